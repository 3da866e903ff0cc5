//! Tests streams and ridge lines: they are where they are, grow with what drains through them, are hidden by land in
//! front of them, and belong to maps.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::time::{Duration, Instant};

use glam::DVec3;

use crate::drainage::{Drainage, Land};
use crate::tests::common;

use common::draw::{NOON, draw, places_m, still};
use common::{World, grid_of};
use hachure::frame::Renderer;
use hachure::internals::read;
use hachure::lines::drainage::DRAINAGE_INK;
use hachure::scene::view::Rig;
use hachure::style::{DrainageLines, DrainageViews, Style};

const SIZE_PX: [u32; 2] = [320, 240];
const STEP_M: f64 = 25.0;
/// Distance between valleys.
const PERIOD_M: f64 = 1600.0;
/// A view straight down, whose pixels are 21 m wide.
const FROM_ABOVE: &str = "0,0,7000,0,-90,40";

/// The middle of a valley that winds.
fn middle_m(y_m: f64) -> f64 {
    300.0 * (y_m / 700.0).sin()
}

/// Valleys along y, with ridges halfway between them, and with holes without outlets.
fn height_m(x_m: f64, y_m: f64) -> f64 {
    let across = std::f64::consts::TAU * (x_m - middle_m(y_m)) / PERIOD_M;
    300.0 * (1.0 - across.cos()) + 0.05 * y_m + 6.0 * (x_m / 130.0).sin() * (y_m / 170.0).cos()
}

fn world() -> Option<World> {
    World::new(grid_of(321, 321, STEP_M, height_m), 0.2)
}

fn style(of: &str, more: &str) -> Style {
    let text = format!(
        "name = \"lines\"\ndescription = \"Lines.\"\n[[layers]]\nkind = \"drainage\"\nof = \"{of}\"\n{more}\n[tone]\nkind = \"plain\"\n"
    );
    Style::parse("lines", &text).unwrap()
}

/// Draws a view and returns the ink of each pixel with the place that it shows.
fn shown(world: &mut World, camera: &str, style: &Style) -> Vec<(f64, Option<DVec3>)> {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), style, &NOON);
    let places = places_m(&world.gpu, &renderer, pose.position_m);
    let Some(target) = renderer.target(&DRAINAGE_INK) else { return places.into_iter().map(|at| (0.0, at)).collect() };
    let bytes = read(&world.gpu, target, [0, 0], SIZE_PX).unwrap();
    let ink = bytes.chunks_exact(2).map(|texel| half::f16::from_le_bytes([texel[0], texel[1]]).to_f64());
    ink.zip(places).collect()
}

/// Returns the distance of a place from the nearest valley (`aside` = 0) or ridge (0.5) in metres.
fn away_m(at: DVec3, aside: f64) -> f64 {
    let part = ((at.x - middle_m(at.y)) / PERIOD_M - aside).rem_euclid(1.0);
    PERIOD_M * part.min(1.0 - part)
}

/// Returns the largest distance from a valley or a ridge of all pixels with ink, in metres, and the share of the rows of
/// pixels in which the line in the middle of the picture is drawn.
fn measured(shown: &[(f64, Option<DVec3>)], aside: f64) -> (f64, f64) {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let mut farthest_m = 0.0_f64;
    let mut drawn = 0;
    for y in 0..height {
        let row = &shown[y * width..][..width];
        let inked = row.iter().filter(|(ink, _)| *ink > 0.4).filter_map(|(_, at)| *at);
        farthest_m = inked.map(|at| away_m(at, aside)).fold(farthest_m, f64::max);
        let is_near = |(ink, at): &&(f64, Option<DVec3>)| *ink > 0.4 && at.is_some_and(|at| away_m(at, aside) < 60.0);
        drawn += usize::from(row.iter().any(|pixel| is_near(&pixel)));
    }
    (farthest_m, drawn as f64 / height as f64)
}

#[test]
fn streams_and_ridge_lines_are_where_they_are() {
    let Some(mut world) = world() else { return };
    for (of, aside) in [("streams", 0.0), ("ridges", 0.5)] {
        let style = style(of, "views = \"all\"\nspacing_px = 50.0\nline_px = 1.5");
        let picture = shown(&mut world, FROM_ABOVE, &style);
        let (farthest_m, drawn) = measured(&picture, aside);
        assert!(farthest_m < 100.0, "{of}: ink {farthest_m} m away");
        assert!(drawn > 0.97, "{of}: in {drawn} of the rows");
        // Planted: the lines of the other kind.
        let (planted_m, planted) = measured(&picture, 0.5 - aside);
        assert!(planted_m > 600.0 && planted == 0.0, "{of}: {planted_m} m, {planted}");
    }
}

