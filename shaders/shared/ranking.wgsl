// What the passes that rank segments (chain_rank.wgsl) share.
#define_import_path hachure::ranking

// In a rank: the head is found.
const FOUND: u32 = 0x80000000u;
// The progress in StrokeCounts, as a list of numbers.
const PROGRESS: u32 = 6u;
// Bits of the progress: rounds 0 to 9 rank all, rounds 11 to 20 the loops.
const FIRST_ROUNDS: u32 = 0x3ffu;
const ROUNDS: u32 = 0x1ffbffu;
