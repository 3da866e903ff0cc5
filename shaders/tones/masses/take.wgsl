// Merges small masses into the land around them: an opening of the tones by area, and a closing where masses are dark
// (Vincent 1993, "Grayscale area openings and closings"). A tone that rises above a level on too few cells remains just
// below that level. If all tones change by little, so do the taken ones.
#import hachure::mass_grid::{MassCell, MassRules, is_in, tone_of_level, BORDERED}
#import hachure::mass_labels::first_of

// How far below or above a level a tone remains, as parts of the distance of levels. Just below it, the soft border of the
// next step would begin.
const BELOW: f32 = 0.25;
const ABOVE: f32 = 1e-3;

@group(0) @binding(0) var<uniform> mass_rules: MassRules;
@group(0) @binding(2) var<storage, read_write> mass_cells: array<MassCell>;
@group(0) @binding(3) var<storage, read> areas: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let cells = mass_rules.cells;
    if any(id.xy >= cells) {
        return;
    }
    let cell = id.y * cells.x + id.x;
    let tone = mass_cells[cell].tone;
    let is_dark = mass_rules.dark == 1u;
    // The masses of a cell shrink from level to level: upward, or downward if they are dark.
    for (var step = 1u; step < mass_rules.levels; step++) {
        let level = select(step, mass_rules.levels - step, is_dark);
        if !is_in(mass_rules, tone, level) {
            continue;
        }
        let area = areas[first_of((level - 1u) * cells.x * cells.y + cell)];
        if (area & BORDERED) != 0u && (area & ~BORDERED) < mass_rules.least {
            mass_cells[cell].tone = (f32(level) - select(BELOW, -ABOVE, is_dark)) / f32(mass_rules.levels);
            mass_cells[cell].level = tone_of_level(mass_rules, level);
            return;
        }
    }
}
