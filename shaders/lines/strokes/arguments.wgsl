// From numbers of things to numbers of workgroups and instances: what the GPU counted, it draws.
@group(0) @binding(0) var<storage, read> counts: array<u32>;
@group(0) @binding(1) var<storage, read_write> arguments: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let points = counts[4] + counts[5];
    arguments[0] = (counts[4] + 255u) / 256u;
    arguments[1] = 1u;
    arguments[2] = 1u;
    arguments[4] = (points + 255u) / 256u;
    arguments[5] = 1u;
    arguments[6] = 1u;
    arguments[8] = 6u;
    arguments[9] = points;
    arguments[10] = 0u;
    arguments[11] = 0u;
}
