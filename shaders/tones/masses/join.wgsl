// Joins neighbouring cells of a mass, at each level: a union-find without locks (Playne and Hawick 2018, "A New Algorithm
// for Parallel Connected-Component Labelling on GPUs").
#import hachure::mass_grid::{MassCell, MassRules, is_in, level_cell}
#import hachure::mass_labels::{labels, first_of}

@group(0) @binding(0) var<uniform> mass_rules: MassRules;
@group(0) @binding(2) var<storage, read> mass_cells: array<MassCell>;

fn join(a: u32, b: u32) {
    var high = first_of(a);
    var low = first_of(b);
    while high != low {
        if high < low {
            let other = high;
            high = low;
            low = other;
        }
        let before = atomicMin(&labels[high], low);
        if before == high {
            return;
        }
        // Another invocation has changed the label in between.
        high = first_of(before);
        low = first_of(low);
    }
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let here = level_cell(mass_rules, id.xy);
    if here.is_outside || !is_in(mass_rules, mass_cells[here.cell].tone, here.level) {
        return;
    }
    if here.place.x > 0u && is_in(mass_rules, mass_cells[here.cell - 1u].tone, here.level) {
        join(here.index, here.index - 1u);
    }
    let columns = mass_rules.cells.x;
    if here.place.y > 0u && is_in(mass_rules, mass_cells[here.cell - columns].tone, here.level) {
        join(here.index, here.index - columns);
    }
}
