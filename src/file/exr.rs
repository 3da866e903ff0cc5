//! OpenEXR: named channels of 32-bit floats and unsigned integers, one part, lossless ZIP.
//!
//! [`ExrWriter`] takes bands of rows from top to bottom and compresses them on all cores while the caller produces the
//! next band, so that a picture of any size needs the memory of a few bands. [`write_exr`] writes a picture that is
//! already complete.

mod order;
mod read;

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use exr::block::writer::{ChunksWriter, write_chunks_with};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{AttributeValue, ChannelDescription, Compression, LineOrder, SampleType, SmallVec, Text, Vec2};
use order::sort_attributes;
pub(crate) use read::channel_names;
pub(super) use read::imprint;
pub use read::{ExrPicture, read_exr};

use super::atomic::AtomicFile;
use super::imprint::{KEY, Notes};
use super::{FileError, sample_count};

/// Number of rows that ZIP compresses together; the format prescribes it.
const BLOCK_ROWS: usize = 16;

/// Number of blocks that may wait for a core. The compressor holds a few more.
const WAITING_BLOCKS: usize = 4;

/// Prefix of the names of hachure's own attributes, so that they never collide with standard ones.
const ATTRIBUTE_PREFIX: &str = "hachure.";

/// Names of the views of a stereo pair, the default view first.
pub(crate) const VIEWS: [&str; 2] = ["left", "right"];

/// Returns the name of a channel in a view of [`VIEWS`], as OpenEXR's `insertViewName` forms it: channels without a
/// layer keep their name in the default view, and otherwise the view comes before the last part of the name:
/// `right.R`, `depth.left.V`.
pub(crate) fn channel_of_view(name: &str, view: usize) -> String {
    match name.rsplit_once('.') {
        Some((layer, channel)) => format!("{layer}.{}.{channel}", VIEWS[view]),
        None if view == 0 => name.to_owned(),
        None => format!("{}.{name}", VIEWS[view]),
    }
}

/// A named channel of a complete picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name of the channel, written verbatim: `R`, `depth.V`, `surface.id`.
    pub name: String,
    /// Width × height samples, row by row from the top.
    pub samples: Samples,
}

/// The samples of a channel. Every bit pattern is preserved, including +inf and NaN.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 32-bit floats.
    F32(Vec<f32>),
    /// 32-bit unsigned integers.
    U32(Vec<u32>),
}

/// Borrowed samples: a band of a channel.
#[derive(Clone, Copy, Debug)]
pub enum SamplesRef<'a> {
    /// 32-bit floats.
    F32(&'a [f32]),
    /// 32-bit unsigned integers.
    U32(&'a [u32]),
}

/// The type of a channel's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleKind {
    /// 32-bit floats.
    F32,
    /// 32-bit unsigned integers.
    U32,
}

impl Samples {
    /// Borrows the samples.
    pub fn as_ref(&self) -> SamplesRef<'_> {
        match self {
            Self::F32(samples) => SamplesRef::F32(samples),
            Self::U32(samples) => SamplesRef::U32(samples),
        }
    }
}

impl<'a> SamplesRef<'a> {
    /// Returns the type of the samples.
    pub(crate) fn kind(self) -> SampleKind {
        match self {
            Self::F32(_) => SampleKind::F32,
            Self::U32(_) => SampleKind::U32,
        }
    }

    /// Returns the number of samples.
    pub(crate) fn len(self) -> usize {
        self.bytes().len() / 4
    }

    fn bytes(self) -> &'a [u8] {
        match self {
            Self::F32(samples) => bytemuck::cast_slice(samples),
            Self::U32(samples) => bytemuck::cast_slice(samples),
        }
    }
}

/// An EXR that is being written. Without [`ExrWriter::finish`] no file appears under its name.
pub struct ExrWriter {
    path: PathBuf,
    width: usize,
    rows_left: usize,
    kinds: Vec<SampleKind>,
    /// For each position in the file's order of channels, the index of that channel in the caller's order.
    file_order: Vec<usize>,
    block: Vec<u8>,
    blocks: Option<SyncSender<Vec<u8>>>,
    encoder: Option<JoinHandle<Result<AtomicFile, String>>>,
}

impl ExrWriter {
    /// Starts a picture of `width` × `height` pixels with these channels, in any order. The attributes are text; they
    /// are stored as `hachure.NAME`, in addition to the standard attribute `software`.
    ///
    /// # Errors
    /// Fails if the picture is empty, if there is no channel, if a channel has no name, if two have the same name, or
    /// if the folder does not exist or is not writable.
    pub fn create(
        path: &Path,
        width: u32,
        height: u32,
        channels: &[(&str, SampleKind)],
        attributes: &[(String, String)],
    ) -> Result<Self, FileError> {
        Self::create_noted(path, width, height, channels, attributes, &Notes::default())
    }

