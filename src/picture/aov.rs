//! The AOV channels of an EXR: one sample at the centre of each pixel, without anti-aliasing.
//!
//! Channels have hachure's own names, or those that compositors expect ([`Names`]): `Z`, `P.X`, `P.Y`, `P.Z`, `N.X`,
//! `N.Y` and `N.Z`, as Arnold and pbrt write them. `Z` and `N` have the same values as `depth` and `normal`. `P` is a
//! position in the world, while `position` is relative to the camera, where 32 bits are more precise.

use std::fmt;
use std::str::FromStr;

use super::Window;
use crate::file::exr::{SampleKind, Samples};
use crate::file::message::{did_you_mean, shown};
use crate::frame::Renderer;
use crate::gpu::target::TargetKind;
use crate::gpu::{Gpu, GpuError};
use crate::lines::detector::ERRORS;
use crate::lines::strokes::stroke::STROKE_IDS;
use crate::lines::threshold::LINE;
use crate::style::layers::Channels;
use crate::style::{Detector, Style};
use crate::surface::motion::MOTION;
use crate::surface::{DISTANCE, SURFACE_ID};
use crate::tones::TONE;

/// Naming scheme of channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Names {
    /// Hachure's own names: `depth.V`, `position.X`, `normal.X`.
    #[default]
    Hachure,
    /// The names that compositors expect: `Z`, `P.X`, `N.X`. Channels without such a name keep hachure's.
    Standard,
}

impl Names {
    const ALL: [(&'static str, Self); 2] = [("hachure", Self::Hachure), ("standard", Self::Standard)];
}

impl FromStr for Names {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|(name, _)| *name == text).map(|(_, names)| *names);
        found.ok_or_else(|| "it must be hachure or standard".to_owned())
    }
}

impl fmt::Display for Names {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(Self::ALL.iter().find(|(_, names)| names == self).map_or("", |(name, _)| name))
    }
}

/// A channel of an EXR.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Name in the EXR.
    pub name: String,
    /// Source of its values.
    pub source: PlaneSource,
}

/// Source of a channel's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneSource {
    /// Distance along the view axis in metres; sky is +inf.
    Depth,
    /// Position relative to the camera in metres: x, y or z; sky is 0.
    Position(usize),
    /// Position in the world in metres: x east, y north, z up; sky is 0.
    WorldPosition(usize),
    /// Component of the unit normal in world axes; sky is 0.
    Normal(usize),
    /// Id of the surface patch; sky is 0.
    SurfaceId,
    /// Motion in pixels from the previous frame to this one: x right, y down.
    Motion(usize),
    /// Error E(p) of the LSA contours.
    LsaError,
    /// LSA line after density filter and ramp, 0 to 1.
    LsaLine,
    /// Number of a stroke, stable from frame to frame; 0 is none.
    Strokes,
    /// Requested tone, 0 black to 1 white.
    Tone,
    /// Tone after hatching, rows of hachures and cut lines, 0 black to 1 white.
    Hatch,
    /// Ink of the layer of the style with this index, in its first channel, 0 to 1. It is not a channel of `--aov`.
    Ink(usize),
}

/// Names of the channels of `--aov`.
pub(crate) const CHANNELS: [&str; 9] =
    ["depth", "position", "normal", "surface", "motion", "lsa", "strokes", "tone", "hatch"];

/// Why a list of channels cannot be written.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum AovError {
    /// A name in the list is not a channel.
    #[error(
        "--aov {}: no such channel; available: {}{}", shown(name), CHANNELS.join(", "), did_you_mean(name, CHANNELS)
    )]
    Unknown {
        /// The name, as given.
        name: String,
    },
    /// The style draws no LSA contours.
    #[error("--aov lsa: the style {} draws no LSA contours; choose one that does, such as ink", shown(style))]
    NoLsa {
        /// Name of the style.
        style: String,
    },
}

/// Returns the channels of a comma-separated list, with hachure's own names.
///
/// # Errors
/// [`AovError`].
pub fn planes(list: &str, style: &Style) -> Result<Vec<Plane>, AovError> {
    planes_named(list, Names::Hachure, style)
}

