//! Which trees an eye sees. See `shaders/surface/trees/place.wgsl`.

use glam::DVec3;

use super::DrawnTrees;
use crate::forest::cells;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Cx;
pub use crate::gpu::wgsl::shared::trees::TreeInstance;
pub(super) use crate::gpu::wgsl::surface::trees::place::{Forest as ForestUniform, TreeCell, TreePoint};
pub(super) use crate::gpu::wgsl::surface::trees::raster::TreeVertex;
use crate::scene::Forest;
use crate::scene::view::View;
use crate::tiles::Terrain;

/// Trees in view, at most. Cells are asked from near to far, as far as the GPU keeps to that order.
pub const MOST_TREES: u32 = 1 << 18;
/// What is smaller on the picture is not drawn.
pub const SMALLEST_PX: f64 = 3.0;
/// Where trees are smaller than this on the picture, fewer of them are drawn.
pub const FULL_PX: f64 = 20.0;
/// Trees that are farther away are not drawn, however large they are on the picture: a frame lists every cell.
pub const FARTHEST_M: f64 = 8000.0;
/// The height of the tallest tree, by that of the mean one.
pub const TALLEST: f64 = 1.35;
/// Workgroups in a row of a dispatch.
const GROUPS_IN_ROW: u32 = crate::gpu::wgsl::shared::dispatch::GROUPS_IN_ROW;

/// The cells of an eye.
const TREE_CELLS: BufferKind = BufferKind::storage("tree cells");

/// Finds the trees of a forest that an eye sees. Reads the terrain.
pub fn run(
    cx: &mut Cx<'_>,
    (view, eye): (&Resource, &View),
    origin_m: DVec3,
    terrain: &Terrain,
    forest: &Forest,
    trees: &DrawnTrees,
) {
    let tallest_m = forest.height_m * TALLEST;
    // Beyond it no tree is large enough.
    let reach_m = (tallest_m * eye.focal_px() / SMALLEST_PX).min(FARTHEST_M);
    let range_m = terrain.range_m().map(f64::from);
    let mut cells = cells::in_view(eye.pose.position_m, &eye.frustum(), reach_m, range_m, tallest_m);
    let eye_m = eye.pose.position_m.truncate();
    cells.sort_by(|a, b| a.corner_m().distance(eye_m).total_cmp(&b.corner_m().distance(eye_m)));
    let starts = &trees.shared.starts;
    let packed: Vec<TreeCell> = cells
        .iter()
        .map(|cell| {
            let [first, end] = [cell.number, cell.number + 1].map(|number| starts[number as usize]);
            TreeCell {
                corner_m: (cell.corner_m() - origin_m.truncate()).as_vec2().to_array(),
                tile: cell.tile.to_array(),
                number: cell.number,
                first,
                count: end - first,
                ..TreeCell::default()
            }
        })
        .collect();
    cx.write(&trees.draw, &[trees.shared.vertex_count, 0, 0, 0]);
    let count = packed.len() as u32;
    let uniform = ForestUniform {
        seed: forest.seed,
        cells: count,
        capacity: MOST_TREES,
        density: (forest.trees_per_ha / Forest::MOST_TREES_PER_HA) as f32,
        tree_line_m: forest.tree_line_m as f32,
        raggedness_m: forest.raggedness_m as f32,
        steepest: forest.steepest_deg.to_radians().tan() as f32,
        height_m: forest.height_m as f32,
        smallest_px: SMALLEST_PX as f32,
        full_px: FULL_PX as f32,
        ..ForestUniform::default()
    };
    if packed.is_empty() && !cx.rehearses() {
        return;
    }
    let mut resources: Vec<Named> = vec![
        ("view", view.clone()),
        ("forest", cx.uniform("forest", &uniform)),
        ("tree_cells", cx.upload(&TREE_CELLS, &packed).binding()),
        ("tree_points", trees.shared.points.binding()),
        ("tree_instances", trees.instances.binding()),
        ("tree_draw", trees.draw.binding()),
    ];
    resources.extend(terrain.resources());
    let rows = count.div_ceil(GROUPS_IN_ROW).max(1);
    cx.groups("surface/trees/place", [count.min(GROUPS_IN_ROW), rows], &resources);
}
