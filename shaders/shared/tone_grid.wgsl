// The cells in which lines from tone are looked for: one for each pixel or, where lines are wide enough, one for each block of
// 2 x 2 pixels, which costs a fourth. Blocks begin at even pixels of the whole picture, so that its parts have the same.
#define_import_path hachure::tone_grid
#import hachure::view::View

struct Grid {
    // Side of a cell.
    side_px: i32,
    // Where the first cell begins, on the targets.
    first_px: vec2<i32>,
    // Cells whose pixels all lie on the targets: a last column or row that is left over has none of its own.
    size: vec2<i32>,
}

fn grid_of(view: View, side_px: i32) -> Grid {
    let first_px = view.origin_px & vec2<i32>(side_px - 1);
    return Grid(side_px, first_px, max((vec2<i32>(view.size_px) - first_px) / side_px, vec2<i32>(1)));
}

// The place on the targets of one on the grid; the middle of a cell is at its number and a half.
fn px_of_place(grid: Grid, place: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(grid.first_px) + f32(grid.side_px) * place;
}

fn place_of_px(grid: Grid, px: vec2<f32>) -> vec2<f32> {
    return (px - vec2<f32>(grid.first_px)) / f32(grid.side_px);
}

// A line as a cell sees it.
struct Line {
    // The curvature of the tone, in parts of that from which lines begin: above 0 that of a dark line, below 0 that of a
    // highlight line. A pixel has a line where it is beyond 1 or -1 between the cells; 0 is no line.
    curvature: f32,
    opacity: f32,
    // How far the line's middle lies from the middle of the cell, to the left of its way.
    offset_px: f32,
    // Unit, to the right; both ways along a line are the same line.
    way: vec2<f32>,
}

// The way of a line as a number from -1 to 1, and back: its part of the sum of both coordinates.
fn number_of_way(way: vec2<f32>) -> f32 {
    return select(-way.y, way.y, way.x >= 0.0) / (abs(way.x) + abs(way.y));
}

fn way_of_number(number: f32) -> vec2<f32> {
    let way = vec2<f32>(1.0 - abs(number), number);
    return way * inverseSqrt(dot(way, way));
}

fn left_of(way: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(-way.y, way.x);
}

// The line that a texel of `tone lines` holds, and back.
fn line_of_texel(texel: vec4<f32>) -> Line {
    return Line(texel.r, texel.g, texel.b, way_of_number(texel.a));
}

fn texel_of_line(line: Line) -> vec4<f32> {
    return vec4<f32>(line.curvature, line.opacity, line.offset_px, number_of_way(line.way));
}

// How far a place lies from the line of a cell, to its left.
fn away_px(grid: Grid, cell: vec2<i32>, line: Line, at_px: vec2<f32>) -> f32 {
    return dot(left_of(line.way), at_px - px_of_place(grid, vec2<f32>(cell) + 0.5)) - line.offset_px;
}
