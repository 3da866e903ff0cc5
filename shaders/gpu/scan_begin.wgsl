// Computes the size of a prefix sum, and the number of workgroups that it needs. See scan.wgsl.

struct ScanSource {
    // Index of the number of values in `numbers`.
    index: u32,
    // Capacity for values; a greater number is clamped to it.
    capacity: u32,
}

@group(0) @binding(0) var<uniform> source: ScanSource;
@group(0) @binding(1) var<storage, read> numbers: array<u32>;
// The number of values.
@group(0) @binding(2) var<storage, read_write> size: u32;
@group(0) @binding(3) var<storage, read_write> arguments: array<u32, 3>;

@compute @workgroup_size(1)
fn main() {
    size = min(numbers[source.index], source.capacity);
    arguments[0] = (size + 2047u) / 2048u;
    arguments[1] = 1u;
    arguments[2] = 1u;
}