#[test]
fn lines_belong_to_maps() {
    let Some(mut world) = world() else { return };
    let on_maps = style("streams", "line_px = 1.5");
    let ink =
        |world: &mut World, style: &Style| shown(world, FROM_ABOVE, style).iter().map(|(ink, _)| ink).sum::<f64>();
    assert_eq!(ink(&mut world, &on_maps), 0.0);
    assert!(ink(&mut world, &on_maps.clone().for_map(20.0).unwrap()) > 100.0);
}

#[test]
fn smaller_spacing_draws_more_lines() {
    let Some(mut world) = world() else { return };
    let mut ink = |spacing_px: f64, gentlest_deg: f64| {
        let more = format!("views = \"all\"\nspacing_px = {spacing_px}\ngentlest_deg = {gentlest_deg}");
        shown(&mut world, FROM_ABOVE, &style("streams", &more)).iter().map(|(ink, _)| ink).sum::<f64>()
    };
    let [few, more, many] = [200.0, 60.0, 12.0].map(|spacing_px| ink(spacing_px, 0.0));
    assert!(few < 0.7 * more && more < 0.7 * many, "{few} {more} {many}");
    // Averaged over some samples, the sides of the valleys are nowhere as steep as that.
    assert_eq!(ink(12.0, 44.0), 0.0);
}

#[test]
fn land_hides_lines_behind_it() {
    let Some(mut world) = world() else { return };
    let style = style("streams", "views = \"all\"\nspacing_px = 60.0\nline_px = 1.5");
    // From a ridge across valleys: land hides some of them.
    let picture = shown(&mut world, "-800,-3000,1600,70,-22,60", &style);
    let inked = picture.iter().filter(|(ink, _)| *ink > 0.4);
    let away: Vec<f64> = inked.map(|(_, at)| at.map_or(f64::INFINITY, |at| away_m(at, 0.0))).collect();
    let astray = away.iter().filter(|away_m| **away_m > 120.0).count() as f64 / away.len() as f64;
    assert!(away.len() > 30, "{} pixels", away.len());
    assert!(astray < 0.1, "{astray} of the ink is on slopes in front of streams");
}

#[test]
fn a_window_does_not_wait_for_lines() {
    let Some(world) = world() else { return };
    let view = still(world.pose(FROM_ABOVE), SIZE_PX);
    let terrain = &world.surfaces.terrain;
    let land = Land { store: std::sync::Arc::clone(terrain.store()), projection: terrain.grid_projection().clone() };
    let rig = Rig::mono(view);
    let mut drainage = Drainage::default();
    let of = DrainageLines::Streams;
    drainage.follow(&world.gpu, &land, &rig, of, false);
    assert!(drainage.lines(of).is_none() && drainage.is_under_way());
    let start = Instant::now();
    while drainage.is_under_way() {
        assert!(start.elapsed() < Duration::from_secs(60), "the lines never come");
        std::thread::sleep(Duration::from_millis(5));
        drainage.take_arrived(&world.gpu);
    }
    assert_eq!(drainage.arrivals(), 1);
    // What is known is not computed again.
    drainage.follow(&world.gpu, &land, &rig, of, false);
    assert!(!drainage.is_under_way());
    let streamed = drainage.lines(of).unwrap().clone();
    let mut waited = Drainage::default();
    waited.follow(&world.gpu, &land, &rig, of, true);
    let waited = waited.lines(of).unwrap();
    assert_eq!((streamed.count, streamed.origin_m), (waited.count, waited.origin_m));
    assert!(streamed.count > 100);
    // The other kind has not been asked for.
    assert!(drainage.lines(DrainageLines::Ridges).is_none());
}

#[test]
fn a_layer_says_where_it_is_drawn() {
    let style = style("ridges", "");
    let layer = style.lowest_drainage().unwrap();
    assert_eq!((layer.of, layer.views), (DrainageLines::Ridges, DrainageViews::Maps));
    assert!(style.drainage_lines().next().is_none() && style.for_map(10.0).unwrap().drainage_lines().count() == 1);
}
