//! Reads any intermediate image of a frame for `--show`. The trace of the frame lists all of them, so a new image can
//! be shown without further code.

use std::collections::BTreeSet;

use rayon::prelude::*;
use wgpu::TextureFormat as Format;

use crate::file::exr::{Channel, Samples};
use crate::file::message::{did_you_mean, shown};
use crate::gpu::target::Group;
use crate::gpu::trace::PassTrace;
use crate::gpu::{Gpu, GpuError, readback};
use crate::style::color::srgb_from_linear;
use crate::surface::seen;

/// An intermediate image of a frame.
#[derive(Clone, Debug)]
pub(crate) struct ShownPicture {
    /// Size in pixels; the layers of an array are placed side by side.
    pub size_px: [u32; 2],
    texels: Texels,
}

#[derive(Clone, Debug)]
enum Texels {
    /// Floating-point channels, one plane for each.
    Numbers(Vec<Vec<f32>>),
    /// Reversed depth: nearer is greater, and 0 is infinitely far.
    Depth(Vec<f32>),
    /// Integer ids, for example of surface patches.
    Ids(Vec<u32>),
}

/// Why an image cannot be shown.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ShowError {
    /// No pass of the frame reads or writes an image of this name.
    #[error(
        "--show {}: the frame has no such image{}; available: {}",
        shown(name), did_you_mean(name, known.iter().copied()), known.join(", ")
    )]
    Unknown {
        /// The name, as given.
        name: String,
        /// Names of the available images.
        known: Vec<&'static str>,
    },
    /// The texture format is not supported.
    #[error("--show {name}: images in the format {format:?} cannot be shown")]
    Format {
        /// Name of the image.
        name: &'static str,
        /// Texture format of the image.
        format: Format,
    },
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Returns the images that passes read or write, by name, in the order of first use. If two have the same name, the
/// last used one is returned.
pub(crate) fn pictures(trace: &[PassTrace]) -> Vec<(&'static str, &wgpu::Texture)> {
    let mut pictures: Vec<(&'static str, &wgpu::Texture)> = Vec::new();
    for used in trace.iter().flat_map(|pass| pass.reads.iter().chain(&pass.writes)) {
        let Some(texture) = &used.texture else { continue };
        match pictures.iter_mut().find(|(name, _)| *name == used.name) {
            Some(known) => known.1 = texture,
            None => pictures.push((used.name, texture)),
        }
    }
    pictures
}

/// Returns the images that passes read or write as a list: by group, each with a sentence that says what it shows.
pub(crate) fn listing(trace: &[PassTrace]) -> String {
    let used = trace.iter().flat_map(|pass| pass.reads.iter().chain(&pass.writes));
    // Pictures of one texel are placeholders for pictures that a style lacks.
    let is_picture = |texture: &wgpu::Texture| [texture.width(), texture.height()] != [1, 1];
    let used = used.filter(|used| used.texture.as_ref().is_some_and(is_picture));
    let all: BTreeSet<(Group, &str, &str)> =
        used.filter_map(|used| used.content.map(|content| (content.group, used.name, content.sentence))).collect();
    let width = all.iter().map(|(_, name, _)| name.len()).max().unwrap_or_default();
    let mut lines = Vec::new();
    let mut before = None;
    for (group, name, sentence) in all {
        if before.replace(group) != Some(group) {
            lines.push(format!("{}:", group.heading()));
        }
        lines.push(format!("  {name:width$}  {sentence}"));
    }
    lines.join("\n")
}

/// Reads the image `name` of the last frame's trace; a hyphen in the name matches a space. Of an array, as many layers
/// are read as fit into `max_px`, and at least one.
///
/// # Errors
/// [`ShowError`].
pub(crate) fn read(gpu: &Gpu, trace: &[PassTrace], name: &str, max_px: [u32; 2]) -> Result<ShownPicture, ShowError> {
    let pictures = pictures(trace);
    let wanted = name.replace('-', " ");
    let Some(&(name, texture)) = pictures.iter().find(|(known, _)| known.replace('-', " ") == wanted) else {
        let known = pictures.iter().map(|(known, _)| *known).collect();
        return Err(ShowError::Unknown { name: name.to_owned(), known });
    };
    let layer_px = [texture.width(), texture.height()];
    let [columns, rows] = [0, 1].map(|i| (max_px[i] / layer_px[i]).max(1));
    let layers = texture.depth_or_array_layers().min(columns.saturating_mul(rows));
    let columns = columns.min(layers);
    let size_px = [columns * layer_px[0], layers.div_ceil(columns) * layer_px[1]];
    let texel = texture.format().block_copy_size(Some(readback::aspect(texture))).unwrap_or(4) as usize;
    let (row_bytes, layer_row_bytes) = (size_px[0] as usize * texel, layer_px[0] as usize * texel);
    let mut bytes = vec![0; row_bytes * size_px[1] as usize];
    for layer in 0..layers {
        let rows = readback::read_layer(gpu, texture, layer, [0, 0], layer_px)?;
        let first = (layer / columns * layer_px[1]) as usize * row_bytes + (layer % columns) as usize * layer_row_bytes;
        for (y, row) in rows.chunks_exact(layer_row_bytes).enumerate() {
            bytes[first + y * row_bytes..][..layer_row_bytes].copy_from_slice(row);
        }
    }
    let format = texture.format();
    of_bytes(name, format, size_px, &bytes).ok_or(ShowError::Format { name, format })
}

/// Returns the image `name` of a texture whose texels have been read; `None` if its format is not supported.
pub(crate) fn of_bytes(name: &str, format: Format, size_px: [u32; 2], bytes: &[u8]) -> Option<ShownPicture> {
    let texels = if seen::holds_normals(name) { Some(normals(format, bytes)) } else { texels(format, bytes) };
    Some(ShownPicture { size_px, texels: texels? })
}

/// Returns one plane of numbers for each channel of texels; `None` for ids, depth and unsupported formats.
#[cfg(feature = "window")]
pub(crate) fn planes(format: Format, bytes: &[u8]) -> Option<Vec<Vec<f32>>> {
    match texels(format, bytes)? {
        Texels::Numbers(planes) => Some(planes),
        Texels::Ids(_) | Texels::Depth(_) => None,
    }
}

/// Converts the bytes of a 16-bit float.
fn from_half(bytes: &[u8]) -> f32 {
    super::aov::f32_from_f16(u16::from_le_bytes([bytes[0], bytes[1]]))
}

fn from_float(bytes: &[u8]) -> f32 {
    f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

fn from_part(bytes: &[u8]) -> f32 {
    f32::from(bytes[0]) / 255.0
}

/// Converts words of normals, and words of their lightness if the format has two, to four channels.
fn normals(format: Format, bytes: &[u8]) -> Texels {
    let words: Vec<u32> = bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let per_texel = if format == Format::Rg32Uint { 2 } else { 1 };
    let texels = words.chunks_exact(per_texel);
    let texels = texels.map(|texel| seen::surface_of([texel[0], texel.get(1).copied().unwrap_or_default()]));
    let texels: Vec<[f32; 4]> = texels.collect();
    Texels::Numbers((0..4).map(|channel| texels.iter().map(|texel| texel[channel]).collect()).collect())
}

/// Converts the bytes of one channel to a number.
type Number = fn(&[u8]) -> f32;

/// Converts the bytes of an image to channels; `None` for an unsupported format.
fn texels(format: Format, bytes: &[u8]) -> Option<Texels> {
    // Number of channels, bytes of each, and their conversion.
    let (channels, sample, number): (usize, usize, Number) = match format {
        Format::R32Uint => {
            let ids = bytes.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]]));
            return Some(Texels::Ids(ids.collect()));
        }
        Format::Depth32Float => return Some(Texels::Depth(bytes.chunks_exact(4).map(from_float).collect())),
        Format::R32Float => (1, 4, from_float),
        Format::Rg32Float => (2, 4, from_float),
        Format::Rgba32Float => (4, 4, from_float),
        Format::R16Float => (1, 2, from_half),
        Format::Rg16Float => (2, 2, from_half),
        Format::Rgba16Float => (4, 2, from_half),
        Format::R8Unorm => (1, 1, from_part),
        Format::R8Uint => (1, 1, |bytes| f32::from(bytes[0])),
        Format::Rg8Unorm => (2, 1, from_part),
        Format::Rgba8Unorm => (4, 1, from_part),
        _ => return None,
    };
    let plane = |channel: usize| {
        bytes.chunks_exact(channels * sample).map(|texel| number(&texel[channel * sample..][..sample])).collect()
    };
    Some(Texels::Numbers((0..channels).map(plane).collect()))
}

