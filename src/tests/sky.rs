//! Tests drawn skies: the sun is where the light comes from, rules have the requested distance and darkness, clouds and
//! stars rotate with the world, parts join, and a style that uses none of these has its gradient.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::f64::consts::TAU;

use common::draw::{draw, halves, north_west, still};
use common::shot::{ink, shoot_style};
use common::{World, grid_of};
use glam::{DVec2, DVec3};
use hachure::composite::PICTURE;
use hachure::composite::sky::SKY;
use hachure::frame::{Light, Renderer, prepare};
use hachure::picture::strokes::render_strokes;
use hachure::picture::{PartRule, PictureRequest};
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::{Sky, Style};

const SIZE_PX: [u32; 2] = [480, 270];
/// A camera over flat land, looking a little upward; the lower part of the picture is land.
const CAMERA: &str = "0,0,+50,20,12,50";

fn world() -> Option<World> {
    World::new(grid_of(65, 65, 30.0, |_, _| 0.0), 0.0)
}

fn style(keys: &str) -> Style {
    let text = format!(
        "name = \"sky\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\n[sky]\n\
         zenith = \"#000000\"\nhorizon = \"#000000\"\n{keys}"
    );
    Style::parse("sky", &text).unwrap()
}

fn toward(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
    let [azimuth, elevation] = [azimuth_deg, elevation_deg].map(f64::to_radians);
    DVec3::new(azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin())
}

fn turned(pose: Pose, yaw_deg: f64) -> Pose {
    let turn = glam::DQuat::from_axis_angle(DVec3::Z, -yaw_deg.to_radians());
    Pose { forward: turn * pose.forward, right: turn * pose.right, up: turn * pose.up, ..pose }
}

/// Returns colour (RGB) and ink (alpha) of the sky, and the view.
fn sky_of(world: &mut World, pose: Pose, style: &Style, light: &Light) -> (Vec<[f64; 4]>, View) {
    let view = still(pose, SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, light);
    (halves(&world.gpu, renderer.target(&SKY).unwrap()), view)
}

/// Returns the sky that the first of two eyes sees: clouds of several eyes depend on directions alone.
fn sky_of_two(world: &mut World, pose: Pose, style: &Style) -> (Vec<[f64; 4]>, View) {
    sky_of_two_in(world, pose, style, &north_west())
}

/// Returns the sky like [`sky_of_two`], in a light.
fn sky_of_two_in(world: &mut World, pose: Pose, style: &Style, light: &Light) -> (Vec<[f64; 4]>, View) {
    let view = still(pose, SIZE_PX);
    let aside = still(Pose { position_m: pose.position_m + pose.right * 0.06, ..pose }, SIZE_PX);
    let rig = Rig { eyes: vec![view, aside], ..Rig::mono(view) };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let prepared = prepare(&world.gpu, &mut world.surfaces, &rig, style, light);
    renderer.render_rig(&world.gpu, &world.surfaces, &prepared, &rig, style, light).unwrap();
    world.gpu.check().unwrap();
    (halves(&world.gpu, renderer.target(&SKY).unwrap()), view)
}

fn pixels() -> impl Iterator<Item = DVec2> {
    let [width, height] = SIZE_PX;
    (0..height).flat_map(move |y| (0..width).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)))
}

#[test]
fn the_sun_stands_where_the_light_comes_from() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    for (azimuth_deg, elevation_deg, radius_deg) in [(20.0, 12.0, 3.0), (45.0, 22.0, 1.5), (-8.0, 25.0, 4.0)] {
        let to_sun = toward(azimuth_deg, elevation_deg);
        let style = style(&format!("sun_deg = {radius_deg:?}\nsun = \"#ffffff\"\n"));
        let (sky, view) = sky_of(&mut world, pose, &style, &Light { to_sun, ..north_west() });
        // The area of the lit pixels, and their middle. The disc is round on the sheet, off its middle too.
        let (mut lit, mut middle_px) = (0.0, DVec2::ZERO);
        for (at_px, texel) in pixels().zip(&sky) {
            lit += texel[0];
            middle_px += at_px * texel[0];
        }
        middle_px /= lit;
        let off_px = |to_sun: DVec3| middle_px.distance(view.place_px(to_sun).unwrap());
        let radius_px = |lit: f64| (2.0 * lit / TAU).sqrt();
        let wanted_px = f64::to_radians(radius_deg) * view.focal_px();
        println!("middle off by {:.3} px, radius {:.3} px of {wanted_px:.3}", off_px(to_sun), radius_px(lit));
        assert!(off_px(to_sun) < 0.1);
        assert!((radius_px(lit) - wanted_px).abs() < 0.1);
        // Planted: a sun one degree farther right, or with another radius.
        assert!(off_px(toward(azimuth_deg + 1.0, elevation_deg)) > 1.0);
        assert!((radius_px(1.1 * lit) - wanted_px).abs() > 0.1);
    }
}

