//! Compares rows on real land, drawn as a map, with the slopes of single samples. This measurement is run by hand.

use glam::DVec2;
use hachure::style::Style;

use crate::tests::common::draw::still;
use crate::tests::common::{World, quantile};
use crate::tests::rows::{Drawn, marks_of};

const SIZE_PX: [u32; 2] = [1440, 1080];
const WINDOW_PX: usize = 64;

/// Returns the ranks of values, from 0.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    order.into_iter().zip(0..).for_each(|(at, rank)| ranks[at] = f64::from(rank));
    ranks
}

/// Returns Spearman's rank correlation coefficient.
fn spearman(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (ranks(a), ranks(b));
    let mean = 0.5 * (a.len() as f64 - 1.0);
    let sum = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - mean) * (y - mean)).sum::<f64>();
    sum(&a, &b) / (sum(&a, &a) * sum(&b, &b)).sqrt()
}

/// Run with `cargo test --release --lib tests::rows -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement that takes minutes"]
fn rows_of_real_land_follow_its_slopes() {
    // Tone depends only on the land's own slope; 45 degrees are black.
    let text = "name = \"rows\"\ndescription = \"\"\n[rows]\nspacing_px = 4.0\n[light]\nslope = 1.0\ndetail = 1.0\n\
                [tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0.0\nlightest = 1.0\n";
    let style = Style::parse("rows", text).unwrap();
    for file in ["mt_rainier_90m.tif", "N46E008_alps.tif", "mt_everest_90m.tif", "N49W123.tif"] {
        let Some(mut world) = World::filled(&format!("dem/geotiff/{file}"), 0.5) else { return };
        let view = still(world.pose("0,0,60000,0,-90,36"), SIZE_PX);
        let Drawn { marks, ink, places_m } = marks_of(&mut world, &style, &view);
        let (grid, mapping) = (world.grid.clone(), world.mapping.clone());
        let height_m = |at_m: DVec2| {
            let at = mapping.grid_from_world(at_m);
            let last = DVec2::new(f64::from(grid.width) - 1.001, f64::from(grid.height) - 1.001);
            let at = at.clamp(DVec2::ZERO, last);
            let (cell, f) = (at.floor(), at.fract());
            let sample = |x: f64, y: f64| {
                f64::from(grid.heights_m[(cell.y + y) as usize * grid.width as usize + (cell.x + x) as usize])
            };
            let row = |y: f64| sample(0.0, y) * (1.0 - f.x) + sample(1.0, y) * f.x;
            row(0.0) * (1.0 - f.y) + row(1.0) * f.y
        };
        // The gradient is over one and a half samples of the land.
        let gradient = |at_m: DVec2| {
            let step_m = 70.0;
            let by = |step: DVec2| (height_m(at_m + step * step_m) - height_m(at_m - step * step_m)) / (2.0 * step_m);
            DVec2::new(by(DVec2::X), by(DVec2::Y))
        };
        let mut angles: Vec<f64> = Vec::new();
        for mark in &marks {
            for (pair, px) in mark.place_m.windows(2).zip(mark.px.windows(2)) {
                let slope = gradient((pair[0] + pair[1]).truncate() * 0.5);
                if px[0].distance(px[1]) > 0.5 && slope.length() > 0.1 {
                    let angle = (pair[1] - pair[0]).truncate().angle_to(slope).to_degrees().abs();
                    angles.push(angle.min(180.0 - angle));
                }
            }
        }
        // Mean ink and mean slope in windows.
        let (mut inks, mut slopes) = (Vec::new(), Vec::new());
        for top in (0..SIZE_PX[1] as usize - WINDOW_PX).step_by(WINDOW_PX) {
            for left in (0..SIZE_PX[0] as usize - WINDOW_PX).step_by(WINDOW_PX) {
                let (mut dark, mut steep) = (0.0, 0.0);
                for (x, y) in (0..WINDOW_PX * WINDOW_PX).map(|i| (left + i % WINDOW_PX, top + i / WINDOW_PX)) {
                    let pixel = y * SIZE_PX[0] as usize + x;
                    dark += ink[pixel];
                    if let Some(place_m) = places_m[pixel].filter(|_| x % 4 == 0 && y % 4 == 0) {
                        steep += (gradient(place_m.truncate()).length().atan().to_degrees() / 45.0).min(1.0);
                    }
                }
                inks.push(dark / (WINDOW_PX * WINDOW_PX) as f64);
                slopes.push(steep / (WINDOW_PX * WINDOW_PX / 16) as f64);
            }
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        println!(
            "{file}: {} marks, off the slope by {:.1} degrees at the median, {:.1} at 90 %; ink against slope: Spearman \
             {:.3}; ink {:.3}, requested {:.3}",
            marks.len(),
            quantile(&mut angles, 0.5),
            quantile(&mut angles, 0.9),
            spearman(&inks, &slopes),
            mean(&inks),
            mean(&slopes)
        );
        // Planted: windows in another order have no correlation.
        slopes.rotate_right(7);
        assert!(spearman(&inks, &slopes) < 0.6);
    }
}
