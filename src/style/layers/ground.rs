//! Marks of what the ground is made of. See `shaders/layers/ground.wgsl`.
//!
//! Why: `docs/decisions/ground.md`.

use super::{Channels, Fading, Ink, InkPass, LandOfPass, LayerBehaviour, Trace};
use crate::gpu::target::{Group, TargetKind};
use crate::gpu::wgsl::layers::ground::{GroundRules, PERIOD_M};
use crate::style::Color;
use crate::style::parameters::{Range, parameters};

/// Ink of marks of the ground, 0 to 1.
pub(crate) const GROUND_INK: TargetKind =
    TargetKind::storage("ground ink", wgpu::TextureFormat::R32Float, Group::Ink.shows("Ink of grass and stones"));

parameters! {
    /// Small marks of what the ground near the eye is made of: tufts of grass and stones, by slope and height.
    pub struct Ground {
        /// Colour of the marks.
        ink called "Ink colour": Color = Color::default();
        /// Approximate height of a tuft of grass in the middle distance; stones are in proportion, and near marks are larger.
        size_px called "Size of marks": f32 = 9.0 => Range::Within(3.0, 48.0);
        /// Mean distance between places for marks; it grows toward the eye with the size of marks.
        spacing_px called "Mark spacing": f32 = 14.0 => Range::Within(8.0, 128.0);
        /// Width of the lines of a mark.
        line_px called "Line width": f32 = 0.9 => Range::Within(0.2, 8.0);
        /// Size of a pixel on the ground, in metres, at which the last marks disappear; 0 draws none.
        farthest_m called "Farthest pixel size": f32 = 9.0 => Range::Within(0.0, 1000.0), zero "none";
        /// Fraction of the possible places that have a mark in the light.
        lit called "Marks in the light": f32 = 0.4 => Range::Within(0.0, 1.0);
        /// Fraction of the possible places that have a mark where the tone is darkest.
        dark called "Marks in the dark": f32 = 0.95 => Range::Within(0.0, 1.0);
        /// Slope from which on stones replace grass.
        stones_deg called "Stones from slope": f32 = 26.0 => Range::Within(0.0, 90.0);
        /// Slope from which on there is rock, which has no marks.
        rock_deg called "Rock from slope": f32 = 33.0 => Range::Within(0.0, 90.0);
        /// True height above which stones replace grass.
        grass_m called "Highest grass": f32 = 2300.0 => Range::Within(-500.0, 10_000.0);
        /// True height above which snow covers grass and stones.
        snow_m called "Snow from height": f32 = 3000.0 => Range::Within(-500.0, 10_000.0);
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.0 => Range::Within(0.0, 1.0);
    }
}

impl LayerBehaviour for Ground {
    fn inks(&self) -> Vec<Ink> {
        vec![Ink {
            id: "ground",
            label: "Grass and stones".to_owned(),
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: false },
            makes_tone: false,
            is_main: false,
            trace: Trace::Picture,
        }]
    }

    fn pass(&self, LandOfPass { origin_m, exaggeration, .. }: LandOfPass) -> Option<InkPass> {
        let rules = GroundRules {
            phase_m: [origin_m.x, origin_m.y].map(|along_m| along_m.rem_euclid(f64::from(PERIOD_M)) as f32),
            size_px: self.size_px,
            spacing_px: self.spacing_px,
            line_px: self.line_px,
            farthest_m: self.farthest_m,
            lit: self.lit,
            dark: self.dark - self.lit,
            stones: self.stones_deg.to_radians().sin(),
            rock: self.rock_deg.to_radians().sin(),
            origin_height_m: origin_m.z as f32,
            exaggeration: exaggeration as f32,
            grass_m: self.grass_m,
            snow_m: self.snow_m,
        };
        Some(InkPass { shader: "layers/ground", rules: bytemuck::bytes_of(&rules).to_vec(), ink: &GROUND_INK })
    }

    fn scale_marks(&mut self, factor: f32) {
        // A print has the marks of the screen: its pixels are smaller on the ground, too.
        self.farthest_m /= factor;
    }

    fn summary(&self) -> Option<String> {
        Some("grass and stones".to_owned())
    }
}
