// Joins ends that chose each other; each end is joined at most once. See chain_choose.wgsl.
#import hachure::strokes::{ChainPlan, NONE}

@group(0) @binding(0) var<uniform> turn: u32;
@group(0) @binding(1) var<uniform> plan: ChainPlan;
@group(0) @binding(2) var<storage, read> choices: array<u32>;
// The end that each end is joined to.
@group(0) @binding(3) var<storage, read_write> links: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let end = id.x;
    if end >= plan.ends || turn > 0u && links[end] != NONE {
        return;
    }
    let choice = choices[end];
    var link = NONE;
    if choice != NONE {
        if choices[choice] == end {
            link = choice;
        }
    }
    links[end] = link;
}