#[test]
fn a_sun_in_view_has_its_place_in_each_picture() {
    let Some(mut world) = world() else { return };
    let style = style("sun_deg = 3.0\nsun = \"#ffffff\"\nsun_in_view = true\n");
    // Light from the left, from the right and from behind the eye: where the light is, no picture has a disc.
    let light = |azimuth_deg: f64| Light { to_sun: toward(azimuth_deg, 30.0), ..north_west() };
    let lit = |sky: &[[f64; 4]]| sky.iter().map(|texel| texel[0]).sum::<f64>();
    let views = [(20.0, 12.0, -110.0, 0.2), (75.0, 5.0, 130.0, 0.8), (200.0, -3.0, 180.0, 0.5)];
    for (yaw_deg, pitch_deg, aside_deg, part) in views {
        let pose = world.pose(&format!("0,0,+50,{yaw_deg},{pitch_deg},50"));
        let (sky, view) = sky_of(&mut world, pose, &style, &light(yaw_deg + aside_deg));
        let area = lit(&sky);
        let middle_px = pixels().zip(&sky).map(|(at_px, texel)| at_px * texel[0]).sum::<DVec2>() / area;
        let horizon_px = (135.0 + view.focal_px() * f64::to_radians(pitch_deg).tan()).min(270.0);
        let off_px = |part: f64, horizon_px: f64| middle_px.distance(DVec2::new(part * 480.0, 0.4 * horizon_px));
        println!("{yaw_deg}, {pitch_deg}: off by {:.3} px", off_px(part, horizon_px));
        assert!(off_px(part, horizon_px) < 0.1);
        // Planted: another horizon, and light from the other side.
        assert!(off_px(part, horizon_px + 5.0) > 1.0);
        assert!(part == 0.5 || off_px(1.0 - part, horizon_px) > 100.0);
        // Two eyes see the disc where the light is: here, out of view.
        assert_eq!(lit(&sky_of_two_in(&mut world, pose, &style, &light(yaw_deg + aside_deg)).0), 0.0);
    }
    // No sky, no sun.
    let pose = world.pose("0,0,+50,20,-60,50");
    assert_eq!(lit(&sky_of(&mut world, pose, &style, &light(20.0)).0), 0.0);
}

/// Returns the ink of a column, from the top down to the horizon.
fn column(sky: &[[f64; 4]], x: usize, rows: usize) -> Vec<f64> {
    (0..rows).map(|y| sky[y * SIZE_PX[0] as usize + x][3]).collect()
}

/// Returns the middles of rules, in pixels from the top.
fn middles_px(column: &[f64]) -> Vec<f64> {
    let mut middles = Vec::new();
    let (mut sum, mut moment) = (0.0, 0.0);
    for (y, ink) in column.iter().enumerate() {
        if *ink > 0.0 {
            sum += ink;
            moment += ink * (y as f64 + 0.5);
        } else if sum > 0.0 {
            middles.push(moment / sum);
            (sum, moment) = (0.0, 0.0);
        }
    }
    middles
}

