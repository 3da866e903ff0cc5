// Adds suggestive contours to the edge list: lines that would be contours for a nearby eye (DeCarlo, Finkelstein,
// Rusinkiewicz, Santella 2003, "Suggestive Contours for Conveying Shape"; Pietrok 2021, section 4.1, draws their
// pixels).
//
// They are the zeros of the radial curvature where it rises toward the eye. Their edges go into the same list as
// contours, so strokes chain both, and a suggestive contour continues a contour where that ends.
//
// Curves are found by marching squares over the blocks of `lines/radial` (cells.wgsl). A curve ends where the rise
// falls below `min_rise`, where the surface faces the eye too much for a contour to be near, or where it turns away.
//
// Each eye of a stereo pair omits lines that are not suggestive contours for the other eye (He, Wang and Bao 2019,
// section 4.4: view-dependent lines that differ cannot be fused). The paper searches for a partner in the other eye's
// picture. Here the shape of the surface is available, so the other eye's curvature is computed at each corner: the
// curvatures of both eyes differ there by the distance of their zeros times the gradient. Lines that nearer land hides
// from the other eye stay.
//
// Edges are in the order of cells (ordered.wgsl): `stage` 0 counts them, 1 writes them, 2 updates their number.
#import hachure::view::{View, place_of_pixel}
#import hachure::cells::{Corner, Curves, corner_at, curves_of}
#import hachure::cell_edges::{Cell, put_curves}
#import hachure::curvature::{Shape, radial_of}
#import hachure::edges::KIND_SUGGESTIVE
#import hachure::mark_normal::{BLOCK_PX, block_count, pixel_of_block}

struct SuggestiveRules {
    // Least rise of the curvature toward the eye (y of `radial`) at a line.
    min_rise: f32,
    // Cosine between normal and direction to the eye above which there are no suggestive contours.
    largest_cosine: f32,
    // Largest distance between the lines of both eyes on the surface, in pixels of this eye; 0 ignores the other eye.
    agree_px: f32,
    padding: f32,
    // Position of the other eye of the stereo pair in the rig.
    other_eye_m: vec3<f32>,
    padding_eye: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> suggestive_rules: SuggestiveRules;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var shape_normal: texture_2d<f32>;
@group(0) @binding(5) var shape_bend: texture_2d<f32>;
@group(0) @binding(6) var shape_change: texture_2d<f32>;
@group(0) @binding(7) var radial: texture_2d<f32>;

// Returns a positive number where a line may be: by its rise, as in `radial`, and by how much the surface faces the
// eye.
fn room_of(rise: f32, facing: f32) -> f32 {
    let rises = (rise - suggestive_rules.min_rise) / max(suggestive_rules.min_rise, 0.01);
    return min(rises, suggestive_rules.largest_cosine - facing);
}

fn corner_of(block: vec2<i32>) -> Corner {
    let own = textureLoad(radial, block, 0);
    return corner_at(view, block, textureLoad(shape_normal, block, 0), own.x, min(room_of(own.y, own.z), own.z));
}

// Returns a positive number where the other eye may have this eye's line. `slope` is the gradient of the curvature, per
// pixel of this eye. A surface turned away from the other eye is near one of its contours, which is as good a partner.
fn room_for_other(block: vec2<i32>, slope: f32) -> f32 {
    let own = textureLoad(radial, block, 0);
    let at_m = place_of_pixel(view, pixel_of_block(view, block), own.w);
    let bend = textureLoad(shape_bend, block, 0);
    let shape = Shape(textureLoad(shape_normal, block, 0).xyz, bend.xyz, textureLoad(shape_change, block, 0));
    let found = radial_of(shape, normalize(suggestive_rules.other_eye_m - at_m));
    let differs = abs(found.curvature * distance(view.eye_m, at_m) / view.focal_px - own.x);
    let apart_px = differs / max(slope, 1e-12);
    return min(room_of(found.change * bend.w * bend.w, found.facing), 1.0 - apart_px / suggestive_rules.agree_px);
}

fn look(block: vec2<i32>) -> Curves {
    if any(block + 1 >= vec2<i32>(block_count(view))) {
        return Curves();
    }
    var corners = array<Corner, 4>(corner_of(block), corner_of(block + vec2<i32>(1, 0)), corner_of(block + vec2<i32>(1, 1)),
        corner_of(block + vec2<i32>(0, 1)));
    if suggestive_rules.agree_px > 0.0 {
        let slope = 0.5 * length(vec2<f32>(corners[1].value - corners[0].value + corners[2].value - corners[3].value,
            corners[3].value - corners[0].value + corners[2].value - corners[1].value)) / f32(BLOCK_PX);
        for (var i = 0; i < 4; i++) {
            let at = block + vec2<i32>((i & 1) ^ (i >> 1u), i >> 1u);
            corners[i].room = min(corners[i].room, room_for_other(at, slope));
        }
    }
    return curves_of(view, corners[0], corners[1], corners[2], corners[3]);
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let cell = Cell(vec2<i32>(id.xy), thread, group.x + group.y * groups.x, groups.x * groups.y);
    put_curves(view, distance_m, normal, cell, look(cell.block), KIND_SUGGESTIVE, 0u);
}