impl ShownPicture {
    /// Returns all channels without loss: `Y` for one, `R`, `G`, `B`, `A` for several, `id` for integer ids.
    pub(crate) fn channels(self) -> Vec<Channel> {
        let named = |name: &str, samples| Channel { name: name.to_owned(), samples };
        match self.texels {
            Texels::Ids(ids) => vec![named("id", Samples::U32(ids))],
            Texels::Depth(depth) => vec![named("Y", Samples::F32(depth))],
            Texels::Numbers(planes) => {
                let names: &[&str] = if planes.len() == 1 { &["Y"] } else { &["R", "G", "B", "A"] };
                names.iter().zip(planes).map(|(name, plane)| named(name, Samples::F32(plane))).collect()
            }
        }
    }

    /// Returns opaque RGBA bytes for a PNG. One channel is shown as grey, several as red, green and blue; four channels
    /// within 0 to 1 are taken as linear colour. Values within 0 to 1 are shown as they are, values within −1 to 1 with
    /// 0 as middle grey, all others scaled from the smallest to the largest. Depth is scaled by its logarithm. Each id
    /// has its own colour, and id 0 is black. NaN is magenta.
    pub(crate) fn rgba8(&self) -> Vec<u8> {
        let pixels = self.size_px.map(|side| side as usize).into_iter().product();
        let grey = |value: f32| {
            if value.is_nan() { [255, 0, 255] } else { [(value.clamp(0.0, 1.0) * 255.0).round() as u8; 3] }
        };
        let picture: Vec<[u8; 3]> = match &self.texels {
            Texels::Ids(ids) => ids.iter().map(|id| color_of(*id)).collect(),
            Texels::Depth(depth) => {
                let logarithms: Vec<f32> = depth.iter().map(|depth| depth.ln()).collect();
                let scale = Scale::of(&[&logarithms]);
                logarithms.iter().map(|value| grey(scale.of_part(*value))).collect()
            }
            Texels::Numbers(planes) if planes.len() == 1 => {
                let scale = Scale::of(&[&planes[0]]);
                planes[0].iter().map(|value| grey(scale.of_part(*value))).collect()
            }
            Texels::Numbers(planes) => {
                let colors: Vec<&[f32]> = planes.iter().take(3).map(Vec::as_slice).collect();
                let scale = Scale::of(&colors);
                let is_color = planes.len() == 4 && scale == Scale::NONE;
                let channel = |i: usize, at: usize| match colors.get(i).map(|plane| scale.of_part(plane[at])) {
                    Some(value) if is_color => grey(srgb_from_linear(value)),
                    Some(value) => grey(value),
                    None => [0; 3],
                };
                (0..pixels).into_par_iter().map(|at| [0, 1, 2].map(|i| channel(i, at)[i])).collect()
            }
        };
        picture.into_iter().flat_map(|[r, g, b]| [r, g, b, 255]).collect()
    }
}

