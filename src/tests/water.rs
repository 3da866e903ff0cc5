//! Tests still water: lakes and the sea are found where heights are level and nowhere else, the shore and the distance
//! from it are right, and water has a tint and lines but no hatching marks.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::sync::Arc;

use common::draw::{draw, floats, halves, north_west, places_m, still};
use common::{World, grid_of, quantile};
use glam::DVec3;
use hachure::frame::{Light, Renderer};
use hachure::scene::Scene;
use hachure::scene::scene_file::SceneError;
use hachure::scene::view::{Part, Pose, Rig, View};
use hachure::style::Style;
use hachure::surface::water::WATER;
use hachure::tiles::Terrain;
use hachure::tiles::slot_maps::MOST_MAPS;
use hachure::tiles::terrain::{Loading, TerrainOptions};
use hachure::tones::balance::MARKS;
use hachure::tones::water::{WATER_INK, WATERED};

const SIZE_PX: [u32; 2] = [480, 270];
/// The smallest allowed error of the mesh that matters, in pixels: the finest tiles are drawn, as with an error of 0, but
/// no patch is divided that is exact.
const FINEST_PX: f64 = 1.0 / 64.0;
const LEVEL_M: f64 = 500.0;
const RADIUS_M: f64 = 2000.0;
/// Maps of 25, 61 and 123 m per pixel, which show three successive levels of samples 30 m apart.
const MAPS: [&str; 3] = ["130,70,8000,0,-90,45", "130,70,20000,0,-90,45", "130,70,40000,0,-90,45"];
const OBLIQUE: &str = "0,-5200,+1400,3,-22,50";

fn style() -> Style {
    let text = "name = \"water\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\nlightest = 0.6\n\
                [water]\ntint = \"#c0d0e0\"\nshore_px = 1\nlines = 3\nspacing_px = 5\n";
    Style::parse("water", text).unwrap()
}

/// A pixel of the land: its point, its width, and its value in the water target.
struct Pixel {
    place_m: DVec3,
    pixel_m: f64,
    water_m: f64,
}

fn water_of(world: &mut World, camera: &str) -> (Vec<Option<Pixel>>, Renderer) {
    let pose = world.pose(camera);
    let view = still(pose, SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let light = Light { haze_m: 1e9, ..north_west() };
    for _ in 0..2 {
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style(), &light);
    }
    (pixels(world, &renderer, &view), renderer)
}

fn pixels(world: &World, renderer: &Renderer, view: &View) -> Vec<Option<Pixel>> {
    let eye_m = view.pose.position_m;
    // A view that is known to be dry has no picture of water.
    let water = renderer.target(&WATER).map(|water| floats::<1>(&world.gpu, water));
    let water = water.unwrap_or_else(|| vec![[0.0]; SIZE_PX[0] as usize * SIZE_PX[1] as usize]);
    let pixel = |(place, [water]): (Option<DVec3>, [f32; 1])| {
        place.map(|place_m| Pixel {
            place_m,
            pixel_m: place_m.distance(eye_m) / view.focal_px(),
            water_m: water.into(),
        })
    };
    places_m(&world.gpu, renderer, eye_m).into_iter().zip(water).map(pixel).collect()
}

/// Returns the part of the land that is water.
fn share(world: &mut World, camera: &str) -> f64 {
    let (pixels, _) = water_of(world, camera);
    let land: Vec<f64> = pixels.iter().flatten().map(|pixel| pixel.water_m).collect();
    land.iter().filter(|water_m| **water_m > 0.0).count() as f64 / land.len() as f64
}

/// Returns the height of a round lake in a bowl.
fn bowl_m(x_m: f64, y_m: f64) -> f64 {
    LEVEL_M + (0.15 * (x_m.hypot(y_m) - RADIUS_M)).max(0.0)
}

