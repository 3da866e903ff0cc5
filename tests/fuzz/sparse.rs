//! A sparse GeoTIFF, written byte by byte: tiles of 512 × 512 floats, of which the file stores only two.

use std::io::Write;
use std::path::Path;

const TILE: u32 = 512;

/// Returns the height in metres of a sample of a stored tile.
fn height_m(column: u32, row: u32) -> f32 {
    (row + 2 * column) as f32
}

/// Returns the numbers of the stored tiles, in row order.
fn stored(tiles: u32) -> [u32; 2] {
    [0, tiles / 2]
}

/// Returns the lowest and highest height, and the number of no-data samples.
pub(crate) fn expected(side: u32) -> ([f32; 2], u64) {
    ([0.0, height_m(TILE - 1, TILE - 1)], u64::from(side).pow(2) - 2 * u64::from(TILE).pow(2))
}

/// Writes a square of `side` samples; `side` must be a multiple of the tile size.
pub(crate) fn write(path: &Path, side: u32) {
    assert_eq!(side % TILE, 0);
    let tiles = (side / TILE).pow(2);
    let samples: Vec<u8> =
        (0..TILE * TILE).flat_map(|index| height_m(index % TILE, index / TILE).to_le_bytes()).collect();
    let mut stored_bytes = zlib(&samples);
    let (short, long, double, ascii) = (3_u16, 4_u16, 12_u16, 2_u16);
    let numbers = |numbers: &[f64]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let number = |number: u32| number.to_le_bytes().to_vec();
    let header = |offsets: Vec<u8>, counts: Vec<u8>| {
        let tags = [
            (256_u16, long, 1, number(side)),
            (257, long, 1, number(side)),
            (258, short, 1, number(32)),
            (259, short, 1, number(8)),
            (262, short, 1, number(1)),
            (277, short, 1, number(1)),
            (322, long, 1, number(TILE)),
            (323, long, 1, number(TILE)),
            (324, long, tiles, offsets),
            (325, long, tiles, counts),
            (339, short, 1, number(3)),
            (33_550, double, 3, numbers(&[1.0, 1.0, 0.0])),
            (33_922, double, 6, numbers(&[0.0, 0.0, 0.0, 5.0e5, 5.0e6, 0.0])),
            (42_113, ascii, 6, b"-9999\0".to_vec()),
        ];
        let mut bytes = b"II*\0\x08\0\0\0".to_vec();
        bytes.extend((tags.len() as u16).to_le_bytes());
        let mut beyond = Vec::new();
        let first_beyond = bytes.len() + 12 * tags.len() + 4;
        for (tag, kind, count, value) in tags {
            bytes.extend(tag.to_le_bytes());
            bytes.extend(kind.to_le_bytes());
            bytes.extend(count.to_le_bytes());
            if value.len() <= 4 {
                bytes.extend(value);
            } else {
                bytes.extend(((first_beyond + beyond.len()) as u32).to_le_bytes());
                beyond.extend(value);
            }
        }
        bytes.extend([0; 4]);
        bytes.extend(beyond);
        bytes
    };
    let table = |value: u32| {
        let values = (0..tiles).map(|tile| if stored(tiles).contains(&tile) { value } else { 0 });
        values.flat_map(u32::to_le_bytes).collect::<Vec<u8>>()
    };
    // The length of the tables does not depend on their content; both tiles have the same bytes.
    let end = header(table(0), table(0)).len() as u32;
    let mut bytes = header(table(end), table(stored_bytes.len() as u32));
    bytes.append(&mut stored_bytes);
    std::fs::File::create(path).unwrap().write_all(&bytes).unwrap();
}

/// Returns a zlib stream without compression.
fn zlib(bytes: &[u8]) -> Vec<u8> {
    // Stored blocks: two bytes of header, blocks of at most 65535 bytes, and an Adler-32 checksum.
    let mut stream = vec![0x78, 0x01];
    let mut blocks = bytes.chunks(0xffff).peekable();
    while let Some(block) = blocks.next() {
        stream.push(u8::from(blocks.peek().is_none()));
        stream.extend((block.len() as u16).to_le_bytes());
        stream.extend((!(block.len() as u16)).to_le_bytes());
        stream.extend(block);
    }
    let (a, b) = bytes.iter().fold((1_u32, 0_u32), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    stream.extend(((b << 16) | a).to_be_bytes());
    stream
}
