//! Lines from shading (abstracted shading). Their passes are in `src/lines/tone`.

use super::{Channels, Fading, Ink, LayerBehaviour, Margins, Trace};
use crate::gpu::wgsl::lines::tone::blur::REACH;
use crate::gpu::wgsl::lines::tone::tone_image::{MAX_WIDTH, MIN_WIDTH};
use crate::style::Color;
use crate::style::parameters::{Range, choices, parameters};

parameters! {
    /// Lines from shading (Lee, Markosian, Lee and Hughes 2007): dark lines along dark valleys of the shaded image,
    /// highlight lines along its bright ridges, and both along its tone edges.
    pub struct ToneLines {
        /// Position of the light that shades the image in which lines are found.
        light called "Light position": ToneLight = ToneLight::Sun;
        /// For `light = "side"`: azimuth of the light, clockwise from behind the eye; negative values are on the left.
        side_deg called "Side light azimuth": f32 = -60.0 => Range::Within(-180.0, 180.0);
        /// For `light = "side"`: elevation of the light above the centre of the view.
        rise_deg called "Side light elevation": f32 = 35.0 => Range::Within(-90.0, 90.0);
        /// How much the smoothed normals of the land (`light.form_px`) replace its own normals when lines are found.
        abstracted called "Smoothed normals": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Strength of specular highlights, which get their own highlight lines; 0 is none.
        specular called "Specular highlights": f32 = 0.0 => Range::Within(0.0, 1.0), zero "none";
        /// Exponent of specular highlights; larger values give smaller highlights.
        shininess: f32 = 20.0 => Range::Within(1.0, 512.0);
        /// Whether every pixel is searched for lines; otherwise wide lines are searched in 2 × 2 blocks at a third of
        /// the cost.
        exact called "Search every pixel": bool = false;
        /// Width of lines, and size of the shading features that become lines.
        width_px called "Line width": f32 = 3.0 => Range::Within(1.0, 16.0);
        /// How strongly width depends on distance; 0 is not at all, larger values make near lines wider and far ones
        /// thinner.
        depth_width called "Width by distance": f32 = 0.0 => Range::Within(0.0, 1.0), zero "none";
        /// Standard deviation of the blur of the shading, in line widths.
        blur called "Blur of shading": f32 = 0.3 => Range::Within(0.0, 1.0);
        /// Whether the sky counts as white, so that skylines become tone edges.
        skyline called "Lines along skyline": bool = true;
        /// Fraction of the way to a line that each search step goes: 0 draws all tone edges, 1 draws none.
        beta called "Search step": f32 = 0.2 => Range::Within(0.0, 1.0);
        /// Whether tone edges are drawn to the extent of `beta`; `false` acts like a `beta` of 1.
        edges called "Tone edges": bool = true;
        /// Whether dark lines are drawn.
        dark called "Dark lines": bool = true;
        /// Whether highlight lines are drawn.
        highlights called "Highlight lines": bool = true;
        /// Curvatures of tone, per square of half a line width, at which dark lines begin and at which they are full.
        dark_ramp called "Dark line thresholds": [f32; 2] = [0.01, 0.04] => Range::Rising(0.0);
        /// Curvatures of tone, in the unit of `dark_ramp`, at which highlight lines begin and at which they are full.
        highlight_ramp called "Highlight thresholds": [f32; 2] = [0.02, 0.06] => Range::Rising(0.0);
        /// Fraction of half a line's width over which its edge fades; 0 is crisp.
        softness called "Softness of edges": f32 = 0.5 => Range::Within(0.0, 1.0);
        /// How much dark lines fade in light tones, and highlight lines in dark tones.
        counterchange called "Fading by tone": f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Shorter lines fade out, because they look like speckle; 0 keeps all lines.
        shortest_px called "Shortest line": f32 = 16.0 => Range::Within(0.0, 256.0), zero "no limit";
        /// Largest ratio of the smaller to the greater curvature of a drawn feature; 1 also draws round spots.
        roundest called "Roundest feature": f32 = 1.0 => Range::Within(0.05, 1.0);
        /// Colour of dark lines.
        ink called "Dark line colour": Color = Color::default();
        /// Colour of highlight lines.
        highlight_ink called "Highlight colour": Color = Color::WHITE;
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Lines fade in haze this many times farther away than tones.
        reach called "Reach in haze": f32 = 1.0 => Range::Above(0.0), soft 8.0;
    }
}

choices! {
    /// Position of the light for lines from shading.
    pub enum ToneLight {
        /// The sun of the scene.
        Sun,
        /// A light at the eye.
        Head,
        /// A light to the side of the eye, at `side_deg` and `rise_deg`.
        Side,
    }
}

impl LayerBehaviour for ToneLines {
    fn inks(&self) -> Vec<Ink> {
        let ink = |id, label: &str, color, channel, is_main| Ink {
            id,
            label: label.to_owned(),
            color: Some(color),
            channels: Channels::One(channel),
            fading: Fading::OnSurface { faintest: self.faintest, reach: self.reach, follows_tone: false },
            makes_tone: false,
            is_main,
            trace: Trace::Picture,
        };
        vec![
            ink("tone-highlights", "Highlight lines from shading", self.highlight_ink, 1, false),
            ink("tone-lines", "Dark lines from shading", self.ink, 0, true),
        ]
    }

    fn margins(&self) -> Margins {
        Margins { margin_px: ToneLines::reach_px(self), ..Margins::default() }
    }

    fn summary(&self) -> Option<String> {
        Some("lines from shading".to_owned())
    }
}

impl ToneLines {
    /// Returns the width of the widest lines, in pixels.
    pub(crate) fn widest_px(&self) -> f32 {
        (self.width_px * (1.0 + (MAX_WIDTH - 1.0) * self.depth_width)).max(1.0)
    }

    /// Returns the width of the narrowest lines, in pixels.
    pub(crate) fn narrowest_px(&self) -> f32 {
        (self.width_px * (1.0 - (1.0 - MIN_WIDTH) * self.depth_width)).max(1.0)
    }

    /// Returns how far around a pixel its lines depend on the picture, in pixels: the sum of the blur, the search, the
    /// samples of a fit, and the walk along the line.
    pub(crate) fn reach_px(&self) -> u32 {
        // Distance from the last position of the search to the corners of the square of samples, in line widths.
        const FIT: f32 = std::f32::consts::FRAC_1_SQRT_2;
        let of_widths = self.widest_px() * (REACH * self.blur + 0.5 + FIT);
        (of_widths + self.shortest_px).ceil() as u32 + 8
    }

    /// Returns the fraction of the way to a line that a search step goes.
    pub(crate) fn step_part(&self) -> f32 {
        if self.edges { self.beta } else { 1.0 }
    }
}
