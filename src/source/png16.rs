//! Grey PNG with 16 bits per sample: the heightmap format of game engines. The height of a step, the sample spacing and
//! the position come from a sidecar file or from options.
//!
//! A picture that is read from its first row to its last is decoded on the way, and only one row of it is held in
//! memory. Any other window needs the whole picture, which then stays in memory: 2 bytes per sample, 4 with an alpha
//! channel.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use png::{BitDepth, ColorType};

use super::SourceError;
use super::georeference::Georeference;
use super::geotiff::guarded;
use super::memory;
use super::picture::{Picture, Rows};
use super::place::{self, check_window};
use super::reader::{HeightReader, Window};
use super::samples::{Meaning, SampleType, Tally, WarnOnce};
use super::sidecar::{OpenOptions, RasterInfo};
use super::values::Holds;
use super::{picture, terrain_rgb};

/// Approximate number of samples in a block of rows.
const BLOCK_SAMPLES: u32 = 1 << 20;

/// Opens a PNG or WebP picture: a heightmap, or terrain-RGB.
pub(super) fn open(
    path: &Path,
    info: &RasterInfo,
    options: &OpenOptions,
) -> Result<Box<dyn HeightReader>, SourceError> {
    let header = picture::header(path)?;
    place::check_size(path, header.size)?;
    let refused = |what| Err(SourceError::NotHeights { path: path.into(), what, holds: Holds::Heights });
    match (header.color, header.depth) {
        (ColorType::Grayscale | ColorType::GrayscaleAlpha, BitDepth::Sixteen) => {
            options.warn_unused(path, "a grey PNG", &["--spacing", "--height-scale", "--height-offset"]);
            Ok(Box::new(GreyReader::open(path, info, header.size)?))
        }
        (ColorType::Grayscale | ColorType::GrayscaleAlpha, _) => refused("a grey picture of 8 bits or less"),
        (_, BitDepth::Sixteen) => refused("a colour picture of 16 bits"),
        _ => {
            let used = ["--spacing", "--height-scale", "--height-offset", "--encoding"];
            options.warn_unused(path, "a colour picture", &used);
            Ok(Box::new(terrain_rgb::open(path, info)?))
        }
    }
}

/// A grey PNG that is decoded row by row or completely.
struct GreyReader {
    path: PathBuf,
    size: [u32; 2],
    meaning: Meaning,
    georeference: Georeference,
    identity: String,
    warnings: WarnOnce,
    state: Mutex<State>,
}

/// The decoded part of the picture.
enum State {
    /// A decoder before the next row; the rows above have been returned.
    Rows(Box<Rows>),
    Whole(Arc<Picture>),
    /// Nothing is decoded: the next window decides how to continue.
    Closed,
}

impl State {
    /// Returns the state before the first row; `Closed` for an interlaced picture.
    fn before_the_first(path: &Path) -> Result<Self, SourceError> {
        Ok(Rows::open(path)?.map_or(Self::Closed, |rows| Self::Rows(Box::new(rows))))
    }
}

impl GreyReader {
    fn open(path: &Path, info: &RasterInfo, size: [u32; 2]) -> Result<Self, SourceError> {
        let meaning = info.meaning(path, SampleType::U16);
        let state = State::before_the_first(path)?;
        Ok(Self {
            path: path.into(),
            size,
            meaning,
            georeference: info.georeference(path, size)?,
            identity: info.identity(path),
            warnings: WarnOnce::default(),
            state: Mutex::new(state),
        })
    }

    /// Returns the rows of a window that spans all columns and is the first or follows the previous one; `None` for
    /// other windows.
    fn read_on(&self, state: &mut State, window: Window) -> Result<Option<Vec<f32>>, SourceError> {
        if window.x != 0 || window.width != self.size[0] {
            return Ok(None);
        }
        let is_ready = match state {
            State::Whole(_) => true,
            State::Rows(rows) => rows.next == 0,
            State::Closed => false,
        };
        if window.y == 0 && !is_ready {
            *state = State::before_the_first(&self.path)?;
        }
        let State::Rows(rows) = state else { return Ok(None) };
        if rows.next != window.y {
            return Ok(None);
        }
        let mut heights_m = memory::window_room(&self.path, window)?;
        let mut tally = Tally::default();
        for _ in 0..window.height {
            let row = rows.read()?;
            self.append_heights_m(row, row.len() / self.size[0] as usize, &mut heights_m, &mut tally);
        }
        self.warnings.warn(&self.path, &tally);
        Ok(Some(heights_m))
    }

    fn whole(&self, state: &mut State) -> Result<Arc<Picture>, SourceError> {
        if let State::Whole(picture) = state {
            return Ok(picture.clone());
        }
        let picture = picture::decode(&self.path)?;
        if picture.size != self.size || picture.channel_bytes != 2 {
            return Err(place::inconsistent(&self.path, "it changed while it was read"));
        }
        let picture = Arc::new(picture);
        *state = State::Whole(picture.clone());
        Ok(picture)
    }

    /// Appends the heights of pixels of `pixel_bytes` bytes each: a sample, possibly with alpha.
    fn append_heights_m(&self, pixels: &[u8], pixel_bytes: usize, heights_m: &mut Vec<f32>, tally: &mut Tally) {
        heights_m.extend(pixels.chunks_exact(pixel_bytes.max(2)).map(|pixel| match pixel {
            [_, _, 0, 0] => f32::NAN,
            _ => self.meaning.height_m(f64::from(u16::from_be_bytes([pixel[0], pixel[1]])), tally),
        }));
    }

    fn read_unguarded(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        // If a thread panicked, its half-read rows are discarded.
        let mut state = self.state.lock().unwrap_or_else(|poison| {
            let mut state = PoisonError::into_inner(poison);
            *state = State::Closed;
            state
        });
        match self.read_on(&mut state, window) {
            Ok(None) => {}
            Ok(Some(heights_m)) => return Ok(heights_m),
            Err(error) => {
                *state = State::Closed;
                return Err(error);
            }
        }
        let picture = self.whole(&mut state)?;
        drop(state);
        let mut heights_m = memory::window_room(&self.path, window)?;
        let mut tally = Tally::default();
        let pixel_bytes = picture.channels * picture.channel_bytes;
        for row in window.rows_in(Window::whole(self.size)) {
            let pixels = &picture.bytes[row.start * pixel_bytes..row.end * pixel_bytes];
            self.append_heights_m(pixels, pixel_bytes, &mut heights_m, &mut tally);
        }
        self.warnings.warn(&self.path, &tally);
        Ok(heights_m)
    }
}

impl HeightReader for GreyReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        check_window(&self.path, window, self.size)?;
        if window.samples() == 0 {
            return Ok(Vec::new());
        }
        guarded(&self.path, || self.read_unguarded(window))
    }

    fn block(&self) -> [u32; 2] {
        [self.size[0], (BLOCK_SAMPLES / self.size[0]).clamp(1, self.size[1])]
    }

    fn is_serial(&self) -> bool {
        true
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.given()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}
