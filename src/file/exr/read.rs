//! Reading EXR files.

use std::path::Path;

use exr::meta::MetaData;
use exr::prelude::{AttributeValue, FlatSamples, ReadChannels, ReadLayers, Text};

use super::{ATTRIBUTE_PREFIX, Channel, Samples, text};
use crate::file::FileError;
use crate::file::imprint::KEY;

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

/// Largest compression ratio: Deflate packs 1032 bytes into one at best, and no other compression of EXR does better.
/// [`FREE_BYTES`] are allowed in addition, for the header.
const MAX_RATIO: u64 = 1032;
const FREE_BYTES: u64 = 1 << 16;

/// Checks the size that the header claims against the length of the file, because the decoder would trust it.
fn check_claims(path: &Path) -> Result<(), FileError> {
    let file_bytes = std::fs::metadata(path).map_err(|error| FileError::read(path, error))?.len();
    let found = MetaData::read_from_file(path, false).map_err(|error| FileError::read(path, error))?;
    let claimed_bytes = found.headers.iter().map(|header| {
        let pixels = (header.layer_size.width() as u64).saturating_mul(header.layer_size.height() as u64);
        pixels.saturating_mul(header.channels.bytes_per_pixel as u64)
    });
    match claimed_bytes.max().unwrap_or(0) > FREE_BYTES + file_bytes.saturating_mul(MAX_RATIO) {
        true => Err(FileError::read(path, format!("its pixels do not fit in {file_bytes} bytes"))),
        false => Ok(()),
    }
}

/// Reads the imprint from the header.
pub(in crate::file) fn imprint(path: &Path) -> Result<Option<String>, FileError> {
    let found = MetaData::read_from_file(path, false).map_err(|error| FileError::read(path, error))?;
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
