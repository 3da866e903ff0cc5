//! Heights packed into the colours of a picture.
//!
//! - Terrarium (Mapzen, "Terrain tile formats"): red × 256 + green + blue / 256 − 32768 metres.
//! - Mapbox ("Mapbox Terrain-RGB v1"): −10000 + (red × 65536 + green × 256 + blue) × 0.1 metres.
//!
//! A picture does not say which it is, but heights on the Earth give it away: in Mapbox's they need a red of 0 to 2, in
//! Terrarium's one of 85 to 163. A picture of anything else has other colours, or jumps by hundreds of metres from pixel
//! to pixel.

use std::path::{Path, PathBuf};

use super::SourceError;
use super::georeference::Georeference;
use super::memory;
use super::picture::{self, Picture};
use super::place::check_window;
use super::reader::{HeightReader, Window};
use super::samples::MAX_HEIGHT_M;
use super::side_file::{Encoding, Said};

/// From below the deepest trench to above the highest mountain, metres.
const PLAUSIBLE_M: std::ops::RangeInclusive<f32> = -11_100.0..=9_100.0;
/// Of the pixels that hold a height at all, so many must be plausible.
const PLAUSIBLE_SHARE: f64 = 0.95;
/// Mean difference of neighbours in metres, above which it is a picture of something else. Whole continents in one
/// tile have about 200.
const MAX_MEAN_JUMP_M: f64 = 500.0;

/// Metres for each step of Mapbox's encoding, where nothing else is said.
pub(super) const MAPBOX_INTERVAL_M: f64 = 0.1;

/// How the colours are to be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Packing {
    pub encoding: Encoding,
    pub interval_m: f64,
}

impl Packing {
    /// A height in metres; NaN where the pixel is black or transparent, which no height is.
    fn height_m(self, pixel: &[u8]) -> f32 {
        let [red, green, blue] = [pixel[0], pixel[1], pixel[2]].map(f64::from);
        let is_void = pixel[..3] == [0, 0, 0] || pixel.get(3) == Some(&0);
        match self.encoding {
            _ if is_void => f32::NAN,
            Encoding::Terrarium => (red * 256.0 + green + blue / 256.0 - 32_768.0) as f32,
            Encoding::Mapbox => {
                let height_m = (red * 65_536.0 + green * 256.0 + blue) * self.interval_m - 10_000.0;
                // A height as everywhere else, whatever the interval is said to be.
                if height_m.abs() <= MAX_HEIGHT_M { height_m as f32 } else { f32::NAN }
            }
        }
    }

    /// The heights of a colour picture in metres, by rows.
    pub fn heights_m(self, picture: &Picture) -> impl Iterator<Item = f32> + '_ {
        picture.bytes.chunks_exact(picture.channels.max(3)).map(move |pixel| self.height_m(pixel))
    }

    /// What is said of the encoding, or what the colours of the pictures give away.
    ///
    /// # Errors
    /// Where the colours are no heights, or nothing but voids.
    pub fn of(path: &Path, said: &Said, pictures: &[Picture]) -> Result<Self, SourceError> {
        let interval_m = said.side.interval_m.unwrap_or(MAPBOX_INTERVAL_M);
        let guess = || {
            let both = [Encoding::Mapbox, Encoding::Terrarium];
            both.into_iter().find(|&encoding| Self { encoding, interval_m }.is_plausible(pictures))
        };
        let encoding = said.side.encoding.or_else(guess);
        let encoding =
            encoding.ok_or_else(|| SourceError::NotHeights { path: path.into(), what: "a colour picture" })?;
        Ok(Self { encoding, interval_m })
    }

    fn is_plausible(self, pictures: &[Picture]) -> bool {
        let (mut heights, mut plausible, mut jumps, mut sum_m) = (0u64, 0u64, 0u64, 0.0);
        let mut is_grey = true;
        let mut colours = std::collections::BTreeSet::new();
        for picture in pictures {
            let mut last = f32::NAN;
            for pixel in picture.bytes.chunks_exact(picture.channels.max(3)) {
                let height = self.height_m(pixel);
                is_grey &= pixel[0] == pixel[1] && pixel[1] == pixel[2];
                if is_grey && colours.len() < 2 {
                    colours.insert(pixel[0]);
                }
                if !height.is_nan() {
                    heights += 1;
                    plausible += u64::from(PLAUSIBLE_M.contains(&height));
                }
                let jump = f64::from((height - last).abs());
                if !jump.is_nan() {
                    jumps += 1;
                    sum_m += jump;
                }
                last = height;
            }
        }
        let is_grey_picture = is_grey && colours.len() > 1;
        heights > 0
            && !is_grey_picture
            && plausible as f64 >= PLAUSIBLE_SHARE * heights as f64
            && sum_m <= MAX_MEAN_JUMP_M * jumps as f64
    }
}

/// A picture in memory, as its file has it: 3 bytes for each sample, 4 with an alpha channel.
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
pub(super) fn open(path: &Path, said: &Said) -> Result<ColourReader, SourceError> {
    let picture = picture::decode(path)?;
    let packing = Packing::of(path, said, std::slice::from_ref(&picture))?;
    let georeference = said.georeference(path, picture.size)?;
    Ok(ColourReader { path: path.into(), picture, packing, georeference, identity: said.identity(path) })
}
