// Constants shared by the passes that rank segments (chain_rank.wgsl).
#define_import_path hachure::ranking

// Bit of a rank: the head has been found.
const FOUND: u32 = 0x80000000u;
// Index of `progress` in `StrokeCounts` as an array of words.
const PROGRESS: u32 = 6u;
// Bits of the progress: rounds 0 to 9 rank all segments, rounds 11 to 20 the loops.
const FIRST_ROUNDS: u32 = 0x3ffu;
const ROUNDS: u32 = 0x1ffbffu;
