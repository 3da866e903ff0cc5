//! The channels of an EXR beside its colour: one sample at the centre of each pixel, which no anti-aliasing touches.
//!
//! They have hachure's own names, or those that compositors look for ([`Names`]): `Z`, `P.X`, `P.Y`, `P.Z`, `N.X`,
//! `N.Y` and `N.Z`, as Arnold and pbrt write them. `Z` and `N` have the same values under both. `P` is a place in the
//! world, and `position` counts from the camera, where 32 bits are finer.

use std::fmt;
use std::str::FromStr;

use super::Window;
use crate::file::exr::{SampleKind, Samples};
use crate::file::message::shown;
use crate::frame::Renderer;
use crate::gpu::target::TargetKind;
use crate::gpu::{Gpu, GpuError};
use crate::lines::detector::ERRORS;
use crate::lines::strokes::stroke::STROKE_IDS;
use crate::lines::threshold::LINE;
use crate::style::{Detector, Style};
use crate::surface::SURFACE_ID;
use crate::surface::motion::MOTION;
use crate::surface::{NORMAL, POSITION};
use crate::tones::TONE;
use crate::tones::balance::MARKS;

/// What channels are called.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Names {
    /// By what they hold: `depth.V`, `position.X`, `normal.X`.
    #[default]
    Hachure,
    /// As compositors know them: `Z`, `P.X`, `N.X`. What has no such name keeps its own.
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

/// One channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// As in the EXR.
    pub name: String,
    /// Where it comes from.
    pub source: PlaneSource,
}

/// Where a channel comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneSource {
    /// Distance along the view axis in metres; sky is +inf.
    Depth,
    /// Relative to the camera in metres: x, y or z; sky is 0.
    Position(usize),
    /// A place in the world in metres: x east, y north, z up; sky is 0.
    WorldPosition(usize),
    /// Unit, in the world; sky is 0.
    Normal(usize),
    /// Which patch; sky is 0.
    SurfaceId,
    /// Pixels from the previous frame to this one: x right, y down.
    Motion(usize),
    /// E(p) of the LSA contours.
    LsaError,
    /// After filter and ramp.
    LsaLine,
    /// A stroke's number, which lasts from frame to frame; 0 is none.
    Strokes,
    /// Asked for: 0 black to 1 white.
    Tone,
    /// The same after the marks.
    Hatch,
}

/// A list of channels that cannot be had.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum AovError {
    /// Not a name.
    #[error(
        "--aov {}: no such channel; there is depth, position, normal, surface, motion, lsa, strokes, tone, hatch",
        shown(name)
    )]
    Unknown {
        /// As given.
        name: String,
    },
    /// The style does not make it.
    #[error("--aov lsa: the style {} draws no LSA contours; ink does", shown(style))]
    NoLsa {
        /// The style's name.
        style: String,
    },
}

/// The channels of a comma-separated list of what there is, under hachure's own names.
///
/// # Errors
/// [`AovError`].
pub fn planes(list: &str, style: &Style) -> Result<Vec<Plane>, AovError> {
    planes_named(list, Names::Hachure, style)
}

/// The same under names of one's choice.
///
/// # Errors
/// [`AovError`].
pub fn planes_named(list: &str, names: Names, style: &Style) -> Result<Vec<Plane>, AovError> {
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
                if style.lines.as_ref().is_none_or(|lines| lines.detector != Detector::Lsa) {
                    return Err(AovError::NoLsa { style: style.name.clone() });
                }
                add("lsa.error", PlaneSource::LsaError);
                add("lsa.line", PlaneSource::LsaLine);
            }
            "strokes" => add("strokes.id", PlaneSource::Strokes),
            "tone" => add("tone.V", PlaneSource::Tone),
            // Without marks the tone after them is the tone.
            "hatch" if style.hatching.is_some() => add("hatch.V", PlaneSource::Hatch),
            "hatch" => add("hatch.V", PlaneSource::Tone),
            _ => return Err(AovError::Unknown { name: name.to_owned() }),
        }
    }
    Ok(planes)
}

impl PlaneSource {
    /// The type of its samples.
    pub fn kind(self) -> SampleKind {
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

/// Reads the planes of a part into a band.
pub(super) fn read_planes(
    gpu: &Gpu,
    renderer: &Renderer,
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
                    // The picture holds samples.
                    let (_, list) = strokes.samples().read(gpu)?;
                    let stroke = |sample: u32| list.get(sample.wrapping_sub(1) as usize).map_or(0, |own| own.stroke);
                    scatter(gpu, renderer, window, &STROKE_IDS, |i, sample: u32| ids[i] = stroke(sample))?;
                }
            }
            Samples::F32(values) => read_floats(gpu, renderer, window, plane.source, values)?,
        }
    }
    Ok(())
}

/// Reads a picture's texels, if the frame made it.
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
    window: &Window,
    source: PlaneSource,
    values: &mut [f32],
) -> Result<(), GpuError> {
    match source {
        PlaneSource::Depth => scatter(gpu, renderer, window, &POSITION, |i, at: [f32; 4]| {
            values[i] = if at[3] > 0.0 { at[3] } else { f32::INFINITY };
        }),
        PlaneSource::Position(axis) => {
            scatter(gpu, renderer, window, &POSITION, |i, at: [f32; 4]| values[i] = at[axis])
        }
        PlaneSource::WorldPosition(axis) => scatter(gpu, renderer, window, &POSITION, |i, at: [f32; 4]| {
            // Rounded once, after the sum. Sky is nowhere.
            values[i] = if at[3] > 0.0 { (window.origin_m[axis] + f64::from(at[axis])) as f32 } else { 0.0 };
        }),
        PlaneSource::Normal(axis) => scatter(gpu, renderer, window, &NORMAL, |i, n: [f32; 4]| values[i] = n[axis]),
        PlaneSource::Motion(axis) => scatter(gpu, renderer, window, &MOTION, |i, v: [f32; 2]| values[i] = v[axis]),
        PlaneSource::LsaError => scatter(gpu, renderer, window, &ERRORS, |i, errors: [u16; 4]| {
            values[i] = errors.map(f32_from_f16).into_iter().fold(0.0, f32::max);
        }),
        PlaneSource::LsaLine => scatter(gpu, renderer, window, &LINE, |i, line: f32| values[i] = line),
        PlaneSource::Hatch => scatter(gpu, renderer, window, &MARKS, |i, ink: f32| values[i] = 1.0 - ink),
        PlaneSource::Tone => {
            scatter(gpu, renderer, window, &TONE, |i, tone: [u16; 4]| values[i] = f32_from_f16(tone[3]))
        }
        PlaneSource::SurfaceId | PlaneSource::Strokes => Ok(()),
    }
}

/// A number of 16 bits, exactly.
pub(super) fn f32_from_f16(bits: u16) -> f32 {
    half::f16::from_bits(bits).to_f32()
}