    /// Does the same as [`ExrWriter::create`], and also writes `notes` into the header.
    ///
    /// # Errors
    /// The same as [`ExrWriter::create`].
    pub fn create_noted(
        path: &Path,
        width: u32,
        height: u32,
        channels: &[(&str, SampleKind)],
        attributes: &[(String, String)],
        notes: &Notes<'_>,
    ) -> Result<Self, FileError> {
        sample_count(path, width, height)?;
        // The format requires channels sorted by the bytes of their names.
        let mut file_order: Vec<usize> = (0..channels.len()).collect();
        file_order.sort_by_key(|&channel| channels[channel].0.as_bytes());
        let mut header = header(path, width, height, file_order.iter().map(|&channel| channels[channel]), attributes)?;
        let own = &mut header.own_attributes;
        own.horizontal_density = notes.dpi.map(|dpi| dpi as f32);
        own.world_to_camera = notes.matrices.map(|matrices| matrices.camera_from_world);
        own.world_to_normalized_device = notes.matrices.map(|matrices| matrices.ndc_from_world);
        if let Some(second) = notes.second_view {
            own.multi_view_names = Some(VIEWS.map(text).to_vec());
            // OpenEXR defines these names only once for a part.
            let matrices = [("worldToCamera", second.camera_from_world), ("worldToNDC", second.ndc_from_world)];
            let named = |(name, matrix)| (text(&format!("{}.{name}", VIEWS[1])), AttributeValue::Matrix4x4(matrix));
            own.other.extend(matrices.map(named));
        }
        own.other.extend(notes.imprint.map(|imprint| (text(KEY), AttributeValue::Text(text(imprint)))));
        let file = AtomicFile::create(path).map_err(|error| FileError::write(path, error))?;
        let (sender, receiver) = sync_channel(WAITING_BLOCKS);
        let encoder = std::thread::Builder::new()
            .name("exr".to_owned())
            .spawn(move || encode(file, header, &receiver))
            .map_err(|error| FileError::write(path, error))?;
        Ok(Self {
            path: path.to_owned(),
            width: width as usize,
            rows_left: height as usize,
            kinds: channels.iter().map(|&(_, kind)| kind).collect(),
            file_order,
            block: Vec::new(),
            blocks: Some(sender),
            encoder: Some(encoder),
        })
    }

    /// Appends complete rows of all channels below those already written. For each channel, in the order given to
    /// [`ExrWriter::create`], the band holds rows × width samples.
    ///
    /// # Errors
    /// Fails if the channels have another number, type or length, if there are more rows than the picture has, or if
    /// the disk is full.
    pub fn write_rows(&mut self, band: &[SamplesRef<'_>]) -> Result<(), FileError> {
        let rows = band.first().map_or(0, |samples| samples.len() / self.width);
        let fits = |(samples, kind): (&SamplesRef<'_>, &SampleKind)| {
            samples.kind() == *kind && samples.len() == rows * self.width
        };
        if band.len() != self.kinds.len() || !band.iter().zip(&self.kinds).all(fits) || rows > self.rows_left {
            let cause = "a band of rows does not match the picture's channels, width or height";
            return Err(FileError::write(&self.path, cause));
        }
        let row_bytes = self.width * 4;
        for row in 0..rows {
            for &channel in &self.file_order {
                self.block.extend_from_slice(&band[channel].bytes()[row * row_bytes..][..row_bytes]);
            }
            self.rows_left -= 1;
            if self.block.len() == BLOCK_ROWS * row_bytes * self.kinds.len() || self.rows_left == 0 {
                let next = Vec::with_capacity(self.block.len());
                let block = std::mem::replace(&mut self.block, next);
                if self.blocks.as_ref().is_none_or(|blocks| blocks.send(block).is_err()) {
                    // The encoder has stopped early and returns the cause.
                    return Err(self.stop().err().unwrap_or_else(|| FileError::write(&self.path, "already stopped")));
                }
            }
        }
        Ok(())
    }

    /// Finishes the picture and gives it its final name.
    ///
    /// # Errors
    /// Fails if rows are missing or the disk is full.
    pub fn finish(mut self) -> Result<(), FileError> {
        if self.rows_left > 0 {
            return Err(FileError::write(&self.path, format!("{} rows are missing", self.rows_left)));
        }
        let mut file = self.stop()?;
        sort_attributes(file.writer()).map_err(|error| FileError::write(&self.path, error))?;
        file.commit().map_err(|error| FileError::write(&self.path, error))
    }

    /// Stops the encoder and waits for its result.
    fn stop(&mut self) -> Result<AtomicFile, FileError> {
        self.blocks = None;
        let result = match self.encoder.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err("the encoder panicked".to_owned()),
            None => Err("the encoder has stopped".to_owned()),
        };
        result.map_err(|cause| FileError::write(&self.path, cause))
    }
}

