// Constants shared by the passes that rank segments (chain_rank.wgsl).
#define_import_path hachure::ranking

// Bit of a rank: the head has been found.
const FOUND: u32 = 0x80000000u;
// Index of `progress` in `StrokeCounts` as an array of words.
const PROGRESS: u32 = 6u;
// Jumps of a round.
const JUMPS: u32 = 32u;
// Rounds 0 to 3 rank all segments: 32^4 is the longest chain. Rounds 5 to 7 rank loops, from the second round on;
// chain_rank_begin.wgsl does the first. Bit 4 is set by round 3 and read by none.
const LOOP_ROUNDS: u32 = 5u;
// Bits of the progress.
const FIRST_ROUNDS: u32 = 0xfu;
const ROUNDS: u32 = 0xefu;
