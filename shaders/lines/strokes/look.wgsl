// Finds, for each sample of a stroke, the stroke at its position in another image of strokes: the previous frame's, or
// (PAIR) the other eye's.
//
// A sample's position there is exact: its own distance is known, and the world does not move. (Pietrok looks the motion
// up in an image, where a line on a contour straddles two motions.) Drawn strokes within REACH_PX are considered,
// nearest first; strokes that run in another direction or are at another distance do not count.
//
// PAIR: the contour of a smooth surface is elsewhere for the other eye. So a sample that finds nothing searches along
// its epipolar line (He, Wang and Bao 2019, section 4.2). Each surface point on this path is a contour for some
// viewpoint between the eyes, t of Eq. 3. A contour is epipolar-slidable if t increases from one eye to the other; the
// search ends at an extreme point, where t turns back, and where the surface ends. Changes: t is computed from the
// images of distance and normal, since there is one surface per pixel, and not from lists of extreme points; and both
// directions are searched, since one of them soon leaves the surface. The pass also finds whether the other eye sees
// the sample.
#import hachure::view::{View, place_at, ray_at}
#import hachure::seen::{normal_seen, place_seen}
#import hachure::stroke_samples::{Temporal, Sample, SampleCounts, Match, nearest_on, is_seam, WHOLLY_PX, LAST, FIRST, KIND_SHIFT}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> sample_counts: SampleCounts;
@group(0) @binding(2) var<storage, read> samples: array<Sample>;
@group(0) @binding(3) var<storage, read> old_samples: array<Sample>;
// Number of the other image's sample, plus 1.
@group(0) @binding(4) var ids: texture_2d<u32>;
@group(0) @binding(5) var<storage, read_write> matches: array<Match>;
#ifdef PAIR
// The other eye's view, without jitter like the strokes.
@group(0) @binding(6) var<uniform> other_view: View;
// Reversed depth: near / distance; 0 is the sky.
@group(0) @binding(7) var depth: texture_depth_2d;
// Distance and normal of the surface, as the other eye sees it.
@group(0) @binding(8) var distance_m: texture_2d<f32>;
@group(0) @binding(9) var normal: texture_2d<u32>;
// The other eye's view, jittered like these three images.
@group(0) @binding(10) var<uniform> seen_view: View;
#else
@group(0) @binding(6) var<uniform> temporal: Temporal;
#endif

const REACH_PX: i32 = 3;
// Smallest cosine between the directions of two strokes that match, and between a stroke and the epipolar line that it
// counts as running along: that of 45 degrees.
const MIN_COSINE: f32 = 0.7;
// Largest ratio between the distances of two strokes that match from one frame to the next.
const MAX_DEPTH_RATIO: f32 = 1.25;
// Largest distance of a match, in pixels. A line may move between frames. Ink that is farther away for the other eye
// does not match, because it is only one or two pixels wide.
const FRAME_APART_PX: f32 = 2.5;
const PAIR_APART_PX: f32 = 1.5;
// Cost of a factor of 2 in distance, in pixels. Both eyes see the same surface at the same time, so the cost between
// eyes is high.
const FRAME_DEPTH_COST_PX: f32 = 4.0;
const PAIR_DEPTH_COST_PX: f32 = 40.0;
// Length of the search along the epipolar line.
const SLIDE_PX: i32 = 12;
// Largest ratio of distances between neighbouring pixels of one surface, and the largest at grazing angles.
const JUMP_RATIO: f32 = 1.05;
const GRAZING_RATIO: f32 = 1.5;
// Sine of the angle within which two points count as in one plane.
const LEVEL: f32 = 0.1;
// Tolerance for t turning back, because the normals of land are rough.
const EXTREME: f32 = 0.1;
// A point is hidden if it is behind the surface by more than this part of its distance.
const HIDDEN: f32 = 0.01;

// Returns the size of the other picture. The previous frame's samples are in pixels of this frame.
fn other_px() -> vec2<u32> {
#ifdef PAIR
    return other_view.size_px;
#else
    return view.size_px;
#endif
}