impl Drop for ExrWriter {
    /// Waits until the temporary file is removed.
    fn drop(&mut self) {
        let _ = self.stop();
    }
}

/// Compresses and writes blocks as they arrive, until all are written.
fn encode(mut file: AtomicFile, header: Header, blocks: &Receiver<Vec<u8>>) -> Result<AtomicFile, String> {
    let (size, headers) = (header.layer_size, SmallVec::from_iter([header]));
    let write = |meta: MetaData, chunks: &mut exr::block::writer::ChunkWriter<_>| {
        let block_at = |index: usize| -> exr::error::Result<UncompressedBlock> {
            let data = blocks.recv().map_err(|_| exr::error::Error::Aborted)?;
            let y = index * BLOCK_ROWS;
            let rows = BLOCK_ROWS.min(size.height() - y);
            let pixel_position = Vec2(0, y);
            let pixel_size = Vec2(size.width(), rows);
            let index = BlockIndex { layer: 0, pixel_position, pixel_size, level: Vec2(0, 0) };
            Ok(UncompressedBlock { index, data })
        };
        let count = chunks.total_chunks_count();
        // `None` means that threads bring no gain or cannot be started.
        if let Some(mut compressor) = chunks.parallel_blocks_compressor(&meta) {
            for index in 0..count {
                compressor.add_block_to_compression_queue(index, block_at(index)?)?;
            }
            return Ok(());
        }
        let mut compressor = chunks.sequential_blocks_compressor(&meta);
        (0..count).try_for_each(|index| compressor.compress_block(index, block_at(index)?))
    };
    write_chunks_with(file.writer(), headers, true, write).map_err(|error| error.to_string())?;
    Ok(file)
}

fn header<'a>(
    path: &Path,
    width: u32,
    height: u32,
    sorted_channels: impl Iterator<Item = (&'a str, SampleKind)>,
    attributes: &[(String, String)],
) -> Result<Header, FileError> {
    let mut list: SmallVec<[ChannelDescription; 5]> = SmallVec::new();
    for (name, kind) in sorted_channels {
        let sample_type = match kind {
            SampleKind::F32 => SampleType::F32,
            SampleKind::U32 => SampleType::U32,
        };
        let channel = ChannelDescription::named(text(name), sample_type);
        if name.is_empty() || list.last().is_some_and(|last| last.name == channel.name) {
            return Err(FileError::write(path, format!("the channel name `{name}` is empty or used twice")));
        }
        list.push(channel);
    }
    if list.is_empty() {
        return Err(FileError::write(path, "a picture without channels"));
    }
    let size = Vec2(width as usize, height as usize);
    let mut header = Header::new(text("hachure"), size, list).with_encoding(
        Compression::ZIP16,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    // Some readers take a file whose only part has a name for a multi-part file.
    header.own_attributes.layer_name = None;
    header.own_attributes.software_name = Some(text(concat!("hachure ", env!("CARGO_PKG_VERSION"))));
    for (name, value) in attributes {
        let name = text(&format!("{ATTRIBUTE_PREFIX}{name}"));
        header.own_attributes.other.insert(name, AttributeValue::Text(text(value)));
    }
    Ok(header)
}

/// Returns a text as UTF-8 bytes, which OpenEXR requires; the crate's own conversion only supports Latin-1 and may
/// panic.
fn text(text: &str) -> Text {
    let bytes_as_chars: String = text.bytes().map(char::from).collect();
    // Every char is a byte here, so that this is never `None`; an empty text is a harmless fallback.
    Text::new_or_none(bytes_as_chars).unwrap_or_default()
}

/// Writes a complete picture: each channel holds width × height samples. See [`ExrWriter::create`].
///
/// # Errors
/// The same as the methods of [`ExrWriter`].
pub fn write_exr(
    path: &Path,
    width: u32,
    height: u32,
    channels: &[Channel],
    attributes: &[(String, String)],
) -> Result<(), FileError> {
    write_exr_noted(path, width, height, channels, attributes, &Notes::default())
}

/// Does the same as [`write_exr`], and also writes `notes` into the header.
///
/// # Errors
/// The same as the methods of [`ExrWriter`].
pub(crate) fn write_exr_noted(
    path: &Path,
    width: u32,
    height: u32,
    channels: &[Channel],
    attributes: &[(String, String)],
    notes: &Notes<'_>,
) -> Result<(), FileError> {
    let kinds: Vec<(&str, SampleKind)> =
        channels.iter().map(|channel| (channel.name.as_str(), channel.samples.as_ref().kind())).collect();
    let mut writer = ExrWriter::create_noted(path, width, height, &kinds, attributes, notes)?;
    let samples: Vec<SamplesRef<'_>> = channels.iter().map(|channel| channel.samples.as_ref()).collect();
    writer.write_rows(&samples)?;
    writer.finish()
}
