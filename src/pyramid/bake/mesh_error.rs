//! The measured error of every mesh patch: the largest distance of its triangles from the data.
//!
//! A patch of stride 1 is compared with the surface between its own samples, at quarter steps in each valid cell, in
//! this module. A patch of stride 2^j, j ≥ 1, is compared with the full-resolution heights under it, in `vertices`.
//! Each quad is split along the diagonal from its first sample to the opposite one.

use rayon::prelude::*;

use super::tile_error::{LARGEST_WEIGHTS, LevelView, range_of};
use crate::pyramid::surface::bicubic;
use crate::pyramid::surface::cell_errors::{ROW_SAMPLES, Steps, row_errors_m};
use crate::pyramid::surface::levels::Region;
use crate::pyramid::surface::statistics::{PatchStatistics, rounded_up};
use crate::pyramid::tile::{PATCH_QUADS, is_void};

/// Measures the patches of stride 1 in the region `patches` (in patches), row-major. `view` is level 0.
pub(super) fn finest_patches(view: &LevelView<'_>, patches: Region) -> Vec<PatchStatistics> {
    let steps = Steps::new();
    let (finest, served) = (view.size, view.served);
    (0..patches.samples() as u32)
        .into_par_iter()
        .map(|patch| {
            let (px, py) = (patches.x + patch % patches.width, patches.y + patch / patches.width);
            let (x0, y0) = (px * PATCH_QUADS, py * PATCH_QUADS);
            let (x1, y1) = ((x0 + PATCH_QUADS).min(finest.width - 1), (y0 + PATCH_QUADS).min(finest.height - 1));
            let range = range_of(view, Region { x: x0, y: y0, width: x1 + 1 - x0, height: y1 + 1 - y0 });
            let mut worst = 0.0_f32;
            let columns: [u32; ROW_SAMPLES] =
                std::array::from_fn(|i| bicubic::neighbour(x0, i as u32, finest.width) - served.region.x);
            let samples = |row: u32, k: u32| {
                let line = served.row(bicubic::neighbour(row, k, finest.height));
                columns.map(|column| line[column as usize])
            };
            for row in y0..y1 {
                let four = [samples(row, 0), samples(row, 1), samples(row, 2), samples(row, 3)];
                let is_valid = |i: usize| !(is_void(four[1][i + 1]) || is_void(four[2][i + 1]));
                let errors_m = row_errors_m(four.each_ref(), &steps);
                for (i, error_m) in errors_m.into_iter().enumerate().take((x1 - x0) as usize) {
                    if error_m > worst && is_valid(i) && is_valid(i + 1) {
                        worst = error_m;
                    }
                }
            }
            // Near its edges the patch depends on heights outside the chunk, and on fillings.
            let doubt_m = if certain(view, x0, y0, x1, y1) { 0.0 } else { (LARGEST_WEIGHTS + 1.0) * view.doubt_m };
            let mesh_error_m = rounded_up(f64::from(worst) + doubt_m);
            PatchStatistics { min_m: range.min_m, max_m: range.max_m, mesh_error_m, voids: range.voids() }
        })
        .collect()
}

/// Returns whether the surface over a patch depends only on stored heights of the chunk's own tiles.
fn certain(view: &LevelView<'_>, x0: u32, y0: u32, x1: u32, y1: u32) -> bool {
    if view.doubt_m == 0.0 {
        return true;
    }
    let taken = Region { x: x0, y: y0, width: x1 + 1 - x0, height: y1 + 1 - y0 }.grown(1, view.size);
    let Region { x, y, width, height } = view.own;
    let inside = taken.x >= x && taken.y >= y && taken.x + taken.width <= x + width;
    inside
        && taken.y + taken.height <= y + height
        && (taken.y..taken.y + taken.height)
            .all(|row| view.served.span(taken.x, row, taken.width).iter().all(|height| !is_void(*height)))
}
