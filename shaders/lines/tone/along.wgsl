// Lines from tone along themselves: crumbs go, and what stays is of an even ink.
//
// Lee et al. 2007, "Line drawings via abstracted shading", find lines pixel by pixel and say so: "rendered lines contain
// some pixel-level artifacts and may look a bit ratty" (section 1), and opacity may depend on other measures of confidence
// (section 3). This pass is no part of the paper. Its measure is length, as a draughtsman has it: from each cell it walks
// both ways along the line, as the search saw its direction, until there is no line or it turns sharply. Short ends fade out,
// and opacity is drawn toward its mean along the line (the idea of flow-based filters: Kang, Lee and Chui 2007).
//
// - A walk begins at the middle of the line, and each step goes to the middle of what it finds, so that all cells across a
//   line walk the same way and fade alike.
// - A line that lies beside the walk is another one: walks that hopped to neighbours, or did not by a part of a pixel, made
//   chequerboards where lines turn.
// - A gap makes what follows count less and does not end the line, and neither does a bend: all of it is smooth, so that
//   neighbours walk as far. A line that runs off the picture goes on.
#import hachure::view::View
#import hachure::tone_grid::{away_px, grid_of, left_of, line_of_texel, place_of_px, px_of_place, Grid}

struct Along {
    // Shorter lines fade out.
    shortest_px: f32,
    step_px: f32,
    steps: i32,
    // Side of a cell of the grid.
    cell_px: i32,
    // From what is farther away no ink comes.
    farthest_px: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> along: Along;
// As `line_of_texel` reads it.
@group(0) @binding(2) var tone_lines: texture_2d<f32>;
// The same.
@group(0) @binding(3) var long_lines: texture_storage_2d<rgba16float, write>;

// Each way, at most; and how long one is at least.
const STEPS: i32 = 20;
const STEP_PX: f32 = 1.5;
// Fainter is no line, in parts of the opacity where the walk began and at all.
const FAINT: f32 = 0.2;
const FAINTEST: f32 = 0.01;
// Cosines of the turn in a step from which on a line is another one, and up to which it is the same.
const TURN: vec2<f32> = vec2<f32>(0.75, 0.93);
// How far beside the walk a line is the same one, and from which on another.
const BESIDE_PX: vec2<f32> = vec2<f32>(1.5, 3.0);
// How far beside the walk cells are asked, in cells.
const ASIDE: f32 = 0.5;
// What a gap of a step leaves of what follows, and what is so little that the walk ends.
const GAP: f32 = 0.45;
const LOST: f32 = 0.05;
// How much of its own opacity a line gives for the mean.
const EVEN: f32 = 0.7;
// Where a line begins to fade, in parts of the shortest one.
const BEGIN: f32 = 0.3;

struct Next {
    // How much it is the same line.
    there: f32,
    // How far the walk lies from it, to the left of its way.
    beside_px: f32,
    opacity: f32,
    // As the walk goes.
    way: vec2<f32>,
}

// What the cell of one place says of the line at another.
fn found(grid: Grid, at_px: vec2<f32>, asked_px: vec2<f32>, way: vec2<f32>, least: f32, curvature: f32) -> Next {
    let cell = clamp(vec2<i32>(floor(place_of_px(grid, asked_px))), vec2<i32>(0), grid.size - 1);
    let line = line_of_texel(textureLoad(tone_lines, cell, 0));
    let turned = select(-1.0, 1.0, dot(line.way, way) >= 0.0);
    let beside_px = turned * away_px(grid, cell, line, at_px);
    let opacity = line.opacity * f32(line.curvature * curvature > 0.0);
    let there = smoothstep(0.5 * least, 1.5 * least, opacity)
        * smoothstep(TURN.x, TURN.y, turned * dot(line.way, way))
        * (1.0 - smoothstep(BESIDE_PX.x, BESIDE_PX.y, abs(beside_px)));
    return Next(there, beside_px, opacity, turned * line.way);
}

// How far a line goes on from a place on it, and the sum and weight of its opacity.
fn walk(grid: Grid, start_px: vec2<f32>, on: vec2<f32>, opacity: f32, curvature: f32) -> vec3<f32> {
    let least = max(FAINT * opacity, FAINTEST);
    var at_px = start_px;
    var way = on;
    var walked = vec3<f32>(0.0);
    // What is left of the line's being the same one.
    var same = 1.0;
    for (var i = 1; i <= along.steps && same > LOST; i++) {
        at_px += way * along.step_px;
        if any(at_px < vec2<f32>(0.0)) || any(at_px >= vec2<f32>(view.size_px)) {
            walked.x += same * (along.shortest_px - f32(i - 1) * along.step_px);
            break;
        }
        // The better one of the cells to both sides: the middle of a line may lie in a cell that does not see it, or hardly.
        let aside_px = ASIDE * f32(grid.side_px) * left_of(way);
        let left = found(grid, at_px, at_px + aside_px, way, least, curvature);
        let right = found(grid, at_px, at_px - aside_px, way, least, curvature);
        var next = left;
        if right.there * right.opacity > left.there * left.opacity {
            next = right;
        }
        let there = next.there;
        same *= mix(GAP, 1.0, there);
        at_px -= there * next.beside_px * left_of(next.way);
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
    // Where there is no line, there is no walk.
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
