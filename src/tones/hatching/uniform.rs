//! `HatchLayer` and `Hatch` in `shaders/shared/hatch.wgsl`: a style's layers in the form that the shaders read.

use bytemuck::Zeroable;

use super::axes;
use crate::gpu::wgsl::shared::hatch;
pub(crate) use crate::gpu::wgsl::shared::hatch::Hatch as HatchUniform;
pub(crate) use crate::gpu::wgsl::shared::hatch::HatchLayer as HatchLayerUniform;
use crate::style::hatching::{Direction, Hatching, Layer, MOST_LAYERS};
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
    fn new(layer: &Layer, map: usize) -> Self {
        let direction = match layer.direction {
            Direction::Fixed => hatch::FIXED,
            Direction::Slope => hatch::SLOPE,
            Direction::Contour => hatch::CONTOUR,
            Direction::Sight => hatch::SIGHT,
            Direction::Curvature => hatch::CURVATURE,
        };
        let turn = if layer.direction == Direction::Fixed { 0.0 } else { layer.angle_deg * 32.0 / 360.0 };
        let fixed_direction = axes::to_azimuth(axes::fixed_rad(layer)).as_vec2().to_array();
        let marks_px = layer.recipe.as_ref().map_or([0.0, 1.0], marks_px);
        let flags = layer.recipe.as_ref().map_or(0, |recipe| {
            let endless = if recipe.kind == Kind::Line { ENDLESS } else { 0 };
            let dots = if recipe.kind == Kind::Dots { DOTS } else { 0 };
            endless | dots | if swells(recipe) { SWELLS } else { 0 }
        });
        // Below three quarters of their size, texels are smaller than pixels and would alias.
        let grey = ((0.75 - layer.size) / 0.4).clamp(0.0, 1.0);
        let (map, size) = (map as u32, layer.size);
        Self { direction, map, size, turn, fixed_direction, marks_px, flags, grey, pad_a: 0.0, pad_b: 0.0 }
    }
}

/// Range of slope on each side of its limit over which a layer appears or disappears, in degrees.
const SLOPE_BORDER_DEG: f32 = 3.0;

impl HatchUniform {
    /// Creates the uniform. `ladder` is the first level and the number of levels, `side` the side of the maps in
    /// texels.
    pub fn new(hatching: &Hatching, ladder: (i32, usize), side: u32) -> Self {
        let layers = &hatching.layers;
        let mut uniform = Self {
            count: layers.len() as u32,
            level_count: ladder.1 as i32,
            first_level: ladder.0,
            softness: hatching.softness,
            side,
            drawn: u32::MAX,
            by_curvature: hatching.follows_curvature().into(),
            begins: [f32::MAX; MOST_LAYERS],
            // A layer that does not exist is drawn on no slope.
            comes_from: [2.0; MOST_LAYERS],
            comes_full: [3.0; MOST_LAYERS],
            goes_from: [2.0; MOST_LAYERS],
            goes_full: [3.0; MOST_LAYERS],
            ..Self::zeroed()
        };
        let density = |darkness: f32| -(1.0 - darkness).ln();
        for (i, layer) in layers.iter().enumerate() {
            uniform.layers[i] = HatchLayerUniform::new(layer, i);
            // The first layer also draws tones lighter than its own.
            uniform.begins[i] = if i == 0 { 0.0 } else { density(layer.from) };
            uniform.spans[i] = layers.get(i + 1).map_or(f32::MAX, |next| density(next.from) - uniform.begins[i]);
            let sine = |deg: f32| deg.to_radians().sin();
            let [low, high] = layer.slope_deg;
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
