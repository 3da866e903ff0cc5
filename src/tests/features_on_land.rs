//! Tests points, lines and outlines of files on the land: they lie where the surface is, land hides them, and layers of a
//! style draw what they name.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]
#![allow(clippy::disallowed_methods, reason = "files go to temporary folders")]

use std::path::{Path, PathBuf};

use glam::DVec2;

use crate::tests::common;

use common::draw::{NOON, draw, still};
use common::{World, full, grid_of, quantile};
use hachure::draped::Draped;
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::gpu::target::Target;
use hachure::internals::read;
use hachure::lines::draped::FEATURE_INK;
use hachure::scene::FeatureFile;
use hachure::scene::view::View;
use hachure::source::GeoKeys;
use hachure::source::georeference::{Crs, Georeference};
use hachure::style::Style;

pub(super) const SIZE_PX: [u32; 2] = [320, 240];
const STEP_M: f64 = 25.0;
const SAMPLES: u32 = 321;
/// Projected coordinates of the world's origin.
const ORIGIN_M: DVec2 = DVec2::new(500_000.0, 5_200_000.0);
/// From above, and along and across hills that hide more of the line than they show.
const CAMERAS: [&str; 3] = ["0,0,6000,0,-90,45", "1500,-2500,+350,20,-15,60", "-2500,500,+500,90,-15,60"];
/// Distance between places on a line where it is compared, in metres.
const PLACE_M: f64 = 1.0;

/// Rounded hills with steep flanks.
fn height_m(x_m: f64, y_m: f64) -> f64 {
    let hills = (x_m / 420.0).sin() * (y_m / 510.0).cos();
    700.0 + 260.0 * hills + 25.0 * (x_m / 97.0 + y_m / 131.0).sin()
}

/// The corners of a line that winds over hills and valleys.
fn winding() -> Vec<DVec2> {
    let at = |i: i32| {
        let t = f64::from(i) / 60.0;
        DVec2::new(3000.0 * (3.0 * t).sin(), -3000.0 + 5600.0 * t + 260.0 * (17.0 * t).cos())
    };
    (0..=60).map(at).collect()
}

pub(super) struct Files(tempfile::TempDir);

impl Files {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(super) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

/// Returns GeoJSON of features: properties, kind of geometry, and coordinates.
pub(super) fn geojson(features: &[(&str, &str, String)]) -> String {
    let feature = |(properties, kind, coordinates): &(&str, &str, String)| {
        format!(
            "{{\"type\":\"Feature\",\"properties\":{{{properties}}},\"geometry\":{{\"type\":\"{kind}\",\"coordinates\":\
             {coordinates}}}}}"
        )
    };
    let features: Vec<String> = features.iter().map(feature).collect();
    format!(
        "{{\"type\":\"FeatureCollection\",\"crs\":{{\"type\":\"name\",\"properties\":{{\"name\":\"EPSG:32632\"}}}},\
         \"features\":[{}]}}",
        features.join(",")
    )
}

pub(super) fn coordinates(line: &[DVec2]) -> String {
    format!("{:?}", line.iter().map(|at| (*at + ORIGIN_M).to_array()).collect::<Vec<_>>())
}

/// Returns the georeference of the land, in zone 32 of UTM.
fn place() -> Georeference {
    place_of(SAMPLES, STEP_M)
}

/// Returns the georeference of land with a number of samples in each direction.
fn place_of(samples: u32, step_m: f64) -> Georeference {
    let half_m = 0.5 * f64::from(samples - 1) * step_m;
    let corner = ORIGIN_M + DVec2::new(-half_m, half_m);
    let crs = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32632".to_owned() };
    Georeference { crs_from_grid: [corner.x, step_m, 0.0, corner.y, 0.0, -step_m], crs, geokeys: GeoKeys::default() }
}

pub(super) fn world() -> Option<World> {
    World::new(grid_of(SAMPLES, SAMPLES, STEP_M, height_m), 0.2)
}

/// Puts files onto the land of a world.
pub(super) fn put(world: &mut World, paths: &[&Path]) {
    put_on(world, paths, SAMPLES, STEP_M);
}

/// Does the same as [`put`] on land with another number of samples in each direction.
pub(super) fn put_on(world: &mut World, paths: &[&Path], samples: u32, step_m: f64) {
    let files: Vec<_> = paths.iter().map(|path| FeatureFile { path: path.to_path_buf(), layer: None }).collect();
    world.surfaces.set_features(Draped::read(&files, None, &place_of(samples, step_m), [samples; 2]).unwrap());
}

pub(super) fn style(layer: &str) -> Style {
    let text = format!(
        "name = \"lines\"\ndescription = \"Lines.\"\n[[layers]]\nkind = \"features\"\n{layer}\n[tone]\nkind = \"plain\"\n"
    );
    Style::parse("lines", &text).unwrap()
}

/// Draws a view and returns the ink of each pixel.
fn ink(world: &mut World, view: &View, style: &Style) -> Vec<f64> {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, view, style, &NOON);
    let Some(target) = renderer.target(&FEATURE_INK) else { return vec![0.0; (SIZE_PX[0] * SIZE_PX[1]) as usize] };
    ink_of(&world.gpu, target)
}

