// Computes the fitted tone of the light in each cell of the masses.
#import hachure::view::distance_from_eye
#import hachure::lit_surface::view
#import hachure::land_tone::land_tone
#import hachure::mass_grid::{MassCell, MassRules, NO_LAND}
#ifdef FITTED
#import hachure::tone_curve::{ToneCurve, ToneFit, fitted}
#endif

@group(0) @binding(8) var<storage, read_write> mass_cells: array<MassCell>;
#ifdef FITTED
@group(0) @binding(22) var<storage, read> tone_curve: ToneCurve;
@group(0) @binding(23) var<storage, read> tone_fit: ToneFit;
#endif
@group(0) @binding(24) var<uniform> mass_rules: MassRules;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let cells = mass_rules.cells;
    if any(id.xy >= cells) {
        return;
    }
    let px = (vec2<f32>(id.xy) + 0.5) * view.picture_px / vec2<f32>(cells);
    let pixel = clamp(vec2<i32>(px) - view.origin_px, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
    let seen = land_tone(pixel);
    var tone = NO_LAND;
    // Trees and models keep their own tones.
    if seen.is_land && seen.surface.normal.w == 1.0 {
        tone = seen.tone;
#ifdef FITTED
        tone = fitted(tone_curve, tone_fit, tone, distance_from_eye(view, seen.at.xyz));
#endif
    }
    mass_cells[id.y * cells.x + id.x] = MassCell(tone, tone, seen.at.w, 0.0);
}
