//! The checks find numbers that are wrong.

use glam::DVec2;

use super::check::{Fault, faults};
use super::surfaces::Scene;
use super::{Number, Surface, place, waves};
use crate::labels::numbers::Contour;

fn scene() -> Scene<Surface> {
    Scene::new([1000.0, 800.0], 20.0, waves)
}

/// Changes numbers, each on its own, and asserts that the checks find at least `part` of the errors.
fn assert_found(fault: Fault, part: f64, change: impl Fn(&mut Number)) {
    let scene = scene();
    let contours = scene.contours();
    scene.with_page(|page| {
        let numbers = place(&contours, page, &scene.rules);
        assert!(numbers.len() > 20);
        let is_found = |i: &usize| {
            let mut changed = numbers.clone();
            change(&mut changed[*i]);
            faults(&contours, page, &scene.rules, &changed).contains(&(*i, fault))
        };
        let found = (0..numbers.len()).filter(is_found).count();
        assert!(found as f64 >= part * numbers.len() as f64, "{found} of {} {fault:?}", numbers.len());
    });
}

#[test]
fn finds_a_number_that_is_turned() {
    assert_found(Fault::Tops, 1.0, |number| {
        number.angle += std::f64::consts::PI;
        number.bend = -number.bend;
    });
}

#[test]
fn finds_a_number_with_the_wrong_level() {
    assert_found(Fault::Level, 1.0, |number| number.text = format!("9{}", &number.text[1..]));
}

#[test]
fn finds_a_number_beside_its_line() {
    for away_px in [-2.0, 2.0] {
        assert_found(Fault::OffLine, 1.0, |number| {
            number.centre_px += away_px * DVec2::from_angle(number.angle).perp();
        });
    }
}

#[test]
fn finds_a_number_beside_its_gap() {
    for away_px in [-3.0, 3.0] {
        assert_found(Fault::Gap, 1.0, |number| {
            number.centre_px += away_px * DVec2::from_angle(number.angle);
        });
    }
}

#[test]
fn finds_a_number_at_a_bend() {
    // A rectangle, with a number moved to a corner.
    let mut scene = Scene::new([400.0, 300.0], 20.0, |at| -(at.x - 200.0).abs().max((at.y - 150.0).abs()));
    let rectangle = [[50.0, 50.0], [350.0, 50.0], [350.0, 250.0], [50.0, 250.0]].map(DVec2::from_array);
    scene.lines.truncate(1);
    scene.lines[0].points = rectangle.to_vec();
    scene.lines[0].is_closed = true;
    scene.lines[0].is_index = true;
    scene.lines[0].text = "1200".to_owned();
    scene.rules.spacing_px = 900.0;
    let contours = scene.contours();
    scene.with_page(|page| {
        let mut numbers = place(&contours, page, &scene.rules);
        assert_eq!(numbers.len(), 1);
        assert_eq!(faults(&contours, page, &scene.rules, &numbers), []);
        let length_px = numbers[0].gap_px[1] - numbers[0].gap_px[0];
        numbers[0].gap_px = [300.0 - 0.5 * length_px, 300.0 + 0.5 * length_px];
        numbers[0].centre_px = rectangle[1];
        numbers[0].angle = std::f64::consts::FRAC_PI_4;
        assert!(faults(&contours, page, &scene.rules, &numbers).contains(&(0, Fault::Bend)));
    });
}

#[test]
fn finds_numbers_that_are_repeated_or_outside() {
    let scene = scene();
    let contours = scene.contours();
    scene.with_page(|page| {
        let mut numbers = place(&contours, page, &scene.rules);
        let last = numbers.len();
        numbers.push(numbers[0].clone());
        let found = faults(&contours, page, &scene.rules, &numbers);
        assert!(found.contains(&(last, Fault::Spacing)) && found.contains(&(last, Fault::Overlap)));
        numbers[last].centre_px.x = -3.0;
        assert!(faults(&contours, page, &scene.rules, &numbers).contains(&(last, Fault::Page)));
        let mut page = *page;
        let around = [numbers[0].centre_px - DVec2::ONE, numbers[0].centre_px + DVec2::ONE];
        let obstacles_px = [around];
        page.obstacles_px = &obstacles_px;
        assert!(faults(&contours, &page, &scene.rules, &numbers).contains(&(0, Fault::Obstacle)));
    });
}

#[test]
fn finds_an_index_contour_under_a_number() {
    let scene = scene();
    let contours = scene.contours();
    scene.with_page(|page| {
        let numbers = place(&contours, page, &scene.rules);
        let centre = numbers[0].centre_px;
        let across = [centre - 40.0 * DVec2::ONE, centre + DVec2::new(40.0, 33.0)];
        let mut other = contours[numbers[0].line];
        other.points = &across;
        let contours: Vec<Contour<'_>> = contours.iter().copied().chain([other]).collect();
        assert!(faults(&contours, page, &scene.rules, &numbers).contains(&(0, Fault::Crossing)));
        // With this line known, the numbers avoid it.
        let numbers = place(&contours, page, &scene.rules);
        assert_eq!(faults(&contours, page, &scene.rules, &numbers), []);
    });
}
