// Empties the buckets for a new frame. See chain_bin.wgsl.
#import hachure::strokes::ChainPlan

@group(0) @binding(0) var<uniform> plan: ChainPlan;
@group(0) @binding(1) var<storage, read_write> buckets: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < plan.buckets {
        buckets[id.x] = 0u;
    }
}
