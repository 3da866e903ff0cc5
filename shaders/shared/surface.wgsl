// The only definition of the surface. Every pass that needs a height calls it, so that mesh, positions, normals and
// lines agree.
//
// Heights are bicubic (Catmull-Rom, a = -0.5) over the samples of a pyramid level, which `terrain` chooses by position
// and distance alone. Two patches of the mesh that share a vertex therefore compute bit-identical heights for it,
// whatever their own levels are.
//
// Why: docs/decisions/one-surface.md.
#define_import_path hachure::surface
#import hachure::terrain::{terrain, levels, tiles, place_on_level, surface_level, LevelPlace, SurfaceLevel}
#import hachure::terrain::{TILE_SAMPLES, TILE_BORDER, NO_SLOT}

@group(0) @binding(14) var heights: texture_2d_array<f32>;

struct Cell {
    // First texel of the cell in its tile, the tile's slot, its level, and the position within the cell.
    texel: vec2<i32>,
    slot: i32,
    level: i32,
    f: vec2<f32>,
    // True if there is no finer data here.
    is_finest: bool,
}

// Returns the cell at a position on a level, or on the next coarser level that is loaded.
fn cell_at(first: LevelPlace, g: vec2<f32>) -> Cell {
    var place = first;
    var slot = NO_SLOT;
    var is_finest = false;
    loop {
        if place.tile >= 0 {
            slot = tiles[place.tile].slot;
            is_finest = tiles[place.tile].is_finest == 1u;
        }
        let is_found = slot != NO_SLOT || place.level >= terrain.level_count - 1;
        if !is_found {
            place = place_on_level(place.level + 1, g);
        }
        continuing {
            break if is_found;
        }
    }
    // Before the first tile is loaded there are no heights at all; the mesh is empty then.
    let texel = (place.cell & vec2<i32>(TILE_SAMPLES - 1)) + TILE_BORDER;
    return Cell(texel, select(i32(slot), 0, slot == NO_SLOT), place.level, place.f, is_finest);
}

fn row_of_samples(cell: Cell, row: i32) -> vec4<f32> {
    let first = cell.texel + vec2<i32>(-1, row);
    return vec4<f32>(
        textureLoad(heights, first, cell.slot, 0).r,
        textureLoad(heights, first + vec2<i32>(1, 0), cell.slot, 0).r,
        textureLoad(heights, first + vec2<i32>(2, 0), cell.slot, 0).r,
        textureLoad(heights, first + vec2<i32>(3, 0), cell.slot, 0).r,
    );
}

fn cubic_weights(f: f32) -> vec4<f32> {
    return vec4<f32>(
        f * (-0.5 + f * (1.0 - 0.5 * f)),
        1.0 + f * f * (-2.5 + 1.5 * f),
        f * (0.5 + f * (2.0 - 1.5 * f)),
        f * f * (-0.5 + 0.5 * f),
    );
}

fn cubic_slopes(f: f32) -> vec4<f32> {
    return vec4<f32>(
        -0.5 + f * (2.0 - 1.5 * f),
        f * (-5.0 + 4.5 * f),
        0.5 + f * (4.0 - 4.5 * f),
        f * (-1.0 + 1.5 * f),
    );
}

fn cubic_curvatures(f: f32) -> vec4<f32> {
    return vec4<f32>(2.0 - 3.0 * f, 9.0 * f - 5.0, 4.0 - 9.0 * f, 3.0 * f - 1.0);
}

// The surface around a place, to second order. Derivatives are with respect to grid coordinates, in metres and samples.
struct Surface {
    // Relative to the camera.
    height_m: f32,
    gradient: vec2<f32>,
    // Second derivatives xx, xy, yy.
    curvature: vec3<f32>,
}

fn camera_relative_m(sample_m: f32) -> f32 {
    return (sample_m - terrain.camera_z_coarse_m) - terrain.camera_z_fine_m;
}

