//! Tests of names on maps.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use super::points::{Board, Page, Point, points};
use super::{Hold, Random, Rect};

const PAGE: Page = Page { area: Rect { from_px: [0.0; 2], to_px: [1600.0, 1000.0] }, gap_px: 2.0, symbol_gap_px: 2.0 };

fn cities(count: usize, seed: u64) -> Vec<Point> {
    let mut random = Random(seed);
    let mut point = |_| {
        let at_px = [random.unit() * 1600.0, random.unit() * 1000.0];
        let size_px = [20.0 + 60.0 * random.unit(), 12.0];
        Point { at_px, radius_px: 2.0, size_px, weight: 1.0 / (0.05 + random.unit()) }
    };
    (0..count).map(&mut point).collect()
}

fn weight(points: &[Point], sides: &[Option<usize>]) -> f64 {
    points.iter().zip(sides).filter(|(_, side)| side.is_some()).map(|(point, _)| point.weight).sum()
}

/// Returns pairs of names, or names and obstacles, that overlap, and names outside of the page.
fn wrong(points: &[Point], obstacles: &[Rect], sides: &[Option<usize>]) -> usize {
    let name_box = |i: usize| sides[i].map(|side| points[i].name_box(side, &PAGE));
    let names: Vec<(usize, Rect)> = (0..points.len()).filter_map(|i| Some((i, name_box(i)?))).collect();
    let near = |a: &Rect, b: &Rect| {
        let apart = |axis: usize| (b.from_px[axis] - a.to_px[axis]).max(a.from_px[axis] - b.to_px[axis]);
        apart(0).max(apart(1)) < PAGE.gap_px - 1e-9
    };
    let mut wrong = 0;
    for (i, area) in &names {
        wrong += names.iter().filter(|(j, other)| j > i && near(area, other)).count();
        wrong += obstacles.iter().filter(|other| near(area, other)).count();
        wrong += (0..points.len()).filter(|j| j != i && near(area, &points[*j].symbol())).count();
        let is_inside = area.from_px[0] >= 0.0 && area.from_px[1] >= 0.0;
        wrong += usize::from(!is_inside || area.to_px[0] > 1600.0 || area.to_px[1] > 1000.0);
    }
    wrong
}

#[test]
fn names_do_not_overlap_and_annealing_is_better_than_greed() {
    let obstacles = [Rect { from_px: [0.0; 2], to_px: [300.0, 120.0] }];
    let (mut shares, mut slowest_s) = (Vec::new(), 0.0_f64);
    for (seed, count) in [100, 400, 1000, 2000].into_iter().enumerate() {
        let cities = cities(count, seed as u64);
        let begin = std::time::Instant::now();
        let sides = points(&cities, &PAGE, &obstacles, &[]);
        slowest_s = slowest_s.max(begin.elapsed().as_secs_f64());
        assert_eq!(wrong(&cities, &obstacles, &sides), 0);
        assert_eq!(sides, points(&cities, &PAGE, &obstacles, &[]));
        let mut greedy = Board::new(&cities, &PAGE, &obstacles, &[]);
        greedy.fill();
        shares.push(weight(&cities, &sides) / weight(&cities, &greedy.sides));
        // Planted: all names at their second side.
        let moved: Vec<Option<usize>> = sides.iter().map(|side| side.map(|side| (side + 1) % 8)).collect();
        assert!(wrong(&cities, &obstacles, &moved) > 0);
    }
    println!("weight relative to greedy placement: {shares:.3?}; 2000 names: {:.1} ms", 1e3 * slowest_s);
    assert!(shares.iter().all(|share| *share >= 1.0) && shares[2] > 1.01, "{shares:?}");
}

#[test]
fn small_maps_are_optimal() {
    let mut shares = Vec::new();
    for seed in 0..30 {
        let mut random = Random(seed + 100);
        let mut point = |_| {
            let at_px = [40.0 + random.unit() * 90.0, 30.0 + random.unit() * 40.0];
            Point { at_px, radius_px: 2.0, size_px: [50.0, 12.0], weight: 1.0 + 3.0 * random.unit() }
        };
        let crowd: Vec<Point> = (0..7).map(&mut point).collect();
        let sides = points(&crowd, &PAGE, &[], &[]);
        let mut all = vec![None; crowd.len()];
        let best = heaviest(&crowd, &mut all, 0);
        shares.push(weight(&crowd, &sides) / best);
    }
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    println!("7 names: least share {least:.4}, mean {:.4}", shares.iter().sum::<f64>() / 30.0);
    assert!(least > 0.95, "{shares:?}");
}

fn heaviest(crowd: &[Point], sides: &mut Vec<Option<usize>>, from: usize) -> f64 {
    if from == crowd.len() {
        return weight(crowd, sides);
    }
    let mut best = 0.0_f64;
    for side in (0..8).map(Some).chain([None]) {
        sides[from] = side;
        if side.is_none() || wrong(crowd, &[], sides) == 0 {
            best = best.max(heaviest(crowd, sides, from + 1));
        }
    }
    sides[from] = None;
    best
}

#[test]
fn preferences_holds_and_odd_numbers() {
    let city = Point { at_px: [500.0; 2], radius_px: 2.0, size_px: [50.0, 12.0], weight: 1.0 };
    assert_eq!(points(&[city], &PAGE, &[], &[]), [Some(0)]);
    assert_eq!(points(&[city], &PAGE, &[], &[Hold::Kept(3)]), [Some(3)]);
    assert_eq!(points(&[city], &PAGE, &[], &[Hold::Out]), [None]);
    // A heavier name displaces neither a fixed nor a kept one, if it has space elsewhere.
    let field = [city, Point { weight: 3.0, at_px: [530.0, 503.0], ..city }];
    let sides = points(&field, &PAGE, &[], &[Hold::Fixed(0)]);
    assert!(sides[0] == Some(0) && sides[1] != Some(0), "{sides:?}");
    assert_eq!(points(&field, &PAGE, &[], &[Hold::Kept(0)])[0], Some(0));
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1.0, 0.0];
    for number in odd {
        let broken = [
            Point { at_px: [number, 10.0], ..city },
            Point { radius_px: number, ..city },
            Point { size_px: [number, 12.0], ..city },
            Point { weight: number, ..city },
            city,
        ];
        let area = Rect { from_px: [number; 2], to_px: [100.0, number] };
        assert_eq!(points(&broken, &PAGE, &[area], &[]).len(), 5);
        points(&broken, &Page { area, gap_px: number, symbol_gap_px: number }, &[], &[]);
    }
    assert_eq!(points(&[], &PAGE, &[], &[]), []);
    let wide = Point { size_px: [2000.0, 12.0], ..city };
    assert_eq!(points(&[wide], &PAGE, &[], &[]), [None]);
}
