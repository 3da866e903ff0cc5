// Draws lines from shading as ink: pixels read the distance to the lines of the cells around them.
//
// Lee et al. 2007, "Line drawings via abstracted shading", section 3.3: the opacity is that of the line, times a
// falloff with the distance to it. They search from each pixel; here cells of a grid have searched (`search`), which
// may be larger than pixels, and a pixel reads the four around it. A line is straight between cells, so the distance of
// any pixel from it is exact, and borders are as crisp as pixels.
//
// - Lines are anti-aliased: their ink falls to half at half their width, within a pixel. `softness` fades them from
//   within, as the paper does.
// - Dark lines and highlight lines are separate: a pixel between both has some of each. Where the cells of a line end,
//   the border is where the interpolated curvature falls below the threshold.
#import hachure::view::View
#import hachure::tone_grid::{grid_of, place_of_px}

struct Ink {
    // Part of a line's half width over which its ink fades.
    softness: f32,
    // Side of a cell of the grid.
    cell_px: i32,
    pad_a: u32,
    pad_b: u32,
}

// Least difference of curvature assumed between cells when borders are computed, relative to the threshold of lines.
const MIN_RANGE: f32 = 0.25;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> ink: Ink;
// Only the last channel is used: 0 is the sky.
@group(0) @binding(2) var distance_m: texture_2d<f32>;
// Only b is used: the width of lines.
@group(0) @binding(3) var blurred: texture_2d<f32>;
@group(0) @binding(4) var tone_lines: texture_2d<f32>;
// r: ink of dark lines; g: ink of highlight lines.
@group(0) @binding(5) var tone_ink: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let grid = grid_of(view, ink.cell_px);
    let at_px = vec2<f32>(pixel) + 0.5;
    let corner = place_of_px(grid, at_px) - 0.5;
    let first = vec2<i32>(floor(corner));
    let part = corner - vec2<f32>(first);
    let last = grid.size - 1;
    let texels = mat4x4<f32>(
        textureLoad(tone_lines, clamp(first, vec2<i32>(0), last), 0),
        textureLoad(tone_lines, clamp(first + vec2<i32>(1, 0), vec2<i32>(0), last), 0),
        textureLoad(tone_lines, clamp(first + vec2<i32>(0, 1), vec2<i32>(0), last), 0),
        textureLoad(tone_lines, clamp(first + 1, vec2<i32>(0), last), 0),
    );
    // Each vector holds one value for all four cells, here and below.
    let of_cells = transpose(texels);
    let curvatures = of_cells[0];
    let opacities = of_cells[1];
    var inks = vec2<f32>(0.0);
    // A loop instead of a branch: drivers that execute both sides of a branch still skip a loop that no pixel enters.
    for (var turn = 0; turn < i32(any(opacities > vec4<f32>(0.0))); turn++) {
        let x = vec4<f32>(1.0 - part.x, part.x, 1.0 - part.x, part.x);
        let y = vec4<f32>(vec2<f32>(1.0 - part.y), vec2<f32>(part.y));
        let near = x * y;
        let is_line = near * vec4<f32>(opacities > vec4<f32>(0.0));
        let dark = is_line * vec4<f32>(curvatures > vec4<f32>(0.0));
        let light = is_line - dark;
        let weights = max(vec2<f32>(dot(dark, vec4<f32>(1.0)), dot(light, vec4<f32>(1.0))), vec2<f32>(1e-6));
        // Distance of the pixel from each cell's line, as in `away_px`.
        let numbers = of_cells[3];
        let level = 1.0 - abs(numbers);
        let side_px = f32(grid.side_px);
        let to_right_px = side_px * (part.x - vec4<f32>(0.0, 1.0, 0.0, 1.0));
        let down_px = side_px * (part.y - vec4<f32>(0.0, 0.0, 1.0, 1.0));
        let across_px = (level * down_px - numbers * to_right_px) * inverseSqrt(level * level + numbers * numbers);
        let aways_px = abs(across_px - of_cells[2]);
        let away_px = vec2<f32>(dot(dark, aways_px), dot(light, aways_px)) / weights;
        let opacity = vec2<f32>(dot(dark, opacities), dot(light, opacities)) / weights;
        let width_px = textureLoad(blurred, clamp(first, vec2<i32>(0), last), 0).b;
        let is_surface = f32(textureLoad(distance_m, pixel, 0).r > 0.0);
        let covered = saturate(0.5 * width_px - away_px + 0.5);
        let faded = 1.0 - ink.softness * smoothstep(vec2<f32>(1.0 - ink.softness), vec2<f32>(1.0), 2.0 * away_px / width_px);
        // Distance beyond the border, estimated from the gradient of the curvature, in pixels.
        let curvature = dot(near, curvatures);
        let highest = max(max(curvatures.x, curvatures.y), max(curvatures.z, curvatures.w));
        let lowest = min(min(curvatures.x, curvatures.y), min(curvatures.z, curvatures.w));
        let beyond_px = (vec2<f32>(curvature, -curvature) - 1.0) * side_px / max(highest - lowest, MIN_RANGE);
        inks = is_surface * saturate(0.5 + beyond_px) * covered * faded * opacity;
    }
    textureStore(tone_ink, pixel, vec4<f32>(inks, 0.0, 0.0));
}
