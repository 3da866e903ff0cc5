// How a stroke texture takes ink. src/lines/strokes/texture.rs has the reasons, and the same in Rust (`Brush`).
#define_import_path hachure::brush

#import hachure::pcg::pcg

struct Brush {
    // Along, across.
    tile_px: vec2<f32>,
    // A stroke of this half width has its marks at the size of the tile's.
    nominal_half_width_px: f32,
    // How much marks widen with the stroke, 0 to 1.
    spread: f32,
    // Half the range of pressure in which a mark takes its ink.
    softness: f32,
    // Exponent of the pressure.
    response: f32,
    // Which part of the paper takes ink at full pressure.
    fill: f32,
    // Pressure falls towards the border over this, or over this part of half the width if that is less.
    border_px: f32,
    // 0 to 1 of half the width.
    border_part: f32,
    // What is left of it there.
    border_pressure: f32,
    padding_a: f32,
    padding_b: f32,
}

// Where on the tile the stroke `id` begins.
fn brush_offset(id: u32) -> vec2<f32> {
    return vec2<f32>(pcg(vec2<u32>(id, 0x9e3779b9u)) >> vec2<u32>(8u)) / 16777216.0;
}

// Where a place of the stroke `id` lies on the tile. `along_px` and `across_px` (signed) are the place's.
fn brush_uv(brush: Brush, along_px: f32, across_px: f32, half_width_px: f32, id: u32) -> vec2<f32> {
    let widening = pow(brush.nominal_half_width_px / half_width_px, brush.spread);
    return vec2<f32>(along_px, across_px * widening) / brush.tile_px + brush_offset(id);
}

// Ink that a place takes, 0 to 1, without its pixel's coverage. `texel` is pigment and threshold, `pressure` 0 to 1,
// `from_middle_px` the distance from the stroke's middle.
fn brush_ink(brush: Brush, texel: vec2<f32>, pressure: f32, from_middle_px: f32, half_width_px: f32) -> f32 {
    let border_px = max(min(brush.border_px, brush.border_part * half_width_px), 1e-3);
    let inside = clamp((half_width_px + 0.5 - from_middle_px) / border_px, 0.0, 1.0);
    let rounded = inside * (2.0 - inside);
    let pressed = select(0.0, pow(min(pressure, 1.0), brush.response), pressure > 0.0);
    let felt = pressed * brush.fill * mix(brush.border_pressure, 1.0, rounded);
    // 0 takes nothing and 1 takes all.
    let threshold = mix(brush.softness, 1.0 - brush.softness, texel.y);
    let t = clamp((felt - threshold) / (2.0 * brush.softness) + 0.5, 0.0, 1.0);
    return texel.x * t * t * (3.0 - 2.0 * t);
}
