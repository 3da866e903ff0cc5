//! The view from a place: land in two resolutions, its shading, and the lines of sight over it.

use glam::{DVec2, DVec3};

use super::raster::Raster;
use crate::scene::Light;

/// Difference in tone between the lowest and the highest land: on gentle land, elevation tints and contour lines of
/// height show more than shading.
const TINT: f64 = 0.06;
/// Smallest contrast of land.
const LEAST_CONTRAST: f64 = 0.004;

/// Heights in two resolutions: of the whole world, and around the place.
pub(super) struct Land<'a> {
    pub whole: Shaded<'a>,
    pub near: Option<Shaded<'a>>,
    /// Distance between samples of the finest level, in metres.
    pub spacing_m: f64,
    /// Light and haze.
    pub light: Light,
    /// Standard deviation of the tones of the land around the place, seen from above.
    pub contrast: f64,
    /// The lowest and the highest land, in metres.
    pub bottom_m: f64,
    pub top_m: f64,
}

/// A raster with its tones.
pub(super) struct Shaded<'a> {
    pub raster: &'a Raster,
    /// Cosine of the angle between the normal of each cell and the direction to the sun, or 0 if that is negative, and a
    /// tint that grows with height.
    tones: Vec<f32>,
}

/// A part of a column of the picture, between two slopes as seen from the camera.
pub(super) struct Span {
    pub slopes: [f64; 2],
    pub is_land: bool,
    /// Distance of the land, in metres.
    pub away_m: f64,
    /// Its tone, which grows with light and height.
    pub tone: f64,
}

impl<'a> Shaded<'a> {
    fn new(raster: &'a Raster, to_sun: DVec3, [bottom_m, top_m]: [f64; 2]) -> Self {
        let [width, height] = raster.size;
        let height_m = |column: usize, row: usize| f64::from(raster.heights_m[row * width + column]);
        let slope = |low: f64, here: f64, high: f64, cells: f64| match (low.is_nan(), high.is_nan()) {
            (false, false) => (high - low) / (cells * raster.cell_m),
            (true, false) => (high - here) / raster.cell_m,
            (false, true) => (here - low) / raster.cell_m,
            (true, true) => 0.0,
        };
        let tone = |column: usize, row: usize| {
            let here = height_m(column, row);
            let [west, east] = [column.saturating_sub(1), (column + 1).min(width - 1)];
            let [south, north] = [row.saturating_sub(1), (row + 1).min(height - 1)];
            let rise_east = slope(height_m(west, row), here, height_m(east, row), (east - west).max(1) as f64);
            let rise_north =
                slope(height_m(column, south), here, height_m(column, north), (north - south).max(1) as f64);
            let shade = DVec3::new(-rise_east, -rise_north, 1.0).normalize().dot(to_sun).max(0.0);
            (shade + TINT * (here - bottom_m) / (top_m - bottom_m).max(1e-9)) as f32
        };
        let cells = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        Self { raster, tones: cells.map(|(column, row)| tone(column, row)).collect() }
    }

    /// Returns the standard deviation of the tones within a distance of a place.
    fn contrast_around(&self, place_m: DVec2, radius_m: f64) -> f64 {
        let (mut sums, mut count) = (DVec2::ZERO, 0.0);
        for (index, &tone) in self.tones.iter().enumerate() {
            let is_near = self.raster.place_m(self.raster.cell(index)).distance_squared(place_m) < radius_m.powi(2);
            if is_near && !self.raster.heights_m[index].is_nan() {
                sums += DVec2::new(f64::from(tone), f64::from(tone).powi(2));
                count += 1.0;
            }
        }
        let mean = sums / f64::max(count, 1.0);
        (mean.y - mean.x.powi(2)).max(0.0).sqrt()
    }
}

