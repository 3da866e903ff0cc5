//! OpenEXR pictures of heights, as terrain generators write them: one channel of numbers, or three equal ones. The
//! height of a unit, the sample spacing and the position come from a sidecar file, from other sidecar files, or from options.

use std::path::Path;

use super::SourceError;
use super::memory::{self, MemoryReader};
use super::place::{self, inconsistent};
use super::samples::{SampleType, Tally, WarnOnce};
use super::sidecar::RasterInfo;
use super::values::Holds;
use crate::file::exr::{Channel, ExrPicture, Samples, read_exr};

/// Names of channels that hold heights.
const NAMES: [&str; 4] = ["height", "elevation", "heightmap", "displacement"];
/// Names of channels that hold heights in a file without colours; with colours, `Z` is the distance from the camera
/// and `Y` the luminance.
const NAMES_WITHOUT_COLOURS: [&str; 2] = ["z", "y"];
/// Names of channels of colours.
const COLOURS: [&str; 5] = ["r", "g", "b", "ry", "by"];

/// Reads a picture into memory, as heights in metres.
///
/// # Errors
/// Fails if the picture is damaged or too large, or holds colours; and if its place is unclear.
pub(super) fn open(path: &Path, info: &RasterInfo) -> Result<MemoryReader, SourceError> {
    let picture = read_exr(path).map_err(|error| {
        let text = error.to_string();
        let name = format!("{}: ", path.display());
        inconsistent(path, text.strip_prefix(&name).unwrap_or(&text))
    })?;
    let size = [picture.width, picture.height];
    place::check_size(path, size)?;
    memory::check_count(path, size)?;
    let refused = |what| SourceError::NotHeights { path: path.into(), what, holds: Holds::Heights };
    if !picture.attributes.is_empty() {
        return Err(refused("a picture that hachure drew"));
    }
    let channel = heights(&picture).ok_or_else(|| refused("a picture in colours"))?;
    let meaning = info.meaning(path, SampleType::F32);
    let mut tally = Tally::default();
    let mut heights_m = memory::room(path, size, u64::from(size[0]) * u64::from(size[1]))?;
    match &channel.samples {
        Samples::F32(samples) => {
            heights_m.extend(samples.iter().map(|it| meaning.height_m(f64::from(*it), &mut tally)));
        }
        Samples::U32(samples) => {
            heights_m.extend(samples.iter().map(|it| meaning.height_m(f64::from(*it), &mut tally)));
        }
    }
    WarnOnce::default().warn(path, &tally);
    let georeference = info.georeference(path, size)?;
    Ok(MemoryReader { path: path.into(), size, heights_m, unit_m: 1.0, georeference, identity: info.identity(path) })
}

/// Returns the channel of heights: one with a usual name, the only one, or the first of three equal ones.
fn heights(picture: &ExrPicture) -> Option<&Channel> {
    let of = |name: &str| picture.channels.iter().find(|channel| channel.name.eq_ignore_ascii_case(name));
    let has_colours = COLOURS.iter().any(|name| of(name).is_some());
    let without_colours = NAMES_WITHOUT_COLOURS.iter().filter(|_| !has_colours);
    if let Some(named) = NAMES.iter().chain(without_colours).find_map(|name| of(name)) {
        return Some(named);
    }
    let colours: Vec<&Channel> =
        picture.channels.iter().filter(|channel| !channel.name.eq_ignore_ascii_case("a")).collect();
    let first = colours.first()?;
    colours.iter().all(|channel| channel.samples == first.samples).then_some(*first)
}
