//! The placement of the headset's room in the world.
//!
//! OpenXR uses metres with y up and −z ahead; the world uses metres east, north and up. A stage gives the point of the
//! world at the middle of the room's floor, the heading, and the number of world metres per metre of the room.

use glam::{DMat3, DQuat, DVec3};

use crate::scene::view::{Lens, Pose, Rig, View};

/// Placement of the room in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stage {
    /// The middle of the floor, in the world.
    pub floor_m: DVec3,
    /// Direction of the room's −z, clockwise from north.
    pub heading_rad: f64,
    /// World metres per metre of the room.
    pub scale: f64,
}

/// An eye in the room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eye {
    /// Position in the room.
    pub at_m: DVec3,
    /// Rotation from the eye's axes (x right, y up, −z ahead) to the room's.
    pub room_from_eye: DQuat,
    /// Field of view.
    pub lens: Lens,
}

impl Stage {
    /// Returns the rotation from the room's directions to the world's.
    pub(crate) fn world_from_stage(&self) -> DMat3 {
        let (sin, cos) = self.heading_rad.sin_cos();
        DMat3::from_cols(DVec3::new(cos, -sin, 0.0), DVec3::Z, DVec3::new(-sin, -cos, 0.0))
    }

    /// Converts a position in the room to a position in the world.
    pub(crate) fn place_m(&self, at_m: DVec3) -> DVec3 {
        self.floor_m + self.world_from_stage() * at_m * self.scale
    }

    /// Turns the room clockwise about a point `at_m` of the room, which stays fixed in the world.
    pub(crate) fn turn_about(&mut self, at_m: DVec3, by_rad: f64) {
        let place_m = self.place_m(at_m);
        self.heading_rad = (self.heading_rad + by_rad).rem_euclid(std::f64::consts::TAU);
        self.floor_m += place_m - self.place_m(at_m);
    }

    /// Returns an eye's pose for the renderer.
    pub(crate) fn pose(&self, eye: &Eye) -> Pose {
        let world_from_eye = self.world_from_stage() * DMat3::from_quat(eye.room_from_eye);
        Pose {
            position_m: self.place_m(eye.at_m),
            forward: -world_from_eye.z_axis,
            right: world_from_eye.x_axis,
            up: world_from_eye.y_axis,
            fov_rad: eye.lens.up.atan() + eye.lens.down.atan(),
        }
    }

    /// Returns the rig of both eyes for the renderer, with its origin between the eyes. `before` is the rig of the
    /// previous frame.
    pub(crate) fn rig(&self, eyes: &[Eye; 2], sizes_px: [[u32; 2]; 2], before: Option<&Rig>) -> Rig {
        let views = [0, 1].map(|number| {
            let (pose, lens) = (self.pose(&eyes[number]), eyes[number].lens);
            let (was, lens_was) =
                before.map_or((pose, Some(lens)), |rig| (rig.eyes[number].pose, rig.eyes[number].lens));
            View { lens: Some(lens), previous_lens: lens_was, ..View::whole(was, pose, sizes_px[number]) }
        });
        Rig { origin_m: self.place_m(middle_m(eyes)), eyes: views.to_vec() }
    }
}

/// Returns the midpoint between the eyes, in the room.
pub(crate) fn middle_m(eyes: &[Eye; 2]) -> DVec3 {
    0.5 * (eyes[0].at_m + eyes[1].at_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: DVec3, b: DVec3) {
        assert!(a.distance(b) < 1e-9, "{a} is not {b}");
    }

    fn stage(heading_deg: f64, scale: f64) -> Stage {
        Stage { floor_m: DVec3::new(100.0, 200.0, 300.0), heading_rad: f64::to_radians(heading_deg), scale }
    }

    fn eye(room_from_eye: DQuat) -> Eye {
        let lens = Lens { left: 1.2, right: 0.9, up: 1.0, down: 1.1 };
        Eye { at_m: DVec3::new(0.5, 1.6, -2.0), room_from_eye, lens }
    }

    #[test]
    fn the_axes_of_the_room_are_those_of_the_world() {
        // Looking north, ahead is north and right is east.
        near(stage(0.0, 1.0).place_m(DVec3::new(0.5, 1.6, -2.0)), DVec3::new(100.5, 202.0, 301.6));
        // Looking east, right is south; at a giant's scale, a metre is a kilometre.
        near(stage(90.0, 1000.0).place_m(DVec3::new(0.5, 1.6, -2.0)), DVec3::new(2100.0, -300.0, 1900.0));
        for heading_deg in [0.0, 33.0, 170.0, 300.0] {
            assert!((stage(heading_deg, 1.0).world_from_stage().determinant() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_head_turns_and_rolls() {
        let north = stage(0.0, 1.0);
        let level = north.pose(&eye(DQuat::IDENTITY));
        near(level.forward, DVec3::Y);
        near(level.right, DVec3::X);
        near(level.up, DVec3::Z);
        // A quarter turn to the left is west.
        near(north.pose(&eye(DQuat::from_rotation_y(90_f64.to_radians()))).forward, -DVec3::X);
        // Looking up, the top of the head is behind.
        let up = north.pose(&eye(DQuat::from_rotation_x(90_f64.to_radians())));
        near(up.forward, DVec3::Z);
        near(up.up, -DVec3::Y);
        // A head that leans to the left has its right side up.
        let rolled = north.pose(&eye(DQuat::from_rotation_z(30_f64.to_radians())));
        near(rolled.forward, DVec3::Y);
        near(rolled.right, DVec3::new(0.75_f64.sqrt(), 0.0, 0.5));
        near(rolled.right.cross(rolled.forward), rolled.up);
    }

    #[test]
    fn a_turn_keeps_the_head_in_its_place() {
        let mut stage = stage(20.0, 1000.0);
        let (head_m, before) = (DVec3::new(0.7, 1.5, 0.4), stage);
        stage.turn_about(head_m, 0.5);
        near(stage.place_m(head_m), before.place_m(head_m));
        assert!((stage.heading_rad - before.heading_rad - 0.5).abs() < 1e-12);
        assert!(stage.place_m(DVec3::ZERO).distance(before.place_m(DVec3::ZERO)) > 300.0);
    }

    #[test]
    fn eyes_of_a_giant_are_far_apart() {
        let [mut left, mut right] = [eye(DQuat::IDENTITY); 2];
        left.at_m.x -= 0.0325;
        right.at_m.x += 0.0325;
        let rig = stage(0.0, 1000.0).rig(&[left, right], [[64, 48], [50, 40]], None);
        let [a, b] = [0, 1].map(|eye: usize| rig.eyes[eye].pose.position_m);
        near(b - a, DVec3::new(65.0, 0.0, 0.0));
        near(0.5 * (a + b), rig.origin_m);
        assert_eq!((rig.eyes[1].picture_px, rig.eyes[1].part.size_px), ([50, 40], [50, 40]));
        assert_eq!(rig.eyes[0].previous, rig.eyes[0].pose);
        let next = stage(0.0, 1000.0).rig(&[right, right], [[64, 48], [50, 40]], Some(&rig));
        assert_eq!(next.eyes[0].previous, rig.eyes[0].pose);
    }
}