#[test]
fn rules_are_as_far_apart_and_as_dark_as_asked() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    let horizon_px = 135.0 + still(pose, SIZE_PX).focal_px() * 12.0_f64.to_radians().tan();
    for (width_px, spacing_px) in [(0.8, 5.0), (1.5, 7.3), (3.0, 12.0)] {
        let style = style(&format!("rules_px = {width_px:?}\nspacing_px = {spacing_px:?}\nfade = 0.0\n"));
        let (sky, _) = sky_of(&mut world, pose, &style, &north_west());
        for x in [3, 240, 470] {
            let ink = column(&sky, x, horizon_px as usize);
            let middles = middles_px(&ink);
            let whole = &middles[1..middles.len() - 1];
            let gap_px = (whole[whole.len() - 1] - whole[0]) / (whole.len() - 1) as f64;
            let dark = ink.iter().sum::<f64>() / horizon_px;
            println!("{gap_px:.3} px apart of {spacing_px}, ink {dark:.3} of {:.3}", width_px / spacing_px);
            let holds = |spacing_px: f64, width_px: f64| {
                (gap_px - spacing_px).abs() < 0.05 && (dark * spacing_px / width_px - 1.0).abs() < 0.06
            };
            assert!(holds(spacing_px, width_px));
            // Planted: rules that are farther apart, or wider.
            assert!(!holds(1.1 * spacing_px, width_px) && !holds(spacing_px, 1.2 * width_px));
        }
    }
    // Rules fade toward the horizon, or away from it.
    for (fade, is_darker_above) in [(0.8, true), (-0.8, false)] {
        let style = style(&format!("rules_px = 2.0\nspacing_px = 6.0\nfade = {fade:?}\n"));
        let (sky, _) = sky_of(&mut world, pose, &style, &north_west());
        let ink = column(&sky, 240, horizon_px as usize);
        let sum = |rows: &[f64]| rows.iter().sum::<f64>();
        let (above, below) = (sum(&ink[..60]), sum(&ink[ink.len() - 60..]));
        assert_eq!(above > 1.2 * below, is_darker_above, "{above} {below}");
        assert_eq!(below > 1.2 * above, !is_darker_above, "{above} {below}");
    }
}

#[test]
fn rules_stay_where_they_are_in_a_pan() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    let style = style("rules_px = 1.2\nspacing_px = 5.0\n");
    let (before, _) = sky_of(&mut world, pose, &style, &north_west());
    let mut worst = |pose: Pose| {
        let (after, _) = sky_of(&mut world, pose, &style, &north_west());
        before.iter().zip(&after).map(|(a, b)| (a[3] - b[3]).abs()).fold(0.0, f64::max)
    };
    let [panned, moved] = [turned(pose, 17.3), Pose { position_m: pose.position_m + DVec3::X * 50.0, ..pose }];
    assert!(worst(panned) < 0.02);
    assert_eq!(worst(moved), 0.0);
    // Planted: an eye that nods.
    let nod = glam::DQuat::from_axis_angle(pose.right, 0.4_f64.to_radians());
    assert!(worst(Pose { forward: nod * pose.forward, up: nod * pose.up, ..pose }) > 0.5);
}

/// Returns the mean difference between a picture and what the first one shows at the points that `place_px` returns.
fn differing(before: &[[f64; 4]], after: &[[f64; 4]], place_px: impl Fn(DVec2) -> Option<DVec2>) -> f64 {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let (mut sum, mut count) = (0.0, 0.0);
    for (at, texel) in pixels().zip(after) {
        let Some(place) = place_px(at).map(|place| place - 0.5) else { continue };
        if place.x < 0.0 || place.y < 0.0 || place.x >= width as f64 - 1.0 || place.y >= height as f64 - 1.0 {
            continue;
        }
        let [x, y] = [place.x.floor(), place.y.floor()];
        let [u, v] = [place.x - x, place.y - y];
        let light = |i: usize, j: usize| before[(y as usize + j) * width + x as usize + i][0];
        let top = light(0, 0) * (1.0 - u) + light(1, 0) * u;
        let low = light(0, 1) * (1.0 - u) + light(1, 1) * u;
        sum += (top * (1.0 - v) + low * v - texel[0]).abs();
        count += 1.0;
    }
    assert!(count > 0.5 * (width * height) as f64);
    sum / count
}

