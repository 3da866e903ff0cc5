//! Warnings about what a drawing does not show.

use super::Job;
use crate::file::message::shown;
use crate::picture::PictureReport;

impl Job<'_> {
    /// Warns once about pictures that show nothing, and about what had no room in them.
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
        let width_m = (east - west).max(north - south);
        format!(
            "the heights are from {west:.0} to {east:.0} m east, {south:.0} to {north:.0} m north and {low_m:.0} to \
             {high_m:.0} m high; --map={x:.0},{y:.0},{width_m:.0} shows them"
        )
    }
}