/// Returns how far the shore is from a circle, in pixels, and the relative errors of the distance from the shore.
/// Distances count if they are more than 4 pixels and three samples, and within the reach of the lines.
fn errors(pixels: &[Option<Pixel>], radius_m: f64) -> [Vec<f64>; 2] {
    let (mut shore, mut distance) = (Vec::new(), Vec::new());
    for pixel in pixels.iter().flatten() {
        let true_m = radius_m - pixel.place_m.truncate().length();
        if pixel.water_m != 0.0 && pixel.water_m.abs() < 0.7 * pixel.pixel_m {
            shore.push((true_m - pixel.water_m).abs() / pixel.pixel_m);
        }
        if true_m > (4.0 * pixel.pixel_m).max(100.0) && true_m < 18.0 * pixel.pixel_m {
            distance.push((pixel.water_m - true_m).abs() / true_m);
        }
    }
    assert!(shore.len() > 60 && distance.len() > 60, "{} {}", shore.len(), distance.len());
    [shore, distance]
}

#[test]
fn a_round_lake_has_its_shore_and_its_distances() {
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, bowl_m), FINEST_PX) else { return };
    for camera in MAPS.into_iter().chain([OBLIQUE]) {
        let (pixels, _) = water_of(&mut world, camera);
        let [mut shore, mut distance] = errors(&pixels, RADIUS_M);
        let [shore, distance] = [quantile(&mut shore, 0.95), quantile(&mut distance, 0.95)];
        println!("{camera}: 95 % of the shore within {shore:.2} px; 95 % of distances within {distance:.3}");
        // A lake that is 16 samples wide to either side on the visible level has a coarser shore.
        let most = if camera == MAPS[2] { [1.5, 0.15] } else { [1.0, 0.05] };
        assert!(shore < most[0] && distance < most[1], "{camera}: {shore} {distance}");
        // Planted: a shore moved by two pixels or more.
        let pixel_m = pixels.iter().flatten().map(|pixel| pixel.pixel_m).fold(f64::INFINITY, f64::min);
        let [mut shore, mut distance] = errors(&pixels, RADIUS_M + 2.0 * pixel_m.max(30.0));
        assert!(quantile(&mut shore, 0.95) > most[0] && quantile(&mut distance, 0.95) > most[1]);
    }
}

/// Tests that distances are continuous where four tiles meet in the middle of the lake.
#[test]
fn tiles_agree() {
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, bowl_m), FINEST_PX) else { return };
    let (pixels, _) = water_of(&mut world, MAPS[0]);
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let rough = |shift: usize| {
        let mut steps = Vec::new();
        let pairs = (1..height).flat_map(|y| (1..width).map(move |x| y * width + x));
        for (i, next) in pairs.flat_map(|i| [(i, i - 1), (i, i - width)]) {
            let pair = [next, (i + shift) % pixels.len()].map(|i| pixels[i].as_ref());
            let [Some(a), Some(b)] = pair else { continue };
            // Near the borders of tiles, which are 256 samples wide.
            let is_near_border = a.place_m.x.abs().min(a.place_m.y.abs()) < 60.0;
            if a.water_m > 0.0 && b.water_m > 0.0 && is_near_border {
                steps.push((a.water_m - b.water_m).abs() / a.pixel_m);
            }
        }
        assert!(steps.len() > 100);
        quantile(&mut steps, 1.0)
    };
    let most = rough(0);
    println!("distances change by at most {most:.2} px from a pixel to the next");
    assert!(most > 0.9 && most < 1.5);
    // Planted: a picture whose neighbouring rows do not match.
    assert!(rough(6 * width) > 1.5);
}

/// Returns the bowl, loaded as in a window.
fn streamed() -> Option<World> {
    let mut world = World::new(grid_of(513, 513, 30.0, bowl_m), FINEST_PX)?;
    let options = TerrainOptions { loading: Loading::Stream, ..TerrainOptions::default() };
    world.surfaces = Terrain::new(&world.gpu, Arc::clone(world.surfaces.terrain.store()), options).unwrap().into();
    Some(world)
}

/// Flies from a map to an oblique view, in frames that do not wait, until no frame is late. Returns the last picture,
/// and the largest number of maps built in one frame. With `loses`, each frame is first prepared without being drawn,
/// so that those maps are never built.
fn flown(loses: bool) -> Option<(Vec<Option<Pixel>>, usize)> {
    let mut world = streamed()?;
    let (mut renderer, style) = (Renderer::new(&world.gpu).unwrap(), style());
    let light = Light { haze_m: 1e9, ..north_west() };
    let mut most = 0;
    for camera in [MAPS[1], OBLIQUE] {
        let view = still(world.pose(camera), SIZE_PX);
        let mut settles = false;
        for _ in 0..200 {
            if loses {
                hachure::frame::prepare(&world.gpu, &mut world.surfaces, &Rig::mono(view), &style, &light);
            }
            let drawn = draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &light);
            most = most.max(world.surfaces.terrain.water_maps().unwrap().jobs().len());
            settles = !drawn.tiles.late;
            if settles {
                break;
            }
        }
        assert!(settles, "{camera}: it is still late");
    }
    let view = still(world.pose(OBLIQUE), SIZE_PX);
    Some((pixels(&world, &renderer, &view), most))
}