impl<'a> Land<'a> {
    /// Creates the land around a place, of which `size_m` is the larger side.
    pub(super) fn new(
        whole: &'a Raster,
        near: Option<&'a Raster>,
        spacing_m: f64,
        light: Light,
        place_m: DVec2,
        size_m: f64,
    ) -> Self {
        let heights_m = whole.heights_m.iter().filter(|height_m| !height_m.is_nan());
        let range_m = heights_m
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &height_m| [low.min(height_m), high.max(height_m)]);
        let [bottom_m, top_m] = range_m.map(f64::from);
        let shaded = |raster| Shaded::new(raster, light.to_sun, [bottom_m, top_m]);
        let whole = shaded(whole);
        let contrast = whole.contrast_around(place_m, 0.3 * size_m).max(LEAST_CONTRAST);
        Self { whole, near: near.map(shaded), spacing_m, light, contrast, bottom_m, top_m }
    }

    /// Returns the raster that holds a place.
    fn at(&self, place_m: DVec2) -> &Shaded<'a> {
        self.near.as_ref().filter(|near| near.raster.contains(place_m)).unwrap_or(&self.whole)
    }

    /// Returns the height of the land at a place; NaN without data.
    pub(super) fn height_m(&self, place_m: DVec2) -> f64 {
        self.at(place_m).raster.height_m(place_m)
    }

    pub(super) fn cell_m(&self, place_m: DVec2) -> f64 {
        self.at(place_m).raster.cell_m
    }

    /// Returns the tone of the land at a place; 0 outside of the rasters, and in a hole of the finer one.
    pub(super) fn tone(&self, place_m: DVec2) -> f64 {
        let shaded = self.at(place_m);
        let tone = shaded.raster.index(place_m).map_or(0.0, |at| f64::from(shaded.tones[at]));
        if tone.is_nan() { 0.0 } else { tone }
    }

    /// Returns the highest land at a place and around it; NaN without data.
    pub(super) fn highest_m(&self, place_m: DVec2) -> f64 {
        let cell_m = self.cell_m(place_m);
        let around = [[0.0, 0.0], [1.5, 0.0], [-1.5, 0.0], [0.0, 1.5], [0.0, -1.5]];
        let heights = around.map(|step| self.height_m(place_m + cell_m * DVec2::from_array(step)));
        if heights[0].is_nan() { f64::NAN } else { heights.into_iter().fold(heights[0], f64::max) }
    }

    /// Returns the spans of a column of the picture from the ground below the camera upward, and the slope of the last
    /// land.
    pub(super) fn column(&self, eye_m: DVec3, azimuth_rad: f64, scale_m: f64, spans: &mut Vec<Span>) -> f64 {
        spans.clear();
        let (sin, cos) = azimuth_rad.sin_cos();
        let (way, start_m) = (DVec2::new(sin, cos), eye_m.truncate());
        let [low_m, high_m] = self.whole.raster.corners_m();
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
                    let tone = self.tone(at_m);
                    spans.push(Span { slopes: [steepest, slope], is_land: !was_void, away_m, tone });
                    if was_hidden {
                        // Marks an outline: nothing of the land between was seen.
                        spans.push(Span { slopes: [slope, slope], is_land: true, away_m, tone });
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

    /// Returns whether a place is visible from an eye, and whether it is also higher than all that is behind it. Land
    /// that is at most `top_m` away from the place does not hide it.
    pub(super) fn sees(&self, eye_m: DVec3, place_m: DVec3, top_m: f64) -> (bool, bool) {
        let way_m = place_m.truncate() - eye_m.truncate();
        let distance_m = way_m.length();
        let cell_m = self.cell_m(place_m.truncate());
        let top_m = top_m.max(2.5 * cell_m);
        let slope = (place_m.z - eye_m.z) / distance_m;
        let steps = (distance_m / (0.8 * cell_m)).clamp(8.0, 2000.0) as u32;
        let slope_at = |part: f64| (self.height_m(eye_m.truncate() + part * way_m) - eye_m.z) / (part * distance_m);
        let is_seen = (1..steps).all(|step| {
            let part = f64::from(step) / f64::from(steps);
            let found = slope_at(part);
            // The summit's own cells hide nothing.
            found.is_nan() || (1.0 - part) * distance_m < top_m || found <= slope
        });
        let mut away_m = distance_m + 1.5 * cell_m;
        let mut is_skyline = is_seen;
        while is_skyline && self.whole.raster.contains(eye_m.truncate() + away_m / distance_m * way_m) {
            let found = slope_at(away_m / distance_m);
            is_skyline = found.is_nan() || found <= slope;
            away_m += (0.8 * cell_m).max(0.03 * (away_m - distance_m));
        }
        (is_seen, is_skyline)
    }
}
