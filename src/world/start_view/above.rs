//! Views from above, through lenses as long as needed: of land that no usual camera shows well.
//!
//! A tower (a mountain whose samples are taken to be closer than they are, for example) has more sky than land around
//! its summit from any place next to it, and a camera just above it looks past the edge of its small land. From high
//! above, its height is foreshortened until it looks like a mountain, and a long lens keeps the edge out of the
//! picture.

use glam::DVec3;

use super::framing::{Field, Judged, LIKE_SKY, Seen, Subject, UNLIKE_SKY, cost_of_light};
use super::ground::Land;
use crate::scene::camera::Camera;

/// Angles between the sun and the direction of view, in degrees; both sides are tried.
const LIGHTS_DEG: [f64; 4] = [55.0, 70.0, 85.0, 105.0];
/// How high the camera is above the place, as angles in degrees.
const HEIGHTS_DEG: [f64; 9] = [24.0, 36.0, 48.0, 58.0, 67.0, 74.0, 80.0, 84.0, 87.0];
/// Vertical fields of view, in degrees.
const FOVS_DEG: [f64; 7] = [45.0, 30.0, 19.0, 11.0, 6.0, 3.0, 1.5];
/// Widths of the picture at the place, as parts of the size of the land.
const WIDTHS: [f64; 6] = [0.8, 0.5, 0.32, 0.2, 0.12, 0.07];
/// Position of the place in the picture: parts of its height, from the top. All cameras are judged with the first one.
const PLACES: [f64; 3] = [0.42, 0.32, 0.52];
/// Number of the best cameras that are judged again, in all places and with more rays.
const FINALISTS: usize = 24;
/// Rays by which all cameras are judged, and the best ones again.
const FIRST_RAYS: Rays = Rays { columns: 12, rows: 8, step: 3.0 };
const LAST_RAYS: Rays = Rays { columns: 32, rows: 20, step: 0.9 };

/// The rays of a picture.
#[derive(Clone, Copy)]
struct Rays {
    columns: usize,
    rows: usize,
    /// Length of a ray's step, in cells on the map.
    step: f64,
}

