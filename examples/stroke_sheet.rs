//! Draws a page of stroke textures as they take ink: for each texture, strokes 2, 4, 8, 16 and 32 px wide, from light
//! pressure on the left to full pressure on the right; the last column swells and ends. It uses the CPU twin of the ink
//! rule, so it needs no GPU.
//!
//! `cargo run --release --example stroke_sheet -- sheet.png [RECIPE …]`: a recipe is the name of a texture or a file
//! (`.toml`).

use std::path::Path;

use anyhow::Context;
use hachure::internals::texture::{Brush, Level, grow};
use hachure::style::texture::{self, Recipe};

const WIDTHS_PX: [f32; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
const PRESSURES: [f32; 5] = [0.2, 0.4, 0.6, 0.8, 1.0];
const COLUMN_PX: f32 = 200.0;
const SHEET_PX: usize = 1280;
/// Gap between strokes.
const GAP_PX: f32 = 14.0;

/// Returns pigment and threshold at `uv`, interpolated between texels; the texture repeats.
fn sample(level: &Level, uv: [f32; 2]) -> [f32; 2] {
    let [width, height] = level.size_px;
    let at = [uv[0] * width as f32 - 0.5, uv[1] * height as f32 - 0.5];
    let whole = at.map(f32::floor);
    let part = [at[0] - whole[0], at[1] - whole[1]];
    let texel = |dx: i64, dy: i64| {
        let x = (whole[0] as i64 + dx).rem_euclid(width.into());
        let y = (whole[1] as i64 + dy).rem_euclid(height.into());
        level.texels[(y * i64::from(width) + x) as usize].map(|byte| f32::from(byte) / 255.0)
    };
    let mix = |a: [f32; 2], b: [f32; 2], t: f32| [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
    mix(mix(texel(0, 0), texel(1, 0), part[0]), mix(texel(0, 1), texel(1, 1), part[0]), part[1])
}

/// Returns the ink at a point of a stroke. Pressure depends on the column; the last column swells and ends.
fn ink(brush: &Brush, level: &Level, along_px: f32, across_px: f32, half_width_px: f32, id: u32) -> f32 {
    let column = (along_px / COLUMN_PX) as usize;
    let within_px = along_px - column as f32 * COLUMN_PX;
    let (length_px, pressure) = match PRESSURES.get(column) {
        Some(pressure) => (COLUMN_PX - 20.0, *pressure),
        None => (COLUMN_PX, (within_px.min(COLUMN_PX - within_px) / 90.0).clamp(0.0, 1.0)),
    };
    let half_width_px = match PRESSURES.get(column) {
        Some(_) => half_width_px,
        None => (half_width_px * (0.35 + 0.65 * pressure.sqrt())).max(0.4),
    };
    let end = (within_px + 0.5).min(length_px - within_px + 0.5).clamp(0.0, 1.0);
    let covered = (half_width_px - across_px.abs() + 0.5).clamp(0.0, 1.0);
    let texel = sample(level, brush.uv(along_px, across_px, half_width_px, id));
    end * covered * brush.ink(texel, pressure, across_px.abs(), half_width_px)
}

/// Returns the sRGB colour of ink on paper, mixed in linear light as the program does.
fn on_paper(ink: f32) -> [u8; 3] {
    [(0.965, 0.007), (0.92, 0.006), (0.82, 0.005)].map(|(paper, black): (f32, f32)| {
        let linear = paper + (black - paper) * ink;
        let srgb = if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        (srgb * 255.0).round() as u8
    })
}

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().context("usage: stroke_sheet OUT.png [RECIPE …]")?;
    let mut recipes: Vec<String> = arguments.collect();
    if recipes.is_empty() {
        recipes = texture::names().into_iter().map(str::to_owned).collect();
    }
    let mut sheet = Vec::new();
    let mut id = 0;
    for name in &recipes {
        let recipe = Recipe::load(name, Path::new(""))?;
        let (levels, brush) = (grow(&recipe), Brush::of(&recipe));
        for width_px in WIDTHS_PX {
            id += 1;
            let rows = (width_px + GAP_PX) as usize;
            for (row, column) in (0..rows).flat_map(|row| (0..SHEET_PX).map(move |column| (row, column))) {
                let along_px = column as f32 + 0.5 - 30.0;
                let across_px = row as f32 + 0.5 - 0.5 * rows as f32;
                let is_on = (0.0..COLUMN_PX * 6.0).contains(&along_px);
                let ink = if is_on { ink(&brush, &levels[0], along_px, across_px, 0.5 * width_px, id) } else { 0.0 };
                sheet.extend(on_paper(ink));
            }
        }
    }
    let rows = sheet.len() / 3 / SHEET_PX;
    let mut file = hachure::file::atomic::AtomicFile::create(Path::new(&out))?;
    {
        let mut encoder = png::Encoder::new(file.writer(), SHEET_PX as u32, rows as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header()?.write_image_data(&sheet)?;
    }
    file.commit()?;
    Ok(())
}
