//! Tests inks, haze and sky of the composite, without the paper's grain.

use glam::{DVec2, DVec3};
use hachure::composite::{self, PICTURE};
use hachure::frame::Light;
use hachure::lines::strokes::stroke::INK;
use hachure::lines::threshold::LINE;
use hachure::lines::tone::ink::TONE_INK;
use hachure::style::color::linear_from_srgb;
use hachure::style::{Color, Style};
use hachure::surface::POSITION;
use hachure::surface::cuts::CUT_INK;
use hachure::surface::rims::RIM;
use hachure::tones::TONE;
use hachure::tones::balance::MARKS;

use crate::tests::line_pictures::{Bench, SIZE_PX, bits, chance, inside, off, places, view};

/// Pictures that are composited.
struct Layers {
    position: Vec<[f32; 4]>,
    tone: Vec<[half::f16; 4]>,
    line: Vec<f32>,
    ink: Vec<[half::f16; 1]>,
    marks: Vec<f32>,
    rows: Vec<f32>,
    cuts: Vec<[half::f16; 4]>,
    water: Vec<f32>,
    heights: Vec<f32>,
    rims: Vec<[f32; 2]>,
    tone_lines: Vec<[half::f16; 4]>,
}

/// Returns a slope that recedes into the distance, sky above it, and some of every ink.
fn layers() -> Layers {
    let view = view();
    let part = |x: i64, y: i64, turn: i64, share: f64| (chance(x, y, turn) - 1.0 + share).max(0.0) / share;
    let position = places().map(|(x, y)| {
        let depth_m = if y < 12 { 0.0 } else { 40_000.0 / (y - 11) as f64 * (1.0 + 0.3 * chance(x / 9, y / 7, 1)) };
        let at = view.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) * depth_m;
        let [x, y, z] = at.as_vec3().to_array();
        [x, y, z, depth_m as f32]
    });
    Layers {
        position: position.collect(),
        tone: places().map(|(x, y)| std::array::from_fn(|i| half::f16::from_f64(chance(x, y, 2 + i as i64)))).collect(),
        line: places().map(|(x, y)| part(x, y, 7, 0.4) as f32).collect(),
        ink: places().map(|(x, y)| [half::f16::from_f64(part(x, y, 8, 0.2))]).collect(),
        marks: places().map(|(x, y)| part(x, y, 9, 0.5) as f32).collect(),
        rows: places().map(|(x, y)| part(x, y, 10, 0.3) as f32).collect(),
        cuts: places()
            .map(|(x, y)| std::array::from_fn(|family| half::f16::from_f64(part(x, y, 13 + family as i64, 0.2))))
            .collect(),
        water: places().map(|(x, y)| part(x, y, 11, 0.2) as f32).collect(),
        heights: places().map(|(x, y)| part(x, y, 12, 0.2) as f32).collect(),
        rims: places().map(|(x, y)| [part(x, y, 16, 0.2) as f32, 1.0]).collect(),
        tone_lines: places()
            .map(|(x, y)| std::array::from_fn(|kind| half::f16::from_f64(part(x, y, 17 + kind as i64, 0.2))))
            .collect(),
    }
}

fn linear(color: Color) -> DVec3 {
    DVec3::from_array(color.linear().map(f64::from))
}

fn mix(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a + (b - a) * t
}

