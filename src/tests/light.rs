//! Tests light from the sun and the sky on the land: shadows are where a ray toward the sun meets the land, the visible
//! sky agrees with a formula, neither has seams or pops, and only styles that use them pay for them.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::sync::Arc;

use common::draw::{draw, halves, normals, places_m, still};
use common::hill::Hill;
use common::{World, grid_of, rough_height_m};
use glam::{DVec2, DVec3};
use hachure::frame::{self, Light, Renderer};
use hachure::gpu::recorder::Submits;
use hachure::gpu::trace::PassTrace;
use hachure::scene::Sun;
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::Style;
use hachure::tiles::Terrain;
use hachure::tiles::horizon_maps::HORIZON_MAP_BYTES;
use hachure::tiles::slot_maps::{MAPS_AT_ONCE, MOST_MAPS};
use hachure::tiles::terrain::{Loading, TerrainOptions};
use hachure::tones::TONE;

const SIZE_PX: [u32; 2] = [240, 160];

/// Returns a style whose tone is light alone.
fn style(ambient: f32, shadow: f32, occlusion: f32) -> Style {
    let text = format!(
        "name = \"light\"\ndescription = \"\"\n[light]\nwrap = 0\nambient = {ambient}\nshadow = {shadow}\n\
         occlusion = {occlusion}\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\nlightest = 1\nsoftness = 1\n"
    );
    Style::parse("light", &text).unwrap()
}

/// Returns a style whose tone is the visible part of the sky.
fn sky() -> Style {
    style(1.0, 0.0, 1.0)
}

fn sun(azimuth_deg: f64, elevation_deg: f64) -> Light {
    Light { to_sun: Sun { azimuth_deg, elevation_deg }.direction(), haze_m: 1e9, haze_srgb: None, focus: None }
}

/// Results of a frame.
#[derive(Clone)]
struct Drawn {
    tone: Vec<f64>,
    /// In the world; `None` for the sky.
    place_m: Vec<Option<DVec3>>,
    normal: Vec<DVec3>,
    passes: Vec<String>,
    jobs: usize,
    late: bool,
    toon_ms: f64,
}

fn whole_view(pose: Pose) -> View {
    still(pose, SIZE_PX)
}

fn drawing(world: &mut World, renderer: &mut Renderer, style: &Style, light: &Light, pose: Pose) -> Drawn {
    let view = whole_view(pose);
    let gpu = &world.gpu;
    let prepared = draw(gpu, &mut world.surfaces, renderer, &view, style, light);
    let tone = halves(gpu, renderer.target(&TONE).unwrap()).into_iter().map(|texel| texel[3]).collect();
    let direction = |[x, y, z, _]: [f32; 4]| DVec3::new(x.into(), y.into(), z.into());
    let normal = normals(gpu, renderer).into_iter().map(direction).collect();
    let place_m = places_m(gpu, renderer, pose.position_m);
    let times = renderer.take_times().unwrap_or_default();
    let toon_ms = times.iter().filter(|time| time.name == "tones/toon").map(|time| time.gpu_ms).sum();
    Drawn {
        tone,
        place_m,
        normal,
        passes: times.into_iter().map(|time| time.name).collect(),
        jobs: world.surfaces.terrain.horizon_maps().map_or(0, |seen| seen.maps.jobs().len()),
        late: prepared.tiles.late,
        toon_ms,
    }
}

fn shot(world: &mut World, style: &Style, light: &Light, camera: &str) -> Drawn {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    drawing(world, &mut renderer, style, light, pose)
}

