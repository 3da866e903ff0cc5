//! Levels of detail of a mesh: the mesh itself, and up to two with fewer triangles, each with its error.
//!
//! The error is the distance of the coarser mesh from the full one ([`deviation`](super::deviation)): where it is below
//! half a pixel, switching between the two moves outlines by no more than that. The level for each eye is chosen on the
//! GPU (`surface/meshes/cull`).

use super::Mesh;
use super::deviation::deviation;
use super::simplify::nearest;

/// Largest number of levels of a mesh, the full one included.
pub(crate) const MAX_LEVELS: usize = 3;
/// Divisors of the triangle count for the coarser levels.
const SHARES: [usize; MAX_LEVELS - 1] = [4, 16];
/// Meshes with fewer triangles have no coarser levels.
const MIN_TRIANGLES: usize = 64;
/// Meshes with more triangles have none either: simplifying them would take minutes.
const MAX_TRIANGLES: usize = 1 << 19;
/// A level with more than this fraction of the triangles of the one before is left out.
const MAX_SHARE_OF_FINER: f64 = 0.75;
/// A level whose error exceeds this fraction of the radius is left out: it would be drawn only on a few pixels.
const LARGEST_ERROR: f64 = 0.25;
/// Number of triangles from which simplifying takes noticeably long.
pub(crate) const MANY_TRIANGLES: usize = 20_000;

/// A simplified version of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    /// The mesh, in the coordinates of the full one, with a centre of its own.
    pub mesh: Mesh,
    /// Its distance from the full mesh, in that mesh's unit.
    pub error_m: f64,
}

/// Computes the coarser levels of a mesh, finest first; none where they would not be worth it.
pub(crate) fn coarser(mesh: &Mesh) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    let whole = mesh.triangles.len();
    if !(MIN_TRIANGLES..=MAX_TRIANGLES).contains(&whole) {
        return levels;
    }
    for share in SHARES {
        let last = levels.last();
        let most = last.map_or(whole, |level| level.mesh.triangles.len()) as f64 * MAX_SHARE_OF_FINER;
        let min_error_m = last.map_or(0.0, |level| level.error_m);
        let Some(coarse) = nearest(mesh, whole / share, deviation) else { continue };
        let (coarse, error_m) = coarse;
        let error_m = error_m.max(min_error_m);
        if coarse.triangles.len() as f64 <= most && error_m <= LARGEST_ERROR * mesh.radius_m {
            levels.push(Level { mesh: coarse, error_m });
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::build::Soup;
    use glam::DVec3;

    /// Returns a ball with `rings` rings of triangles, closed at both ends.
    fn ball(rings: u32) -> Mesh {
        let at = |row: u32, column: u32| {
            let (z, turn) = (f64::from(row) / f64::from(rings), f64::from(column) / f64::from(2 * rings));
            let ((ring, up), (sin, cos)) =
                ((z * std::f64::consts::PI).sin_cos(), (turn * std::f64::consts::TAU).sin_cos());
            DVec3::new(5.0 + 2.0 * ring * cos, 7.0 + 2.0 * ring * sin, 2.0 * up)
        };
        let mut soup = Soup::default();
        for row in 0..rings {
            for column in 0..2 * rings {
                let next = (column + 1) % (2 * rings);
                let first = soup.places_m.len() as u32;
                soup.places_m.extend([at(row, column), at(row + 1, column), at(row + 1, next), at(row, next)]);
                soup.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
        soup.into_mesh("ball.obj".to_owned()).unwrap()
    }

    #[test]
    fn levels_have_fewer_triangles_and_the_error_that_they_state() {
        let mesh = ball(24);
        let levels = coarser(&mesh);
        assert_eq!(levels.len(), 2);
        let mut before = mesh.triangles.len();
        for level in &levels {
            let triangles = level.mesh.triangles.len();
            assert!(triangles as f64 <= 0.75 * before as f64 && triangles > 10, "{triangles} of {before}");
            before = triangles;
            // Distances from the ball, at a vertex and the middle of every triangle.
            let off = |at_m: DVec3| (at_m.distance(DVec3::new(5.0, 7.0, 0.0)) - 2.0).abs();
            let corner = |i: usize, k: usize| level.mesh.middle_m + level.mesh.corner_m(i, k);
            let middle = |i: usize| (0..3).map(|k| corner(i, k)).sum::<DVec3>() / 3.0;
            let found = (0..triangles).flat_map(|i| [off(middle(i)), off(corner(i, 0))]).fold(0.0, f64::max);
            assert!(found <= level.error_m * 1.05 && found > 0.3 * level.error_m, "{found} {}", level.error_m);
            // Planted error: a mesh that is larger by more than that is farther away.
            let mut larger = level.mesh.clone();
            larger.vertices_m.iter_mut().flatten().for_each(|along| *along *= 1.0 + level.error_m as f32);
            assert!(deviation(&mesh, &larger) > level.error_m * 1.2);
        }
        assert!(levels[0].error_m < levels[1].error_m);
        // Simple meshes have no coarser levels.
        assert!(coarser(&ball(3)).is_empty());
    }
}
