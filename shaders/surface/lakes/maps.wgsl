// Computes the signed distance of each sample of a tile from the shore: the second half of the transform that `columns`
// begins.
//
// The nearest of the shores that the columns on both sides found is almost the nearest of all; of the pieces of shore
// around it, each a sample long, the nearest decides.
#import hachure::map_job::MapJob
#import hachure::water_maps::{code_of, AROUND, SIDE, SHORE_REACH, MAP_WORDS, MAP_ROWS, FAR_LAND, FAR_WATER}
#import hachure::terrain::TILE_BORDER
#import hachure::shores::{unpacked_shore, extents, IS_SHORE, IS_WATER, ROW_SHIFT, ROW_ZERO, FIRST_WET}

// Workgroups of 8 x 8 texels along y.
const GROUPS: u32 = 33u;
// Columns on either side in which a shore is searched on land.
const LAND_REACH: i32 = 4;
// Half the length of a piece of shore, in samples; and the distance within which the piece decides on which side of it
// a sample is.
const HALF_PIECE: f32 = 0.6;
const DECISIVE: f32 = 1.5;
// Smallest cosine between the normals of pieces of one shore.
const ALIKE: f32 = 0.7;
const NONE: f32 = 1e30;

@group(0) @binding(0) var<storage, read> jobs: array<MapJob>;
@group(0) @binding(1) var<storage, read> found: array<u32>;
@group(0) @binding(2) var<storage, read> shores: array<u32>;
@group(0) @binding(3) var water_maps: texture_storage_2d_array<r32uint, write>;

// The vector to a piece of shore in the world, in sample sizes, and the piece's normal, which is 0 if there is none.
struct Piece {
    to: vec2<f32>,
    normal: vec2<f32>,
}

fn piece_at(first: i32, place: vec2<i32>, way: vec2<i32>, world: mat2x2<f32>) -> Piece {
    let at = clamp(place + way, vec2<i32>(0), vec2<i32>(SIDE - 1));
    let word = shores[first + at.y * SIDE + at.x];
    let shore = unpacked_shore(word);
    if (word & IS_SHORE) == 0u {
        return Piece(vec2<f32>(0.0), vec2<f32>(0.0));
    }
    return Piece(world * (vec2<f32>(at - place) + shore.offset), shore.normal);
}

fn distance_of(first: i32, place: vec2<i32>, world: mat2x2<f32>) -> f32 {
    let here = first + place.y * SIDE + place.x;
    let is_water = (shores[here] & IS_WATER) != 0u;
    // Distance between columns.
    let apart = abs(world[0].x * world[1].y - world[0].y * world[1].x) / length(world[1]);
    var nearest = vec2<i32>(0);
    var least = NONE;
    let looks = 2 * select(LAND_REACH, SHORE_REACH, is_water) + 1;
    for (var i = 0; i < looks; i++) {
        let aside = select((i + 1) / 2, -(i + 1) / 2, (i & 1) == 1);
        if f32(abs(aside)) * apart > least {
            break;
        }
        let row = i32(shores[here + aside] >> ROW_SHIFT);
        let way = vec2<i32>(aside, row - ROW_ZERO);
        let away = length(world * vec2<f32>(way));
        if row > 0 && away < least {
            least = away;
            nearest = way;
        }
    }
    if least == NONE {
        return select(FAR_LAND, FAR_WATER, is_water);
    }
    // First the nearest piece, then the mean of the pieces that continue it, which smooths the stairs of samples.
    least = NONE;
    var beyond = 0.0;
    var normal = vec2<f32>(0.0);
    for (var i = 0; i < 9; i++) {
        let piece = piece_at(first, place, nearest + vec2<i32>(i % 3, i / 3) - 1, world);
        let along = max(abs(piece.to.x * piece.normal.y - piece.to.y * piece.normal.x) - HALF_PIECE, 0.0);
        let away = length(vec2<f32>(dot(piece.to, piece.normal), along));
        if any(piece.normal != vec2<f32>(0.0)) && away < least {
            least = away;
            beyond = along;
            normal = piece.normal;
        }
    }
    var sum = vec2<f32>(0.0);
    for (var i = 0; i < 9; i++) {
        let piece = piece_at(first, place, nearest + vec2<i32>(i % 3, i / 3) - 1, world);
        sum += vec2<f32>(dot(piece.to, normal), 1.0) * smoothstep(ALIKE, 1.0, dot(piece.normal, normal));
    }
    let across = sum.x / sum.y;
    least = length(vec2<f32>(across, beyond));
    let side = select(0.0, -across, beyond == 0.0);
    let is_inside = select(is_water, side > 0.0, side != 0.0 && least < DECISIVE);
    return select(-least, least, is_inside);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let turn = group.y / GROUPS;
    let number = found[FIRST_WET + turn];
    let job = jobs[number];
    let texel = vec2<i32>(vec2<u32>(id.x, id.y - turn * GROUPS * 8u));
    if texel.x >= MAP_WORDS || texel.y >= MAP_ROWS - 1 {
        return;
    }
    let first = i32(number) * SIDE * SIDE;
    let corner = vec2<i32>(4 * texel.x, texel.y) + AROUND - TILE_BORDER;
    let world = extents(job, corner + vec2<i32>(2, 0));
    var codes = vec4<f32>(0.0);
    for (var i = 0; i < 4; i++) {
        codes[i] = code_of(distance_of(first, corner + vec2<i32>(i, 0), world)) / 255.0;
    }
    textureStore(water_maps, texel, job.slot, vec4<u32>(pack4x8unorm(codes), 0u, 0u, 0u));
}
