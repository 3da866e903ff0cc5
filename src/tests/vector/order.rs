//! Tests the order of strokes: each is drawn once, its geometry is unchanged, and the pen's way in the air is short and
//! never longer than before.

use std::f64::consts::TAU;

use hachure::lines::strokes::polylines::{EdgeKind, Polyline};
use hachure::vector::grid::{Grid, distance};
use hachure::vector::improve::{Stop, improve};
use hachure::vector::order::{Visit, order, pen_up_px};
use kurbo::{Point, Vec2};

use crate::tests::vector::{polyline, random};

const CORNER: [f64; 2] = [0.0; 2];

/// Returns random strokes, every third of them closed.
fn strokes(seed: i64, count: usize) -> Vec<Polyline> {
    let mut r = random(seed);
    let mut next = |most: f64| r.next().unwrap() * most;
    (0..count)
        .map(|i| {
            let at = Point::new(next(1000.0), next(600.0));
            let (size, turn) = (1.0 + next(60.0), next(TAU));
            let points: Vec<Point> =
                (0..2 + i % 9).map(|k| at + Vec2::from_angle(turn + 0.6 * k as f64) * size).collect();
            polyline(&points, EdgeKind::Contour, i % 3 == 0 && points.len() > 2)
        })
        .collect()
}

fn places(line: &Polyline) -> Vec<Point> {
    line.points.iter().map(|point| Point::new(point.px[0].into(), point.px[1].into())).collect()
}

/// Returns the length of the pen's way in the air, computed from the points that are drawn.
fn way(strokes: &[&Polyline], visits: &[Visit]) -> f64 {
    let mut at = Point::ORIGIN;
    let mut length = 0.0;
    for visit in visits {
        let points = places(&visit.drawn(strokes));
        length += at.distance(points[0]);
        at = if strokes[visit.stroke].is_closed { points[0] } else { points[points.len() - 1] };
    }
    length
}

/// Returns the error of an order, if there is one.
fn fault(strokes: &[&Polyline], visits: &[Visit]) -> Option<String> {
    let mut seen = vec![0; strokes.len()];
    for visit in visits {
        seen[visit.stroke] += 1;
        let (mut drawn, own) = (places(&visit.drawn(strokes)), places(strokes[visit.stroke]));
        if visit.is_flipped {
            drawn.reverse();
        }
        if strokes[visit.stroke].is_closed {
            drawn.rotate_right(visit.begin);
        } else if visit.begin != 0 {
            return Some(format!("stroke {} is open and does not begin at an end", visit.stroke));
        }
        if drawn != own {
            return Some(format!("stroke {} has another shape", visit.stroke));
        }
    }
    if seen.iter().any(|times| *times != 1) {
        return Some("a stroke is missing, or twice".to_owned());
    }
    let given: Vec<Visit> = (0..strokes.len()).map(Visit::as_is).collect();
    let (now, before) = (way(strokes, visits), way(strokes, &given));
    if (now - pen_up_px(strokes, visits, CORNER)).abs() > 1e-6 * (1.0 + now) {
        return Some("the way is not as long as it is said to be".to_owned());
    }
    (now > before + 1e-9).then(|| format!("{now} px in the air instead of {before}"))
}

#[test]
fn every_stroke_is_drawn_once_as_it_is_and_the_way_is_no_longer() {
    for (seed, count) in [0, 1, 2, 3, 5, 40, 41, 300, 3000].into_iter().enumerate() {
        let strokes = strokes(seed as i64, count);
        let strokes: Vec<&Polyline> = strokes.iter().collect();
        let visits = order(&strokes, CORNER);
        assert_eq!(fault(&strokes, &visits), None);
        assert_eq!(visits, order(&strokes, CORNER), "the order must be deterministic");
        // Ordering an ordered list again must not make it worse.
        let again: Vec<Polyline> = visits.iter().map(|visit| reordered(&strokes, visit)).collect();
        let again: Vec<&Polyline> = again.iter().collect();
        assert_eq!(fault(&again, &order(&again, CORNER)), None);
        let given: Vec<Visit> = (0..count).map(Visit::as_is).collect();
        println!(
            "{count} strokes: {:.0} px in the air instead of {:.0}",
            way(&strokes, &visits),
            way(&strokes, &given)
        );
        if count >= 40 {
            assert!(way(&strokes, &visits) < 0.4 * way(&strokes, &given));
        }
    }
}

/// Returns the stroke as its visit draws it.
fn reordered(strokes: &[&Polyline], visit: &Visit) -> Polyline {
    let stroke = strokes[visit.stroke];
    polyline(&places(&visit.drawn(strokes)), stroke.kind, stroke.is_closed)
}

#[test]
fn wrong_orders_are_noticed() {
    let strokes = strokes(7, 50);
    let strokes: Vec<&Polyline> = strokes.iter().collect();
    let good = order(&strokes, CORNER);
    assert_eq!(fault(&strokes, &good), None);
    let planted = |change: &dyn Fn(&mut Vec<Visit>)| {
        let mut visits = good.clone();
        change(&mut visits);
        fault(&strokes, &visits)
    };
    assert!(planted(&|visits| visits.truncate(49)).is_some());
    assert!(planted(&|visits| visits[3] = visits[4]).is_some());
    // Planted: to and fro across the picture.
    let zigzag = planted(&|visits| {
        visits.sort_by(|a, b| {
            let x = |visit: &Visit| strokes[visit.stroke].points[0].px[0];
            x(a).total_cmp(&x(b))
        });
        let last = visits.len() - 1;
        (0..visits.len() / 2).step_by(2).for_each(|i| visits.swap(i, last - i));
    });
    assert!(zigzag.is_some());
    let open = good.iter().position(|visit| !strokes[visit.stroke].is_closed).unwrap();
    assert!(planted(&|visits| visits[open].begin = 1).is_some());
}

