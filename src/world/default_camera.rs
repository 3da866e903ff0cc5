//! The camera of a world that has none: a view from the south over the whole extent, or over the part that has data.

use glam::{DVec2, DVec3};

use super::OpenWorld;
use crate::pyramid::store::DataArea;
use crate::scene::camera::Camera;
use crate::scene::view::View;

/// Size of the picture in which the view of the data is estimated, in cells.
const PICTURE_CELLS: [u32; 2] = [16, 9];
/// Share of the cells of a picture that must show data. A view over a whole DEM has about half.
const ENOUGH: f64 = 0.15;
/// Vertical field of view, in degrees.
const FOV_DEG: f64 = 45.0;

/// An area that a camera looks over: its corners in metres, and its lowest and highest height.
#[derive(Clone, Copy, Debug)]
struct Sight {
    low_m: DVec2,
    high_m: DVec2,
    range_m: [f64; 2],
}

/// Where the world has heights.
struct Data {
    /// Places of heights in the world.
    points_m: Vec<DVec3>,
    sight: Sight,
}

impl OpenWorld {
    /// Returns the scene's start, or by default a view from the south over the whole extent, from a little above its
    /// summits. If that view shows little but no-data, it is a view over the part that has data.
    pub fn default_camera(&self) -> Camera {
        if let Some(start) = self.scene.start {
            return start;
        }
        let half_m = 0.5 * DVec2::from_array(self.extent_m());
        let range_m = self.surfaces.terrain.range_m().map(f64::from);
        let over_whole = Sight { low_m: -half_m, high_m: half_m, range_m }.camera(0.0);
        let Some(data) = self.data() else { return over_whole };
        let share = |camera: &Camera| self.share_of_data(camera, &data.points_m);
        if share(&over_whole) >= ENOUGH {
            return over_whole;
        }
        let near = |part: f64| data.sight.around(data.nearest_to_middle_m(), part);
        let others = [data.sight.camera(0.0), near(0.5).camera(0.0), near(0.25).camera(0.0), near(0.1).camera(0.0)];
        let turned = [90.0, 180.0, 270.0].map(|yaw_deg| data.sight.camera(yaw_deg));
        let all = || std::iter::once(over_whole).chain(others).chain(turned);
        let found = all().find(|camera| share(camera) >= ENOUGH);
        found.or_else(|| all().max_by(|a, b| share(a).total_cmp(&share(b)))).unwrap_or(over_whole)
    }

    /// Returns the extent of the heights: west, south, east and north in metres; `None` if all of the world has
    /// heights, or if they cannot be read, which drawing reports.
    pub(crate) fn data_extent_m(&self) -> Option<[f64; 4]> {
        let Sight { low_m, high_m, .. } = self.data()?.sight;
        Some([low_m.x, low_m.y, high_m.x, high_m.y])
    }

    fn data(&self) -> Option<Data> {
        let terrain = &self.surfaces.terrain;
        let area = DataArea::of(terrain.store()).ok().filter(|area| !area.is_whole)?;
        let mut points_m = Vec::new();
        let mut range_m = [f64::INFINITY, f64::NEG_INFINITY];
        for cell in &area.cells {
            let heights_m = cell.range_m.map(f64::from);
            range_m = [range_m[0].min(heights_m[0]), range_m[1].max(heights_m[1])];
            let height_m = 0.5 * (heights_m[0] + heights_m[1]);
            let steps = [0.0, 0.5, 1.0];
            for (u, v) in steps.into_iter().flat_map(|v| steps.map(|u| (u, v))) {
                let at = |axis: usize, t: f64| cell.low[axis] + (cell.high[axis] - cell.low[axis]) * t;
                points_m.push(terrain.mapping().world_from_grid(at(0, u), at(1, v)).extend(height_m));
            }
        }
        let flat = || points_m.iter().map(|point| point.truncate());
        let (low_m, high_m) = (flat().reduce(DVec2::min)?, flat().reduce(DVec2::max)?);
        // A single row or column has no width.
        let least_m = DVec2::from_array(self.extent_m()).max_element() * 1e-4;
        let sight = Sight { low_m: low_m - least_m, high_m: high_m + least_m, range_m };
        Some(Data { points_m, sight })
    }

    /// Returns the share of the picture of a camera in which there are heights, without regard to what hides them.
    fn share_of_data(&self, camera: &Camera, points_m: &[DVec3]) -> f64 {
        let pose = self.pose(camera);
        let [width, height] = PICTURE_CELLS;
        let view = View::whole(pose, pose, PICTURE_CELLS);
        let mut is_seen = vec![false; (width * height) as usize];
        for place in points_m.iter().filter_map(|point| view.place_px(*point - pose.position_m)) {
            let is_inside = place.cmpge(DVec2::ZERO).all() && place.x < f64::from(width) && place.y < f64::from(height);
            if is_inside {
                is_seen[(place.y as u32 * width + place.x as u32) as usize] = true;
            }
        }
        is_seen.iter().filter(|seen| **seen).count() as f64 / is_seen.len() as f64
    }
}

impl Data {
    /// Returns the place with a height that is nearest to the middle of all: the middle itself may be a hole.
    fn nearest_to_middle_m(&self) -> DVec2 {
        let flat = || self.points_m.iter().map(|point| point.truncate());
        let middle_m = flat().sum::<DVec2>() / self.points_m.len() as f64;
        let apart = |place: &DVec2| place.distance_squared(middle_m);
        flat().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(middle_m)
    }
}

impl Sight {
    /// Returns a part of this area around a place.
    fn around(self, middle_m: DVec2, part: f64) -> Self {
        let half_m = 0.5 * part * (self.high_m - self.low_m);
        Self { low_m: middle_m - half_m, high_m: middle_m + half_m, ..self }
    }

    /// Returns a camera inside the area, behind its middle, that looks over it in a direction.
    fn camera(self, yaw_deg: f64) -> Camera {
        let middle_m = 0.5 * (self.low_m + self.high_m);
        let size_m = self.high_m - self.low_m;
        let (sin, cos) = yaw_deg.to_radians().sin_cos();
        let depth_m = (size_m.x * sin).abs() + (size_m.y * cos).abs();
        let [low_m, high_m] = self.range_m;
        // Higher over flat land, whose panorama would otherwise be one line.
        let z_m = (high_m + 0.15 * (high_m - low_m)).max(low_m + 0.06 * depth_m);
        let behind_m = -0.42 * depth_m * DVec2::new(sin, cos);
        let ahead_m = 0.45 * depth_m;
        let target_m = low_m + 0.55 * (high_m - low_m);
        Camera {
            position_m: (middle_m + behind_m).extend(z_m),
            height_above_ground: false,
            yaw_deg,
            pitch_deg: ((target_m - z_m) / ahead_m).atan().to_degrees(),
            fov_deg: FOV_DEG,
        }
    }
}
