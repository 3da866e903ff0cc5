// The trees that an eye sees. See src/forest/mod.rs.
#define_import_path hachure::trees

// Ways to draw a tree: its full mesh, a mesh of few triangles, an impostor, or a piece of canopy that represents many
// trees.
const NEAR: u32 = 0u;
const MIDDLE: u32 = 1u;
const IMPOSTOR: u32 = 2u;
const CANOPY: u32 = 3u;
const TREE_LEVELS: u32 = 4u;
// Words of the draw arguments of a list: vertices of a tree or indices of its mesh, trees, and zeros.
const DRAW_WORDS: u32 = 5u;
// Lists of trees: of each species its near and its middle meshes, then the impostors of all species, their pieces of
// canopy, and of each species the trees that cast shadows.
const MESH_LISTS: u32 = 2u;
const LISTS_OF_SPECIES: u32 = 3u;
const LISTS_OF_ALL: u32 = 2u;
// Trees of a block that one workgroup evaluates. Each is drawn as three instances at most: in two of the levels between
// which it dissolves, and as the piece of canopy that replaces it.
const TREES_OF_GROUP: u32 = 64u;
const INSTANCES_OF_TREE: u32 = 3u;
// Placeholder for a list that does not contain the instance.
const NO_LIST: u32 = 0xffffu;
// Depth along the view axis below which parts of trees are not drawn, so that an eye within a crown looks out of it.
const CLEAR_M: f32 = 5.0;
// Over this distance beyond CLEAR_M a tree disappears as the eye approaches its trunk: branches without their trunk
// would hang in the air.
const CLEARING_M: f32 = 2.0;
// Trees that are smaller on the picture cast no shadow.
const SHADOW_PX: f32 = 8.0;

struct TreeInstance {
    // Position of the foot on the flat map, in metres from the rig's origin.
    flat_m: vec3<f32>,
    height_m: f32,
    // Sine and cosine of its rotation.
    turn: vec2<f32>,
    // Metres across per tree unit.
    width_m: f32,
    // Number in the surface id.
    id: u32,
    // Rise to the east and to the north, in metres per metre: canopies follow slopes.
    slope: vec2<f32>,
    // Range of dither values that show the tree: the first one and the end, in 16 bits each.
    shown: u32,
    // Species and level: species * TREE_LEVELS + level; from bit 16 on, the light on its site, 0 to 255; the highest
    // bit: the tree has strokes.
    bucket: u32,
}

// Returns the list of a species and a level, in a forest of so many species.
fn list_of(all: u32, species: u32, level: u32) -> u32 {
    return select(species * MESH_LISTS + level, all * MESH_LISTS + level - MESH_LISTS, level >= MESH_LISTS);
}

// Returns the list of the shadows of a species.
fn list_of_shadows(all: u32, species: u32) -> u32 {
    return all * MESH_LISTS + LISTS_OF_ALL + species;
}

fn species_of(tree: TreeInstance) -> u32 {
    return (tree.bucket & 0xffffu) / TREE_LEVELS;
}

// Returns the light on a tree's site, 0 to 1.
fn light_of(tree: TreeInstance) -> f32 {
    return f32((tree.bucket >> 16u) & 0xffu) / 255.0;
}

const HAS_STROKES: u32 = 0x80000000u;

fn has_strokes(tree: TreeInstance) -> bool {
    return (tree.bucket & HAS_STROKES) != 0u;
}

// Packs the lightness of a tree's pixel, and whether the tree has strokes, into one channel.
fn with_strokes(lightness: f32, tree: TreeInstance) -> f32 {
    return lightness + select(0.0, 2.0, has_strokes(tree));
}

fn shows_strokes(packed: f32) -> bool {
    return packed >= 2.0;
}

fn lightness_of(packed: f32) -> f32 {
    return packed - select(0.0, 2.0, shows_strokes(packed));
}

// Returns the offset in metres from a tree's foot of a point in tree units.
fn place_on_tree(tree: TreeInstance, own: vec3<f32>) -> vec3<f32> {
    let turn = mat2x2<f32>(vec2<f32>(tree.turn.y, tree.turn.x), vec2<f32>(-tree.turn.x, tree.turn.y));
    let across_m = turn * own.xy * tree.width_m;
    return vec3<f32>(across_m, own.z * tree.height_m + dot(across_m, tree.slope));
}

// Returns the depth along the view axis below which this tree is not drawn.
fn clear_m(tree: TreeInstance, eye_m: vec3<f32>) -> f32 {
    let foot_m = tree.flat_m - eye_m;
    let to_trunk_m = length(vec3<f32>(foot_m.xy, clamp(0.0, foot_m.z, foot_m.z + tree.height_m)));
    return mix(to_trunk_m + tree.height_m, CLEAR_M, smoothstep(CLEAR_M, CLEAR_M + CLEARING_M, to_trunk_m));
}

// Returns the world normal of a normal in tree units.
fn normal_on_tree(tree: TreeInstance, own: vec3<f32>) -> vec3<f32> {
    let turn = mat2x2<f32>(vec2<f32>(tree.turn.y, tree.turn.x), vec2<f32>(-tree.turn.x, tree.turn.y));
    let up = own.z / tree.height_m;
    return normalize(vec3<f32>(turn * own.xy / tree.width_m - up * tree.slope, up));
}

// Returns a value of 0 to 1 for a pixel and a tree, well distributed among neighbours (interleaved gradient noise:
// Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced Warfare").
fn dither(pixel: vec2<f32>, id: u32) -> f32 {
    let own = fract(f32(id & 0xffffu) * 0.61803399);
    return fract(52.9829189 * fract(dot(floor(pixel), vec2<f32>(0.06711056, 0.00583715))) + own);
}

fn is_shown(tree: TreeInstance, pixel: vec2<f32>) -> bool {
    let shown = unpack2x16unorm(tree.shown);
    let value = dither(pixel, tree.id);
    return value >= shown.x && (value < shown.y || shown.y == 1.0);
}
