// The land's form as rows of hachures follow it.
#define_import_path hachure::row_form
#import hachure::terrain::{terrain, place_on_level, as_far_as_there}
#import hachure::surface::{Surface, surface_near, form_at}
#import hachure::rows::{RowBlock, Frame, grid_of, camera_height_m}

// Of a step, in cells.
const LONGEST: f32 = 2.0;

fn is_grid(g: vec2<f32>) -> bool {
    let low = vec2<f32>(terrain.extent_units.xy) / terrain.units_per_sample;
    let high = vec2<f32>(terrain.extent_units.zw) / terrain.units_per_sample;
    return all(g >= low) && all(g <= high);
}

// The form at a grid coordinate, on the level of the pyramid that a block's cells have.
fn surface_of(block: RowBlock, g: vec2<f32>) -> Surface {
    let wanted = clamp(block.level, 0.0, f32(terrain.level_count - 1));
    return form_at(surface_near(g, as_far_as_there(wanted, place_on_level(i32(wanted), g), g)));
}

// By east and north the slope, and the height in the world, at a place of a block.
fn row_form(block: RowBlock, frame: Frame, place: vec2<f32>) -> vec3<f32> {
    let at = surface_of(block, grid_of(block, place));
    return vec3<f32>(dot(at.gradient, frame.point.dg_dx), dot(at.gradient, frame.point.dg_dy), at.height_m + camera_height_m());
}

// The way in cells along the slope that rises by `rise_m`.
fn way_of(block: RowBlock, frame: Frame, slope: vec2<f32>, rise_m: f32) -> vec2<f32> {
    let by_m = slope * (rise_m / max(dot(slope, slope), 1e-12));
    return (frame.point.dg_dx * by_m.x + frame.point.dg_dy * by_m.y) / block.cell;
}
