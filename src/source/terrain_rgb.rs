//! Terrain-RGB: heights that are encoded in the colours of a picture.
//!
//! - Terrarium (Mapzen, "Terrain tile formats"): red × 256 + green + blue / 256 − 32768 metres.
//! - Mapbox ("Mapbox Terrain-RGB v1"): −10000 + code × 0.1 metres, where the code is red × 65536 + green × 256 + blue.
//!   Other programs (`rio rgbify`) write another base and another interval.
//! - GSI (Geospatial Information Authority of Japan, "標高タイルの詳細仕様"): code × 0.01 metres in two's complement;
//!   (128, 0, 0) is no-data.
//!
//! The encoding, and whether a picture contains heights at all, is not in the file; a sidecar file or an option must
//! give it. Otherwise the colours must prove it (`colour_proof`).

use std::path::{Path, PathBuf};

use super::georeference::Georeference;
use super::picture::{self, Picture};
use super::place::begin_window;
use super::reader::{HeightReader, Window};
use super::samples::MAX_HEIGHT_M;
use super::sidecar::RasterInfo;
use super::{Encoding, SourceError, colour_proof};

/// The code of GSI that means no-data, which is also the smallest number of 24 bits in two's complement.
const GSI_VOID: u32 = 1 << 23;

/// The encoding of heights, with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColourEncoding {
    pub encoding: Encoding,
    /// Metres per step of the code.
    pub interval_m: f64,
    /// Height of code 0, in metres.
    pub base_m: f64,
    /// Whether black is no-data: a height only if the base says so.
    is_black_void: bool,
    /// Another code that means no-data.
    void_code: Option<u32>,
}

impl ColourEncoding {
    /// Returns an encoding, with its usual numbers for those that are not given.
    pub(super) fn new(encoding: Encoding, interval_m: Option<f64>, base_m: Option<f64>) -> Self {
        let [own_interval_m, own_base_m] = encoding.steps_m();
        Self {
            encoding,
            interval_m: interval_m.unwrap_or(own_interval_m),
            base_m: base_m.unwrap_or(own_base_m),
            is_black_void: encoding != Encoding::Gsi && base_m.is_none_or(|base_m| base_m == own_base_m),
            void_code: None,
        }
    }

    /// Returns the encoding with a no-data value in steps, as a sidecar file gives it.
    pub(super) fn with_void(self, no_data: Option<f64>) -> Self {
        let code = no_data.filter(|code| (0.0..f64::from(1 << 24)).contains(code) && code.fract() == 0.0);
        Self { void_code: code.map(|code| code as u32).or(self.void_code), ..self }
    }

    /// Returns a height in metres; NaN for a pixel that is transparent or has the colour of no-data.
    pub(super) fn height_m(&self, pixel: &[u8]) -> f32 {
        let code = u32::from_be_bytes([0, pixel[0], pixel[1], pixel[2]]);
        let is_void = pixel.get(3) == Some(&0)
            || (code == 0 && self.is_black_void)
            || self.void_code == Some(code)
            || (code == GSI_VOID && self.encoding == Encoding::Gsi);
        if is_void {
            return f32::NAN;
        }
        let steps = match self.encoding {
            Encoding::Gsi if code > GSI_VOID => f64::from(code) - f64::from(1 << 24),
            _ => f64::from(code),
        };
        let height_m = steps * self.interval_m + self.base_m;
        // Whatever the interval, the range of valid heights is the same as for other formats.
        if height_m.abs() <= MAX_HEIGHT_M { height_m as f32 } else { f32::NAN }
    }

    /// Returns the heights of a colour picture in metres, row by row.
    pub(super) fn heights_m<'a>(&'a self, picture: &'a Picture) -> impl Iterator<Item = f32> + 'a {
        picture.bytes.chunks_exact(picture.channels.max(3)).map(|pixel| self.height_m(pixel))
    }
}

/// A picture in memory with the samples of its file: 3 bytes per sample, 4 with an alpha channel.
pub(super) struct ColourReader {
    path: PathBuf,
    picture: Picture,
    packing: ColourEncoding,
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
        let mut heights_m = begin_window(&self.path, window, self.picture.size)?;
        let channels = self.picture.channels.max(3);
        for row in window.rows_in(Window::whole(self.picture.size)) {
            let pixels = &self.picture.bytes[row.start * channels..row.end * channels];
            heights_m.extend(pixels.chunks_exact(channels).map(|pixel| self.packing.height_m(pixel)));
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        [self.picture.size[0], 256.min(self.picture.size[1])]
    }

    fn encoding(&self) -> Option<Encoding> {
        Some(self.packing.encoding)
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

/// Reads a single picture.
pub(super) fn open(path: &Path, info: &RasterInfo) -> Result<ColourReader, SourceError> {
    let picture = picture::decode(path)?;
    let hints = colour_proof::PlaceHints { spacing_m: info.spacing_beside_m(), in_japan: None };
    let packing = colour_proof::packing(path, info, std::slice::from_ref(&picture), &hints)?;
    let georeference = info.georeference(path, picture.size)?;
    Ok(ColourReader { path: path.into(), picture, packing, georeference, identity: info.identity(path) })
}
