// The density of trees at a position, and the species of a tree, as determined by the land.
//
// The land is sampled at a scale of about RULE_M, whatever level is drawn there, so that no tree comes or goes with the
// level of detail (far away, where that level is not loaded, at the finest that is).
#define_import_path hachure::forest
#import hachure::terrain::{terrain, grid_from_world, place_on_level, as_far_as_there}
#import hachure::surface::{surface_near, surface_at}
#import hachure::still_water::{is_level, level_around}
#import hachure::earth::camera_z_m
#import hachure::pcg::pcg

struct Forest {
    seed: u32,
    // Number of blocks in the dispatch, one for each workgroup.
    blocks: u32,
    // Capacity for trees.
    capacity: u32,
    species: u32,
    // Part of the points that have a tree, 0 to 1.
    density: f32,
    // Height of the tree line and how far it varies, in metres above the sea.
    tree_line_m: f32,
    raggedness_m: f32,
    // Steepest slope with trees, rise over run.
    steepest: f32,
    // Distance up to which all trees are drawn, seen from above, in metres.
    full_m: f32,
    // Distance beyond which no tree is drawn, in metres.
    reach_m: f32,
    // Heights on the picture below which a tree is drawn as MIDDLE, and as IMPOSTOR, in pixels.
    middle_px: f32,
    impostor_px: f32,
    tile_m: f32,
    points: f32,
    // 1: some species prefers hollows or ridges.
    asks_hollow: u32,
    // Height of the tallest tree.
    tallest_m: f32,
    // Unit vector to the sun, in the world.
    to_sun: vec3<f32>,
    // Length of a tree's shadow on its side away from the sun, in heights of the tree; 0 where there are no shadows.
    shadow_reach: f32,
    // Largest displacement of any part of a tree by wind.
    sways_m: f32,
    // 1: level land is water.
    level_is_water: u32,
    // Height of the sea, in which no trees grow, in metres.
    sea_m: f32,
    padding: u32,
}

// Largest number of species of a forest.
const MAX_SPECIES: u32 = 8u;

struct Species {
    // Part of all trees, 0 to 1.
    share: f32,
    height_m: f32,
    // Lowest and highest elevation at which the species grows, in metres above the sea.
    low_m: f32,
    high_m: f32,
    // The direction in which preferred slopes face (a unit vector), times the strength of the preference.
    aspect: vec2<f32>,
    // Preference for hollows over ridges; negative prefers ridges.
    by_hollow: f32,
    // Radius of the crown in heights of the tree.
    crown: f32,
    // Centres and radii of the bounding spheres of its pictures, in tree units: of a tree, and of a piece of canopy.
    middle: vec3<f32>,
    radius: f32,
    canopy_middle: vec3<f32>,
    canopy_radius: f32,
    // Upright bounding cylinders within: radius, bottom and top, in tree units.
    cylinder: vec4<f32>,
    canopy_cylinder: vec4<f32>,
}

// The rasters and species that determine which trees may grow where.
struct TreeRules {
    // South-western corner of the cover rasters, in metres from the rig's origin.
    cover_low_m: vec2<f32>,
    cells_per_m: vec2<f32>,
    // MAX_SPECIES entries.
    species: array<Species, 8>,
    // Shares that replace a species' own, for each of 255 classes of land cover and each species.
    shares: array<f32, 2040>,
}

// The land at the position of a tree.
struct Site {
    // Position in the grid.
    g: vec2<f32>,
    // Gradient to the east and to the north, in metres per metre.
    slope: vec2<f32>,
    // Relative to the camera.
    height_m: f32,
}

// Scale at which the land is sampled, in metres.
const RULE_M: f32 = 30.0;
// Hollows and ridges are relative to land averaged over this many more levels of the pyramid.
const AROUND: f32 = 3.0;
// Steepest shore of still water at the scale of RULE_M, rise over run.
const STEEPEST_SHORE: f32 = 0.3;
// Cells of the noise of the tree line in a tile: an integer, so that tiles fit together.
const PATCHES: i32 = 4;
// Range of height above and below its limits over which a species becomes rarer.
const FADES_OVER_M: f32 = 100.0;

fn random(seed: u32, at: vec2<i32>, salt: u32) -> vec2<f32> {
    let mixed = pcg(bitcast<vec2<u32>>(at) ^ vec2<u32>(seed * 0x9e3779b9u, salt));
    return vec2<f32>(mixed >> vec2<u32>(8u)) / 16777216.0;
}

