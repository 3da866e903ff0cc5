//! Tests contour lines of height: they are at their heights, have the requested width, and belong to maps.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{NOON, draw, floats, places_m, still};
use common::{World, full, grid_of};
use glam::DVec3;
use hachure::frame::Renderer;
use hachure::style::layers::HEIGHT_INK;
use hachure::style::{HeightLines, HeightsOf, Style};

const SIZE_PX: [u32; 2] = [320, 200];
const INTERVAL_M: f32 = 40.0;
/// A view straight down, and a view along the land.
const VIEWS: [&str; 2] = ["0,0,6000,0,-90,40", "0,-5000,2600,10,-20,45"];

/// A slope with waves that are long compared with the samples that the form of the land smooths over.
fn height_m(x_m: f64, y_m: f64) -> f64 {
    700.0 + 0.16 * x_m - 0.07 * y_m + 90.0 * (x_m / 1900.0).sin() * (y_m / 2300.0).cos()
}

fn world() -> Option<World> {
    World::new(grid_of(513, 513, 25.0, height_m), 0.2)
}

fn style(change: impl Fn(&mut HeightLines)) -> Style {
    let mut style = Style::load("pen").unwrap();
    change(style.lowest_height_lines_mut().unwrap());
    style
}

/// The kinds of the style's other layers.
const OTHERS: [&str; 4] = ["drainage", "ground", "strokes", "water"];

/// Returns the same style for a test of the lines. In the fast tier it has no layers of some kinds, and simple tones.
fn lines(unneeded: &[&str], change: impl Fn(&mut HeightLines)) -> Style {
    let mut style = style(change);
    if !full() {
        style = style.without(unneeded);
        style.tone = Style::load("plain").unwrap().tone;
    }
    style
}

/// Ink of a pixel, its distance in pixels to the nearest contour line, and the gap between lines there.
struct Shown {
    ink: f64,
    away_px: f64,
    is_index: bool,
    gap_px: f64,
}

/// The ink and the position of each pixel.
type Drawn = (Vec<[f32; 1]>, Vec<Option<DVec3>>);

fn drawn(world: &mut World, camera: &str, style: &Style, size_px: [u32; 2]) -> Drawn {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, size_px), style, &NOON);
    let ink = floats::<1>(&world.gpu, renderer.target(&HEIGHT_INK).unwrap());
    (ink, places_m(&world.gpu, &renderer, pose.position_m))
}

fn shown((ink, places): &Drawn, [interval_m, from_m]: [f64; 2]) -> Vec<Shown> {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let height_at = |x: usize, y: usize| places[y * width + x].map(|place| height_m(place.x, place.y));
    let mut found = Vec::new();
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let around = [height_at(x - 1, y), height_at(x + 1, y), height_at(x, y - 1), height_at(x, y + 1)];
            let (Some(here_m), [Some(west), Some(east), Some(north), Some(south)]) = (height_at(x, y), around) else {
                continue;
            };
            let rise_m = 0.5 * (east - west).hypot(south - north);
            // Next to a skyline, neighbours do not give the slope.
            if (east - 2.0 * here_m + west).abs().max((south - 2.0 * here_m + north).abs()) > 0.2 * rise_m {
                continue;
            }
            let above_m = here_m - from_m;
            let number = (above_m / interval_m).round();
            let away_px = (above_m - number * interval_m).abs() / rise_m;
            let is_index = number.rem_euclid(5.0) == 0.0;
            let gap_px = interval_m / rise_m;
            found.push(Shown { ink: f64::from(ink[y * width + x][0]), away_px, is_index, gap_px });
        }
    }
    found
}

/// Returns the share of inked pixels that are on no line, and of pixels in the middle of a line that have no ink.
fn wrong(shown: &[Shown]) -> [f64; 2] {
    let share = |picked: &dyn Fn(&&Shown) -> bool, bad: &dyn Fn(&&Shown) -> bool| {
        let all: Vec<&Shown> = shown.iter().filter(picked).collect();
        assert!(all.len() > 300, "{}", all.len());
        all.iter().filter(|own| bad(own)).count() as f64 / all.len() as f64
    };
    [
        share(&|own| own.ink > 0.4, &|own| own.away_px > 1.2),
        share(&|own| own.away_px < 0.3 && own.gap_px > 8.0, &|own| own.ink < 0.4),
    ]
}

#[test]
fn lines_lie_at_their_heights() {
    let Some(mut world) = world() else { return };
    let style = lines(&OTHERS, |lines| lines.interval_m = INTERVAL_M);
    for camera in VIEWS {
        let drawn = drawn(&mut world, camera, &style, SIZE_PX);
        let found = shown(&drawn, [f64::from(INTERVAL_M), 0.0]);
        let [astray, missing] = wrong(&found);
        println!("{camera}: {:.2} % astray, {:.2} % missing", 100.0 * astray, 100.0 * missing);
        assert!(astray < 0.01 && missing < 0.01);
        // Planted errors: lines of another interval, and an origin that is off by a quarter of it.
        let interval_m = f64::from(INTERVAL_M);
        for planted in [[1.1 * interval_m, 0.0], [interval_m, 0.25 * interval_m]] {
            let [astray, missing] = wrong(&shown(&drawn, planted));
            assert!(astray > 0.3 && missing > 0.3, "{astray} {missing}");
        }
    }
}

