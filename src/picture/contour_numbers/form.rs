//! The form of the land on a map, as `shaders/shared/form.wgsl` computes it: contour lines of heights follow it, and not
//! the land itself.
//!
//! The heights are read at the levels of the pyramid that the form needs, whose samples are about as large as the size to
//! which the land is smoothed, so a map needs far fewer of them than it has pixels.

use glam::DVec2;
use rayon::prelude::*;

use crate::drainage::flow::Grid;
use crate::drainage::{Land, Region};
use crate::pyramid::PyramidError;
use crate::scene::map::Map;

/// Largest number of nodes at which heights are computed.
const MAX_NODES: f64 = (1 << 22) as f64;
/// Nodes for the size to which the land is smoothed, along a side.
const NODES_PER_FORM: f64 = 4.0;
/// Levels above that of level land which the form of the steepest land may need: `MIN_FACING` of the shader.
const STEEPER_LEVELS: f64 = 2.0;
/// As in the shader: levels that can be averaged beyond the coarsest one, and the width of the averaging square in
/// samples, per factor by which a sample should be larger.
const MAX_BEYOND: f64 = 2.0;
const WIDER: f64 = 1.5;
/// Samples that are read around those of the map.
const MARGIN_SAMPLES: f64 = 4.0;
/// Points along each side of the map that find the samples under it.
const SIDE_POINTS: u32 = 16;

/// Heights of the form at the nodes of a grid over a map.
pub(super) struct Form {
    /// Number of columns and rows of nodes.
    pub size: [usize; 2],
    /// Position of the first node on the picture, and the distance of nodes, in pixels.
    pub first_px: DVec2,
    pub step_px: f64,
    /// Heights in metres, as they are drawn, row by row; NaN where there is no land.
    pub heights_m: Vec<f64>,
}

/// The levels of the pyramid under a map, from finer to coarser.
struct Levels<'a> {
    land: &'a Land,
    levels: Vec<(Region, Grid)>,
}

impl Form {
    /// Reads the form of the land in an area of a map, which is given by two corners in pixels. `form_px` is the size to
    /// which the land is smoothed.
    ///
    /// # Errors
    /// The first tile that cannot be read.
    pub(super) fn read(land: &Land, map: &Map, area_px: [DVec2; 2], form_px: f64) -> Result<Self, PyramidError> {
        let size_px = (area_px[1] - area_px[0]).max(DVec2::ZERO);
        let step_px = (form_px / NODES_PER_FORM).max((size_px.x * size_px.y / MAX_NODES).sqrt()).max(1.0);
        let size = size_px.to_array().map(|side_px| (side_px / step_px) as usize + 1);
        let level = (form_px * map.pixel_m / land.projection.spacing_m()).log2();
        let mut form = Self { size, first_px: area_px[0], step_px, heights_m: Vec::new() };
        let Some(levels) = Levels::read(land, map, area_px, level)? else {
            form.heights_m = vec![f64::NAN; size[0] * size[1]];
            return Ok(form);
        };
        let nodes = 0..size[0] * size[1];
        let level_land = nodes.clone().into_par_iter().map(|node| levels.form_m(map, form.node_px(node), level));
        form.heights_m = level_land.collect();
        // Steep land is seen at an angle, so that a sample covers less of the picture, and is smoothed more.
        let steep_land = nodes.into_par_iter().map(|node| {
            let slope = form.gradient_at(node).map_or(0.0, |gradient| gradient.length() / map.pixel_m);
            let more = (0.25 * (1.0 + slope * slope).log2()).min(STEEPER_LEVELS);
            levels.form_m(map, form.node_px(node), level + more)
        });
        form.heights_m = steep_land.collect();
        Ok(form)
    }

    fn node_px(&self, node: usize) -> DVec2 {
        self.px(DVec2::new((node % self.size[0]) as f64, (node / self.size[0]) as f64))
    }

    /// Returns the position on the picture of a column and a row.
    pub(super) fn px(&self, at: DVec2) -> DVec2 {
        self.first_px + self.step_px * at
    }

    /// Returns the gradient at a node in metres per pixel; `None` where it is unknown.
    fn gradient_at(&self, node: usize) -> Option<DVec2> {
        let [columns, rows] = self.size;
        let [x, y] = [node % columns, node / columns];
        let rise = |[before, after]: [usize; 2], steps: usize| {
            let rise_m = self.heights_m[after] - self.heights_m[before];
            (steps > 0).then(|| rise_m / (steps as f64 * self.step_px))
        };
        let [left, right] = [x.saturating_sub(1), (x + 1).min(columns - 1)];
        let [above, below] = [y.saturating_sub(1), (y + 1).min(rows - 1)];
        let along = rise([y * columns + left, y * columns + right], right - left)?;
        let down = rise([above * columns + x, below * columns + x], below - above)?;
        Some(DVec2::new(along, down)).filter(|gradient| gradient.is_finite())
    }

    /// Returns the gradient at the node nearest to a point of the picture, in metres per pixel; `None` where it is
    /// unknown. It points uphill.
    pub(super) fn gradient(&self, at_px: DVec2) -> Option<DVec2> {
        let at = ((at_px - self.first_px) / self.step_px).round();
        let last = DVec2::new(self.size[0] as f64, self.size[1] as f64) - 1.0;
        let is_inside = at.cmpge(DVec2::ZERO).all() && at.cmple(last).all();
        is_inside.then(|| self.gradient_at(at.y as usize * self.size[0] + at.x as usize)).flatten()
    }
}

