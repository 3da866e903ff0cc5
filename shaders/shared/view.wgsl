// The view of one eye. Positions are in metres, east-north-up, from the origin of the rig that the eye belongs to; this
// is the space that names call "camera". With one eye the origin is the eye.
#define_import_path hachure::view

struct View {
    clip_from_camera: mat4x4<f32>,
    // Takes this frame's positions to the previous frame's clip space.
    previous_clip_from_camera: mat4x4<f32>,
    // The ray through picture point p, at unit distance along the view axis, is corner + p.x * dx + p.y * dy.
    ray_corner: vec3<f32>,
    // Pixels per radian around the axis.
    focal_px: f32,
    ray_dx: vec3<f32>,
    // Distance of the near plane.
    near_m: f32,
    ray_dy: vec3<f32>,
    pad: f32,
    // Size of the targets, which may be a part of the picture.
    size_px: vec2<u32>,
    // Position of the targets' first pixel in the picture; a large picture is rendered in parts.
    origin_px: vec2<i32>,
    // Size of the whole picture.
    picture_px: vec2<f32>,
    // Displacement of the picture's content by jitter.
    jitter_px: vec2<f32>,
    // Position of the eye in its rig.
    eye_m: vec3<f32>,
    pad_eye: f32,
}

// Returns the ray through a position on the targets, at unit distance along the view axis.
fn ray_at(view: View, px: vec2<f32>) -> vec3<f32> {
    let p = px + vec2<f32>(view.origin_px);
    return view.ray_corner + p.x * view.ray_dx + p.y * view.ray_dy;
}

// Returns the ray through the centre of a pixel of the targets, at unit distance along the view axis.
fn ray_of_pixel(view: View, pixel: vec2<i32>) -> vec3<f32> {
    let p = vec2<f32>(pixel + view.origin_px) + 0.5;
    return view.ray_corner + p.x * view.ray_dx + p.y * view.ray_dy;
}

// Returns the point on the ray through the centre of a pixel, at a distance along the view axis.
fn place_of_pixel(view: View, pixel: vec2<i32>, depth_m: f32) -> vec3<f32> {
    return ray_of_pixel(view, pixel) * depth_m + view.eye_m;
}

// Returns the point on the ray through a position on the targets, at a distance along the view axis.
fn place_at(view: View, px: vec2<f32>, depth_m: f32) -> vec3<f32> {
    return ray_at(view, px) * depth_m + view.eye_m;
}

// Returns how far the content of a pixel has moved since the previous frame, in pixels. `point` is its position or,
// with 0 as its last coordinate, a direction, which the eye's movement does not affect. Jitter does not count as
// motion.
fn motion_of(view: View, pixel: vec2<i32>, point: vec4<f32>) -> vec2<f32> {
    let clip = view.previous_clip_from_camera * point;
    // A point off-screen or behind the previous eye has no position in its picture: it comes from far outside.
    let ndc = clip.xy / max(clip.w, 1e-6 * length(clip.xyz));
    let before_px = vec2<f32>(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * vec2<f32>(view.size_px);
    return vec2<f32>(pixel) + 0.5 - view.jitter_px - before_px;
}

// Returns the vector from the eye to a point.
fn from_eye(view: View, at_m: vec3<f32>) -> vec3<f32> {
    return at_m - view.eye_m;
}

// Returns the distance of a point from the eye.
fn distance_from_eye(view: View, at_m: vec3<f32>) -> f32 {
    return length(from_eye(view, at_m));
}

// Returns whether a sphere is off-screen: entirely beyond one of the four planes at the sides of the frustum.
fn is_off_screen(view: View, at_m: vec3<f32>, radius_m: f32) -> bool {
    var m = transpose(view.clip_from_camera);
    var off_screen = false;
    for (var side = 0u; side < 4u; side++) {
        let plane = m[3] + m[side / 2u] * select(-1.0, 1.0, side % 2u == 0u);
        off_screen = off_screen || dot(plane, vec4<f32>(at_m, 1.0)) < -radius_m * length(plane.xyz);
    }
    return off_screen;
}

// Returns the sine of a direction's height above a horizon that is below level. `up` is the sine of its height above
// level, `horizon` the cosine and the sine of the horizon's depression.
fn above_horizon(up: f32, horizon: vec2<f32>) -> f32 {
    return up * horizon.x + sqrt(max(1.0 - up * up, 0.0)) * horizon.y;
}
