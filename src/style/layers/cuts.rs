//! Cut lines (cross-contours): lines where parallel planes cut the land. See `shaders/layers/cuts.wgsl`.
//!
//! Why: `docs/decisions/cuts.md`.

use std::path::PathBuf;

use glam::DVec3;

use super::{Channels, Fading, Ink, InkPass, LandOfPass, LayerBehaviour, RecipeSource, Trace};
use crate::gpu::target::{Group, TargetKind};
use crate::gpu::wgsl::layers::cuts::{CutFamily, CutRules};
use crate::style::parameters::{Range, parameters};
use crate::style::{Color, StyleError};

/// Ink of the families of planes, one family per channel, 0 to 1.
pub(crate) const CUT_INK: TargetKind = TargetKind::storage(
    "cut ink",
    wgpu::TextureFormat::Rgba16Float,
    Group::Ink.shows("Ink of cut lines, one family of planes in each channel"),
);

/// Period modulo which heights above a plane are computed, in metres; small enough for an f32 to resolve millimetres.
/// Distances between planes are powers of two of a metre (`family_ink` in the shader), so the period is a multiple of
/// them, unless they are above 8192 m.
const PERIOD_M: f64 = 8192.0;

/// Largest number of families of planes of a layer.
pub(super) const MAX_FAMILIES: usize = 3;

parameters! {
    /// Lines where families of parallel planes cut the land. They are evenly spaced on the picture, and wider where the
    /// tone is darker.
    pub struct Cuts {
        /// Colour of the lines.
        ink called "Ink colour": Color = Color::default();
        /// The land is smoothed to this size before it is cut, so that lines do not follow single samples.
        form_px called "Smoothing of land": f32 = 6.0 => Range::Within(1.0, 256.0);
        /// Fraction of the land that the lines cover where the tone is darkest.
        darkest called "Cover in darkest tone": f32 = 0.9 => Range::Within(0.0, 0.98);
        /// Fraction of the ink that remains in full haze; how much thinner the lines become is set by
        /// `haze.faintest_tone`.
        faintest called "Ink in full haze": f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Families of parallel planes; they are sorted by `from`.
        families: Vec<PlaneFamily> => Range::Entries(1, MAX_FAMILIES);
    }
}

parameters! {
    /// A family of parallel planes.
    pub struct PlaneFamily {
        /// Mean distance between lines on the picture.
        spacing_px called "Line spacing": f32 = 5.0 => Range::Within(2.0, 64.0);
        /// Tilt of the planes: 0 gives horizontal planes, 90 vertical ones.
        tilt_deg called "Tilt of planes": f32 = 0.0 => Range::Within(0.0, 90.0);
        /// Azimuth toward which tilted planes rise, clockwise from north.
        azimuth_deg called "Azimuth of planes": f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Land at a smaller angle to the planes has no lines; for horizontal planes that is flat land.
        level_deg called "Least angle to planes": f32 = 2.0 => Range::Within(0.1, 45.0);
        /// Darkness from which the family is drawn.
        from called "From darkness": f32 = 0.0 => Range::Within(0.0, 0.99);
    }
}

impl LayerBehaviour for Cuts {
    fn inks(&self) -> Vec<Ink> {
        vec![Ink {
            id: "cuts",
            label: "Cut lines".to_owned(),
            color: Some(self.ink),
            channels: Channels::Crossed(self.families.len()),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: true },
            makes_tone: true,
            is_main: true,
            trace: Trace::Picture,
        }]
    }

    fn pass(&self, LandOfPass { origin_m, .. }: LandOfPass) -> Option<InkPass> {
        let mut rules = CutRules {
            form_px: self.form_px,
            darkest: self.darkest,
            count: self.families.len() as u32,
            ..CutRules::default()
        };
        for (entry, family) in rules.families.iter_mut().zip(&self.families) {
            let (sin_tilt, cos_tilt) = f64::from(family.tilt_deg).to_radians().sin_cos();
            let (east, north) = f64::from(family.azimuth_deg).to_radians().sin_cos();
            // The planes rise toward the azimuth, so their normals point away from it.
            let normal = DVec3::new(-sin_tilt * east, -sin_tilt * north, cos_tilt);
            *entry = CutFamily {
                normal: normal.as_vec3().to_array(),
                phase_m: normal.dot(origin_m).rem_euclid(PERIOD_M) as f32,
                spacing_px: family.spacing_px,
                level: family.level_deg.to_radians().sin(),
                darkness_from: family.from,
                ..CutFamily::default()
            };
        }
        Some(InkPass { shader: "layers/cuts", rules: bytemuck::bytes_of(&rules).to_vec(), ink: &CUT_INK })
    }

    fn summary(&self) -> Option<String> {
        Some("cut lines".to_owned())
    }

    fn complete(&mut self, _: RecipeSource<'_>) -> Result<Vec<PathBuf>, (String, StyleError)> {
        self.sort();
        Ok(Vec::new())
    }
}

impl Cuts {
    /// Sorts the families by the darkness from which they appear.
    pub(in crate::style) fn sort(&mut self) {
        self.families.sort_by(|a, b| a.from.total_cmp(&b.from));
    }
}
