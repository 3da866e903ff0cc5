//! Finds a camera that shows a place well: many cameras around it are judged by what they would see, and the best one
//! is taken.
//!
//! What a camera sees is computed on a raster of heights, along the columns of a picture: from the camera outward, a
//! sample of land is visible if the line to it is steeper than to all nearer samples. What is between is land, no-data,
//! the space beyond the edge of the data, or sky.

use glam::{DVec2, DVec3};

use super::ground::{Land, Span};
use super::summit::form_of_mountain;
use crate::scene::camera::Camera;

/// Vertical field of view, in degrees.
pub(super) const FOV_DEG: f64 = 45.0;
/// Number of columns along which pictures are judged, and of rows of fields whose detail is compared.
const COLUMNS: usize = 25;
const ROWS: usize = 16;
/// Number of directions from which the place is looked at.
const DIRECTIONS: u32 = 36;
/// Distances, as factors of the most suitable one. The largest are for a summit among holes: the visible rest of its
/// mountain is small, and only from far away do the holes take little of the picture.
const DISTANCES: [f64; 9] = [1.0, 0.7, 1.4, 0.5, 2.0, 0.33, 2.8, 4.0, 5.6];
/// How high the camera is above the place, as angles in degrees.
const HEIGHTS_DEG: [f64; 12] = [-8.0, -5.0, -2.0, 1.0, 4.0, 8.0, 12.0, 17.0, 23.0, 31.0, 42.0, 56.0];
/// Position of the place in the picture: parts of its height, from the top.
const PLACES: [f64; 5] = [0.28, 0.33, 0.38, 0.44, 0.5];
/// Largest pitch, in degrees: the horizon is above the middle of the picture.
const LARGEST_PITCH_DEG: f64 = -1.0;
/// Largest part of the picture without land.
pub(super) const MOST_SKY: f64 = 0.38;
/// Slope below the horizon down to which the space beyond the data looks like sky.
pub(super) const LIKE_SKY: f64 = 0.02;
/// Slope below the horizon from which on the space beyond the data is recognisably not sky: it counts as no-data.
pub(super) const UNLIKE_SKY: f64 = 0.11;
/// The smallest distance of the camera, in samples of the finest level.
const LEAST_SAMPLES: f64 = 24.0;
/// The most suitable distance is at most this part of the distance at which haze takes most of the contrast.
const CLEAR_PART: f64 = 0.8;

/// Radius of the land around a place that is not a mountain, as a part of the size of the data.
const LEVEL_PART: f64 = 0.1;
/// Cost of no-data and of too much sky from which on the land is also looked at from above.
const MOST_BLANK: f64 = 1.5;
/// Weight of the detail of the land in view, and the detail that suffices: a factor of the contrast of the land.
const DETAIL_WEIGHT: f64 = 6.0;
const ENOUGH_DETAIL: f64 = 0.5;
/// Largest amount by which the best picture reduces the cost of a camera.
const BEST_PICTURE: f64 = DETAIL_WEIGHT * ENOUGH_DETAIL + 1.0;

/// The mountain or land that a start view shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subject {
    /// Position of the place.
    pub place_m: DVec3,
    /// Radius of the mountain or of the land around the place, in metres.
    pub radius_m: f64,
    /// Height by which the land falls over that radius, in metres; 0 if it does not.
    pub drop_m: f64,
    /// Radius of the top around the place, in metres.
    pub top_m: f64,
    /// The larger side of the land, in metres.
    pub size_m: f64,
    /// Direction and distance from which it is looked at, if they are given: the azimuth of the camera seen from the
    /// place, in degrees, and metres.
    pub from: Option<[f64; 2]>,
}

/// Parts of the picture of a camera, 0 to 1.
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
    /// Mean difference of the tones between neighbouring fields of the picture, in haze; 0 where there is no land.
    pub detail: f64,
}

/// A field of a picture: how much of it is land, and sums over that land of its tone and of its contrast in haze.
pub(super) type Field = [f64; 3];

/// A camera, and how bad the picture is that it sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judged {
    pub camera: Camera,
    pub cost: f64,
    pub seen: Seen,
}

