//! Detects the height encoding of a colour picture that neither an option nor a sidecar file declares.
//!
//! A picture proves that it holds numbers by carries: where neighbours differ by one in a byte, the next lower byte
//! goes the other way, as only numbers of several bytes have it. That does not show which numbers they are: a code of
//! 24 bits may count decimetres from −10000 m (Mapbox), centimetres (GSI), or anything else (`rio rgbify -b 0`). So an
//! encoding is only guessed if the heights are those of land and no other encoding explains them as well; otherwise the
//! candidates are named, and the caller chooses.
//!
//! Why: `docs/decisions/colours.md`.

use std::path::Path;

use super::picture::Picture;
use super::place::unclear;
use super::sidecar::RasterInfo;
use super::terrain_rgb::ColourEncoding;
use super::{Encoding, SourceError};
use crate::file::message::printable;

/// Heights that the Earth has, sea floor included, in metres.
const EARTH_M: std::ops::RangeInclusive<f32> = -11_100.0..=9_100.0;
/// Smallest share of such heights among the pixels that hold a height.
const EARTH_SHARE: f64 = 0.95;
/// Heights of land in metres, and their smallest share in a guess.
const LAND_M: std::ops::RangeInclusive<f32> = -500.0..=9000.0;
const LAND_SHARE: f64 = 0.99;
/// Test for carries. Where neighbours differ by one in a byte, the next lower byte of heights goes the other way: from
/// 255 to 0, or slightly less where the land is steep. In an ordinary picture both channels change alike, or
/// independently. There must be at least [`CARRIES`] such places, and at a share of [`CARRY_SHARE`] of them the lower
/// byte must go back by more than [`WRAP`] steps.
const CARRIES: u64 = 32;
const CARRY_SHARE: f64 = 0.9;
const WRAP: i32 = 64;
/// Land that is steeper on average than this, read as Mapbox's code, may be gentler land in GSI's, whose steps are a
/// tenth: a slope of 19°.
const STEEP: f64 = 0.35;
/// Land whose lowest height is above this in metres, read as Mapbox's code, may be land from 1050 m on in GSI's.
const HIGH_M: f32 = 500.0;

/// The spacing and the place of pictures, which help to distinguish encodings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PlaceHints {
    /// Distance between samples on the ground in metres.
    pub spacing_m: Option<f64>,
    /// Whether they show Japan.
    pub in_japan: Option<bool>,
}

/// Returns the encoding of colour pictures with its numbers: the given one, or the one that the colours prove.
///
/// # Errors
/// Fails if no encoding is given and the colours prove none, or leave a choice; the message names the option to use.
pub(super) fn packing(
    path: &Path,
    info: &RasterInfo,
    pictures: &[Picture],
    hints: &PlaceHints,
) -> Result<ColourEncoding, SourceError> {
    let [interval_m, base_m] = [info.colour_interval_m(), info.colour_base_m()];
    let of = |encoding| ColourEncoding::new(encoding, interval_m, base_m).with_void(info.sidecar.no_data);
    let has_numbers = interval_m.is_some() || base_m.is_some();
    let found = match info.encoding() {
        Some(encoding) => of(encoding),
        None if has_numbers && proves_terrarium(pictures) => of(Encoding::Terrarium),
        None if interval_m.is_some() && base_m.is_some() => {
            let packing = of(Encoding::Mapbox);
            if !has_carries(&packing, pictures) {
                return Err(no_heights(path, pictures));
            }
            packing
        }
        None => guess(path, pictures, hints, &of)?.with_void(info.sidecar.no_data),
    };
    if found.encoding == Encoding::Terrarium && has_numbers {
        let why = "its encoding is terrarium, which fixes the height scale and offset; leave these options out";
        return Err(unclear(path, why));
    }
    if let Some([low_m, high_m]) = range_m(&found, pictures)
        && (high_m < *LAND_M.start() || low_m > *LAND_M.end())
    {
        tracing::warn!(
            "{}: read as {}, its heights are {low_m:.0} to {high_m:.0} m, which no land has; check --encoding, \
             --height-scale and --height-offset",
            path.display(),
            found.encoding.name()
        );
    }
    Ok(found)
}

