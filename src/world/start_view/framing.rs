//! Finds a camera that shows a place well: many cameras around it are judged by what they would see, and the best one
//! is taken.
//!
//! What a camera sees is computed on a raster of heights, along the columns of a picture: from the camera outward, a
//! sample of land is visible if the line to it is steeper than to all nearer samples. What is between is land, no-data,
//! the space beyond the edge of the data, or sky.

use glam::{DVec2, DVec3};

use super::raster::Raster;
use crate::scene::Light;
use crate::scene::camera::Camera;

/// Vertical field of view, in degrees.
pub(super) const FOV_DEG: f64 = 45.0;
/// Number of columns along which pictures are judged.
const COLUMNS: usize = 25;
/// Number of directions from which the place is looked at.
const DIRECTIONS: u32 = 36;
/// Distances, as factors of the most suitable one.
const DISTANCES: [f64; 7] = [1.0, 0.7, 1.4, 0.5, 2.0, 0.33, 2.8];
/// How high the camera is above the place, as angles in degrees.
const HEIGHTS_DEG: [f64; 12] = [-8.0, -5.0, -2.0, 1.0, 4.0, 8.0, 12.0, 17.0, 23.0, 31.0, 42.0, 56.0];
/// Where the place is in the picture: parts of its height, from the top.
const PLACES: [f64; 5] = [0.28, 0.33, 0.38, 0.44, 0.5];
/// Largest pitch, in degrees: the horizon is above the middle of the picture.
const LARGEST_PITCH_DEG: f64 = -1.0;
/// Largest part of the picture without land.
const MOST_SKY: f64 = 0.38;
/// Slope below the horizon down to which the space beyond the data looks like sky.
const LIKE_SKY: f64 = 0.02;
/// Slope below the horizon from which on it is seen to be none: it counts as no-data.
const UNLIKE_SKY: f64 = 0.11;
/// The smallest distance of the camera, in samples of the finest level.
const LEAST_SAMPLES: f64 = 24.0;
/// The most suitable distance is at most this part of the distance at which haze takes most of the contrast.
const CLEAR_PART: f64 = 0.8;

/// Heights in two resolutions: of the whole world, and around the place.
pub(super) struct Land<'a> {
    pub whole: &'a Raster,
    pub near: Option<&'a Raster>,
    /// Distance between samples of the finest level, in metres.
    pub spacing_m: f64,
    /// Light and haze.
    pub light: Light,
}

/// What is to be shown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subject {
    /// Position of the place.
    pub place_m: DVec3,
    /// Radius of the mountain or of the land around the place, in metres.
    pub radius_m: f64,
    /// How far the land falls over that radius, in metres; 0 if it does not.
    pub drop_m: f64,
    /// Direction and distance from which it is looked at, if they are given: the azimuth of the camera seen from the
    /// place, in degrees, and metres.
    pub from: Option<[f64; 2]>,
}

/// What a camera sees: parts of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// Without land: sky, and the next two.
    pub empty: f64,
    /// Space beyond the edge of the data, below the horizon.
    pub beyond: f64,
    /// No-data in front of land, or under the camera.
    pub no_data: f64,
    /// Land that is much nearer than the place.
    pub near: f64,
    /// Number of outlines of land before land, in the mean column.
    pub outlines: f64,
}

/// A part of a column of the picture, between two slopes as seen from the camera.
struct Span {
    slopes: [f64; 2],
    is_land: bool,
    /// Distance of the land, in metres.
    away_m: f64,
}

