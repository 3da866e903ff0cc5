//! The colours of a GeoTIFF, by windows.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tiff_reader::cache::BlockCache;
use tiff_reader::{OpenOptions, TiffFile};

use super::super::georeference::{self, Georeference};
use super::super::geotiff::{damaged, decode_error, geo_tags, meaning};
use super::super::geotiff_layout::check_colors;
use super::super::masked::Mask;
use super::super::place::{self, cannot_open, inconsistent};
use super::super::reader::Window;
use super::super::samples::{Meaning, SampleType, Tally};
use super::super::tiff_blocks::{self, Blocks};
use super::super::tiff_sidecars::TiffSidecars;
use super::super::{GeoKeys, SourceError, memory, prj};
use super::Rgba;

/// Size of the cache of decoded blocks of a file.
const CACHE_BYTES: usize = 48 << 20;
/// Side of the window from which the range of other samples than shades is measured.
const MEASURED_PX: u32 = 2048;
/// Largest 16-bit value up to which samples count as shades of another range, such as the reflectances of satellites.
const LOW_16: f32 = 16_384.0;

/// The meaning of the samples of a pixel.
#[derive(Clone, Debug)]
enum Colors {
    /// A shade, dark or light for large values.
    Grey {
        is_inverted: bool,
    },
    Rgb,
    /// Indices into a table.
    Palette(Arc<[[u8; 3]]>),
}

/// One resolution of a GeoTIFF with colours.
pub(super) struct TiffColors {
    path: PathBuf,
    file: Arc<TiffFile>,
    cache: Arc<BlockCache>,
    blocks: Arc<Blocks>,
    colors: Colors,
    meaning: Meaning,
    masks: Vec<Mask>,
    /// Values of black and of white.
    range: [f32; 2],
}

/// Opens all resolutions of a GeoTIFF, with its position, and whether the file gives it.
pub(super) fn open(path: &Path) -> Result<(Vec<TiffColors>, Georeference, bool), SourceError> {
    let file_bytes = std::fs::metadata(path).map_err(cannot_open(path))?.len();
    let options =
        OpenOptions { block_cache_bytes: CACHE_BYTES, decode_output_bytes: usize::MAX / 2, ..OpenOptions::default() };
    let file = Arc::new(TiffFile::open_with_options(path, options).map_err(damaged(path))?);
    let layouts = check_colors(&file, file_bytes, path)?;
    let largest_block = layouts.iter().map(|level| level.block_bytes).max().unwrap_or(0);
    let cache = tiff_blocks::cache(CACHE_BYTES.max(largest_block as usize));
    let unsupported = |what: &str| SourceError::Unsupported { path: path.into(), what: what.to_owned() };

    let main = layouts.first().ok_or_else(|| inconsistent(path, "it contains no picture"))?;
    let ifd = file.ifd(main.blocks.ifd).map_err(damaged(path))?;
    let samples = main.blocks.samples;
    let bands = samples.per_pixel - usize::from(samples.alpha.is_some());
    let colors = match ifd.photometric_interpretation() {
        Some(3) => {
            let map = ifd.color_map().map_err(damaged(path))?;
            let map = map.ok_or_else(|| inconsistent(path, "its palette is missing"))?;
            let high = |value: &u16| value.to_be_bytes()[0];
            let entries = map.red().iter().zip(map.green()).zip(map.blue());
            Colors::Palette(entries.map(|((red, green), blue)| [high(red), high(green), high(blue)]).collect())
        }
        // A JPEG in a TIFF is decoded to red, green and blue.
        Some(6) if ifd.compression() != 7 => return Err(unsupported("a YCbCr picture without JPEG compression")),
        Some(5) => return Err(unsupported("a CMYK picture")),
        Some(8..=10) => return Err(unsupported("a CIE L*a*b* picture")),
        Some(0) => Colors::Grey { is_inverted: true },
        _ if bands >= 3 => Colors::Rgb,
        _ => Colors::Grey { is_inverted: false },
    };

    let located = |source| SourceError::Georeference { path: path.into(), source };
    let sidecars = TiffSidecars::of(path);
    let mut tags = geo_tags(ifd);
    let mut meaning = meaning(ifd, samples.decoded, &tags.geokeys, path);
    sidecars.overrule(&mut meaning);
    let name = path.display().to_string();
    let size = [main.width, main.height];
    let place = sidecars.place(&mut tags);
    let georeference = match place {
        Some(crs_from_grid) if tags.geokeys == GeoKeys::default() => {
            place::locate(path, crs_from_grid, prj::keys(path, crs_from_grid, size)?.0, size)?
        }
        Some(crs_from_grid) => georeference::from_transform(crs_from_grid, tags.geokeys, &name).map_err(located)?,
        None => georeference::assumed(),
    };

    let main_ifd = main.blocks.ifd;
    let range = [0.0, samples.decoded.largest(samples.bits) as f32];
    let mut levels = Vec::new();
    for layout in layouts {
        let blocks = Arc::new(layout.blocks);
        let masks = match blocks.ifd == main_ifd {
            true => Mask::all(&file, &cache, &blocks, file_bytes, path)?,
            false => Mask::internal(&file, &cache, &blocks, file_bytes, path)?.into_iter().collect(),
        };
        let meaning = Meaning::metres(samples.decoded, meaning.no_data);
        let (path, file, cache) = (path.into(), Arc::clone(&file), Arc::clone(&cache));
        levels.push(TiffColors { path, file, cache, blocks, colors: colors.clone(), meaning, masks, range });
    }
    let is_shades = samples.decoded == SampleType::U8 || matches!(colors, Colors::Palette(_));
    if let (false, Some(smallest)) = (is_shades, levels.last()) {
        let measured = smallest.measured_range()?;
        let is_full = samples.decoded == SampleType::U16 && measured[1] > LOW_16;
        let range = if is_full { range } else { measured };
        levels.iter_mut().for_each(|level| level.range = range);
    }
    Ok((levels, georeference, place.is_some()))
}

