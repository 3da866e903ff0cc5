//! Computes how far vertices move from one frame to the next.

use glam::DVec3;
use hachure::tiles::grid_projection::GridProjection;
use hachure::tiles::selection::PatchKey;
use rayon::prelude::*;

use crate::tests::common::quantile;
use crate::tests::popping::SIDE;
use crate::tests::popping::mesh::{Mesh, parent};

/// The largest motion in pixels, with its patch and its position in the world.
pub type Worst = Option<(f64, PatchKey, DVec3)>;

/// Motions between two frames, in pixels.
#[derive(Default)]
pub struct Motions {
    pub whole: Vec<f64>,
    pub across: Vec<f64>,
    pub in_place: Vec<f64>,
    /// Number of vertices in view of patches that were neither drawn before, nor split, nor merged by one level.
    pub without_partner: usize,
    /// Worst of *whole*, *across*, *in place*.
    pub worst: [Worst; 3],
}

impl Motions {
    pub fn append(&mut self, mut other: Self) {
        self.whole.append(&mut other.whole);
        self.across.append(&mut other.across);
        self.in_place.append(&mut other.in_place);
        self.without_partner += other.without_partner;
        for (kind, worst) in other.worst.into_iter().enumerate() {
            if let Some((px, key, at_m)) = worst {
                self.note(kind, px, key, at_m);
            }
        }
    }

    pub fn note(&mut self, kind: usize, px: f64, key: PatchKey, at_m: DVec3) {
        if px > self.most(kind) {
            self.worst[kind] = Some((px, key, at_m));
        }
    }

    /// Returns the largest motion of a kind, in pixels.
    pub fn most(&self, kind: usize) -> f64 {
        self.worst[kind].map_or(0.0, |worst| worst.0)
    }

    /// Adds the motion of a vertex from `from_m` to `to_m`.
    pub fn pair(&mut self, after: &Mesh, key: PatchKey, from_m: DVec3, to_m: DVec3, normal: Option<DVec3>) {
        if let Some(normal) = normal.filter(|_| after.is_in_view(to_m)) {
            let step_m = to_m - from_m;
            self.whole.push(after.px(to_m, step_m));
            self.across.push(after.px(to_m, normal * step_m.dot(normal)));
            self.note(0, after.px(to_m, step_m), key, to_m);
            self.note(1, after.px(to_m, normal * step_m.dot(normal)), key, to_m);
        }
    }

    /// Adds the motion of the mesh between the heights `z_m` and that of `at_m`, at the same point of the map.
    pub fn in_place(&mut self, after: &Mesh, key: PatchKey, at_m: DVec3, z_m: f64, normal: DVec3) {
        let px = after.px(at_m, normal * normal.z * (at_m.z - z_m));
        self.in_place.push(px);
        self.note(2, px, key, at_m);
    }

    /// Returns a row of the printed table.
    pub fn line(&mut self, name: &str) -> String {
        let of = |values: &mut Vec<f64>| {
            [0.5, 0.99, 0.999, 1.0].map(|part| format!("{:8.3}", quantile(values, part))).join(" ")
        };
        let (whole, across, in_place) = (of(&mut self.whole), of(&mut self.across), of(&mut self.in_place));
        let (count, lone) = (self.whole.len(), self.without_partner);
        format!("{name:24} | {whole} | {across} | {in_place} | {count} vertices, {lone} without partner")
    }
}

/// Returns the motions of the patch `key` of the later mesh, in pixels of the later frame.
pub fn motions_of(before: &Mesh, after: &Mesh, grid_projection: &GridProjection, key: PatchKey) -> Motions {
    let mut motions = Motions::default();
    let patch = &after.patches[&key];
    let all = || (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j)));
    let mut pair = |from_m, to_m, normal| motions.pair(after, key, from_m, to_m, normal);
    // Returns the vertex of a coarse patch that equals a child's vertex, or to which it morphs.
    let coarse_of = |child: PatchKey, i: usize, j: usize| {
        let of = |patch: i64, k: usize| (patch.rem_euclid(2) as usize * (SIDE - 1) + (k & !1)) / 2;
        (of(child.x, i), of(child.y, j))
    };
    let children = (0..4).map(|k| PatchKey { level: key.level - 1, x: 2 * key.x + k % 2, y: 2 * key.y + k / 2 });
    let merged: Vec<PatchKey> = children.filter(|child| before.patches.contains_key(child)).collect();
    if let Some(old) = before.patches.get(&key) {
        all().for_each(|(i, j)| pair(old.at(i, j), patch.at(i, j), patch.normal(i, j)));
    } else if let Some(old) = before.patches.get(&parent(key)) {
        for (i, j) in all() {
            let (ci, cj) = coarse_of(key, i, j);
            pair(old.at(ci, cj), patch.at(i, j), patch.normal(i, j));
        }
    } else if !merged.is_empty() {
        for (child, (i, j)) in merged.iter().flat_map(|child| all().map(move |at| (child, at))) {
            let (ci, cj) = coarse_of(*child, i, j);
            pair(before.patches[child].at(i, j), patch.at(ci, cj), patch.normal(ci, cj));
        }
    } else {
        motions.without_partner += patch.vertices_m.iter().filter(|at| after.is_in_view(**at)).count();
    }
    for at_m in patch.vertices_m.iter().filter(|at| after.is_in_view(**at)) {
        if let Some((z_m, normal)) = before.under(grid_projection, at_m.truncate()) {
            motions.in_place(after, key, *at_m, z_m, normal);
        }
    }
    motions
}

/// Returns the motions between two frames.
pub fn motions(before: &Mesh, after: &Mesh, grid_projection: &GridProjection) -> Motions {
    let mut keys: Vec<PatchKey> = after.patches.keys().copied().collect();
    keys.sort();
    let later: Vec<Motions> = keys.par_iter().map(|key| motions_of(before, after, grid_projection, *key)).collect();
    let mut keys: Vec<PatchKey> = before.patches.keys().copied().collect();
    keys.sort();
    // Two triangle meshes are farthest apart approximately at a vertex of one of them.
    let earlier = keys.par_iter().map(|key| {
        let mut motions = Motions::default();
        for at_m in before.patches[key].vertices_m.iter().filter(|at| after.is_in_view(**at)) {
            if let Some((z_m, normal)) = after.under(grid_projection, at_m.truncate()) {
                motions.in_place(after, *key, *at_m, z_m, normal);
            }
        }
        motions
    });
    let mut sum = Motions::default();
    earlier.collect::<Vec<_>>().into_iter().chain(later).for_each(|motions| sum.append(motions));
    sum
}
