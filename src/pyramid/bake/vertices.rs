//! The errors of the mesh patches of stride 2 and more against the full-resolution heights.
//!
//! The first round compares the triangles of a stride with every height. A later one has the heights at every 2^base-th
//! sample and the last, which are the vertices of the patches of stride 2^base, and the errors of these patches.
//! Between the vertices both meshes are linear, and the diagonals of the finer mesh are on those of the coarser one:
//! their distance is largest at a vertex of the finer mesh. That distance plus the error of the finer patch bounds the
//! error of the coarser one. Where the last column or row of quads is cut by the end of the grid, diagonals cross; near
//! the coarser one, the planes of both its triangles are compared with both sides.
//!
//! In the first round, a vertex without data has the height of its filling, if that is known. Otherwise it has the mean
//! of the known heights around it, no farther away than the sides of the round's largest quads; where nothing is known,
//! there is nothing to draw, and the vertex is NaN.

use rayon::prelude::*;

use super::plan::Steps;
use crate::pyramid::surface::field::Field;
use crate::pyramid::surface::levels::{LevelSize, Region};
use crate::pyramid::surface::statistics::{PatchPage, PatchStatistics, rounded_up};
use crate::pyramid::tile::PATCH_QUADS;

/// The vertices over a chunk.
pub(super) struct Vertices<'a> {
    /// The size of level 0.
    pub finest: LevelSize,
    /// Distance between vertices, in samples of level 0.
    pub step: u64,
    /// Their heights in metres, addressed by their numbers; NaN if unknown or no-data.
    pub field: &'a Field,
    /// In the first round, level 0 as tiles serve it.
    pub served: Option<&'a Field>,
    /// Radius in vertices of the mean that an unknown vertex takes.
    pub reach: u32,
}

/// A quad of a patch: the numbers and positions of its first and last vertices.
struct Quad {
    x: [u32; 2],
    y: [u32; 2],
    left: u32,
    top: u32,
    width: f64,
    height: f64,
    cut: bool,
}