// Returns the position on the other image, and the distance along the view axis.
fn on_picture(at_m: vec3<f32>) -> vec3<f32> {
#ifdef PAIR
    let clip = other_view.clip_from_camera * vec4<f32>(at_m, 1.0);
#else
    let clip = view.previous_clip_from_camera * vec4<f32>(at_m, 1.0);
#endif
    let size = vec2<f32>(other_px());
    let ndc = clip.xy / max(clip.w, 1e-6);
    return vec3<f32>((ndc * vec2<f32>(0.5, -0.5) + 0.5) * size, clip.w);
}

// Returns the stroke drawn near `place` that runs along `way`, or `nothing` if there is none like it.
fn look(place: vec3<f32>, way: vec2<f32>, nothing: Match) -> Match {
#ifdef PAIR
    let max_apart_px = PAIR_APART_PX;
    let depth_cost_px = PAIR_DEPTH_COST_PX;
    // A chain that joins a near edge to a far one has intermediate distances, for one eye more than for the other: a
    // stroke at another distance is better than none.
    let max_depth_ratio = 1e9;
#else
    let max_apart_px = FRAME_APART_PX;
    let depth_cost_px = FRAME_DEPTH_COST_PX;
    let max_depth_ratio = MAX_DEPTH_RATIO;
#endif
    var found = nothing;
#ifdef PAIR
    let ids_px = other_px();
#else
    // The ids of a previous frame may be those of another size.
    let ids_px = temporal.last_px;
#endif
    let size = vec2<i32>(ids_px);
    let middle = vec2<i32>(floor(place.xy * (vec2<f32>(ids_px) / vec2<f32>(other_px()))));
    var best = 1e9;
    var seen = 0u;
    for (var i = 0; i < (2 * REACH_PX + 1) * (2 * REACH_PX + 1); i++) {
        let pixel = middle + vec2<i32>(i % (2 * REACH_PX + 1), i / (2 * REACH_PX + 1)) - REACH_PX;
        if any(pixel < vec2<i32>(0)) || any(pixel >= size) {
            continue;
        }
        let id = textureLoad(ids, pixel, 0).r;
        if id == 0u || id == seen {
            continue;
        }
        seen = id;
        let a = old_samples[id - 1u];
        let b = old_samples[id];
        let near = nearest_on(a.px, b.px, place.xy);
        let apart_px = distance(near.px, place.xy);
        let cosine = dot(normalize(b.px - a.px + vec2<f32>(1e-6, 0.0)), way);
        let depth_ratio = mix(a.depth_m, b.depth_m, near.t) / place.z;
        if is_seam(a.along_px, b.along_px, distance(a.px, b.px)) {
            continue;
        }
        let is_like = abs(cosine) >= MIN_COSINE && max(depth_ratio, 1.0 / depth_ratio) <= max_depth_ratio;
        let cost = apart_px + 4.0 * (1.0 - abs(cosine)) + depth_cost_px * abs(log2(depth_ratio));
        if is_like && apart_px <= max_apart_px && cost < best {
            best = cost;
            found.stroke = a.stroke;
            // Beyond an end of the old stroke: its shown part ends there.
            let old_way = normalize(b.px - a.px + vec2<f32>(1e-6, 0.0));
            let beyond_px = dot(place.xy - near.px, old_way);
            found.along_px = mix(a.along_px, b.along_px, near.t) + beyond_px * sign(b.along_px - a.along_px);
            found.pressure = mix(a.pressure, b.pressure, near.t);
            found.shown_px = mix(a.shown_px, b.shown_px, near.t) - abs(beyond_px);
            found.direction_sign = select(-1.0, 1.0, cosine * (b.along_px - a.along_px) >= 0.0);
            found.to_old_line_px = near.px - place.xy + beyond_px * old_way;
            found.half_width_px = mix(a.half_width_px, b.half_width_px, near.t);
        }
    }
    return found;
}

#ifdef PAIR
// Returns the pixel of the surface at a position on the image of strokes.
fn pixel_at(px: vec2<f32>) -> vec2<i32> {
    return clamp(vec2<i32>(floor(px + other_view.jitter_px)), vec2<i32>(0), vec2<i32>(other_view.size_px) - 1);
}

fn depth_at_m(px: vec2<f32>) -> f32 {
    return other_view.near_m / max(textureLoad(depth, pixel_at(px), 0), 1e-30);
}

