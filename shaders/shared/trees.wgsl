// Trees that an eye sees. See src/forest/mod.rs.
#define_import_path hachure::trees

// How a tree is drawn: as its mesh, as one of few triangles, from pictures, or as a part of the canopy, which stands for
// many.
const NEAR: u32 = 0u;
const MIDDLE: u32 = 1u;
const IMPOSTOR: u32 = 2u;
const CANOPY: u32 = 3u;
const TREE_LEVELS: u32 = 4u;
// Words of the arguments of a list's draw: vertices of a tree, trees, and the first of each.
const DRAW_WORDS: u32 = 4u;
// Parts of trees that are nearer to the eye along the view axis are not drawn: an eye within a crown looks out of it.
const CLEAR_M: f32 = 5.0;
// From a trunk this much farther away on, more of the tree goes with every step toward it, until all is gone: branches
// would hang in the air without it.
const CLEARING_M: f32 = 2.0;
// Smaller ones on the picture throw no shadow.
const SHADOW_PX: f32 = 8.0;

struct TreeInstance {
    // Where it stands: on the flat map, from the origin of the rig.
    flat_m: vec3<f32>,
    height_m: f32,
    // Sine and cosine of its turn.
    turn: vec2<f32>,
    // Its own unit, across.
    width_m: f32,
    // Of the surface.
    id: u32,
    // By how much it rises to the east and to the north: canopies lie on slopes.
    slope: vec2<f32>,
    // Of the dither pattern, those values that show it: in 16 bits each, from the first on and below the second.
    shown: u32,
    // Its species and level: species * TREE_LEVELS + level; from bit 16 on, how much light its site has, of 255; the
    // highest bit: strokes are found on it.
    bucket: u32,
}

fn species_of(tree: TreeInstance) -> u32 {
    return (tree.bucket & 0xffffu) / TREE_LEVELS;
}

// 0 to 1.
fn light_of(tree: TreeInstance) -> f32 {
    return f32((tree.bucket >> 16u) & 0xffu) / 255.0;
}

const HAS_STROKES: u32 = 0x80000000u;

fn has_strokes(tree: TreeInstance) -> bool {
    return (tree.bucket & HAS_STROKES) != 0u;
}

// The lightness of a tree's pixel and whether the tree has strokes, in one channel.
fn with_strokes(lightness: f32, tree: TreeInstance) -> f32 {
    return lightness + select(0.0, 2.0, has_strokes(tree));
}

fn shows_strokes(packed: f32) -> bool {
    return packed >= 2.0;
}

fn lightness_of(packed: f32) -> f32 {
    return packed - select(0.0, 2.0, shows_strokes(packed));
}

// A place of a tree, whose foot is at 0, in its own units; from its foot.
fn place_on_tree(tree: TreeInstance, own: vec3<f32>) -> vec3<f32> {
    let turn = mat2x2<f32>(vec2<f32>(tree.turn.y, tree.turn.x), vec2<f32>(-tree.turn.x, tree.turn.y));
    let across_m = turn * own.xy * tree.width_m;
    return vec3<f32>(across_m, own.z * tree.height_m + dot(across_m, tree.slope));
}

// Along the view axis: what is nearer of this tree is not drawn.
fn clear_m(tree: TreeInstance, eye_m: vec3<f32>) -> f32 {
    let foot_m = tree.flat_m - eye_m;
    let to_trunk_m = length(vec3<f32>(foot_m.xy, clamp(0.0, foot_m.z, foot_m.z + tree.height_m)));
    return mix(to_trunk_m + tree.height_m, CLEAR_M, smoothstep(CLEAR_M, CLEAR_M + CLEARING_M, to_trunk_m));
}

// The normal in the world of one in the tree's own units.
fn normal_on_tree(tree: TreeInstance, own: vec3<f32>) -> vec3<f32> {
    let turn = mat2x2<f32>(vec2<f32>(tree.turn.y, tree.turn.x), vec2<f32>(-tree.turn.x, tree.turn.y));
    let up = own.z / tree.height_m;
    return normalize(vec3<f32>(turn * own.xy / tree.width_m - up * tree.slope, up));
}

// A value of 0 to 1 for a pixel and a tree, well spread among neighbours (interleaved gradient noise: Jimenez 2014, "Next
// Generation Post Processing in Call of Duty: Advanced Warfare").
fn dither(pixel: vec2<f32>, id: u32) -> f32 {
    let own = fract(f32(id & 0xffffu) * 0.61803399);
    return fract(52.9829189 * fract(dot(floor(pixel), vec2<f32>(0.06711056, 0.00583715))) + own);
}

fn is_shown(tree: TreeInstance, pixel: vec2<f32>) -> bool {
    let shown = unpack2x16unorm(tree.shown);
    let value = dither(pixel, tree.id);
    return value >= shown.x && (value < shown.y || shown.y == 1.0);
}
