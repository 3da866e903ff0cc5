// Lists whose order does not depend on which workgroup is quicker.
//
// A pass that appends to a list with an atomic counter puts its entries in a random order. Code that looks at
// neighbours in the list, or lets the first of equals win, then differs from run to run. Here a pass runs twice: at
// stage 0 each workgroup counts its entries, a prefix sum turns the counts into offsets, and at stage 1 every entry is
// written to its place: by workgroup, then by thread.
#define_import_path hachure::ordered

// The state of an ordered list, in one buffer because bindings are few.
struct Order {
    // Number of entries that the list had before, if the pass stores it at stage 0.
    before: u32,
    // The prefix sum needs its values at an aligned offset.
    padding: array<u32, 63>,
    // Offset of each workgroup's entries, and the total; then whatever the pass stores between stages.
    starts: array<u32>,
}

// Whether this is stage 0. A shader that binds three other uniforms has a variant for each stage instead of a fourth
// (docs/decisions/software-drivers.md).
#ifdef COUNTS
fn is_counting() -> bool {
    return true;
}
#else
#ifdef WRITES
fn is_counting() -> bool {
    return false;
}
#else
@group(0) @binding(28) var<uniform> order_stage: u32;

fn is_counting() -> bool {
    return order_stage == 0u;
}
#endif
#endif

// The entries of this workgroup's threads: one bit each, in the order of the list.
var<workgroup> marks: array<atomic<u32>, 40>;

const MARK_WORDS: u32 = 40u;

// Clears the marks. At least 40 threads call it; a barrier must follow before the first mark.
fn clear_marks(thread: u32) {
    if thread < MARK_WORDS {
        atomicStore(&marks[thread], 0u);
    }
}

// Marks entry `number`, below 1280. A barrier must follow the last mark.
fn mark(number: u32) {
    atomicOr(&marks[number / 32u], 1u << (number % 32u));
}

// Returns how many entries are marked before `number`.
fn marks_before(number: u32) -> u32 {
    var count = countOneBits(atomicLoad(&marks[min(number / 32u, MARK_WORDS - 1u)]) & ((1u << (number % 32u)) - 1u));
    for (var word = 0u; word < number / 32u; word++) {
        count += countOneBits(atomicLoad(&marks[word]));
    }
    return count;
}

// Returns how many entries are marked in all.
fn all_marks() -> u32 {
    var count = 0u;
    for (var word = 0u; word < MARK_WORDS; word++) {
        count += countOneBits(atomicLoad(&marks[word]));
    }
    return count;
}