impl<'a> Levels<'a> {
    /// Reads the levels that the form needs; `None` if there is no land under the map.
    fn read(land: &'a Land, map: &Map, area_px: [DVec2; 2], level: f64) -> Result<Option<Self>, PyramidError> {
        let coarsest = land.store.levels().len() as u32 - 1;
        let [first, last] = [level, level + STEEPER_LEVELS + 1.0].map(|level| {
            let level = level.floor().clamp(0.0, f64::from(coarsest));
            level as u32
        });
        let Some([low, high]) = under(land, map, area_px) else { return Ok(None) };
        let mut levels: Vec<(Region, Grid)> = Vec::new();
        for level in first..=last {
            let margin = MARGIN_SAMPLES * f64::from(level).exp2();
            let region = Region::bounded(land, level, [low - margin, high + margin]);
            // The finest levels of a large map may have too many samples.
            if levels.last().is_none_or(|(finer, _)| finer.level() < region.level()) {
                let grid = region.read(land)?;
                levels.push((region, grid));
            }
        }
        Ok(Some(Self { land, levels }))
    }

    /// Returns the height of the form at a point of a map and a level, in metres: `form_of_level` of the shader. It is NaN
    /// where there is no land.
    fn form_m(&self, map: &Map, at_px: DVec2, level: f64) -> f64 {
        let at = self.land.projection.grid_from_world(map.world_from_px(at_px));
        let last = last_sample(self.land);
        if !(at.cmpge(DVec2::ZERO).all() && at.cmple(last).all()) {
            return f64::NAN;
        }
        let sizes = self.land.store.levels();
        let coarsest = (sizes.len() - 1) as f64;
        let beyond = (level - coarsest).clamp(0.0, MAX_BEYOND).exp2();
        let along = beyond.ceil() as u32;
        let step = WIDER * (beyond - 1.0) / beyond * coarsest.exp2();
        let taps = (0..along * along).map(|i| {
            let tap = DVec2::new(f64::from(i % along), f64::from(i / along)) - 0.5 * f64::from(along - 1);
            self.smoothed_m((at + step * tap).clamp(DVec2::ZERO, last), level.clamp(0.0, coarsest))
        });
        taps.sum::<f64>() / f64::from(along * along)
    }

    /// Returns the height between two levels, which are blended in the middle half of their interval.
    fn smoothed_m(&self, at: DVec2, level: f64) -> f64 {
        let fine = level.floor();
        let blend = ((level - fine) * 2.0 - 0.5).clamp(0.0, 1.0);
        let of = |level: f64| self.spline_m(at, level as u32);
        match blend {
            0.0 => of(fine),
            1.0 => of(fine + 1.0),
            blend => of(fine) + blend * (of(fine + 1.0) - of(fine)),
        }
    }

    /// Returns the height of a level under a uniform cubic B-spline, or of the nearest level that was read.
    fn spline_m(&self, at: DVec2, level: u32) -> f64 {
        let nearest = self.levels.iter().min_by_key(|(region, _)| region.level().abs_diff(level));
        let Some((region, grid)) = nearest else { return f64::NAN };
        let at = region.column_and_row(self.land, at);
        let [columns, rows] = grid.size;
        let axis = |at: f64, count: usize| {
            let cell = at.floor().clamp(0.0, count.saturating_sub(2) as f64);
            let weights = spline_weights((at - cell).clamp(-0.5, 1.5));
            let sample = |k: usize| (cell as usize + k).saturating_sub(1).min(count - 1);
            [0, 1, 2, 3].map(|k| (sample(k), weights[k]))
        };
        let along = axis(at.x, columns);
        let row_m = |row: usize| {
            let row = &grid.heights_m[row * columns..][..columns];
            along.iter().map(|(column, weight)| weight * f64::from(row[*column])).sum::<f64>()
        };
        axis(at.y, rows).iter().map(|(row, weight)| weight * row_m(*row)).sum()
    }
}

fn spline_weights(f: f64) -> [f64; 4] {
    let e = 1.0 - f;
    [e * e * e, 4.0 + f * f * (3.0 * f - 6.0), 4.0 + e * e * (3.0 * e - 6.0), f * f * f].map(|weight| weight / 6.0)
}

/// Returns the place of the last sample on the grid.
fn last_sample(land: &Land) -> DVec2 {
    let finest = land.store.levels()[0];
    DVec2::new(f64::from(finest.width), f64::from(finest.height)) - DVec2::ONE
}

/// Returns the first and the last place on the grid under an area of a map; `None` if there is no land.
fn under(land: &Land, map: &Map, area_px: [DVec2; 2]) -> Option<[DVec2; 2]> {
    let size_px = area_px[1] - area_px[0];
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for (row, column) in (0..=SIDE_POINTS).flat_map(|row| (0..=SIDE_POINTS).map(move |column| (row, column))) {
        let part = DVec2::new(f64::from(column), f64::from(row)) / f64::from(SIDE_POINTS);
        let at = land.projection.grid_from_world(map.world_from_px(area_px[0] + size_px * part));
        if at.is_finite() {
            (low, high) = (low.min(at), high.max(at));
        }
    }
    let last = last_sample(land);
    // Between these points, the border of the map may be curved on the grid.
    let bent = (high - low) / f64::from(SIDE_POINTS);
    let [low, high] = [(low - bent).max(DVec2::ZERO), (high + bent).min(last)];
    high.cmpgt(low).all().then_some([low, high])
}