/// Counts pixels of two pictures whose distances differ by more than a hundredth of a pixel.
fn differing<'a>(a: impl Iterator<Item = &'a Option<Pixel>>, b: impl Iterator<Item = &'a Option<Pixel>>) -> usize {
    let pairs = a.zip(b).filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?)));
    pairs.filter(|(a, b)| (a.water_m - b.water_m).abs() > 0.01 * a.pixel_m).count()
}

#[test]
fn cached_maps_equal_rebuilt_maps() {
    let Some((kept, most)) = flown(false) else { return };
    assert!((1..=MOST_MAPS).contains(&most), "{most} maps in a frame");
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, bowl_m), FINEST_PX) else { return };
    let (rebuilt, _) = water_of(&mut world, OBLIQUE);
    let differ = differing(kept.iter(), rebuilt.iter());
    println!("{differ} pixels differ after a flight");
    assert!(differ < 20);
    // Planted: maps that count as built but are not.
    let Some((lost, _)) = flown(true) else { return };
    assert!(differing(lost.iter(), rebuilt.iter()) > 200);
}

#[test]
fn parts_and_eyes_have_the_water_of_the_whole() {
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, bowl_m), FINEST_PX) else { return };
    let (whole, mut renderer) = water_of(&mut world, OBLIQUE);
    let light = Light { haze_m: 1e9, ..north_west() };
    let view = still(world.pose(OBLIQUE), SIZE_PX);
    let (left, top, width, height) = (250, 90, 170, 120);
    let part = Part { origin_px: [left, top], size_px: [width, height] };
    let view_of_part = View { part, ..view };
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view_of_part, &style(), &light);
    let part = pixels(&world, &renderer, &view_of_part);
    let within = |left: i32| {
        let at = move |i: usize| {
            (top as usize + i / width as usize) * SIZE_PX[0] as usize + left as usize + i % width as usize
        };
        (0..part.len()).map(at).collect::<Vec<usize>>()
    };
    let of_whole = |left: i32| differing(within(left).into_iter().map(|i| &whole[i]), part.iter());
    println!("{} of {} pixels of a part differ", of_whole(left), part.len());
    assert!(part.iter().flatten().filter(|pixel| pixel.water_m > 0.0).count() > 2000);
    assert!(of_whole(left) < 20);
    // Planted: a part that is moved by two pixels.
    assert!(of_whole(left + 2) > 200);

    // The second of two eyes is drawn as if it were alone.
    let aside = DVec3::new(40.0, 0.0, 0.0);
    let other = View { pose: Pose { position_m: view.pose.position_m + aside, ..view.pose }, ..view };
    let rig = Rig { origin_m: view.pose.position_m + 0.5 * aside, eyes: vec![other, view] };
    renderer.render_eyes(&world.gpu, &mut world.surfaces, &rig, &style(), &light).unwrap();
    let eye: Vec<f64> =
        floats::<1>(&world.gpu, renderer.eye_target(1, &WATER).unwrap()).into_iter().map(|[m]| m.into()).collect();
    let off = |shift: usize| {
        let pairs = whole.iter().zip(eye.iter().skip(shift)).filter_map(|(pixel, eye)| Some((pixel.as_ref()?, eye)));
        pairs.filter(|(pixel, water_m)| (pixel.water_m - *water_m).abs() > 0.05 * pixel.pixel_m).count()
    };
    println!("{} pixels of an eye differ", off(0));
    assert!(off(0) < 200);
    assert!(off(2) > 1000);
}