#[test]
fn lines_are_as_wide_as_asked() {
    let Some(mut world) = world() else { return };
    for (line_px, index_px) in [(0.7, 1.3), (1.5, 3.0)] {
        let style = lines(&OTHERS, |lines| {
            lines.interval_m = INTERVAL_M;
            lines.line_px = line_px;
            lines.index_px = index_px;
        });
        let found = shown(&drawn(&mut world, VIEWS[0], &style, SIZE_PX), [f64::from(INTERVAL_M), 0.0]);
        // Over the picture, each pixel covers its part of the gap from one line to the next.
        let width_px = |is_index: bool| {
            let of_line = || found.iter().filter(|own| own.is_index == is_index);
            let ink: f64 = of_line().map(|own| own.ink).sum();
            ink / of_line().map(|own| 1.0 / own.gap_px).sum::<f64>()
        };
        let [line, index] = [false, true].map(width_px);
        println!("requested {line_px} and {index_px} px, measured {line:.2} and {index:.2} px");
        assert!((line / f64::from(line_px) - 1.0).abs() < 0.1 && (index / f64::from(index_px) - 1.0).abs() < 0.1);
    }
}

/// Radius of a cone that is steeper toward its middle.
const STEEP_FOOT_M: f64 = 5000.0;

fn cone_m(x_m: f64, y_m: f64) -> f64 {
    let out = (x_m.hypot(y_m) / STEEP_FOOT_M).min(1.0);
    0.5 * STEEP_FOOT_M * (1.0 - out) * (1.0 - out)
}

/// Returns the slope at a distance from the middle, in degrees.
fn cone_slope_deg(away_m: f64) -> f64 {
    (1.0 - (away_m / STEEP_FOOT_M).min(1.0)).atan().to_degrees()
}

#[test]
fn steep_land_has_no_lines() {
    let Some(mut world) = World::new(grid_of(513, 513, 25.0, cone_m), 0.2) else { return };
    // Returns the mean ink on slopes of each whole degree.
    let ink_by_slope = |world: &mut World, steepest_deg: f32| {
        let style = lines(&OTHERS, |lines| {
            // Lines at this interval stay apart on the steepest slope.
            lines.interval_m = 60.0;
            lines.steepest_deg = steepest_deg;
        });
        let (ink, places) = drawn(world, "0,0,14000,0,-90,40", &style, SIZE_PX.map(|side| 2 * side));
        let mut sums = [[0.0, 0.0]; 46];
        for ([ink], place) in ink.iter().zip(places) {
            let Some(place) = place else { continue };
            let slope_deg = cone_slope_deg(place.x.hypot(place.y));
            sums[slope_deg.round() as usize][0] += f64::from(*ink);
            sums[slope_deg.round() as usize][1] += 1.0;
        }
        sums.map(|[ink, pixels]| if pixels > 30.0 { Some(ink / pixels) } else { None })
    };
    let all = ink_by_slope(&mut world, 90.0);
    // Returns the ratio of the ink on slopes between two angles to that without a limit.
    let left = |some: &[Option<f64>; 46], slopes_deg: std::ops::RangeInclusive<usize>| {
        let pairs: Vec<[f64; 2]> = slopes_deg.filter_map(|slope| Some([some[slope]?, all[slope]?])).collect();
        // A single degree may have only pixels between two lines.
        assert!(pairs.len() > 3 && pairs.iter().map(|[_, all]| all).sum::<f64>() > 0.3, "{pairs:?}");
        pairs.iter().map(|[some, _]| some).sum::<f64>() / pairs.iter().map(|[_, all]| all).sum::<f64>()
    };
    // Lines fade out from 0.8 of the limit's tangent on.
    let is_right = |some: &[Option<f64>; 46], steepest_deg: usize| {
        let fades_deg = (0.8 * (steepest_deg as f64).to_radians().tan()).atan().to_degrees();
        let [gentle, steep] = [left(some, 5..=fades_deg as usize - 1), left(some, steepest_deg + 1..=40)];
        println!("up to {steepest_deg}°: {gentle:.3} of the ink is left below, {steep:.3} above");
        gentle > 0.98 && steep < 0.01
    };
    for steepest_deg in [25, 34].into_iter().take(if full() { 2 } else { 1 }) {
        let some = ink_by_slope(&mut world, steepest_deg as f32);
        assert!(is_right(&some, steepest_deg));
        // Planted errors: another limit, below and above, and no limit.
        for planted in [steepest_deg as f32 - 5.0, steepest_deg as f32 + 5.0] {
            assert!(!is_right(&ink_by_slope(&mut world, planted), steepest_deg), "{planted}");
        }
        assert!(!is_right(&all, steepest_deg));
    }
}

