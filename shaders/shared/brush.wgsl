// The rule by which a stroke texture takes ink. `Brush` in src/lines/strokes/texture.rs is the same rule in Rust, with
// its derivation.
#define_import_path hachure::brush

#import hachure::power::power
#import hachure::pcg::pcg

struct Brush {
    // Size of the texture's tile along and across the stroke, in pixels; across, a picture of a stroke is as wide as the
    // stroke.
    tile_px: vec2<f32>,
    // Half width of a stroke that shows the texture at its own scale, in pixels.
    nominal_half_width_px: f32,
    // How much the texture widens with the stroke: 0 (not at all) to 1 (in proportion).
    spread: f32,
    // Half the range of pressure over which a mark takes its ink, as a part of full pressure.
    softness: f32,
    // Exponent applied to the pressure.
    response: f32,
    // Part of the paper that takes ink at full pressure, 0 to 1.
    fill: f32,
    // Width over which pressure falls towards the stroke's border, in pixels; `border_part` limits it on thin strokes.
    border_px: f32,
    // Largest width of that border as a part of the half width, 0 to 1.
    border_part: f32,
    // Part of the pressure that is left at the border, 0 to 1.
    border_pressure: f32,
    // Whether the tile is a picture of a stroke, which reaches from border to border: 1 or 0.
    fills: f32,
    // Half a texel across, in tiles: a picture of a stroke does not begin again beyond its border.
    half_texel: f32,
}

// Returns where the stroke `id` begins on the tile, in tiles.
fn brush_offset(id: u32) -> vec2<f32> {
    return vec2<f32>(pcg(vec2<u32>(id, 0x9e3779b9u)) >> vec2<u32>(8u)) / 16777216.0;
}

// Returns the texture coordinates of a point of the stroke `id`. `along_px` is its arc length, `across_px` its signed
// distance from the centre line.
fn brush_uv(brush: Brush, along_px: f32, across_px: f32, half_width_px: f32, id: u32) -> vec2<f32> {
    let offset = brush_offset(id);
    if brush.fills > 0.5 {
        let across = clamp(0.5 + 0.5 * across_px / half_width_px, brush.half_texel, 1.0 - brush.half_texel);
        return vec2<f32>(along_px / brush.tile_px.x + offset.x, across);
    }
    let widening = power(brush.nominal_half_width_px / half_width_px, brush.spread);
    return vec2<f32>(along_px, across_px * widening) / brush.tile_px + offset;
}

// Returns the ink that a point takes, 0 to 1, without the coverage of its pixel. `texel` is pigment and threshold,
// `pressure` is 0 to 1, `from_middle_px` the distance from the stroke's centre line.
fn brush_ink(brush: Brush, texel: vec2<f32>, pressure: f32, from_middle_px: f32, half_width_px: f32) -> f32 {
    let border_px = max(min(brush.border_px, brush.border_part * half_width_px), 1e-3);
    let inside = clamp((half_width_px + 0.5 - from_middle_px) / border_px, 0.0, 1.0);
    let rounded = inside * (2.0 - inside);
    let pressed = select(0.0, power(min(pressure, 1.0), brush.response), pressure > 0.0);
    let felt = pressed * brush.fill * mix(brush.border_pressure, 1.0, rounded);
    // A pressure of 0 takes ink nowhere, and a pressure of 1 everywhere.
    let threshold = mix(brush.softness, 1.0 - brush.softness, texel.y);
    let t = clamp((felt - threshold) / (2.0 * brush.softness) + 0.5, 0.0, 1.0);
    return texel.x * t * t * (3.0 - 2.0 * t);
}
