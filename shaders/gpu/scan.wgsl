// Exclusive prefix sum in place: reduce, then scan (Merrill, Grimshaw 2009; Harris, Sengupta, Owens 2007, GPU Gems 3,
// chapter 39).
//
// A fixed number of workgroups share the values: each has as many blocks of 2048 values as the others, one after
// another, and those beyond the last value have none. There are two stages: 0, each workgroup sums its values; 1, each
// adds up the sums of the workgroups before it, and scans its values from there on. A single workgroup needs only the
// second. Sums wrap at 2^32. The value after the last becomes the total, if the buffer has room for it.
//
// Single-pass sums (decoupled look-back) read less, but wait for other workgroups, and not every driver guarantees that
// those make progress.

struct Scan {
    stage: u32,
    // Number of workgroups, at most 64.
    groups: u32,
    // The number of values; with COUNTED, their capacity, to which a greater number is clamped.
    capacity: u32,
    // With COUNTED, index of the number of values in `numbers`.
    index: u32,
}

@group(0) @binding(0) var<uniform> scan: Scan;
#ifdef COUNTED
@group(0) @binding(1) var<storage, read> numbers: array<u32>;
#endif
// The sum of each workgroup's values.
@group(0) @binding(2) var<storage, read_write> sums: array<u32>;
@group(0) @binding(3) var<storage, read_write> values: array<u32>;

const THREADS: u32 = 256u;
// Values per thread in a block, and values in a block.
const OF_THREAD: u32 = 8u;
const BLOCK: u32 = 2048u;

var<workgroup> even: array<u32, 256>;
var<workgroup> odd: array<u32, 256>;

// Returns the inclusive prefix sum over the threads of a workgroup (Hillis, Steele 1986). Afterwards `even` holds it
// for all threads; a barrier must follow before the next call.
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

fn sum_of_values(begin: u32, end: u32) -> u32 {
    var sum = 0u;
    for (var i = begin; i < end; i++) {
        sum += values[i];
    }
    return sum;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
#ifdef COUNTED
    let size = min(numbers[scan.index], scan.capacity);
#else
    let size = scan.capacity;
#endif
    let blocks = (size + BLOCK - 1u) / BLOCK;
    let of_group = (blocks + scan.groups - 1u) / scan.groups;
    let first = min(group.x * of_group, blocks);
    let last = min(first + of_group, blocks);
    if scan.stage == 0u {
        if first == last {
            if thread == 0u {
                sums[group.x] = 0u;
            }
            return;
        }
        var own = 0u;
        for (var block = first; block < last; block++) {
            let begin = block * BLOCK + thread * OF_THREAD;
            own += sum_of_values(begin, min(begin + OF_THREAD, size));
        }
        let through = sum_of_threads(thread, own);
        if thread == THREADS - 1u {
            sums[group.x] = through;
        }
        return;
    }
    if first == last {
        if size == 0u && group.x == 0u && thread == 0u && arrayLength(&values) > 0u {
            values[0] = 0u;
        }
        return;
    }
    var before_block = 0u;
    if group.x > 0u {
        var of_others = 0u;
        if thread < group.x {
            of_others = sums[thread];
        }
        sum_of_threads(thread, of_others);
        before_block = even[THREADS - 1u];
        workgroupBarrier();
    }
    for (var block = first; block < last; block++) {
        let begin = block * BLOCK + thread * OF_THREAD;
        let end = min(begin + OF_THREAD, size);
        let own = sum_of_values(begin, end);
        var before = before_block + sum_of_threads(thread, own) - own;
        before_block += even[THREADS - 1u];
        for (var i = begin; i < end; i++) {
            let value = values[i];
            values[i] = before;
            before += value;
        }
        workgroupBarrier();
    }
    if last == blocks && thread == 0u && size < arrayLength(&values) {
        values[size] = before_block;
    }
}