/// Returns the ink of each pixel of a picture of features.
pub(super) fn ink_of(gpu: &Gpu, target: &Target) -> Vec<f64> {
    let bytes = read(gpu, target, [0, 0], SIZE_PX).unwrap();
    bytes.chunks_exact(2).map(|texel| half::f16::from_le_bytes([texel[0], texel[1]]).to_f64()).collect()
}

/// How far land rises above the ray to the eye where it hides a place for certain, in pixels.
const HIDDEN_PX: f64 = 2.0;

/// A place on a line, as it is seen.
struct Place {
    px: DVec2,
    is_visible: bool,
    /// Whether land in front of it rises above the ray to the eye by more than [`HIDDEN_PX`].
    is_hidden: bool,
}

/// Returns the places of a line on the picture. Land hides a place if it is above the ray to the eye anywhere.
fn places(world: &World, view: &View, line: &[DVec2]) -> Vec<Place> {
    let terrain = &world.surfaces.terrain;
    let eye_m = view.pose.position_m;
    let mut found = Vec::new();
    for pair in line.windows(2) {
        let count = (pair[0].distance(pair[1]) / PLACE_M).ceil().max(1.0);
        for i in 0..count as u32 {
            let at = pair[0].lerp(pair[1], f64::from(i) / count);
            let Some(height_m) = terrain.height_m(at) else { continue };
            let at_m = at.extend(height_m);
            let Some(px) = view.place_px(at_m - eye_m) else { continue };
            let steps = (at_m.distance(eye_m) / 4.0).ceil();
            let above_px = (1..steps as u32).filter_map(|step| {
                let on_ray = at_m.lerp(eye_m, f64::from(step) / steps);
                let above_m = terrain.height_m(on_ray.truncate())? - on_ray.z;
                (above_m > 0.02).then(|| above_m * view.focal_px() / on_ray.distance(eye_m))
            });
            let above_px = above_px.fold(0.0, f64::max);
            found.push(Place { px, is_visible: above_px == 0.0, is_hidden: above_px > HIDDEN_PX });
        }
    }
    found
}

