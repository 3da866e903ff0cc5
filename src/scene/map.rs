//! Maps: pictures of the land from straight above, north up, on which every point is at its east and north, whatever
//! its height.
//!
//! Passes measure pixels by a distance and a focal length, so a map is drawn by an eye very far up with a very long
//! lens: rays are so close to parallel that relief moves no point by more than [`SHIFT_PX`]. Why the rays are not
//! exactly parallel: `docs/decisions/maps.md`.

use std::fmt;
use std::str::FromStr;

use glam::{DVec2, DVec3};

use super::camera::{Camera, FOV_RANGE_DEG, LARGEST_COORDINATE_M};
use super::view::Pose;
use super::{Haze, Scene, ranges};

/// Largest shift by relief of a point in a corner of the picture, in pixels.
pub(crate) const SHIFT_PX: f64 = 0.25;
/// Allowance for objects on the land: how far they may rise above it or reach below it, in metres.
const STANDING_M: f64 = 50.0;
/// The least reach above and below a height that is assumed, as a part of the map's longer side.
const LEAST_REACH: f64 = 0.01;
/// Free margin at each end of the picture's side around a whole world, so that its outline fits.
const FREE_PART: f64 = 0.01;
/// Haze distance that has no visible effect, in metres.
const NO_HAZE_M: f64 = 1e20;

/// The area that a map shows.
///
/// It is written and parsed as `whole`, `EAST,NORTH` or `EAST,NORTH,WIDTH` in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapArea {
    /// The whole world, as large as it fits.
    Whole,
    /// The land around a point, as wide as follows from the scale of the map.
    At {
        /// East and north of the centre in the world's frame, in metres.
        centre_m: DVec2,
    },
    /// The land around a point.
    Around {
        /// East and north of the centre in the world's frame, in metres.
        centre_m: DVec2,
        /// Width of the picture in metres.
        width_m: f64,
    },
}

impl FromStr for MapArea {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "whole" {
            return Ok(Self::Whole);
        }
        let wrong = || {
            "it must be EAST,NORTH,WIDTH in metres, like 1200,-350,5000, EAST,NORTH with --map-scale, or nothing for the \
             whole world; a negative first number needs an equals sign, --map=-120,80,5000"
        };
        let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        let (east_m, north_m, width_m) = match numbers.as_deref() {
            Some(&[east_m, north_m]) => (east_m, north_m, None),
            Some(&[east_m, north_m, width_m]) => (east_m, north_m, Some(width_m)),
            _ => return Err(wrong().to_owned()),
        };
        if ![east_m, north_m].iter().all(|place_m| place_m.abs() <= LARGEST_COORDINATE_M) {
            return Err(format!("the map's centre must be within {LARGEST_COORDINATE_M} m of the world's origin"));
        }
        let centre_m = DVec2::new(east_m, north_m);
        let Some(width_m) = width_m else { return Ok(Self::At { centre_m }) };
        if !ranges::MAP_WIDTH_M.holds(width_m) {
            return Err(ranges::MAP_WIDTH_M.rule().replacen("it", "the map's width in metres", 1));
        }
        Ok(Self::Around { centre_m, width_m })
    }
}

impl fmt::Display for MapArea {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => f.write_str("whole"),
            Self::At { centre_m } => write!(f, "{},{}", centre_m.x, centre_m.y),
            Self::Around { centre_m, width_m } => write!(f, "{},{},{width_m}", centre_m.x, centre_m.y),
        }
    }
}

/// The mapping from the pixels of a map to the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// East and north of the picture's centre, in metres.
    pub centre_m: DVec2,
    /// Side of a pixel in metres.
    pub pixel_m: f64,
    /// Size of the picture.
    pub size_px: [u32; 2],
}

