//! Lines, strokes and marks of two eyes agree on distant land.

use glam::DVec2;
use hachure::measure::stereo::orphans;
use hachure::picture::nearest::nearest_m;
use hachure::scene::stereo::IPD_M;
use hachure::source::{Silent, procedural};

use super::*;
use crate::tests::common::{World, full};

const SIZE_PX: [u32; 2] = [480, 270];

/// Returns the size of the pictures of tests whose results hardly depend on it: smaller in the fast tier.
fn small_px() -> [u32; 2] {
    if full() { SIZE_PX } else { SIZE_PX.map(|side| side / 2) }
}

const MOUNTAINS: [(&str, &str); 3] = [
    ("dem/geotiff/mt_rainier_90m.tif", "-19800,30500,+500,0,3,50"),
    ("dem/geotiff/mt_everest_90m.tif", "0,-15000,+900,0,2,50"),
    ("dem/geotiff/N46E008_alps.tif", "0,0,+300,40,0,55"),
];

/// Returns procedural mountains and `real` real ones, each with a camera.
fn places(real: usize) -> Vec<(String, World, Pose)> {
    let own = World::new(procedural::generate_sized(1, 512, 24.0, &Silent), 1.0);
    let own = own.map(|world| ("procedural", world, "-300,-2500,+350,20,-6,60"));
    let real =
        MOUNTAINS.iter().take(real).filter_map(|(file, camera)| Some((*file, World::filled(file, 1.0)?, *camera)));
    let place = |(name, world, camera): (&str, World, &str)| {
        let pose = world.pose(camera);
        (name.to_owned(), world, pose)
    };
    own.into_iter().chain(real).map(place).collect()
}

/// Returns a wide distance between eyes: a thirtieth of the distance to the nearest land.
fn wide_m(world: &mut World, pose: Pose) -> f64 {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    // Any style will do, and this one is the cheapest.
    let style = Style::load("plain").unwrap();
    nearest_m(&world.gpu, &mut renderer, &mut world.surfaces, pose, &style).unwrap().unwrap() / 30.0
}

fn of(metrics: &Metrics, name: &str) -> f64 {
    metrics[name].unwrap_or_else(|| panic!("{name} was not measured"))
}

#[test]
fn lines_of_far_land_have_partners() {
    let style = Style::load("lsa").unwrap();
    for (place, mut world, pose) in places(if full() { 3 } else { 0 }) {
        let wide_m = wide_m(&mut world, pose);
        let mut at = |style: &Style, ipd_m: f64| {
            let eyes = draw(&world.gpu, &mut world.surfaces, style, &rig(pose, ipd_m, SIZE_PX));
            (agreement(&eyes), eyes)
        };
        let orphans_of = |metrics: &Metrics| of(metrics, "orphans");
        // In the fast tier another test draws this land for eyes 65 mm apart.
        if full() {
            let narrow = orphans_of(&at(&style, IPD_M).0);
            println!("{place}: orphans {:.4} % at 65 mm", 100.0 * narrow);
            assert!(narrow <= 1e-3, "{place}: too many lines without a partner at 65 mm");
        }
        let (wide, eyes) = at(&style, wide_m);
        let (alone, _) = at(&ink_alone(), wide_m);
        println!(
            "{place}: orphans {:.4} % at {wide_m:.1} m, alone {:.4} %; correlation of ink {:.3}; coverage {:.3} of \
             that alone",
            100.0 * orphans_of(&wide),
            100.0 * orphans_of(&alone),
            of(&wide, "line_correlation"),
            of(&wide, "line_coverage") / of(&alone, "line_coverage")
        );
        assert!(orphans_of(&wide) <= 1e-3, "{place}: too many lines without a partner");
        assert!(of(&wide, "line_correlation") >= 0.9, "{place}: the correlation of ink is below 0.9");
        assert!(
            (of(&wide, "line_coverage") / of(&alone, "line_coverage") - 1.0).abs() <= 0.15,
            "{place}: agreement changes the coverage of lines"
        );
        // Planted errors: parallax of the wrong sign, and lines that are three pixels off.
        let exchanged = [eyes[1].clone(), eyes[0].clone()];
        let swapped = [0, 1].map(|i| DrawnFrame { ink: exchanged[i].ink.clone(), ..eyes[i].clone() });
        assert!(orphans_of(&agreement(&swapped)) > 10.0 * orphans_of(&wide), "{place}");
        let mut off = eyes[1].clone();
        off.ink.as_mut().unwrap().rotate_right(3 * SIZE_PX[0] as usize);
        assert!(orphans_of(&agreement(&[eyes[0].clone(), off])) > 10.0 * orphans_of(&wide), "{place}");
    }
}