/// Compares pixels that are clear of a shadow's border with rays toward the sun. Returns the part that agrees, among
/// lit or among shadowed pixels, whichever is less, and the number of pixels in shadow.
fn agreement(hill: &Hill, drawn: &Drawn, to_sun: DVec3, texel_m: f64, half_m: DVec2) -> (f64, u32) {
    let lit = |x_m: f64, y_m: f64, to_sun: DVec3| {
        let from = DVec3::new(x_m, y_m, hill.height_m(x_m, y_m) + 0.02);
        hill.hit(from, to_sun, half_m).is_none()
    };
    // Numbers of lit and of shadowed pixels: all, and those that are right.
    let (mut clear, mut right) = ([0_u32; 2], [0_u32; 2]);
    for (i, at) in drawn.place_m.iter().enumerate() {
        let Some(at) = at else { continue };
        let diffuse = drawn.normal[i].dot(to_sun);
        if diffuse < 0.02 || at.truncate().abs().cmpgt(half_m - 200.0).any() {
            continue;
        }
        let expected = lit(at.x, at.y, to_sun);
        // Two texels to each side, and the height of the penumbra up and down.
        let aside =
            [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.7, 0.7), (-0.7, 0.7), (0.7, -0.7), (-0.7, -0.7)];
        let is_clear =
            aside.iter().all(|(x, y)| lit(at.x + 2.0 * texel_m * x, at.y + 2.0 * texel_m * y, to_sun) == expected)
                && [-0.012, 0.012].iter().all(|up| lit(at.x, at.y, (to_sun + DVec3::Z * *up).normalize()) == expected);
        if !is_clear {
            continue;
        }
        let class = usize::from(!expected);
        clear[class] += 1;
        right[class] += u32::from((drawn.tone[i] / diffuse > 0.5) == expected);
    }
    assert!(clear[0] > 5000, "{clear:?} pixels are clear of a border");
    let part = |class: usize| f64::from(right[class]) / f64::from(clear[class].max(1));
    (part(0).min(part(1)), clear[1])
}

#[test]
fn shadows_are_where_rays_meet_the_land() {
    let (hill, grid) = Hill::square(641, 10.0);
    let Some(mut world) = World::new(grid, 1.0) else {
        return;
    };
    let half_m = DVec2::splat(3200.0);
    for (azimuth_deg, elevation_deg) in [(250.0, 7.0), (80.0, 4.0), (0.0, 9.0)] {
        let light = sun(azimuth_deg, elevation_deg);
        for camera in ["0,0,6000,0,-90,50", "-1500,-2500,700,30,-14,60"] {
            let drawn = shot(&mut world, &style(0.0, 1.0, 0.0), &light, camera);
            let (right, dark) = agreement(&hill, &drawn, light.to_sun, 20.0, half_m);
            println!(
                "sun {azimuth_deg}, {elevation_deg}, camera {camera}: {:.3} % agree, {dark} pixels in shadow",
                100.0 * right
            );
            assert!(right >= 0.98, "only {right} of the pixels agree");
            assert!(dark > 60, "only {dark} pixels are in shadow");
            // Planted errors: a sun in another direction, and a sun that casts no shadows.
            let (turned, _) = agreement(&hill, &drawn, sun(azimuth_deg + 25.0, elevation_deg).to_sun, 20.0, half_m);
            let lit = shot(&mut world, &style(0.0, 0.0, 0.0), &light, camera);
            let (lit, _) = agreement(&hill, &lit, light.to_sun, 20.0, half_m);
            assert!(turned < 0.98 && lit < 0.98, "turned {turned}, without shadow {lit}");
        }
    }
}

#[test]
fn exposure_makes_land_white() {
    let Some(mut world) = World::new(grid_of(65, 65, 20.0, rough_height_m), 1.0) else {
        return;
    };
    let light = sun(315.0, 40.0);
    let mut tone = |exposure: f32| {
        let mut style = style(0.0, 0.0, 0.0);
        style.light.exposure = exposure;
        shot(&mut world, &style, &light, "0,-900,+300,0,-30,60").tone
    };
    let [as_is, brighter, dimmer] = [1.0, 1.5, 0.5].map(&mut tone);
    let is_times = |other: &[f64], factor: f64| {
        as_is.iter().zip(other).all(|(a, b)| ((a * factor).min(1.0) - b).abs() < 2e-3 || *a >= 0.9995)
    };
    assert!(is_times(&brighter, 1.5) && is_times(&dimmer, 0.5));
    assert!(!is_times(&brighter, 1.4) && !is_times(&as_is, 0.5));
}

