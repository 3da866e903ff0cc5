//! The order of levels.

use super::Contour;

/// The different levels of contour lines, in order: heights, then depths.
pub(super) struct Ranks(Vec<(bool, f64)>);

impl Ranks {
    pub(super) fn new<'a>(contours: impl Iterator<Item = &'a Contour<'a>>) -> Self {
        let mut levels: Vec<(bool, f64)> = contours.map(|contour| (contour.is_depth, contour.level_m + 0.0)).collect();
        levels.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        levels.dedup();
        // Depths and heights are not neighbours in a ladder.
        if let Some(first) = levels.iter().position(|level| level.0) {
            levels.insert(first, (false, f64::INFINITY));
        }
        Self(levels)
    }

    /// Returns the number of different levels.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns the position of the level of a contour line in the order.
    pub(super) fn of(&self, contour: &Contour<'_>) -> usize {
        let own = (contour.is_depth, contour.level_m + 0.0);
        self.0.partition_point(|level| level.0.cmp(&own.0).then(level.1.total_cmp(&own.1)).is_lt())
    }
}
