//! The mesh of a frame as it was drawn.

use std::collections::{BTreeSet, HashMap};

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::pyramid::tile::PATCH_QUADS;
use hachure::scene::view::View;
use hachure::style::Style;
use hachure::tiles::grid_projection::GridProjection;
use hachure::tiles::selection::{PatchInstance, PatchKey};
use hachure::world::Surfaces;

use crate::tests::common::draw::{draw, north_west};
use crate::tests::popping::{SIDE, SIZE_PX};

/// A patch as it was drawn.
#[derive(Clone)]
pub struct Patch {
    instance: PatchInstance,
    /// Vertices in the world, row by row.
    pub vertices_m: Vec<DVec3>,
}

/// All patches of a frame.
#[derive(Clone)]
pub struct Mesh {
    pub view: View,
    pub patches: HashMap<PatchKey, Patch>,
    /// The levels of the patches.
    levels: BTreeSet<i32>,
    /// Whether a part was coarser than its error allows.
    pub late: bool,
}

impl Patch {
    pub fn at(&self, i: usize, j: usize) -> DVec3 {
        self.vertices_m[j * SIDE + i]
    }

    /// Returns the mesh's normal at a vertex, from neighbours far enough away that they have not merged with it.
    pub fn normal(&self, i: usize, j: usize) -> Option<DVec3> {
        (0..4).map(|reach| 1 << reach).find_map(|reach: usize| {
            let (low, high) = (|k: usize| k.saturating_sub(reach), |k: usize| (k + reach).min(SIDE - 1));
            let east = self.at(high(i), j) - self.at(low(i), j);
            let south = self.at(i, high(j)) - self.at(i, low(j));
            let normal = south.cross(east);
            (normal.z.abs() > 1e-9 * east.length() * south.length()).then(|| normal.normalize())
        })
    }

    /// Returns height and normal of the triangle above a point, or `None` if neither triangle of the quad is above it.
    /// The quad is divided from its first corner to its last.
    pub fn quad_at(&self, i: usize, j: usize, place_m: DVec2) -> Option<(f64, DVec3)> {
        let (first, last) = (self.at(i, j), self.at(i + 1, j + 1));
        [self.at(i + 1, j), self.at(i, j + 1)].into_iter().find_map(|side| {
            let (a, b) = (side - first, last - first);
            let area = a.truncate().perp_dot(b.truncate());
            if area.abs() < 1e-3 {
                return None;
            }
            let from = place_m - first.truncate();
            let (u, v) = (from.perp_dot(b.truncate()) / area, a.truncate().perp_dot(from) / area);
            (u >= -1e-4 && v >= -1e-4 && u + v <= 1.0 + 1e-4)
                .then(|| (first.z + u * a.z + v * b.z, a.cross(b).normalize()))
        })
    }
}

/// Returns the key of the patch on the next coarser level.
pub fn parent(key: PatchKey) -> PatchKey {
    PatchKey { level: key.level + 1, x: key.x >> 1, y: key.y >> 1 }
}

impl Mesh {
    pub fn read(gpu: &Gpu, renderer: &mut Renderer, world: &mut Surfaces, view: View, style: &Style) -> Self {
        let prepared = draw(gpu, world, renderer, &view, style, &north_west());
        let vertices = renderer.drawn_vertices(gpu, &prepared).unwrap().expect("one batch");
        let selection = &prepared.selection;
        let instances = selection.solid.iter().chain(&selection.with_holes);
        let camera_m = view.pose.position_m;
        let world_m = |at: &[f32; 4]| camera_m + DVec3::new(at[0].into(), at[1].into(), at[2].into());
        let patches = vertices.chunks_exact(SIDE * SIDE).zip(instances).map(|(vertices, instance)| Patch {
            instance: *instance,
            vertices_m: vertices.iter().map(world_m).collect(),
        });
        let levels = selection.leaves.iter().map(|key| key.level).collect();
        let patches = selection.leaves.iter().copied().zip(patches).collect();
        Self { view, patches, levels, late: prepared.tiles.late }
    }

    /// Returns the mesh with a planted error: no morphing. A patch or an edge that is morphing to a coarser level is
    /// already at that level. An even vertex has not moved yet, so all vertices are still vertices of the mesh itself.
    pub fn without_morphing(&self) -> Self {
        let mut mesh = self.clone();
        for patch in mesh.patches.values_mut() {
            let drawn = patch.vertices_m.clone();
            let [west, east, north, south] = patch.instance.edge_levels;
            for (i, j) in (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j))) {
                let last = SIDE - 1;
                let mut level = patch.instance.inner_level;
                for (is_there, edge) in [(i == 0, west), (i == last, east), (j == 0, north), (j == last, south)] {
                    level = if is_there { edge } else { level };
                }
                let shift = level.ceil() as usize;
                let on_level = |k: usize| k >> shift << shift;
                patch.vertices_m[j * SIDE + i] = drawn[on_level(j) * SIDE + on_level(i)];
            }
        }
        mesh
    }

    /// Returns height and normal of the mesh at a point.
    pub fn under(&self, grid_projection: &GridProjection, place_m: DVec2) -> Option<(f64, DVec3)> {
        let grid = grid_projection.grid_from_world(place_m);
        self.levels.iter().find_map(|&level| {
            let stride = f64::from(level).exp2();
            let at = grid / stride;
            let patch_of = |k: f64| (k / f64::from(PATCH_QUADS)).floor() as i64;
            let key = PatchKey { level, x: patch_of(at.x), y: patch_of(at.y) };
            let patch = self.patches.get(&key)?;
            let quad_of = |k: f64, patch: i64| {
                (k - patch as f64 * f64::from(PATCH_QUADS)).clamp(0.0, f64::from(PATCH_QUADS) - 0.5) as usize
            };
            let (i, j) = (quad_of(at.x, key.x), quad_of(at.y, key.y));
            // A vertex morphs to the left and up, so a point is in its own quad or in a later one.
            let near = (j..(j + 2).min(SIDE - 1)).flat_map(|j| (i..(i + 2).min(SIDE - 1)).map(move |i| (i, j)));
            let all = (0..SIDE - 1).flat_map(|j| (0..SIDE - 1).map(move |i| (i, j)));
            near.chain(all).find_map(|(i, j)| patch.quad_at(i, j, place_m))
        })
    }

    /// Returns the length on the screen of a step at a point, in pixels.
    pub fn px(&self, at_m: DVec3, step_m: DVec3) -> f64 {
        let way_m = at_m - self.view.pose.position_m;
        let ray = way_m.normalize();
        (step_m - ray * step_m.dot(ray)).length() * self.view.focal_px() / way_m.length()
    }

    pub fn is_in_view(&self, at_m: DVec3) -> bool {
        let View { pose, .. } = &self.view;
        let way_m = at_m - pose.position_m;
        let ahead_m = way_m.dot(pose.forward);
        let [wide, high] = SIZE_PX.map(|side| 0.5 * f64::from(side) / self.view.focal_px());
        ahead_m > 0.0 && way_m.dot(pose.right).abs() < wide * ahead_m && way_m.dot(pose.up).abs() < high * ahead_m
    }
}