/// Returns the encoding that explains the colours as land, if no other does; `of` gives the numbers of an
/// encoding.
fn guess(
    path: &Path,
    pictures: &[Picture],
    hints: &PlaceHints,
    of: &dyn Fn(Encoding) -> ColourEncoding,
) -> Result<ColourEncoding, SourceError> {
    if proves_terrarium(pictures) {
        return Ok(of(Encoding::Terrarium));
    }
    let [mapbox, gsi] = [of(Encoding::Mapbox), of(Encoding::Gsi)];
    let candidates: Vec<&ColourEncoding> = [&mapbox, &gsi].into_iter().filter(|it| has_carries(it, pictures)).collect();
    let on_earth = |packing: &&ColourEncoding| share_within(packing, pictures, &EARTH_M) >= EARTH_SHARE;
    if !candidates.iter().any(on_earth) {
        return Err(no_heights(path, pictures));
    }
    let may_be = |packing: &ColourEncoding| candidates.contains(&packing) && is_land(packing, pictures);
    // Marks are no proof against Mapbox's code, where they may be no-data or a watermark.
    let is_marked = hints.in_japan != Some(false) && has_marks_of_gsi(pictures);
    match [may_be(&mapbox), may_be(&gsi) && is_marked] {
        [false, true] => return Ok(gsi),
        [true, false] if is_no_gsi(&mapbox, pictures, hints) => return Ok(mapbox),
        _ => {}
    }
    let named = [&mapbox, &gsi].into_iter().filter_map(|packing| {
        let [low_m, high_m] = range_m(packing, pictures)?;
        Some(format!("{} ({low_m:.0} to {high_m:.0} m)", packing.encoding.name()))
    });
    Err(SourceError::Encodings { path: path.into(), candidates: named.collect::<Vec<_>>().join(" or ") })
}

fn proves_terrarium(pictures: &[Picture]) -> bool {
    let terrarium = ColourEncoding::new(Encoding::Terrarium, None, None);
    share_within(&terrarium, pictures, &EARTH_M) >= EARTH_SHARE && has_carries(&terrarium, pictures)
}

fn is_land(packing: &ColourEncoding, pictures: &[Picture]) -> bool {
    share_within(packing, pictures, &LAND_M) >= LAND_SHARE
}

/// Returns whether land in Mapbox's code is not likely to be land in GSI's, which would be 1000 m high or more and have
/// a tenth of the slopes: it is not in Japan, reaches down to low land, and is not steep.
fn is_no_gsi(mapbox: &ColourEncoding, pictures: &[Picture], hints: &PlaceHints) -> bool {
    let is_low = range_m(mapbox, pictures).is_some_and(|[low_m, _]| low_m < HIGH_M);
    let slope = hints.spacing_m.map(|spacing_m| mean_step_m(mapbox, pictures) / spacing_m);
    hints.in_japan != Some(true) && is_low && slope.is_some_and(|slope| slope <= STEEP)
}

/// Returns the error of colours that prove nothing; it names the encodings that would give heights on the Earth.
fn no_heights(path: &Path, pictures: &[Picture]) -> SourceError {
    let on_earth = |encoding: &Encoding| {
        let packing = ColourEncoding::new(*encoding, None, None);
        share_within(&packing, pictures, &EARTH_M) >= EARTH_SHARE
    };
    let which: Vec<&str> = Encoding::ALL.iter().filter(|it| on_earth(it)).map(|it| it.name()).collect();
    let which = if which.is_empty() { Encoding::ALL.map(Encoding::name).join(", ") } else { which.join(" or ") };
    let file_name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let why = format!(
        "holds a colour picture, not heights; if it is terrain-RGB, give --encoding {which} (or `encoding` in {}.toml)",
        printable(&file_name, 60)
    );
    SourceError::Unclear { path: path.into(), why }
}

