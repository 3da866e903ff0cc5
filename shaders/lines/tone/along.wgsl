// Smooths lines from shading along themselves: short fragments vanish, and the rest gets even ink.
//
// Lee et al. 2007, "Line drawings via abstracted shading", find lines pixel by pixel, and note that "rendered lines
// contain some pixel-level artifacts and may look a bit ratty" (section 1), and opacity may depend on other measures of
// confidence (section 3). This pass is not part of the paper. Its measure is length: from each cell it walks both ways
// along the line, in the direction that the search found, until the line ends or turns sharply. Short ends fade out,
// and opacity is drawn toward its mean along the line (the idea of flow-based filters: Kang, Lee and Chui 2007).
//
// - A walk begins on the line's centre, and each step moves to the centre of the line that it finds, so that all cells
//   across a line walk the same way and fade alike.
// - A line parallel to the walk is another one: walks that hopped to neighbours, or missed by a fraction of a pixel,
//   made chequerboards where lines turn.
// - A gap or a bend lowers the weight of what follows and does not end the line: all of it is smooth, so that
//   neighbouring cells walk equally far. A line that leaves the picture counts as continued.
#import hachure::view::View
#import hachure::tone_grid::{away_px, grid_of, left_of, line_of_texel, place_of_px, px_of_place, Grid}

struct Along {
    // Length below which lines fade out, in pixels.
    shortest_px: f32,
    step_px: f32,
    steps: i32,
    // Side of a cell of the grid, in pixels.
    cell_px: i32,
    // Distance of a line from the cell's centre beyond which the cell gives no ink.
    farthest_px: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> along: Along;
// In the encoding of `line_of_texel`.
@group(0) @binding(2) var tone_lines: texture_2d<f32>;
// In the same encoding.
@group(0) @binding(3) var long_lines: texture_storage_2d<rgba16float, write>;

// Largest number of steps in each direction, and smallest length of a step.
const STEPS: i32 = 20;
const STEP_PX: f32 = 1.5;
// Opacity below which a walk finds no line: relative to the opacity where it began, and absolute.
const FAINT: f32 = 0.2;
const FAINTEST: f32 = 0.01;
// Cosines of the turn in a step: below the first a line is another one, above the second the same.
const TURN: vec2<f32> = vec2<f32>(0.75, 0.93);
// Distances from the walk within which a line is the same one, and beyond which it is another.
const OFFSET_PX: vec2<f32> = vec2<f32>(1.5, 3.0);
// Distance on either side of the walk at which cells are read, in cells.
const ASIDE: f32 = 0.5;
// Factor of the weight for a step across a gap, and weight at which the walk ends.
const GAP: f32 = 0.45;
const LOST: f32 = 0.05;
// Weight of the mean in a line's opacity.
const EVEN: f32 = 0.7;
// Length at which a line is fully faded, relative to the shortest.
const BEGIN: f32 = 0.3;

struct Next {
    // How much it is the same line, 0 to 1.
    there: f32,
    // Signed distance of the walk from the line, positive to the left of `way`.
    offset_px: f32,
    opacity: f32,
    // In the direction of the walk.
    way: vec2<f32>,
}

// Returns the line of the cell at `asked_px`, relative to a walk at `at_px`.
fn found(grid: Grid, at_px: vec2<f32>, asked_px: vec2<f32>, way: vec2<f32>, least: f32, curvature: f32) -> Next {
    let cell = clamp(vec2<i32>(floor(place_of_px(grid, asked_px))), vec2<i32>(0), grid.size - 1);
    let line = line_of_texel(textureLoad(tone_lines, cell, 0));
    let turned = select(-1.0, 1.0, dot(line.way, way) >= 0.0);
    let offset_px = turned * away_px(grid, cell, line, at_px);
    let opacity = line.opacity * f32(line.curvature * curvature > 0.0);
    let there = smoothstep(0.5 * least, 1.5 * least, opacity)
        * smoothstep(TURN.x, TURN.y, turned * dot(line.way, way))
        * (1.0 - smoothstep(OFFSET_PX.x, OFFSET_PX.y, abs(offset_px)));
    return Next(there, offset_px, opacity, turned * line.way);
}

// Returns how far a line continues from a point on it, and the sum and weight of its opacity.
fn walk(grid: Grid, start_px: vec2<f32>, on: vec2<f32>, opacity: f32, curvature: f32) -> vec3<f32> {
    let least = max(FAINT * opacity, FAINTEST);
    var at_px = start_px;
    var way = on;
    var walked = vec3<f32>(0.0);
    // Weight of the line as the same one.
    var same = 1.0;
    for (var i = 1; i <= along.steps && same > LOST; i++) {
        at_px += way * along.step_px;
        if any(at_px < vec2<f32>(0.0)) || any(at_px >= vec2<f32>(view.size_px)) {
            walked.x += same * (along.shortest_px - f32(i - 1) * along.step_px);
            break;
        }
        // The better one of the cells on both sides: the centre of a line may be in a cell that hardly detects it.
        let aside_px = ASIDE * f32(grid.side_px) * left_of(way);
        let left = found(grid, at_px, at_px + aside_px, way, least, curvature);
        let right = found(grid, at_px, at_px - aside_px, way, least, curvature);
        var next = left;
        if right.there * right.opacity > left.there * left.opacity {
            next = right;
        }
        let there = next.there;
        same *= mix(GAP, 1.0, there);
        at_px -= there * next.offset_px * left_of(next.way);
        way = normalize(mix(way, next.way, there) + vec2<f32>(1e-9, 0.0));
        walked += same * there * vec3<f32>(along.step_px, next.opacity, 1.0);
    }
    return walked;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let grid = grid_of(view, along.cell_px);
    let cell = vec2<i32>(id.xy);
    if any(cell >= grid.size) {
        return;
    }
    let own = textureLoad(tone_lines, cell, 0);
    let line = line_of_texel(own);
    let middle_px = px_of_place(grid, vec2<f32>(cell) + 0.5) + line.offset_px * left_of(line.way);
    // Without a line there is no walk.
    let opacity = line.opacity;
    let is_near = opacity > FAINTEST && abs(line.offset_px) <= along.farthest_px;
    var both = vec3<f32>(0.0);
    for (var side = 0; side < 2 && is_near; side++) {
        both += walk(grid, middle_px, select(line.way, -line.way, side == 1), opacity, line.curvature);
    }
    let mean = (opacity + both.y) / (1.0 + both.z);
    let even = mix(1.0, mean / max(opacity, 1e-4), EVEN);
    let kept = saturate(opacity * even * smoothstep(BEGIN, 1.0, (both.x + 1.0) / along.shortest_px));
    textureStore(long_lines, cell, vec4<f32>(own.r, kept, own.ba));
}
