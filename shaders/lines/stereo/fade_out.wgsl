// Contours of two eyes fade out softly where the surface turns away (Zaidi et al., section 4.2, "Contour Fade-Out").
//
// A smooth surface has its contour elsewhere for each eye. Between the two lies a strip that one eye sees and the other
// does not; it is darkened, with a soft border that both eyes see. So the line art has something dark at the same place
// of the surface for both.
//
// The viewpoints are those of a disc: its middle is between the eyes, its radius half of their distance, and it is
// perpendicular to the view direction, so that a head may tilt and nothing changes. Of them the one that sees the
// surface most nearly as a contour counts.
//
// Readings and changes:
// - The mean angle of the paper is that between the ways to this viewpoint and to the one across the disc: it does not
//   depend on the tilt of the head either.
// - The viewpoint is that on the border of the disc against the normal. It is the true one for surfaces that are far
//   compared with the disc's radius; for those as near as the eyes are apart it lies some degrees beside it.
// - Gate: a plane that is seen edge-on has no contour, and would be darkened whole. A fade that would be wider than
//   WIDEST_PX on the picture, as the normal turns here, is none.
// - Land whose back is seen, through a hole, has no contour either. Slightly turned away is what lies beside a contour.
#import hachure::view::View

struct FadeOut {
    // The middle of the eyes, in their rig.
    middle_m: vec3<f32>,
    // Half of what they are apart.
    radius_m: f32,
    // Unit.
    forward: vec3<f32>,
    // In mean angles from the contour: where the fade begins.
    start: f32,
    // Where it is full.
    end: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> fade_out: FadeOut;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;
@group(0) @binding(4) var line: texture_2d<f32>;
@group(0) @binding(5) var faded: texture_storage_2d<r32float, write>;

const WIDEST_PX: f32 = 64.0;
// A cosine: what is turned away from its eye by more shows its back.
const BACK: f32 = -0.1;

// How far the normal turns from a pixel to the next, in the direction where it turns more. Of two opposite neighbours
// the one that turns less counts: the other may be of what lies behind.
fn turn_per_px(pixel: vec2<i32>, n: vec3<f32>) -> f32 {
    let last = vec2<i32>(view.size_px) - 1;
    var most = 0.0;
    for (var axis = 0; axis < 2; axis++) {
        let step = select(vec2<i32>(0, 1), vec2<i32>(1, 0), axis == 0);
        let before = textureLoad(normal, clamp(pixel - step, vec2<i32>(0), last), 0).xyz;
        let after = textureLoad(normal, clamp(pixel + step, vec2<i32>(0), last), 0).xyz;
        most = max(most, min(distance(before, n), distance(after, n)));
    }
    return most;
}

fn fade(pixel: vec2<i32>) -> f32 {
    let at = textureLoad(position, pixel, 0);
    if at.w <= 0.0 {
        return 0.0;
    }
    let n = textureLoad(normal, pixel, 0).xyz;
    if dot(n, normalize(view.eye_m - at.xyz)) < BACK {
        return 0.0;
    }
    let across = n - fade_out.forward * dot(n, fade_out.forward);
    let aside = across * (fade_out.radius_m / max(length(across), 1e-6));
    let to_contour = fade_out.middle_m - aside - at.xyz;
    let to_opposite = fade_out.middle_m + aside - at.xyz;
    let angle = atan2(length(cross(to_contour, to_opposite)), dot(to_contour, to_opposite));
    // pi/2 - phi: how far the surface is from being a contour; below 0 the viewpoint sees its back.
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