/// The linear mapping of values to 0 (black) to 1 (white).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    least: f32,
    span: f32,
}

impl Scale {
    const NONE: Self = Self { least: 0.0, span: 1.0 };

    /// Chooses the mapping from the range of the finite values.
    fn of(planes: &[&[f32]]) -> Self {
        let finite = planes.iter().flat_map(|plane| plane.iter().copied()).filter(|value| value.is_finite());
        let (least, most) =
            finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
        match () {
            () if least > most || (least >= 0.0 && most <= 1.0) => Self::NONE,
            () if least >= -1.0 && most <= 1.0 => Self { least: -1.0, span: 2.0 },
            () => Self { least, span: (most - least).max(f32::MIN_POSITIVE) },
        }
    }

    fn of_part(self, value: f32) -> f32 {
        (value - self.least) / self.span
    }
}

/// Returns a colour that distinguishes an id from neighbouring ids; 0 is black.
fn color_of(id: u32) -> [u8; 3] {
    if id == 0 {
        return [0; 3];
    }
    // The mixer of lowbias32 (Wellons 2018).
    let mut hash = id;
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x7feb_352d);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x846c_a68b);
    hash ^= hash >> 16;
    let [r, g, b, _] = hash.to_le_bytes();
    [r, g, b].map(|channel| 64 + channel / 4 * 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(planes: Vec<Vec<f32>>) -> ShownPicture {
        ShownPicture { size_px: [planes[0].len() as u32, 1], texels: Texels::Numbers(planes) }
    }

    #[test]
    fn numbers_are_scaled_by_what_they_are() {
        let grey = |values: &[f32]| shown(vec![values.to_vec()]).rgba8().chunks(4).map(|p| p[0]).collect::<Vec<u8>>();
        assert_eq!(grey(&[0.0, 0.5, 1.0]), [0, 128, 255]);
        assert_eq!(grey(&[-1.0, 0.0, 0.5]), [0, 128, 191]);
        assert_eq!(grey(&[100.0, 150.0, 300.0]), [0, 64, 255]);
        // The infinite distance of the sky does not affect the scale.
        assert_eq!(grey(&[100.0, 300.0, f32::INFINITY]), [0, 255, 255]);
        assert_eq!(shown(vec![vec![f32::NAN]]).rgba8(), [255, 0, 255, 255]);
        // Colour is encoded as sRGB, directions are not.
        let [half, one] = [vec![0.5], vec![1.0]];
        assert_eq!(shown(vec![half.clone(), one.clone(), vec![0.0], one.clone()]).rgba8(), [188, 255, 0, 255]);
        assert_eq!(shown(vec![half.clone(), one, vec![-1.0], half]).rgba8(), [191, 255, 0, 255]);
    }

    #[test]
    fn numbers_of_things_are_told_apart() {
        let colors: BTreeSet<[u8; 3]> = (0..1000).map(color_of).collect();
        assert!(colors.len() > 990 && color_of(0) == [0; 3]);
        assert!((1..1000).all(|id| color_of(id).iter().all(|channel| *channel >= 64)));
    }

    #[test]
    fn formats_are_read_by_their_samples() {
        let numbers = |format, bytes: &[u8]| match texels(format, bytes) {
            Some(Texels::Numbers(planes)) => planes,
            other => panic!("{format:?}: {other:?}"),
        };
        let floats: Vec<u8> = [1.5_f32, -2.0, 3.0, 4.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        assert_eq!(numbers(Format::Rg32Float, &floats), [[1.5, 3.0], [-2.0, 4.0]]);
        assert_eq!(numbers(Format::R16Float, &[0, 0x3c, 0, 0xc0]), [[1.0, -2.0]]);
        assert_eq!(numbers(Format::Rg8Unorm, &[255, 0]), [[1.0], [0.0]]);
        assert!(texels(Format::Bc1RgbaUnorm, &floats).is_none());
    }
}
