//! An array of heights, here computed by a formula, becomes a drawing without a file of heights:
//!
//! ```text
//! cargo run --release --example heights_in_memory -- island.png
//! ```

use std::path::Path;

use anyhow::Context;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::picture::{self, PictureRequest};
use hachure::style::Style;
use hachure::world::OpenWorld;
use hachure::world::TerrainOptions;

/// Samples per row, rows, and metres between samples.
const SIZE: [u32; 2] = [900, 700];
const SPACING_M: f64 = 10.0;

/// The height in metres of an island with a crater and radial valleys, `east_m` and `north_m` from its middle.
fn height_m(east_m: f64, north_m: f64) -> f64 {
    let (radius_m, angle) = (east_m.hypot(north_m), north_m.atan2(east_m));
    let cone = 1400.0 * (-radius_m / 1600.0).exp();
    let crater = 700.0 * (-(radius_m / 300.0).powi(2)).exp();
    let depth = 0.16 * (radius_m / 900.0).min(1.0);
    let valleys = (9.0 * angle + 0.0022 * radius_m).sin() + 0.5 * (23.0 * angle - 0.004 * radius_m).cos();
    (cone * (1.0 + depth * valleys) - crater - 60.0).max(0.0)
}

fn main() -> anyhow::Result<()> {
    let png = std::env::args().nth(1).context("usage: heights_in_memory OUT.png")?;
    let [width, height] = SIZE;
    // Row by row from north to south, each row from west to east.
    let mut heights_m = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let east_m = (f64::from(column) - 0.5 * f64::from(width - 1)) * SPACING_M;
            let north_m = (0.5 * f64::from(height - 1) - f64::from(row)) * SPACING_M;
            heights_m.push(height_m(east_m, north_m) as f32);
        }
    }
    let gpu = Gpu::open(&AdapterWish::Best)?;
    let mut world = OpenWorld::from_heights(&gpu, heights_m, SIZE, SPACING_M, TerrainOptions::default())?;
    let style = Style::load("ink")?;
    let eye = world.pose(&world.default_camera());
    let request = PictureRequest::still(eye, [1600, 900], &style, world.light());
    let report = picture::write_png(&gpu, &mut world.surfaces, &request, Path::new(&png))?;
    println!("{png}: {} triangles in {:.0} ms", report.triangles, report.wall_ms);
    Ok(())
}
