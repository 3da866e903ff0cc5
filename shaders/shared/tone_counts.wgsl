// Counts of tones and of distances, from which the tones are fitted to the picture.
#define_import_path hachure::tone_counts

// Bins of tones, and as many of distances.
const BINS: u32 = 64u;
const WORDS: u32 = 128u;
// Binary logarithm of the least distance, in metres, and the octaves of a bin.
const LEAST_OCTAVE: f32 = -4.0;
const OCTAVES_PER_BIN: f32 = 0.5;
