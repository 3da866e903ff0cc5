//! Light falls on the form of the land: few large areas of shade where the land is rough, unchanged light where it is
//! smooth, two differently lit sides on every ridge, and bare paper where it is level.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{draw, halves, normals, places_m, still};
use common::{World, grid_of, random, rough_height_m};
use glam::DVec3;
use hachure::composite::PICTURE;
use hachure::frame::{Light, Renderer};
use hachure::scene::Sun;
use hachure::style::Style;
use hachure::tones::TONE;

const SIZE_PX: [u32; 2] = [480, 270];

/// Returns a style whose tone is the light, in `steps` steps, or smooth with 0.
fn style(steps: u32, light: &str) -> Style {
    let text = format!(
        "name = \"form\"\ndescription = \"\"\n[light]\nwrap = 0\n{light}\n[tone]\nkind = \"toon\"\nsteps = {steps}\n\
         darkest = 0\nlightest = 1\n"
    );
    Style::parse("form", &text).unwrap()
}

fn sun(azimuth_deg: f64, elevation_deg: f64) -> Light {
    Light { to_sun: Sun { azimuth_deg, elevation_deg }.direction(), haze_m: 1e9, haze_srgb: None, focus: None }
}

/// Returns the tones of a frame; `None` in the sky.
fn tones(world: &mut World, style: &Style, light: &Light, camera: &str) -> Vec<Option<f64>> {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), style, light);
    let places = places_m(&world.gpu, &renderer, pose.position_m);
    let tones = halves(&world.gpu, renderer.target(&TONE).unwrap());
    tones.iter().zip(places).map(|([.., tone], place)| place.map(|_| *tone)).collect()
}

/// Looks for islands in a stepped tone: returns the fraction of the land in islands smaller than 0.2 % of the picture,
/// and the number of neighbouring pixels of different steps.
fn broken(tones: &[Option<f64>]) -> (f64, usize) {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let step = |i: usize| tones[i].map(|tone| (tone * 1000.0).round() as i64);
    let neighbours = |i: usize| {
        let (x, y) = (i % width, i / width);
        [
            (x > 0, i.wrapping_sub(1)),
            (x + 1 < width, i + 1),
            (y > 0, i.wrapping_sub(width)),
            (y + 1 < height, i + width),
        ]
        .into_iter()
        .filter_map(|(is_there, neighbour)| is_there.then_some(neighbour))
    };
    let (mut seen, mut small, mut land, mut border) = (vec![false; tones.len()], 0, 0, 0);
    for first in 0..tones.len() {
        if seen[first] || tones[first].is_none() {
            continue;
        }
        let (mut island, mut next) = (0, vec![first]);
        seen[first] = true;
        while let Some(i) = next.pop() {
            island += 1;
            for neighbour in neighbours(i).filter(|neighbour| tones[*neighbour].is_some()) {
                if step(neighbour) != step(i) {
                    border += 1;
                } else if !seen[neighbour] {
                    seen[neighbour] = true;
                    next.push(neighbour);
                }
            }
        }
        land += island;
        small += if island < tones.len() / 500 { island } else { 0 };
    }
    (small as f64 / land as f64, border / 2)
}

/// Tests land that is rough at every scale, as real land is.
#[test]
fn rough_land_has_few_large_masses_of_shade() {
    let Some(mut world) = World::new(grid_of(1025, 1025, 30.0, rough_height_m), 1.0) else { return };
    let light = sun(300.0, 35.0);
    let cameras = ["0,-9000,+900,10,-14,50", "3000,2000,+1500,200,-20,50", "0,0,+30000,0,-90,40"];
    for camera in cameras.into_iter().take(if common::full() { 3 } else { 1 }) {
        let (of_samples, long) = broken(&tones(&mut world, &style(4, ""), &light, camera));
        let (of_form, short) = broken(&tones(&mut world, &style(4, "form_px = 16"), &light, camera));
        println!(
            "{camera}: {of_samples:.4} of the land in small islands, {long} px of border; with form {of_form:.4}, {short} px"
        );
        assert!(of_form < 0.04 && of_form < 0.1 * of_samples && 8 * short < long);
        // Planted error: light on the land itself, without a form.
        assert!(of_samples > 0.02);
    }
}

