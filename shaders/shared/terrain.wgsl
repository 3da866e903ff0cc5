// Positions in the terrain: grid and world, the levels of the pyramid and their tiles, and the level that is drawn.
//
// The level is a continuous function of position and distance alone. It is the scale of the pixel's footprint, or finer
// where the measured error of that level would exceed the allowed error, and coarser while finer tiles are missing. The
// heights themselves are in `surface`.
//
// Grid coordinates `g` are in samples of the finest level, relative to the anchor, a sample near the camera.
#define_import_path hachure::terrain

// A level of the pyramid.
struct Level {
    // Level coordinate of g: g * scale + fraction, counted from sample `cell`.
    scale: vec2<f32>,
    fraction: vec2<f32>,
    cell: vec2<i32>,
    size: vec2<i32>,
    // First of its rows of tiles in `tile_rows`.
    first_row: i32,
    // Number of that row within the level.
    top: i32,
    row_count: i32,
    pad: i32,
}

// A row of the tiles that the view needs.
struct TileRow {
    // Column of its first tile in the level.
    left: i32,
    count: i32,
    // Index in `tiles`.
    first_tile: i32,
    pad: i32,
}

// A tile that the view needs.
struct TileRecord {
    // Largest height error of the up to four tiles that meet at each corner (north-west, north-east, south-west,
    // south-east), in metres.
    errors_m: vec4<f32>,
    // Parts of a level, at the same corners in 8 bits each, by which the surface has to stay above this tile's level
    // because tiles around it are not loaded.
    blocked: u32,
    // Slot in the atlas; NO_SLOT if the tile is not loaded.
    slot: u32,
    // 1 if there is no finer data.
    is_finest: u32,
    // As `blocked`, for horizons and for shores: parts of a level by which they have to stay above this tile's map.
    // NO_MAP if the tile has no map: see `horizon_maps` and `water_maps`.
    unlit: u32,
    shoreless: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

struct Terrain {
    // Polynomial coefficients: xy of world_from_grid, zw of grid_from_world, in rows of rising powers of the first
    // variable.
    terms: array<vec4<f32>, 36>,
    // First and last sample of the grid, in grid units relative to the anchor.
    extent_units: vec4<i32>,
    // Scales of the polynomials' variables: g * grid_unit, metres * world_unit.
    grid_unit: f32,
    world_unit: f32,
    degree: i32,
    level_count: i32,
    // The camera's height is coarse + fine. The coarse part is exact in f32 and near, so sample heights minus it keep
    // their digits.
    camera_z_coarse_m: f32,
    camera_z_fine_m: f32,
    // Range of heights of the whole terrain, relative to the camera.
    min_z_m: f32,
    max_z_m: f32,
    spacing_m: f32,
    // Height error that the choice of the level may add, in pixels.
    level_error_px: f32,
    // Origin of the expansion of grid_from_world: the point of the terrain's extent that is nearest to the camera.
    world_origin_m: vec2<f32>,
    focal_px: f32,
    // Grid units per sample.
    units_per_sample: f32,
    // Inverse radius of the globe that the land is bent around, in 1/m; 0 is flat.
    inverse_radius: f32,
    // Inverse radius of the earth itself, without refraction, in 1/m.
    earth_inverse_radius: f32,
}

@group(0) @binding(10) var<uniform> terrain: Terrain;
@group(0) @binding(11) var<storage, read> levels: array<Level>;
@group(0) @binding(12) var<storage, read> tile_rows: array<TileRow>;
@group(0) @binding(13) var<storage, read> tiles: array<TileRecord>;

const TILE_SAMPLES: i32 = 256;
const TILE_SHIFT: vec2<u32> = vec2<u32>(8u, 8u);
const TILE_BORDER: i32 = 2;
const NO_SLOT: u32 = 0xffffffffu;
// Value of `unlit` and `shoreless` for a tile without a map.
const NO_MAP: u32 = 0xffffffffu;

// Return the grid coordinates of the first and the last sample.
fn first_sample() -> vec2<f32> {
    return vec2<f32>(terrain.extent_units.xy) / terrain.units_per_sample;
}

fn last_sample() -> vec2<f32> {
    return vec2<f32>(terrain.extent_units.zw) / terrain.units_per_sample;
}

fn is_in_grid(g: vec2<f32>) -> bool {
    return all(g >= first_sample()) && all(g <= last_sample());
}

fn first_term_of_row(row: i32) -> i32 {
    return row * (terrain.degree + 1) - (row * (row - 1)) / 2;
}

// Returns camera-relative east and north of a grid coordinate, in metres.
fn world_from_grid(g: vec2<f32>) -> vec2<f32> {
    let v = g * terrain.grid_unit;
    var sum = vec2<f32>(0.0);
    for (var row = terrain.degree; row >= 0; row--) {
        let first = first_term_of_row(row);
        var inner = vec2<f32>(0.0);
        for (var i = terrain.degree - row; i >= 0; i--) {
            inner = inner * v.x + terrain.terms[first + i].xy;
        }
        sum = sum * v.y + inner;
    }
    return sum;
}

struct GridPoint {
    g: vec2<f32>,
    // dg/dx and dg/dy for x east and y north, in samples per metre.
    dg_dx: vec2<f32>,
    dg_dy: vec2<f32>,
}

// Returns the grid coordinate of a camera-relative position, with its derivatives.
fn grid_from_world(xy_m: vec2<f32>) -> GridPoint {
    let v = (xy_m - terrain.world_origin_m) * terrain.world_unit;
    var sum = vec2<f32>(0.0);
    var sum_x = vec2<f32>(0.0);
    var sum_y = vec2<f32>(0.0);
    for (var row = terrain.degree; row >= 0; row--) {
        let first = first_term_of_row(row);
        var inner = vec2<f32>(0.0);
        var inner_x = vec2<f32>(0.0);
        for (var i = terrain.degree - row; i >= 0; i--) {
            inner_x = inner_x * v.x + inner;
            inner = inner * v.x + terrain.terms[first + i].zw;
        }
        sum_y = sum_y * v.y + sum;
        sum = sum * v.y + inner;
        sum_x = sum_x * v.y + inner_x;
    }
    return GridPoint(sum, sum_x * terrain.world_unit, sum_y * terrain.world_unit);
}

// A grid coordinate on a level: the tile, the cell, and the position within the cell.
struct LevelPlace {
    level: i32,
    // Index in `tiles`; -1 if the view does not need that tile.
    tile: i32,
    cell: vec2<i32>,
    f: vec2<f32>,
}

fn place_on_level(level: i32, g: vec2<f32>) -> LevelPlace {
    let info = levels[level];
    let c = g * info.scale + info.fraction;
    let whole = floor(c);
    let cell = vec2<i32>(whole) + info.cell;
    let inside = clamp(cell, vec2<i32>(0), max(info.size - 2, vec2<i32>(0)));
    // At the border of a coarse level the outer half sample continues its last cell.
    let f = clamp(c - whole + vec2<f32>(cell - inside), vec2<f32>(-0.5), vec2<f32>(1.5));
    let tile = inside >> TILE_SHIFT;
    let y = tile.y - info.top;
    var index = -1;
    if y >= 0 && y < info.row_count {
        let row = tile_rows[info.first_row + y];
        let x = tile.x - row.left;
        index = select(-1, row.first_tile + x, x >= 0 && x < row.count);
    }
    return LevelPlace(level, index, inside, f);
}

// Interpolates a value that is given at the corners of a tile.
fn between_corners(corners: vec4<f32>, place: LevelPlace) -> f32 {
    let in_tile = vec2<f32>(place.cell & vec2<i32>(TILE_SAMPLES - 1)) + place.f;
    let t = clamp(in_tile / f32(TILE_SAMPLES), vec2<f32>(0.0), vec2<f32>(1.0));
    return mix(mix(corners.x, corners.y, t.x), mix(corners.z, corners.w, t.x), t.y);
}

// Returns a continuous bound of the height error of a level at a place, in metres.
fn level_error_m(place: LevelPlace) -> f32 {
    if place.tile < 0 {
        // The view does not need this tile, so its parent is good enough.
        return 0.0;
    }
    return between_corners(tiles[place.tile].errors_m, place);
}

// The continuous level at a place, and the position on the finer of its two integer levels.
struct SurfaceLevel {
    level: f32,
    place: LevelPlace,
}

// Raises the wanted level as far as tiles are loaded. The first usable level from the wanted one upward decides, since
// a tile is used only where its parents are loaded.
fn as_far_as_there(wanted: f32, first: LevelPlace, g: vec2<f32>) -> SurfaceLevel {
    let coarsest = terrain.level_count - 1;
    var place = first;
    var there = f32(coarsest);
    loop {
        var blocked = 1.0;
        if place.tile >= 0 {
            blocked = between_corners(unpack4x8unorm(tiles[place.tile].blocked), place);
        }
        let is_last = place.level >= coarsest;
        let can_be_used = blocked < 1.0 || is_last;
        if can_be_used {
            there = f32(place.level) + select(blocked, 0.0, is_last);
        } else {
            place = place_on_level(place.level + 1, g);
        }
        continuing {
            break if can_be_used;
        }
    }
    return SurfaceLevel(max(wanted, there), place);
}

// Returns the continuous level at a place seen from `distance_m`.
fn surface_level(g: vec2<f32>, distance_m: f32) -> SurfaceLevel {
    let pixel_m = distance_m / terrain.focal_px;
    let allowed_m = terrain.level_error_px * pixel_m;
    let coarsest = terrain.level_count - 1;
    var wanted = clamp(log2(pixel_m / terrain.spacing_m), 0.0, f32(coarsest));
    var level = min(i32(wanted), coarsest);
    var place = place_on_level(level, g);
    var coarser_m = level_error_m(place_on_level(min(level + 1, coarsest), g));
    if coarser_m > allowed_m {
        var error_m = level_error_m(place);
        if error_m <= allowed_m {
            wanted = f32(level) + min(wanted - f32(level), (allowed_m - error_m) / (coarser_m - error_m));
        } else {
            while level > 0 && error_m > allowed_m {
                level -= 1;
                coarser_m = error_m;
                place = place_on_level(level, g);
                error_m = level_error_m(place);
            }
            let way = clamp((allowed_m - error_m) / max(coarser_m - error_m, 1e-30), 0.0, 1.0);
            wanted = f32(level) + select(way, 0.0, error_m >= allowed_m);
        }
    }
    return as_far_as_there(wanted, place, g);
}
