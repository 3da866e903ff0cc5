// Combines paper, tones, haze, focus and lines into a picture.
#import hachure::focus::{Focus, in_focus, half_of_focus, focus_width}
#import hachure::view::{View, above_horizon, distance_from_eye, ray_of_pixel}
#import hachure::paper::{bordered, paper_grain}

struct Composite {
    paper: vec3<f32>,
    // Distance at which haze has taken 63 %.
    haze_m: f32,
    ink: vec3<f32>,
    // Strength of the paper's grain.
    grain: f32,
    sky_zenith: vec3<f32>,
    // Part of a line that is left in full haze, 0 to 1.
    faintest_line: f32,
    sky_horizon: vec3<f32>,
    // 1: lines are drawn.
    line_strength: f32,
    haze: vec3<f32>,
    // Part of a tone that is left in full haze, 0 to 1.
    faintest_tone: f32,
    stroke_ink: vec3<f32>,
    // How many times farther than tones lines reach into the haze.
    line_reach: f32,
    mark_ink: vec3<f32>,
    // Part of a mark's ink that is left in full haze, 0 to 1.
    faintest_mark: f32,
    // 1: the picture is one sample of a mean, and its fourth channel is the ink of lines.
    is_sample: u32,
    water_ink: vec3<f32>,
    // Part of the ink of shores and water lines that is left in full haze, 0 to 1.
    faintest_water: f32,
    // Linear colour of ruled lines and outlines in the sky.
    sky_ink: vec3<f32>,
    border: vec3<f32>,
    // 1: the sheet has a margin or a border, whose widths are `border_px`.
    is_bordered: u32,
    border_px: vec2<f32>,
    // Cosine and sine of the horizon's depression below level.
    horizon: vec2<f32>,
    height_ink_color: vec3<f32>,
    // Part of the ink of contour lines that is left in full haze, 0 to 1.
    faintest_height: f32,
    // Height of the bare paper below the picture.
    foot_px: f32,
    // Linear colour that tones far from the focus approach.
    unfocused: vec3<f32>,
    // Part of the ink of rims that is left in full haze, 0 to 1.
    faintest_rim: f32,
    rim_ink: vec3<f32>,
    // Part of the ink of lines from shading that is left in full haze, 0 to 1; `tone_line_reach` is how many times
    // farther than tones they reach into it.
    faintest_tone_line: f32,
    tone_line_ink: vec3<f32>,
    tone_line_reach: f32,
    highlight_ink: vec3<f32>,
    // Part of the ink of rows that is left in full haze, 0 to 1.
    faintest_row: f32,
    row_ink: vec3<f32>,
    // Part of the ink of cut lines that is left in full haze, 0 to 1.
    faintest_cut: f32,
    cut_ink: vec3<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> composite: Composite;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var tone: texture_2d<f32>;
@group(0) @binding(4) var line: texture_2d<f32>;
// Ink of strokes, after haze.
@group(0) @binding(5) var ink: texture_2d<f32>;
// Ink of hatching.
@group(0) @binding(6) var marks: texture_2d<f32>;
// Ink of rows of hachures.
@group(0) @binding(7) var rows: texture_2d<f32>;
// Ink of cut lines, one family per channel.
@group(0) @binding(8) var cuts: texture_2d<f32>;
// Ink of shores and water lines.
@group(0) @binding(9) var water_ink: texture_2d<f32>;
// Ink of contour lines.
@group(0) @binding(10) var height_ink: texture_2d<f32>;
// Ink of the rims of holes.
@group(0) @binding(11) var rims: texture_2d<f32>;
@group(0) @binding(12) var<storage, read> focus: Focus;
#ifdef SKY
// A drawn sky: linear colour, and the ink of its lines.
@group(0) @binding(13) var sky: texture_2d<f32>;
#endif
// Ink of lines from shading: dark lines and highlight lines.
@group(0) @binding(15) var tone_lines: texture_2d<f32>;
// Linear colour; alpha is 1, or in a sample the ink of lines.
@group(0) @binding(14) var picture: texture_storage_2d<rgba16float, write>;

// Returns the part of the contrast that haze leaves at a distance.
fn clearness(distance_m: f32, reach: f32) -> f32 {
    let t = distance_m / (composite.haze_m * reach);
    return exp(-t * t);
}

// Returns the nearest surface point around a pixel, to which a line there belongs (a silhouette belongs to the
// occluding surface), and its distance.
fn nearest_m(pixel: vec2<i32>) -> vec4<f32> {
    let last = vec2<i32>(view.size_px) - 1;
    var nearest = vec4<f32>(vec3<f32>(0.0), 1e30);
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let at = textureLoad(position, clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), last), 0);
            if at.w > 0.0 {
                let distance_m = distance_from_eye(view, at.xyz);
                nearest = select(nearest, vec4<f32>(at.xyz, distance_m), distance_m < nearest.w);
            }
        }
    }
    return nearest;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = textureLoad(position, pixel, 0);
    let shaded = textureLoad(tone, pixel, 0);
    let sheet = vec2<f32>(pixel + view.origin_px);
    var color: vec3<f32>;
    // Families of cut lines overlap independently.
    let bare = 1.0 - textureLoad(cuts, pixel, 0).rgb;
    var cut_ink = 1.0 - bare.r * bare.g * bare.b;
    var mark_ink = textureLoad(marks, pixel, 0).r;
    var row_ink = textureLoad(rows, pixel, 0).r;
    var shore_ink = textureLoad(water_ink, pixel, 0).r;
    var contour_ink = textureLoad(height_ink, pixel, 0).r;
    var edge_ink = textureLoad(rims, pixel, 0).r;
    var tone_line = textureLoad(tone_lines, pixel, 0).rg;
    if at.w <= 0.0 {
#ifdef SKY
        color = textureLoad(sky, pixel, 0).rgb;
#else
        let up = above_horizon(normalize(ray_of_pixel(view, pixel)).z, composite.horizon);
        color = mix(composite.sky_horizon, composite.sky_zenith, clamp(up * 2.0, 0.0, 1.0));
#endif
    } else {
        let clear = clearness(distance_from_eye(view, at.xyz), 1.0);
        let seen = in_focus(focus, view, at.xyz, sheet + 0.5);
        color = mix(composite.haze, shaded.rgb, mix(composite.faintest_tone, 1.0, clear));
        color = select(mix(composite.unfocused, color, seen), color, seen == 1.0);
        mark_ink *= mix(composite.faintest_mark, 1.0, clear) * half_of_focus(seen);
        cut_ink *= mix(composite.faintest_cut, 1.0, clear) * half_of_focus(seen);
        row_ink *= mix(composite.faintest_row, 1.0, clear) * half_of_focus(seen);
        shore_ink *= mix(composite.faintest_water, 1.0, clear) * seen;
        contour_ink *= mix(composite.faintest_height, 1.0, clear) * seen;
        edge_ink *= mix(composite.faintest_rim, 1.0, clear) * seen;
        let far = clearness(distance_from_eye(view, at.xyz), composite.tone_line_reach);
        tone_line *= mix(composite.faintest_tone_line, 1.0, far) * seen;
    }
    color *= composite.paper;
    if composite.grain > 0.0 {
        color *= 1.0 + composite.grain * paper_grain(sheet);
    }