impl Land<'_> {
    /// Returns the camera that shows the subject best from above; `None` if all of them are below the land.
    pub(super) fn framed_from_above(&self, subject: &Subject, aspect: f64) -> Option<Judged> {
        let to_sun = self.light.to_sun;
        let sun_deg = to_sun.x.atan2(to_sun.y).to_degrees();
        let mut judged = Vec::new();
        for light_deg in LIGHTS_DEG.into_iter().flat_map(|light_deg| [light_deg, -light_deg]) {
            for up_deg in HEIGHTS_DEG {
                for (fov_deg, width) in FOVS_DEG.into_iter().flat_map(|fov| WIDTHS.map(|width| (fov, width))) {
                    let half = (0.5 * fov_deg).to_radians().tan();
                    let away_m = width * subject.size_m / (2.0 * half * aspect);
                    let yaw_deg = sun_deg - light_deg;
                    let (sin, cos) = yaw_deg.to_radians().sin_cos();
                    let (sin_up, cos_up) = up_deg.to_radians().sin_cos();
                    let eye_m = subject.place_m + away_m * DVec3::new(-sin * cos_up, -cos * cos_up, sin_up);
                    let ground_m = self.highest_m(eye_m.truncate());
                    if eye_m.z < ground_m + (0.05 * away_m).max(2.0 * self.spacing_m) {
                        continue;
                    }
                    let camera = Camera {
                        position_m: eye_m,
                        height_above_ground: false,
                        yaw_deg: yaw_deg.rem_euclid(360.0),
                        pitch_deg: pitch_deg(up_deg, fov_deg, PLACES[0]),
                        fov_deg,
                    };
                    // A usual lens, not from too high, and not too near.
                    let cost = 0.5 * cost_of_light(light_deg)
                        + 2.0 * (up_deg / 90.0).powi(2)
                        + 0.25 * (45.0 / fov_deg).ln()
                        + 0.6 * (width / 0.4).ln().powi(2);
                    judged.push((self.judged(&camera, cost, aspect, FIRST_RAYS), cost, up_deg));
                }
            }
        }
        judged.sort_by(|(a, ..), (b, ..)| a.cost.total_cmp(&b.cost));
        judged.truncate(FINALISTS);
        let finalists = judged.into_iter().flat_map(|(Judged { camera, .. }, cost, up_deg)| {
            let (is_seen, _) = self.sees(camera.position_m, subject.place_m, subject.top_m);
            let cost = cost + if is_seen { 0.0 } else { 12.0 };
            PLACES.map(|place| {
                let camera = Camera { pitch_deg: pitch_deg(up_deg, camera.fov_deg, place), ..camera };
                self.judged(&camera, cost + 8.0 * (place - 0.4).powi(2), aspect, LAST_RAYS)
            })
        });
        finalists.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Judges a camera by the rays of its picture.
    fn judged(&self, camera: &Camera, cost: f64, aspect: f64, rays: Rays) -> Judged {
        let Rays { columns, rows, step } = rays;
        let (sin_yaw, cos_yaw) = camera.yaw_deg.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = camera.pitch_deg.to_radians().sin_cos();
        let forward = DVec3::new(sin_yaw * cos_pitch, cos_yaw * cos_pitch, sin_pitch);
        let right = DVec3::new(cos_yaw, -sin_yaw, 0.0);
        let up = right.cross(forward);
        let half = (0.5 * camera.fov_deg).to_radians().tan();
        let haze_m = self.light.for_eye_above((camera.position_m.z - self.top_m).max(0.0)).haze_m;
        let share = 1.0 / (columns * rows) as f64;
        let mut seen = Seen::default();
        let (mut fields, mut before): (Vec<Field>, Vec<Field>) = (Vec::new(), Vec::new());
        for (column, row) in (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row))) {
            let across = (2.0 * (column as f64 + 0.5) / columns as f64 - 1.0) * half * aspect;
            let upward = (1.0 - 2.0 * (row as f64 + 0.5) / rows as f64) * half;
            let way = (forward + across * right + upward * up).normalize();
            match self.met_m(camera.position_m, way, step) {
                Some(away_m) => {
                    let at_m = (camera.position_m + away_m * way).truncate();
                    fields.push([1.0, self.tone(at_m), (-away_m / haze_m).exp()]);
                }
                None => {
                    let slope = way.z / way.truncate().length().max(1e-9);
                    fields.push([0.0; 3]);
                    seen.empty += share;
                    seen.beyond += if slope < -LIKE_SKY { share } else { 0.0 };
                    seen.no_data += if slope < -UNLIKE_SKY { share } else { 0.0 };
                }
            }
            if fields.len() == rows {
                seen.add_detail(&fields, (!before.is_empty()).then_some(&before[..]), columns);
                before = std::mem::take(&mut fields);
            }
        }
        Judged { camera: *camera, cost: cost + seen.cost(self.contrast), seen }
    }

    /// Returns how far a ray goes until it meets the land, in metres; `None` if it passes it.
    fn met_m(&self, eye_m: DVec3, way: DVec3, step: f64) -> Option<f64> {
        let [low_m, high_m] = self.whole.raster.corners_m();
        let (low_m, high_m) = (low_m.extend(self.bottom_m), high_m.extend(self.top_m));
        // Where the ray is in the box around the land.
        let (mut first_m, mut last_m) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let [a, b] = [low_m, high_m].map(|corner| (corner[axis] - eye_m[axis]) / way[axis]);
            if a.is_nan() || b.is_nan() {
                continue;
            }
            (first_m, last_m) = (first_m.max(a.min(b)), last_m.min(a.max(b)));
        }
        let step_m =
            (step * self.whole.raster.cell_m / way.truncate().length().max(1e-9)).min(0.05 * (last_m - first_m));
        let mut away_m = first_m + 1e-3 * step_m;
        // A ray that is below the land when it leaves a hole, or when it enters the data from outside, has not met the
        // land: it looks under it.
        let mut was_void = first_m > 0.0;
        while away_m < last_m {
            let at_m: DVec3 = eye_m + away_m * way;
            let height_m = self.whole.raster.height_m(at_m.truncate());
            if at_m.z <= height_m {
                return (!was_void).then_some(away_m);
            }
            was_void = height_m.is_nan();
            away_m += step_m;
        }
        // The lowest land is the bottom of the box.
        let at_m = eye_m + last_m * way;
        let is_below = at_m.z <= self.whole.raster.height_m(at_m.truncate() - 1e-6 * way.truncate());
        (first_m < last_m && is_below && !was_void).then_some(last_m)
    }
}

