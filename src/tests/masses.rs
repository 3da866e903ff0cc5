//! Tests the masses of stepped tones: none is small, their borders are short and lie on ridges, a picture in parts has
//! those of the whole, and a flight does not make them flicker more.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{draw, halves, places_m, still, tones_in_parts};
use common::{World, grid_of, random, rough_height_m};
use hachure::frame::{Light, Renderer};
use hachure::picture::{PartRule, PictureRequest};
use hachure::scene::Sun;
use hachure::style::Style;
use hachure::tones::TONE;
use hachure::tones::masses::{MassCell, Masses};

const SIZE_PX: [u32; 2] = [480, 270];
/// Keys of `[light]` and `[tone]` of land in planes with edited masses, of the form alone, and of planes alone.
const EDITED: [&str; 2] = ["form_px = 6\nplanes_px = 48", "smallest_share = 0.015"];
/// The light of the presets with stepped colours.
const OF_PRESETS: [&str; 2] =
    ["form_px = 6\nplanes_px = 28\nshadow = 0.7\nocclusion = 0.5\ncrests = 0.5\nturn_deg = 20", EDITED[1]];
const OF_FORM: [&str; 2] = ["form_px = 14\ndetail = 0.15", ""];
const PLANES: [&str; 2] = [EDITED[0], ""];

/// Returns a style of three grey steps without haze.
fn style([light, tone]: [&str; 2]) -> Style {
    let text = format!(
        "name = \"masses\"\ndescription = \"\"\n[light]\nwrap = 0.35\n{light}\n[tone]\nkind = \"toon\"\nsteps = 3\n\
         darkest = 0\nfit = true\nwhite_share = 0.35\ndark_share = 0.2\nrecede = 0\n{tone}\n\
         [haze]\nfaintest_tone = 1.0\n"
    );
    Style::parse("masses", &text).unwrap()
}

fn light() -> Light {
    let to_sun = Sun { azimuth_deg: 300.0, elevation_deg: 35.0 }.direction();
    Light { to_sun, haze_m: 1e12, haze_srgb: None, focus: None }
}

fn rough() -> Option<World> {
    World::new(grid_of(1025, 1025, 30.0, rough_height_m), 1.0)
}

/// Returns the steps of a frame by pixel, 0 to 2; `None` in the sky.
fn steps(world: &mut World, renderer: &mut Renderer, style: &Style, camera: &str) -> Vec<Option<u8>> {
    let pose = world.pose(camera);
    draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, SIZE_PX), style, &light());
    let places = places_m(&world.gpu, renderer, pose.position_m);
    let tones = halves(&world.gpu, renderer.target(&TONE).unwrap());
    tones.iter().zip(places).map(|([.., tone], place)| place.map(|_| (2.0 * tone).round() as u8)).collect()
}

/// The masses of a picture.
struct Measured {
    /// Share of the picture in masses of less than 1.2 % of it that land of another step borders on.
    small: f64,
    /// Number of neighbouring pixels of different steps.
    border: usize,
}

fn measured(steps: &[Option<u8>]) -> Measured {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let neighbours = |i: usize| {
        let (x, y) = (i % width, i / width);
        let left = (x > 0).then(|| i - 1);
        let above = (y > 0).then(|| i - width);
        let right = (x + 1 < width).then_some(i + 1);
        let below = (y + 1 < height).then_some(i + width);
        [left, above, right, below].into_iter().flatten().filter(|other| steps[*other].is_some())
    };
    let (mut seen, mut small, mut border) = (vec![false; steps.len()], 0, 0);
    for first in (0..steps.len()).filter(|i| steps[*i].is_some()) {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let (mut area, mut own_border, mut next) = (0, 0, vec![first]);
        while let Some(i) = next.pop() {
            area += 1;
            for other in neighbours(i) {
                if steps[other] != steps[i] {
                    own_border += 1;
                } else if !std::mem::replace(&mut seen[other], true) {
                    next.push(other);
                }
            }
        }
        border += own_border;
        small += if own_border > 0 && (area as f64) < 0.012 * steps.len() as f64 { area } else { 0 };
    }
    Measured { small: small as f64 / steps.len() as f64, border: border / 2 }
}

#[test]
fn no_mass_is_small_and_borders_are_short() {
    let Some(mut world) = rough() else { return };
    let mut planted = 0.0_f64;
    let cameras = ["0,-9000,+900,10,-14,50", "3000,2000,+1500,200,-20,50", "-6000,4000,+2500,120,-18,50"];
    for camera in cameras.into_iter().take(if common::full() { 3 } else { 1 }) {
        let [edited, presets, of_form, planes] = [EDITED, OF_PRESETS, OF_FORM, PLANES].map(|keys| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            measured(&steps(&mut world, &mut renderer, &style(keys), camera))
        });
        println!(
            "{camera}: small masses cover {:.4} of the picture, with the form alone {:.4}, with planes alone {:.4}; \
             borders of {} px, {} px, {} px",
            edited.small, of_form.small, planes.small, edited.border, of_form.border, planes.border
        );
        println!("light of presets: small masses cover {:.4}; borders of {} px", presets.small, presets.border);
        // A mass that hangs together by one cell may be two of pixels.
        for drawn in [&edited, &presets] {
            assert!(drawn.small < 0.003, "small masses cover {}", drawn.small);
            assert!(drawn.border as f64 <= 0.6 * of_form.border as f64);
        }
        planted = planted.max(planes.small);
    }
    // Planted error: masses that are not edited.
    assert!(planted > 0.01, "{planted}");
}