/// Returns the largest distance of the drawn line from the true one at 99 % of the pixels, in pixels, from the ink of a
/// line of one pixel, which is 1 less the distance. Only pixels are compared that are farther than 2 px from places of the
/// other kind: visible or hidden.
fn offset_px(ink: &[f64], places: &[Place]) -> (f64, usize) {
    let [width, height] = SIZE_PX.map(|side| side as i32);
    let mut nearest = vec![[f64::INFINITY; 2]; ink.len()];
    for place in places {
        let own = place.px.floor().as_ivec2();
        for y in (own.y - 3).max(0)..=(own.y + 3).min(height - 1) {
            for x in (own.x - 3).max(0)..=(own.x + 3).min(width - 1) {
                let away = place.px.distance(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                let known = &mut nearest[(y * width + x) as usize][usize::from(place.is_visible)];
                *known = known.min(away);
            }
        }
    }
    let compared = nearest.iter().zip(ink).filter(|([hidden, visible], _)| *hidden > 2.0 && *visible < 2.0);
    let mut errors: Vec<f64> = compared.map(|([_, away], ink)| ((1.0 - away).max(0.0) - ink).abs()).collect();
    let count = errors.len();
    (if errors.is_empty() { 0.0 } else { quantile(&mut errors, 0.99) }, count)
}

/// Returns how many pixels have ink at hidden places that are farther than 2 px from visible ones of the same line.
fn seen_through(ink: &[f64], places: &[Place]) -> usize {
    let visible: Vec<DVec2> = places.iter().filter(|place| place.is_visible).map(|place| place.px).collect();
    let hidden = places.iter().filter(|place| place.is_hidden);
    let far = hidden.filter(|place| visible.iter().all(|other| other.distance(place.px) > 2.0));
    let pixels: std::collections::BTreeSet<usize> = far
        .map(|place| place.px.floor().as_ivec2())
        .filter(|at| at.x >= 0 && at.y >= 0 && at.x < SIZE_PX[0] as i32 && at.y < SIZE_PX[1] as i32)
        .map(|at| (at.y * SIZE_PX[0] as i32 + at.x) as usize)
        .collect();
    pixels.into_iter().filter(|pixel| ink[*pixel] > 0.1).count()
}

#[test]
fn lines_are_on_the_surface_and_land_hides_them() {
    let Some(mut world) = world() else { return };
    let files = Files::new();
    let path = files.write("line.geojson", &geojson(&[("", "LineString", coordinates(&winding()))]));
    put(&mut world, &[&path]);
    let style = style("line_px = 1.0");
    let mut hidden = 0;
    for camera in CAMERAS {
        let view = still(world.pose(camera), SIZE_PX);
        let ink = ink(&mut world, &view, &style);
        let places = places(&world, &view, &winding());
        let (offset, count) = offset_px(&ink, &places);
        let through = seen_through(&ink, &places);
        hidden += places.iter().filter(|place| place.is_hidden).count();
        println!("{camera}: within {offset:.2} px at 99 % of {count} pixels; {through} hidden pixels have ink");
        assert!(count > 150, "{camera}: {count} pixels");
        assert!(offset < 0.5, "{camera}: {offset} px");
        assert!(through <= 2, "{camera}: {through} hidden pixels have ink");
        // Planted: the line is shifted by three quarters of a pixel, and what is hidden is exchanged with what is visible.
        let shifted = |place: &Place| Place { px: place.px + DVec2::new(0.75, 0.75), ..*place };
        let shifted: Vec<Place> = places.iter().map(shifted).collect();
        assert!(offset_px(&ink, &shifted).0 > 0.5, "{camera}: a shift is not found");
        let exchanged: Vec<Place> =
            places.iter().map(|at| Place { px: at.px, is_visible: at.is_hidden, is_hidden: at.is_visible }).collect();
        assert!(seen_through(&ink, &exchanged) > 50, "{camera}: exchanged visibility is not found");
    }
    assert!(hidden > 500, "the views hide {hidden} places");
}

#[test]
fn layers_draw_what_they_name() {
    let Some(mut world) = world() else { return };
    let files = Files::new();
    let line = |x_m: f64| coordinates(&[DVec2::new(x_m, -2500.0), DVec2::new(x_m, 2500.0)]);
    let square = [[-3000.0, -3000.0], [3000.0, -3000.0], [3000.0, 3000.0], [-3000.0, 3000.0], [-3000.0, -3000.0]];
    let ways = [
        ("\"kind\":\"path\"", "LineString", line(-1500.0)),
        ("\"kind\":\"road\"", "LineString", line(1500.0)),
        ("\"kind\":\"park\"", "Polygon", format!("[{}]", coordinates(&square.map(DVec2::from_array)))),
    ];
    let ways = files.write("ways.geojson", &geojson(&ways));
    let middle = coordinates(&[DVec2::ZERO]);
    let huts = files.write("huts.geojson", &geojson(&[("", "Point", middle[1..middle.len() - 1].to_owned())]));
    put(&mut world, &[&ways, &huts]);
    let view = still(world.pose("0,0,9000,0,-90,50"), SIZE_PX);
    // The sums of ink near the path, the road, the outline of the park, and the hut.
    let parts_px: Vec<DVec2> = [[-1500.0, 1000.0], [1500.0, 1000.0], [0.0, 3000.0], [0.0, 0.0]]
        .into_iter()
        .map(|at| {
            let at = DVec2::from_array(at);
            let height_m = world.surfaces.terrain.height_m(at).unwrap();
            view.place_px(at.extend(height_m) - view.pose.position_m).unwrap()
        })
        .collect();
    let drawn = |world: &mut World, layer: &str| {
        // Areas have no fill, so that ink is that of lines and points.
        let ink = ink(world, &view, &style(&format!("fill = 0\n{layer}")));
        let near = |px: DVec2| {
            let around = (-2..=2).flat_map(|y| (-2..=2).map(move |x| (px.x as i32 + x, px.y as i32 + y)));
            around.map(|(x, y)| ink[(y * SIZE_PX[0] as i32 + x) as usize]).sum::<f64>() > 1.0
        };
        let parts: Vec<bool> = parts_px.iter().map(|px| near(*px)).collect();
        <[bool; 4]>::try_from(parts).unwrap()
    };
    for (layer, expected) in [
        ("", [true, true, true, true]),
        ("file = \"huts\"", [false, false, false, true]),
        ("file = \"Ways\"", [true, true, true, false]),
        ("file = \"rivers\"", [false; 4]),
        ("when = \"kind == 'path'\"", [true, false, false, false]),
        ("when = \"kind in ('road', 'park')\"", [false, true, true, false]),
        ("of = \"lines\"", [true, true, false, false]),
        ("of = \"areas\"", [false, false, true, false]),
        ("of = \"points\"", [false, false, false, true]),
        ("when = \"name == 'x'\"", [false; 4]),
        ("line_px = 0", [false, false, false, true]),
        ("point_px = 0", [true, true, true, false]),
    ] {
        assert_eq!(drawn(&mut world, layer), expected, "{layer}");
    }
    let features = world.surfaces.features().unwrap();
    let doubts = |layer: &str| features.doubts(&[style(layer).lowest_features().unwrap()]).join("; ");
    assert_eq!(doubts(""), "");
    assert!(doubts("file = \"rivers\"").contains("no file or layer is called \"rivers\"; there are ways, huts"));
    assert!(
        doubts("when = \"kimd == 'path'\"").contains("did you mean \"kind\"?"),
        "{}",
        doubts("when = \"kimd == 'path'\"")
    );
    assert!(doubts("file = \"ways\"").contains("no layer of the style draws \"huts\""));
    // Dashes have less ink than a solid line.
    let sum = |world: &mut World, layer: &str| ink(world, &view, &style(layer)).iter().sum::<f64>();
    let part = sum(&mut world, "of = \"lines\"\ndash_px = 6\ngap_px = 6") / sum(&mut world, "of = \"lines\"");
    assert!((0.4..0.65).contains(&part), "dashes have {part} of the ink");
    let wrong = Style::parse(
        "x.toml",
        "name = \"x\"\ndescription = \"\"\n[[layers]]\nkind = \"features\"\nwhen = \"kind = 'path'\"\n[tone]\nkind = \"plain\"\n",
    );
    let wrong = wrong.unwrap_err().to_string();
    assert!(wrong.contains("features.when") && wrong.contains("column 6"), "{wrong}");
}

#[test]
fn every_reference_system_gives_the_same_line() {
    let Some(mut world) = world() else { return };
    let files = Files::new();
    // Corners about the world's origin, in zone 32 of UTM and in longitude and latitude, by Snyder's series (1987, "Map
    // Projections: A Working Manual").
    let own = coordinates(&[DVec2::new(0.0, 0.0), DVec2::new(1000.0, 1000.0)]);
    let own = files.write("own.geojson", &geojson(&[("", "LineString", own)]));
    let degrees = "{\"type\":\"LineString\",\"coordinates\":[[9,46.95352920],[9.01314428,46.96252728]]}";
    let degrees = files.write("degrees.geojson", degrees);
    let view = still(world.pose("500,500,3500,0,-90,40"), SIZE_PX);
    let style = style("line_px = 2");
    put(&mut world, &[&own]);
    let a = ink(&mut world, &view, &style);
    put(&mut world, &[&degrees]);
    let b = ink(&mut world, &view, &style);
    let sums = [&a, &b].map(|ink| ink.iter().sum::<f64>());
    let differs = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f64>();
    assert!(sums[0] > 50.0, "{sums:?}");
    assert!(differs < 0.15 * sums[0], "{differs} of {sums:?}");
}

#[test]
fn many_lines_are_simplified_to_what_is_seen() {
    let Some(mut world) = world() else { return };
    let files = Files::new();
    // 300 lines of 400 vertices, each of which trembles by a few centimetres.
    let lines = if full() { 300 } else { 100 };
    let line = |number: i32| {
        let at = |i: i32| {
            let aside = 0.05 * common::random(i.into(), number.into());
            DVec2::new(-3900.0 + 7800.0 * f64::from(number) / f64::from(lines) + aside, -3900.0 + 19.5 * f64::from(i))
        };
        ("", "LineString", coordinates(&(0..400).map(at).collect::<Vec<_>>()))
    };
    let path = files.write("many.geojson", &geojson(&(0..lines).map(line).collect::<Vec<_>>()));
    put(&mut world, &[&path]);
    let style = style("line_px = 1");
    let view = still(world.pose("0,0,20000,0,-90,45"), SIZE_PX);
    let far = ink(&mut world, &view, &style).iter().sum::<f64>();
    let features = world.surfaces.features().unwrap();
    let points: u32 = features.layer(0).unwrap().blocks.iter().map(|block| block.count).sum();
    println!("{points} of {} points are drawn, with {far:.0} px of ink", 400 * lines);
    assert!(points < 40 * lines as u32, "{points} points of {lines} straight lines");
    assert!(far > 5000.0, "{far}");
    // From near only what is in view is there.
    let view = still(world.pose("0,0,+60,0,-30,45"), SIZE_PX);
    ink(&mut world, &view, &style);
    let blocks = world.surfaces.features().unwrap().layer(0).map_or(0, |layer| layer.blocks.len());
    assert!((1..2 * lines as usize).contains(&blocks), "{blocks} blocks");
}

/// Lines end at the border of the land, and lines outside of it are not drawn.
#[test]
fn lines_end_with_the_land() {
    let Some(mut world) = world() else { return };
    let files = Files::new();
    let across = coordinates(&[DVec2::new(-90_000.0, 0.0), DVec2::new(90_000.0, 0.0)]);
    let away = coordinates(&[DVec2::new(-90_000.0, 4_300.0), DVec2::new(90_000.0, 4_300.0)]);
    let path = files.write("a.geojson", &geojson(&[("", "LineString", across), ("", "LineString", away)]));
    put(&mut world, &[&path]);
    let view = still(world.pose("0,0,12000,0,-90,45"), SIZE_PX);
    let ink = ink(&mut world, &view, &style("line_px = 2"));
    let row = &ink[120 * 320..121 * 320];
    let drawn = row.iter().filter(|ink| **ink > 0.4).count();
    // 8000 m, seen from 11 300 m above.
    let width_px = 8000.0 * view.focal_px() / (12_000.0 - height_m(0.0, 0.0));
    assert!((drawn as f64 - width_px).abs() < 8.0, "{drawn} of {width_px} px");
    let off: f64 = ink.iter().enumerate().filter(|(i, _)| (i / 320).abs_diff(120) > 12).map(|(_, ink)| ink).sum();
    assert_eq!(off, 0.0);
}

#[test]
fn graticules_have_their_coordinates() {
    let Some(mut world) = world() else { return };
    let view = still(world.pose("0,0,12000,0,-90,45"), SIZE_PX);
    let named = style("file = \"graticule\"\nline_px = 1.5");
    // The mean ink of places on a north-south line, and of places on an east-west line.
    let along = |world: &World, ink: &[f64], place_m: &dyn Fn(f64) -> DVec2| {
        let inks = (-30..=30).map(|i| {
            let at = place_m(100.0 * f64::from(i));
            let height_m = world.surfaces.terrain.height_m(at).unwrap();
            let px = view.place_px(at.extend(height_m) - view.pose.position_m).unwrap().floor();
            let around = [-1.0, 0.0, 1.0].into_iter().flat_map(|y| [-1.0, 0.0, 1.0].map(|x| px + DVec2::new(x, y)));
            around.map(|px| ink[(px.y * 320.0 + px.x) as usize]).fold(0.0, f64::max)
        });
        inks.sum::<f64>() / 61.0
    };
    // The central meridian of the zone is at x = 0, and a hundredth of a degree is 760 m of longitude here. The parallel of
    // 46.95 is 392 m south of the middle.
    for (graticule, lines_m, gap_m, line_y_m, gap_y_m) in
        [("0.01", [0.0, 760.6, -760.6], 380.0, -392.2, 556.0), ("1000m", [0.0, 1000.0, -2000.0], 500.0, 1000.0, 500.0)]
    {
        let draped = Draped::read(&[], Some(graticule.parse().unwrap()), &place(), [SAMPLES; 2]).unwrap();
        world.surfaces.set_features(draped);
        let drawn = ink(&mut world, &view, &named);
        for x_m in lines_m {
            let mean = along(&world, &drawn, &|y_m| DVec2::new(x_m, y_m));
            assert!(mean > 0.6, "{graticule}: {mean} at {x_m} m");
            // Planted: halfway to the next line there is only what crosses it.
            let mean = along(&world, &drawn, &|y_m| DVec2::new(x_m + gap_m, y_m));
            assert!(mean < 0.3, "{graticule}: {mean} between lines");
        }
        let mean = along(&world, &drawn, &|x_m| DVec2::new(x_m, line_y_m));
        assert!(mean > 0.6, "{graticule}: {mean} at {line_y_m} m north");
        let mean = along(&world, &drawn, &|x_m| DVec2::new(x_m, line_y_m + gap_y_m));
        assert!(mean < 0.3, "{graticule}: {mean} between lines");
        let unnamed = ink(&mut world, &view, &style("line_px = 1.5"));
        assert_eq!(unnamed.iter().sum::<f64>(), 0.0, "{graticule}: a layer that does not name it draws it");
    }
    let error = |graticule: &str| {
        Draped::read(&[], Some(graticule.parse().unwrap()), &place(), [SAMPLES; 2]).err().unwrap().to_string()
    };
    assert!(error("0.00001").contains("lines; at most 1000 are drawn"), "{}", error("0.00001"));
}