/// Returns land in whole metres, with a constant slope.
fn terraces_m(slope_deg: f64) -> impl Fn(f64, f64) -> f64 {
    move |x_m, y_m| (300.0 + slope_deg.to_radians().tan() * (0.8 * x_m + 0.6 * y_m)).round()
}

#[test]
fn terraces_are_no_lakes() {
    for slope_deg in [1.0, 0.3, 0.1] {
        let Some(mut world) = World::new(grid_of(513, 513, 30.0, terraces_m(slope_deg)), FINEST_PX) else { return };
        for camera in [MAPS[0], OBLIQUE, MAPS[1]].into_iter().take(if common::full() { 3 } else { 2 }) {
            let water = share(&mut world, camera);
            println!("terraces of {slope_deg} degrees, {camera}: {water:.5} is water");
            assert!(water < 0.005, "{slope_deg} {camera}: {water}");
        }
    }
    // Control: a terrace that is a lake, also in whole metres.
    let lake = |x_m: f64, y_m: f64| {
        let wall_m = 0.2 * (x_m.hypot(y_m) - RADIUS_M);
        if wall_m < 0.0 { 280.0 } else { 280.0 + wall_m.round() }
    };
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, lake), FINEST_PX) else { return };
    assert!(share(&mut world, MAPS[0]) > 0.1);
}

#[test]
fn level_land_without_a_shore_is_no_lake() {
    let Some(mut world) = World::new(grid_of(257, 257, 30.0, |_, _| 300.0), FINEST_PX) else { return };
    assert_eq!(share(&mut world, MAPS[0]), 0.0);
    // Control: the sea is higher.
    world.surfaces.set_sea_level(Some(301.0));
    assert_eq!(share(&mut world, MAPS[0]), 1.0);
}

#[test]
fn the_sea_stands_where_the_scene_says() {
    let slope = |x_m: f64, y_m: f64| 0.05 * x_m + 20.0 * (y_m / 900.0).sin();
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, slope), FINEST_PX) else { return };
    assert_eq!(share(&mut world, MAPS[0]), 0.0);
    world.surfaces.set_sea_level(Some(10.0));
    let (pixels, _) = water_of(&mut world, MAPS[0]);
    let wrong = |level_m: f64| {
        let pixels: Vec<&Pixel> = pixels.iter().flatten().collect();
        // Within a sample of the shore, a pixel may be either.
        let far = |pixel: &&&Pixel| (slope(pixel.place_m.x, pixel.place_m.y) - level_m).abs() > 0.05 * 30.0;
        let is_wrong = |pixel: &&Pixel| (pixel.water_m > 0.0) != (slope(pixel.place_m.x, pixel.place_m.y) <= level_m);
        let far: Vec<&Pixel> = pixels.iter().filter(far).copied().collect();
        far.iter().filter(|pixel| is_wrong(pixel)).count() as f64 / far.len() as f64
    };
    println!("{:.5} of the land is on the wrong side of the shore", wrong(10.0));
    assert!(wrong(10.0) < 0.002);
    // Planted: another level.
    assert!(wrong(13.0) > 0.002);
}

#[test]
fn water_that_is_level_at_the_sea_s_height_is_the_sea() {
    let coast = |x_m: f64, y_m: f64| (0.01 * x_m + 4.0 * (y_m / 700.0).sin()).round().max(0.0);
    let side = if common::full() { 513 } else { 257 };
    let Some(mut world) = World::new(grid_of(side, side, 30.0, coast), FINEST_PX) else { return };
    let (pixels, _) = water_of(&mut world, MAPS[0]);
    let far = pixels.iter().flatten().filter(|pixel| pixel.place_m.x < -900.0).map(|pixel| pixel.water_m > 0.0);
    let far: Vec<bool> = far.collect();
    assert!(far.len() > 1000 && far.iter().all(|is_water| *is_water));
    // Control: the same gentle land, above the sea.
    let Some(mut inland) =
        World::new(grid_of(side, side, 30.0, |x, y| coast(x, y) + (y * 0.004).round() + 40.0), FINEST_PX)
    else {
        return;
    };
    assert!(share(&mut inland, MAPS[0]) < 0.05);
}