#[test]
fn smooth_land_is_lit_as_it_was() {
    let hill = |x: f64, y: f64| 900.0 * (-(x * x + y * y) / (2.0 * 4000.0_f64.powi(2))).exp();
    let Some(mut world) = World::new(grid_of(1025, 1025, 30.0, hill), 1.0) else { return };
    let light = sun(300.0, 35.0);
    let differ = |world: &mut World, camera: &str| {
        let plain = tones(world, &style(0, ""), &light, camera);
        let formed = tones(world, &style(0, "form_px = 16"), &light, camera);
        let differences = plain.iter().zip(&formed).filter_map(|(a, b)| Some(((*a)? - (*b)?).abs()));
        let differences: Vec<f64> = differences.collect();
        differences.iter().filter(|difference| **difference > 0.02).count() as f64 / differences.len() as f64
    };
    for camera in ["0,-9000,+900,0,-10,50", "0,0,+20000,0,-90,40"] {
        let part = differ(&mut world, camera);
        println!("{camera}: {part:.5} of the land changes its light by more than 0.02");
        // A few pixels next to the skyline may differ, where blocks of the form see the land from another side.
        assert!(part < 0.003, "a fraction of {part} of smooth land changes its light");
    }
    // Planted error: rough land.
    let Some(mut rough) = World::new(grid_of(257, 257, 30.0, rough_height_m), 1.0) else { return };
    assert!(differ(&mut rough, "0,0,+20000,0,-90,40") > 0.1);
}

/// Returns a ridge with two even sides, which runs along the x axis or the y axis.
fn ridge(along_x: bool) -> Option<World> {
    let height_m = move |x: f64, y: f64| -0.5 * (if along_x { y } else { x }).hypot(200.0);
    World::new(grid_of(513, 513, 30.0, height_m), 1.0)
}

#[test]
fn a_ridge_along_the_light_has_two_sides() {
    // The light comes along the x axis.
    let light = sun(270.0, 40.0);
    let apart = |world: &mut World, keys: &str| {
        let tones = tones(world, &style(0, keys), &light, "0,0,+4000,0,-90,40");
        // Points above and below the centre, and left and right of it: on the two sides of the ridge.
        let [width, height] = SIZE_PX.map(|side| side as usize);
        let at = |x: usize, y: usize| tones[y * width + x].unwrap();
        [
            at(width / 2, height / 2 - 20) - at(width / 2, height / 2 + 20),
            at(width / 2 - 20, height / 2) - at(width / 2 + 20, height / 2),
        ]
    };
    let Some(mut along) = ridge(true) else { return };
    let [still, turned] = ["form_px = 8", "form_px = 8\nturn_deg = 30"].map(|keys| apart(&mut along, keys)[0].abs());
    println!("a ridge along the light: its sides differ by {still:.3}, turned {turned:.3}");
    assert!(still < 0.02 && turned > 0.1);
    let Some(mut across) = ridge(false) else { return };
    let [still, turned] = ["form_px = 8", "form_px = 8\nturn_deg = 30"].map(|keys| apart(&mut across, keys)[1].abs());
    println!("a ridge across it: {still:.3}, turned {turned:.3}");
    // The light of this ridge does not change.
    assert!(still > 0.3 && (still - turned).abs() < 0.02);
}

