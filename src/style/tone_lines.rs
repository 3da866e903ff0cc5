//! Lines from tone of a style.

use super::Color;
use super::parameters::{Range, choices, parameters};
use crate::gpu::wgsl::lines::tone::blur::REACH;
use crate::gpu::wgsl::lines::tone::tone_image::{LEAST_WIDTH, MOST_WIDTH};

parameters! {
    /// Lines from tone (Lee, Markosian, Lee and Hughes 2007): dark lines along dark valleys of the shaded picture,
    /// highlight lines along its bright ridges, and both along its tone edges.
    pub struct ToneLines {
        /// Where the light stands whose tones have the lines.
        light: ToneLight = ToneLight::Sun;
        /// Where a light beside the eye stands, clockwise from behind it; below 0 it stands on the left.
        side_deg: f32 = -60.0 => Range::Within(-180.0, 180.0);
        /// How high above the middle of the view a light beside the eye stands.
        rise_deg: f32 = 35.0 => Range::Within(-90.0, 90.0);
        /// How much light falls on the land's form (`light.form_px`) in place of its own normals, for lines.
        abstracted: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Strength of specular highlights, which have highlight lines of their own; 0 is none.
        specular: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Exponent of specular highlights; the greater, the smaller they are.
        shininess: f32 = 20.0 => Range::Within(1.0, 512.0);
        /// Whether each pixel looks for lines; else blocks of 2 × 2 do where lines are wide, at a third of the cost.
        exact: bool = false;
        /// Width of lines, which is also the size of the shapes that are lines.
        width_px: f32 = 3.0 => Range::Within(1.0, 16.0);
        /// How much wider near lines are than far ones.
        depth_width: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Standard deviation of the blur of the tones, in line widths.
        blur: f32 = 0.3 => Range::Within(0.0, 1.0);
        /// Whether the sky counts as white, so that skylines are tone edges.
        skyline: bool = true;
        /// The part of the way to a line that each step of the search goes: 0 draws all tone edges, 1 none.
        beta: f32 = 0.2 => Range::Within(0.0, 1.0);
        /// Whether tone edges are drawn as far as `beta` lets them; without them it is 1.
        edges: bool = true;
        /// Whether dark lines are drawn.
        dark: bool = true;
        /// Whether highlight lines are drawn.
        highlights: bool = true;
        /// Two curvatures of tone, per square of half a line width: a dark line begins at the first, and is full at the second.
        dark_ramp: [f32; 2] = [0.01, 0.04] => Range::Rising(0.0);
        /// The same for highlight lines.
        highlight_ramp: [f32; 2] = [0.02, 0.06] => Range::Rising(0.0);
        /// The part of half a line's width in which it fades; 0 is crisp.
        softness: f32 = 0.5 => Range::Within(0.0, 1.0);
        /// How much lighter dark lines are in light tones, and highlight lines fainter in dark ones.
        counterchange: f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Shorter lines fade out, because they look like crumbs; 0 keeps all.
        shortest_px: f32 = 16.0 => Range::Within(0.0, 256.0);
        /// How round what is drawn may be, as the lesser curvature in parts of the greater; 1 keeps spots.
        roundest: f32 = 1.0 => Range::Within(0.05, 1.0);
        /// Colour of dark lines.
        ink: Color = Color::default();
        /// Colour of highlight lines.
        highlight_ink: Color = Color::WHITE;
        /// What is left of lines in full haze.
        faintest: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How many times farther than tones lines reach into the haze.
        reach: f32 = 1.0 => Range::Above(0.0);
    }
}

choices! {
    /// Where the light of tone lines stands.
    pub enum ToneLight {
        /// Where the scene's sun is.
        Sun,
        /// At the eye.
        Head,
        /// Beside the eye, as `side_deg` and `rise_deg` say.
        Side,
    }
}

impl ToneLines {
    /// The widest lines that there are.
    pub fn widest_px(&self) -> f32 {
        (self.width_px * (1.0 + (MOST_WIDTH - 1.0) * self.depth_width)).max(1.0)
    }

    /// The narrowest lines that there are.
    pub fn narrowest_px(&self) -> f32 {
        (self.width_px * (1.0 - (1.0 - LEAST_WIDTH) * self.depth_width)).max(1.0)
    }

    /// How far around a line its pixels look: the blur, the search, the samples of a fit, and the walk along the line.
    pub fn reach_px(&self) -> u32 {
        // From the search's last place to the corners of its samples.
        const FIT: f32 = std::f32::consts::FRAC_1_SQRT_2;
        let of_widths = self.widest_px() * (REACH * self.blur + 0.5 + FIT);
        (of_widths + self.shortest_px).ceil() as u32 + 8
    }

    /// The part of the way that a step of the search goes.
    pub fn step_part(&self) -> f32 {
        if self.edges { self.beta } else { 1.0 }
    }
}