impl Land<'_> {
    /// Returns what is to be shown at a place: the mountain there. `top_m` is the radius of its top.
    pub(super) fn subject(&self, place_m: DVec3, top_m: f64, size_m: f64, from: Option<[f64; 2]>) -> Subject {
        let cell_m = self.cell_m(place_m.truncate());
        // The foot of a mountain is below its top.
        let radii_m = [(2.0 * cell_m).max(1.5 * top_m).min(0.25 * size_m), 0.5 * size_m];
        let form = form_of_mountain(|at| self.height_m(at), place_m.truncate(), place_m.z, radii_m);
        let [radius_m, drop_m] = form.unwrap_or([LEVEL_PART * size_m, 0.0]);
        Subject { place_m, radius_m, drop_m, top_m, size_m, from }
    }

    /// Returns a camera that shows the subject, for a picture of `aspect` (width over height). Land that no usual camera
    /// shows well, such as a tower, is seen from above.
    pub(super) fn framed(&self, subject: &Subject, aspect: f64) -> Judged {
        let usual = self.framed_as_usual(subject, aspect);
        if usual.seen.blank() < MOST_BLANK || subject.from.is_some() {
            return usual;
        }
        let above = self.framed_from_above(subject, aspect);
        above.filter(|above| above.seen.blank() < usual.seen.blank()).unwrap_or(usual)
    }

    fn framed_as_usual(&self, subject: &Subject, aspect: f64) -> Judged {
        let place_m = subject.place_m;
        let to_sun = self.light.to_sun;
        let sun_deg = to_sun.x.atan2(to_sun.y).to_degrees();
        let [low_m, high_m] = self.whole.raster.corners_m();
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
        let mut best: Option<Judged> = None;
        for yaw_deg in azimuths {
            let light = cost_of_light(sun_deg - yaw_deg);
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
                    if best.as_ref().is_some_and(|best| cost - BEST_PICTURE > best.cost) {
                        continue;
                    }
                    let (is_seen, is_skyline) = self.sees(eye_m, place_m, subject.top_m);
                    cost += if is_seen { 0.0 } else { 12.0 };
                    // A mountain is recognised by its outline before the sky; on gentle land there is hardly one.
                    cost += if is_skyline { 0.0 } else { 2.0 * (1.0 - gentle * gentle) };
                    for (pitch_deg, seen, place) in self.seen(eye_m, [yaw_deg, up_deg], [distance_m, haze_m], aspect) {
                        let cost = cost + seen.cost(self.contrast) + 8.0 * (place - 0.4_f64).powi(2);
                        if best.as_ref().is_none_or(|best| cost < best.cost) {
                            let camera = Camera {
                                position_m: eye_m,
                                height_above_ground: false,
                                yaw_deg: yaw_deg.rem_euclid(360.0),
                                pitch_deg,
                                fov_deg: FOV_DEG,
                            };
                            best = Some(Judged { camera, cost, seen });
                        }
                    }
                }
            }
        }
        // Not reached: the first camera is always better than none.
        best.unwrap_or_else(|| Judged {
            camera: Camera {
                position_m: place_m + DVec3::Z * wanted_m,
                height_above_ground: false,
                yaw_deg: 0.0,
                pitch_deg: -89.0,
                fov_deg: FOV_DEG,
            },
            cost: f64::INFINITY,
            seen: Seen { empty: 1.0, ..Seen::default() },
        })
    }

    /// Returns the pitches by which a place `down_deg` below the eye is in the upper half of the picture, each with what
    /// the camera sees, and with the part of the picture above the place.
    fn seen(
        &self,
        eye_m: DVec3,
        [yaw_deg, down_deg]: [f64; 2],
        [distance_m, haze_m]: [f64; 2],
        aspect: f64,
    ) -> Vec<(f64, Seen, f64)> {
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
        let mut before: Vec<Option<[Field; ROWS]>> = vec![None; found.len()];
        for column in 0..COLUMNS {
            let across = (2.0 * (column as f64 + 0.5) / COLUMNS as f64 - 1.0) * half * aspect;
            let beside_rad = (across / level).atan();
            let last = self.column(eye_m, yaw_deg.to_radians() + beside_rad, distance_m, &mut spans);
            for ((pitch_deg, seen, _), before) in found.iter_mut().zip(&mut before) {
                let column = Column { pitch_rad: pitch_deg.to_radians(), beside_rad, half };
                let fields = seen.add(&spans, last, column, [distance_m, haze_m]);
                seen.add_detail(&fields, before.as_ref().map(|before| &before[..]), COLUMNS);
                *before = Some(fields);
            }
        }
        found
    }
}

