//! Warnings about content that a drawing does not show.

use super::Job;
use crate::file::message::shown;
use crate::picture::PictureReport;
use crate::scene::camera::Camera;
use crate::scene::map::MapArea;

/// Largest number of cameras of a path that are compared with the ground.
const COMPARED_CAMERAS: usize = 1000;

/// Returns the warning about cameras below the ground, whose depths in metres are given; NaN or less than 0 is above.
fn below_ground(depths_m: &[f64]) -> Option<String> {
    let deepest_m = depths_m.iter().copied().fold(0.0, f64::max);
    if deepest_m == 0.0 {
        return None;
    }
    let below = match depths_m {
        [_] => format!("{deepest_m:.0} m"),
        all => {
            let share = all.iter().filter(|depth_m| **depth_m > 0.0).count() as f64 / all.len() as f64;
            format!("up to {deepest_m:.0} m (in {:.0} % of the frames)", (100.0 * share).max(1.0))
        }
    };
    Some(format!("the camera is {below} below the ground; write z as +300 for 300 m above it"))
}

impl Job<'_> {
    /// Warns of cameras below the ground, which show the land from below.
    pub(super) fn warn_of_camera_below_ground(&self, cameras: &[Camera]) {
        if self.map.is_some() {
            return;
        }
        let depth_m = |camera: &Camera| {
            let at_m = self.world.pose(camera).position_m;
            self.world.surfaces.terrain.height_m(at_m.truncate()).map_or(f64::NAN, |ground_m| ground_m - at_m.z)
        };
        let compared = cameras.iter().step_by(cameras.len().div_ceil(COMPARED_CAMERAS).max(1));
        if let Some(warning) = below_ground(&compared.map(depth_m).collect::<Vec<_>>()) {
            tracing::warn!("{warning}");
        }
    }

    /// Warns once about pictures that show nothing, and about content that was left out for lack of room.
    pub(super) fn warn_of_absence(&self, report: &PictureReport) {
        let of = |count: u64| match report.pictures {
            0 | 1 => String::new(),
            all => format!(" in {count} of {all} frames"),
        };
        if report.empty > 0 {
            let what = if self.map.is_some() { "the map shows only no-data" } else { "only sky or no-data is in view" };
            tracing::warn!("{what}{}: {}", of(report.empty), self.where_heights_are());
        }
        if report.pale > 0 {
            tracing::warn!(
                "the picture is nearly blank{}: land is in view, but the style {} draws nothing on it that stands out \
                 at this distance and in this light",
                of(report.pale),
                shown(&self.style.name)
            );
        }
        if let Some(text) = report.left_out.message() {
            tracing::warn!("{text}");
        }
        if report.models_left_out > 0 {
            let models = report.models_left_out;
            tracing::warn!("{models} models are missing: they do not fit into the vertex buffers");
        }
    }

    /// Returns where the world has heights, and how to look there.
    fn where_heights_are(&self) -> String {
        let terrain = &self.world.surfaces.terrain;
        let [west, south, east, north] = self.world.data_extent_m().unwrap_or_else(|| {
            let [low_m, high_m] = terrain.corners_m();
            [low_m.x, low_m.y, high_m.x, high_m.y]
        });
        let [low_m, high_m] = terrain.range_m();
        let (x, y) = (0.5 * (west + east), 0.5 * (south + north));
        let [width_px, height_px] = self.args.size().map(f64::from);
        let width_m = (east - west).max((north - south) * width_px / height_px);
        let map = MapArea::Around { centre_m: glam::DVec2::new(x.round(), y.round()), width_m: width_m.ceil() };
        format!(
            "the heights are from {west:.0} to {east:.0} m east, {south:.0} to {north:.0} m north and {low_m:.0} to \
             {high_m:.0} m high; --map={map} shows them"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_below_the_ground_are_reported() {
        assert_eq!(below_ground(&[-5.0]), None);
        assert_eq!(below_ground(&[f64::NAN]), None, "beyond the land there is no ground");
        let one = "the camera is 3700 m below the ground; write z as +300 for 300 m above it";
        assert_eq!(below_ground(&[3700.2]).as_deref(), Some(one));
        let path = below_ground(&[-5.0, 12.0, 3.0, -1.0]).unwrap_or_default();
        assert!(path.starts_with("the camera is up to 12 m (in 50 % of the frames) below the ground"), "{path}");
    }
}