/// Lines along the rims of holes are removed in each eye; those of ridges in front of holes stay in both.
#[test]
fn holes_take_no_lines_of_pairs() {
    let (file, camera) = MOUNTAINS[0];
    let Some(mut world) = World::real(file, 1.0) else { return };
    let pose = world.pose(camera);
    let wide_m = wide_m(&mut world, pose);
    let [agreed, alone] = [Style::load("lsa").unwrap(), ink_alone()].map(|style| {
        let eyes = draw(&world.gpu, &mut world.surfaces, &style, &rig(pose, wide_m, small_px()));
        of(&agreement(&eyes), "line_coverage")
    });
    println!("line coverage {:.3} % with agreement, {:.3} % alone", 100.0 * agreed, 100.0 * alone);
    assert!((agreed / alone - 1.0).abs() <= 0.15);
}

#[test]
fn what_lacks_a_partner_is_reported() {
    let Some((place, mut world, pose)) = places(0).into_iter().next() else { return };
    let size_px = small_px();
    let scale = f64::from(size_px[0]) / f64::from(SIZE_PX[0]);
    let eyes = draw(&world.gpu, &mut world.surfaces, &Style::load("lsa").unwrap(), &rig(pose, IPD_M, size_px));
    // Planted error: the right eye's lines are erased in a rectangle.
    let mut rubbed = eyes[1].clone();
    let (low, high) = (DVec2::new(200.0, 120.0) * scale, DVec2::new(360.0, 240.0) * scale);
    let is_in = |pixel: usize, by_px: f64| {
        let at = DVec2::new((pixel as u32 % size_px[0]).into(), (pixel as u32 / size_px[0]).into());
        at.cmpge(low - by_px).all() && at.cmplt(high + by_px).all()
    };
    rubbed
        .ink
        .as_mut()
        .unwrap()
        .iter_mut()
        .enumerate()
        .filter(|(pixel, _)| is_in(*pixel, 0.0))
        .for_each(|(_, ink)| *ink = 0.0);
    let lone = orphans(&eyes[0], &rubbed).unwrap();
    let ink = eyes[0].ink.as_ref().unwrap();
    let missed = (0..ink.len()).filter(|pixel| is_in(*pixel, -4.0) && ink[*pixel] > 0.5 && lone[*pixel] == 0.0).count();
    let elsewhere = (0..ink.len()).filter(|pixel| !is_in(*pixel, 4.0) && lone[*pixel] > 0.1).count();
    let found = lone.iter().filter(|ink| **ink > 0.5).count();
    println!("{place}: {found} pixels lack a partner, {missed} are missed, {elsewhere} are elsewhere");
    assert!(found as f64 > 100.0 * scale && missed == 0 && elsewhere == 0);
}