/// Tests a blunt, rough ridge from above, of which the style wants more than one side dark.
#[test]
fn borders_lie_on_ridges() {
    let roof = |x: f64, y: f64| {
        let noise_m = |size_m: f64| random((x / size_m).floor() as i64, (y / size_m).floor() as i64);
        -0.5 * x.hypot(700.0) + 10.0 * noise_m(30.0) + 20.0 * noise_m(120.0) + 60.0 * noise_m(480.0)
    };
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, roof), 1.0) else { return };
    let two = |keys: [&str; 2]| {
        let mut style = style(keys);
        let crate::style::Tone::Toon(toon) = &mut style.tone else { unreachable!("the tone of this style") };
        (toon.steps, toon.dark_share) = (2, 0.57);
        style
    };
    let width = SIZE_PX[0] as usize;
    let mut off = |keys| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let steps = steps(&mut world, &mut renderer, &two(keys), "0,0,+6000,0,-90,40");
        // Where the step changes along each row.
        assert!(steps.iter().all(Option::is_some));
        let borders = steps.chunks(width).flat_map(|row| {
            (1..width).filter(|x| row[*x] != row[x - 1]).map(|x| (x as f64 - 0.5 * width as f64).abs())
        });
        let mut borders: Vec<f64> = borders.collect();
        assert!(borders.len() >= SIZE_PX[1] as usize / 2, "{} borders", borders.len());
        common::quantile(&mut borders, 0.9)
    };
    let [edited, of_form] = [off(EDITED), off(OF_FORM)];
    println!("90 % of the border lies within {edited:.1} px of the ridge; with the form alone {of_form:.1} px");
    assert!(edited < 10.0 && of_form > 1.5 * edited);
}

#[test]
fn a_picture_in_parts_has_the_masses_of_the_whole() {
    let Some(mut world) = rough() else { return };
    let pose = world.pose("0,-9000,+900,10,-14,50");
    let mut tones = |size_px: [u32; 2], keys: [&str; 2], parts: &PartRule| {
        let style = style(keys);
        tones_in_parts(&mut world, PictureRequest::still(pose, size_px, &style, light()), parts)
    };
    let whole_px = PartRule { whole_px: u64::MAX, ..PartRule::default() };
    // The masses of the picture that is 1200 px long are found on a smaller one.
    let cases: &[([u32; 2], u32, f64)] = if common::full() {
        &[([250, 400], 100, 0.001), ([1200, 400], 100, 0.03)]
    } else {
        &[([250, 240], 160, 0.001)]
    };
    for &(size_px, part_px, most) in cases {
        let in_parts = PartRule { whole_px: 0, part_px, ..PartRule::default() };
        let whole = tones(size_px, EDITED, &whole_px);
        let mut differing = |keys: [&str; 2]| {
            let parts = tones(size_px, keys, &in_parts);
            let differing = whole.iter().zip(&parts).filter(|(a, b)| (**a - **b).abs() > 0.1).count();
            differing as f64 / whole.len() as f64
        };
        let (same, planted) = (differing(EDITED), differing(PLANES));
        println!("{size_px:?}: {same:.4} of the pixels differ in parts; {planted:.4} if these have no masses");
        assert!(same < most && planted > 3.0 * same && planted > 0.01);
    }
}

/// Flies ahead with one renderer, and counts the pixels whose step changes from frame to frame.
#[test]
fn a_flight_does_not_flicker_more() {
    let Some(mut world) = rough() else { return };
    let frames = if common::full() { [24; 3] } else { [4, 2, 2] };
    let mut changed = |keys, step_m: f64, frames: u32| {
        let (style, mut renderer) = (style(keys), Renderer::new(&world.gpu).unwrap());
        let all: Vec<_> = (0..frames)
            .map(|frame| {
                let camera = format!("0,{},+1200,10,-14,50", -9000.0 + step_m * f64::from(frame));
                steps(&mut world, &mut renderer, &style, &camera)
            })
            .collect();
        let pairs = all.windows(2).map(|pair| pair[0].iter().zip(&pair[1]).filter(|(a, b)| a != b).count());
        let mut pairs: Vec<f64> = pairs.map(|count| count as f64 / all[0].len() as f64).collect();
        [common::quantile(&mut pairs, 0.5), common::quantile(&mut pairs, 1.0)]
    };
    let edited = changed(EDITED, 5.0, frames[0]);
    let of_form = changed(OF_FORM, 5.0, frames[1]);
    let fast = changed(EDITED, 200.0, frames[2]);
    println!("pixels that change, median and most: {edited:.4?}; with the form alone {of_form:.4?}; fast {fast:.4?}");
    // A mass that becomes too small changes in one frame.
    assert!(edited[0] <= 0.5 * of_form[0] && edited[1] < 0.06);
    // Planted error: forty times the speed.
    assert!(fast[0] > 3.0 * edited[0]);
}

