//! TIFFs written byte by byte: variants that libtiff reads and few programs write.

use std::path::Path;

use crate::dem::Dem;

pub(crate) const STRIPS: [u16; 2] = [273, 279];
pub(crate) const TILES: [u16; 2] = [324, 325];

/// The value of a tag.
#[derive(Clone)]
pub(crate) enum Value {
    Short(Vec<u16>),
    Long(Vec<u32>),
    Ascii(String),
}

/// One image of a TIFF file. The defaults are one band of signed 16-bit samples in one uncompressed strip.
#[derive(Clone)]
pub(crate) struct Picture {
    pub size: [u32; 2],
    /// All tags apart from the size and the offsets and lengths of blocks; a later tag replaces an earlier one.
    pub tags: Vec<(u16, Value)>,
    /// The tags of the offsets and lengths of blocks.
    pub places: [u16; 2],
    pub blocks: Vec<Vec<u8>>,
}

impl Picture {
    pub(crate) fn of_i16(dem: &Dem) -> Self {
        let blocks = vec![bytes(&dem.heights)];
        let size = [dem.width as u32, dem.height as u32];
        Self { size, tags: samples(16, 2), places: STRIPS, blocks }.with(278, short(dem.height as u16))
    }

    pub(crate) fn with(mut self, tag: u16, value: Value) -> Self {
        self.tags.retain(|it| it.0 != tag);
        self.tags.push((tag, value));
        self
    }
}

pub(crate) fn short(value: u16) -> Value {
    Value::Short(vec![value])
}

/// Returns the tags for bits per sample and sample format: 1 unsigned, 2 signed, 3 floating-point.
pub(crate) fn samples(bits: u16, format: u16) -> Vec<(u16, Value)> {
    [(258, bits), (259, 1), (262, 1), (277, 1), (339, format)].into_iter().map(|(tag, it)| (tag, short(it))).collect()
}

pub(crate) fn bytes(samples: &[i16]) -> Vec<u8> {
    samples.iter().flat_map(|it| it.to_le_bytes()).collect()
}

pub(crate) fn write(path: &Path, pictures: &[Picture]) {
    std::fs::write(path, file(pictures)).unwrap();
}

fn file(pictures: &[Picture]) -> Vec<u8> {
    let mut file = b"II*\0\0\0\0\0".to_vec();
    let mut next = 4;
    for picture in pictures {
        let mut place = |bytes: &[u8]| {
            file.resize(file.len().next_multiple_of(2), 0);
            file.extend(bytes);
            (file.len() - bytes.len()) as u32
        };
        let offsets: Vec<u32> = picture.blocks.iter().map(|block| place(block)).collect();
        let counts = picture.blocks.iter().map(|block| block.len() as u32).collect();
        let mut tags = picture.tags.clone();
        tags.extend([(256, Value::Long(vec![picture.size[0]])), (257, Value::Long(vec![picture.size[1]]))]);
        tags.extend([(picture.places[0], Value::Long(offsets)), (picture.places[1], Value::Long(counts))]);
        tags.sort_by_key(|tag| tag.0);
        let mut directory = (tags.len() as u16).to_le_bytes().to_vec();
        for (tag, value) in &tags {
            let (kind, count, mut bytes): (u16, usize, Vec<u8>) = match value {
                Value::Short(values) => (3, values.len(), values.iter().flat_map(|it| it.to_le_bytes()).collect()),
                Value::Long(values) => (4, values.len(), values.iter().flat_map(|it| it.to_le_bytes()).collect()),
                Value::Ascii(text) => (2, text.len() + 1, format!("{text}\0").into_bytes()),
            };
            if bytes.len() > 4 {
                bytes = place(&bytes).to_le_bytes().to_vec();
            }
            bytes.resize(4, 0);
            directory.extend(tag.to_le_bytes());
            directory.extend(kind.to_le_bytes());
            directory.extend((count as u32).to_le_bytes());
            directory.extend(bytes);
        }
        directory.extend([0; 4]);
        let at = place(&directory);
        file[next..next + 4].copy_from_slice(&at.to_le_bytes());
        next = file.len() - 4;
    }
    file
}

/// Returns a zlib stream of one stored block.
pub(crate) fn deflate(bytes: &[u8]) -> Vec<u8> {
    let length = bytes.len() as u16;
    let (a, b) = bytes.iter().fold((1u32, 0u32), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    let head = [0x78, 1, 1];
    [&head[..], &length.to_le_bytes(), &(!length).to_le_bytes(), bytes, &(b << 16 | a).to_be_bytes()].concat()
}

/// Returns LZW data with a clear code before codes grow beyond nine bits.
pub(crate) fn lzw(bytes: &[u8]) -> Vec<u8> {
    const CLEAR: u16 = 256;
    const END: u16 = 257;
    let mut codes = Vec::new();
    for run in bytes.chunks(200) {
        codes.push(CLEAR);
        codes.extend(run.iter().map(|&byte| u16::from(byte)));
    }
    codes.push(END);
    let bits: Vec<u8> = codes.iter().flat_map(|code| (0..9).rev().map(move |bit| (code >> bit & 1) as u8)).collect();
    bits.chunks(8).map(|bits| bits.iter().enumerate().fold(0, |byte, (at, bit)| byte | bit << (7 - at))).collect()
}

/// Returns PackBits data of literal runs.
pub(crate) fn pack_bits(bytes: &[u8]) -> Vec<u8> {
    bytes.chunks(128).flat_map(|run| std::iter::once(run.len() as u8 - 1).chain(run.iter().copied())).collect()
}

/// Returns a Zstandard frame with one raw block (RFC 8878).
pub(crate) fn zstd(bytes: &[u8]) -> Vec<u8> {
    let block = (bytes.len() as u32) << 3 | 1;
    let size = (bytes.len() as u16 - 256).to_le_bytes();
    [&[0x28, 0xb5, 0x2f, 0xfd, 0x60], &size[..], &block.to_le_bytes()[..3], bytes].concat()
}
