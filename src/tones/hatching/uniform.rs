//! `HatchLayer` and `Hatch` in `shaders/shared/hatch.wgsl`: the sets of marks of a style in the form that the shaders
//! read.

use bytemuck::Zeroable;

use super::axes;
use crate::gpu::wgsl::shared::hatch;
pub(crate) use crate::gpu::wgsl::shared::hatch::Hatch as HatchUniform;
pub(crate) use crate::gpu::wgsl::shared::hatch::HatchLayer as HatchLayerUniform;
use crate::style::hatching::{Direction, Hatching, MAX_SETS, MarkSet};
use crate::style::marks::{Kind, Recipe};

/// Flag: marks have no ends.
const ENDLESS: u32 = hatch::ENDLESS;
/// Flag: marks darken by growing wider.
const SWELLS: u32 = hatch::SWELLS;

/// Flag: marks are round dots that keep apart.
const DOTS: u32 = hatch::DOTS;

/// Returns length and width of a mark by the fractal rule, in pixels: a line has no end (length 0), a dot is as long as
/// wide.
fn marks_px(recipe: &Recipe) -> [f32; 2] {
    let length_px = match recipe.kind {
        Kind::Line => 0.0,
        Kind::Stipple | Kind::Halftone | Kind::Stack | Kind::Dots => recipe.width_px,
        Kind::Dash | Kind::Cross | Kind::Scribble | Kind::Dab => recipe.length_px.max(recipe.width_px),
    };
    [length_px, recipe.width_px]
}

/// Returns whether marks darken by growing wider, rather than by number.
pub(crate) fn swells(recipe: &Recipe) -> bool {
    recipe.swell >= 0.5 || recipe.kind == Kind::Halftone
}

impl HatchLayerUniform {
    fn new(set: &MarkSet, map: usize) -> Self {
        let direction = match set.direction {
            Direction::Fixed => hatch::FIXED,
            Direction::Slope => hatch::SLOPE,
            Direction::Contour => hatch::CONTOUR,
            Direction::Sight => hatch::SIGHT,
            Direction::Curvature => hatch::CURVATURE,
        };
        let turn = if set.direction == Direction::Fixed { 0.0 } else { set.angle_deg * 32.0 / 360.0 };
        let fixed_direction = axes::to_azimuth(axes::fixed_rad(set)).as_vec2().to_array();
        let marks_px = set.recipe.as_ref().map_or([0.0, 1.0], marks_px);
        let flags = set.recipe.as_ref().map_or(0, |recipe| {
            let endless = if recipe.kind == Kind::Line { ENDLESS } else { 0 };
            let dots = if recipe.kind == Kind::Dots { DOTS } else { 0 };
            endless | dots | if swells(recipe) { SWELLS } else { 0 }
        });
        // Below three quarters of their size, texels are smaller than pixels and would alias.
        let grey = ((0.75 - set.size) / 0.4).clamp(0.0, 1.0);
        let (map, size) = (map as u32, set.size);
        Self { direction, map, size, turn, fixed_direction, marks_px, flags, grey, pad_a: 0.0, pad_b: 0.0 }
    }
}

/// Range of slope on each side of its limit over which a set appears or disappears, in degrees.
const SLOPE_BORDER_DEG: f32 = 3.0;

impl HatchUniform {
    /// Creates the uniform. `ladder` is the first level and the number of levels, `side` the side of the maps in
    /// texels.
    pub(crate) fn new(hatching: &Hatching, ladder: (i32, usize), side: u32) -> Self {
        let sets = &hatching.sets;
        let mut uniform = Self {
            count: sets.len() as u32,
            level_count: ladder.1 as i32,
            first_level: ladder.0,
            softness: hatching.softness,
            side,
            drawn: u32::MAX,
            by_curvature: hatching.follows_curvature().into(),
            share: hatching.share,
            begins: [f32::MAX; MAX_SETS],
            // A set that does not exist is drawn on no slope.
            comes_from: [2.0; MAX_SETS],
            comes_full: [3.0; MAX_SETS],
            goes_from: [2.0; MAX_SETS],
            goes_full: [3.0; MAX_SETS],
            ..Self::zeroed()
        };
        let density = |darkness: f32| -(1.0 - darkness).ln();
        for (i, set) in sets.iter().enumerate() {
            uniform.layers[i] = HatchLayerUniform::new(set, i);
            // The first set also draws tones lighter than its own.
            uniform.begins[i] = if i == 0 { 0.0 } else { density(set.from) };
            uniform.spans[i] = sets.get(i + 1).map_or(f32::MAX, |next| density(next.from) - uniform.begins[i]);
            let sine = |deg: f32| deg.to_radians().sin();
            let [low, high] = set.slope_deg;
            if low <= 0.0 {
                [uniform.comes_from[i], uniform.comes_full[i]] = [-2.0, -1.0];
            } else {
                [uniform.comes_from[i], uniform.comes_full[i]] =
                    [sine(low - SLOPE_BORDER_DEG), sine(low + SLOPE_BORDER_DEG)];
            }
            if high < 90.0 {
                [uniform.goes_from[i], uniform.goes_full[i]] =
                    [sine(high - SLOPE_BORDER_DEG), sine(high + SLOPE_BORDER_DEG)];
            }
        }
        uniform
    }
}
