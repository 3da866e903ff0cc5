// Lines from tone as ink: pixels ask the cells around them how far away their lines are.
//
// Lee et al. 2007, "Line drawings via abstracted shading", section 3.3: the opacity is that of the line, times what is left
// at the distance to it. They search from each pixel; here cells of a grid have searched (`search`), which may be larger than
// pixels, and a pixel reads the four about it. A line is straight between cells, so the distance of any pixel from it is
// exact, and borders are as crisp as pixels are.
//
// - Lines are anti-aliased: half of their ink lies at half their width, and they end within a pixel. `softness` fades them
//   from within as the paper does.
// - Dark lines and highlight lines are told apart: a pixel between both has some of each. Where cells of a line end, the
//   border is where the curvature between them falls below the least.
#import hachure::view::View
#import hachure::tone_grid::{grid_of, place_of_px}

struct Ink {
    // Part of half a line's width over which its ink fades.
    softness: f32,
    // Side of a cell of the grid.
    cell_px: i32,
    pad_a: u32,
    pad_b: u32,
}

// Curvatures differ so much at least from cell to cell, for the sake of borders: in parts of the least that a line has.
const LEAST_RANGE: f32 = 0.25;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> ink: Ink;
// For its last channel: 0 is no surface.
@group(0) @binding(2) var position: texture_2d<f32>;
// For the width of lines, in b.
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
    // A row of cells each; and so are the numbers from here on, for all four at once.
    let of_cells = transpose(texels);
    let curvatures = of_cells[0];
    let opacities = of_cells[1];
    var inks = vec2<f32>(0.0);
    // A loop, since drivers that run both sides of a branch leave one that no pixel goes through.
    for (var turn = 0; turn < i32(any(opacities > vec4<f32>(0.0))); turn++) {
        let x = vec4<f32>(1.0 - part.x, part.x, 1.0 - part.x, part.x);
        let y = vec4<f32>(vec2<f32>(1.0 - part.y), vec2<f32>(part.y));
        let near = x * y;
        let is_line = near * vec4<f32>(opacities > vec4<f32>(0.0));
        let dark = is_line * vec4<f32>(curvatures > vec4<f32>(0.0));
        let light = is_line - dark;
        let weights = max(vec2<f32>(dot(dark, vec4<f32>(1.0)), dot(light, vec4<f32>(1.0))), vec2<f32>(1e-6));
        // How far the pixel lies from the line of each, as `away_px` has it.
        let numbers = of_cells[3];
        let level = 1.0 - abs(numbers);
        let side_px = f32(grid.side_px);
        let to_right_px = side_px * (part.x - vec4<f32>(0.0, 1.0, 0.0, 1.0));
        let down_px = side_px * (part.y - vec4<f32>(0.0, 0.0, 1.0, 1.0));
        let beside_px = (level * down_px - numbers * to_right_px) * inverseSqrt(level * level + numbers * numbers);
        let aways_px = abs(beside_px - of_cells[2]);
        let away_px = vec2<f32>(dot(dark, aways_px), dot(light, aways_px)) / weights;
        let opacity = vec2<f32>(dot(dark, opacities), dot(light, opacities)) / weights;
        let width_px = textureLoad(blurred, clamp(first, vec2<i32>(0), last), 0).b;
        let is_surface = f32(textureLoad(position, pixel, 0).w > 0.0);
        let covered = saturate(0.5 * width_px - away_px + 0.5);
        let faded = 1.0 - ink.softness * smoothstep(vec2<f32>(1.0 - ink.softness), vec2<f32>(1.0), 2.0 * away_px / width_px);
        // As far beyond the border as it is at the slope of the curvature, in pixels.
        let curvature = dot(near, curvatures);
        let highest = max(max(curvatures.x, curvatures.y), max(curvatures.z, curvatures.w));
        let lowest = min(min(curvatures.x, curvatures.y), min(curvatures.z, curvatures.w));
        let beyond_px = (vec2<f32>(curvature, -curvature) - 1.0) * side_px / max(highest - lowest, LEAST_RANGE);
        inks = is_surface * saturate(0.5 + beyond_px) * covered * faded * opacity;
    }
    textureStore(tone_ink, pixel, vec4<f32>(inks, 0.0, 0.0));
}
