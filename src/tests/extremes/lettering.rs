//! The title block of pictures of every size, resolution and scale, and pens of extreme width.

use glam::DVec2;
use hachure::lettering::ink::{PenStroke, cover};
use hachure::picture::Band;
use hachure::picture::title::{MapScale, Words, block, foot_px};
use hachure::style::{Paper, Style};

/// Returns the words of a title block at several scales.
fn words() -> Vec<Words> {
    let scale = |m_per_px: f64, mm_per_px: Option<f64>, true_north_rad: Option<f64>| {
        Some(MapScale { m_per_px, mm_per_px, denominator: None, true_north_rad })
    };
    let long = "Großglockner 山 🖋 ".repeat(200);
    let texts = [(String::new(), String::new()), ("Tödi".to_owned(), "3614 m".to_owned()), (long.clone(), long)];
    let scales = [
        None,
        scale(1e-9, None, None),
        scale(1e-9, Some(1e-3), Some(0.0)),
        scale(30.0, Some(0.25), Some(-std::f64::consts::PI)),
        scale(1e8, Some(25.4), Some(std::f64::consts::PI)),
        scale(1e8, Some(2.54e-3), None),
    ];
    let all = texts.into_iter().flat_map(|(title, below)| {
        let credits = below.clone();
        scales.map(|scale| Words {
            title: title.clone(),
            below: below.clone(),
            credits: credits.clone(),
            scale,
            legend_rows: 1,
        })
    });
    all.collect()
}

#[test]
fn title_blocks_are_finite() {
    let plain = Style::load("plain").unwrap();
    let mut cases = 0;
    for words in words() {
        for size_px in [[1, 1], [64, 48], [3, 2000], [1 << 20, 60]] {
            // The pixels of a style are those of 96 dots per inch.
            for px in [1.0 / 96.0, 1.0, 10_000.0 / 96.0] {
                for margin_px in [0.0, 1000.0] {
                    let bare = Paper { margin_px, border_px: 0.0, foot_px: 0.0, ..plain.paper.clone() };
                    let paper = Paper { foot_px: foot_px(&bare, true, 1, px), ..bare };
                    let block = block(&words, size_px, &paper, paper.border, px);
                    let points = block.strokes.iter().flat_map(|stroke| &stroke.points);
                    let is_finite = points.clone().all(|point| point.is_finite());
                    let is_finite = is_finite && block.areas.iter().all(|area| area.curves.is_finite());
                    let widths = block.strokes.iter().all(|stroke| stroke.width_px.is_finite());
                    assert!(is_finite && widths, "{words:?}, {size_px:?}, {px} px per px, margin {margin_px}");
                    // The rows in the middle of the block.
                    let [width, height] = size_px;
                    let middle = f64::from(height) - f64::from(paper.margin_px) - 0.5 * f64::from(paper.foot_px);
                    let width = width.min(500) as usize;
                    let mut band = Band {
                        first_row: middle.max(0.0) as u32,
                        rows: 2,
                        picture: vec![[1.0; 4]; 2 * width],
                        planes: Vec::new(),
                    };
                    block.draw(&mut band, width);
                    let holds = |texel: &[f32; 4]| texel.iter().all(|value| (0.0..=1.0).contains(value));
                    assert!(band.picture.iter().all(holds), "{words:?}, {size_px:?}, {px} px per px");
                    cases += 1;
                }
            }
        }
    }
    println!("{cases} title blocks");
}

#[test]
fn pens_of_every_width_cover_between_nothing_and_all() {
    let mut most = 0.0_f32;
    for width_px in [0.0, 1e-300, 0.4, 7.0, 1e9] {
        for end in [DVec2::ZERO, DVec2::new(1e-200, 0.0), DVec2::new(30.0, 7.0), DVec2::new(-1e8, 1e8)] {
            for origin in [DVec2::ZERO, DVec2::splat(1e7), DVec2::splat(-1e7)] {
                let stroke = PenStroke::line(origin, origin + end, width_px);
                let mut covered = [0.0; 64];
                cover(std::slice::from_ref(&stroke), origin.x - 20.0, origin.y, &mut covered);
                let holds = covered.iter().all(|part| (0.0..=1.0).contains(part));
                assert!(holds, "{width_px} px from {origin} by {end}: {covered:?}");
                most = covered.iter().copied().fold(most, f32::max);
            }
        }
    }
    assert!(most > 0.99, "some pens cover pixels");
    // Planted: a point that is not finite.
    let stroke = PenStroke { points: vec![DVec2::new(f64::NAN, 0.0)], width_px: 1.0 };
    let mut covered = [0.0; 4];
    cover(&[stroke], 0.0, 0.0, &mut covered);
    assert_eq!(covered, [0.0; 4], "it covers nothing");
}
