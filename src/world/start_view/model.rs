//! The start view of a model that is opened by itself: all of it, from in front, from its right and from above.

use glam::{DVec2, DVec3};

use super::super::OpenWorld;
use super::super::lone_model::{box_m, vertices_m};
use crate::scene::camera::Camera;

/// Direction of the view, clockwise from north: a model looks to the south, and is seen from the south-west.
const YAW_DEG: f64 = 28.0;
/// Vertical field of view, in degrees: longer than that of land, as for portraits.
const FOV_DEG: f64 = 35.0;
/// The largest parts of the picture's width and height that the model fills.
const FILLED: DVec2 = DVec2::new(0.78, 0.68);
/// Angle at which the camera looks down on a very high and on a very flat model, in degrees: so steep that the border
/// of the ground is above the picture.
const DOWN_DEG: [f64; 2] = [21.0, 32.0];
/// Height over width by which a model counts as high rather than flat, more gradually the larger.
const HIGH: f64 = 0.5;
/// Steps to which positions are rounded, in longest sides of the model.
const STEP: f64 = 1e-3;

/// Returns the camera for a picture of `aspect` (width over height); `None` if the world is not that of a model.
pub(super) fn camera(world: &OpenWorld, aspect: f64) -> Option<Camera> {
    let [low_m, high_m] = box_m(&world.scene, &world.surfaces)?;
    let size_m = high_m - low_m;
    let height = size_m.z / size_m.truncate().max_element().max(1e-9);
    let [least_deg, most_deg] = DOWN_DEG;
    let down_deg = least_deg + (most_deg - least_deg) * (-height / HIGH).exp();
    let mut camera = Camera {
        position_m: DVec3::ZERO,
        height_above_ground: false,
        yaw_deg: YAW_DEG,
        pitch_deg: -(10.0 * down_deg).round() / 10.0,
        fov_deg: FOV_DEG,
    };
    let placed = world.surfaces.meshes()?;
    let vertices = placed.standing.iter().flat_map(|standing| vertices_m(placed, standing));
    let up = (0.5 * FOV_DEG).to_radians().tan();
    let position_m = framing_m(&camera, FILLED * DVec2::new(up * aspect, up), vertices);
    let step_m = 10.0_f64.powf((STEP * size_m.max_element()).log10().floor()).clamp(1e-3, 1.0);
    camera.position_m = (position_m / step_m).round() * step_m;
    position_m.is_finite().then_some(camera)
}

/// Returns the position of a camera from which all places are within a lens, in its middle and as near as possible.
/// `lens` has the tangents of half its angles, across and up.
fn framing_m(camera: &Camera, lens: DVec2, places_m: impl Iterator<Item = DVec3>) -> DVec3 {
    let (right, up, forward) = (camera.right(), camera.up(), camera.forward());
    // A place q is within the lens of an eye c if |q.xy − c.xy| ≤ lens (q.z − c.z), with z along the view.
    let (mut above, mut below) = (DVec2::NEG_INFINITY, DVec2::NEG_INFINITY);
    for place_m in places_m {
        let (aside, along) = (DVec2::new(place_m.dot(right), place_m.dot(up)), place_m.dot(forward));
        above = above.max(aside - lens * along);
        below = below.max(-aside - lens * along);
    }
    let along = (-(above + below) / (2.0 * lens)).min_element();
    let aside = 0.5 * (above - below);
    aside.x * right + aside.y * up + along * forward
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_frames_all_places_and_no_more() {
        let camera = Camera {
            position_m: DVec3::ZERO,
            height_above_ground: false,
            yaw_deg: 40.0,
            pitch_deg: -25.0,
            fov_deg: 35.0,
        };
        let places_m = [[-3.0, 1.0, 0.0], [2.0, 5.0, 0.5], [0.0, 0.0, 9.0], [1.0, -2.0, 0.0]].map(DVec3::from_array);
        let seen = |eye_m: DVec3| {
            places_m.map(|place_m| {
                let way_m = place_m - eye_m;
                DVec2::new(way_m.dot(camera.right()), way_m.dot(camera.up())) / way_m.dot(camera.forward())
            })
        };
        for lens in [DVec2::new(0.3, 0.2), DVec2::new(0.1, 0.4)] {
            let eye_m = framing_m(&camera, lens, places_m.into_iter());
            let parts = seen(eye_m).map(|at| at / lens);
            let low = parts.iter().fold(DVec2::INFINITY, |low, part| low.min(*part));
            let high = parts.iter().fold(DVec2::NEG_INFINITY, |high, part| high.max(*part));
            // In the middle, and as large as possible in one direction.
            assert!(low.max_element() < 0.0 && (low + high).abs().min_element() < 1e-9, "{low} {high}");
            assert!((high.max_element() - 1.0).abs() < 1e-9, "{low} {high}");
            // Planted error: a step nearer.
            let nearer = seen(eye_m + 0.2 * camera.forward()).map(|at| at / lens);
            assert!(nearer.iter().any(|part| part.abs().max_element() > 1.001), "{nearer:?}");
        }
    }
}