impl TiffColors {
    pub(super) fn size(&self) -> [u32; 2] {
        self.blocks.size
    }

    /// Returns the pixels of a window inside the picture.
    pub(super) fn read(&self, window: Window) -> Result<Vec<Rgba>, SourceError> {
        let mut pixels: Vec<Rgba> = memory::room(&self.path, self.size(), window.samples() as u64)?;
        let bytes = self.meaning.sample_type.bytes();
        match &self.colors {
            Colors::Palette(table) => {
                let indices = self.band(0, window)?;
                let index = |sample: &[u8]| match sample {
                    [index] => usize::from(*index),
                    [low, high] => usize::from(u16::from_ne_bytes([*low, *high])),
                    _ => usize::MAX,
                };
                let no_data = self.meaning.no_data;
                pixels.extend(indices.chunks_exact(bytes).map(|sample| {
                    let index = index(sample);
                    let color = table.get(index).filter(|_| no_data != Some(index as f64));
                    color.map_or([0; 4], |[red, green, blue]| [*red, *green, *blue, 255])
                }));
            }
            Colors::Grey { is_inverted } => {
                let values = self.values(0, window)?;
                pixels.extend(values.iter().map(|value| {
                    let shade = self.shade(*value);
                    let shade = if *is_inverted { 255 - shade } else { shade };
                    if value.is_nan() { [0; 4] } else { [shade, shade, shade, 255] }
                }));
            }
            Colors::Rgb => {
                let [red, green, blue] = [self.values(0, window)?, self.values(1, window)?, self.values(2, window)?];
                let no_data = self.meaning.no_data.unwrap_or(0.0) as f32;
                pixels.extend(red.iter().zip(&green).zip(&blue).map(|((red, green), blue)| {
                    // A pixel is no-data if all of its channels are.
                    let channel = |value: &f32| self.shade(if value.is_nan() { no_data } else { *value });
                    let is_nothing = [red, green, blue].into_iter().all(|value| value.is_nan());
                    if is_nothing { [0; 4] } else { [channel(red), channel(green), channel(blue), 255] }
                }));
            }
        }
        if let Some(band) = self.blocks.samples.alpha {
            let largest = self.meaning.sample_type.largest(self.blocks.samples.bits) as f32;
            let mut opacities = Vec::new();
            let plain = Meaning::metres(self.meaning.sample_type, None);
            plain.append_heights_m(&self.band(band, window)?, &mut opacities, &mut Tally::default());
            for (pixel, opacity) in pixels.iter_mut().zip(opacities) {
                pixel[3] = pixel[3].min((255.0 * (opacity / largest).clamp(0.0, 1.0)).round() as u8);
            }
        }
        let mut seen = Vec::new();
        for mask in &self.masks {
            seen.clear();
            seen.resize(pixels.len(), 1.0);
            mask.apply(window, &mut seen)?;
            pixels.iter_mut().zip(&seen).filter(|(_, seen)| seen.is_nan()).for_each(|(pixel, _)| *pixel = [0; 4]);
        }
        // Blocks that a file leaves out show nothing.
        for part in self.blocks.parts(window).filter(|part| self.blocks.place(part.block).is_none()) {
            part.window.fill(window, &mut pixels, [0; 4]);
        }
        Ok(pixels)
    }

    fn shade(&self, value: f32) -> u8 {
        let [black, white] = self.range;
        (255.0 * ((value - black) / (white - black)).clamp(0.0, 1.0)).round() as u8
    }

    fn band(&self, band: usize, window: Window) -> Result<Vec<u8>, SourceError> {
        let read = self.blocks.read(&self.file, &self.cache, band, window);
        let bytes = read.map_err(|source| decode_error(source, &self.path))?;
        match bytes.len() == window.samples() * self.meaning.sample_type.bytes() {
            true => Ok(bytes),
            false => Err(inconsistent(&self.path, "a strip or tile decodes to the wrong size")),
        }
    }

    /// Returns the values of a band; NaN is no-data.
    fn values(&self, band: usize, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut values = memory::room(&self.path, self.size(), window.samples() as u64)?;
        self.meaning.append_heights_m(&self.band(band, window)?, &mut values, &mut Tally::default());
        Ok(values)
    }

    /// Returns the smallest and the largest value of the colours in the middle of the picture.
    fn measured_range(&self) -> Result<[f32; 2], SourceError> {
        let [width, height] = self.size().map(|side| side.min(MEASURED_PX));
        let [x, y] = [(self.size()[0] - width) / 2, (self.size()[1] - height) / 2];
        let window = Window { x, y, width, height };
        let bands = if matches!(self.colors, Colors::Rgb) { 3 } else { 1 };
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for band in 0..bands {
            for value in self.values(band, window)?.into_iter().filter(|value| value.is_finite()) {
                range = [range[0].min(value), range[1].max(value)];
            }
        }
        let [low, high] = range;
        Ok(if high > low { [low, high] } else { [0.0, if high > 0.0 { high } else { 1.0 }] })
    }
}