// Returns whether the other eye sees a point: some pixel around it has no nearer surface.
fn is_seen(place: vec3<f32>) -> bool {
    var farthest_m = 0.0;
    for (var i = 0; i < 9; i++) {
        farthest_m = max(farthest_m, depth_at_m(place.xy + vec2<f32>(vec2<i32>(i % 3, i / 3) - 1)));
    }
    return place.z * (1.0 - HIDDEN) <= farthest_m;
}

// Returns the viewpoint between the eyes, 0 for this one and 1 for the other, that sees a point as a contour (Eq. 3).
fn viewpoint(px: vec2<f32>) -> f32 {
    let pixel = pixel_at(px);
    let n = normal_seen(normal, pixel);
    let across = dot(other_view.eye_m - view.eye_m, n);
    return dot(place_seen(seen_view, distance_m, pixel).xyz - view.eye_m, n) / select(across, 1e-9, abs(across) < 1e-9);
}

// Returns whether the surface continues from a point of the previous pixel (with its distance along the view axis) to a
// pixel: the pixel is at the same distance or, at a grazing angle, in the same plane.
fn goes_on(before: vec4<f32>, pixel: vec2<i32>) -> bool {
    let at = place_seen(seen_view, distance_m, pixel);
    let way_m = at.xyz - before.xyz;
    let is_level = abs(dot(way_m, normal_seen(normal, pixel))) <= LEVEL * length(way_m);
    return max(at.w / before.w, before.w / max(at.w, 1e-30)) <= select(JUMP_RATIO, GRAZING_RATIO, is_level);
}

// Searches along the epipolar line of a sample, two pixels at a time and in both directions, as far as the surface
// continues.
fn slide(own: Sample, place: vec3<f32>, way: vec2<f32>, nothing: Match) -> Match {
    let farther = on_picture(place_at(view, own.px, 2.0 * own.depth_m));
    let along = farther.xy - place.xy;
    // A stroke that runs along its epipolar line has its partner on itself.
    if length(along) < 1e-3 || abs(dot(normalize(along), way)) > MIN_COSINE {
        return nothing;
    }
    let step = normalize(along);
    for (var turn = 0; turn < 2; turn++) {
        let sense = select(1.0, -1.0, turn == 1);
        var before = vec4<f32>(own.position_m, place.z);
        // The sample's own eye sees the point as a contour.
        var last = 0.0;
        for (var i = 2; i <= SLIDE_PX; i += 2) {
            let at = place.xy + step * (sense * f32(i));
            if !goes_on(before, pixel_at(at)) {
                break;
            }
            before = place_seen(seen_view, distance_m, pixel_at(at));
            let now = viewpoint(at);
            if now < last - EXTREME {
                break;
            }
            last = now;
            let found = look(vec3<f32>(at, place.z), way, nothing);
            if found.stroke != 0u {
                return found;
            }
        }
    }
    return nothing;
}
#endif

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= sample_counts.fresh {
        return;
    }
    let own = samples[id.x];
    var found = Match(0u, 0.0, 0.0, 1.0, vec2<f32>(0.0), 0.0, matches[id.x].at_px, -WHOLLY_PX, 0u);
    let place = on_picture(own.position_m);
    let size = vec2<f32>(other_px());
    if place.z >= view.near_m && all(place.xy >= vec2<f32>(-8.0)) && all(place.xy <= size + 8.0) {
        // A last sample uses the direction from the sample before it.
        let is_last = (own.flags & LAST) != 0u;
        let next_px = on_picture(samples[select(id.x + 1u, max(id.x, 1u) - 1u, is_last)].position_m).xy;
        let ahead = select(next_px - place.xy, place.xy - next_px, is_last);
        let way = normalize(ahead + vec2<f32>(1e-6, 0.0));
        found = look(place, way, found);
#ifdef PAIR
        let is_inside = all(place.xy >= vec2<f32>(0.0)) && all(place.xy < size);
        found.is_seen = u32(is_inside && is_seen(place));
        let is_contour = (own.flags >> KIND_SHIFT) == 0u;
        if found.stroke == 0u && is_contour && is_inside {
            let is_seen = found.is_seen;
            found = slide(own, place, way, found);
            found.is_seen = is_seen;
        }
#endif
    }
    matches[id.x] = found;
}