/// Returns the channels of a comma-separated list, with the given naming scheme.
///
/// # Errors
/// [`AovError`].
pub(crate) fn planes_named(list: &str, names: Names, style: &Style) -> Result<Vec<Plane>, AovError> {
    let mut planes = Vec::new();
    let is_standard = names == Names::Standard;
    for name in list.split(',').map(str::trim).filter(|name| !name.is_empty()) {
        let mut add = |name: &str, source| {
            let plane = Plane { name: name.to_owned(), source };
            if !planes.contains(&plane) {
                planes.push(plane);
            }
        };
        let xyz = ["X", "Y", "Z"];
        match name {
            "depth" if is_standard => add("Z", PlaneSource::Depth),
            "position" if is_standard => {
                (0..3).for_each(|i| add(&format!("P.{}", xyz[i]), PlaneSource::WorldPosition(i)));
            }
            "normal" if is_standard => (0..3).for_each(|i| add(&format!("N.{}", xyz[i]), PlaneSource::Normal(i))),
            "depth" => add("depth.V", PlaneSource::Depth),
            "position" => (0..3).for_each(|i| add(&format!("position.{}", xyz[i]), PlaneSource::Position(i))),
            "normal" => (0..3).for_each(|i| add(&format!("normal.{}", xyz[i]), PlaneSource::Normal(i))),
            "surface" => add("surface.id", PlaneSource::SurfaceId),
            "motion" => (0..2).for_each(|i| add(&format!("motion.{}", xyz[i]), PlaneSource::Motion(i))),
            "lsa" => {
                if style.lines().is_none_or(|lines| lines.detector != Detector::Lsa) {
                    return Err(AovError::NoLsa { style: style.name.clone() });
                }
                add("lsa.error", PlaneSource::LsaError);
                add("lsa.line", PlaneSource::LsaLine);
            }
            "strokes" => add("strokes.id", PlaneSource::Strokes),
            "tone" => add("tone.V", PlaneSource::Tone),
            // Without marks that make tone, the tone does not change.
            "hatch" if style.inks().iter().any(|own| own.ink.makes_tone) => add("hatch.V", PlaneSource::Hatch),
            "hatch" => add("hatch.V", PlaneSource::Tone),
            _ => return Err(AovError::Unknown { name: name.to_owned() }),
        }
    }
    Ok(planes)
}

impl PlaneSource {
    /// Returns the type of the samples.
    pub(crate) fn kind(self) -> SampleKind {
        match self {
            Self::SurfaceId | Self::Strokes => SampleKind::U32,
            _ => SampleKind::F32,
        }
    }

    pub(super) fn samples(self, pixels: usize) -> Samples {
        match self.kind() {
            SampleKind::U32 => Samples::U32(vec![0; pixels]),
            SampleKind::F32 => Samples::F32(vec![0.0; pixels]),
        }
    }
}

/// Reads the channels of a tile into a band.
pub(super) fn read_planes(
    gpu: &Gpu,
    renderer: &Renderer,
    style: &Style,
    window: &Window,
    planes: &[Plane],
    samples: &mut [Samples],
) -> Result<(), GpuError> {
    for (plane, samples) in planes.iter().zip(samples) {
        match samples {
            Samples::U32(ids) => {
                if plane.source != PlaneSource::Strokes {
                    scatter(gpu, renderer, window, &SURFACE_ID, |i, id: u32| ids[i] = id)?;
                } else if let Some(strokes) = renderer.eye_strokes(window.eye) {
                    // The target holds numbers of stroke samples.
                    let (_, list) = strokes.samples().read(gpu)?;
                    let stroke = |sample: u32| list.get(sample.wrapping_sub(1) as usize).map_or(0, |own| own.stroke);
                    scatter(gpu, renderer, window, &STROKE_IDS, |i, sample: u32| ids[i] = stroke(sample))?;
                }
            }
            Samples::F32(values) => read_floats(gpu, renderer, style, window, plane.source, values)?,
        }
    }
    Ok(())
}

