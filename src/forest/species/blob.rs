//! Clumps of leaves: stretched spheres of few triangles.
//!
//! A sphere is an icosahedron whose triangles are divided into four, repeatedly. Its vertices are moved outward so that
//! its outline is as large as the ellipsoid's, which matters most for spheres of 20 triangles.

use glam::{DQuat, DVec3};

use super::patch::Patch;

/// An ellipsoid of leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blob {
    pub at: DVec3,
    /// Radii along x, y and z.
    pub radii: DVec3,
    /// Rotation of the triangulation (not of the ellipsoid).
    pub turn: DQuat,
}

impl Blob {
    /// Returns its surface, of 20 · 4^`divisions` triangles.
    pub(super) fn patch(&self, divisions: u32) -> Patch {
        let mut patch = icosphere(divisions);
        let grown = match divisions {
            0 => 1.12,
            1 => 1.03,
            _ => 1.01,
        };
        for place in &mut patch.places {
            let way = self.turn * *place;
            *place = self.at + way * self.radii * grown;
        }
        patch
    }

    /// Whether a point is inside of the planes of all triangles.
    pub(super) fn holds(&self, place: DVec3, divisions: u32) -> bool {
        ((place - self.at) / self.radii).length() < Self::inner(divisions)
    }

    /// Returns the scale of the ellipsoid that is inside of all triangles.
    fn inner(divisions: u32) -> f64 {
        if divisions == 0 { 0.89 } else { 0.96 }
    }
}

/// Returns a sphere of radius 1.
fn icosphere(divisions: u32) -> Patch {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut places = Vec::new();
    for (long, short) in [(golden, 1.0), (golden, -1.0), (-golden, 1.0), (-golden, -1.0)] {
        places.extend([
            DVec3::new(0.0, short, long).normalize(),
            DVec3::new(short, long, 0.0).normalize(),
            DVec3::new(long, 0.0, short).normalize(),
        ]);
    }
    let edge = places[0].distance(places[3]) + 1e-9;
    let mut triangles = Vec::new();
    for a in 0..places.len() {
        for b in a + 1..places.len() {
            for c in b + 1..places.len() {
                let [p, q, r] = [a, b, c].map(|place| places[place]);
                if p.distance(q) < edge && q.distance(r) < edge && r.distance(p) < edge {
                    let is_outward = (q - p).cross(r - p).dot(p) > 0.0;
                    triangles.push(if is_outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    let mut patch = Patch { places, triangles };
    (0..divisions).for_each(|_| divide(&mut patch));
    patch
}

fn divide(patch: &mut Patch) {
    let mut middles: Vec<([usize; 2], usize)> = Vec::new();
    let mut finer = Vec::new();
    for &[a, b, c] in &patch.triangles {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|mut ends| {
            ends.sort_unstable();
            if let Some((_, middle)) = middles.iter().find(|(of, _)| *of == ends) {
                return *middle;
            }
            patch.places.push((patch.places[ends[0]] + patch.places[ends[1]]).normalize());
            middles.push((ends, patch.places.len() - 1));
            patch.places.len() - 1
        });
        finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    patch.triangles = finer;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_are_whole_and_hold_what_is_inside() {
        for divisions in 0..3 {
            let sphere = icosphere(divisions);
            assert_eq!(sphere.triangles.len(), 20 << (2 * divisions));
            // Euler's formula for a closed surface without handles.
            assert_eq!(sphere.places.len(), sphere.triangles.len() / 2 + 2);
            assert!(sphere.triangles.iter().all(|triangle| {
                let [a, b, c] = sphere.at(triangle);
                (b - a).cross(c - a).dot(a + b + c) > 0.0
            }));
        }
        let blob = Blob { at: DVec3::X, radii: DVec3::new(0.2, 0.2, 0.4), turn: DQuat::IDENTITY };
        for divisions in 0..2 {
            let patch = blob.patch(divisions);
            // The ellipsoid that `holds` tests is behind every triangle.
            let hull = Blob::inner(divisions);
            for triangle in &patch.triangles {
                let [a, b, c] = patch.at(triangle);
                let face = (b - a).cross(c - a);
                // The support of that ellipsoid, against the distance of the triangle's plane.
                let reach = (face * blob.radii).length() * hull;
                assert!((a - blob.at).dot(face) > reach, "{divisions}");
                // Planted: a larger ellipsoid would stick out.
                assert!((a - blob.at).dot(face) < reach * 1.15);
            }
        }
        assert!(blob.holds(DVec3::new(1.0, 0.0, 0.3), 1) && !blob.holds(DVec3::new(1.3, 0.0, 0.0), 1));
    }
}