#[test]
fn the_way_is_near_the_shortest() {
    // Dashes in a row, in any order and direction: the pen should go from gap to gap.
    let mut dashes: Vec<Polyline> = (0..200)
        .map(|i| {
            let x = f64::from(i) * 5.0;
            let mut ends = [Point::new(x, 3.0), Point::new(x + 4.0, 3.0)];
            if i % 3 == 0 {
                ends.reverse();
            }
            polyline(&ends, EdgeKind::Contour, false)
        })
        .collect();
    dashes.sort_by_key(|dash| (dash.points[0].px[0] as u64).wrapping_mul(7919) % 1009);
    let dashes: Vec<&Polyline> = dashes.iter().collect();
    assert!((way(&dashes, &order(&dashes, CORNER)) - (3.0 + 199.0)).abs() < 1e-3);

    // For few strokes, all orders and directions are tried.
    let (mut ours, mut shortest) = (0.0, 0.0);
    for seed in 100..130 {
        let strokes: Vec<Polyline> =
            strokes(seed, 7).into_iter().map(|stroke| Polyline { is_closed: false, ..stroke }).collect();
        let strokes: Vec<&Polyline> = strokes.iter().collect();
        let own = way(&strokes, &order(&strokes, CORNER));
        let best = shortest_of_all(&strokes);
        assert!(own >= best - 1e-6 && own < 1.5 * best, "the way is {own} px, the shortest {best} px");
        ours += own;
        shortest += best;
    }
    println!("{:.3} times the shortest way", ours / shortest);
    assert!(ours < 1.1 * shortest);
}

fn shortest_of_all(strokes: &[&Polyline]) -> f64 {
    fn go(ends: &[[Point; 2]], left: u32, at: Point) -> f64 {
        let each = (0..ends.len()).filter(|i| left >> i & 1 == 1);
        let way = each.flat_map(|i| {
            [[0, 1], [1, 0]].map(|[down, up]| at.distance(ends[i][down]) + go(ends, left & !(1 << i), ends[i][up]))
        });
        let best = way.fold(f64::INFINITY, f64::min);
        if left == 0 { 0.0 } else { best }
    }
    let ends: Vec<[Point; 2]> = strokes
        .iter()
        .map(|stroke| {
            let points = places(stroke);
            [points[0], points[points.len() - 1]]
        })
        .collect();
    go(&ends, (1 << ends.len()) - 1, Point::ORIGIN)
}

#[test]
fn local_changes_shorten_the_way_and_keep_the_strokes() {
    for seed in 0..10 {
        let strokes = strokes(seed, 200);
        let ends = |stroke: &Polyline| [0, stroke.points.len() - 1].map(|i| stroke.points[i].px.map(f64::from));
        let before: Vec<Stop> =
            (0..).zip(&strokes).map(|(stroke, line)| Stop { ends: ends(line), stroke, is_flipped: false }).collect();
        let length = |stops: &[Stop]| {
            let mut at = CORNER;
            let steps = stops.iter().map(|stop| distance(std::mem::replace(&mut at, stop.ends[1]), stop.ends[0]));
            steps.sum::<f64>()
        };
        let mut after = before.clone();
        improve(&mut after, CORNER);
        // Local changes shorten the way even from a bad initial order.
        assert!(length(&after) < 0.25 * length(&before), "{} of {}", length(&after), length(&before));
        let is_whole = |stop: &Stop| {
            let [down, up] = ends(&strokes[stop.stroke]);
            stop.ends == if stop.is_flipped { [up, down] } else { [down, up] }
        };
        assert!(after.iter().all(is_whole));
        let mut numbers: Vec<usize> = after.iter().map(|stop| stop.stroke).collect();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..200));
        // Planted: one end flipped without marking it.
        after[5].ends.reverse();
        assert!(!after.iter().all(is_whole));
    }
}

#[test]
fn the_grid_finds_what_is_nearest() {
    for (seed, spread) in [(1, [1000.0, 600.0]), (2, [1e6, 1.0]), (3, [0.0, 50.0]), (4, [0.0, 0.0])] {
        let mut r = random(seed);
        let mut place = |scale: f64| [0, 1].map(|i| spread[i] * scale * (r.next().unwrap() - 0.5));
        let places: Vec<[f64; 2]> = (0..500).map(|_| place(1.0)).collect();
        let mut grid = Grid::new(&places);
        for _ in 0..300 {
            // Some points are outside the grid.
            let from = place(2.0);
            let is_wanted = |number: u32| !number.is_multiple_of(3);
            let distance = |number: u32| {
                let [x, y] = places[number as usize];
                (x - from[0]).hypot(y - from[1])
            };
            let mut all: Vec<u32> = (0..500).filter(|number| is_wanted(*number)).collect();
            all.sort_by(|a, b| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b)));
            assert_eq!(grid.nearest(from, 8, is_wanted), all[..8]);
            assert_eq!(grid.take_nearest(from, is_wanted).unwrap().0, all[0]);
        }
        assert!(grid.take_nearest([0.0; 2], |_| false).is_none());
        assert!(grid.nearest([0.0; 2], 8, |_| true).is_empty(), "entries that were not wanted must be removed");
    }
    assert!(Grid::new(&[]).take_nearest([0.0; 2], |_| true).is_none());
}
