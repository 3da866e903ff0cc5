// The cells in which lines from shading are detected: one for each pixel or, where lines are wide enough, one for each
// block of 2 x 2 pixels, at a quarter of the cost. Blocks begin at even pixels of the whole picture, so that its parts
// agree.
#define_import_path hachure::tone_grid
#import hachure::view::View

struct Grid {
    // Side of a cell, in pixels.
    side_px: i32,
    // Origin of the first cell, in pixels of the target.
    first_px: vec2<i32>,
    // Number of cells that are entirely on the target; a partial last column or row has no cells.
    size: vec2<i32>,
}

fn grid_of(view: View, side_px: i32) -> Grid {
    let first_px = view.origin_px & vec2<i32>(side_px - 1);
    return Grid(side_px, first_px, max((vec2<i32>(view.size_px) - first_px) / side_px, vec2<i32>(1)));
}

// Returns the target pixel position of a grid position; the centre of cell n is at n + 0.5.
fn px_of_place(grid: Grid, place: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(grid.first_px) + f32(grid.side_px) * place;
}

fn place_of_px(grid: Grid, px: vec2<f32>) -> vec2<f32> {
    return (px - vec2<f32>(grid.first_px)) / f32(grid.side_px);
}

// A line as detected in a cell.
struct Line {
    // Curvature of the tone, relative to the threshold of lines: positive for a dark line, negative for a highlight
    // line. A pixel has a line where the value interpolated between cells is beyond 1 or -1; 0 is none.
    curvature: f32,
    opacity: f32,
    // Signed distance of the line's centre from the centre of the cell, positive to the left of `way`.
    offset_px: f32,
    // Unit vector along the line, pointing right; both directions are the same line.
    way: vec2<f32>,
}

// Packs the direction of a line into a number from -1 to 1 (a coordinate divided by the sum of both), and back.
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

// Converts between a line and its texel in `tone lines`.
fn line_of_texel(texel: vec4<f32>) -> Line {
    return Line(texel.r, texel.g, texel.b, way_of_number(texel.a));
}

fn texel_of_line(line: Line) -> vec4<f32> {
    return vec4<f32>(line.curvature, line.opacity, line.offset_px, number_of_way(line.way));
}

// Returns how far a position is to the left of a cell's line, in pixels.
fn away_px(grid: Grid, cell: vec2<i32>, line: Line, at_px: vec2<f32>) -> f32 {
    return dot(left_of(line.way), at_px - px_of_place(grid, vec2<f32>(cell) + 0.5)) - line.offset_px;
}
