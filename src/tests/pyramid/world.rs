//! A synthetic grid with all difficulties: odd sizes, no-data areas of all sizes, roughness, large heights.

use hachure::source::HeightGrid;
use hachure::source::georeference::{Crs, Georeference};

/// Returns 601 × 487 samples in UTM zone 10 north, 10 m apart.
#[allow(dead_code, reason = "not every test that shares this file needs it")]
pub(crate) fn grid() -> HeightGrid {
    rough(601, 487, true)
}

pub(crate) fn rough(width: u32, height: u32, voids: bool) -> HeightGrid {
    let mut seed = 12_345_u32;
    let mut heights_m = Vec::new();
    for row in 0..height {
        for column in 0..width {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (seed >> 8) as f32 / 16_777_216.0;
            let (x, y) = (column as f32, row as f32);
            let hills = 300.0 * (x * 0.021).sin() * (y * 0.017).cos() + 40.0 * (x * 0.13 + y * 0.09).sin();
            heights_m.push(2500.0 + hills + 6.0 * noise);
            let disc = (x - 300.0).powi(2) + (y - 200.0).powi(2) < 45.0 * 45.0;
            let corner = x + y < 60.0;
            let speck = seed >> 20 == 7;
            // This block is large enough for whole tiles to be no-data.
            let block = (380..600).contains(&column) && (260..487).contains(&row);
            if voids && (disc || corner || speck || block) {
                *heights_m.last_mut().unwrap() = f32::NAN;
            }
        }
    }
    let crs = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32610".into() };
    let crs_from_grid = [590_005.0, 10.0, 0.0, 5_199_995.0, 0.0, -10.0];
    HeightGrid {
        width,
        height,
        heights_m,
        georeference: Georeference { crs_from_grid, crs, geokeys: Default::default() },
    }
}