// The sixteen samples around a cell, as differences from one of them: this keeps digits that f32 would lose at 4000 m.
struct Samples {
    row_a: vec4<f32>,
    row_b: vec4<f32>,
    row_c: vec4<f32>,
    row_d: vec4<f32>,
    reference_m: f32,
    // Position within the cell, and level coordinates per grid coordinate.
    f: vec2<f32>,
    scale: vec2<f32>,
}

fn samples_around(place: LevelPlace, g: vec2<f32>) -> Samples {
    let cell = cell_at(place, g);
    let row_b = row_of_samples(cell, 0);
    let reference = row_b.y;
    return Samples(
        row_of_samples(cell, -1) - reference, row_b - reference, row_of_samples(cell, 1) - reference,
        row_of_samples(cell, 2) - reference, reference, cell.f, levels[cell.level].scale);
}

// Weights of four samples along an axis at a position between the middle two, and their first and second derivatives.
struct Basis {
    weights: vec4<f32>,
    slopes: vec4<f32>,
    curvatures: vec4<f32>,
}

fn cubic_basis(f: f32) -> Basis {
    return Basis(cubic_weights(f), cubic_slopes(f), cubic_curvatures(f));
}

fn surface_by(samples: Samples, x: Basis, y: Basis) -> Surface {
    let scale = samples.scale;
    let height = vec4<f32>(dot(x.weights, samples.row_a), dot(x.weights, samples.row_b),
        dot(x.weights, samples.row_c), dot(x.weights, samples.row_d));
    let slope = vec4<f32>(dot(x.slopes, samples.row_a), dot(x.slopes, samples.row_b),
        dot(x.slopes, samples.row_c), dot(x.slopes, samples.row_d));
    let bend = vec4<f32>(dot(x.curvatures, samples.row_a), dot(x.curvatures, samples.row_b),
        dot(x.curvatures, samples.row_c), dot(x.curvatures, samples.row_d));
    return Surface(
        camera_relative_m(samples.reference_m) + dot(y.weights, height),
        vec2<f32>(dot(y.weights, slope), dot(y.slopes, height)) * scale,
        vec3<f32>(dot(y.weights, bend), dot(y.slopes, slope), dot(y.curvatures, height))
            * vec3<f32>(scale.x * scale.x, scale.x * scale.y, scale.y * scale.y),
    );
}

fn surface_in_cell(samples: Samples) -> Surface {
    return surface_by(samples, cubic_basis(samples.f.x), cubic_basis(samples.f.y));
}

fn between(a: Surface, b: Surface, blend: f32) -> Surface {
    return Surface(mix(a.height_m, b.height_m, blend), mix(a.gradient, b.gradient, blend),
        mix(a.curvature, b.curvature, blend));
}

// The surface near a place on a continuous level: the cells of the two nearest integer levels.
struct Near {
    fine: Samples,
    coarse: Samples,
    // Weight of the coarse one.
    blend: f32,
    // Approximate log2 of the size of cells, in samples.
    level: f32,
}

fn surface_near(g: vec2<f32>, at: SurfaceLevel) -> Near {
    // Most places need one level only; levels are blended in the middle half of their interval.
    let blend = clamp((at.level - f32(at.place.level)) * 2.0 - 0.5, 0.0, 1.0);
    var near: Near;
    near.blend = select(blend, 0.0, blend >= 1.0);
    near.level = at.level;
    var place = at.place;
    if blend > 0.0 {
        place = place_on_level(min(place.level + 1, terrain.level_count - 1), g);
    }
    var is_second = false;
    loop {
        let samples = samples_around(place, g);
        if !is_second {
            near.coarse = samples;
        }
        near.fine = samples;
        place = at.place;
        let is_done = is_second || near.blend == 0.0;
        is_second = true;
        continuing {
            break if is_done;
        }
    }
    return near;
}

fn surface_at(near: Near) -> Surface {
    return between(surface_in_cell(near.fine), surface_in_cell(near.coarse), near.blend);
}

