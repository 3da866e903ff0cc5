//! GIF: short films of at most 255 colours, for pages and messages that show no video.
//!
//! All frames share one palette, so that colours do not flicker: the exact colours if there are few enough, and
//! otherwise those that the network of `color_quant` (NeuQuant, Dekker 1994) learns from samples of all frames. The
//! palette is known only after the last frame, so frames wait in memory, compressed. Of each frame only the pixels that
//! change are written. There is no dithering: its pattern would crawl over flat paper.

use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use gif::{AnyExtension, Encoder, Extension, Frame, Repeat};
use rustc_hash::{FxHashMap, FxHashSet};

use super::atomic::AtomicFile;
use super::frame_rate::FrameRate;
use super::imprint::{KEY, Notes};
use super::input::open_regular;
use super::{FileError, sample_count};

/// Longest side that the format can state.
const LONGEST_PX: u32 = 65_535;
/// Largest frame rate: browsers show frames of less than 2/100 s for 10/100 s.
pub(crate) const LARGEST_RATE: f64 = 50.0;
/// Units of a delay in a second.
const DELAYS_PER_S: f64 = 100.0;
/// Bytes of all compressed frames; a longer film is refused.
const LARGEST_BYTES: usize = 1 << 30;
/// Colours of the palette; one more index is for pixels that do not change.
const COLOURS: usize = 255;
/// Pixels of all frames from which a palette is learned.
const SAMPLES: usize = 1 << 19;
/// Part of the samples that the network looks at: 1 is all, 30 is a thirtieth.
const SAMPLE_FACTOR: i32 = 1;
/// Channels of a pixel of the caller.
const RGBA: usize = 4;

/// A film that is being made. Without [`GifWriter::finish`] there is no file.
pub struct GifWriter {
    path: PathBuf,
    size: [u16; 2],
    rate: FrameRate,
    imprint: Option<String>,
    /// Compressed frames, three bytes per pixel.
    frames: Vec<Vec<u8>>,
    bytes: usize,
    /// The distinct colours so far; `None` once there are too many for a palette.
    colours: Option<FxHashSet<[u8; 3]>>,
}

impl GifWriter {
    /// Starts a film of `width` × `height` pixels with an imprint.
    ///
    /// # Errors
    /// Fails if the picture is empty or has a side of more than 65,535 pixels, or for more than 50 frames per second.
    pub fn create(
        path: &Path,
        [width, height]: [u32; 2],
        rate: FrameRate,
        notes: &Notes<'_>,
    ) -> Result<Self, FileError> {
        sample_count(path, width, height)?;
        if width.max(height) > LONGEST_PX {
            let cause = format!("a GIF has at most {LONGEST_PX} pixels a side, and the film has {width}x{height}");
            return Err(FileError::write(path, cause));
        }
        if rate.per_second() > LARGEST_RATE {
            let cause = format!("a GIF shows at most {LARGEST_RATE} frames per second; use a lower --fps than {rate}");
            return Err(FileError::write(path, cause));
        }
        Ok(Self {
            path: path.to_owned(),
            size: [width as u16, height as u16],
            rate,
            imprint: notes.imprint.map(str::to_owned),
            frames: Vec::new(),
            bytes: 0,
            colours: Some(FxHashSet::default()),
        })
    }

    /// Appends a frame: width × height × 4 bytes of red, green, blue, alpha, from the top. Alpha is ignored.
    ///
    /// # Errors
    /// Fails if the number of bytes is wrong, or if the film becomes too long for memory.
    pub fn write_frame(&mut self, rgba: &[u8]) -> Result<(), FileError> {
        let failed = |error| FileError::write(&self.path, error);
        let expected = usize::from(self.size[0]) * usize::from(self.size[1]) * RGBA;
        if rgba.len() != expected {
            return Err(FileError::write(&self.path, format!("a frame has {} bytes, not {expected}", rgba.len())));
        }
        let rgb: Vec<u8> = rgba.chunks_exact(RGBA).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        if let Some(colours) = &mut self.colours {
            colours.extend(pixels(&rgb));
            if colours.len() > COLOURS {
                self.colours = None;
            }
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&rgb).map_err(failed)?;
        let packed = encoder.finish().map_err(failed)?;
        self.bytes += packed.len();
        self.frames.push(packed);
        if self.bytes > LARGEST_BYTES {
            let cause = format!(
                "the film is too long for a GIF: {} frames fill the memory that hachure uses for one; write an .mp4, or \
                 use a smaller --size or --fps",
                self.frames.len()
            );
            return Err(FileError::write(&self.path, cause));
        }
        Ok(())
    }

    /// Finishes the film and gives it its name.
    ///
    /// # Errors
    /// Fails if there is no frame, the folder does not exist or is not writable, or the disk is full.
    pub fn finish(self) -> Result<(), FileError> {
        if self.frames.is_empty() {
            return Err(FileError::write(&self.path, "the film has no frames"));
        }
        let mut file = AtomicFile::create(&self.path).map_err(|error| FileError::write(&self.path, error))?;
        self.write(file.writer()).map_err(|error| FileError::write(&self.path, error))?;
        file.commit().map_err(|error| FileError::write(&self.path, error))
    }

