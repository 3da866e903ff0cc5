//! Numbers on the contour lines of a map that `hachure render` draws.

use anyhow::Context;
use glam::DVec2;
use kurbo::{BezPath, Shape};

use super::Job;
use crate::picture::contour_numbers::{Inputs, Numbers, numbers};
use crate::picture::title::Block;
use crate::vector::Group;

impl Job<'_> {
    /// Returns the numbers on contour lines, if a map is drawn in a style that has them. They do not touch the boxes of
    /// other labels, `labels_px`.
    ///
    /// # Errors
    /// Fails if a tile cannot be read.
    pub(super) fn contour_numbers(&self, labels_px: &[[DVec2; 2]]) -> anyhow::Result<Option<Numbers>> {
        let Some(placed) = &self.map else { return Ok(None) };
        let (surfaces, style, px) = (&self.world.surfaces, &self.style, self.args.px_per_style_px());
        let inputs = Inputs { map: &placed.map, surfaces, style, obstacles_px: labels_px, px };
        numbers(&inputs).context("cannot read the heights of contour lines")
    }
}

/// Returns the boxes of the strokes and letters of blocks: lower and upper corners, in pixels.
pub(super) fn blocks_px<'a>(blocks: impl Iterator<Item = &'a Block> + Clone) -> Vec<[DVec2; 2]> {
    let strokes = blocks.clone().flat_map(|block| &block.strokes);
    let strokes = strokes.map(|stroke| around(stroke.points.iter().copied(), 0.5 * stroke.width_px));
    strokes.chain(blocks.flat_map(|block| &block.areas).map(|area| around_path(&area.curves))).collect()
}

/// Returns the boxes of the lines and areas of groups: lower and upper corners, in pixels.
pub(super) fn groups_px<'a>(groups: impl Iterator<Item = &'a Group> + Clone) -> Vec<[DVec2; 2]> {
    let lines = groups.clone().flat_map(|group| &group.lines).map(|line| {
        let half_width_px = line.points.iter().map(|point| f64::from(point.half_width_px)).fold(0.0, f64::max);
        around(line.points.iter().map(|point| DVec2::from(point.px.map(f64::from))), half_width_px)
    });
    lines.chain(groups.flat_map(|group| &group.fills).map(around_path)).collect()
}

fn around(points: impl Iterator<Item = DVec2>, margin_px: f64) -> [DVec2; 2] {
    let [low, high] =
        points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
    [low - margin_px, high + margin_px]
}

fn around_path(path: &BezPath) -> [DVec2; 2] {
    let around = path.bounding_box();
    [DVec2::new(around.x0, around.y0), DVec2::new(around.x1, around.y1)]
}