#[test]
fn the_visible_sky_is_what_a_formula_says() {
    let seen = |height_m: &dyn Fn(f64, f64) -> f64| {
        let mut world = World::new(grid_of(601, 601, 20.0, height_m), 1.0)?;
        let drawn = shot(&mut world, &sky(), &sun(0.0, 30.0), "0,0,+1500,0,-90,30");
        let low = drawn.place_m.iter().zip(&drawn.tone).filter(|(at, _)| at.is_some_and(|at| at.x.abs() < 4.0));
        let low: Vec<f64> = low.map(|(_, tone)| *tone).collect();
        assert!(low.len() > 100);
        Some((low.iter().copied().fold(1.0, f64::min), low.iter().copied().fold(0.0, f64::max)))
    };
    let Some(plane) = seen(&|_, _| 700.0) else {
        return;
    };
    assert!(plane.0 > 0.999, "a plane sees {plane:?}");
    let exact = |angle_deg: f64| {
        let tangent = angle_deg.to_radians().tan();
        let hidden = |i: i32| (tangent * (f64::from(i).to_radians() + 0.5_f64.to_radians()).sin().abs()).atan().sin();
        1.0 - (0..360).map(hidden).sum::<f64>() / 360.0
    };
    for angle_deg in [15.0_f64, 35.0, 50.0] {
        let (least, most) = seen(&|x, _| x.abs() * angle_deg.to_radians().tan()).unwrap();
        let exact_here = exact(angle_deg);
        println!("valley of {angle_deg}°: {least:.4} to {most:.4}, exact {exact_here:.4}");
        let is_within = |exact: f64| (least - exact).abs() < 0.05 && (most - exact).abs() < 0.05;
        assert!(is_within(exact_here), "{least} to {most}, not {exact_here}");
        assert!(!is_within(exact(angle_deg + 15.0)), "a valley of another angle was not detected");
    }
}

/// Returns the largest difference between the tones of adjacent pixels on the same land.
fn largest_jump(drawn: &Drawn, apart_m: f64) -> f64 {
    let width = SIZE_PX[0] as usize;
    let mut jump = 0.0_f64;
    for i in 0..drawn.tone.len() {
        for j in [i + 1, i + width] {
            if j % width == 0 || j >= drawn.tone.len() {
                continue;
            }
            let (Some(a), Some(b)) = (drawn.place_m[i], drawn.place_m[j]) else {
                continue;
            };
            if a.distance(b) < apart_m {
                jump = jump.max((drawn.tone[i] - drawn.tone[j]).abs());
            }
        }
    }
    jump
}

#[test]
fn there_are_no_seams_and_nothing_pops() {
    let (_, grid) = Hill::square(641, 10.0);
    let Some(mut world) = World::new(grid, 1.0) else {
        return;
    };
    // The whole hill, with the corners of four tiles, and a view along it, over three levels of detail.
    for (camera, most) in [("0,0,6000,0,-90,50", 0.02), ("-1200,-1900,400,30,-12,60", 0.035)] {
        let drawn = shot(&mut world, &sky(), &sun(0.0, 30.0), camera);
        let jump = largest_jump(&drawn, 80.0);
        println!("{camera}: neighbours differ by {jump:.4} at most");
        assert!(jump < most, "{jump}");
        let mut planted = drawn;
        planted.tone.iter_mut().skip(SIZE_PX[0] as usize * 120).for_each(|tone| *tone += 0.06);
        assert!(largest_jump(&planted, 80.0) > most, "a planted seam was not detected");
    }
    // The camera rises by 0.6 % per frame, from one level of detail through the next.
    let (style, light) = (style(0.2, 1.0, 1.0), sun(250.0, 12.0));
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let (mut before, mut steps): (Option<Drawn>, Vec<f64>) = (None, Vec::new());
    for i in 0..120 {
        let pose = world.pose(&format!("100,-50,{},0,-90,40", 2400.0 * 1.006_f64.powi(i)));
        let drawn = drawing(&mut world, &mut renderer, &style, &light, pose);
        if let Some(before) = &before {
            steps.push(mean_step(before, &drawn));
        }
        before = Some(drawn);
    }
    let median = common::quantile(&mut steps.clone(), 0.5);
    let worst = steps.iter().copied().fold(0.0, f64::max);
    println!("from frame to frame tones change by {median:.5} on the median, {worst:.5} at most");
    assert!(worst < 3.0 * median + 0.001, "a frame changes by {worst}, the median one by {median}");
    // Planted error: an eighth of a frame's pixels have the tones of another level.
    let mut popped = before.clone().unwrap();
    popped.tone.iter_mut().step_by(8).for_each(|tone| *tone += 0.08);
    assert!(mean_step(before.as_ref().unwrap(), &popped) > 3.0 * median + 0.001, "a planted pop was not detected");
}

