// Lists in an order that does not depend on which workgroup is quicker.
//
// A pass that appends to a list with an atomic counter gives its entries places by chance, and what looks at neighbours
// in the list, or lets the first of equals win, differs from run to run. Here a pass runs twice: at stage 0 each
// workgroup counts what it has, a prefix sum makes beginnings of the counts, and at stage 1 everything is written to
// its place: by workgroup, then by thread.
#define_import_path hachure::ordered

// In one buffer, for bindings are few.
struct Order {
    // Which of the runs this is.
    stage: u32,
    // How many workgroups there are.
    groups: u32,
    // Sums want their values at an aligned offset.
    padding: array<u32, 62>,
    // Where the entries of each workgroup begin, and their sum; then what the pass keeps from stage to stage.
    starts: array<u32>,
}

// What the threads of this workgroup have: a bit for each, in the order of the list.
var<workgroup> marks: array<atomic<u32>, 40>;

const MARK_WORDS: u32 = 40u;

// By at least 40 threads; a barrier before the first mark.
fn clear_marks(thread: u32) {
    if thread < MARK_WORDS {
        atomicStore(&marks[thread], 0u);
    }
}

// There is entry `number`, below 1280; a barrier after the last mark.
fn mark(number: u32) {
    atomicOr(&marks[number / 32u], 1u << (number % 32u));
}

// Entries before `number`.
fn marks_before(number: u32) -> u32 {
    var count = countOneBits(atomicLoad(&marks[min(number / 32u, MARK_WORDS - 1u)]) & ((1u << (number % 32u)) - 1u));
    for (var word = 0u; word < number / 32u; word++) {
        count += countOneBits(atomicLoad(&marks[word]));
    }
    return count;
}

// All entries.
fn all_marks() -> u32 {
    var count = 0u;
    for (var word = 0u; word < MARK_WORDS; word++) {
        count += countOneBits(atomicLoad(&marks[word]));
    }
    return count;
}
