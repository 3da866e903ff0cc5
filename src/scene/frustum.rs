//! The view frustum, and visibility of boxes and spheres in it.

use glam::{DQuat, DVec3};

/// An axis-aligned box relative to the camera, in metres.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// The corner with the least coordinates.
    pub low_m: DVec3,
    /// The corner with the greatest coordinates.
    pub high_m: DVec3,
}

impl Bounds {
    /// Returns the distance from the camera to the nearest point of the box; 0 inside.
    pub fn distance_m(&self) -> f64 {
        DVec3::ZERO.clamp(self.low_m, self.high_m).length()
    }

    /// Returns the distance from the camera to the farthest point of the box.
    pub fn farthest_m(&self) -> f64 {
        self.low_m.abs().max(self.high_m.abs()).length()
    }
}

/// The side planes of a view's pyramid, as inward unit normals; all planes pass through the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    normals: [DVec3; 4],
    forward: DVec3,
}

impl Frustum {
    /// Builds the frustum from the rays through the picture's corners, in order around it (upper left, upper right,
    /// lower right, lower left).
    pub fn new(corner_rays: [DVec3; 4]) -> Self {
        let middle: DVec3 = corner_rays.iter().sum();
        let side = |i: usize| {
            let normal = corner_rays[i].cross(corner_rays[(i + 1) % 4]).normalize_or_zero();
            if normal.dot(middle) < 0.0 { -normal } else { normal }
        };
        Self { normals: [side(0), side(1), side(2), side(3)], forward: middle.normalize_or_zero() }
    }

    /// Returns the unit vector along the axis, away from the camera.
    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// Returns the frustum widened by an angle in radians on every side; each side opens to a half space at most.
    pub fn widened(&self, angle_rad: f64) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        let normals = self.normals.map(|normal| {
            let outward = (self.forward - normal * normal.dot(self.forward)).normalize_or_zero();
            let turned = normal * cos + outward * sin;
            if turned.dot(self.forward) < normal.dot(self.forward) { self.forward } else { turned }
        });
        Self { normals, forward: self.forward }
    }

    /// Returns the frustum turned about the camera.
    pub(crate) fn turned(&self, turn: DQuat) -> Self {
        Self { normals: self.normals.map(|normal| turn * normal), forward: turn * self.forward }
    }

    /// Returns whether everything in the frustum `other`, which has the same apex, is in this one.
    pub(crate) fn contains(&self, other: &Self) -> bool {
        (0..4).all(|side| {
            let edge = other.normals[side].cross(other.normals[(side + 1) % 4]);
            let ray = if edge.dot(other.forward) < 0.0 { -edge } else { edge };
            self.normals.iter().all(|normal| normal.dot(ray) >= -1e-12)
        })
    }

    /// Returns the angle between the axis and the centre of a box, in radians; 0 if the camera is inside the box.
    pub fn aside(&self, bounds: &Bounds) -> f64 {
        let middle = (bounds.low_m + bounds.high_m) * 0.5;
        if bounds.distance_m() == 0.0 { 0.0 } else { middle.angle_between(self.forward) }
    }

    /// Whether part of a sphere may be in view. Conservative: never `false` for a visible sphere.
    pub fn may_see_sphere(&self, middle_m: DVec3, radius_m: f64) -> bool {
        self.normals.iter().all(|normal| normal.dot(middle_m) >= -radius_m)
    }

    /// Whether part of a box may be in view. Conservative: never `false` for a visible box.
    pub fn may_see(&self, bounds: &Bounds) -> bool {
        self.may_see_within(bounds, 0.0)
    }

    /// Whether part of a box may be in view or at most `reach_m` outside of it. Conservative: never `false` for such a
    /// box.
    pub fn may_see_within(&self, bounds: &Bounds, reach_m: f64) -> bool {
        self.normals.iter().all(|normal| {
            let farthest = DVec3::select(normal.cmpge(DVec3::ZERO), bounds.high_m, bounds.low_m);
            normal.dot(farthest) >= -reach_m
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A view of 60° by 40° along an angle from north, clockwise.
    fn view(yaw_rad: f64) -> Frustum {
        let (x, z) = (30_f64.to_radians().tan(), 20_f64.to_radians().tan());
        let corners = [[-x, z], [x, z], [x, -z], [-x, -z]].map(|[x, z]| DVec3::new(x, 1.0, z));
        Frustum::new(corners).turned(DQuat::from_rotation_z(-yaw_rad))
    }

    #[test]
    fn a_widened_frustum_contains_those_that_turn_a_little() {
        let wide = view(0.3).widened(0.06);
        for i in -10..=10 {
            assert!(wide.contains(&view(0.3 + 0.003 * f64::from(i))));
        }
        assert!(!wide.contains(&view(0.5)) && !wide.contains(&view(0.1)));
        assert!(view(0.3).contains(&view(0.3)) && !view(0.3).contains(&wide));
    }

    #[test]
    fn a_turned_frustum_sees_what_is_there() {
        let at = |x: f64, y: f64| Bounds { low_m: DVec3::new(x, y, -1.0), high_m: DVec3::new(x + 1.0, y + 1.0, 1.0) };
        let east = view(std::f64::consts::FRAC_PI_2);
        assert!(east.may_see(&at(100.0, 0.0)) && !east.may_see(&at(0.0, 100.0)));
        assert!((east.forward() - DVec3::X).length() < 1e-12);
    }
}
