// The tone image: the shading in which lines from shading are found.
//
// Lee, Markosian, Lee and Hughes 2007, "Line drawings via abstracted shading", section 3: a line drawing is an
// abstraction of the shaded picture, so that is made first. Diffuse light and specular highlights have separate
// channels, since broad bright tones often hide highlights (section 1); the light is arbitrary. With "abstracted
// normals" (section 3.4) the land is lit by its form (surface/form.wgsl) and not by each of its samples, as its base
// coat may be.
//
// Interpretations and changes:
// - Diffuse light is the tone of the style's light (shared/light.wgsl), so that lines continue where the base coat
//   ends. Cast shadows are omitted: their borders would be lines of the sun and not of the land.
// - A light at the eye shines along each pixel's own ray, any other light from one direction.
// - The width of lines by depth (section 3.4) is determined here, so that all later passes agree, and it is blurred
//   like tones: it does not jump where a near ridge is in front of a far one.
// - Haze determines what is near and far, as for the widths of strokes (lines/strokes/samples.wgsl).
// - A cell of the grid (shared/tone_grid.wgsl) is shaded once, by the mean of its pixels' normals.
#import hachure::power::power
#import hachure::view::{View, from_eye}
#import hachure::seen::{place_seen, surface_seen}
#import hachure::light::{Light, light_tone}
#import hachure::lit_normal::lit_normal
#import hachure::tone_grid::grid_of

struct ToneRules {
    // Unit vector toward the light; all 0 is a light at the eye.
    to_light: vec3<f32>,
    // Strength of highlights, and their exponent.
    specular: f32,
    shininess: f32,
    width_px: f32,
    // How much wider near lines are than far ones, 0 to 1.
    depth_width: f32,
    // Part of the form's normals in the normals that are lit, 0 to 1; the land's own are the rest.
    abstracted: f32,
    // Side of a cell of the grid, in pixels.
    cell_px: i32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
// The style's light; `tone_rules` replaces its direction.
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> tone_rules: ToneRules;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
// One empty texel if nothing is abstracted.
@group(0) @binding(5) var form_normal: texture_2d<f32>;
// r: diffuse tone, 0 black to 1 white; g: specular; b: width of lines in pixels, all multiplied by a: the part of the
// cell that is surface; all 0 is the sky.
@group(0) @binding(6) var tone_image: texture_storage_2d<rgba16float, write>;

// Widths by depth: part of the haze distance at which a line has its nominal width, and the least and greatest factor.
const AS_ASKED: f32 = 0.05;
const MIN_WIDTH: f32 = 0.4;
const MAX_WIDTH: f32 = 1.6;
// Range of the cosine to the light, at the edge of the shade, over which highlights fade in.
const TERMINATOR: f32 = 0.2;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let grid = grid_of(view, tone_rules.cell_px);
    let cell = vec2<i32>(id.xy);
    if any(cell >= grid.size) {
        return;
    }
    // The first pixel of a surface represents the cell, and normals of the same kind of surface are averaged.
    var pixel = vec2<i32>(0);
    var at = vec4<f32>(0.0);
    var is_land = false;
    var surfaces = 0.0;
    var alike = 0.0;
    var normals = vec4<f32>(0.0);
    for (var i = 0; i < grid.side_px * grid.side_px; i++) {
        let here_px = grid.first_px + grid.side_px * cell + vec2<i32>(i % grid.side_px, i / grid.side_px);
        let here_at = place_seen(view, distance_m, here_px);
        let here = surface_seen(normal, here_px);
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
        specular = tone_rules.specular * is_lit * power(dot(n.xyz, half_way), tone_rules.shininess);
    }
    let nearness = clamp(light.haze_m * AS_ASKED / max(at.w, 1.0), MIN_WIDTH, MAX_WIDTH);
    let width_px = max(tone_rules.width_px * mix(1.0, nearness, tone_rules.depth_width), 1.0);
    let part = surfaces / f32(grid.side_px * grid.side_px);
    textureStore(tone_image, cell, vec4<f32>(diffuse, specular, width_px, 1.0) * part);
}