#[test]
fn water_has_a_tint_and_lines_and_no_marks() {
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, bowl_m), FINEST_PX) else { return };
    let (pixels, renderer) = water_of(&mut world, MAPS[1]);
    let tones = halves(&world.gpu, renderer.target(&WATERED).unwrap());
    let ink: Vec<f32> =
        floats::<1>(&world.gpu, renderer.target(&WATER_INK).unwrap()).into_iter().map(|[ink]| ink).collect();
    let tint = style().water().unwrap().tint.linear();
    let mut rings = [0.0_f64; 14];
    for (i, pixel) in pixels.iter().enumerate().filter_map(|(i, pixel)| Some((i, pixel.as_ref()?))) {
        let away_px = pixel.water_m / pixel.pixel_m;
        if away_px > 1.5 {
            assert!((0..3).all(|c| (tones[i][c] - f64::from(tint[c])).abs() < 0.01) && tones[i][3] == 1.0);
        }
        if pixel.water_m == 0.0 {
            assert!(tones[i][3] < 0.61 && ink[i] == 0.0);
        }
        if (0.0..14.0).contains(&away_px) {
            let ring = &mut rings[away_px as usize];
            *ring = ring.max(ink[i].into());
        }
    }
    println!("most ink by the distance in pixels: {rings:.2?}");
    // Ink is expected at the shore, at the first line at 5 px, and at the second one at 5 + 6.75 px, with paper in
    // between.
    assert!(rings[0] > 0.6 && rings[4].max(rings[5]) > 0.5 && rings[11].max(rings[12]) > 0.3);
    assert!(rings[2] < 0.1 && rings[8] < 0.1);

    // Light so dim that no land is white because of it.
    let text = hachure::style::preset_text("pencil").unwrap();
    let text = text.replace("level_deg = 2", "level_deg = 0").replace("exposure = 1.3", "exposure = 0.5");
    // Marks depend on no strokes.
    let others: &[&str] = if common::full() { &[] } else { &["strokes"] };
    let wet = Style::parse("wet", &text).unwrap().without(others);
    let dry = wet.clone().without(&["water"]);
    let marked = |world: &mut World, style: &Style| {
        let view = still(world.pose(MAPS[1]), SIZE_PX);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &north_west());
        let marks = floats::<1>(&world.gpu, renderer.target(&MARKS).unwrap());
        let is_inside =
            |at: &&(Option<DVec3>, [f32; 1])| at.0.is_some_and(|at| at.truncate().length() < RADIUS_M - 200.0);
        let all: Vec<_> = places_m(&world.gpu, &renderer, view.pose.position_m).into_iter().zip(marks).collect();
        all.iter().filter(is_inside).map(|(_, [ink])| *ink).fold(0.0, f32::max)
    };
    assert_eq!(marked(&mut world, &wet), 0.0);
    // Control: without water there are marks, because level land is not left white.
    assert!(dry.water().is_none() && marked(&mut world, &dry) > 0.5);
}

#[test]
fn real_land_has_the_lakes_that_it_has() {
    let shares = [
        ("mt_everest_90m.tif", "0,0,140000,0,-90,50", 0.0, 0.002),
        ("N49W123.tif", "0,0,90000,0,-90,40", 0.01, 0.06),
        ("craterlake-elev-16bit-30m.tif", "0,0,9000,0,-90,50", 0.0, 0.01),
    ];
    // In the fast tier only the land with lakes.
    for (name, camera, least, most) in shares.into_iter().filter(|(_, _, least, _)| common::full() || *least > 0.0) {
        let Some(mut world) = World::real(&format!("dem/geotiff/{name}"), FINEST_PX) else { return };
        let water = share(&mut world, camera);
        println!("{name}: {water:.5} is water");
        assert!((least..=most).contains(&water), "{name}: {water}");
    }
}

#[test]
fn a_scene_says_how_high_the_sea_is() {
    let read = |text: &str| Scene::parse("x.toml".as_ref(), &format!("[world]\nprocedural = {{ seed = 1 }}\n{text}"));
    assert_eq!(read("[water]\nsea_level_m = 3.5").unwrap().sea_level_m, Some(3.5));
    assert_eq!(read("").unwrap().sea_level_m, None);
    for text in ["[water]\nsea_level_m = nan", "[water]\nsea_level_m = 1e6", "[water]\nsea = 3"] {
        assert!(matches!(read(text), Err(SceneError::Toml(_))), "{text}");
    }
}