/// Returns the mean difference of two pictures.
fn mean_step(a: &Drawn, b: &Drawn) -> f64 {
    a.tone.iter().zip(&b.tone).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.tone.len() as f64
}

const CAMERA: &str = "-2000,-3000,+300,30,-12,60";

fn rough() -> Option<World> {
    World::new(grid_of(1401, 1290, 20.0, rough_height_m), 1.0)
}

#[test]
fn at_rest_nothing_runs_and_the_sun_is_followed() {
    let Some(mut world) = rough() else { return };
    let style = style(0.3, 1.0, 1.0);
    let pose = world.pose(CAMERA);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let first = drawing(&mut world, &mut renderer, &style, &sun(100.0, 20.0), pose);
    assert!(
        first.jobs > MAPS_AT_ONCE && !first.late,
        "a picture must wait for all of its tiles; maps made: {}",
        first.jobs
    );
    assert!(first.passes.is_empty() || first.passes.iter().any(|pass| pass == "surface/land/horizons"));
    let second = drawing(&mut world, &mut renderer, &style, &sun(100.0, 20.0), pose);
    assert_eq!((second.jobs, &second.tone), (0, &first.tone), "at rest");
    assert!(second.passes.iter().all(|pass| pass != "surface/land/horizons"));
    // A higher sun needs no new maps; a rotated one needs all of them.
    let higher = drawing(&mut world, &mut renderer, &style, &sun(100.0, 35.0), pose);
    assert!(higher.jobs == 0 && higher.tone != first.tone);
    let turned = drawing(&mut world, &mut renderer, &style, &sun(220.0, 20.0), pose);
    assert_eq!(turned.jobs, first.jobs);
    let fresh = shot(&mut rough().unwrap(), &style, &sun(220.0, 20.0), CAMERA);
    assert_eq!(turned.tone, fresh.tone, "maps must follow the sun's azimuth");
    assert!(mean_step(&first, &fresh) > 0.02, "another sun must make another picture");
}

/// Returns the rough land, loaded as in a window.
fn streamed() -> World {
    let mut world = rough().unwrap();
    let options = TerrainOptions { loading: Loading::Stream, ..TerrainOptions::default() };
    world.surfaces = Terrain::new(&world.gpu, Arc::clone(world.surfaces.terrain.store()), options).unwrap().into();
    world
}

/// Draws until no frame is late. Returns the last frame, the largest number of maps in one frame, and the number of all
/// maps. With `loses`, each frame is first prepared without being drawn, so that those maps are never made.
fn settle(
    world: &mut World,
    renderer: &mut Renderer,
    style: &Style,
    light: &Light,
    loses: bool,
) -> (Drawn, usize, usize) {
    let pose = world.pose(CAMERA);
    let (mut most, mut all) = (0, 0);
    for _ in 0..400 {
        if loses {
            frame::prepare(&world.gpu, &mut world.surfaces, &Rig::mono(whole_view(pose)), style, light);
        }
        let drawn = drawing(world, renderer, style, light, pose);
        most = most.max(drawn.jobs);
        all += drawn.jobs;
        if !drawn.late {
            return (drawn, most, all);
        }
    }
    panic!("it is still late");
}

#[test]
fn streaming_keeps_its_budget_and_ends_at_the_picture_of_a_file() {
    let Some(mut still) = rough() else { return };
    let (style, light) = (style(0.3, 1.0, 1.0), sun(100.0, 20.0));
    let expected = shot(&mut still, &style, &light, CAMERA);
    let mut world = streamed();
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let (settled, most, all) = settle(&mut world, &mut renderer, &style, &light, false);
    println!("{all} maps, at most {most} in a frame");
    assert!((1..=MOST_MAPS).contains(&most), "{most} maps in a frame");
    assert!(all > 2 * MAPS_AT_ONCE);
    assert_eq!(settled.tone, expected.tone, "the settled frame must equal the picture of a file");
    let pose = world.pose(CAMERA);
    let again = drawing(&mut world, &mut renderer, &style, &light, pose);
    assert_eq!((again.jobs, &again.tone), (0, &settled.tone), "at rest");
    // Switching to another style and back keeps the maps, and no frame is late.
    let bare = self::style(0.3, 0.0, 0.0);
    for _ in 0..2 {
        let other = drawing(&mut world, &mut renderer, &bare, &light, pose);
        assert!(mean_step(&other, &expected) > 0.02);
        let back = drawing(&mut world, &mut renderer, &style, &light, pose);
        assert_eq!((back.jobs, back.late, &back.tone), (0, false, &settled.tone), "back again");
    }
    // Planted error: maps that count as built but are not.
    let mut world = streamed();
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let (lost, ..) = settle(&mut world, &mut renderer, &style, &light, true);
    assert_ne!(lost.tone, expected.tone, "lost maps were not detected");
}

