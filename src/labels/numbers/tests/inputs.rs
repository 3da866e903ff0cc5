//! Tests of unusual inputs.

use glam::DVec2;

use super::surfaces::{LETTER_PX, Scene, Traced, contours, width_px};
use super::{checked, waves};
use crate::labels::numbers::{Contour, Every, Page, Rules, Tops, place};

fn page<'a>(uphill: &'a dyn Fn(DVec2) -> Option<DVec2>) -> Page<'a> {
    Page {
        corners_px: [DVec2::ZERO, DVec2::splat(500.0)],
        obstacles_px: &[],
        letter_px: LETTER_PX,
        width_px: &width_px,
        uphill,
    }
}

fn line<'a>(points: &'a [DVec2], text: &'a str) -> Contour<'a> {
    Contour { points, is_closed: false, level_m: 100.0, is_index: true, is_depth: false, text }
}

#[test]
fn lines_without_room_have_no_number() {
    let page = page(&|_| None);
    let count = |contour: Contour<'_>| place(&[contour], &page, &Rules::default()).len();
    let straight = |length_px: f64| [DVec2::new(50.0, 50.0), DVec2::new(50.0 + length_px, 50.0)];
    // The text is 32 px long.
    assert_eq!(count(line(&straight(75.0), "1000")), 0);
    assert_eq!(count(line(&straight(85.0), "1000")), 1);
    assert_eq!(count(line(&straight(75.0), "10")), 1);
    assert_eq!(count(line(&straight(200.0), "")), 0);
    assert_eq!(count(line(&[], "1000")), 0);
    assert_eq!(count(line(&[DVec2::ONE], "1000")), 0);
    assert_eq!(count(line(&[DVec2::splat(70.0); 5], "1000")), 0);
    assert_eq!(count(line(&[DVec2::NAN; 5], "1000")), 0);
    assert_eq!(count(Contour { level_m: f64::NAN, ..line(&straight(200.0), "1000") }), 0);
    assert_eq!(count(line(&straight(1e8), "1000")), 0);
    // Off the page.
    let away = straight(200.0).map(|at| at - DVec2::new(0.0, 49.0));
    assert_eq!(count(line(&away, "1000")), 0);
    // Rings: one that bends too much, and a small one.
    let ring = |radius_px: f64| {
        let point =
            |i: u32| DVec2::splat(250.0) + radius_px * DVec2::from_angle(f64::from(i) / 40.0 * std::f64::consts::TAU);
        (0..40).map(point).collect::<Vec<_>>()
    };
    assert_eq!(count(Contour { is_closed: true, ..line(&ring(9.0), "100") }), 0);
    assert_eq!(count(Contour { is_closed: true, ..line(&ring(24.0), "100") }), 1);
}

#[test]
fn invalid_pages_have_no_numbers() {
    let points = [DVec2::new(50.0, 50.0), DVec2::new(250.0, 50.0)];
    let contours = [line(&points, "1000")];
    let uphill = |_: DVec2| Some(DVec2::NAN);
    let page = page(&uphill);
    assert_eq!(place(&contours, &page, &Rules::default()).len(), 1);
    for letter_px in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300, 1e300] {
        assert!(place(&contours, &Page { letter_px, ..page }, &Rules::default()).is_empty());
    }
    for spacing_px in [0.0, f64::NAN] {
        assert!(place(&contours, &page, &Rules { spacing_px, ..Rules::default() }).is_empty());
    }
    assert!(place(&contours, &Page { corners_px: [DVec2::NAN; 2], ..page }, &Rules::default()).is_empty());
    assert!(place(&contours, &Page { width_px: &|_| f64::NAN, ..page }, &Rules::default()).is_empty());
    let obstacles_px = [[DVec2::NAN; 2], [DVec2::splat(1e300), DVec2::splat(-1e300)]];
    assert!(place(&contours, &Page { obstacles_px: &obstacles_px, ..page }, &Rules::default()).is_empty());
}

#[test]
fn extreme_lengths_are_harmless() {
    let scene = Scene::new([400.0, 300.0], 20.0, waves);
    let contours = scene.contours();
    let obstacles_px = [[DVec2::ZERO, DVec2::splat(60.0)]];
    scene.with_page(|page| {
        let page = Page { obstacles_px: &obstacles_px, ..*page };
        for spacing_px in [1e-300, 1e-3, 1e9, 1e300] {
            let rules = Rules { spacing_px, ..Rules::default() };
            let numbers = place(&contours, &page, &rules);
            let limits = if spacing_px < 1.0 { 10..500 } else { 2..30 };
            assert!(limits.contains(&numbers.len()), "{} at {spacing_px}", numbers.len());
        }
        for letter_px in [1e-9, 0.3, 300.0, 1e9] {
            place(&contours, &Page { letter_px, ..page }, &Rules::default());
        }
        for width_px in [1e-300, 1e-3, 900.0, 1e300] {
            place(&contours, &Page { width_px: &|_| width_px, ..page }, &Rules::default());
        }
        let far = contours.iter().map(|contour| Contour { level_m: 1e300 * contour.level_m, ..*contour });
        place(&far.collect::<Vec<_>>(), &page, &Rules::default());
    });
}

#[test]
fn damaged_lines_are_numbered_like_whole_ones() {
    let whole = Scene::new([1000.0, 800.0], 20.0, waves);
    let mut damaged = Scene::new([1000.0, 800.0], 20.0, waves);
    for line in &mut damaged.lines {
        let twice = line.points.iter().flat_map(|at| [*at, *at, DVec2::new(f64::NAN, at.y)]);
        line.points = twice.collect();
    }
    assert_eq!(checked(&whole), checked(&damaged));
}

#[test]
fn the_same_input_has_the_same_numbers() {
    let scene = Scene::new([1000.0, 800.0], 20.0, waves);
    let numbers = checked(&scene);
    assert_eq!(numbers, checked(&scene));
    // They do not depend on the direction of the lines, except for rounding.
    let mut reversed = Scene::new([1000.0, 800.0], 20.0, waves);
    reversed.lines.iter_mut().for_each(|line| line.points.reverse());
    let other = checked(&reversed);
    assert!(numbers.len().abs_diff(other.len()) * 5 < numbers.len());
}

#[test]
fn depths_have_their_own_texts_and_ladders() {
    // A coast: land above, water below, with depths in metres as positive levels.
    let mut scene = Scene::new([900.0, 700.0], 20.0, |at| 350.0 - at.y + 15.0 * (at.x / 120.0).sin());
    for line in scene.lines.iter_mut().filter(|line: &&mut Traced| line.level_m < 0.0) {
        line.level_m = -line.level_m;
        line.is_depth = true;
        line.text = crate::labels::numbers::metres(line.level_m, true);
    }
    let numbers = checked(&scene);
    assert!(numbers.iter().any(|number| scene.lines[number.line].is_depth));
    assert!(numbers.iter().any(|number| !scene.lines[number.line].is_depth));
    // Tops point uphill, towards the land.
    assert!(numbers.iter().all(|number| number.angle.cos() > 0.5));
}

#[test]
fn without_uphill_numbers_are_upright() {
    let scene = Scene::new([1000.0, 800.0], 20.0, waves);
    let contours = contours(&scene.lines);
    let page = Page { corners_px: [DVec2::ZERO, scene.size_px], ..page(&|_| None) };
    let rules = Rules { every: Every::Index, tops: Tops::Uphill, spacing_px: 250.0 };
    let numbers = place(&contours, &page, &rules);
    assert!(numbers.len() > 10);
    assert!(numbers.iter().all(|number| number.angle.cos() > -1e-6));
}