#[test]
fn clouds_and_stars_turn_with_the_world() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    let kinds = ["clouds = 0.8\n", "clouds = 0.8\ncloud_form = \"streaks\"\n", "stars = 0.8\nstar_px = 4.0\n"];
    for keys in kinds {
        let style = style(keys);
        let (before, view) = sky_of_two(&mut world, pose, &style);
        let lit = before.iter().map(|texel| texel[0]).sum::<f64>() / before.len() as f64;
        let (after, next) = sky_of_two(&mut world, turned(pose, 7.0), &style);
        let with_world = differing(&before, &after, |at| view.place_px(next.ray(at)));
        // Planted: patterns that are fixed to the page.
        let with_sheet = differing(&before, &after, Some);
        println!(
            "{keys:?}: {lit:.4} is light; it differs by {with_world:.4} in the world, {with_sheet:.4} on the page"
        );
        assert!(lit > 0.002);
        assert!(with_world < 0.25 * with_sheet);
        // An eye that moves sees the same sky, because it is infinitely far away.
        let aside = Pose { position_m: pose.position_m + DVec3::new(90.0, -40.0, 3.0), ..pose };
        assert_eq!(sky_of_two(&mut world, aside, &style).0, before);
    }
}

#[test]
fn no_cloud_of_a_picture_is_cut_by_its_frame() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    let [width, height] = SIZE_PX.map(|side| side as usize);
    for form in ["", "cloud_form = \"streaks\"\n"] {
        let style = style(&format!("clouds = 1.0\n{form}"));
        // Light at the frame: the first row, and the first and the last column.
        let at_frame = |sky: &[[f64; 4]]| {
            let top = (0..width).map(|x| sky[x][0]);
            let sides = (0..height).flat_map(|y| [sky[y * width][0], sky[y * width + width - 1][0]]);
            top.chain(sides).sum::<f64>()
        };
        let (mut cut, mut lit) = (0.0, 0.0);
        for turn_deg in [0.0, 20.0, 40.0, 60.0] {
            let pose = turned(pose, turn_deg);
            let (sky, _) = sky_of(&mut world, pose, &style, &north_west());
            assert_eq!(at_frame(&sky), 0.0, "{form:?} {turn_deg}");
            lit += sky.iter().map(|texel| texel[0]).sum::<f64>();
            // Planted: clouds that know no frame.
            cut += at_frame(&sky_of_two(&mut world, pose, &style).0);
        }
        println!("{lit:.0} px of clouds in four pictures; {cut:.0} px at the frame if they do not know it");
        assert!(lit > 4000.0 && cut > 20.0, "{lit} {cut}");
    }
}

#[test]
fn fewer_stars_stand_near_the_horizon() {
    let Some(mut world) = world() else { return };
    let style = style("stars = 1.0\n");
    let mut light = |elevation_deg: f64| {
        let pose = world.pose(&format!("0,0,+50,0,{elevation_deg},20"));
        sky_of(&mut world, pose, &style, &north_west()).0.iter().map(|texel| texel[0]).sum::<f64>()
    };
    let [low, high] = [light(10.0), light(60.0)];
    assert!(low > 0.0 && high > 2.0 * low, "{low} {high}");
}

/// Returns a style with every element of skies, over lines, so that parts have margins.
fn rich() -> Style {
    let drawn = style(
        "rules_px = 0.9\nclouds = 0.7\noutline_px = 1.5\nbokashi = 0.4\nhorizon_bokashi = 0.2\n\
         bokashi_color = \"#204080\"\nsun_deg = 3.0\nsun = \"#ffe080\"\nstars = 0.5\n",
    );
    let Sky { zenith, horizon, .. } = Style::load("wash").unwrap().sky;
    Style { sky: Sky { zenith, horizon, ..drawn.sky }, ..ink("footprint") }
}

