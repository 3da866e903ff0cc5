// The land's form as rows of hachures follow it.
#define_import_path hachure::row_form
#import hachure::form::{form_of_level}
#import hachure::rows::{RowBlock, Frame, grid_of, camera_height_m}

// Of a step, in cells.
const LONGEST: f32 = 2.0;

// By east and north the slope, and the height in the world, at a place of a block: of the form on the level of the
// pyramid that the block's cells have.
fn row_form(block: RowBlock, frame: Frame, place: vec2<f32>) -> vec3<f32> {
    let at = form_of_level(grid_of(block, place), block.level);
    return vec3<f32>(dot(at.gradient, frame.point.dg_dx), dot(at.gradient, frame.point.dg_dy), at.height_m + camera_height_m());
}

// The way in cells along the slope that rises by `rise_m`.
fn way_of(block: RowBlock, frame: Frame, slope: vec2<f32>, rise_m: f32) -> vec2<f32> {
    let by_m = slope * (rise_m / max(dot(slope, slope), 1e-12));
    return (frame.point.dg_dx * by_m.x + frame.point.dg_dy * by_m.y) / block.cell;
}