/// Merges masses of fewer than `least` cells on the CPU, as `shaders/tones/masses/` should, by filling masses one by one.
fn filled(masses: &Masses, levels: u32, rise: f32, least: usize) -> Vec<f32> {
    let [width, height] = masses.counts.map(|count| count as usize);
    let mut tones: Vec<f32> = masses.cells.iter().map(|cell| cell.tone).collect();
    let around = |i: usize| {
        let (x, y) = (i % width, i / width);
        let beside = [(x > 0).then(|| i - 1), (x + 1 < width).then_some(i + 1)];
        let above = [(y > 0).then(|| i - width), (y + 1 < height).then_some(i + width)];
        beside.into_iter().chain(above).flatten()
    };
    for (is_dark, rise) in [(false, rise), (true, 0.0)] {
        let before = tones.clone();
        let mut edited = vec![false; tones.len()];
        // The level at which a mass is largest comes first.
        let mut order: Vec<u32> = (1..levels).collect();
        if is_dark {
            order.reverse();
        }
        for level in order {
            let limit = (level as f32 - rise) / levels as f32;
            let is_in = |i: usize| before[i] >= 0.0 && (before[i] >= limit) != is_dark;
            let mut seen = vec![false; tones.len()];
            for first in (0..tones.len()).filter(|i| is_in(*i)) {
                if seen[first] {
                    continue;
                }
                seen[first] = true;
                let (mut mass, mut at, mut is_bordered) = (vec![first], 0, false);
                while at < mass.len() {
                    for other in around(mass[at]).filter(|other| before[*other] >= 0.0) {
                        if !is_in(other) {
                            is_bordered = true;
                        } else if !std::mem::replace(&mut seen[other], true) {
                            mass.push(other);
                        }
                    }
                    at += 1;
                }
                for i in mass.iter().filter(|_| is_bordered && mass.len() < least) {
                    if !std::mem::replace(&mut edited[*i], true) {
                        tones[*i] = (level as f32 + if is_dark { 1e-3 } else { -0.25 }) / levels as f32;
                    }
                }
            }
        }
    }
    tones
}

#[test]
fn small_masses_are_merged_as_by_filling() {
    let Some(gpu) = common::gpu() else { return };
    let counts = [97, 61];
    // Value noise of two sizes, with a lake.
    let tone = |x: u32, y: u32| {
        let noise = |size: u32| random(i64::from(x / size), i64::from(y / size)) as f32;
        let is_lake = (x as f32 - 60.0).hypot(y as f32 - 20.0) < 9.0 && (x as f32 - 60.0).hypot(y as f32 - 20.0) > 4.0;
        if is_lake { -1.0 } else { 0.55 * noise(13) + 0.3 * noise(4) + 0.15 * noise(1) }
    };
    let cells = (0..counts[1]).flat_map(|y| (0..counts[0]).map(move |x| (x, y))).map(|(x, y)| {
        let tone = tone(x, y);
        MassCell { tone, before: tone, depth_m: 1.0, level: 0.0 }
    });
    let masses = Masses { counts, cells: cells.collect() };
    for (steps, softness, levels) in [(2, 0.02, 2), (3, 0.02, 3), (4, 0.6, 12)] {
        let mut style = style(EDITED);
        let crate::style::Tone::Toon(toon) = &mut style.tone else { unreachable!("the tone of this style") };
        (toon.steps, toon.softness) = (steps, softness);
        let least = (f64::from(toon.smallest_share) * f64::from(counts[0] * counts[1])).ceil() as usize;
        let edited = masses.edited(&gpu, toon);
        let rise = if softness > 0.1 { 0.0 } else { softness };
        let unlike = |least: usize| {
            let filled = filled(&masses, levels, rise, least);
            filled.iter().zip(&edited.cells).filter(|(tone, cell)| (*tone - cell.tone).abs() > 1e-5).count()
        };
        let changed = masses.cells.iter().zip(&edited.cells).filter(|(a, b)| a.tone != b.tone).count();
        println!(
            "{steps} steps: {changed} cells are merged; {} differ, {} with half of the area",
            unlike(least),
            unlike(least / 2)
        );
        assert!(changed > 300 && unlike(least) == 0, "{} cells differ", unlike(least));
        // Planted error: another area.
        assert!(unlike(least / 2) > 20);
    }
}