/// Returns the share of heights within a range among all pixels that hold a height; 0 if none does.
fn share_within(packing: &ColourEncoding, pictures: &[Picture], range_m: &std::ops::RangeInclusive<f32>) -> f64 {
    let (mut heights, mut within) = (0u64, 0u64);
    for height_m in pictures.iter().flat_map(|picture| packing.heights_m(picture)).filter(|it| !it.is_nan()) {
        heights += 1;
        within += u64::from(range_m.contains(&height_m));
    }
    if heights == 0 { 0.0 } else { within as f64 / heights as f64 }
}

/// Returns the lowest and the highest height.
fn range_m(packing: &ColourEncoding, pictures: &[Picture]) -> Option<[f32; 2]> {
    let heights_m = pictures.iter().flat_map(|picture| packing.heights_m(picture));
    let range_m = heights_m.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], it| [low.min(it), high.max(it)]);
    (range_m[0] <= range_m[1]).then_some(range_m)
}

/// Returns whether there are pixels that GSI's encoding explains best: (128, 0, 0), or small negative numbers. White is
/// none of them, because it is no-data in many pictures.
fn has_marks_of_gsi(pictures: &[Picture]) -> bool {
    let is_mark = |pixel: &[u8]| match pixel[..3] {
        [255, 255, 255] => false,
        [red, green, blue] => pixel.get(3) != Some(&0) && (red == 255 || [red, green, blue] == [128, 0, 0]),
        _ => false,
    };
    pictures.iter().any(|picture| picture.bytes.chunks_exact(picture.channels.max(3)).any(is_mark))
}

/// Calls `visit` with all pairs of horizontal neighbours that both hold heights.
fn neighbours<'a>(packing: &ColourEncoding, pictures: &'a [Picture], mut visit: impl FnMut(&'a [u8], &'a [u8])) {
    for picture in pictures {
        let channels = picture.channels.max(3);
        for row in picture.bytes.chunks_exact((picture.size[0] as usize * channels).max(1)) {
            for (a, b) in row.chunks_exact(channels).zip(row.chunks_exact(channels).skip(1)) {
                if !packing.height_m(a).is_nan() && !packing.height_m(b).is_nan() {
                    visit(a, b);
                }
            }
        }
    }
}

/// Returns the mean step between neighbours that differ, in metres.
fn mean_step_m(packing: &ColourEncoding, pictures: &[Picture]) -> f64 {
    let (mut sum_m, mut count) = (0.0, 0u64);
    neighbours(packing, pictures, |a, b| {
        let step_m = f64::from((packing.height_m(b) - packing.height_m(a)).abs());
        if step_m > 0.0 {
            sum_m += step_m;
            count += 1;
        }
    });
    sum_m / count.max(1) as f64
}

/// Returns whether bytes carry into the next higher ones from pixel to pixel.
fn has_carries(packing: &ColourEncoding, pictures: &[Picture]) -> bool {
    // The lowest byte of Terrarium may be missing, and the highest of Mapbox seldom changes.
    [[0, 1], [1, 2]].into_iter().any(|[coarse, fine]| {
        let (mut steps, mut wraps) = (0u64, 0u64);
        neighbours(packing, pictures, |a, b| {
            let difference = |channel: usize| i32::from(b[channel]) - i32::from(a[channel]);
            let step = difference(coarse);
            if step.abs() == 1 && (0..coarse).all(|higher| difference(higher) == 0) {
                steps += 1;
                wraps += u64::from(difference(fine) * step < -WRAP);
            }
        });
        steps >= CARRIES && wraps as f64 >= CARRY_SHARE * steps as f64
    })
}