impl Vertices<'_> {
    fn steps(&self) -> (Steps, Steps) {
        let Self { finest, step, .. } = *self;
        (Steps { samples: finest.width, step }, Steps { samples: finest.height, step })
    }

    /// Returns the height that a mesh has at a vertex; NaN where nothing is known around it.
    pub(super) fn height_m(&self, x: u32, y: u32, reach: u32) -> f64 {
        let known = self.field.at(x, y);
        if !known.is_nan() {
            return known.into();
        }
        let filled = self.served.filter(|served| served.has(x, y)).map_or(f32::NAN, |served| served.at(x, y));
        if filled.is_nan() { self.mean_m(x, y, reach) } else { filled.into() }
    }

    /// Returns the mean of the known heights around a vertex.
    fn mean_m(&self, x: u32, y: u32, reach: u32) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for row in self.around(x, y, reach) {
            for height in row.iter().filter(|height| !height.is_nan()) {
                sum += f64::from(*height);
                count += 1.0;
            }
        }
        // Rounded to f32, as later rounds read it.
        f64::from((sum / count) as f32)
    }

    fn around(&self, x: u32, y: u32, reach: u32) -> impl Iterator<Item = &[f32]> {
        let (columns, rows) = self.steps();
        let (left, right) = (x.saturating_sub(reach), (x + reach + 1).min(columns.count()));
        let (top, bottom) = (y.saturating_sub(reach), (y + reach + 1).min(rows.count()));
        (top..bottom).map(move |row| self.field.span(left, row, right - left))
    }

    /// Returns the vertices of the next round in `own` (in its numbers), 2^`levels` times as far apart. A vertex is
    /// known where one of the quads around it may have data.
    pub(super) fn decimated(&self, levels: u32, own: Region) -> Field {
        let (columns, rows) = self.steps();
        let at = |i: u32, count: u32| (u64::from(i) << levels).min(u64::from(count) - 1) as u32;
        let mut heights_m = Vec::with_capacity(own.samples());
        for y in own.y..own.y + own.height {
            for x in own.x..own.x + own.width {
                let (x, y) = (at(x, columns.count()), at(y, rows.count()));
                let data = self.around(x, y, self.reach).flatten().any(|height| !height.is_nan());
                heights_m.push(if data { self.height_m(x, y, self.reach) as f32 } else { f32::NAN });
            }
        }
        Field { region: own, heights_m }
    }

    /// Measures the patches of the stride with 2^`d` vertices to a quad, in the region `patches` (in patches),
    /// row-major; their errors are at least those of their children. `under_m` bounds the error of the round's finest
    /// patches under each; it is 0 in the first round.
    pub(super) fn patches(
        &self,
        d: u32,
        patches: Region,
        (children, child_region): (&[PatchStatistics], Region),
        under_m: &[f32],
    ) -> Vec<PatchStatistics> {
        (0..patches.samples() as u32)
            .into_par_iter()
            .map(|i| {
                let (x, y) = (patches.x + i % patches.width, patches.y + i / patches.width);
                let mut patch: Option<PatchStatistics> = None;
                for_children((x, y), child_region, |child| {
                    let child = children[child];
                    patch = Some(patch.map_or(child, |patch| PatchStatistics {
                        min_m: patch.min_m.min(child.min_m),
                        max_m: patch.max_m.max(child.max_m),
                        mesh_error_m: patch.mesh_error_m.max(child.mesh_error_m),
                        voids: patch.voids.union(child.voids),
                    }));
                });
                let patch = patch.unwrap_or(PatchPage::NOTHING);
                let own_m = self.patch_error_m(d, x, y) + f64::from(under_m[i as usize]);
                PatchStatistics { mesh_error_m: rounded_up(own_m).max(patch.mesh_error_m), ..patch }
            })
            .collect()
    }

    /// Returns the largest distance in metres of known heights from the triangles of a patch.
    fn patch_error_m(&self, d: u32, x: u32, y: u32) -> f64 {
        let mut worst = 0.0_f64;
        for quad_y in y * PATCH_QUADS..(y + 1) * PATCH_QUADS {
            for quad_x in x * PATCH_QUADS..(x + 1) * PATCH_QUADS {
                if let Some(quad) = self.quad(d, quad_x, quad_y) {
                    worst = worst.max(self.quad_error_m(d, &quad));
                }
            }
        }
        worst
    }

    fn quad(&self, d: u32, x: u32, y: u32) -> Option<Quad> {
        let (columns, rows) = self.steps();
        let end = |i: u64, steps: Steps| (i << d).min(u64::from(steps.count()) - 1) as u32;
        let ends = |i: u32, steps| [end(i.into(), steps), end(u64::from(i) + 1, steps)];
        let (x, y) = (ends(x, columns), ends(y, rows));
        if x[0] == x[1] || y[0] == y[1] {
            return None;
        }
        let (left, top) = (columns.position(x[0]), rows.position(y[0]));
        let (width, height) = (columns.position(x[1]) - left, rows.position(y[1]) - top);
        let whole = self.step << d;
        let cut = self.step > 1 && (u64::from(width) != whole || u64::from(height) != whole);
        Some(Quad { x, y, left, top, width: width.into(), height: height.into(), cut })
    }

    fn quad_error_m(&self, d: u32, quad: &Quad) -> f64 {
        let count = quad.x[1] + 1 - quad.x[0];
        let corner = |x: usize, y: usize| self.field.at(quad.x[x], quad.y[y]);
        let known = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        let lines = || (quad.y[0]..=quad.y[1]).map(|y| (y, self.field.span(quad.x[0], y, count)));
        if known.iter().all(|height| height.is_nan())
            && lines().all(|(_, line)| line.iter().all(|height| height.is_nan()))
        {
            return 0.0;
        }
        let reach = self.reach.max(1 << d);
        let corner = |x: usize, y: usize| self.height_m(quad.x[x], quad.y[y], reach);
        let corners = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        let (columns, rows) = self.steps();
        let mut worst = 0.0_f64;
        for (y, line) in lines() {
            let v = f64::from(rows.position(y) - quad.top) / quad.height;
            worst = worst.max(if self.step == 1 {
                line_error_m(line, corners, v)
            } else {
                let u = |i: u32| f64::from(columns.position(quad.x[0] + i) - quad.left) / quad.width;
                // Both triangles within a step of the diagonal, where the diagonals of the finer quads cross it.
                let near = if quad.cut { self.step as f64 * (1.0 / quad.width + 1.0 / quad.height) } else { 0.0 };
                (0..)
                    .zip(line)
                    .filter(|(_, height)| !height.is_nan())
                    .map(|(i, height)| planes_error_m(f64::from(*height), corners, (u(i), v), near))
                    .fold(0.0, f64::max)
            });
        }
        worst
    }
}

/// Calls `each` with the index in `region`, row-major, of each existing child of (`x`, `y`).
pub(super) fn for_children((x, y): (u32, u32), region: Region, mut each: impl FnMut(usize)) {
    for child_y in (2 * y).max(region.y)..(2 * y + 2).min(region.y + region.height) {
        for child_x in (2 * x).max(region.x)..(2 * x + 2).min(region.x + region.width) {
            each(((child_y - region.y) * region.width + child_x - region.x) as usize);
        }
    }
}

/// Returns the largest difference between the heights of a row across a quad (both ends included) and the quad's
/// triangles, at the fraction `v` down the quad.
fn line_error_m(heights_m: &[f32], [first, right, down, opposite]: [f64; 4], v: f64) -> f64 {
    let last = (heights_m.len() - 1) as f64;
    let mut worst = 0.0_f64;
    for (x, height) in heights_m.iter().enumerate() {
        let u = x as f64 / last;
        let flat = if u >= v {
            first + u * (right - first) + v * (opposite - right)
        } else {
            first + v * (down - first) + u * (opposite - down)
        };
        // f64::max ignores the NaN of no-data.
        worst = worst.max((f64::from(*height) - flat).abs());
    }
    worst
}

/// Returns the difference between a height and the quad's triangle there, or the larger of both within `near` of the
/// diagonal.
fn planes_error_m(height: f64, [first, right, down, opposite]: [f64; 4], (u, v): (f64, f64), near: f64) -> f64 {
    let upper = (height - (first + u * (right - first) + v * (opposite - right))).abs();
    let lower = (height - (first + v * (down - first) + u * (opposite - down))).abs();
    match u - v {
        side if side.abs() <= near => upper.max(lower),
        side if side >= 0.0 => upper,
        _ => lower,
    }
}
