//! Tests that strokes have as much ink as pressure requests, on all levels and at all widths.

use hachure::lines::strokes::texture::{Brush, Level, grow};

use crate::tests::stroke_texture::recipes;

const PRESSURES: [f32; 6] = [0.1, 0.2, 0.4, 0.6, 0.8, 1.0];

/// Returns the ink that a rule with uniformly distributed thresholds takes, by integration.
fn promised(brush: &Brush, pressure: f32) -> f64 {
    let ink = |i: u16| f64::from(brush.ink([1.0, (f32::from(i) + 0.5) / 4096.0], pressure, 0.0, 1e3));
    (0..4096).map(ink).sum::<f64>() / 4096.0
}

#[test]
fn ink_grows_with_pressure_as_promised() {
    for (name, recipe) in recipes() {
        let (level, brush) = (&grow(&recipe)[0], Brush::of(&recipe));
        let density = f64::from(recipe.pigment.density);
        assert_eq!(level.mean_ink(&brush, 0.0), 0.0, "{name}");
        let means: Vec<f64> = (0..=20).map(|i| level.mean_ink(&brush, i as f32 / 20.0)).collect();
        assert!(means.is_sorted(), "{name}: {means:?}");
        for pressure in PRESSURES {
            let (mean, asked) = (level.mean_ink(&brush, pressure), density * promised(&brush, pressure));
            assert!((mean - asked).abs() < 0.01, "{name} at {pressure}: mean ink {mean}, expected {asked}");
        }
        let full = level.mean_ink(&brush, 1.0);
        let bounds = match name {
            "pen" | "brush" => 0.95..=1.0,
            "dry-ink" => 0.6..=0.8,
            "charcoal" => 0.85..=0.95,
            _ => 0.85..=0.92,
        };
        println!("{name}: {:.3} at 0.2, {:.3} at 0.5, {full:.3} at 1", means[4], means[10]);
        assert!(bounds.contains(&full), "{name}: {full}");
        // Planted: unequalised thresholds, which crowd around their middle.
        let crowded = level.texels.iter().map(|[pigment, threshold]| [*pigment, 64 + threshold / 2]);
        let crowded = Level { size_px: level.size_px, texels: crowded.collect() };
        let is_far =
            |pressure: &f32| (crowded.mean_ink(&brush, *pressure) - density * promised(&brush, *pressure)).abs() > 0.01;
        assert!(PRESSURES.iter().any(is_far), "{name}");
    }
}

/// Returns the next level by averaging 2 × 2 texels and nothing else.
fn averaged(level: &Level) -> Level {
    let size_px = level.size_px.map(|side| side / 2);
    let width = level.size_px[0] as usize;
    let texel = |x: usize, y: usize| {
        let first = 2 * y * width + 2 * x;
        let places = [first, first + 1, first + width, first + width + 1];
        [0, 1].map(|channel| {
            (places.iter().map(|place| u32::from(level.texels[*place][channel])).sum::<u32>() as f32 / 4.0) as u8
        })
    };
    let places = (0..size_px[1] as usize).flat_map(|y| (0..size_px[0] as usize).map(move |x| (x, y)));
    Level { size_px, texels: places.map(|(x, y)| texel(x, y)).collect() }
}

/// Returns the largest relative difference between a level's mean ink and that of the finest level.
fn loss(levels: &[Level], brush: &Brush) -> f64 {
    let mean = |level: &Level, pressure: f32| level.mean_ink(brush, pressure) / levels[0].mean_ink(brush, pressure);
    let losses = levels.iter().flat_map(|level| PRESSURES.iter().map(|pressure| (mean(level, *pressure) - 1.0).abs()));
    losses.fold(0.0, f64::max)
}

#[test]
fn levels_keep_the_ink() {
    for (name, recipe) in recipes() {
        let begin = std::time::Instant::now();
        let (levels, brush) = (grow(&recipe), Brush::of(&recipe));
        println!("{name}: grown in {:.1} ms", begin.elapsed().as_secs_f64() * 1e3);
        assert_eq!(levels.len(), 6, "{name}");
        let kept = loss(&levels, &brush);
        println!("{name}: levels differ by {kept:.4} at most");
        assert!(kept < 0.02, "{name}: {kept}");
        // Planted: averaging alone, as for colour textures. The middle of a pen stroke takes ink whatever the threshold
        // is.
        let mut plain = vec![levels[0].clone()];
        for i in 0..5 {
            plain.push(averaged(&plain[i]));
        }
        let lost = loss(&plain, &brush);
        println!("{name}: by {lost:.4} if only averaged");
        assert!(name == "pen" || lost > 0.02, "{name}: {lost}");
    }
}

/// Returns the ink of a stroke per pixel of its width.
fn ink_of_stroke(level: &Level, brush: &Brush, width_px: f32, pressure: f32) -> f64 {
    let [width, height] = level.size_px.map(|side| side as i64);
    let half_width_px = 0.5 * width_px;
    let rows = half_width_px.ceil() as i64 + 1;
    let mut ink = 0.0;
    for (x, row) in (0..width).flat_map(|x| (-rows..rows).map(move |row| (x, row))) {
        let across_px = row as f32 + 0.5;
        let [u, v] = brush.uv(x as f32 + 0.5, across_px, half_width_px, 1);
        let place = [u * width as f32, v * height as f32].map(|at| at.floor() as i64);
        let texel = level.texels[(place[1].rem_euclid(height) * width + place[0].rem_euclid(width)) as usize];
        let covered = (half_width_px - across_px.abs() + 0.5).clamp(0.0, 1.0);
        let texel = texel.map(|byte| f32::from(byte) / 255.0);
        ink += f64::from(covered * brush.ink(texel, pressure, across_px.abs(), half_width_px));
    }
    ink / (width as f64 * f64::from(width_px))
}

#[test]
fn thin_strokes_are_not_washed_out() {
    for (name, recipe) in recipes() {
        let (level, brush) = (&grow(&recipe)[0], Brush::of(&recipe));
        for pressure in [0.4, 0.7, 1.0] {
            let inks = [2.0, 4.0, 8.0, 16.0, 32.0].map(|width_px| ink_of_stroke(level, &brush, width_px, pressure));
            println!("{name} at {pressure}: {inks:.3?} for 2 to 32 px");
            assert!(inks[0] >= 0.6 * inks[4], "{name} at {pressure}: {inks:?}");
        }
        // Planted: a border as wide in thin strokes as in wide ones.
        let wide = Brush { border_px: 8.0, border_part: 8.0, border_pressure: 0.0, ..brush };
        let [thin, thick] = [2.0, 32.0].map(|width_px| ink_of_stroke(level, &wide, width_px, 0.4));
        assert!(name == "pen" || thin < 0.6 * thick, "{name}: {thin}, {thick}");
    }
}