    fn write(&self, out: &mut impl Write) -> Result<(), gif::EncodingError> {
        let mut palette = Palette::new(self.palette()?);
        let [width, height] = self.size;
        let unchanged = palette.colours.len() as u8;
        let table: Vec<u8> = palette.colours.iter().copied().chain([[0; 3]]).flatten().collect();
        let mut encoder = Encoder::new(out, width, height, &table)?;
        encoder.set_repeat(Repeat::Infinite)?;
        if let Some(imprint) = &self.imprint {
            let text = format!("{KEY}\n{imprint}");
            encoder.write_raw_extension(AnyExtension(Extension::Comment as u8), &[text.as_bytes()])?;
        }
        let mut shown: Vec<u8> = Vec::new();
        let end = |frame: u64| (self.rate.time_s(frame) * DELAYS_PER_S).round();
        for (number, packed) in (0..).zip(&self.frames) {
            let indices: Vec<u8> = pixels(&unpacked(packed)?).map(|colour| palette.index(colour)).collect();
            let (area, buffer) = changed(&shown, &indices, width, unchanged);
            encoder.write_frame(&Frame {
                delay: (end(number + 1) - end(number)).clamp(1.0, f64::from(u16::MAX)) as u16,
                transparent: (!shown.is_empty()).then_some(unchanged),
                left: area[0],
                top: area[1],
                width: area[2],
                height: if shown.is_empty() { height } else { area[3] },
                buffer: buffer.into(),
                ..Frame::default()
            })?;
            shown = indices;
        }
        encoder.into_inner()?;
        Ok(())
    }

    /// Returns at most [`COLOURS`] colours for all frames.
    fn palette(&self) -> std::io::Result<Vec<[u8; 3]>> {
        if let Some(colours) = &self.colours {
            let mut colours: Vec<_> = colours.iter().copied().collect();
            colours.sort_unstable();
            return Ok(colours);
        }
        let all = self.frames.len() * usize::from(self.size[0]) * usize::from(self.size[1]);
        // An odd step does not follow columns.
        let step = all.div_ceil(SAMPLES) | 1;
        let (mut samples, mut skipped) = (Vec::new(), 0);
        for packed in &self.frames {
            let rgb = unpacked(packed)?;
            samples.extend(pixels(&rgb).skip(skipped).step_by(step).flat_map(|[r, g, b]| [r, g, b, 255]));
            let count = rgb.len() / 3;
            skipped = (skipped + step - count % step) % step;
        }
        let network = color_quant::NeuQuant::new(SAMPLE_FACTOR, COLOURS, &samples);
        Ok(network.color_map_rgb().chunks_exact(3).map(|own| [own[0], own[1], own[2]]).collect())
    }
}

/// The colours of a film, and the index of each colour that was looked up.
struct Palette {
    colours: Vec<[u8; 3]>,
    known: FxHashMap<[u8; 3], u8>,
}

impl Palette {
    fn new(colours: Vec<[u8; 3]>) -> Self {
        Self { colours, known: FxHashMap::default() }
    }

    /// Returns the index of the nearest colour.
    fn index(&mut self, colour: [u8; 3]) -> u8 {
        let Self { colours, known } = self;
        *known.entry(colour).or_insert_with(|| {
            let far =
                |own: &[u8; 3]| own.iter().zip(colour).map(|(a, b)| (i32::from(*a) - i32::from(b)).pow(2)).sum::<i32>();
            (0..).zip(colours.iter()).min_by_key(|(_, own)| far(own)).map_or(0, |(index, _): (u8, _)| index)
        })
    }
}

fn pixels(rgb: &[u8]) -> impl Iterator<Item = [u8; 3]> + '_ {
    rgb.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]])
}

fn unpacked(packed: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut rgb = Vec::new();
    ZlibDecoder::new(packed).read_to_end(&mut rgb)?;
    Ok(rgb)
}

/// Returns the area (left, top, width, height) in which a frame differs from the one that is shown, and its pixels;
/// those that do not differ are `unchanged`. Without a shown frame all pixels differ, and the height is not counted. A
/// frame without a difference has one pixel.
fn changed(shown: &[u8], next: &[u8], width: u16, unchanged: u8) -> ([u16; 4], Vec<u8>) {
    if shown.is_empty() {
        return ([0, 0, width, 0], next.to_vec());
    }
    let columns = usize::from(width);
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for (pixel, _) in shown.iter().zip(next).enumerate().filter(|(_, (a, b))| a != b) {
        let at = [pixel % columns, pixel / columns];
        low = [low[0].min(at[0]), low[1].min(at[1])];
        high = [high[0].max(at[0]), high[1].max(at[1])];
    }
    if low[0] == usize::MAX {
        return ([0, 0, 1, 1], vec![unchanged]);
    }
    let rows = low[1]..=high[1];
    let of_row = |row: usize| row * columns + low[0]..=row * columns + high[0];
    let pixel = |at: usize| if shown[at] == next[at] { unchanged } else { next[at] };
    let buffer = rows.flat_map(|row| of_row(row).map(pixel)).collect();
    // Sides are at most 65,535.
    ([low[0], low[1], high[0] - low[0] + 1, high[1] - low[1] + 1].map(|side| side as u16), buffer)
}

