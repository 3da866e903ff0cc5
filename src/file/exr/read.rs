//! Reading EXR files.

use std::io::{BufReader, Read};
use std::path::Path;

use exr::meta::MetaData;
use exr::prelude::{AttributeValue, FlatSamples, ReadChannels, ReadLayers, Text};

use super::{ATTRIBUTE_PREFIX, Channel, Samples, text};
use crate::file::FileError;
use crate::file::imprint::KEY;
use crate::file::input::{most_deflated_bytes, open_regular};

/// An EXR that [`read_exr`] has read.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The channels in the file's order, which is by name.
    pub channels: Vec<Channel>,
    /// Hachure's own attributes, sorted by name, without their prefix.
    pub attributes: Vec<(String, String)>,
}

impl ExrPicture {
    /// Returns the samples of a channel of 32-bit floats.
    pub fn f32(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|channel| channel.name == name).and_then(|channel| match &channel.samples {
            Samples::F32(samples) => Some(samples.as_slice()),
            Samples::U32(_) => None,
        })
    }

    /// Returns the samples of a channel of 32-bit unsigned integers.
    pub fn u32(&self, name: &str) -> Option<&[u32]> {
        self.channels.iter().find(|channel| channel.name == name).and_then(|channel| match &channel.samples {
            Samples::U32(samples) => Some(samples.as_slice()),
            Samples::F32(_) => None,
        })
    }
}

/// Largest header: an imprint has at most 4 MiB.
const MAX_HEADER_BYTES: u64 = 8 << 20;

/// Reads the header. An attribute may claim any length, so that the header ends after [`MAX_HEADER_BYTES`].
fn meta_data(path: &Path) -> Result<MetaData, FileError> {
    let file = open_regular(path).map_err(|error| FileError::read(path, error))?;
    let is_cut = file.metadata().is_ok_and(|found| found.len() > MAX_HEADER_BYTES);
    let header = BufReader::new(file.take(MAX_HEADER_BYTES));
    MetaData::read_from_buffered(header, false).map_err(|error| match is_cut {
        true => FileError::read(path, "its header is damaged, or longer than 8 MiB"),
        false => FileError::read(path, error),
    })
}

/// Checks the size that the header claims against the length of the file, because the decoder would trust it.
fn check_claims(path: &Path) -> Result<(), FileError> {
    let file_bytes = std::fs::metadata(path).map_err(|error| FileError::read(path, error))?.len();
    let found = meta_data(path)?;
    let claimed_bytes = found.headers.iter().map(|header| {
        let pixels = (header.layer_size.width() as u64).saturating_mul(header.layer_size.height() as u64);
        pixels.saturating_mul(header.channels.bytes_per_pixel as u64)
    });
    // No other compression of EXR packs more than DEFLATE.
    match claimed_bytes.max().unwrap_or(0) > most_deflated_bytes(file_bytes) {
        true => Err(FileError::read(path, format!("its pixels do not fit in {file_bytes} bytes"))),
        false => Ok(()),
    }
}

/// Reads the imprint from the header.
pub(in crate::file) fn imprint(path: &Path) -> Result<Option<String>, FileError> {
    let found = meta_data(path)?;
    let own = found.headers.first().map(|header| &header.own_attributes);
    Ok(own.and_then(|own| own.other.get(&text(KEY))).and_then(|value| match value {
        AttributeValue::Text(value) => Some(utf8(value)),
        _ => None,
    }))
}

/// Reads the names of the channels of all parts from the header.
///
/// # Errors
/// Fails if the file cannot be read or is no EXR.
pub(crate) fn channel_names(path: &Path) -> Result<Vec<String>, FileError> {
    let found = MetaData::read_from_file(path, false).map_err(|error| FileError::read(path, error))?;
    Ok(found.headers.iter().flat_map(|header| &header.channels.list).map(|channel| utf8(&channel.name)).collect())
}

/// Returns UTF-8 bytes as a string; see [`text`].
fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// Reads the whole first part of an EXR that is not deep; 16-bit floats become 32-bit ones.
///
/// # Errors
/// Fails if the file cannot be opened, is not such an EXR, or has a header that claims more pixels than the file can
/// hold.
pub fn read_exr(path: &Path) -> Result<ExrPicture, FileError> {
    check_claims(path)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|error| FileError::read(path, error))?;
    let layer = image.layer_data;
    let channels = layer.channel_data.list.into_iter().map(|channel| Channel {
        name: utf8(&channel.name),
        samples: match channel.sample_data {
            FlatSamples::F16(samples) => Samples::F32(samples.into_iter().map(|sample| sample.to_f32()).collect()),
            FlatSamples::F32(samples) => Samples::F32(samples),
            FlatSamples::U32(samples) => Samples::U32(samples),
        },
    });
    let own = layer.attributes.other.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(value) => Some((utf8(name).strip_prefix(ATTRIBUTE_PREFIX)?.to_owned(), utf8(value))),
        _ => None,
    });
    let mut attributes: Vec<_> = own.collect();
    attributes.sort();
    // The format stores sizes as signed 32-bit numbers.
    let (width, height) = (layer.size.width() as u32, layer.size.height() as u32);
    Ok(ExrPicture { width, height, channels: channels.collect(), attributes })
}
