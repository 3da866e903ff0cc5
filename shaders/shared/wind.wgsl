// The motion of trees in wind: a function of the position of a tree, of the height above its foot, and of time. The
// constants are those of src/scene/wind.rs.
//
// A tree bends like a rod fixed at its foot: by the square of the height above it. A lean that would exceed MAX_LEAN
// of that height is limited. Leaves of meshes also flutter.
#define_import_path hachure::wind
#import hachure::trees::TreeInstance

// Largest lean of any part of a tree, in heights above the foot.
const MAX_LEAN: f32 = 0.2;

// A wave that travels over the land.
struct Wave {
    // Radians per metre to the east and to the north.
    per_m: vec2<f32>,
    // Phase at the rig's origin, in radians, in this frame and in the previous one.
    now: f32,
    before: f32,
    // Amplitudes along the wind and across it.
    along: f32,
    across: f32,
    // Radians per metre above the foot of a tree.
    per_m_up: f32,
    padding: f32,
}

struct Wind {
    // Unit vector: the direction that the wind blows to.
    toward: vec2<f32>,
    // Mean lean of trees, in metres per square metre of height.
    mean_lean: f32,
    // Largest flutter of leaves.
    flutter_m: f32,
    // Heights of trees on the picture below which leaves do not flutter, and above which they flutter fully.
    still_px: f32,
    flutter_px: f32,
    // Number of places for instances of trees.
    instances: u32,
    padding: u32,
    // Gusts, and the swinging of trees.
    sways: array<Wave, 5>,
    // Flutter of leaves.
    flutters: array<Wave, 2>,
}

// The sway of a tree: metres to the east and to the north, per square metre of height.
struct Sway {
    now: vec2<f32>,
    before: vec2<f32>,
}

// Returns the sway of the tree whose foot is at a point of the flat map, relative to the rig's origin.
fn sway_at(wind: Wind, foot_m: vec2<f32>) -> Sway {
    var shares = vec4<f32>(1.0, 0.0, 1.0, 0.0);
    for (var i = 0u; i < 5u; i++) {
        let wave = wind.sways[i];
        let swings = sin(dot(wave.per_m, foot_m) + vec2<f32>(wave.now, wave.before));
        shares += swings.xxyy * vec4<f32>(wave.along, wave.across, wave.along, wave.across);
    }
    shares *= wind.mean_lean;
    let across = vec2<f32>(-wind.toward.y, wind.toward.x);
    return Sway(shares.x * wind.toward + shares.y * across, shares.z * wind.toward + shares.w * across);
}

// Returns the lean at a height above the foot, as a factor of the sway.
fn lean_by_sway(sway: vec2<f32>, up_m: f32) -> f32 {
    let yields = length(sway) * up_m / MAX_LEAN;
    return up_m * up_m * inverseSqrt(1.0 + yields * yields);
}

// Returns the lean at a height above a tree's foot, in metres to the east and to the north.
fn lean_at(sway: vec2<f32>, up_m: f32) -> vec2<f32> {
    return sway * lean_by_sway(sway, up_m);
}

// Returns the part of the flutter that a tree of this height on the picture shows, 0 to 1.
fn flutter_shown(wind: Wind, tall_px: f32) -> f32 {
    return smoothstep(wind.still_px, wind.flutter_px, tall_px);
}

// Returns the displacement of a leaf that flutters fully, in this frame and in the previous one.
fn flutter_at(wind: Wind, at_m: vec2<f32>, up_m: f32) -> array<vec3<f32>, 2> {
    var swings: array<vec2<f32>, 2>;
    for (var i = 0u; i < 2u; i++) {
        let wave = wind.flutters[i];
        swings[i] = sin(dot(wave.per_m, at_m) + wave.per_m_up * up_m + vec2<f32>(wave.now, wave.before));
    }
    let first = wind.flutters[0];
    let second = wind.flutters[1];
    let along = first.along * swings[0] + second.along * swings[1];
    let up = first.across * swings[0] + second.across * swings[1];
    return array<vec3<f32>, 2>(
        wind.flutter_m * vec3<f32>(along.x * wind.toward, up.x),
        wind.flutter_m * vec3<f32>(along.y * wind.toward, up.y),
    );
}

// Returns the displacement of a part of a mesh by wind, in this frame and in the previous one. `own` is the part's
// position in tree units, `from_foot_m` its offset from the tree's foot. Both eyes see the same flutter.
fn moved_by_wind(
    wind: Wind,
    focal_px: f32,
    tree: TreeInstance,
    sway: Sway,
    own: vec4<f32>,
    from_foot_m: vec3<f32>,
) -> array<vec3<f32>, 2> {
    let up_m = own.z * tree.height_m;
    var moved = array<vec3<f32>, 2>(
        vec3<f32>(lean_at(sway.now, up_m), 0.0),
        vec3<f32>(lean_at(sway.before, up_m), 0.0),
    );
    let shown = own.w * flutter_shown(wind, tree.height_m * focal_px / max(length(tree.flat_m), 1e-3));
    if shown > 0.0 {
        let flutter = flutter_at(wind, tree.flat_m.xy + from_foot_m.xy, up_m);
        moved[0] += shown * flutter[0];
        moved[1] += shown * flutter[1];
    }
    return moved;
}