#[test]
fn strokes_of_two_eyes_are_the_same_strokes() {
    for (place, mut world, pose) in places(usize::from(full())) {
        let wide_m = wide_m(&mut world, pose);
        for name in ["strokes", "charcoal"].into_iter().take(if full() { 2 } else { 1 }) {
            let mut style = Style::load(name).unwrap();
            style.strokes_mut().unwrap().wobble_px = 0.0;
            let mut at = |ipd_m: f64| {
                let eyes = draw(&world.gpu, &mut world.surfaces, &style, &rig(pose, ipd_m, SIZE_PX));
                (agreement(&eyes), eyes)
            };
            for (ipd_m, least, most) in [(IPD_M, 0.95, [0.01, 0.002]), (wide_m, 0.93, [0.03, 0.006])] {
                let (metrics, mut eyes) = at(ipd_m);
                println!(
                    "{place}, {name}, eyes {ipd_m:.3} m apart: correlation of ink {:.3}, orphans {:.3} %, other identity \
                     {:.2} %, other width {:.2} %",
                    of(&metrics, "line_correlation"),
                    100.0 * of(&metrics, "orphans"),
                    100.0 * of(&metrics, "other_identity"),
                    100.0 * of(&metrics, "other_width")
                );
                assert!(of(&metrics, "line_correlation") >= least, "{place}, {name}: correlation of ink");
                assert!(of(&metrics, "other_identity") <= most[0], "{place}, {name}: strokes with another identity");
                assert!(of(&metrics, "other_width") <= 0.01, "{place}, {name}: strokes of another width");
                assert!(of(&metrics, "orphans") <= most[1], "{place}, {name}: strokes without a partner");
                // Planted error: the eyes do not share identities.
                let centres = eyes[1].centres.as_mut().unwrap();
                centres.id.iter_mut().for_each(|id| *id = id.wrapping_mul(3));
                assert!(of(&agreement(&eyes), "other_identity") > 0.9, "{place}, {name}");
            }
        }
    }
}

#[test]
fn marks_of_two_eyes_are_as_dark() {
    for (place, mut world, pose) in places(usize::from(full())) {
        let wide_m = wide_m(&mut world, pose);
        let names = ["stipple", "crosshatch", "hachures", "pencil", "charcoal", "rock"];
        for name in names.into_iter().take(if full() { 6 } else { 1 }) {
            let style = Style::load(name).unwrap();
            let mut eyes = draw(&world.gpu, &mut world.surfaces, &style, &rig(pose, wide_m, SIZE_PX));
            let correlation = of(&agreement(&eyes), "mark_correlation");
            println!("{place}, {name}: correlation of the ink of marks {correlation:.3}");
            // Each eye selects rows by its own picture, so some marks are in one eye only.
            let is_of_rows = style.rows().is_some();
            assert!(
                correlation >= if is_of_rows { 0.9 } else { 0.93 },
                "{place}, {name}: correlation {correlation:.3}"
            );
            // Planted error: marks shifted by several pixels.
            eyes[1].marks.as_mut().unwrap().rotate_right(6);
            let apart = of(&agreement(&eyes), "mark_correlation");
            assert!(apart < if is_of_rows { 0.8 } else { 0.9 }, "{place}, {name}: {apart:.3}");
        }
    }
}

/// Prints a table of agreement: `cargo test --release --lib tests::eyes -- --ignored --nocapture`
#[test]
#[ignore = "a measurement"]
fn table() {
    for (place, mut world, pose) in places(3) {
        let wide_m = wide_m(&mut world, pose);
        for name in hachure::style::names() {
            let style = Style::load(name).unwrap();
            for ipd_m in [IPD_M, wide_m] {
                let eyes = draw(&world.gpu, &mut world.surfaces, &style, &rig(pose, ipd_m, SIZE_PX));
                let metrics = agreement(&eyes);
                let shown =
                    ["orphans", "line_correlation", "mark_correlation", "picture_correlation", "other_identity"];
                let values = shown.map(|name| metrics[name].map_or("-".to_owned(), |value| format!("{value:.4}")));
                println!("| {place} | {ipd_m:.3} | {name} | {} |", values.join(" | "));
            }
        }
    }
}
