//! Tests of layouts of panoramas.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::f64::consts::SQRT_2;
use std::time::Instant;

use super::check::{Violation, check};
use super::panorama::{Label, Place, Problem, Rows, panorama};
use super::slanted::slanted;
use super::{Hold, chain, exact, instances};

fn weight(labels: &[Label], places: &[Option<Place>]) -> f64 {
    labels.iter().zip(places).filter(|(_, place)| place.is_some()).map(|(label, _)| label.weight).sum()
}

/// Returns the least and mean share, and prints them.
fn summary(name: &str, shares: &[f64]) -> [f64; 2] {
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    println!("{name}: share of the optimum: least {least:.5}, mean {mean:.5} of {}", shares.len());
    [least, mean]
}

/// Returns the layout by the exact dynamic programme, whatever time it takes.
fn whole(labels: &[Label], rows: &Rows) -> Vec<Option<Place>> {
    let problem = Problem::new(labels, rows, &[]);
    let rows_of = chain::solve(&problem, labels.len() + 1);
    problem.places(labels.len(), &rows_of, &problem.homes(0.5))
}

#[test]
fn layouts_of_few_labels_are_optimal() {
    let mut shares = Vec::new();
    for seed in 0..50_u64 {
        let (count, row_count) = (8 + seed as usize % 7, 1 + seed as usize % 3);
        let width_px = [300.0, 450.0, 700.0][seed as usize / 3 % 3];
        let rows = instances::rows(row_count, width_px);
        let labels = [instances::scattered(count, width_px, seed), instances::mountains(count, width_px, seed)];
        let pair = instances::paired(&labels[seed as usize % 2], 12.0, seed);
        for labels in [&labels[0], &labels[1], &pair] {
            let places = panorama(labels, &rows, &[]);
            assert_eq!(check(labels, &rows, &places), []);
            shares.push(weight(labels, &places) / exact::largest_weight(labels, &rows));
        }
    }
    let [least, _] = summary("at most 14 labels, 3 rows", &shares);
    assert!(least > 0.999 && shares.iter().all(|share| *share < 1.0 + 1e-9));
}

#[test]
fn rows_that_are_not_in_use_have_no_labels() {
    for seed in 0..10 {
        let labels = instances::mountains(30, 900.0, seed);
        let dense = instances::rows(3, 900.0);
        let shift_px = 20.0 * 4.0;
        let labels: Vec<Label> = labels.iter().map(|label| Label { y_px: label.y_px + shift_px, ..*label }).collect();
        // Rows 2, 4 and 5 of a picture with room for eight.
        let in_use = |row: usize| [2, 4, 5].contains(&row);
        let top_px = |row: usize| if in_use(row) { 10.0 + 20.0 * row as f64 } else { f64::NAN };
        let sparse = Rows { tops_px: (0..8).map(top_px).collect(), ..dense.clone() };
        let places = panorama(&labels, &sparse, &[]);
        assert!(places.iter().flatten().all(|place| in_use(place.row)));
        let [found, expected] = [weight(&labels, &places), weight(&labels, &panorama(&labels, &dense, &[]))];
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} and not {expected}");
        // Planted: another row.
        let with = |row: usize| Rows {
            tops_px: sparse.tops_px.iter().enumerate().map(|(i, top)| if i == row { 70.0 } else { *top }).collect(),
            ..sparse.clone()
        };
        let more = panorama(&labels, &with(3), &[]);
        assert!(more.iter().flatten().any(|place| place.row == 3));
    }
}

#[test]
fn one_row_is_optimal() {
    let mut shares = Vec::new();
    for seed in 0..50 {
        let (count, width_px) = ([30, 80, 200][seed as usize % 3], 1200.0);
        let rows = instances::rows(1, width_px);
        for mut labels in [instances::scattered(count, width_px, seed), instances::mountains(count, width_px, seed)] {
            labels.iter_mut().for_each(|label| label.weight = label.weight.ceil().min(300.0));
            let places = panorama(&labels, &rows, &[]);
            assert_eq!(check(&labels, &rows, &places), []);
            shares.push(weight(&labels, &places) / exact::largest_in_one_row(&labels, &rows));
        }
    }
    let [least, _] = summary("one row, up to 200 labels", &shares);
    assert!(least > 1.0 - 1e-9 && shares.iter().all(|share| *share < 1.0 + 1e-9));
}

