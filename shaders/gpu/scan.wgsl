// Exclusive prefix sum in place: reduce, then scan (Merrill, Grimshaw 2009; Harris, Sengupta, Owens 2007, GPU Gems 3,
// chapter 39).
//
// There are three stages: 0, each workgroup sums a block of 2048 values; 1, one workgroup turns the sums of the blocks
// into their offsets; 2, each workgroup scans its block from its offset on. Sums wrap at 2^32. The value after the last
// becomes the total, if the buffer has room for it.
//
// Single-pass sums (decoupled look-back) read less, but wait for other workgroups, and not every driver guarantees that
// those make progress.

@group(0) @binding(0) var<uniform> stage: u32;
@group(0) @binding(1) var<storage, read> size: u32;
@group(0) @binding(2) var<storage, read_write> sums: array<u32>;
@group(0) @binding(3) var<storage, read_write> values: array<u32>;

const THREADS: u32 = 256u;
// Values per thread in a block, and per thread of the one workgroup that scans the sums of 1024 blocks.
const OF_BLOCK: u32 = 8u;
const OF_SUMS: u32 = 4u;

var<workgroup> even: array<u32, 256>;
var<workgroup> odd: array<u32, 256>;

// Returns the inclusive prefix sum over the threads of a workgroup (Hillis, Steele 1986).
fn sum_of_threads(thread: u32, own: u32) -> u32 {
    even[thread] = own;
    workgroupBarrier();
    var sum = own;
    for (var reach = 1u; reach < THREADS; reach *= 4u) {
        if thread >= reach {
            sum += even[thread - reach];
        }
        odd[thread] = sum;
        workgroupBarrier();
        if thread >= 2u * reach {
            sum += odd[thread - 2u * reach];
        }
        even[thread] = sum;
        workgroupBarrier();
    }
    return sum;
}

fn scan_sums(thread: u32) {
    let blocks = (size + THREADS * OF_BLOCK - 1u) / (THREADS * OF_BLOCK);
    let begin = thread * OF_SUMS;
    let end = min(begin + OF_SUMS, blocks);
    var own = 0u;
    for (var i = begin; i < end; i++) {
        own += sums[i];
    }
    let through = sum_of_threads(thread, own);
    var before = through - own;
    for (var i = begin; i < end; i++) {
        let value = sums[i];
        sums[i] = before;
        before += value;
    }
    if thread == THREADS - 1u && size < arrayLength(&values) {
        values[size] = through;
    }
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    if stage == 1u {
        scan_sums(thread);
        return;
    }
    let begin = (group.x * THREADS + thread) * OF_BLOCK;
    let end = min(begin + OF_BLOCK, size);
    var own = 0u;
    for (var i = begin; i < end; i++) {
        own += values[i];
    }
    let through = sum_of_threads(thread, own);
    if stage == 0u {
        if thread == THREADS - 1u {
            sums[group.x] = through;
        }
        return;
    }
    var before = sums[group.x] + through - own;
    for (var i = begin; i < end; i++) {
        let value = values[i];
        values[i] = before;
        before += value;
    }
}
