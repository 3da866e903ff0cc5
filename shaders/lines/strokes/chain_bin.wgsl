// Sorts the ends of segments into cells whose side is the reach, so that partners are in 3 x 3 cells (the uniform grid
// of Green 2010, "Particle simulation using CUDA").
//
// The grid is unbounded: cell (x, y) maps to bucket x + y * CELL_ROW, modulo the number of buckets, which is about that
// of ends. Ends far outside of the picture are handled like all others, and the work depends on the number of segments,
// not on the picture. Three cells in a row are three buckets in a row. Ends that share a bucket by chance are rejected
// by their distance.
//
// Stage 0 counts the ends of each bucket; a prefix sum turns the counts into offsets; stage 1 puts each end into its
// place, after which `buckets` holds the end of each bucket. The order inside a bucket is random; nothing that follows
// depends on it.
#import hachure::strokes::{ChainPlan, ChainRules, LIMIT_UNITS, Segment, bucket_of, direction, end_position}

@group(0) @binding(0) var<uniform> stage: u32;
@group(0) @binding(1) var<uniform> rules: ChainRules;
@group(0) @binding(2) var<uniform> plan: ChainPlan;
@group(0) @binding(3) var<storage, read> segments: array<Segment>;
@group(0) @binding(4) var<storage, read_write> buckets: array<atomic<u32>>;
// For each end: x, y, its number, its outward direction (each component + 128, in 8 bits).
@group(0) @binding(5) var<storage, read_write> slots: array<vec4<i32>>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let end = id.x;
    if end >= plan.ends {
        return;
    }
    let segment = segments[end / 2u];
    let position = end_position(segment, end);
    let cell = vec2<u32>(position + LIMIT_UNITS) / rules.reach_units;
    let bucket = bucket_of(cell, plan.buckets);
    let at = atomicAdd(&buckets[bucket], 1u);
    if stage == 0u {
        return;
    }
    let outward = direction(position - end_position(segment, end ^ 1u)) + 128;
    slots[at] = vec4<i32>(position, i32(end), outward.x | (outward.y << 8u));
}