/// Returns the pitch of a camera `up_deg` above a place that is to be at a part of the picture's height, in degrees.
fn pitch_deg(up_deg: f64, fov_deg: f64, place: f64) -> f64 {
    let half = (0.5 * fov_deg).to_radians().tan();
    (-up_deg - ((1.0 - 2.0 * place) * half).atan().to_degrees()).max(-89.0)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::raster::Raster;
    use super::*;
    use crate::scene::Scene;

    fn hills_m(x: f64, y: f64) -> f64 {
        500.0 + 400.0 * (x / 170.0).sin() * (y / 230.0).cos()
    }

    /// Returns the part of a picture of 32 × 20 rays that meets no land, by small steps over the land's own function.
    fn empty(camera: &Camera, aspect: f64, land_m: impl Fn(DVec2) -> f64) -> f64 {
        let (sin_yaw, cos_yaw) = camera.yaw_deg.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = camera.pitch_deg.to_radians().sin_cos();
        let forward = DVec3::new(sin_yaw * cos_pitch, cos_yaw * cos_pitch, sin_pitch);
        let right = DVec3::new(cos_yaw, -sin_yaw, 0.0);
        let up = DVec3::new(-sin_yaw * sin_pitch, -cos_yaw * sin_pitch, cos_pitch);
        let half = (0.5 * camera.fov_deg).to_radians().tan();
        let meets = |ray: u32| {
            let across = (f64::from(ray % 32) + 0.5) / 16.0 - 1.0;
            let upward = 1.0 - (f64::from(ray / 32) + 0.5) / 10.0;
            let way = forward + half * (aspect * across * right + upward * up);
            // In steps of about a metre, land is met by a step that begins above land and does not end above it.
            let mut was_above = false;
            for step in 0..4000 {
                let at = camera.position_m + f64::from(step) * way;
                let above_m = at.z - land_m(at.truncate());
                if above_m <= 0.0 {
                    return was_above;
                }
                was_above = above_m > 0.0;
            }
            false
        };
        f64::from((0..640).filter(|ray| !meets(*ray)).count() as u32) / 640.0
    }

    /// A ray that goes through a hole is below the land behind it, and does not see that.
    #[test]
    fn holes_and_the_space_beside_the_data_are_no_land() {
        let land_m = |at: DVec2| match at.abs().max_element() {
            away if !(600.0..=1005.0).contains(&away) => f64::NAN,
            _ => hills_m(at.x, at.y),
        };
        let raster = Raster::of(201, 10.0, |x, y| land_m(DVec2::new(x, y)));
        let land = Land::new(&raster, None, 10.0, Scene::default().light([2000.0; 2]), DVec2::ZERO, 2000.0);
        for (name, x, y, z, yaw_deg, pitch_deg) in [
            ("into the hole", 0.0, -900.0, 1100.0, 0.0, -30.0),
            ("from outside", 2000.0, 2000.0, 1300.0, 225.0, -20.0),
            ("along the rim", -800.0, -900.0, 1000.0, 20.0, -25.0),
        ] {
            let position_m = DVec3::new(x, y, z);
            let camera = Camera { position_m, height_above_ground: false, yaw_deg, pitch_deg, fov_deg: 45.0 };
            let judged = land.judged(&camera, 0.0, 1.6, LAST_RAYS);
            let expected = empty(&camera, 1.6, land_m);
            assert!(expected > 0.15, "{name}: {expected}");
            assert!((judged.seen.empty - expected).abs() < 0.06, "{name}: {:?}, and is {expected}", judged.seen);
            assert!(judged.seen.detail.is_finite() && judged.cost.is_finite());
        }
    }
}