#[test]
fn the_checker_finds_planted_errors() {
    let rows = instances::rows(3, 900.0);
    let (mut moved, mut exchanged) = (0, 0);
    for seed in 0..20 {
        let labels = instances::scattered(40, 900.0, seed);
        let places = panorama(&labels, &rows, &[]);
        assert_eq!(check(&labels, &rows, &places), []);
        let placed: Vec<usize> = (0..labels.len()).filter(|i| places[*i].is_some()).collect();
        // Two labels exchange their positions.
        let [a, b] = [placed[0], placed[1]];
        let mut wrong = places.clone();
        let left_px = |i: usize| places[i].unwrap().offset_px + labels[i].x_px[0];
        wrong[a] = places[b].map(|place| Place { offset_px: left_px(b) - labels[a].x_px[0], ..place });
        wrong[b] = places[a].map(|place| Place { offset_px: left_px(a) - labels[b].x_px[0], ..place });
        exchanged += usize::from(!check(&labels, &rows, &wrong).is_empty());
        // A full row moves down to the next one.
        let mut wrong = places.clone();
        wrong.iter_mut().flatten().for_each(|place| place.row = place.row.max(1));
        moved += usize::from(!check(&labels, &rows, &wrong).is_empty());
    }
    assert_eq!([moved, exchanged], [20, 20]);
    let label = |x_px: f64| Label { x_px: [x_px; 2], y_px: 300.0, width_px: 60.0, height_px: 14.0, weight: 1.0 };
    let place = |row: usize, offset_px: f64| Some(Place { row, offset_px });
    let two = [label(400.0), label(420.0)];
    assert_eq!(check(&two, &rows, &[place(0, -60.0), place(2, 0.0)]), []);
    // The leader of the higher label crosses the lower one; in the other order it does not.
    assert_eq!(check(&two, &rows, &[place(0, -60.0), place(2, -30.0)]), [Violation::Crossing(0, 1)]);
    assert_eq!(check(&two, &rows, &[place(1, 0.0), place(0, 0.0)]), [Violation::Crossing(1, 0)]);
    assert_eq!(check(&two, &rows, &[place(1, -30.0), place(1, 0.0)]), [Violation::Overlap(0, 1)]);
    assert_eq!(check(&two, &rows, &[place(1, 1.0), None]), [Violation::Detached(0)]);
    assert_eq!(check(&[label(20.0)], &rows, &[place(1, -30.0)]), [Violation::Outside(0)]);
    assert_eq!(check(&two, &rows, &[place(3, 0.0), None]), [Violation::NoRow(0)]);
    let low = Label { y_px: 30.0, ..two[0] };
    assert_eq!(check(&[low], &rows, &[place(1, 0.0)]), [Violation::TooLow(0)]);
    // A crossing in the right picture only.
    let pair = [two[0], Label { x_px: [420.0, 401.0], ..two[1] }];
    assert_eq!(check(&pair, &rows, &[place(0, -60.0), place(2, 0.0)]), [Violation::Crossing(0, 1)]);
}

#[test]
fn a_pair_has_one_layout_that_both_pictures_can_have() {
    for seed in 0..10 {
        let rows = instances::rows(4, 1000.0);
        let single = instances::mountains(60, 1000.0, seed);
        let pair = instances::paired(&single, 60.0, seed);
        let places = panorama(&pair, &rows, &[]);
        assert_eq!(check(&pair, &rows, &places), []);
        // Planted: the layout of one picture does not suit the other one.
        let left: Vec<Label> = pair.iter().map(|label| Label { x_px: [label.x_px[0]; 2], ..*label }).collect();
        assert!(!check(&pair, &rows, &panorama(&left, &rows, &[])).is_empty());
        assert!(weight(&pair, &places) > 0.6 * weight(&left, &panorama(&left, &rows, &[])));
    }
}

