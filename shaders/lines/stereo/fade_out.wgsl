// Contours of a stereo pair fade out softly where the surface turns away (Zaidi et al., section 4.2, "Contour
// Fade-Out").
//
// A smooth surface has its contour at a different place for each eye. Between the two is a strip that only one eye
// sees; it is darkened, with a soft border that both eyes see. So both eyes find something dark at the same place of
// the surface.
//
// The viewpoints are those of a disc: its centre is between the eyes, its radius is half of their distance, and it is
// perpendicular to the view direction, so that tilting the head changes nothing. The viewpoint that sees the surface
// most nearly as a contour counts.
//
// Interpretations and changes:
// - The mean angle of the paper is the one between the directions to this viewpoint and to the opposite one on the
//   disc: it does not depend on the tilt of the head either.
// - The viewpoint is the one on the border of the disc opposite to the normal. It is exact for surfaces that are far
//   compared with the disc's radius; for surfaces as near as the distance of the eyes it is some degrees off.
// - Gate: a plane that is seen edge-on has no contour, and would be darkened entirely. A fade that would be wider than
//   WIDEST_PX on the picture, given how the normal changes there, is suppressed.
// - Land whose back is visible through a hole has no contour either. Surfaces turned away slightly are next to a
//   contour.
#import hachure::view::View
#import hachure::seen::{normal_seen, place_seen}

struct FadeOut {
    // Midpoint between the eyes, in their rig.
    middle_m: vec3<f32>,
    // Half of the distance between the eyes.
    radius_m: f32,
    // Unit vector, the view direction.
    forward: vec3<f32>,
    // Angle from the contour at which the fade begins, in mean angles.
    start: f32,
    // Angle at which the fade is complete, in mean angles.
    end: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> fade_out: FadeOut;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var line: texture_2d<f32>;
@group(0) @binding(5) var faded: texture_storage_2d<r32float, write>;

const WIDEST_PX: f32 = 64.0;
// Cosine between normal and direction to the eye below which the back of the surface is visible.
const BACK: f32 = -0.1;

// Returns how much the normal changes from a pixel to the next, in the axis of the greater change. Of two opposite
// neighbours the smaller change counts, since the other may be of a surface behind.
fn turn_per_px(pixel: vec2<i32>, n: vec3<f32>) -> f32 {
    let last = vec2<i32>(view.size_px) - 1;
    var most = 0.0;
    for (var axis = 0; axis < 2; axis++) {
        let step = select(vec2<i32>(0, 1), vec2<i32>(1, 0), axis == 0);
        let before = normal_seen(normal, clamp(pixel - step, vec2<i32>(0), last));
        let after = normal_seen(normal, clamp(pixel + step, vec2<i32>(0), last));
        most = max(most, min(distance(before, n), distance(after, n)));
    }
    return most;
}

fn fade(pixel: vec2<i32>) -> f32 {
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        return 0.0;
    }
    let n = normal_seen(normal, pixel);
    if dot(n, normalize(view.eye_m - at.xyz)) < BACK {
        return 0.0;
    }
    let across = n - fade_out.forward * dot(n, fade_out.forward);
    let aside = across * (fade_out.radius_m / max(length(across), 1e-6));
    let to_contour = fade_out.middle_m - aside - at.xyz;
    let to_opposite = fade_out.middle_m + aside - at.xyz;
    let angle = atan2(length(cross(to_contour, to_opposite)), dot(to_contour, to_opposite));
    // pi/2 - phi: the angle from being a contour; negative if the viewpoint sees the back of the surface.
    let open = asin(clamp(dot(n, normalize(to_contour)), -1.0, 1.0));
    let start = fade_out.start * angle;
    let value = clamp((start - open) / max(start - fade_out.end * angle, 1e-12), 0.0, 1.0);
    if value <= 0.0 {
        return 0.0;
    }
    return value * clamp(turn_per_px(pixel, n) * WIDEST_PX / max(start, 1e-12), 0.0, 1.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let value = max(textureLoad(line, pixel, 0).r, fade(pixel));
    textureStore(faded, pixel, vec4<f32>(value, 0.0, 0.0, 0.0));
}
