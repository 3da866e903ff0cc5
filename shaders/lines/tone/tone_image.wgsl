// The tone image: how light the scene is, for lines that are found in its tones.
//
// Lee, Markosian, Lee and Hughes 2007, "Line drawings via abstracted shading", section 3: a line drawing is an abstraction
// of the shaded picture, so that is made first. Diffuse light and specular highlights stand in channels of their own, since
// highlights are often hidden by broad bright tones (section 1); the light is any light. With "abstracted normals" (section
// 3.4) the land is lit by its form (surface/form.wgsl) and not by each of its samples, as its base coat may be.
//
// Readings and changes:
// - Diffuse light is the tone that the style's light asks for (shared/light.wgsl), so that lines go on where the base coat
//   ends. Cast shadows are left out: their borders would be lines of the sun and not of the land.
// - A light at the eye shines along each pixel's own ray, one beside it from one direction.
// - The width of lines by depth (section 3.4) is decided here, so that all later passes have the same, and it is blurred as
//   tones are: it does not jump where a near ridge stands before a far one.
// - Far and near are told by haze, as the widths of strokes are (lines/strokes/samples.wgsl).
// - A cell of the grid (shared/tone_grid.wgsl) is shaded once, by the mean of its pixels' normals.
#import hachure::view::{View, from_eye}
#import hachure::light::{Light, light_tone}
#import hachure::lit_normal::lit_normal
#import hachure::tone_grid::grid_of

struct ToneRules {
    // Unit, toward the light; all 0 is a light at the eye.
    to_light: vec3<f32>,
    // Strength of highlights, and their exponent.
    specular: f32,
    shininess: f32,
    width_px: f32,
    // How much wider near lines are than far ones.
    depth_width: f32,
    // How much of the form's normals light falls on, in place of the land's own.
    abstracted: f32,
    // Side of a cell of the grid.
    cell_px: i32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
// The style's; where it stands is said by the rules.
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> tone_rules: ToneRules;
@group(0) @binding(3) var position: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<f32>;
// One empty texel where nothing is abstracted.
@group(0) @binding(5) var form_normal: texture_2d<f32>;
// r: diffuse tone, 0 black to 1 white; g: specular; b: width of lines in pixels, all times a: which
// part of the cell is surface; all 0 is the sky.
@group(0) @binding(6) var tone_image: texture_storage_2d<rgba16float, write>;

// Widths by depth: at this part of the haze a line is as wide as asked, and these are the least and the most.
const AS_ASKED: f32 = 0.05;
const LEAST_WIDTH: f32 = 0.4;
const MOST_WIDTH: f32 = 1.6;
// The light reaches over the edge of the shade for highlights, within so much of its cosine.
const TERMINATOR: f32 = 0.2;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let grid = grid_of(view, tone_rules.cell_px);
    let cell = vec2<i32>(id.xy);
    if any(cell >= grid.size) {
        return;
    }
    // The first pixel that is surface stands for the cell, and the normals of those like it count.
    var pixel = vec2<i32>(0);
    var at = vec4<f32>(0.0);
    var is_land = false;
    var surfaces = 0.0;
    var alike = 0.0;
    var normals = vec4<f32>(0.0);
    for (var i = 0; i < grid.side_px * grid.side_px; i++) {
        let here_px = grid.first_px + grid.side_px * cell + vec2<i32>(i % grid.side_px, i / grid.side_px);
        let here_at = textureLoad(position, here_px, 0);
        let here = textureLoad(normal, here_px, 0);
        let is_surface = here_at.w > 0.0;
        if is_surface && surfaces == 0.0 {
            pixel = here_px;
            at = here_at;
            is_land = here.w == 1.0;
        }
        let counts = f32(is_surface && (here.w == 1.0) == is_land);
        surfaces += f32(is_surface);
        alike += counts;
        normals += select(vec4<f32>(0.0), here, counts > 0.0);
    }
    if surfaces == 0.0 {
        textureStore(tone_image, cell, vec4<f32>(0.0));
        return;
    }
    let own = vec4<f32>(normals.xyz * inverseSqrt(max(dot(normals.xyz, normals.xyz), 1e-12)), normals.w / alike);
    let n = lit_normal(view, form_normal, pixel, at, own, 1.0 - tone_rules.abstracted);
    let to_eye = -normalize(from_eye(view, at.xyz));
    var lit = light;
    lit.to_sun = select(tone_rules.to_light, to_eye, all(tone_rules.to_light == vec3<f32>(0.0)));
    let diffuse = light_tone(lit, n, vec2<f32>(1.0));
    var specular = 0.0;
    if tone_rules.specular > 0.0 {
        let between = to_eye + lit.to_sun;
        let half_way = between * inverseSqrt(max(dot(between, between), 1e-12));
        let is_lit = smoothstep(0.0, TERMINATOR, dot(n.xyz, lit.to_sun));
        specular = tone_rules.specular * is_lit * pow(max(dot(n.xyz, half_way), 0.0), tone_rules.shininess);
    }
    let nearness = clamp(light.haze_m * AS_ASKED / max(at.w, 1.0), LEAST_WIDTH, MOST_WIDTH);
    let width_px = max(tone_rules.width_px * mix(1.0, nearness, tone_rules.depth_width), 1.0);
    let part = surfaces / f32(grid.side_px * grid.side_px);
    textureStore(tone_image, cell, vec4<f32>(diffuse, specular, width_px, 1.0) * part);
}
