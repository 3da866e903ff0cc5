//! Tests of numbers on contour lines.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod check;
mod inputs;
mod planted;
mod surfaces;

use glam::DVec2;

use self::check::faults;
use self::surfaces::{LETTER_PX, Scene};
use super::{Every, Number, Tops, metres, place};

/// The height of a surface in metres, at a point of the page.
type Surface = fn(DVec2) -> f64;

fn cone(at: DVec2) -> f64 {
    1000.0 - at.distance(DVec2::new(500.0, 400.0))
}

fn saddle(at: DVec2) -> f64 {
    let at = (at - DVec2::new(500.0, 400.0)) / 30.0;
    500.0 + 1.7 * at.x * at.y + 0.4 * at.x
}

fn ridge(at: DVec2) -> f64 {
    900.0 - 0.8 * (at.y - 400.0 + 40.0 * (at.x / 150.0).sin()).abs() + 0.1 * at.x
}

fn waves(at: DVec2) -> f64 {
    let wave = |length: f64, phase: f64| ((at.x + phase) / length).sin() * ((at.y - 0.4 * at.x + phase) / length).cos();
    600.0 + 260.0 * wave(170.0, 20.0) + 70.0 * wave(61.0, 300.0) + 9.0 * wave(13.0, 50.0)
}

/// Places the numbers of a scene, checks them, and returns them.
fn checked<F: Fn(DVec2) -> f64>(scene: &Scene<F>) -> Vec<Number> {
    let contours = scene.contours();
    scene.with_page(|page| {
        let numbers = place(&contours, page, &scene.rules);
        let faults = faults(&contours, page, &scene.rules, &numbers);
        assert!(faults.is_empty(), "{faults:?}");
        numbers
    })
}

#[test]
fn numbers_of_all_surfaces_obey_the_rules() {
    let surfaces: [(Surface, usize); 4] = [(cone, 8), (saddle, 10), (ridge, 12), (waves, 20)];
    for (height_m, least) in surfaces {
        for (every, tops) in [(Every::Index, Tops::Uphill), (Every::All, Tops::Uphill), (Every::Auto, Tops::Upright)] {
            let mut scene = Scene::new([1000.0, 800.0], 20.0, height_m);
            scene.rules.every = every;
            scene.rules.tops = tops;
            scene.obstacles_px = vec![[DVec2::new(100.0, 100.0), DVec2::new(420.0, 330.0)]];
            let count = checked(&scene).len();
            assert!(count >= least, "{count} numbers on a surface that has room for {least}");
        }
    }
}

#[test]
fn numbers_of_a_cone_are_readable_and_form_one_ladder() {
    let scene = Scene::new([1000.0, 800.0], 20.0, cone);
    let numbers = checked(&scene);
    // Tops point inwards, so below the summit they point up.
    let below = numbers.iter().filter(|number| number.centre_px.y > 400.0).count();
    assert!(below * 2 > numbers.len(), "{below} of {}", numbers.len());
    let upside_down = numbers.iter().filter(|number| number.angle.cos() < -0.3).count();
    assert!(upside_down * 5 <= 2 * numbers.len(), "{upside_down} of {}", numbers.len());
    // On one bearing from the summit there are most of the levels.
    let bearing = |number: &Number| (number.centre_px - DVec2::new(500.0, 400.0)).to_angle();
    let most =
        numbers.iter().map(|own| numbers.iter().filter(|other| (bearing(own) - bearing(other)).abs() < 0.12).count());
    assert!(most.max().unwrap() >= 3, "{:?}", numbers.iter().map(bearing).collect::<Vec<_>>());
}

