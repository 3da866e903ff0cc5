// The form of the land: the land at a level of the pyramid, smoothed by a B-spline.
#define_import_path hachure::form
#import hachure::view::{View, distance_from_eye, ray_of_pixel}
#import hachure::terrain::{terrain, GridPoint, grid_from_world, place_on_level, as_far_as_there, first_sample, last_sample}
#import hachure::surface::{Surface, surface_near, form_at}
#import hachure::earth::{Unbent, unbend, bend_normal}

// Levels that can be averaged beyond the coarsest one of the pyramid; and the width of the averaging square in samples,
// per factor by which a sample should be larger.
const MAX_BEYOND: f32 = 2.0;
const WIDER: f32 = 1.5;
// Smallest cosine between the surface and the view direction that is used; land at a flatter angle counts as this.
const MIN_FACING: f32 = 0.0625;

// Returns the land smoothed at a level. A small DEM has few levels, and a map of it may request more: above the
// coarsest level the form is the mean over a square.
fn form_of_level(g: vec2<f32>, level: f32) -> Surface {
    let coarsest = f32(terrain.level_count - 1);
    let wanted = clamp(level, 0.0, coarsest);
    let beyond = exp2(clamp(level - coarsest, 0.0, MAX_BEYOND));
    let along = i32(ceil(beyond));
    let step = WIDER * (beyond - 1.0) / beyond * exp2(coarsest);
    var sum = Surface(0.0, vec2<f32>(0.0), vec3<f32>(0.0));
    for (var i = 0; i < along * along; i++) {
        let tap = vec2<f32>(vec2<i32>(i % along, i / along)) - 0.5 * f32(along - 1);
        let at = clamp(g + step * tap, first_sample(), last_sample());
        let form = form_at(surface_near(at, as_far_as_there(wanted, place_on_level(i32(wanted), at), at)));
        sum.height_m += form.height_m;
        sum.gradient += form.gradient;
        sum.curvature += form.curvature;
    }
    let share = 1.0 / f32(along * along);
    return Surface(share * sum.height_m, share * sum.gradient, share * sum.curvature);
}

fn normal_of_level(flat_place: Unbent, point: GridPoint, level: f32) -> vec3<f32> {
    let gradient = form_of_level(point.g, level).gradient;
    return bend_normal(flat_place, vec2<f32>(dot(gradient, point.dg_dx), dot(gradient, point.dg_dy)));
}

// Returns the level whose samples cover an area of `sample_px` squared on the picture, taking the angle of the land
// into account.
fn level_seen(view: View, at: vec3<f32>, flat_place: Unbent, point: GridPoint, sample_px: f32) -> f32 {
    let level = log2(sample_px * distance_from_eye(view, at) / (view.focal_px * terrain.spacing_m));
    let facing = abs(dot(normal_of_level(flat_place, point, level), normalize(view.eye_m - at)));
    return level - 0.5 * log2(max(facing, MIN_FACING));
}

// Returns the vectors from the point of a pixel, on a plane with that normal, to where the rays of the pixels to the
// right and below meet the plane, in metres. `depth_m` is along the view axis.
fn steps_on_plane(view: View, pixel: vec2<i32>, depth_m: f32, normal: vec3<f32>) -> mat2x3<f32> {
    let ray = ray_of_pixel(view, pixel);
    let facing = dot(normal, ray);
    let by_facing = 1.0 / select(facing, -1e-6, abs(facing) < 1e-6);
    let right = depth_m * (view.ray_dx - ray * (dot(normal, view.ray_dx) * by_facing));
    let down = depth_m * (view.ray_dy - ray * (dot(normal, view.ray_dy) * by_facing));
    return mat2x3<f32>(right, down);
}

// The level whose samples are `sample_px` wide on the picture, and the normal there. Land at a flat angle has narrower
// samples; they are matched by area.
struct Form {
    level: f32,
    normal: vec3<f32>,
}

fn form_seen(view: View, at: vec3<f32>, flat_place: Unbent, point: GridPoint, sample_px: f32) -> Form {
    let seen = level_seen(view, at, flat_place, point, sample_px);
    return Form(seen, normal_of_level(flat_place, point, seen));
}
