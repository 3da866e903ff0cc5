// How wind moves trees: a function of the place where a tree stands, of the height above its foot, and of time. The numbers
// are those of src/scene/wind.rs.
//
// A tree bends as a rod does that stands firm: at its foot not at all, and with the square of the height above it; what
// would lean by more than MOST_LEAN of that height yields. Leaves of meshes flutter besides.
#define_import_path hachure::wind
#import hachure::trees::TreeInstance

// No part of a tree leans by more, by its height above the foot.
const MOST_LEAN: f32 = 0.2;

// A wave that runs over the land.
struct Wave {
    // Radians per metre to the east and to the north.
    per_m: vec2<f32>,
    // Where it is at the origin of the rig, in radians: in this frame and in the one before.
    now: f32,
    before: f32,
    // How much it moves along the wind and across it.
    along: f32,
    across: f32,
    // Radians per metre above the foot of a tree.
    per_m_up: f32,
    padding: f32,
}

struct Wind {
    // Unit: where it blows to.
    toward: vec2<f32>,
    // By how many metres trees lean in the mean, for each square metre of their height.
    mean_lean: f32,
    // How far leaves flutter, at most.
    flutter_m: f32,
    // Heights of trees on the picture at which leaves do not flutter any more, and from which on they do as they should.
    still_px: f32,
    flutter_px: f32,
    // The word of `tree_draws` that tells how many trees there are.
    counter: u32,
    padding: u32,
    // Gusts, and how trees swing.
    sways: array<Wave, 5>,
    // Of leaves.
    flutters: array<Wave, 2>,
}

// How a tree sways: metres to the east and to the north, for each square metre of its height.
struct Sway {
    now: vec2<f32>,
    before: vec2<f32>,
}

// That of the tree whose foot is at a place of the flat map, from the origin of the rig.
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

// What the lean at a height above the foot is of the sway.
fn lean_by_sway(sway: vec2<f32>, up_m: f32) -> f32 {
    let yields = length(sway) * up_m / MOST_LEAN;
    return up_m * up_m * inverseSqrt(1.0 + yields * yields);
}

// By how much a tree leans at a height above its foot, to the east and to the north.
fn lean_at(sway: vec2<f32>, up_m: f32) -> vec2<f32> {
    return sway * lean_by_sway(sway, up_m);
}

// How much of the flutter shows on a tree that is so tall on the picture.
fn flutter_shown(wind: Wind, tall_px: f32) -> f32 {
    return smoothstep(wind.still_px, wind.flutter_px, tall_px);
}

// Where a leaf flutters to that wind moves by all: in this frame, and in the one before.
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

// By how much wind moves a part of a mesh, whose place is told in the tree's own units and from its foot: in this frame,
// and in the one before. Both eyes see it flutter alike.
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