/// The CPU twin of the composite. A pixel whose distance is more than `behind` times that of its nearest neighbour is
/// behind a line.
fn twin(layers: &Layers, style: &Style, light: &Light, behind: f64) -> Vec<f64> {
    let view = view();
    let lines = style.lines().unwrap();
    let at = |x: i64, y: i64| layers.position[inside(x, y)].map(f64::from);
    let away = |[x, y, z, _]: [f64; 4]| DVec3::new(x, y, z).length();
    let clearness = |distance_m: f64, reach: f64| (-(distance_m / (light.haze_m * reach)).powi(2)).exp();
    let haze = light.haze_srgb.map_or(linear(style.haze.color), |color| {
        DVec3::from_array(color.map(|value| f64::from(linear_from_srgb(value))))
    });
    let faintest = |faintest: f32, clear: f64| f64::from(faintest) + (1.0 - f64::from(faintest)) * clear;
    places()
        .flat_map(|(x, y)| {
            let i = inside(x, y);
            let here = at(x, y);
            let hatching = style.hatching().unwrap();
            let water = style.water().unwrap();
            let heights = style.height_lines().unwrap();
            let mut height_ink = f64::from(layers.heights[i]);
            let mut shore_ink = f64::from(layers.water[i]);
            let mut rim_ink = f64::from(layers.rims[i][0]);
            let tone_style = style.tone_lines().unwrap();
            let [mut dark, mut highlight, ..] = layers.tone_lines[i].map(half::f16::to_f64);
            // Families of cut lines cross each other.
            let (cuts, rows) = (style.cuts().unwrap(), style.rows().unwrap());
            let mut cut_ink = 1.0 - layers.cuts[i][..3].iter().map(|ink| 1.0 - ink.to_f64()).product::<f64>();
            let mut mark_ink = f64::from(layers.marks[i]);
            let mut row_ink = f64::from(layers.rows[i]);
            let mut color = if here[3] <= 0.0 {
                let up = view.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)).normalize().z;
                mix(linear(style.sky.horizon), linear(style.sky.zenith), (2.0 * up).clamp(0.0, 1.0))
            } else {
                let [red, green, blue, _] = layers.tone[i].map(half::f16::to_f64);
                let clear = clearness(away(here), 1.0);
                mark_ink *= faintest(hatching.faintest, clear);
                cut_ink *= faintest(cuts.faintest, clear);
                row_ink *= faintest(rows.faintest, clear);
                shore_ink *= faintest(water.faintest, clear);
                height_ink *= faintest(heights.faintest, clear);
                rim_ink *= faintest(style.rims.faintest, clear);
                let left = faintest(tone_style.faintest, clearness(away(here), tone_style.reach.into()));
                (dark, highlight) = (dark * left, highlight * left);
                mix(haze, DVec3::new(red, green, blue), faintest(style.haze.faintest_tone, clear))
            };
            color *= linear(style.paper.color);
            color = mix(color, linear(tone_style.highlight_ink), highlight);
            color = mix(color, linear(tone_style.ink), dark);
            color = mix(color, linear(heights.ink), height_ink);
            color = mix(color, linear(hatching.ink), mark_ink);
            color = mix(color, linear(cuts.ink), cut_ink);
            color = mix(color, linear(rows.ink), row_ink);
            color = mix(color, linear(water.ink), shore_ink);
            color = mix(color, linear(style.rim_ink()), rim_ink);
            let drawn = f64::from(layers.line[i]);
            if drawn > 0.0 {
                let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (x + i, y + j))).map(|(x, y)| at(x, y));
                let nearest = around.filter(|at| at[3] > 0.0).map(away).fold(1e30, f64::min);
                let clear = clearness(nearest, f64::from(lines.reach));
                let side = if here[3] <= 0.0 || away(here) > behind * nearest { clear } else { 1.0 };
                color = mix(color, linear(lines.ink), drawn * side * faintest(lines.faintest, clear));
            }
            color = mix(color, linear(style.strokes().unwrap().ink), layers.ink[i][0].to_f64());
            color.to_array()
        })
        .collect()
}