impl Land<'_> {
    /// Returns the height of the land at a place; NaN without data.
    pub(super) fn height_m(&self, place_m: DVec2) -> f64 {
        match self.near {
            Some(near) if near.contains(place_m) => near.height_m(place_m),
            _ => self.whole.height_m(place_m),
        }
    }

    fn cell_m(&self, place_m: DVec2) -> f64 {
        self.near.filter(|near| near.contains(place_m)).unwrap_or(self.whole).cell_m
    }

    /// Returns the highest land at a place and around it; NaN without data.
    fn highest_m(&self, place_m: DVec2) -> f64 {
        let cell_m = self.cell_m(place_m);
        let around = [[0.0, 0.0], [1.5, 0.0], [-1.5, 0.0], [0.0, 1.5], [0.0, -1.5]];
        let heights = around.map(|step| self.height_m(place_m + cell_m * DVec2::from_array(step)));
        if heights[0].is_nan() { f64::NAN } else { heights.into_iter().fold(heights[0], f64::max) }
    }

    /// Returns the spans of a column of the picture from the ground below the camera upward, and the slope of the last
    /// land.
    fn column(&self, eye_m: DVec3, azimuth_rad: f64, scale_m: f64, spans: &mut Vec<Span>) -> f64 {
        spans.clear();
        let (sin, cos) = azimuth_rad.sin_cos();
        let (way, start_m) = (DVec2::new(sin, cos), eye_m.truncate());
        let [low_m, high_m] = self.whole.corners_m();
        let reach_m = (high_m - low_m).length() + (start_m - start_m.clamp(low_m, high_m)).length();
        let mut away_m = (0.02 * scale_m).max(0.5 * self.cell_m(start_m));
        let mut steepest = -1e9;
        let mut was_hidden = false;
        let mut was_void = self.height_m(start_m).is_nan();
        while away_m < reach_m {
            let at_m = start_m + away_m * way;
            let height_m = self.height_m(at_m);
            if height_m.is_nan() {
                was_void = true;
            } else {
                let slope = (height_m - eye_m.z) / away_m;
                if slope > steepest {
                    // Between land and the land behind a hole, one looks below the land.
                    spans.push(Span { slopes: [steepest, slope], is_land: !was_void, away_m });
                    if was_hidden {
                        // Marks an outline: nothing of the land between was seen.
                        spans.push(Span { slopes: [slope, slope], is_land: true, away_m });
                    }
                    (steepest, was_hidden) = (slope, false);
                } else {
                    was_hidden = true;
                }
                was_void = false;
            }
            away_m += (0.8 * self.cell_m(at_m)).max(0.025 * away_m);
        }
        steepest
    }

    /// Returns whether a place is visible from an eye, and whether it is also higher than all that is behind it.
    fn sees(&self, eye_m: DVec3, place_m: DVec3) -> (bool, bool) {
        let way_m = place_m.truncate() - eye_m.truncate();
        let distance_m = way_m.length();
        let cell_m = self.cell_m(place_m.truncate());
        let slope = (place_m.z - eye_m.z) / distance_m;
        let steps = (distance_m / (0.8 * cell_m)).clamp(8.0, 2000.0) as u32;
        let slope_at = |part: f64| (self.height_m(eye_m.truncate() + part * way_m) - eye_m.z) / (part * distance_m);
        let is_seen = (1..steps).all(|step| {
            let part = f64::from(step) / f64::from(steps);
            let found = slope_at(part);
            // The summit's own cells hide nothing.
            found.is_nan() || (1.0 - part) * distance_m < 2.5 * cell_m || found <= slope
        });
        let behind_m = 1.5 * cell_m;
        let mut away_m = distance_m + behind_m;
        let mut is_skyline = is_seen;
        while is_skyline && self.whole.contains(eye_m.truncate() + away_m / distance_m * way_m) {
            let found = slope_at(away_m / distance_m);
            is_skyline = found.is_nan() || found <= slope;
            away_m += (0.8 * cell_m).max(0.03 * (away_m - distance_m));
        }
        (is_seen, is_skyline)
    }

    /// Returns a camera that shows the subject, for a picture of `aspect` (width over height).
    pub(super) fn framed(&self, subject: &Subject, aspect: f64) -> Camera {
        let place_m = subject.place_m;
        let to_sun = self.light.to_sun;
        let sun_deg = to_sun.x.atan2(to_sun.y).to_degrees();
        let [low_m, high_m] = self.whole.corners_m();
        let longest_m = 1.5 * (high_m - low_m).length();
        let least_m = (LEAST_SAMPLES * self.spacing_m).min(0.5 * longest_m);
        // What is far away is lost in haze.
        let clear_m = CLEAR_PART * self.light.haze_m;
        let wanted_m = (2.2 * subject.radius_m).min(clear_m).clamp(least_m, longest_m.max(least_m));
        // A gentle hill is seen from higher than a mountain.
        let steepness = (subject.drop_m / wanted_m).clamp(0.015, 0.25);
        let gentle = ((0.25_f64).ln() - steepness.ln()) / ((0.25_f64).ln() - (0.015_f64).ln());
        let wanted_deg = -1.0 + 18.0 * gentle * gentle;
        let (azimuths, distances_m) = match subject.from {
            Some([azimuth_deg, distance_m]) => (vec![azimuth_deg + 180.0], vec![distance_m]),
            None => (
                (0..DIRECTIONS).map(|turn| sun_deg + 360.0 * f64::from(turn) / f64::from(DIRECTIONS)).collect(),
                DISTANCES.map(|factor| (factor * wanted_m).max(least_m)).to_vec(),
            ),
        };
        let mut best: Option<(f64, Camera)> = None;
        for yaw_deg in azimuths {
            // 90° is light from the side, 0° from the front and 180° from behind.
            let side_deg = ((sun_deg - yaw_deg + 180.0).rem_euclid(360.0) - 180.0).abs();
            let light = ((side_deg - 78.0) / 30.0).powi(2) + if (45.0..=115.0).contains(&side_deg) { 0.0 } else { 3.0 };
            for &distance_m in &distances_m {
                let (sin, cos) = yaw_deg.to_radians().sin_cos();
                let eye_m = place_m.truncate() - distance_m * DVec2::new(sin, cos);
                let ground_m = self.highest_m(eye_m);
                let off_data = if ground_m.is_nan() { 12.0 } else { 0.0 };
                let mut last_m = f64::NAN;
                for height_deg in HEIGHTS_DEG {
                    let clear_m = (0.03 * distance_m).max(2.0 * self.spacing_m.min(50.0));
                    let z_m = (place_m.z + distance_m * height_deg.to_radians().tan()).max(ground_m + clear_m);
                    if (z_m - last_m).abs() < 1e-6 * distance_m {
                        continue;
                    }
                    last_m = z_m;
                    let eye_m = eye_m.extend(z_m);
                    let up_deg = ((z_m - place_m.z) / distance_m).atan().to_degrees();
                    let off_height = ((up_deg - wanted_deg) / 12.0).abs();
                    let haze_m = self.light.for_eye_above((z_m - place_m.z).max(0.0)).haze_m;
                    let mut cost = 1.2 * (distance_m / wanted_m).ln().powi(2)
                        + 0.6 * off_height.powi(2).min(1.5 * off_height)
                        + 3.0 * (distance_m / haze_m - CLEAR_PART).clamp(0.0, 3.0)
                        + 0.5 * light
                        + off_data;
                    if best.as_ref().is_some_and(|(known, _)| cost - 1.0 > *known) {
                        continue;
                    }
                    let (is_seen, is_skyline) = self.sees(eye_m, place_m);
                    cost += if is_seen { 0.0 } else { 12.0 };
                    // A mountain is recognised by its outline before the sky; on gentle land there is hardly one.
                    cost += if is_skyline { 0.0 } else { 2.0 * (1.0 - gentle * gentle) };
                    for (pitch_deg, seen, place) in self.seen(eye_m, yaw_deg, up_deg, distance_m, aspect) {
                        let cost = cost + seen.cost() + 8.0 * (place - 0.4_f64).powi(2);
                        if best.as_ref().is_none_or(|(known, _)| cost < *known) {
                            let camera = Camera {
                                position_m: eye_m,
                                height_above_ground: false,
                                yaw_deg: yaw_deg.rem_euclid(360.0),
                                pitch_deg,
                                fov_deg: FOV_DEG,
                            };
                            best = Some((cost, camera));
                        }
                    }
                }
            }
        }
        match best {
            Some((_, camera)) => camera,
            // Not reached: the first camera is always better than none.
            None => Camera {
                position_m: place_m + DVec3::Z * wanted_m,
                height_above_ground: false,
                yaw_deg: 0.0,
                pitch_deg: -89.0,
                fov_deg: FOV_DEG,
            },
        }
    }

    /// Returns the pitches by which a place `down_deg` below the eye is in the upper half of the picture, each with what
    /// the camera sees, and with the part of the picture above the place.
    fn seen(&self, eye_m: DVec3, yaw_deg: f64, down_deg: f64, distance_m: f64, aspect: f64) -> Vec<(f64, Seen, f64)> {
        let half = (0.5 * FOV_DEG).to_radians().tan();
        let pitch_deg = |place: f64| {
            let pitch_deg = -down_deg - ((1.0 - 2.0 * place) * half).atan().to_degrees();
            pitch_deg.clamp(-80.0, LARGEST_PITCH_DEG)
        };
        let mut found: Vec<(f64, Seen, f64)> = Vec::new();
        for place in PLACES {
            let pitch_deg = pitch_deg(place);
            // What the limit of the pitch has moved is elsewhere in the picture.
            let place = 0.5 - 0.5 * (-down_deg - pitch_deg).to_radians().tan() / half;
            if (0.27..=0.55).contains(&place) && found.iter().all(|(known, ..)| *known != pitch_deg) {
                found.push((pitch_deg, Seen::default(), place));
            }
        }
        let Some((first_deg, ..)) = found.first() else { return found };
        let level = first_deg.to_radians().cos().max(0.2);
        let mut spans = Vec::new();
        for column in 0..COLUMNS {
            let across = (2.0 * (column as f64 + 0.5) / COLUMNS as f64 - 1.0) * half * aspect;
            let beside_rad = (across / level).atan();
            let last = self.column(eye_m, yaw_deg.to_radians() + beside_rad, distance_m, &mut spans);
            for (pitch_deg, seen, _) in &mut found {
                seen.add(&spans, last, Column { pitch_rad: pitch_deg.to_radians(), beside_rad, half }, distance_m);
            }
        }
        found
    }
}