impl Map {
    /// Returns the map of an area in a world that extends from `low_m` to `high_m` (east, north).
    pub fn new(area: MapArea, [low_m, high_m]: [DVec2; 2], size_px: [u32; 2]) -> Self {
        let size = DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]));
        match area {
            MapArea::Around { centre_m, width_m } => Self { centre_m, pixel_m: width_m / size.x, size_px },
            MapArea::Whole | MapArea::At { .. } => {
                let pixel_m = ((high_m - low_m) / (size * (1.0 - 2.0 * FREE_PART))).max_element().max(1e-6);
                let centre_m = match area {
                    MapArea::At { centre_m } => centre_m,
                    _ => 0.5 * (low_m + high_m),
                };
                Self { centre_m, pixel_m, size_px }
            }
        }
    }

    /// Returns the map on a picture that is `foot_px` rows longer at the bottom.
    #[must_use]
    pub(crate) fn with_foot(self, foot_px: u32) -> Self {
        let [width, height] = self.size_px;
        let down_m = 0.5 * self.pixel_m * f64::from(foot_px);
        Self { centre_m: self.centre_m - DVec2::new(0.0, down_m), size_px: [width, height + foot_px], ..self }
    }

    /// Returns the centre of the part of the map that is above `foot_px` rows at the bottom, in metres.
    pub(crate) fn centre_above_m(&self, foot_px: u32) -> DVec2 {
        self.centre_m + DVec2::new(0.0, 0.5 * self.pixel_m * f64::from(foot_px))
    }

    /// Returns the map on a picture that is `frame_px` larger on each side.
    #[must_use]
    pub(crate) fn with_frame(self, frame_px: u32) -> Self {
        Self { size_px: self.size_px.map(|side| side + 2 * frame_px), ..self }
    }

    /// Returns east and north of a point of the picture; (0, 0) is its upper left corner.
    pub fn world_from_px(&self, px: DVec2) -> DVec2 {
        let from_centre = px - 0.5 * self.size();
        self.centre_m + self.pixel_m * DVec2::new(from_centre.x, -from_centre.y)
    }

    /// Returns the south-western and the north-eastern corner.
    pub(crate) fn corners_m(&self) -> [DVec2; 2] {
        let half_m = 0.5 * self.pixel_m * self.size();
        [self.centre_m - half_m, self.centre_m + half_m]
    }

    /// Returns the pose of the eye that draws the map, over land between the two heights.
    pub fn pose(&self, [low_m, high_m]: [f64; 2]) -> Pose {
        self.pose_above(0.5 * (low_m + high_m), 0.5 * (high_m - low_m).max(0.0) + STANDING_M)
    }

    /// Returns the pose of the eye that draws the map, over all that there is between the two heights, without the
    /// allowance for objects on the land.
    pub(crate) fn pose_within(&self, [low_m, high_m]: [f64; 2]) -> Pose {
        // The eye is several widths of the map above level ground.
        let least_m = LEAST_REACH * self.pixel_m * self.size().max_element();
        self.pose_above(0.5 * (low_m + high_m), (0.5 * (high_m - low_m)).max(least_m))
    }

    /// Returns the pose of the eye over all that is at most `reach_m` above or below a height.
    fn pose_above(&self, middle_m: f64, reach_m: f64) -> Pose {
        let above_m = reach_m * 0.5 * self.size().length() / SHIFT_PX;
        let half_m = 0.5 * self.pixel_m * f64::from(self.size_px[1]);
        Pose {
            position_m: self.centre_m.extend(middle_m + above_m),
            forward: DVec3::NEG_Z,
            right: DVec3::X,
            up: DVec3::Y,
            fov_rad: 2.0 * (half_m / above_m).atan(),
        }
    }

    /// Returns the nearest valid camera to a pose: the pose's lens may be longer than cameras allow.
    pub(crate) fn camera(pose: &Pose) -> Camera {
        let fov_deg = pose.fov_rad.to_degrees().clamp(FOV_RANGE_DEG[0], FOV_RANGE_DEG[1]);
        let lowest_m = DVec3::splat(-LARGEST_COORDINATE_M);
        let position_m = pose.position_m.clamp(lowest_m, -lowest_m);
        Camera { position_m, height_above_ground: false, yaw_deg: 0.0, pitch_deg: -90.0, fov_deg }
    }

    /// Returns the size of the picture in pixels.
    pub(crate) fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.size_px[0]), f64::from(self.size_px[1]))
    }
}

impl Scene {
    /// Returns the scene without what depends on the eye's position: haze, and the curvature of the earth.
    #[must_use]
    pub fn for_map(self) -> Self {
        let haze = Haze { distance_m: Some(NO_HAZE_M), ..self.haze };
        Self { earth: None, haze, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::view::View;

    #[test]
    fn areas_are_read_as_they_are_written() {
        let around = MapArea::Around { centre_m: DVec2::new(-120.5, 80.0), width_m: 5000.0 };
        let at = MapArea::At { centre_m: DVec2::new(3.5, -80.0) };
        for area in [MapArea::Whole, at, around] {
            assert_eq!(area.to_string().parse(), Ok(area));
        }
        for wrong in
            ["", "1", "1,2,3,4", "1e99,2", "a,2,3", "1,2,0", "1,2,-3", "NaN,0,1", "0,1e9,1", "0,0,inf", "hill.tif"]
        {
            assert!(wrong.parse::<MapArea>().is_err(), "{wrong}");
        }
    }

    /// Largest distance, in pixels, between where a point is seen and where the map has it, over corners and heights.
    fn shift_px(map: &Map, range_m: [f64; 2], pose: &Pose) -> f64 {
        let view = View::whole(*pose, *pose, map.size_px);
        let mut max_px = 0.0_f64;
        for corner in [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [1.0, 1.0]] {
            let px = DVec2::from(corner) * map.size();
            for height_m in [range_m[0], 0.5 * (range_m[0] + range_m[1]), range_m[1]] {
                let seen = view.place_px(map.world_from_px(px).extend(height_m) - pose.position_m).unwrap();
                max_px = max_px.max(seen.distance(px));
            }
        }
        max_px
    }

    #[test]
    fn relief_moves_no_place() {
        let range_m = [-20.0, 4371.0];
        let around = MapArea::Around { centre_m: DVec2::new(700.0, -30.0), width_m: 77_000.0 };
        for size_px in [[1280, 720], [300, 900], [20_000, 8000]] {
            let map = Map::new(around, [DVec2::ZERO; 2], size_px);
            let pose = map.pose(range_m);
            let found_px = shift_px(&map, range_m, &pose);
            assert!(found_px <= SHIFT_PX, "{size_px:?}: {found_px}");
            // Planted: an eye at a fifth of that height, whose lens shows the same area.
            let mut low = pose;
            low.position_m.z *= 0.2;
            low.fov_rad *= 5.0;
            assert!(shift_px(&map, range_m, &low) > 2.0 * SHIFT_PX, "{size_px:?}");
        }
    }

    #[test]
    fn a_whole_world_fits() {
        let corners = [DVec2::new(-100.0, -400.0), DVec2::new(300.0, 500.0)];
        for size_px in [[1000, 100], [100, 1000], [640, 360]] {
            let map = Map::new(MapArea::Whole, corners, size_px);
            let [low_m, high_m] = map.corners_m();
            assert!(low_m.cmplt(corners[0]).all() && high_m.cmpgt(corners[1]).all(), "{size_px:?}");
            let free = (corners[0] - low_m).min_element() / (map.pixel_m * map.size()).min_element();
            assert!(free > 0.0 && (map.world_from_px(DVec2::ZERO) - DVec2::new(low_m.x, high_m.y)).length() < 1e-9);
        }
    }
}
