// The pictures of a tree from all directions above the horizon, and the tree's space: that of a tree 1 unit tall and
// wide, with its foot at 0. See src/forest/impostor.rs.
#define_import_path hachure::tree_pictures
#import hachure::trees::TreeInstance

// Pictures along each side of the map of pictures.
const FRAMES: f32 = 24.0;

// Returns the inverse of the tree's rotation.
fn back_of(tree: TreeInstance) -> mat2x2<f32> {
    return mat2x2<f32>(vec2<f32>(tree.turn.y, -tree.turn.x), vec2<f32>(tree.turn.x, tree.turn.y));
}

// Transforms a world offset from the tree's foot to tree units, in which the tree is 1 tall and wide.
fn own_of(tree: TreeInstance, from_foot_m: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(back_of(tree) * from_foot_m.xy / tree.width_m,
        (from_foot_m.z - dot(from_foot_m.xy, tree.slope)) / tree.height_m);
}

// Returns the picture whose direction is nearest to this one; directions below the horizon use one at the horizon.
fn frame_near(direction: vec3<f32>) -> vec2<f32> {
    let d = vec3<f32>(direction.xy, max(direction.z, 0.0));
    let p = d.xy / max(abs(d.x) + abs(d.y) + d.z, 1e-6);
    let uv = vec2<f32>(p.x + p.y, p.x - p.y);
    return clamp(round((uv * 0.5 + 0.5) * (FRAMES - 1.0)), vec2<f32>(0.0), vec2<f32>(FRAMES - 1.0));
}

fn direction_of(frame: vec2<f32>) -> vec3<f32> {
    let uv = frame / (FRAMES - 1.0) * 2.0 - 1.0;
    let p = 0.5 * vec2<f32>(uv.x + uv.y, uv.x - uv.y);
    return normalize(vec3<f32>(p, 1.0 - abs(p.x) - abs(p.y)));
}

// Returns the axes of a picture taken from a direction: right, up, toward the eye.
fn axes_of(direction: vec3<f32>) -> mat3x3<f32> {
    let right = normalize(vec3<f32>(-direction.y, direction.x, 0.0));
    return mat3x3<f32>(right, cross(direction, right), direction);
}

// Returns where a ray enters and leaves an upright cylinder (radius, bottom, top); both are equal if it misses.
fn cross_cylinder(cylinder: vec4<f32>, origin: vec3<f32>, ray: vec3<f32>) -> vec2<f32> {
    let a = max(dot(ray.xy, ray.xy), 1e-9);
    let b = dot(origin.xy, ray.xy);
    let inner = b * b - a * (dot(origin.xy, origin.xy) - cylinder.x * cylinder.x);
    if inner <= 0.0 {
        return vec2<f32>(0.0);
    }
    let around = (vec2<f32>(-1.0, 1.0) * sqrt(inner) - b) / a;
    let rising = select(ray.z, 1e-9, abs(ray.z) < 1e-9);
    let levels = (cylinder.yz - origin.z) / rising;
    return vec2<f32>(max(max(around.x, min(levels.x, levels.y)), 0.0), min(around.y, max(levels.x, levels.y)));
}