// Returns smooth noise of −1 to 1, continuous across the borders of tiles. `in_tile` is 0 to 1.
fn stray(seed: u32, tile: vec2<i32>, in_tile: vec2<f32>) -> f32 {
    let at = in_tile * f32(PATCHES);
    let whole = floor(at);
    let corner = tile * PATCHES + vec2<i32>(whole);
    let f = at - whole;
    let t = f * f * (3.0 - 2.0 * f);
    let south = mix(random(seed, corner, 1u).x, random(seed, corner + vec2<i32>(1, 0), 1u).x, t.x);
    let north = mix(random(seed, corner + vec2<i32>(0, 1), 1u).x, random(seed, corner + vec2<i32>(1, 1), 1u).x, t.x);
    return 2.0 * mix(south, north, t.y) - 1.0;
}

// Returns whether the position is within the extent of the land.
fn has_land(g: vec2<f32>) -> bool {
    let units = g * terrain.units_per_sample;
    return all(units >= vec2<f32>(terrain.extent_units.xy)) && all(units <= vec2<f32>(terrain.extent_units.zw));
}

fn site_at(xy_m: vec2<f32>) -> Site {
    let at = grid_from_world(xy_m);
    let rule_level = clamp(log2(RULE_M / terrain.spacing_m), 0.0, f32(terrain.level_count - 1));
    let land = surface_at(surface_near(at.g, as_far_as_there(rule_level, place_on_level(i32(rule_level), at.g), at.g)));
    let slope = vec2<f32>(dot(land.gradient, at.dg_dx), dot(land.gradient, at.dg_dy));
    return Site(at.g, slope, land.height_m);
}

// Returns how far a site is below the land around it, in units of RULE_M.
fn hollow_at(site: Site) -> f32 {
    let rule_level = clamp(log2(RULE_M / terrain.spacing_m), 0.0, f32(terrain.level_count - 1));
    let level = min(rule_level + AROUND, f32(terrain.level_count - 1));
    let wide = surface_at(surface_near(site.g, as_far_as_there(level, place_on_level(i32(level), site.g), site.g)));
    return (wide.height_m - site.height_m) / RULE_M;
}

// Returns whether a site is in the sea that the scene names.
fn is_sea(forest: Forest, site: Site) -> bool {
    return site.height_m + camera_z_m() <= forest.sea_m;
}

// Returns whether a site is water. Lakes and the sea are level in elevation data wherever they are wider than the
// neighbourhood that `level_around` samples; at a shore less than half of that is level.
fn is_still_water(site: Site) -> bool {
    // A site so steep may be near the shore, but it is not in the water.
    if length(site.slope) > STEEPEST_SHORE {
        return false;
    }
    let own = surface_at(surface_near(site.g, as_far_as_there(0.0, place_on_level(0, site.g), site.g)));
    return is_level(own) && level_around(site.g, own.height_m) >= 3;
}

// Returns the part of the points that have trees: it falls toward the tree line and toward steep land. `stray` is the
// noise of the tree line, −1 to 1.
fn density_of(forest: Forest, site: Site, stray: f32) -> f32 {
    let below_m = forest.tree_line_m + forest.raggedness_m * stray - (site.height_m + camera_z_m());
    return forest.density * smoothstep(0.0, max(forest.raggedness_m, 1.0), below_m)
        * (1.0 - smoothstep(0.7 * forest.steepest, forest.steepest, length(site.slope)));
}

// Returns the share of a species at a site.
fn suits(species: Species, site: Site, hollow: f32) -> f32 {
    let above_sea_m = site.height_m + camera_z_m();
    let by_height = clamp(1.0 + min(above_sea_m - species.low_m, species.high_m - above_sea_m) / FADES_OVER_M, 0.0, 1.0);
    let steepness = length(site.slope);
    // A slope faces down: against its gradient. Gentle slopes hardly face anywhere.
    let looks = -dot(site.slope, species.aspect) / max(steepness, 1e-6);
    let by_aspect = 1.0 + smoothstep(0.05, 0.3, steepness) * 0.5 * (looks - length(species.aspect));
    let by_hollow = clamp(1.0 + 2.0 * species.by_hollow * hollow, 0.0, 2.0);
    return max(species.share * by_height * by_aspect * by_hollow, 0.0);
}