#[test]
fn numbers_are_on_the_straightest_part_of_a_line() {
    // The contour lines are straight on the left and wind on the right.
    let height_m = |at: DVec2| {
        let winding = ((at.x - 400.0) / 100.0).clamp(0.0, 1.0);
        500.0 - at.y + winding * 12.0 * (at.x / 11.0).sin()
    };
    let scene = Scene::new([800.0, 500.0], 20.0, height_m);
    let numbers = checked(&scene);
    assert!(numbers.len() >= 4);
    assert!(numbers.iter().all(|number| number.centre_px.x < 420.0 && number.is_straight()));
    // They are readable, since uphill is up.
    assert!(numbers.iter().all(|number| number.angle.abs() < 0.1));
}

#[test]
fn numbers_follow_the_curve_of_a_line() {
    let mut scene = Scene::new([400.0, 400.0], 20.0, |at| 500.0 - at.distance(DVec2::splat(200.0)));
    scene.lines.retain(|line| line.level_m == 440.0);
    scene.rules.every = Every::All;
    let numbers = checked(&scene);
    assert_eq!(numbers.len(), 1);
    let number = &numbers[0];
    assert!((number.bend.abs() - 1.0 / 60.0).abs() < 0.002, "{}", number.bend);
    // The middles of the letters are on the circle.
    for i in 0..3 {
        let letter = number.letter(8.0 * f64::from(i), 8.0);
        let along = DVec2::from_angle(letter.angle);
        let middle = letter.left_px + 4.0 * along - 0.5 * LETTER_PX * along.perp();
        assert!((middle.distance(DVec2::splat(200.0)) - 60.0).abs() < 0.5);
    }
}

#[test]
fn most_numbers_belong_to_ladders() {
    let scene = Scene::new([1600.0, 1200.0], 20.0, |at| waves(0.6 * at));
    let numbers = checked(&scene);
    let contours = scene.contours();
    let level_m = |number: &Number| contours[number.line].level_m;
    // A number of the level above or below is within 25 degrees of the slope line.
    let has_neighbour = |own: &&Number| {
        numbers.iter().any(|other| {
            let way = other.centre_px - own.centre_px;
            let aside = way.normalize_or_zero().dot(DVec2::from_angle(own.angle)).abs();
            (level_m(own) - level_m(other)).abs() == 100.0 && way.length() < 150.0 && aside < 0.42
        })
    };
    let count = numbers.iter().filter(has_neighbour).count();
    assert!(count * 3 > numbers.len() * 2, "{count} of {}", numbers.len());
}

#[test]
fn rules_choose_lines() {
    let mut scene = Scene::new([1000.0, 800.0], 20.0, cone);
    let index = checked(&scene);
    assert!(index.iter().all(|number| scene.lines[number.line].is_index));
    scene.rules.every = Every::All;
    let all = checked(&scene);
    assert!(all.len() > 2 * index.len());
    // Lines are 20 px apart, which is no room for numbers in between.
    scene.rules.every = Every::Auto;
    assert_eq!(checked(&scene), index);
    // On flat land there is room.
    let mut flat = Scene::new([1000.0, 800.0], 20.0, |at| 0.25 * cone(at));
    flat.rules.every = Every::Auto;
    let numbers = checked(&flat);
    assert!(numbers.iter().any(|number| flat.lines[number.line].is_index));
    assert!(numbers.iter().any(|number| !flat.lines[number.line].is_index));
}

#[test]
fn upright_numbers_are_never_upside_down() {
    let mut scene = Scene::new([1000.0, 800.0], 20.0, waves);
    scene.rules.tops = Tops::Upright;
    assert!(checked(&scene).iter().all(|number| number.angle.cos() > -1e-6));
}

#[test]
fn texts_of_levels_have_a_decimal_where_they_need_it() {
    let texts =
        [(1200.0, "1200"), (12.5, "12.5"), (-3.0, "−3"), (-12.5, "−12.5"), (-0.0, "0"), (0.04, "0"), (1e4, "10000")];
    for (level_m, text) in texts {
        assert_eq!(metres(level_m, false), text);
    }
    assert_eq!(metres(-20.0, true), "20");
    assert_eq!(metres(2.5, true), "2.5");
}