#[test]
fn labels_that_are_held_remain() {
    let rows = instances::rows(3, 900.0);
    for seed in 0..20 {
        let labels = instances::scattered(40, 900.0, seed);
        let places = panorama(&labels, &rows, &[]);
        // All labels in the rows of another layout, of which nothing may change.
        let mut turned = labels.clone();
        turned.iter_mut().for_each(|label| label.weight = 6.0 - label.weight);
        let other = panorama(&turned, &rows, &[]);
        let fixed: Vec<Hold> =
            other.iter().map(|place| place.map_or(Hold::Free, |place| Hold::Fixed(place.row))).collect();
        let held = panorama(&labels, &rows, &fixed);
        assert_eq!(check(&labels, &rows, &held), []);
        for (place, hold) in held.iter().zip(&fixed) {
            assert!(*hold == Hold::Free || place.map(|place| Hold::Fixed(place.row)) == Some(*hold));
        }
        // Slightly different weights change nothing in a layout that is kept.
        let kept: Vec<Hold> =
            places.iter().map(|place| place.map_or(Hold::Free, |place| Hold::Kept(place.row))).collect();
        let mut close = labels.clone();
        close.iter_mut().enumerate().for_each(|(i, label)| label.weight *= 1.0 + 0.02 * (i % 3) as f64);
        assert_eq!(panorama(&close, &rows, &kept), places);
    }
}

#[test]
fn odd_numbers_are_left_out() {
    let rows = instances::rows(3, 900.0);
    let usual = Label { x_px: [400.0; 2], y_px: 300.0, width_px: 60.0, height_px: 14.0, weight: 1.0 };
    assert_eq!(panorama(&[], &rows, &[]), []);
    assert_eq!(panorama(&[usual], &Rows { tops_px: Vec::new(), ..rows.clone() }, &[]), [None]);
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1.0, 0.0] {
        let broken = [
            Label { x_px: [number, 400.0], ..usual },
            Label { y_px: number, ..usual },
            Label { width_px: number, ..usual },
            Label { height_px: number, ..usual },
            Label { weight: number, ..usual },
            usual,
        ];
        let places = panorama(&broken, &rows, &[Hold::Fixed(9)]);
        assert!(places[5].is_some() && places[0].is_none() && places[2].is_none() && places[4].is_none());
        for broken in [
            Rows { tops_px: vec![number, 40.0, number], ..rows.clone() },
            Rows { width_px: number, ..rows.clone() },
            Rows { margin_px: number, ..rows.clone() },
            Rows { gap_px: number, leader_gap_px: number, align: number, ..rows.clone() },
        ] {
            panorama(&[usual; 4], &broken, &[]);
        }
    }
    // Labels at the same position: each row has at most two, and leaders do not cross labels.
    let places = panorama(&[usual; 9], &rows, &[]);
    assert_eq!(check(&[usual; 9], &rows, &places), []);
    assert_eq!(weight(&[usual; 9], &places), 1.0);
    let touching = Rows { gap_px: 0.0, leader_gap_px: 0.0, ..rows.clone() };
    assert_eq!(weight(&[usual; 9], &panorama(&[usual; 9], &touching, &[])), 6.0);
    // Too wide for the picture; and a summit that is only below the top row.
    assert_eq!(panorama(&[Label { width_px: 891.0, ..usual }], &rows, &[]), [None]);
    assert_eq!(panorama(&[Label { y_px: 30.0, ..usual }], &rows, &[])[0].map(|place| place.row), Some(0));
}

