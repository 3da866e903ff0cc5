// Draws marks of rows as ink: a strip along the samples of each.
//
// There is one instance per mark: a strip with two corners at each sample, mitred there, and wider by a fringe for the
// border's coverage. Marks narrower than a pixel are paler instead. Where marks of two levels overlap, the darker one
// stays. A pixel is inked where it shows the land that the mark is on.
#import hachure::view::View
#import hachure::seen::place_seen
#import hachure::rows::{RowRules, SAMPLES}
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: RowRules;
@group(0) @binding(2) var<storage, read> marks: array<vec4<f32>>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var surface_id: texture_2d<u32>;

const FRINGE_PX: f32 = 0.75;
// Largest distance of a mark behind the land at its pixel: in spacings, and relative to the distance.
const BEHIND: f32 = 4.0;
const BEHIND_PART: f32 = 0.004;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(linear) across_px: f32,
    @location(1) @interpolate(linear) half_width_px: f32,
    @location(2) @interpolate(linear) depth_m: f32,
}

fn direction(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    let d = b - a;
    let l = length(d);
    return select(vec2<f32>(0.0), d / l, l > 1e-4);
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Vertex {
    if instance >= rules.max_marks {
        return Vertex(vec4<f32>(2.0, 2.0, 0.0, 1.0), 0.0, 0.0, 1.0);
    }
    let first = instance * u32(SAMPLES);
    let number = corner / 2u;
    let side = select(1.0, -1.0, (corner & 1u) == 1u);
    let at = marks[first + number];
    let into = direction(marks[first + max(number, 1u) - 1u].xy, at.xy);
    let out = direction(at.xy, marks[first + min(number + 1u, u32(SAMPLES) - 1u)].xy);
    // At an end of the mark one of the two is 0, and beyond it both are: there the strip has no area.
    var tangent = into + out;
    let turn = length(tangent);
    tangent = select(out, tangent / turn, turn > 0.5);
    let mitre = min(1.0 / max(max(dot(tangent, into), dot(tangent, out)), 0.25), 2.0);
    let reach = max(at.z, 0.5) + FRINGE_PX;
    let px = at.xy + vec2<f32>(tangent.y, -tangent.x) * (side * reach * mitre);
    let ndc = px / vec2<f32>(view.size_px) * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
    return Vertex(vec4<f32>(ndc, 0.0, 1.0), side * reach, at.z, at.w);
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4<f32> {
    let half_width = max(in.half_width_px, 0.5);
    let covered = clamp(half_width - abs(in.across_px) + 0.5, 0.0, 1.0) * in.half_width_px / half_width;
    let pixel = vec2<i32>(in.clip.xy);
    let land = place_seen(view, distance_m, pixel);
    let allowed_m = land.w * (1.0 + BEHIND_PART) + BEHIND * rules.spacing_px * land.w / view.focal_px;
    let is_hidden = land.w <= 0.0 || in.depth_m > allowed_m || !has_trait(id_seen(surface_id, pixel), ON_GRID);
    // Written so that NaN, from a strip without area, is discarded too.
    if is_hidden || !(covered >= 1.0 / 512.0) {
        discard;
    }
    return vec4<f32>(covered);
}
