//! Terrain-RGB: heights that are encoded in the colours of a picture.
//!
//! - Terrarium (Mapzen, "Terrain tile formats"): red × 256 + green + blue / 256 − 32768 metres.
//! - Mapbox ("Mapbox Terrain-RGB v1"): −10000 + (red × 65536 + green × 256 + blue) × 0.1 metres.
//!
//! The encoding, and whether a picture contains heights at all, is not in the file; a sidecar file or an option must
//! give it. Otherwise the colours must prove it ([`Packing::of`]): plausible heights in one encoding, and carries as
//! only numbers of several bytes have them.

use std::path::{Path, PathBuf};

use super::SourceError;
use super::georeference::Georeference;
use super::memory;
use super::picture::{self, Picture};
use super::place::{check_window, unclear};
use super::reader::{HeightReader, Window};
use super::samples::MAX_HEIGHT_M;
use super::sidecar::{Encoding, RasterInfo};

/// Plausible heights in metres: from below the deepest trench to above the highest mountain.
const PLAUSIBLE_M: std::ops::RangeInclusive<f32> = -11_100.0..=9_100.0;
/// Smallest share of plausible heights among the pixels that hold a height.
const PLAUSIBLE_SHARE: f64 = 0.95;
/// Test for carries. Where neighbours differ by one in a byte, the next lower byte of heights goes the other way: from
/// 255 to 0, or slightly less where the land is steep. In an ordinary picture both channels change alike, or
/// independently. There must be at least [`CARRIES`] such places, and at a share of [`CARRY_SHARE`] of them the lower
/// byte must go back by more than [`WRAP`] steps.
const CARRIES: u64 = 32;
const CARRY_SHARE: f64 = 0.9;
const WRAP: i32 = 64;

/// Default of metres per step of Mapbox's encoding.
pub(super) const MAPBOX_INTERVAL_M: f64 = 0.1;

/// The encoding of heights, with its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Packing {
    pub encoding: Encoding,
    pub interval_m: f64,
}

impl Packing {
    /// Returns a height in metres; NaN for a black or transparent pixel, which never is a height.
    fn height_m(self, pixel: &[u8]) -> f32 {
        let [red, green, blue] = [pixel[0], pixel[1], pixel[2]].map(f64::from);
        let is_void = pixel[..3] == [0, 0, 0] || pixel.get(3) == Some(&0);
        match self.encoding {
            _ if is_void => f32::NAN,
            Encoding::Terrarium => (red * 256.0 + green + blue / 256.0 - 32_768.0) as f32,
            Encoding::Mapbox => {
                let height_m = (red * 65_536.0 + green * 256.0 + blue) * self.interval_m - 10_000.0;
                // Whatever the interval, the range of valid heights is the same as for other formats.
                if height_m.abs() <= MAX_HEIGHT_M { height_m as f32 } else { f32::NAN }
            }
        }
    }

    /// Returns the heights of a colour picture in metres, row by row.
    pub(super) fn heights_m(self, picture: &Picture) -> impl Iterator<Item = f32> + '_ {
        picture.bytes.chunks_exact(picture.channels.max(3)).map(move |pixel| self.height_m(pixel))
    }

    /// Returns the given encoding, or the one that the colours of the pictures prove.
    ///
    /// # Errors
    /// Fails if no encoding is given and the colours prove nothing; the message names the option to use.
    pub(super) fn of(path: &Path, info: &RasterInfo, pictures: &[Picture]) -> Result<Self, SourceError> {
        let interval_m = info.sidecar.interval_m.unwrap_or(MAPBOX_INTERVAL_M);
        if let Some(encoding) = info.encoding() {
            return Ok(Self { encoding, interval_m });
        }
        let both = Encoding::ALL.map(|encoding| Self { encoding, interval_m });
        let plausible: Vec<Self> = both.into_iter().filter(|packing| packing.is_plausible(pictures)).collect();
        if let Some(proved) = plausible.iter().find(|packing| packing.has_carries(pictures)) {
            return Ok(*proved);
        }
        let which = match &*plausible {
            [one] => one.encoding.name(),
            _ => "mapbox or terrarium",
        };
        let file_name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        Err(unclear(
            path,
            format!(
                "holds a colour picture, not heights; if it is terrain-RGB, give --encoding {which} (or `encoding` in \
                 {file_name}.toml)"
            ),
        ))
    }

    /// Returns whether nearly all pixels would be heights on the Earth.
    fn is_plausible(self, pictures: &[Picture]) -> bool {
        let (mut heights, mut plausible) = (0u64, 0u64);
        for height_m in pictures.iter().flat_map(|picture| self.heights_m(picture)).filter(|it| !it.is_nan()) {
            heights += 1;
            plausible += u64::from(PLAUSIBLE_M.contains(&height_m));
        }
        heights > 0 && plausible as f64 >= PLAUSIBLE_SHARE * heights as f64
    }

    /// Returns whether bytes carry into the next higher ones from pixel to pixel.
    fn has_carries(self, pictures: &[Picture]) -> bool {
        // The lowest byte of Terrarium may be missing, and the highest of Mapbox seldom changes.
        [[0, 1], [1, 2]].into_iter().any(|[coarse, fine]| {
            let (mut steps, mut wraps) = (0u64, 0u64);
            for picture in pictures {
                let channels = picture.channels.max(3);
                for row in picture.bytes.chunks_exact((picture.size[0] as usize * channels).max(1)) {
                    let next = row.chunks_exact(channels).skip(1);
                    for (a, b) in row.chunks_exact(channels).zip(next) {
                        let is_void = |pixel: &[u8]| self.height_m(pixel).is_nan();
                        let difference = |channel: usize| i32::from(b[channel]) - i32::from(a[channel]);
                        if is_void(a) || is_void(b) || (0..coarse).any(|higher| difference(higher) != 0) {
                            continue;
                        }
                        let step = difference(coarse);
                        if step.abs() == 1 {
                            steps += 1;
                            wraps += u64::from(difference(fine) * step < -WRAP);
                        }
                    }
                }
            }
            steps >= CARRIES && wraps as f64 >= CARRY_SHARE * steps as f64
        })
    }
}

/// A picture in memory with the samples of its file: 3 bytes per sample, 4 with an alpha channel.
pub(super) struct ColourReader {
    path: PathBuf,
    picture: Picture,
    packing: Packing,
    georeference: Georeference,
    identity: String,
}

impl HeightReader for ColourReader {
    fn size(&self) -> [u32; 2] {
        self.picture.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        check_window(&self.path, window, self.picture.size)?;
        let mut heights_m = memory::window_room(&self.path, window)?;
        let channels = self.picture.channels.max(3);
        for row in window.y as usize..(window.y + window.height) as usize {
            let first = (row * self.picture.size[0] as usize + window.x as usize) * channels;
            let pixels = &self.picture.bytes[first..first + window.width as usize * channels];
            heights_m.extend(pixels.chunks_exact(channels).map(|pixel| self.packing.height_m(pixel)));
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        [self.picture.size[0], 256.min(self.picture.size[1])]
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

/// Reads a single picture.
pub(super) fn open(path: &Path, info: &RasterInfo) -> Result<ColourReader, SourceError> {
    let picture = picture::decode(path)?;
    let packing = Packing::of(path, info, std::slice::from_ref(&picture))?;
    let georeference = info.georeference(path, picture.size)?;
    Ok(ColourReader { path: path.into(), picture, packing, georeference, identity: info.identity(path) })
}
