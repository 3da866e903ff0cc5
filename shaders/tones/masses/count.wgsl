// Counts the cells of each mass, at each level, and notes whether other land borders on it.
#import hachure::mass_grid::{MassCell, MassRules, is_in, level_cell, BORDERED, NO_LAND}
#import hachure::mass_labels::first_of

@group(0) @binding(0) var<uniform> mass_rules: MassRules;
@group(0) @binding(2) var<storage, read> mass_cells: array<MassCell>;
@group(0) @binding(3) var<storage, read_write> areas: array<atomic<u32>>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let here = level_cell(mass_rules, id.xy);
    if here.is_outside || !is_in(mass_rules, mass_cells[here.cell].tone, here.level) {
        return;
    }
    let cells = mass_rules.cells;
    let mass = first_of(here.index);
    atomicAdd(&areas[mass], 1u);
    var is_bordered = false;
    for (var side = 0u; side < 4u; side++) {
        let sign = 1 - 2 * i32(side & 1u);
        let other = vec2<i32>(here.place) + select(vec2<i32>(0, sign), vec2<i32>(sign, 0), side < 2u);
        if any(other < vec2<i32>(0)) || any(other >= vec2<i32>(cells)) {
            continue;
        }
        let tone = mass_cells[u32(other.y) * cells.x + u32(other.x)].tone;
        is_bordered = is_bordered || (tone != NO_LAND && !is_in(mass_rules, tone, here.level));
    }
    if is_bordered {
        atomicOr(&areas[mass], BORDERED);
    }
}