/// Tests land of 1.5° and slopes of 12°, both with some noise.
#[test]
fn level_land_is_paper() {
    let land = |x: f64, y: f64| {
        let noise_m = 0.3 * random((x / 30.0) as i64, (y / 30.0) as i64);
        noise_m + if y < 0.0 { 0.026 * x } else { 0.026 * x + 0.21 * y }
    };
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, land), 1.0) else { return };
    let light = sun(315.0, 40.0);
    // In the fast tier one style for each kind of marks: rows, cut lines, hatching lines and dots.
    let names = ["hachures", "engraving", "crosshatch", "stipple", "pencil", "woodcut"];
    // And a strip of the picture, from its top to its bottom.
    let size_px = if common::full() { SIZE_PX } else { [120, SIZE_PX[1]] };
    for name in names.into_iter().take(if common::full() { 6 } else { 4 }) {
        let mut ink = |level: bool| {
            let mut style = common::absolute(name);
            style.set_strokes(None);
            style.paper.grain = 0.0;
            if !level {
                style.light.level_deg = 0.0;
                // The land must not be white merely because the light is strong, either.
                style.light.exposure = 1.0;
                style
                    .lowest_cuts_mut()
                    .into_iter()
                    .flat_map(|cuts| &mut cuts.families)
                    .for_each(|layer| layer.level_deg = 0.5);
                style.rows_mut().into_iter().for_each(|rows| rows.level_deg = 0.5);
            }
            let pose = world.pose("0,0,+2500,0,-90,50");
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, size_px), &style, &light);
            let paper = style.paper.color.linear().map(f64::from);
            let picture = halves(&world.gpu, renderer.target(&PICTURE).unwrap());
            let half = picture.len() / 2;
            let mean = |texels: &[[f64; 4]]| texels.iter().map(|texel| texel[1]).sum::<f64>() / texels.len() as f64;
            // The upper half of the picture is the slope; some rows around the centre belong to neither part.
            let rows = 24 * size_px[0] as usize;
            [&picture[half + rows..], &picture[..half - rows]].map(|part| 1.0 - mean(part) / paper[1])
        };
        let [plain, slope] = ink(true);
        let [grit, _] = ink(false);
        println!("{name:12} plain {plain:.4}, slope {slope:.3}; without level_deg the plain {grit:.3}");
        assert!(
            plain <= 0.01 && slope > 0.05,
            "{name}: ink of the plain {plain}, expected at most 0.01; of the slope {slope}, expected more than 0.05"
        );
        // Planted error: without level_deg the plain has ink.
        assert!(grit > 0.01, "{name}: without level_deg the plain has only {grit} of ink");
    }
}

/// Tests that the form depends on position and distance alone: the tone of a point stays when the camera turns.
#[test]
fn a_turn_does_not_move_the_form() {
    let Some(mut world) = World::new(grid_of(1025, 1025, 30.0, rough_height_m), 1.0) else { return };
    let light = sun(300.0, 35.0);
    // In the fast tier a strip of the picture.
    let (size_px, least) = if common::full() { (SIZE_PX, 5_000) } else { ([160, SIZE_PX[1]], 1_500) };
    let mut shot = |keys: &str, yaw_deg: f64| {
        let style = style(0, keys);
        let pose = world.pose(&format!("0,-9000,+900,{yaw_deg},-14,50"));
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, size_px), &style, &light);
        let tones: Vec<f64> =
            halves(&world.gpu, renderer.target(&TONE).unwrap()).into_iter().map(|[.., tone]| tone).collect();
        let places = places_m(&world.gpu, &renderer, pose.position_m);
        let normals = normals(&world.gpu, &renderer);
        (pose, tones, places, normals)
    };
    // Returns how much tones differ at the same points, and at points that are 12 pixels aside.
    let mut moved = |keys: &str| {
        let (_, tones, places, _) = shot(keys, 10.0);
        let (pose, turned, turned_places, normals) = shot(keys, 13.0);
        let view = still(pose, size_px);
        let mut differences: [Vec<f64>; 2] = Default::default();
        for (tone, at_m) in tones.iter().zip(&places).filter_map(|(tone, place)| Some((tone, (*place)?))) {
            let Some(px) = view.place_px(at_m - pose.position_m) else { continue };
            let [x, y] = [px.x.floor(), px.y.floor()];
            if x < 0.0 || y < 0.0 || x >= f64::from(size_px[0]) || y >= f64::from(size_px[1]) {
                continue;
            }
            let i = y as usize * size_px[0] as usize + x as usize;
            let toward = DVec3::from_array([0, 1, 2].map(|axis| f64::from(normals[i][axis])));
            // The same face of the land, not seen at a grazing angle.
            let is_same =
                turned_places[i].is_some_and(|place| place.distance(at_m) < 0.0015 * at_m.distance(pose.position_m));
            if is_same && toward.dot((pose.position_m - at_m).normalize()) > 0.15 {
                for (differences, aside) in differences.iter_mut().zip([0, 12]) {
                    differences.push((turned[(i + aside) % turned.len()] - tone).abs());
                }
            }
        }
        assert!(differences[0].len() > least, "{}", differences[0].len());
        differences.map(|mut differences| common::quantile(&mut differences, 0.95))
    };
    let ([form, planted], [samples, _]) = (moved("form_px = 16"), moved(""));
    println!(
        "95 % of points keep their tone within {form:.4}; without a form {samples:.4}; shifted by 12 pixels {planted:.4}"
    );
    // A pixel shows the land within half a pixel, and without generalisation the land changes more there.
    assert!(form < 0.02 && form < samples);
    // Planted error: tones compared at other points.
    assert!(planted > 0.02);
}
