// What images on the land say about each pixel: a hue with its strength, and a factor of the light.
//
// Images are in tiles on the grid of heights, in a quadtree. The level of a pixel is that of its footprint, a continuous
// function of its distance and of the angle at which land is seen, so nothing pops: two levels are mixed. A level whose tile is missing or fades in leaves
// its share to the next coarser one. On land that is seen at a grazing angle the footprint is long: several points along
// it are read.
#import hachure::view::{View, from_eye}
#import hachure::seen::{place_seen, normal_seen}
#import hachure::earth::unbend
#import hachure::terrain::grid_from_world
#import hachure::surface_id::{id_seen, has_trait, ON_GRID}
#import hachure::color::{linear_from_srgb, luminance, srgb_from_linear}

// Texels of a tile along a side, and of border on each side.
const TILE_TEXELS: i32 = 256;
const BORDER: i32 = 2;
const TILE_SHIFT: u32 = 8u;
const MOST_LEVELS: i32 = 24;
const NO_NODE: i32 = -1;
const NO_SLOT: i32 = -1;
// Largest number of points along a footprint.
const MOST_POINTS: f32 = 4.0;
// Luminance from which on a colour has its whole hue: darker ones are noise.
const DARKEST: f32 = 0.01;

// A tile that the view needs.
struct ImageNode {
    // Index of the first of the four tiles below it: north-west, north-east, south-west, south-east in the order of columns
    // and rows; NO_NODE if the view needs none.
    first_child: i32,
    // Layer of its texels; NO_SLOT if it is not loaded.
    slot: i32,
    // How far it has faded in, 0 to 1.
    fade: f32,
    // 1 if the view needs this tile; 0 only fills up the four.
    is_there: i32,
}

struct DrapedImage {
    // Texel of level 0 at which the first half of the anchor's sample begins: whole texels, and the rest.
    cell: vec2<i32>,
    fraction: vec2<f32>,
    // Texels of level 0 per sample of the heights, and their distance.
    texels_per_sample: f32,
    texel_m: f32,
    focal_px: f32,
    // Levels by which the images are coarser.
    bias: f32,
    // The coarsest level.
    top: i32,
    // Strength of hues, and of tones, 0 to 1.
    color: f32,
    tone: f32,
    // Added to each channel, -1 to 1.
    brightness: f32,
    // Factor of the distance of each channel from the middle.
    contrast: vec3<f32>,
    pad: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> draped: DrapedImage;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var surface_id: texture_2d<u32>;
@group(0) @binding(5) var image_tiles: texture_2d_array<f32>;
@group(0) @binding(6) var image_sampler: sampler;
@group(0) @binding(7) var<storage, read> image_nodes: array<ImageNode>;
// r: the square root of a linear colour in three bytes, and the strength of its hue, as in `shared/local_color.wgsl`.
// g: factor of the light, as the bits of a float.
@group(0) @binding(8) var draped_image: texture_storage_2d<rg32uint, write>;

// Returns the colour times its opacity, and the opacity, at a grid coordinate, at a continuous level.
fn image_at(g: vec2<f32>, wanted: f32) -> vec4<f32> {
    let t = g * draped.texels_per_sample + draped.fraction;
    let whole = floor(t);
    let cell = max(vec2<i32>(whole) + draped.cell, vec2<i32>(0));
    let f = t - whole;
    // From the root to the finest tile that is wanted.
    var path = array<i32, MOST_LEVELS>();
    let finest = i32(wanted);
    var level = draped.top;
    var index = 0;
    path[level] = 0;
    while level > finest && image_nodes[index].first_child != NO_NODE {
        let below = (cell >> vec2<u32>(TILE_SHIFT + u32(level - 1))) & vec2<i32>(1);
        let child = image_nodes[index].first_child + below.x + 2 * below.y;
        if image_nodes[child].is_there == 0 {
            break;
        }
        index = child;
        level -= 1;
        path[level] = index;
    }
    // And back, until nothing is left.
    var sum = vec4<f32>(0.0);
    var rest = 1.0;
    while level <= draped.top && rest > 0.0 {
        let node = image_nodes[path[level]];
        if node.slot != NO_SLOT {
            let share = select(clamp(f32(level + 1) - wanted, 0.0, 1.0) * node.fade, 1.0, level == draped.top);
            let texel = f32(1u << u32(level));
            let in_tile = vec2<f32>((cell >> vec2<u32>(u32(level))) & vec2<i32>(TILE_TEXELS - 1));
            let within = (vec2<f32>(cell & vec2<i32>((1 << u32(level)) - 1)) + f) / texel;
            let uv = (in_tile + within + f32(BORDER)) / f32(TILE_TEXELS + 2 * BORDER);
            sum += rest * share * textureSampleLevel(image_tiles, image_sampler, uv, node.slot, 0.0);
            rest *= 1.0 - share;
        }
        level += 1;
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    var words = vec2<u32>(0u, bitcast<u32>(1.0));
    if at.w > 0.0 && has_trait(id_seen(surface_id, pixel), ON_GRID) {
        let n = normal_seen(normal, pixel);
        let ray = normalize(from_eye(view, at.xyz));
        let facing = max(abs(dot(ray, n)), 1e-3);
        let pixel_m = length(at.xyz) / draped.focal_px;
        // The long axis of the footprint, on the surface.
        let along = ray - n * dot(ray, n);
        let long_m = pixel_m / facing;
        let points = clamp(ceil(1.0 / facing), 1.0, MOST_POINTS);
        let wide_m = max(pixel_m, min(long_m / points, 4.0 * pixel_m));
        let wanted = clamp(log2(wide_m / draped.texel_m) + draped.bias, 0.0, f32(draped.top));
        let place = grid_from_world(unbend(at.xyz).flat_m.xy);
        let step_m = along.xy / max(length(along), 1e-6) * (long_m / points);
        let step = place.dg_dx * step_m.x + place.dg_dy * step_m.y;
        var seen = vec4<f32>(0.0);
        for (var point = 0.0; point < points; point += 1.0) {
            seen += image_at(place.g + step * (point + 0.5 - 0.5 * points), wanted);
        }
        seen /= points;
        let stored = srgb_from_linear(seen.rgb / max(seen.a, 1e-4));
        let shade = clamp((stored - 0.5) * draped.contrast + 0.5 + draped.brightness, vec3<f32>(0.0), vec3<f32>(1.0));
        let color = linear_from_srgb(shade);
        let light = luminance(color);
        let lightness = srgb_from_linear(vec3<f32>(light)).r;
        let hue = draped.color * seen.a * smoothstep(0.0, DARKEST, light);
        words = vec2<u32>(
            pack4x8unorm(vec4<f32>(sqrt(color), hue)),
            bitcast<u32>(1.0 - draped.tone * seen.a * (1.0 - lightness)));
    }
    textureStore(draped_image, pixel, vec4<u32>(words, 0u, 0u));
}