/// Reads the imprint from the comments before the first frame.
pub(super) fn imprint(path: &Path, largest_bytes: usize) -> Result<Option<String>, FileError> {
    let failed = |error: std::io::Error| FileError::read(path, error);
    let mut file = BufReader::new(open_regular(path).map_err(failed)?);
    let mut head = [0; 13];
    file.read_exact(&mut head).map_err(failed)?;
    if head[10] & 0x80 != 0 {
        let mut table = vec![0; 3 << ((head[10] & 7) + 1)];
        file.read_exact(&mut table).map_err(failed)?;
    }
    let mut byte = || {
        let mut byte = [0];
        file.read_exact(&mut byte).map(|()| byte[0])
    };
    while byte().map_err(failed)? == 0x21 {
        let is_comment = byte().map_err(failed)? == Extension::Comment as u8;
        let mut text = Vec::new();
        loop {
            let length = byte().map_err(failed)?;
            if length == 0 {
                break;
            }
            for _ in 0..length {
                text.push(byte().map_err(failed)?);
            }
            if text.len() > largest_bytes {
                return Err(FileError::read(path, "its imprint is too long"));
            }
        }
        let text = String::from_utf8(text).ok().filter(|_| is_comment);
        if let Some(imprint) = text.as_deref().and_then(|text| text.strip_prefix(KEY)?.strip_prefix('\n')) {
            return Ok(Some(imprint.to_owned()));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    const SIZE: [u32; 2] = [40, 30];

    /// Writes frames, and returns what a decoder shows, with its delays.
    fn shown(frames: &[Vec<u8>], rate: FrameRate) -> (Vec<Vec<u8>>, Vec<u16>, Option<String>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gif");
        let notes = Notes { imprint: Some("style = \"ü\""), ..Notes::default() };
        let mut film = GifWriter::create(&path, SIZE, rate, &notes).unwrap();
        frames.iter().for_each(|frame| film.write_frame(frame).unwrap());
        film.finish().unwrap();
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(std::fs::File::open(&path).unwrap()).unwrap();
        let mut canvas = vec![0; (SIZE[0] * SIZE[1]) as usize * RGBA];
        let (mut pictures, mut delays) = (Vec::new(), Vec::new());
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            for (i, pixel) in frame.buffer.chunks_exact(RGBA).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
                let at = [i % usize::from(frame.width), i / usize::from(frame.width)];
                let at = (at[1] + usize::from(frame.top)) * SIZE[0] as usize + at[0] + usize::from(frame.left);
                canvas[at * RGBA..][..RGBA].copy_from_slice(pixel);
            }
            pictures.push(canvas.clone());
            delays.push(frame.delay);
        }
        (pictures, delays, imprint(&path, 1000).unwrap())
    }

    fn frame(colour: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
        let pixels = (0..SIZE[0] * SIZE[1]).map(|i| colour(i % SIZE[0], i / SIZE[0]));
        pixels.flat_map(|[r, g, b]| [r, g, b, 255]).collect()
    }

    fn farthest(a: &[u8], b: &[u8]) -> u8 {
        a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
    }

    #[test]
    fn few_colours_are_exact_and_frames_last_as_long_as_they_should() {
        let spot = |at: u32| frame(move |x, y| if x == at && y > 5 { [20, 18, 15] } else { [250, (y * 4) as u8, 230] });
        let frames = [spot(3), spot(9), spot(9), spot(30)];
        let (pictures, delays, text) = shown(&frames, "30".parse().unwrap());
        assert!(pictures == frames);
        assert!(pictures[0] != frames[1], "planted error");
        // A third of a second is 33 or 34 hundredths; 30 frames are a second.
        assert_eq!(delays, [3, 4, 3, 3]);
        assert_eq!(text.as_deref(), Some("style = \"ü\""));
        let fast = GifWriter::create(Path::new("a.gif"), SIZE, FrameRate::Number(60.0), &Notes::default());
        assert!(fast.err().unwrap().to_string().contains("at most 50 frames"));
    }

    #[test]
    fn many_colours_share_a_palette() {
        let frames: Vec<_> = (0..3)
            .map(|step| frame(move |x, y| [(x * 6) as u8, (y * 8) as u8, (x * 3 + y * 3 + step) as u8]))
            .collect();
        let (pictures, ..) = shown(&frames, FrameRate::Number(10.0));
        for (picture, frame) in pictures.iter().zip(&frames) {
            assert!(farthest(picture, frame) < 40, "{}", farthest(picture, frame));
        }
        assert!(farthest(&pictures[0], &vec![128; pictures[0].len()]) > 100, "planted error");
    }
}
