//! The place under the cursor: the surface that the last picture shows at a pixel, read back from the GPU without
//! waiting.
//!
//! Why: `docs/decisions/place-under-the-cursor.md`.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};

use crate::gpu::Gpu;
use crate::gpu::async_readback::AsyncReadback;
use crate::gpu::target::Target;
use crate::scene::view::View;
use crate::tiles::earth_curvature::EarthCurvature;

/// The place that the picture shows at a position of the cursor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaceUnderCursor {
    /// Position of the cursor in the window, in pixels.
    pub cursor_px: DVec2,
    /// Number of the picture.
    pub picture: u64,
    /// Place on the surface in the world's frame, in metres; `None` in the sky.
    pub place_m: Option<DVec3>,
    /// Distance from the eye, in metres; infinite in the sky.
    pub distance_m: f64,
}

/// A request whose texel has not arrived yet.
struct PendingPlace {
    cursor_px: DVec2,
    picture: u64,
    /// The eye's view, without jitter.
    view: View,
    pixel: [u32; 2],
    earth: EarthCurvature,
}

/// Requests places and returns them when the GPU has answered.
pub(super) struct PlacePicker {
    readback: AsyncReadback,
    pending: VecDeque<PendingPlace>,
}

/// A request for the place at a position of the cursor.
pub(super) struct PlaceRequest<'a> {
    /// Distances of the picture of the eye.
    pub distance: &'a Target,
    /// The view of the eye.
    pub view: View,
    /// The earth as the eye sees it.
    pub earth: EarthCurvature,
    /// Position of the cursor in the window, in pixels.
    pub cursor_px: DVec2,
    /// Position of the cursor in the picture of the eye, 0 to 1 in each direction.
    pub part: DVec2,
    /// Number of the picture.
    pub picture: u64,
}

impl PlacePicker {
    /// Creates a picker without requests.
    pub(super) fn new() -> Self {
        Self { readback: AsyncReadback::new(4), pending: VecDeque::new() }
    }

    /// Requests the place that the last picture shows. Returns `false` if too many requests are pending.
    pub(super) fn request(&mut self, gpu: &Gpu, request: &PlaceRequest<'_>) -> bool {
        let PlaceRequest { distance, view, earth, cursor_px, part, picture } = *request;
        let size = distance.size_px();
        let pixel = [0, 1].map(|axis| ((part[axis] * f64::from(size[axis])) as u32).min(size[axis].saturating_sub(1)));
        let is_sent = self.readback.request_texel(gpu, distance, pixel);
        if is_sent {
            self.pending.push_back(PendingPlace { cursor_px, picture, view, pixel, earth });
        }
        is_sent
    }

    /// Returns whether requests are pending.
    pub(super) fn is_waiting(&self) -> bool {
        self.readback.is_waiting()
    }

    /// Takes the places that have arrived, and returns the newest.
    pub(super) fn take(&mut self) -> Option<PlaceUnderCursor> {
        let mut newest = None;
        while let Some(bytes) = self.readback.take() {
            let question = self.pending.pop_front()?;
            let along_m = bytes.first_chunk().map_or(0.0, |bytes| f32::from_le_bytes(*bytes));
            newest = Some(question.answer(f64::from(along_m)));
        }
        if !self.readback.is_waiting() {
            // The device dropped the rest.
            self.pending.clear();
        }
        newest
    }
}

impl PendingPlace {
    /// Returns the place, from the distance along the view axis; 0 is the sky.
    fn answer(&self, along_m: f64) -> PlaceUnderCursor {
        let Self { cursor_px, picture, view, pixel, earth } = self;
        let ray = view.ray(DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5));
        let is_surface = along_m > 0.0 && along_m.is_finite();
        let seen_m = ray * along_m;
        PlaceUnderCursor {
            cursor_px: *cursor_px,
            picture: *picture,
            place_m: is_surface.then(|| view.pose.position_m + earth.unbend(seen_m)),
            distance_m: if is_surface { seen_m.length() } else { f64::INFINITY },
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::scene::camera::Camera;
    use crate::window::fly_camera::FlyCamera;

    fn question(part: DVec2, inverse_radius: f64) -> PendingPlace {
        let start = Camera {
            position_m: DVec3::new(1000.0, -2000.0, 1500.0),
            height_above_ground: false,
            yaw_deg: 30.0,
            pitch_deg: -25.0,
            fov_deg: 50.0,
        };
        let pose = FlyCamera::new(&start, |_| 0.0, [30_000.0, 30_000.0]).pose();
        let view = View::whole(pose, pose, [640, 360]);
        let pixel = [(part.x * 640.0) as u32, (part.y * 360.0) as u32];
        let earth = EarthCurvature { inverse_radius, camera_z_m: 1500.0, lowest_m: 0.0 };
        PendingPlace { cursor_px: part, picture: 1, view, pixel, earth }
    }

    #[test]
    fn a_distance_becomes_a_place() {
        let question = question(DVec2::splat(0.5), 0.0);
        let wanted_m = DVec3::new(1500.0, 3000.0, 200.0);
        // The pixel that sees the place, and its distance along the axis.
        let way_m = wanted_m - question.view.pose.position_m;
        let px = question.view.place_px(way_m).unwrap();
        let question = PendingPlace { pixel: [px.x as u32, px.y as u32], ..question };
        let answer = question.answer(way_m.dot(question.view.pose.forward));
        let off_m = answer.place_m.unwrap().distance(wanted_m);
        let pixel_m = way_m.length() / question.view.focal_px();
        assert!(off_m < pixel_m, "{off_m} m, a pixel is {pixel_m} m");
        assert!((answer.distance_m / way_m.length() - 1.0).abs() < 1e-3);
        // Planted error: the distance as if it were along the ray.
        let wrong = question.answer(way_m.length());
        assert!(wrong.place_m.unwrap().distance(wanted_m) > 1.5 * pixel_m, "at {px}");
    }

    #[test]
    fn the_earth_is_unbent_and_the_sky_is_no_place() {
        let [flat, curved] = [0.0, 1.0 / 6_371_008.8].map(|k| question(DVec2::splat(0.5), k).answer(40_000.0));
        let dropped_m = curved.place_m.unwrap().z - flat.place_m.unwrap().z;
        // d² / 2R over 36 km.
        assert!((90.0..130.0).contains(&dropped_m), "{dropped_m}");
        let sky = question(DVec2::splat(0.5), 0.0).answer(0.0);
        assert!(sky.place_m.is_none() && sky.distance_m == f64::INFINITY);
    }
}