#[test]
fn the_composite_is_its_twin() {
    let Some(mut bench) = Bench::new() else { return };
    let mut style = Style::load("ink").unwrap();
    style.set_strokes(Style::load("pen").unwrap().strokes);
    let Style { hatching, rows, .. } = Style::load("hachures").unwrap();
    (style.hatching, style.rows, style.cuts) = (hatching, rows, Style::load("engraving").unwrap().cuts);
    style.rows_mut().unwrap().ink = Color::from_srgb([0.1, 0.4, 0.1]);
    style.cuts_mut().unwrap().ink = Color::from_srgb([0.1, 0.1, 0.5]);
    style.water = Style::parse(
        "water",
        "name = \"w\"\ndescription = \"\"\n[water]\nink = \"#103050\"\n[tone]\nkind = \"plain\"\n",
    )
    .unwrap()
    .water;
    style.set_tone_lines(Style::load("tone-lines").unwrap().tone_lines);
    style.set_height_lines(Style::load("pen").unwrap().height_lines);
    style.height_lines_mut().unwrap().ink = Color::from_srgb([0.5, 0.25, 0.12]);
    style.rims.ink = Some(Color::from_srgb([0.6, 0.1, 0.3]));
    style.paper.grain = 0.0;
    let layers = layers();
    let position = bench.picture(&POSITION, SIZE_PX, &layers.position);
    let tone = bench.picture(&TONE, SIZE_PX, &bits(&layers.tone));
    let line = bench.picture(&LINE, SIZE_PX, &layers.line);
    let ink = bench.picture(&INK, SIZE_PX, &bits(&layers.ink));
    let marks = bench.picture(&MARKS, SIZE_PX, &layers.marks);
    let rows = bench.picture(&MARKS, SIZE_PX, &layers.rows);
    let cuts = bench.picture(&CUT_INK, SIZE_PX, &bits(&layers.cuts));
    let water = bench.picture(&MARKS, SIZE_PX, &layers.water);
    let heights = bench.picture(&MARKS, SIZE_PX, &layers.heights);
    let rims = bench.picture(&RIM, SIZE_PX, &layers.rims);
    let tone_lines = bench.picture(&TONE_INK, SIZE_PX, &bits(&layers.tone_lines));
    for haze_srgb in [None, Some([0.7, 0.75, 0.9])] {
        let light = Light { to_sun: DVec3::Z, haze_m: 9_000.0, haze_srgb, focus: None };
        let picture = bench.out(&PICTURE);
        bench.run(|recorder| {
            let view = &recorder.uniform("view", &view().uniform(DVec3::ZERO));
            let (style, light, lines) = (&style, &light, style.lines());
            let (position, tone, line) = (&position, &tone, &line);
            let (ink, marks, rows, picture) = (&ink, &marks, &rows, &picture);
            let (cuts, water, heights, rims, tone_lines) = (&cuts, &water, &heights, &rims, &tone_lines);
            let inputs = composite::Inputs {
                view,
                style,
                lines,
                light,
                position,
                tone,
                sky: None,
                inks: composite::Inks { line, strokes: ink, marks, rows, cuts, water, heights, rims, tone_lines },
                is_sample: false,
                picture,
            };
            composite::run(recorder, &inputs);
        });
        let found: Vec<f64> =
            bench.halves(&picture).into_iter().flat_map(|[red, green, blue, _]| [red, green, blue]).collect();
        let differing = |behind: f64, light: &Light| off(&found, &twin(&layers, &style, light, behind), 2e-3);
        assert_eq!(differing(1.01, &light), 0);
        // Planted errors: lines that keep both of their sides in the distance, and nearer haze.
        assert!(differing(1e9, &light) > 50);
        assert!(differing(1.01, &Light { haze_m: 8_000.0, ..light }) > 500);
        // Planted errors: marks and rims that do not fade.
        let mut black = style.clone();
        black.hatching_mut().unwrap().faintest = 1.0;
        assert!(off(&found, &twin(&layers, &black, &light, 1.01), 2e-3) > 500);
        let mut black = style.clone();
        black.rims.faintest = 1.0;
        assert!(off(&found, &twin(&layers, &black, &light, 1.01), 2e-3) > 500);
        // Planted errors: rows in the ink of hatching, and cut lines that do not fade.
        let mut exchanged = style.clone();
        exchanged.rows_mut().unwrap().ink = style.hatching().unwrap().ink;
        assert!(off(&found, &twin(&layers, &exchanged, &light, 1.01), 2e-3) > 500);
        let mut black = style.clone();
        black.cuts_mut().unwrap().faintest = 1.0;
        assert!(off(&found, &twin(&layers, &black, &light, 1.01), 2e-3) > 500);
        // Planted error: lines from shading that do not fade.
        let mut black = style.clone();
        black.tone_lines_mut().unwrap().faintest = 1.0;
        assert!(off(&found, &twin(&layers, &black, &light, 1.01), 2e-3) > 500);
    }
}
