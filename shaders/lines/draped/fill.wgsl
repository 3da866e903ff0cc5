// Fills areas of features with a tint or with hatching.
//
// A pixel knows the place on the map that it sees, and finds out in which areas this place is. Cells that divide the map,
// each into four by four, hold the edges of areas. The smallest cell around the place has a reference point, for which it
// is known how often each area winds around it; the straight line from there to the place crosses the edges that change
// this. Edges are relative to the reference point, so that f32 holds them. Four samples in a pixel smooth the border; they
// are on the plane that touches the surface at the centre of the pixel.
#import hachure::view::{View, ray_at, ray_of_pixel}
#import hachure::seen::{normal_seen, place_seen}
#import hachure::earth::unbend
#import hachure::full_screen::full_screen_corner
#import hachure::line_ink::line_ink

// A square of the map. Positions are in units from the south-west corner of the largest cell.
struct AreaCell {
    // Reference point of a cell that is not divided.
    origin: vec2<u32>,
    // First of 16 cells, in rows from the south-west; or first edge of a cell that is not divided.
    first: u32,
    // Number of edges; DIVIDED for a cell that is divided.
    count: u32,
    // First, and number, of the areas that cover all of the cell; the cells in it do not list them again.
    covers: u32,
    cover_count: u32,
    pad_a: u32,
    pad_b: u32,
}

struct EdgeOwner {
    area: u32,
    winding: i32,
}

struct FillRules {
    // Position of the rig's origin: whole units modulo 2^32, and the rest in metres.
    origin: vec2<i32>,
    rest_m: vec2<f32>,
    unit_m: f32,
    // Binary logarithm of the width of the largest cell in units.
    root_bits: u32,
    // Part of an area that is inked.
    fill: f32,
    // Distance of hatching lines; 0 for a tint.
    hatch_px: f32,
    // Unit vector across the lines, east and north.
    across: vec2<f32>,
    // Number of the finest line at the rig's origin, modulo 2^32, and the rest as a part of the finest distance.
    line: u32,
    line_rest: f32,
}

const DIVIDED: u32 = 0xffffffffu;
// Bits of a position that a level of cells takes.
const CELL_BITS: u32 = 2u;
// Binary logarithms of the smallest and largest pixel for which lines are at their distance, in metres.
const FINEST: f32 = -12.0;
const COARSEST: f32 = 19.0;
// How much the distance along the view axis may change within a pixel, as a factor: grazing planes are cut off.
const STEEPEST: f32 = 1.25;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: FillRules;
@group(0) @binding(2) var<storage, read> cells: array<AreaCell>;
// Edges of cells: begin and end, in metres from the reference point of their cell. The area is on their left.
@group(0) @binding(3) var<storage, read> edges: array<vec4<f32>>;
// The area of each edge, and how often this area winds around the reference point. Edges of an area follow each other.
@group(0) @binding(4) var<storage, read> owners: array<EdgeOwner>;
// Areas that cover cells.
@group(0) @binding(5) var<storage, read> covers: array<u32>;
// A bit for each area: whether it is filled.
@group(0) @binding(6) var<storage, read> filled: array<u32>;
@group(0) @binding(7) var distance_m: texture_2d<f32>;
@group(0) @binding(8) var normal: texture_2d<u32>;

// A place on the map: whole units, and the rest in metres.
struct MapPlace {
    units: vec2<i32>,
    rest_m: vec2<f32>,
}

// A cell that is not divided, with its width.
struct Leaf {
    cell: AreaCell,
    bits: u32,
    // Whether an area that is filled covers all of it.
    is_covered: bool,
    is_in_root: bool,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return full_screen_corner(index);
}

fn map_place(flat_m: vec2<f32>) -> MapPlace {
    let from_m = flat_m + rules.rest_m;
    let whole = round(from_m / rules.unit_m);
    return MapPlace(rules.origin + vec2<i32>(whole), from_m - whole * rules.unit_m);
}

fn is_filled(area: u32) -> bool {
    return ((filled[area >> 5u] >> (area & 31u)) & 1u) == 1u;
}

fn leaf_around(units: vec2<i32>) -> Leaf {
    var leaf = Leaf(AreaCell(vec2<u32>(0u), 0u, 0u, 0u, 0u, 0u, 0u), rules.root_bits, false, false);
    let at = vec2<u32>(units);
    leaf.is_in_root = all((at >> vec2<u32>(rules.root_bits)) == vec2<u32>(0u));
    if !leaf.is_in_root {
        return leaf;
    }
    var cell = cells[0];
    loop {
        for (var i = 0u; i < cell.cover_count; i++) {
            leaf.is_covered = leaf.is_covered || is_filled(covers[cell.covers + i]);
        }
        if cell.count != DIVIDED || leaf.bits < CELL_BITS {
            break;
        }
        leaf.bits -= CELL_BITS;
        let part = (at >> vec2<u32>(leaf.bits)) & vec2<u32>((1u << CELL_BITS) - 1u);
        cell = cells[cell.first + (part.y << CELL_BITS) + part.x];
    }
    leaf.cell = cell;
    return leaf;
}

// Returns the determinant of two vectors: positive if the second is to the left of the first.
fn side(a: vec2<f32>, b: vec2<f32>) -> f32 {
    return a.x * b.y - a.y * b.x;
}

