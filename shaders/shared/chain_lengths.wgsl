// The length of each chain on the picture: budget.wgsl counts the budget by it, and sizes.wgsl spends the budget by it.
#define_import_path hachure::chain_lengths

#import hachure::strokes::{Chain, StrokeCounts, UNITS_PER_PX}
#import hachure::stroke_style::Strokes

@group(0) @binding(0) var<uniform> strokes: Strokes;
@group(0) @binding(1) var<storage, read> counts: StrokeCounts;
@group(0) @binding(2) var<storage, read> chains: array<Chain>;
// Arc length of each point from the first point of the first chain, in 1/16 px.
@group(0) @binding(3) var<storage, read> along_units: array<u32>;

fn chain_length_px(number: u32) -> f32 {
    let chain = chains[number];
    // A chain of n segments has n + 1 points.
    let first = chain.first + number;
    return f32(along_units[first + chain.count] - along_units[first]) / UNITS_PER_PX;
}
