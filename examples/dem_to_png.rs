//! Draws a height file, using the library alone:
//!
//! ```text
//! cargo run --release --example dem_to_png -- mountain.tif mountain.png
//! ```

use std::path::Path;

use anyhow::Context;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::picture::{self, PictureRequest};
use hachure::style::Style;
use hachure::world::OpenWorld;
use hachure::world::TerrainOptions;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let (dem, png) = arguments.next().zip(arguments.next()).context("usage: dem_to_png DEM OUT.png")?;
    let gpu = Gpu::open(&AdapterWish::Best)?;
    let mut world = OpenWorld::open(&gpu, Some(&dem), TerrainOptions::default())?;
    let style = Style::load("ink")?;
    let eye = world.pose(&world.default_camera());
    let request = PictureRequest::still(eye, [1600, 900], &style, world.light());
    let report = picture::write_png(&gpu, &mut world.surfaces, &request, Path::new(&png))?;
    println!("{png}: {} triangles in {:.0} ms", report.triangles, report.wall_ms);
    Ok(())
}