#ifdef SKY
    if at.w <= 0.0 {
        color = mix(color, composite.sky_ink, textureLoad(sky, pixel, 0).a);
    }
#endif
    color = mix(color, composite.highlight_ink, tone_line.g);
    color = mix(color, composite.tone_line_ink, tone_line.r);
    color = mix(color, composite.height_ink_color, contour_ink);
    color = mix(color, composite.mark_ink, mark_ink);
    color = mix(color, composite.cut_ink, cut_ink);
    color = mix(color, composite.row_ink, row_ink);
    color = mix(color, composite.water_ink, shore_ink);
    color = mix(color, composite.rim_ink, edge_ink);
    let drawn = textureLoad(line, pixel, 0).r * composite.line_strength;
    if drawn > 0.0 {
        let nearest = nearest_m(pixel);
        let clear = clearness(nearest.w, composite.line_reach);
        let seen = in_focus(focus, view, nearest.xyz, sheet + 0.5);
        // A line covers both sides of its edge. In the distance the farther side fades, so that lines are thin.
        let behind = at.w <= 0.0 || distance_from_eye(view, at.xyz) > 1.01 * nearest.w;
        let side = select(1.0, clear, behind);
        // Away from the focus lines lose their pale sides.
        let lost = 1.0 - focus_width(seen);
        let kept = max(drawn - lost, 0.0) / (1.0 - lost);
        color = mix(color, composite.ink, kept * side * mix(composite.faintest_line, 1.0, clear) * half_of_focus(seen));
    }
    color = mix(color, composite.stroke_ink, textureLoad(ink, pixel, 0).r);
    if composite.is_bordered == 1u {
        let bare = composite.paper * (1.0 + composite.grain * paper_grain(sheet));
        color = bordered(color, bare, composite.border, composite.border_px, composite.foot_px, sheet + 0.5, view.picture_px);
    }
    // The ink of lines before haze, because distant lines are lines as well.
    let alpha = select(1.0, textureLoad(line, pixel, 0).r, composite.is_sample == 1u);
    textureStore(picture, pixel, vec4<f32>(color, alpha));
}
