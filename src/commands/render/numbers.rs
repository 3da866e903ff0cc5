//! Numbers on the contour lines of a map that `hachure render` draws.

use anyhow::Context;

use super::Job;
use crate::picture::contour_numbers::{Inputs, Numbers, numbers};

impl Job<'_> {
    /// Returns the numbers on contour lines, if a map is drawn in a style that has them.
    ///
    /// # Errors
    /// Fails if a tile cannot be read.
    pub(super) fn contour_numbers(&self) -> anyhow::Result<Option<Numbers>> {
        let Some(placed) = &self.map else { return Ok(None) };
        let (surfaces, style, px) = (&self.world.surfaces, &self.style, self.args.px_per_style_px());
        numbers(&Inputs { map: &placed.map, surfaces, style, px }).context("cannot read the heights of contour lines")
    }
}