#[test]
fn parts_have_the_sky_of_the_whole() {
    let Some(mut world) = world() else { return };
    let (pose, style) = (world.pose("0,0,+50,-45,25,70"), rich());
    let mut shoot = |parts: &PartRule| shoot_style(&mut world, &mut None, pose, pose, [317, 211], &style, parts);
    let whole = shoot(&PartRule::default());
    let parts = shoot(&PartRule { whole_px: 0, part_px: 100, margin_px: 12 });
    assert!(parts.report.parts > 1);
    let sky: Vec<usize> = (0..whole.picture.len()).filter(|pixel| whole.is_sky(*pixel)).collect();
    assert!(sky.len() > whole.picture.len() / 2);
    let differs = |shift: usize| {
        sky.iter()
            .filter(|pixel| parts.picture[(**pixel + shift) % parts.picture.len()] != whole.picture[**pixel])
            .count()
    };
    assert_eq!(differs(0), 0);
    // Planted: a picture that is one row lower.
    assert!(differs(317) > sky.len() / 10);
}

#[test]
fn a_style_that_asks_for_no_more_has_its_gradient() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    let view = still(pose, SIZE_PX);
    let mut style = style("stars = 0.1\n");
    let wash = Sky { clouds: 0.0, ..Style::load("wash").unwrap().sky };
    let mut passes = |sky: Sky| {
        style.sky = sky;
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_traces(true);
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &north_west());
        let has_pass = renderer.trace().iter().any(|pass| pass.name == "composite/sky");
        let picture = halves(&world.gpu, renderer.target(&PICTURE).unwrap());
        (has_pass, picture)
    };
    let (has_pass, picture) = passes(wash.clone());
    assert!(!has_pass);
    let [low, high] = [wash.horizon, wash.zenith].map(|color| color.linear().map(f64::from));
    let worst = |factor: f64| {
        let off = pixels().zip(&picture).filter(|(at, _)| view.ray(*at).z > 0.0).map(|(at, texel)| {
            let up = (factor * view.ray(at).normalize().z).clamp(0.0, 1.0);
            (0..3).map(|i| (low[i] + (high[i] - low[i]) * up - texel[i]).abs()).fold(0.0, f64::max)
        });
        off.fold(0.0, f64::max)
    };
    // The precision of half floats.
    assert!(worst(2.0) < 5e-4, "{}", worst(2.0));
    // Planted: another gradient.
    assert!(worst(1.9) > 5e-3);
    // Lengths and colours alone do not cause a pass.
    let (has_pass, same) = passes(Sky { spacing_px: 9.0, outline_px: 3.0, star_px: 4.0, ..wash.clone() });
    assert!(!has_pass && same == picture);
    let (has_pass, other) = passes(Sky { stars: 0.5, ..wash });
    assert!(has_pass && other != picture);
}

#[test]
fn a_map_has_no_sky() {
    let Some(mut world) = world() else { return };
    let pose = world.pose("0,0,6000,0,-90,45");
    let (sky, _) = sky_of(&mut world, pose, &rich(), &north_west());
    let first = sky[0];
    assert_eq!(first[3], 0.0);
    assert!(sky.iter().all(|texel| *texel == first));
}

#[test]
fn rules_are_lines_of_a_drawing() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    let lines_of = |world: &mut World, keys: &str| {
        let style = style(keys);
        let request = PictureRequest::still(pose, SIZE_PX, &style, north_west());
        let drawn = render_strokes(&world.gpu, &mut None, &mut world.surfaces, &request, None).unwrap();
        drawn.marks.into_iter().find(|group| group.id == "sky").map(|group| group.lines)
    };
    let lines = lines_of(&mut world, "rules_px = 1.0\nspacing_px = 10.0\nfade = 0.0\n").unwrap();
    let length = |line: &hachure::lines::strokes::polylines::Polyline| {
        let step = |pair: &[_]| -> f32 {
            let [a, b]: [hachure::lines::strokes::polylines::PolylinePoint; 2] = [pair[0], pair[1]];
            (a.px[0] - b.px[0]).hypot(a.px[1] - b.px[1])
        };
        line.points.windows(2).map(step).sum::<f32>()
    };
    let long = lines.iter().filter(|line| length(line) > 400.0).count();
    let horizon_px = 135.0 + still(pose, SIZE_PX).focal_px() * 12.0_f64.to_radians().tan();
    println!("{long} rules of {} lines over {horizon_px:.1} px", lines.len());
    assert!((long as f64 - horizon_px / 10.0).abs() < 2.0);
    assert!(lines_of(&mut world, "stars = 1.0\n").is_none());
}
