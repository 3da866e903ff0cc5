// Gives each cell a label of its own, at each level, and clears the areas.
#import hachure::mass_grid::{MassRules, level_cell}

@group(0) @binding(0) var<uniform> mass_rules: MassRules;
@group(0) @binding(1) var<storage, read_write> labels: array<u32>;
@group(0) @binding(2) var<storage, read_write> areas: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let here = level_cell(mass_rules, id.xy);
    if !here.is_outside {
        labels[here.index] = here.index;
        areas[here.index] = 0u;
    }
}