// Returns whether a place in a leaf is in an area that is filled: one that winds around it at least once, in whichever
// direction. Two edges that share an end compute the same side for it, so that a line through that end crosses exactly
// one of them.
fn is_inside(leaf: Leaf, place: MapPlace) -> bool {
    let to_m = vec2<f32>(place.units - vec2<i32>(leaf.cell.origin)) * rules.unit_m + place.rest_m;
    var is_in = leaf.is_covered;
    var area = 0u;
    var winding = 0;
    for (var i = 0u; i < leaf.cell.count && !is_in; i++) {
        let owner = owners[leaf.cell.first + i];
        if i == 0u || owner.area != area {
            is_in = winding != 0 && is_filled(area);
            area = owner.area;
            winding = owner.winding;
        }
        let edge = edges[leaf.cell.first + i];
        if (side(to_m, edge.xy) > 0.0) == (side(to_m, edge.zw) > 0.0) {
            continue;
        }
        let along_m = edge.zw - edge.xy;
        let from_left = side(along_m, -edge.xy) > 0.0;
        let to_left = side(along_m, to_m - edge.xy) > 0.0;
        if from_left != to_left {
            winding += select(-1, 1, to_left);
        }
    }
    return is_in || (winding != 0 && is_filled(area));
}

// Returns the flat place of a position on the targets, on the plane that touches the surface at a pixel.
fn flat_place(px: vec2<f32>, ray: vec3<f32>, n: vec3<f32>, depth_m: f32) -> vec2<f32> {
    let other = ray_at(view, px);
    let facing = dot(n, ray);
    let other_facing = dot(n, other);
    let is_before = facing * other_facing > 0.0;
    let farther = select(STEEPEST, clamp(facing / select(1.0, other_facing, is_before), 1.0 / STEEPEST, STEEPEST), is_before);
    return unbend(other * (depth_m * farther) + view.eye_m).flat_m.xy;
}

// Returns the ink of hatching at a place, relative to the rig, that moves by `step_m` over a pixel to the right and down.
// Lines are fixed to the map at distances that are powers of two; between two powers, every second line becomes thinner.
fn hatching(flat_m: vec2<f32>, right_m: vec2<f32>, down_m: vec2<f32>) -> f32 {
    let pixel_m = max(length(vec2<f32>(dot(right_m, rules.across), dot(down_m, rules.across))), 1e-9);
    let octave = log2(pixel_m);
    let power = clamp(floor(octave), FINEST, COARSEST);
    let thinner = clamp(octave - power, 0.0, 1.0);
    let spacing_m = rules.hatch_px * exp2(power);
    let finer = u32(power - FINEST);
    let first = rules.line >> finer;
    let part = (f32(rules.line - (first << finer)) + rules.line_rest) * exp2(-f32(finer));
    let turn = 0.5 * (dot(flat_m, rules.across) / spacing_m + part + f32(first & 1u));
    let even = 2.0 * abs(turn - round(turn));
    let odd = 1.0 - even;
    let spacing_px = spacing_m / pixel_m;
    let width_px = 2.0 * rules.fill * spacing_px / (2.0 - thinner);
    return max(line_ink(even * spacing_px, width_px), line_ink(odd * spacing_px, width_px * (1.0 - thinner)));
}

@fragment
fn fragment(@builtin(position) clip: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(clip.xy);
    let seen = place_seen(view, distance_m, pixel);
    if seen.w <= 0.0 {
        return vec4<f32>(0.0);
    }
    let n = normal_seen(normal, pixel);
    let ray = ray_of_pixel(view, pixel);
    let centre_px = vec2<f32>(pixel) + 0.5;
    let flat_m = unbend(seen.xyz).flat_m.xy;
    let right_m = flat_place(centre_px + vec2<f32>(0.5, 0.0), ray, n, seen.w) - flat_m;
    let down_m = flat_place(centre_px + vec2<f32>(0.0, 0.5), ray, n, seen.w) - flat_m;
    // Half a pixel each.
    let places = array<vec2<f32>, 4>(
        flat_m + 0.25 * right_m + 0.75 * down_m,
        flat_m + 0.75 * right_m - 0.25 * down_m,
        flat_m - 0.25 * right_m - 0.75 * down_m,
        flat_m - 0.75 * right_m + 0.25 * down_m,
    );
    var covered = 0.0;
    var leaf = leaf_around(map_place(flat_m).units);
    for (var i = 0; i < 4; i++) {
        let place = map_place(places[i]);
        let differs = vec2<u32>(place.units) ^ leaf.cell.origin;
        let is_same = leaf.is_in_root && all((differs >> vec2<u32>(leaf.bits)) == vec2<u32>(0u));
        if !is_same {
            leaf = leaf_around(place.units);
        }
        covered += select(0.0, 0.25, leaf.is_in_root && is_inside(leaf, place));
    }
    if covered == 0.0 {
        return vec4<f32>(0.0);
    }
    var ink = rules.fill;
    if rules.hatch_px > 0.0 {
        ink = hatching(flat_m, 2.0 * right_m, 2.0 * down_m);
    }
    return vec4<f32>(covered * ink);
}
