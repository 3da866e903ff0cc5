// Draws pieces of lines and points of features as strips with round ends. Where strips overlap, the darker one stays (max
// blending), so that joints are smooth.
//
// A line is on the surface. It is visible at a pixel unless it is behind the surface that the pixel sees, which is
// decided by the plane that touches the surface there. A dot is visible if its centre is.
#import hachure::view::{View, place_at, place_of_pixel, from_eye}
#import hachure::seen::normal_seen
#import hachure::line_ink::line_ink
#import hachure::draped::{DrapedPiece, DrapedRules, DOT}

// How far behind the plane a line is still visible, in pixels; and the least cosine of the angle between ray and normal
// that counts: along a crest, where it is 0, lines far behind would be visible.
const CLOSE_PX: f32 = 0.8;
const LEAST_FACING: f32 = 0.1;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: DrapedRules;
@group(0) @binding(2) var<storage, read> pieces: array<DrapedPiece>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) begin: vec4<f32>,
    @location(1) @interpolate(flat) end: vec4<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Vertex {
    let piece = pieces[index];
    let is_drawn = piece.begin.z > 0.0 && piece.end.z > 0.0;
    let width_px = select(rules.line_px, rules.point_px, piece.begin.w == DOT);
    let reach_px = 0.5 * max(width_px, 1.0) + 1.0;
    let along_px = piece.end.xy - piece.begin.xy;
    let length_px = length(along_px);
    let along = select(vec2<f32>(1.0, 0.0), along_px / length_px, length_px > 1e-4);
    let across = vec2<f32>(-along.y, along.x);
    // Two triangles: corners 0, 1, 2 and 2, 1, 3.
    let number = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u)[corner];
    let side = select(-1.0, 1.0, (number & 1u) == 1u);
    let px = select(piece.begin.xy - along * reach_px, piece.end.xy + along * reach_px, number >= 2u)
        + across * (side * reach_px);
    let ndc = (px / vec2<f32>(view.size_px) - 0.5) * vec2<f32>(2.0, -2.0);
    let clip = select(vec4<f32>(2.0, 2.0, 0.0, 1.0), vec4<f32>(ndc, 0.5, 1.0), is_drawn && width_px > 0.0);
    return Vertex(clip, piece.begin, piece.end);
}

// Returns whether a point at `px` and `depth_m` is not behind the surface that a pixel sees.
fn is_seen(pixel: vec2<i32>, px: vec2<f32>, depth_m: f32) -> bool {
    let seen_m = textureLoad(distance_m, pixel, 0).r;
    let surface_m = place_of_pixel(view, pixel, seen_m);
    let facing = normal_seen(normal, pixel);
    let toward_eye = select(facing, -facing, dot(facing, from_eye(view, surface_m)) > 0.0);
    let before_m = dot(toward_eye, place_at(view, px, depth_m) - surface_m);
    let close_m = CLOSE_PX * seen_m / view.focal_px;
    return seen_m > 0.0 && before_m >= -close_m && (depth_m - seen_m) * LEAST_FACING <= close_m;
}

// Returns how much of a dashed line is inked at a length along it. Dashes are about as long as their rule says: their
// length on the map is that times a power of two, so that it does not change while the eye approaches a little.
fn dash_ink(along_m: f32, depth_m: f32) -> f32 {
    if rules.gap_px <= 0.0 || rules.dash_px <= 0.0 {
        return 1.0;
    }
    let pixel_m = depth_m / view.focal_px;
    let period_m = (rules.dash_px + rules.gap_px) * exp2(round(log2(pixel_m)));
    let place = fract(along_m / period_m);
    let dash = rules.dash_px / (rules.dash_px + rules.gap_px);
    // Distance from the middle of the dash to its end, in pixels.
    let inside_px = (0.5 * dash - abs(place - 0.5 * dash)) * period_m / pixel_m;
    let from_next_px = (place - (1.0 + 0.5 * dash) + 0.5 * dash) * period_m / pixel_m;
    return clamp(max(inside_px, from_next_px) + 0.5, 0.0, 1.0);
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4<f32> {
    let along_px = in.end.xy - in.begin.xy;
    let away_px = in.clip.xy - in.begin.xy;
    let part = clamp(dot(away_px, along_px) / max(dot(along_px, along_px), 1e-6), 0.0, 1.0);
    // Distances are reciprocal on a straight line.
    let depth_m = 1.0 / mix(1.0 / in.begin.z, 1.0 / in.end.z, part);
    let centre_px = in.begin.xy + along_px * part;
    let is_dot = in.begin.w == DOT;
    let last = vec2<i32>(view.size_px) - 1;
    let own = vec2<i32>(in.clip.xy);
    let pixel = select(own, clamp(vec2<i32>(floor(centre_px)), vec2<i32>(0), last), is_dot);
    let ink = line_ink(length(in.clip.xy - centre_px), select(rules.line_px, rules.point_px, is_dot));
    var dash = 1.0;
    if !is_dot {
        dash = dash_ink(mix(in.begin.w, in.end.w, part), depth_m);
    }
    return vec4<f32>(select(0.0, ink * dash, is_seen(pixel, centre_px, depth_m)));
}