/// Returns the largest number of horizon dispatches in one submit of a frame, and the number of all of them.
fn fullest_submit(trace: &[PassTrace]) -> (usize, usize) {
    let of_maps = || trace.iter().filter(|pass| pass.name == "surface/land/horizons").map(|pass| pass.submit);
    (of_maps().map(|submit| of_maps().filter(|other| *other == submit).count()).max().unwrap_or(0), of_maps().count())
}

#[test]
fn a_file_makes_its_maps_in_bounded_submits() {
    let Some(mut world) = rough() else { return };
    let (style, light, pose) = (style(0.3, 1.0, 1.0), sun(100.0, 20.0), world.pose(CAMERA));
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_traces(true);
    let whole = drawing(&mut world, &mut renderer, &style, &light, pose);
    let trace = renderer.trace().to_vec();
    let parts = whole.jobs.div_ceil(MAPS_AT_ONCE);
    assert!(parts > 3, "{} maps", whole.jobs);
    assert_eq!(fullest_submit(&trace), (1, parts), "of {} maps", whole.jobs);
    // The rest of the frame is one submit, which begins with the last of them.
    let last = trace.last().unwrap().submit;
    assert_eq!(last as usize, parts - 1);
    assert!(trace.iter().filter(|pass| pass.submit == last).count() > 2);
    // The picture equals that of a frame whose passes are submitted one by one.
    assert_eq!(whole.tone, shot(&mut rough().unwrap(), &style, &light, CAMERA).tone);
    // Planted error: all dispatches in one submit.
    let planted: Vec<PassTrace> = trace.into_iter().map(|pass| PassTrace { submit: 0, ..pass }).collect();
    assert_eq!(fullest_submit(&planted), (parts, parts));
    // At rest a frame is one submit.
    drawing(&mut world, &mut renderer, &style, &light, pose);
    assert!(renderer.trace().iter().all(|pass| pass.submit == 0));
}

#[test]
fn only_who_asks_pays() {
    let Some(mut world) = rough() else { return };
    let (plain, lit, light) = (style(0.3, 0.0, 0.0), style(0.3, 0.5, 0.0), sun(100.0, 20.0));
    let pose = world.pose(CAMERA);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_submits(Submits::Timed);
    let first = drawing(&mut world, &mut renderer, &plain, &light, pose);
    let (bytes, targets) = (world.surfaces.terrain.gpu_bytes(), renderer.target_bytes());
    assert!(
        world.surfaces.terrain.horizon_maps().is_none()
            && first.passes.iter().all(|pass| pass != "surface/land/horizons")
    );

    let (mut quickest, mut quickest_lit) = (first.toon_ms, f64::INFINITY);
    for _ in 0..3 {
        quickest_lit = quickest_lit.min(drawing(&mut world, &mut renderer, &lit, &light, pose).toon_ms);
    }
    let more = world.surfaces.terrain.gpu_bytes() - bytes;
    let tiles = world.surfaces.terrain.horizon_maps().unwrap().maps.bytes();
    println!("{} KiB for {} tiles of horizons", tiles >> 10, tiles / HORIZON_MAP_BYTES);
    // The tables may grow by tiles next to the view.
    assert!(more >= tiles && more < tiles + (1 << 16), "{more} bytes, {tiles} of them tiles");
    assert_eq!(renderer.target_bytes(), targets);

    for _ in 0..3 {
        let again = drawing(&mut world, &mut renderer, &plain, &light, pose);
        assert_eq!(again.tone, first.tone);
        quickest = quickest.min(again.toon_ms);
    }
    // Maps are kept for a style that uses them again, so none is rebuilt.
    let back = drawing(&mut world, &mut renderer, &lit, &light, pose);
    assert_eq!(back.jobs, 0);
    println!("toon {quickest:.3} ms, with shadows {quickest_lit:.3} ms: {:.2} times", quickest_lit / quickest);
}