fn spline_weights(f: f32) -> vec4<f32> {
    let e = 1.0 - f;
    return vec4<f32>(e * e * e, 4.0 + f * f * (3.0 * f - 6.0), 4.0 + e * e * (3.0 * e - 6.0), f * f * f) / 6.0;
}

fn spline_slopes(f: f32) -> vec4<f32> {
    let e = 1.0 - f;
    return vec4<f32>(-0.5 * e * e, f * (1.5 * f - 2.0), e * (2.0 - 1.5 * e), 0.5 * f * f);
}

fn spline_curvatures(f: f32) -> vec4<f32> {
    return vec4<f32>(1.0 - f, 3.0 * f - 2.0, 1.0 - 3.0 * f, f);
}

fn spline_basis(f: f32) -> Basis {
    return Basis(spline_weights(f), spline_slopes(f), spline_curvatures(f));
}

// Returns the form of the surface: uniform cubic B-splines, which smooth the samples and do not pass through them.
fn form_at(near: Near) -> Surface {
    return between(surface_by(near.fine, spline_basis(near.fine.f.x), spline_basis(near.fine.f.y)),
        surface_by(near.coarse, spline_basis(near.coarse.f.x), spline_basis(near.coarse.f.y)), near.blend);
}

// Returns the height of a vertex of the mesh: bicubic on the finest level, where vertices may be between samples.
// Coarser levels have a sample in every pixel or two, and bilinear is within the error that chose them.
fn vertex_height_m(g: vec2<f32>, distance_m: f32) -> f32 {
    let cell = cell_at(surface_level(g, distance_m).place, g);
    if cell.is_finest {
        let wx = cubic_weights(cell.f.x);
        let reference = textureLoad(heights, cell.texel, cell.slot, 0).r;
        let along = vec4<f32>(
            dot(wx, row_of_samples(cell, -1) - reference), dot(wx, row_of_samples(cell, 0) - reference),
            dot(wx, row_of_samples(cell, 1) - reference), dot(wx, row_of_samples(cell, 2) - reference));
        return camera_relative_m(reference) + dot(cubic_weights(cell.f.y), along);
    }
    let nw = textureLoad(heights, cell.texel, cell.slot, 0).r;
    let ne = textureLoad(heights, cell.texel + vec2<i32>(1, 0), cell.slot, 0).r - nw;
    let sw = textureLoad(heights, cell.texel + vec2<i32>(0, 1), cell.slot, 0).r - nw;
    let se = textureLoad(heights, cell.texel + vec2<i32>(1, 1), cell.slot, 0).r - nw;
    return camera_relative_m(nw) + mix(ne * cell.f.x, mix(sw, se, cell.f.x), cell.f.y);
}

fn row_of_voids(cell: Cell, row: i32) -> vec4<f32> {
    return vec4<f32>(bitcast<vec4<u32>>(row_of_samples(cell, row)) & vec4<u32>(1u));
}

// Returns the no-data part around a place, 0 to 1, and its gradient over the level's samples: the no-data flags (the
// lowest bit of each sample) under a B-spline, which rounds their stairs.
fn void_share(cell: Cell) -> vec3<f32> {
    let f = clamp(cell.f, vec2<f32>(0.0), vec2<f32>(1.0));
    let rows = mat4x4<f32>(row_of_voids(cell, -1), row_of_voids(cell, 0), row_of_voids(cell, 1), row_of_voids(cell, 2));
    let along = spline_weights(f.x) * rows;
    let down = spline_weights(f.y);
    return vec3<f32>(dot(down, along), dot(down, spline_slopes(f.x) * rows), dot(spline_slopes(f.y), along));
}

// Value of `void_share` at the rim of a hole. Along rows of no-data samples, the rim is at the last samples with data.
const RIM_SHARE: f32 = 1.0 / 6.0;

// Returns whether the data have a hole here.
fn is_void(g: vec2<f32>, distance_m: f32) -> bool {
    return void_share(cell_at(surface_level(g, distance_m).place, g)).x > RIM_SHARE;
}
