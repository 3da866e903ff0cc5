//! Draws the procedural world as shaded relief, for judging it by eye:
//!
//! ```text
//! cargo run --release --example procedural_shade -- out.png [seed] [sun azimuth °] [size] [spacing m] [crop]
//! ```
//!
//! With `crop`, it draws only the middle `crop` samples per side, enlarged to about 1,000 pixels. A second picture,
//! `out.profile.png`, shows rows of profiles behind one another, seen from the south.

use hachure::file::atomic;
use hachure::source::procedural;
use hachure::source::{HeightGrid, Silent};
use std::path::Path;
use std::time::Instant;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |place: usize, default: f64| -> anyhow::Result<f64> {
        Ok(arguments.get(place).map(|text| text.parse()).transpose()?.unwrap_or(default))
    };
    let path = arguments.first().map_or("procedural.png", String::as_str);
    let seed = number(1, 1.0)? as u32;
    let azimuth = number(2, 315.0)?.to_radians();
    let size = number(3, f64::from(procedural::SIZE_SAMPLES))? as u32;
    let spacing_m = number(4, procedural::SPACING_M)?;
    let started = Instant::now();
    let grid = procedural::generate_sized(seed, size, spacing_m, &Silent);
    println!("seed {seed}: {size}² in {:.2} s", started.elapsed().as_secs_f64());
    tell_statistics(&grid, spacing_m as f32);
    let crop = (number(5, f64::from(size))? as usize).min(size as usize);
    let zoom = (1000 / crop).max(1);
    write_grey(Path::new(path), crop * zoom, crop * zoom, &shade(&grid, spacing_m as f32, azimuth, crop, zoom))?;
    let (width, height, pixels) = profiles(&grid, spacing_m as f32);
    write_grey(&Path::new(path).with_extension("profile.png"), width, height, &pixels)
}

fn tell_statistics(grid: &HeightGrid, spacing_m: f32) {
    let (width, heights_m) = (grid.width as usize, &grid.heights_m);
    let mut slopes: Vec<f32> = (1..grid.height as usize - 1)
        .flat_map(|row| (1..width - 1).map(move |column| row * width + column))
        .map(|i| {
            let dx = heights_m[i + 1] - heights_m[i - 1];
            let dy = heights_m[i + width] - heights_m[i - width];
            (dx.hypot(dy) / (2.0 * spacing_m)).atan().to_degrees()
        })
        .collect();
    slopes.sort_by(f32::total_cmp);
    let at = |part: f32| slopes[((slopes.len() - 1) as f32 * part) as usize];
    let lowest = heights_m.iter().copied().fold(f32::INFINITY, f32::min);
    let highest = heights_m.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    println!(
        "heights {lowest:.0} to {highest:.0} m; slopes 10 %: {:.1}°, 50 %: {:.1}°, 90 %: {:.1}°, 99 %: {:.1}°, 100 %: {:.1}°",
        at(0.1),
        at(0.5),
        at(0.9),
        at(0.99),
        at(1.0)
    );
}

/// Lambertian shading with the sun at 40° and a little light from above.
fn shade(grid: &HeightGrid, spacing_m: f32, azimuth: f64, crop: usize, zoom: usize) -> Vec<u8> {
    let width = grid.width as usize;
    let start = (width - crop) / 2;
    let (sin, cos) = (azimuth.sin() as f32, azimuth.cos() as f32);
    let sun = [sin * 0.766, cos * 0.766, 0.643];
    let at = |column: usize, row: usize| grid.heights_m[row.min(width - 1) * width + column.min(width - 1)];
    let mut pixels = Vec::with_capacity(crop * crop * zoom * zoom);
    for y in 0..crop * zoom {
        for x in 0..crop * zoom {
            let (column, row) = (start + x / zoom, start + y / zoom);
            let east = (at(column + 1, row) - at(column.saturating_sub(1), row)) / (2.0 * spacing_m);
            let north = (at(column, row.saturating_sub(1)) - at(column, row + 1)) / (2.0 * spacing_m);
            let length = (1.0 + east * east + north * north).sqrt();
            let light = (-east * sun[0] - north * sun[1] + sun[2]).max(0.0) / length;
            pixels.push((255.0 * (0.12 / length + 0.95 * light).min(1.0)) as u8);
        }
    }
    pixels
}

/// Draws a perspective from above the southern edge: profiles from near to far, each hiding those behind it.
fn profiles(grid: &HeightGrid, spacing_m: f32) -> (usize, usize, Vec<u8>) {
    let (width, height) = (1600, 700);
    let size = grid.width as usize;
    let mut pixels = vec![255_u8; width * height];
    let mut skyline = vec![height as f32; width];
    let middle = size as f32 * 0.5;
    let eye_row = size as f32 * 0.98;
    let near = (size - 1) * size..size * size;
    let eye_m = grid.heights_m[near].iter().copied().fold(0.0_f32, f32::max).max(1500.0) + 500.0;
    let mut distance = 60.0_f32;
    while eye_row - distance > 1.0 {
        let row = (eye_row - distance) as usize;
        let fade = (distance / size as f32 * 170.0) as u8;
        for (x, top) in skyline.iter_mut().enumerate() {
            let column = middle + (x as f32 - width as f32 * 0.5) / width as f32 * distance * 1.1;
            if column < 1.0 || column >= size as f32 - 2.0 {
                continue;
            }
            let (c, f) = (column as usize, column.fract());
            let height_m = grid.heights_m[row * size + c] * (1.0 - f) + grid.heights_m[row * size + c + 1] * f;
            let y = 230.0 + (eye_m - height_m) / (distance * spacing_m) * width as f32 / 1.1;
            if y < *top - 0.02 {
                let slope = (grid.heights_m[row * size + c + 1] - grid.heights_m[row * size + c.saturating_sub(1)])
                    / (2.0 * spacing_m);
                let tone = (200.0 - 90.0 * slope).clamp(60.0, 250.0) as u8;
                for line in (y.max(0.0) as usize)..(top.min(height as f32 - 1.0) as usize).max(y.max(0.0) as usize) {
                    pixels[line * width + x] = tone.saturating_add(fade / 2);
                }
                *top = y;
            }
        }
        distance += (distance * 0.002).max(0.5);
    }
    (width, height, pixels)
}

fn write_grey(path: &Path, width: usize, height: usize, pixels: &[u8]) -> anyhow::Result<()> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header()?.write_image_data(pixels)?;
    atomic::write(path, &bytes)?;
    println!("{}", path.display());
    Ok(())
}