/// A column of a picture.
#[derive(Clone, Copy)]
struct Column {
    pitch_rad: f64,
    /// Angle beside the middle of the picture.
    beside_rad: f64,
    /// Tangent of half of the field of view.
    half: f64,
}

impl Column {
    /// Returns where a line of a slope is seen: 0 at the bottom of the picture, 1 at the top.
    fn part(self, slope: f64) -> f64 {
        let (sin, cos) = self.pitch_rad.sin_cos();
        let ahead = self.beside_rad.cos() * cos + slope * sin;
        let up = -self.beside_rad.cos() * sin + slope * cos;
        if ahead <= 1e-9 {
            return if up > 0.0 { 1.0 } else { 0.0 };
        }
        (0.5 + 0.5 * up / (ahead * self.half)).clamp(0.0, 1.0)
    }
}

impl Seen {
    /// Adds one of the columns.
    fn add(&mut self, spans: &[Span], last: f64, column: Column, distance_m: f64) {
        let weight = 1.0 / COLUMNS as f64;
        let part = |[low, high]: [f64; 2]| weight * (column.part(high) - column.part(low)).max(0.0);
        for span in spans {
            let share = part(span.slopes);
            if span.slopes[0] == span.slopes[1] {
                let is_in_picture = (0.01..0.99).contains(&column.part(span.slopes[0]));
                self.outlines += if is_in_picture { weight } else { 0.0 };
            } else if !span.is_land {
                self.no_data += share;
                self.empty += share;
            } else if span.away_m < 0.2 * distance_m {
                self.near += share;
            }
        }
        // Rays above the last land end in the sky; those that point down are seen to pass the edge of the data.
        self.empty += weight * (1.0 - column.part(last));
        self.beyond += part([last, -LIKE_SKY]);
        self.no_data += part([last, -UNLIKE_SKY]);
    }

    /// Returns how bad a picture is.
    fn cost(&self) -> f64 {
        60.0 * self.no_data
            + 6.0 * self.beyond
            + 40.0 * (self.beyond - 0.08).max(0.0)
            + 400.0 * (self.empty - MOST_SKY).max(0.0)
            + 2.0 * (0.1 - self.empty).max(0.0)
            + 3.0 * (self.near - 0.3).max(0.0)
            - 0.25 * self.outlines.min(3.0)
    }
}
