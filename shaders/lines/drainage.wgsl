// Draws streams or ridge lines, which follow from how the land drains (src/drainage), as strips that grow wider with the
// area that drains through them.
//
// There is one instance for each pair of consecutive points, a strip with round ends. Where strips overlap, the darker
// one stays (max blending), so that joints are smooth. A line is drawn from the point on through which a given area of
// the picture drains: the farther away the land is, the fewer lines it has.
#import hachure::view::View
#import hachure::earth::bend
#import hachure::line_ink::line_ink

struct DrainagePoint {
    // Position in metres, from the origin of the lines, on the flat map.
    at_m: vec3<f32>,
    // Binary logarithm of the area that drains through the point, in m²; LAST_OF_LINE at the last point of a line.
    rank: f32,
    // Tangent of the slope on the gentler side of the line.
    relief: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

struct DrainageRules {
    // Origin of the lines, in metres from the rig's origin.
    origin_m: vec3<f32>,
    // Width where a line begins to be drawn.
    line_px: f32,
    // Largest width.
    widest_px: f32,
    // Side of the square on the picture whose area must drain through a line.
    spacing_px: f32,
    // Relief from which on a line begins to be drawn; 0 draws all lines.
    min_relief: f32,
    // Distance by which a line may be behind the visible land, besides BEHIND.
    behind_m: f32,
}

// Rank of the last point of each line.
const LAST_OF_LINE: f32 = -1000.0;
// A line is as wide as it gets where 2^WIDEST_RANK times the least area drains through it.
const WIDEST_RANK: f32 = 8.0;
// Part of the distance by which a line may be behind the visible land: its heights are those of samples, and the land is
// drawn within the allowed error.
const BEHIND: f32 = 0.01;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: DrainageRules;
@group(0) @binding(2) var<storage, read> points: array<DrainagePoint>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
// Positive on water. A single texel without water.
@group(0) @binding(4) var water: texture_2d<f32>;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) a_px: vec2<f32>,
    @location(1) @interpolate(flat) b_px: vec2<f32>,
    // Distance along the view axis, width and relief at both ends.
    @location(2) @interpolate(flat) a: vec3<f32>,
    @location(3) @interpolate(flat) b: vec3<f32>,
}

struct End {
    px: vec2<f32>,
    depth_m: f32,
    width_px: f32,
    is_there: bool,
}

fn nothing() -> Vertex {
    return Vertex(vec4<f32>(2.0, 2.0, 0.0, 1.0), vec2<f32>(0.0), vec2<f32>(0.0), vec3<f32>(1.0), vec3<f32>(1.0));
}

// Projects a point; `rank` is that of the end from which the line flows on.
fn end_of(point: DrainagePoint, rank: f32) -> End {
    let at_m = bend(point.at_m + rules.origin_m);
    let clip = view.clip_from_camera * vec4<f32>(at_m, 1.0);
    let px = (clip.xy / max(clip.w, 1e-6) * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(view.size_px);
    let pixel_m = max(clip.w, view.near_m) / view.focal_px;
    let above = rank - 2.0 * log2(rules.spacing_px * pixel_m);
    let growth = clamp(above / WIDEST_RANK, 0.0, 1.0);
    let width_px = mix(rules.line_px, rules.widest_px, growth) * clamp(above, 0.0, 1.0);
    return End(px, clip.w, width_px, clip.w > view.near_m);
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) segment: u32) -> Vertex {
    let first = points[segment];
    if first.rank == LAST_OF_LINE {
        return nothing();
    }
    let second = points[segment + 1u];
    let a = end_of(first, first.rank);
    let b = end_of(second, select(second.rank, first.rank, second.rank == LAST_OF_LINE));
    if !a.is_there || !b.is_there || max(a.width_px, b.width_px) <= 0.0 {
        return nothing();
    }
    let reach_px = 0.5 * max(a.width_px, b.width_px) + 1.0;
    let along_px = b.px - a.px;
    let length_px = length(along_px);
    let along = select(vec2<f32>(1.0, 0.0), along_px / length_px, length_px > 1e-4);
    let across = vec2<f32>(-along.y, along.x);
    // Two triangles: corners 0, 1, 2 and 2, 1, 3.
    let number = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u)[corner];
    let is_end = number >= 2u;
    let side = select(-1.0, 1.0, (number & 1u) == 1u);
    let px = select(a.px - along * reach_px, b.px + along * reach_px, is_end) + across * (side * reach_px);
    let ndc = (px / vec2<f32>(view.size_px) - 0.5) * vec2<f32>(2.0, -2.0);
    return Vertex(vec4<f32>(ndc, 0.5, 1.0), a.px, b.px, vec3<f32>(a.depth_m, a.width_px, first.relief),
        vec3<f32>(b.depth_m, b.width_px, second.relief));
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.clip.xy);
    let from_a = in.clip.xy - in.a_px;
    let along_px = in.b_px - in.a_px;
    let part = clamp(dot(from_a, along_px) / max(dot(along_px, along_px), 1e-6), 0.0, 1.0);
    let at = mix(in.a, in.b, part);
    let seen_m = textureLoad(distance_m, pixel, 0).r;
    let on_water = textureLoad(water, min(pixel, vec2<i32>(textureDimensions(water)) - 1), 0).r > 0.0;
    let is_hidden = seen_m <= 0.0 || at.x > seen_m * (1.0 + BEHIND) + rules.behind_m;
    let has_relief = select(smoothstep(rules.min_relief, 1.5 * rules.min_relief, at.z), 1.0, rules.min_relief == 0.0);
    let ink = line_ink(length(from_a - along_px * part), at.y) * has_relief;
    return vec4<f32>(select(ink, 0.0, on_water || is_hidden));
}
