//! The surface of decision 6, computed in f64 from the samples of a grid: Keys' bicubic convolution with a = −1/2,
//! written from its kernel and independent of the program's weights.

use glam::{DVec2, DVec3};
use hachure::source::{HeightGrid, WorldMapping};

/// The surface between the samples of a grid, in world coordinates.
pub(crate) struct Field<'a> {
    pub grid: &'a HeightGrid,
    pub mapping: &'a WorldMapping,
}

/// Returns the kernel of Keys 1981, Eq. 8, for a = −1/2: 1 at 0, 0 at the other integers.
fn kernel(x: f64) -> f64 {
    let a = -0.5;
    let x = x.abs();
    if x < 1.0 {
        (a + 2.0) * x.powi(3) - (a + 3.0) * x.powi(2) + 1.0
    } else if x < 2.0 {
        a * x.powi(3) - 5.0 * a * x.powi(2) + 8.0 * a * x - 4.0 * a
    } else {
        0.0
    }
}

impl Field<'_> {
    /// Returns the height at a grid coordinate; `None` within `margin` cells of no-data or of the border.
    fn on_grid_m(&self, c: DVec2, margin: i64) -> Option<f64> {
        let (column, row) = (c.x.floor() as i64, c.y.floor() as i64);
        let at = |column: i64, row: i64| {
            let inside =
                (0..i64::from(self.grid.width)).contains(&column) && (0..i64::from(self.grid.height)).contains(&row);
            let height = if inside {
                self.grid.heights_m[(row * i64::from(self.grid.width) + column) as usize]
            } else {
                f32::NAN
            };
            height.is_finite().then_some(f64::from(height))
        };
        let reach = margin.max(1);
        let mut sum = 0.0;
        for row in row - reach..=row + 1 + reach {
            for column in column - reach..=column + 1 + reach {
                let weight = kernel(c.x - column as f64) * kernel(c.y - row as f64);
                sum += weight * at(column, row)?;
            }
        }
        Some(sum)
    }

    /// Returns the height at a position in the world; `None` within three cells of no-data or of the border.
    pub(crate) fn height_m(&self, place_m: DVec2) -> Option<f64> {
        self.on_grid_m(self.mapping.grid_from_world(place_m), 3)
    }

    /// Returns the unit normal at a position in the world, by central differences over a thousandth of a sample.
    pub(crate) fn normal(&self, place_m: DVec2, spacing_m: f64) -> Option<DVec3> {
        let step = 1e-3 * spacing_m;
        let slope = |way: DVec2| {
            let (after, before) = (self.height_m(place_m + way * step)?, self.height_m(place_m - way * step)?);
            Some((after - before) / (2.0 * step))
        };
        Some(DVec3::new(-slope(DVec2::X)?, -slope(DVec2::Y)?, 1.0).normalize())
    }
}