#[test]
fn slanted_names_are_optimal() {
    for seed in 0..20 {
        let rows = instances::rows(1, 700.0);
        let single = instances::mountains(14, 600.0, seed);
        for labels in [instances::paired(&single, 8.0, seed), single] {
            let is_drawn = slanted(&labels, &rows, 150.0, &[]);
            let total = |chosen: &dyn Fn(usize) -> bool| -> Option<f64> {
                let all: Vec<usize> = (0..labels.len()).filter(|i| chosen(*i)).collect();
                let is_right =
                    |i: &usize| all.iter().all(|j| i == j || are_clear(&labels[*i], &labels[*j], rows.gap_px));
                let inside = |i: &usize| {
                    let [a, b] =
                        [labels[*i].x_px[0].min(labels[*i].x_px[1]), labels[*i].x_px[0].max(labels[*i].x_px[1])];
                    a - 14.0 / SQRT_2 >= 5.0 && b + labels[*i].width_px / SQRT_2 <= 695.0
                };
                let is_possible = all.iter().all(|i| is_right(i) && inside(i));
                is_possible.then(|| all.iter().map(|i| labels[*i].weight).sum())
            };
            let best = (0..1 << labels.len()).filter_map(|set| total(&|i| set >> i & 1 == 1)).fold(0.0, f64::max);
            let found = total(&|i| is_drawn[i]).unwrap();
            assert!((found / best - 1.0).abs() < 1e-9, "{found} and not {best}");
        }
    }
    let odd = Label { x_px: [f64::NAN; 2], y_px: 300.0, width_px: 60.0, height_px: 14.0, weight: 1.0 };
    let usual = Label { x_px: [300.0; 2], ..odd };
    let rows = instances::rows(1, 700.0);
    assert_eq!(slanted(&[odd, usual, usual], &rows, 150.0, &[Hold::Free, Hold::Out]), [false, false, true]);
    assert_eq!(slanted(&[usual], &rows, f64::NAN, &[]), [false]);
    // Too long for the space above, and a summit above the baseline.
    assert_eq!(slanted(&[Label { width_px: 250.0, ..usual }], &rows, 150.0, &[]), [false]);
    assert_eq!(slanted(&[Label { y_px: 140.0, ..usual }], &rows, 150.0, &[]), [false]);
}

/// Returns whether bands at 45° from two leaders are apart in both pictures: the distance of their baselines is more than
/// the height of the right one.
fn are_clear(a: &Label, b: &Label, gap_px: f64) -> bool {
    let apart = [0, 1].map(|eye| (b.x_px[eye] - a.x_px[eye]) / SQRT_2);
    apart.iter().all(|apart| *apart >= 14.0 + gap_px) || apart.iter().all(|apart| -apart >= 14.0 + gap_px)
}

/// Compares the approximation for many labels with the dynamic programme without limits.
fn compare(cases: &[(usize, usize, f64)], seeds: u64, runs: usize) {
    for (count, row_count, width_px) in cases.iter().copied() {
        let rows = instances::rows(row_count, width_px);
        let (mut shares, mut slowest_s) = (Vec::new(), 0.0_f64);
        for seed in 0..seeds {
            for labels in [instances::scattered(count, width_px, seed), instances::mountains(count, width_px, seed)] {
                let (mut fastest_s, mut places) = (f64::INFINITY, Vec::new());
                for _ in 0..runs {
                    let begin = Instant::now();
                    places = panorama(&labels, &rows, &[]);
                    fastest_s = fastest_s.min(begin.elapsed().as_secs_f64());
                }
                slowest_s = slowest_s.max(fastest_s);
                assert_eq!(check(&labels, &rows, &places), []);
                shares.push(weight(&labels, &places) / weight(&labels, &whole(&labels, &rows)));
            }
        }
        let name = format!("{count} labels, {row_count} rows, {width_px} px, {:.1} ms", 1e3 * slowest_s);
        let [least, _] = summary(&name, &shares);
        assert!(least > 0.95, "{name}: {least}");
    }
}

#[test]
fn layouts_of_many_labels_are_almost_optimal() {
    compare(&[(100, 3, 1200.0), (100, 8, 1500.0), (130, 4, 1000.0)], 2, 1);
}

#[test]
#[ignore = "takes a minute; run it in a release after changes of the limits"]
fn the_largest_layouts_are_almost_optimal_and_fast() {
    let large = [(150, 3, 1920.0), (300, 5, 3000.0), (500, 1, 1920.0), (500, 3, 1920.0), (500, 8, 1920.0)];
    compare(&large, 3, 10);
    compare(&[(500, 8, 5000.0), (500, 4, 7680.0)], 3, 10);
}
