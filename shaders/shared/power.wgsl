// Powers of numbers that may be 0, or below 0 by rounding.
#define_import_path hachure::power

// The least base: a normal number so small that its powers are 0 in every picture.
const LEAST: f32 = 1e-37;

// Returns `base` to the power of `exponent`, where a base below 0 counts as 0. WGSL's pow is exp2(exponent * log2(base)):
// on many GPUs it is not a number where both are 0, and where the base is negative.
fn power(base: f32, exponent: f32) -> f32 {
    return pow(max(base, LEAST), exponent);
}