/// Reads the texels of a target, if the frame has written it.
fn scatter<T: bytemuck::Pod>(
    gpu: &Gpu,
    renderer: &Renderer,
    window: &Window,
    kind: &TargetKind,
    put: impl FnMut(usize, T),
) -> Result<(), GpuError> {
    renderer.eye_target(window.eye, kind).map_or(Ok(()), |target| window.scatter(gpu, target, put))
}

fn read_floats(
    gpu: &Gpu,
    renderer: &Renderer,
    style: &Style,
    window: &Window,
    source: PlaneSource,
    values: &mut [f32],
) -> Result<(), GpuError> {
    match source {
        PlaneSource::Depth => scatter(gpu, renderer, window, &DISTANCE, |i, along_m: f32| {
            values[i] = if along_m > 0.0 { along_m } else { f32::INFINITY };
        }),
        PlaneSource::Position(axis) => {
            let places = renderer.places(gpu, window.eye, window.inset, window.size_px)?;
            window.place(&places.unwrap_or_default(), |i, at| values[i] = at[axis]);
            Ok(())
        }
        PlaneSource::WorldPosition(axis) => {
            let places = renderer.places(gpu, window.eye, window.inset, window.size_px)?;
            window.place(&places.unwrap_or_default(), |i, at| {
                // The sum is rounded once. Sky has no position.
                values[i] = if at[3] > 0.0 { (window.origin_m[axis] + f64::from(at[axis])) as f32 } else { 0.0 };
            });
            Ok(())
        }
        PlaneSource::Normal(axis) => {
            let normals = renderer.normals(gpu, window.eye, window.inset, window.size_px)?;
            window.place(&normals.unwrap_or_default(), |i, n| values[i] = n[axis]);
            Ok(())
        }
        PlaneSource::Motion(axis) => scatter(gpu, renderer, window, &MOTION, |i, v: [f32; 2]| values[i] = v[axis]),
        PlaneSource::LsaError => scatter(gpu, renderer, window, &ERRORS, |i, errors: [u16; 4]| {
            values[i] = errors.map(f32_from_f16).into_iter().fold(0.0, f32::max);
        }),
        PlaneSource::LsaLine => scatter(gpu, renderer, window, &LINE, |i, line: f32| values[i] = line),
        PlaneSource::Hatch => read_marks(gpu, renderer, style, window, values),
        PlaneSource::Ink(layer) => {
            let Some(target) = renderer.ink_target(window.eye, layer) else { return Ok(()) };
            let texels = super::ink::channels(gpu, target, window.inset, window.size_px)?;
            window.place(&texels, |i, texel| values[i] = texel[0]);
            Ok(())
        }
        PlaneSource::Tone => {
            scatter(gpu, renderer, window, &TONE, |i, tone: [u16; 4]| values[i] = f32_from_f16(tone[3]))
        }
        PlaneSource::SurfaceId | PlaneSource::Strokes => Ok(()),
    }
}

/// Reads the fraction of white that is left by all ink layers that make tone: the darkest of them counts, as in
/// `shaders/composite/composite.wgsl`.
fn read_marks(
    gpu: &Gpu,
    renderer: &Renderer,
    style: &Style,
    window: &Window,
    values: &mut [f32],
) -> Result<(), GpuError> {
    let mut darkest = vec![0.0_f32; values.len()];
    for own in style.inks().iter().filter(|own| own.ink.makes_tone) {
        let Some(target) = own.layer.and_then(|index| renderer.ink_target(window.eye, index)) else { continue };
        let texels = super::ink::channels(gpu, target, window.inset, window.size_px)?;
        window.place(&texels, |i, texel| {
            let ink = match own.ink.channels {
                Channels::One(channel) => texel[channel],
                Channels::Crossed(_) => 1.0 - texel[..3].iter().map(|ink| 1.0 - ink).product::<f32>(),
            };
            darkest[i] = darkest[i].max(ink);
        });
    }
    // Only the pixels of this window change.
    scatter(gpu, renderer, window, &TONE, |i, _: [u16; 4]| values[i] = 1.0 - darkest[i])
}

/// Converts a 16-bit float, without loss.
pub(super) fn f32_from_f16(bits: u16) -> f32 {
    half::f16::from_bits(bits).to_f32()
}
