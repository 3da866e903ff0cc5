// Squares of the picture in which the ink of rows is compared with the requested ink.
#define_import_path hachure::row_ink
#import hachure::rows::RowRules

// Side of a square, in spacings, and units of ink per pixel.
const SQUARE: f32 = 4.0;
const INK_UNIT: f32 = 64.0;
// Length of a mark in widths.
const SLENDER: f32 = 4.0;

fn square_px(rules: RowRules) -> i32 {
    return i32(ceil(SQUARE * rules.spacing_px));
}

fn squares_of(rules: RowRules, size_px: vec2<u32>) -> vec2<i32> {
    return (vec2<i32>(size_px) + square_px(rules) - 1) / square_px(rules);
}