/// A column of a picture.
#[derive(Clone, Copy)]
struct Column {
    pitch_rad: f64,
    /// Horizontal angle from the middle of the picture.
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
    /// Adds one of the columns, and returns its fields.
    fn add(&mut self, spans: &[Span], last: f64, column: Column, [distance_m, haze_m]: [f64; 2]) -> [Field; ROWS] {
        let mut fields = [[0.0; 3]; ROWS];
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
            } else {
                self.near += if span.away_m < 0.2 * distance_m { share } else { 0.0 };
                let [low, high] = span.slopes.map(|slope| ROWS as f64 * column.part(slope));
                let contrast = (-span.away_m / haze_m).exp();
                for (row, field) in fields.iter_mut().enumerate().take(high.ceil() as usize).skip(low as usize) {
                    let land = high.min(row as f64 + 1.0) - low.max(row as f64);
                    for (sum, value) in field.iter_mut().zip([1.0, span.tone, contrast]) {
                        *sum += land * value;
                    }
                }
            }
        }
        // Rays above the last land end in the sky; those that point down are seen to pass the edge of the data.
        self.empty += weight * (1.0 - column.part(last));
        self.beyond += part([last, -LIKE_SKY]);
        self.no_data += part([last, -UNLIKE_SKY]);
        fields
    }

    /// Adds the detail of a column of fields and of the differences from the column before, of which there are
    /// `columns`.
    pub(super) fn add_detail(&mut self, fields: &[Field], before: Option<&[Field]>, columns: usize) {
        let weight = 1.0 / (columns * fields.len()) as f64;
        let below = fields.windows(2).map(|pair| difference(pair[0], pair[1])).sum::<f64>();
        let beside = before.map_or(0.0, |before| fields.iter().zip(before).map(|(a, b)| difference(*a, *b)).sum());
        self.detail += 0.5 * weight * (below + beside);
    }

    /// Returns how bad no-data and too much sky are.
    pub(super) fn blank(&self) -> f64 {
        60.0 * self.no_data + 400.0 * (self.empty - MOST_SKY).max(0.0)
    }

    /// Returns how bad a picture is, of land with a contrast of its own.
    pub(super) fn cost(&self, contrast: f64) -> f64 {
        self.blank()
            + 6.0 * self.beyond
            + 40.0 * (self.beyond - 0.08).max(0.0)
            + 2.0 * (0.1 - self.empty).max(0.0)
            + 5.0 * (self.near - 0.25).max(0.0)
            - 0.25 * self.outlines.min(3.0)
            - DETAIL_WEIGHT * (self.detail / contrast).min(ENOUGH_DETAIL)
    }
}

/// Returns the difference of the tones of two fields, in haze; 0 if one of them is not mostly land.
fn difference([land, tone, contrast]: Field, [other, other_tone, other_contrast]: Field) -> f64 {
    if land < 0.5 || other < 0.5 {
        return 0.0;
    }
    (tone / land - other_tone / other).abs() * (contrast / land).min(other_contrast / other)
}

/// Returns the cost of light: 90° from the view direction is from the side, 0° from the front and 180° from behind.
pub(super) fn cost_of_light(beside_deg: f64) -> f64 {
    let side_deg = ((beside_deg + 180.0).rem_euclid(360.0) - 180.0).abs();
    ((side_deg - 78.0) / 30.0).powi(2) + if (45.0..=115.0).contains(&side_deg) { 0.0 } else { 3.0 }
}