#[test]
fn lines_without_an_interval_are_for_maps() {
    let Some(mut world) = world() else { return };
    let style = style(|_| {});
    let pose = world.pose(VIEWS[1]);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &NOON);
    assert!(renderer.target(&HEIGHT_INK).is_none());
    let of_map = style.clone().for_map(20.0).unwrap();
    let above = still(world.pose(VIEWS[0]), SIZE_PX);
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &above, &of_map, &NOON);
    assert!(renderer.target(&HEIGHT_INK).is_some());
    // An interval in the style holds on maps, too.
    let own = self::style(|lines| lines.interval_m = 15.0).for_map(20.0).unwrap();
    assert_eq!(own.lowest_height_lines().unwrap().interval_m, 15.0);
}

/// Height of a lake, a little below a contour line.
const LAKE_M: f64 = 719.5;

#[test]
fn lakes_have_no_lines() {
    let land = grid_of(513, 513, 25.0, |x_m, y_m| height_m(x_m, y_m).max(LAKE_M));
    let Some(mut world) = World::new(land, 0.2) else { return };
    let mut ink_on_water = |style: &Style| {
        let (ink, places) = drawn(&mut world, VIEWS[0], style, SIZE_PX);
        let on_water = ink.iter().zip(places).filter(|(_, place)| {
            // Beyond the strip in which the surface is still curved.
            place.is_some_and(|place_m| height_m(place_m.x, place_m.y) < LAKE_M - 4.0)
        });
        let (count, sum) = on_water.fold((0, 0.0), |(count, sum), ([ink], _)| (count + 1, sum + f64::from(*ink)));
        assert!(count > 5000);
        sum
    };
    let with_water = lines(&OTHERS[..3], |lines| lines.interval_m = INTERVAL_M);
    let without = with_water.clone().without(&["water"]);
    let [found, planted] = [&with_water, &without].map(&mut ink_on_water);
    println!("ink of lines on a lake just below one: {found:.2} px, without a water map {planted:.1} px");
    assert!(found < 1.0);
    // Planted error: a style without water.
    assert!(planted > 20.0);
}

/// Height of the sea.
const SEA_M: f64 = 710.0;

/// Tests that depth contours are drawn below the sea that a scene names, at depths that count from its surface, and that
/// contour lines of the same style are above it.
#[test]
fn the_sea_has_lines_of_its_depths() {
    let Some(mut world) = world() else { return };
    world.surfaces.set_sea_level(Some(SEA_M));
    let mut drawn_of = |of: HeightsOf| {
        let style = lines(&OTHERS[..3], |lines| (lines.of, lines.interval_m) = (of, INTERVAL_M));
        drawn(&mut world, VIEWS[0], &style, SIZE_PX)
    };
    let [sea, land] = [HeightsOf::Sea, HeightsOf::Land].map(&mut drawn_of);
    // The ink above the sea, and below it.
    let split = |(ink, places): &Drawn| {
        let mut sums = [0.0; 2];
        for ([ink], place) in ink.iter().zip(places) {
            if let Some(place) = place {
                sums[usize::from(height_m(place.x, place.y) < SEA_M)] += f64::from(*ink);
            }
        }
        sums
    };
    println!("ink above and below the sea: depths {:?}, heights {:?}", split(&sea), split(&land));
    assert!(split(&sea)[0] < 1.0 && split(&sea)[1] > 500.0 && split(&land)[1] < 1.0 && split(&land)[0] > 500.0);
    let below = |[interval_m, from_m]: [f64; 2]| {
        let (ink, places) = &sea;
        let is_below = |place: &DVec3| height_m(place.x, place.y) < SEA_M - f64::from(INTERVAL_M);
        let places = places.iter().map(|place| place.filter(is_below)).collect();
        wrong(&shown(&(ink.clone(), places), [interval_m, from_m]))
    };
    let interval_m = f64::from(INTERVAL_M);
    let [astray, missing] = below([interval_m, SEA_M]);
    println!("{:.2} % astray, {:.2} % missing", 100.0 * astray, 100.0 * missing);
    assert!(astray < 0.01 && missing < 0.01);
    // Planted error: heights instead of depths.
    let [astray, missing] = below([interval_m, 0.0]);
    assert!(astray > 0.3 && missing > 0.3, "{astray} {missing}");
    // A world without a sea has none.
    world.surfaces.set_sea_level(None);
    let none = drawn(
        &mut world,
        VIEWS[0],
        &lines(&OTHERS[..3], |own| (own.of, own.interval_m) = (HeightsOf::Sea, INTERVAL_M)),
        SIZE_PX,
    );
    assert!(split(&none).iter().sum::<f64>() < 1.0);
}
