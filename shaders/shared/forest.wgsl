// What the land says to trees: how densely they stand at a place, and of which species a tree is.
//
// The land is asked at a scale of about RULE_M, whatever is drawn there, so that no tree comes or goes with the level of
// detail (far away, where no such level is loaded, at the finest that is).
#define_import_path hachure::forest
#import hachure::terrain::{terrain, grid_from_world, place_on_level, as_far_as_there}
#import hachure::surface::{surface_near, surface_at}
#import hachure::still_water::{is_level, level_around}
#import hachure::earth::camera_z_m
#import hachure::pcg::pcg

struct Forest {
    seed: u32,
    // Blocks that are asked.
    blocks: u32,
    // Trees that there is room for.
    capacity: u32,
    species: u32,
    // Of the points: 1 is all of them.
    density: f32,
    // Metres above the sea, and by how much it strays.
    tree_line_m: f32,
    raggedness_m: f32,
    // Rise over run where the last tree stands.
    steepest: f32,
    // Up to here all trees are drawn, seen from above.
    full_m: f32,
    // Beyond it none is.
    reach_m: f32,
    // Heights on the picture below which a tree is drawn as MIDDLE, and as IMPOSTOR.
    middle_px: f32,
    impostor_px: f32,
    tile_m: f32,
    points: f32,
    // A species asks for hollows or ridges.
    asks_hollow: u32,
    // Of the tallest tree.
    tallest_m: f32,
    // Unit.
    to_sun: vec3<f32>,
    // As far away from the sun a tree's shadow reaches from its foot, by its height; 0 where there are no shadows.
    shadow_reach: f32,
    // No part of a tree is moved farther by wind.
    sways_m: f32,
    // Where land is level there is water.
    level_is_water: u32,
    padding_a: u32,
    padding_b: u32,
}

// A forest has no more.
const MOST_SPECIES: u32 = 8u;

struct Species {
    // Of all trees.
    share: f32,
    height_m: f32,
    // Above the sea.
    low_m: f32,
    high_m: f32,
    // Unit: where slopes should look, times how much that matters.
    aspect: vec2<f32>,
    // How much hollows are preferred to ridges.
    by_hollow: f32,
    // Of a crown, by the tree's height.
    crown: f32,
    // Of the spheres of its pictures, in tree units: of a tree, and of a piece of canopy.
    middle: vec3<f32>,
    radius: f32,
    canopy_middle: vec3<f32>,
    canopy_radius: f32,
    // The upright cylinders within: radius, bottom and top.
    cylinder: vec4<f32>,
    canopy_cylinder: vec4<f32>,
}

// What may stand where.
struct TreeRules {
    // Of rasters: the south-western corner, from the origin of the rig.
    cover_low_m: vec2<f32>,
    cells_per_m: vec2<f32>,
    // MOST_SPECIES.
    species: array<Species, 8>,
    // For each of 255 classes of land and each species, in place of the species' share.
    shares: array<f32, 2040>,
}

// The land where a tree stands, or would.
struct Site {
    // In the grid.
    g: vec2<f32>,
    // To the east and to the north, metres per metre.
    slope: vec2<f32>,
    // Relative to the camera.
    height_m: f32,
}

// The land is asked at this scale.
const RULE_M: f32 = 30.0;
// Hollows and ridges are told by so much wider a look: three levels.
const AROUND: f32 = 3.0;
// The shore of still water is not steeper at the scale of RULE_M, rise over run.
const STEEPEST_SHORE: f32 = 0.3;
// Of the noise that the tree line strays by: so many in a tile, so that it fits together.
const PATCHES: i32 = 4;
// Above and below its heights a species becomes rarer over as much.
const FADES_OVER_M: f32 = 100.0;

fn random(seed: u32, at: vec2<i32>, salt: u32) -> vec2<f32> {
    let mixed = pcg(bitcast<vec2<u32>>(at) ^ vec2<u32>(seed * 0x9e3779b9u, salt));
    return vec2<f32>(mixed >> vec2<u32>(8u)) / 16777216.0;
}

// −1 to 1, smooth, the same on both sides of a tile's border. `in_tile` is 0 to 1.
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

// Whether there is land.
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

// How far a site lies below the land around it, by RULE_M.
fn hollow_at(site: Site) -> f32 {
    let rule_level = clamp(log2(RULE_M / terrain.spacing_m), 0.0, f32(terrain.level_count - 1));
    let level = min(rule_level + AROUND, f32(terrain.level_count - 1));
    let wide = surface_at(surface_near(site.g, as_far_as_there(level, place_on_level(i32(level), site.g), site.g)));
    return (wide.height_m - site.height_m) / RULE_M;
}

// Whether a site is water: lakes and the sea are level in elevation data, wherever they are wider than what is around a
// site; at a shore less than half of that is.
fn is_still_water(site: Site) -> bool {
    // Its shore is nearer than what the land is asked at.
    if length(site.slope) > STEEPEST_SHORE {
        return false;
    }
    let own = surface_at(surface_near(site.g, as_far_as_there(0.0, place_on_level(0, site.g), site.g)));
    return is_level(own) && level_around(site.g, own.height_m) >= 3;
}

// Of the points, those that have trees: it thins out toward the tree line and toward what is too steep. `stray` is that of
// the tree line.
fn density_of(forest: Forest, site: Site, stray: f32) -> f32 {
    let below_m = forest.tree_line_m + forest.raggedness_m * stray - (site.height_m + camera_z_m());
    return forest.density * smoothstep(0.0, max(forest.raggedness_m, 1.0), below_m)
        * (1.0 - smoothstep(0.7 * forest.steepest, forest.steepest, length(site.slope)));
}

// How much of a species' share there is at a place.
fn suits(species: Species, site: Site, hollow: f32) -> f32 {
    let above_sea_m = site.height_m + camera_z_m();
    let by_height = clamp(1.0 + min(above_sea_m - species.low_m, species.high_m - above_sea_m) / FADES_OVER_M, 0.0, 1.0);
    let steepness = length(site.slope);
    // A slope looks down: against its gradient. Gentle ones hardly look anywhere.
    let looks = -dot(site.slope, species.aspect) / max(steepness, 1e-6);
    let by_aspect = 1.0 + smoothstep(0.05, 0.3, steepness) * 0.5 * (looks - length(species.aspect));
    let by_hollow = clamp(1.0 + 2.0 * species.by_hollow * hollow, 0.0, 2.0);
    return max(species.share * by_height * by_aspect * by_hollow, 0.0);
}
