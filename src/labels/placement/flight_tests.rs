//! Tests of layouts over successive frames.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::collections::BTreeMap;

use super::check::check;
use super::flight::{Flight, Shown, Summit};
use super::instances;
use super::map_flight::{MapFlight, ShownName, Spot};
use super::panorama::{Label, Place, Rows};
use super::points::{Page, Point};
use super::steady::{CHANGE_S, FADE_S};
use super::{Random, Rect};

/// Summits in the picture of a camera that flies through them and turns. In the right picture of a pair the camera is
/// `apart_m` further right.
struct World {
    peaks: Vec<([f64; 2], Label)>,
    apart_m: f64,
}

impl World {
    fn new(count: usize, apart_m: f64) -> Self {
        let labels = instances::mountains(count, 1400.0, 3);
        let mut random = Random(9);
        let place = |label: Label| {
            let (angle, away_m) = (random.unit() * std::f64::consts::TAU, 3000.0 + 40_000.0 * random.unit());
            ([away_m * angle.cos(), away_m * angle.sin()], label)
        };
        Self { peaks: labels.into_iter().map(place).collect(), apart_m }
    }

    fn frame(&self, time_s: f64) -> Vec<Summit> {
        let yaw = 0.12 * time_s + 0.3 * (0.5 * time_s).sin();
        let (sin, cos) = yaw.sin_cos();
        let at = [150.0 * time_s, 60.0 * time_s];
        let mut summits = Vec::new();
        for (id, (peak, label)) in (0..).zip(&self.peaks) {
            let [east, north] = [peak[0] - at[0], peak[1] - at[1]];
            let [depth, right] = [east * cos + north * sin, east * sin - north * cos];
            let x_px = [0.0, self.apart_m].map(|apart_m| 700.0 + 900.0 * (right - apart_m) / depth);
            // Land hides a summit from time to time.
            let is_hidden = ((time_s + id as f64 * 0.7) * 0.4).sin() > 0.9;
            if depth > 500.0 {
                let label = Label { x_px, y_px: 200.0 + 1e6 / depth, ..*label };
                summits.push(Summit { id, label, is_visible: !is_hidden });
            }
        }
        summits
    }
}

/// What happens in a flight.
#[derive(Debug, Default)]
struct Log {
    frames: usize,
    labels: usize,
    changes: usize,
    /// Changes less than a second after the one before, of labels that were not hidden.
    early: usize,
    /// Violations among labels that remain, and among all.
    wrong: usize,
    wrong_fading: usize,
    /// Largest movement of a label relative to its summit in a frame, more than its neighbours move.
    jump_px: f64,
    /// Longest frame.
    slowest_s: f64,
}

fn of(shown: &[Shown]) -> (Vec<Label>, Vec<Option<Place>>) {
    shown.iter().map(|shown| (shown.label, Some(shown.place))).unzip()
}

fn log(world: &World, rows: &Rows, rate: f64, seconds: f64) -> (Log, Vec<Vec<Shown>>) {
    let (mut flight, mut log, mut frames) = (Flight::default(), Log::default(), Vec::<Vec<Shown>>::new());
    let mut changed: BTreeMap<u64, f64> = BTreeMap::new();
    for index in 0..(rate * seconds) as usize {
        let time_s = index as f64 / rate;
        let summits = world.frame(time_s);
        let begin = std::time::Instant::now();
        let shown = flight.frame(time_s, &summits, rows);
        log.slowest_s = log.slowest_s.max(begin.elapsed().as_secs_f64());
        let before: BTreeMap<u64, Shown> =
            frames.last().into_iter().flatten().map(|shown| (shown.id, *shown)).collect();
        for now in &shown {
            let old = before.get(&now.id);
            let step = now.opacity - old.map_or(0.0, |old| old.opacity);
            assert!((0.0..=1.0).contains(&now.opacity) && step.abs() < 1.0 / rate / FADE_S + 1e-6, "{step}");
            let is_new = old.is_none_or(|old| old.is_leaving && !now.is_leaving);
            let leaves = old.is_some_and(|old| !old.is_leaving) && now.is_leaving;
            assert!(old.is_none_or(|old| old.place.row == now.place.row || old.opacity < 1.0 / rate / FADE_S + 1e-6));
            if is_new || leaves {
                log.changes += 1;
                let seen = summits.iter().find(|summit| summit.id == now.id);
                let inside = |x_px: &f64| *x_px >= rows.margin_px && *x_px <= rows.width_px - rows.margin_px;
                let stays = seen.is_some_and(|summit| summit.is_visible && summit.label.x_px.iter().all(inside));
                let last_s = changed.insert(now.id, time_s).unwrap_or(-10.0);
                let is_early = time_s - last_s < CHANGE_S - 1e-6;
                // A label that moves to another row appears again as soon as it is gone.
                log.early += usize::from(is_early && leaves && stays);
                assert!(!is_early || !is_new || time_s - last_s > FADE_S - 1e-6);
            }
            if let Some(old) = old.filter(|_| !is_new && !now.is_leaving) {
                log.jump_px = log.jump_px.max((now.place.offset_px - old.place.offset_px).abs());
            }
        }
        let (labels, places) = of(&shown);
        log.wrong_fading += check(&labels, rows, &places).len();
        let stays: Vec<Shown> = shown.iter().filter(|shown| !shown.is_leaving).copied().collect();
        let (labels, places) = of(&stays);
        log.wrong += check(&labels, rows, &places).len();
        log.frames += 1;
        log.labels += stays.len();
        frames.push(shown);
    }
    (log, frames)
}

#[test]
fn labels_are_steady_in_flight() {
    for apart_m in [0.0, 100.0] {
        let world = World::new(150, apart_m);
        let rows = instances::rows(4, 1400.0);
        let (log, _) = log(&world, &rows, 60.0, 40.0);
        println!("{apart_m} m: {log:?}");
        // Labels that remain never overlap, in either picture.
        assert_eq!(log.wrong, 0);
        assert!(log.labels > 15 * log.frames && log.changes > 300, "{log:?}");
        // Few labels that remain visible lack space in the first second.
        assert!(log.early * 20 < log.changes, "{log:?}");
        assert!(log.jump_px < 15.0, "{log:?}");
    }
}

#[test]
fn flights_do_not_depend_on_the_frame_rate() {
    let world = World::new(150, 0.0);
    let rows = instances::rows(4, 1400.0);
    let rates = [30.0, 60.0, 90.0].map(|rate| log(&world, &rows, rate, 30.0).1);
    let (mut same, mut different, mut far) = (0, 0, 0);
    for index in 0..rates[0].len() {
        for (turn, others) in rates.iter().enumerate().skip(1) {
            let shown: BTreeMap<u64, Shown> =
                others[index * (turn + 1)].iter().map(|shown| (shown.id, *shown)).collect();
            for one in &rates[0][index] {
                let other = shown.get(&one.id).filter(|other| other.place.row == one.place.row);
                let is_same = other.is_some_and(|other| (other.opacity - one.opacity).abs() < 0.12);
                same += usize::from(is_same);
                different += usize::from(!is_same);
                // A label that leaves does so at the frame that sees that it must: here, summits at the sides of the
                // picture move by 8 px in the longest frame.
                let most_px = if one.is_leaving { 9.0 } else { 4.0 };
                far += usize::from(other.is_some_and(|o| (o.place.offset_px - one.place.offset_px).abs() > most_px));
            }
        }
    }
    println!("same {same}, different {different}, far apart {far}");
    assert!(same > 20_000 && 100 * (different + far) < same);
}

#[test]
fn names_on_a_map_are_steady() {
    let mut random = Random(4);
    let cities: Vec<([f64; 2], f64)> =
        (0..200).map(|_| ([random.unit() * 2000.0, random.unit() * 900.0], random.unit())).collect();
    let area = Rect { from_px: [0.0; 2], to_px: [900.0, 600.0] };
    let page = Page { area, gap_px: 2.0, symbol_gap_px: 2.0 };
    let (mut flight, mut changed, mut before) = (MapFlight::default(), BTreeMap::new(), BTreeMap::new());
    let (mut changes, mut early, mut labels, mut wrong) = (0, 0, 0, 0);
    for index in 0..900 {
        let time_s = f64::from(index) / 60.0;
        let scale = 0.6 + 0.3 * (0.5 * time_s).sin();
        let spot = |(id, (at, weight)): (u64, &([f64; 2], f64))| {
            let at_px = [(at[0] - 40.0 * time_s) * scale, at[1] * scale];
            let point = Point { at_px, radius_px: 2.0, size_px: [70.0, 13.0], weight: 1.0 + weight };
            Spot { id, point, is_visible: true }
        };
        let spots: Vec<Spot> = (0..).zip(&cities).map(spot).collect();
        let names = flight.frame(time_s, &spots, &page, &[]);
        for (turn, name) in names.iter().enumerate().filter(|(_, name)| !name.is_leaving) {
            labels += 1;
            wrong += names[..turn].iter().filter(|o| !o.is_leaving && o.area.overlaps(&name.area, 0.0)).count();
        }
        let now: BTreeMap<u64, usize> = names.iter().filter(|name| !name.is_leaving).map(|n| (n.id, n.side)).collect();
        for id in (0..200).filter(|id| before.get(id) != now.get(id)) {
            changes += 1;
            let last_s = changed.insert(id, time_s).unwrap_or(-10.0);
            let inside =
                |name: &&ShownName| name.area.from_px[0] >= 0.0 && name.area.to_px.iter().all(|to| *to <= 600.0);
            let stays = names.iter().find(|name| name.id == id).filter(inside).is_some();
            early += usize::from(!now.contains_key(&id) && stays && time_s - last_s < CHANGE_S - 1e-6);
        }
        before = now;
    }
    println!("map: {labels} names in 900 frames, {changes} changes, {early} early, {wrong} overlaps");
    assert!(labels > 20_000 && changes > 50 && early * 20 < changes && wrong == 0);
}

#[test]
fn odd_frames_are_harmless() {
    let rows = instances::rows(3, 900.0);
    let usual = Label { x_px: [400.0; 2], y_px: 300.0, width_px: 60.0, height_px: 14.0, weight: 1.0 };
    let summit = Summit { id: 1, label: usual, is_visible: true };
    let mut flight = Flight::default();
    assert_eq!(flight.frame(0.0, &[summit, summit], &rows).len(), 1);
    assert_eq!(flight.frame(1.0, &[summit], &rows)[0].opacity, 1.0);
    for number in [f64::NAN, f64::INFINITY, 1e300] {
        let broken = Summit { label: Label { x_px: [number; 2], ..usual }, ..summit };
        flight.frame(number.min(1.0), &[broken], &rows);
    }
    // The summit is gone: the label fades where it was.
    let shown = flight.frame(1.1, &[], &rows);
    assert!(shown.len() == 1 && shown[0].opacity < 0.7 && shown[0].label == usual, "{shown:?}");
    assert_eq!(flight.frame(1.31, &[], &rows), []);
    // Rows are fewer than before, and the time jumps back.
    let none = Rows { tops_px: Vec::new(), ..rows.clone() };
    flight.frame(3.0, &[summit], &rows);
    assert!(flight.frame(4.0, &[summit], &none).iter().all(|shown| shown.is_leaving));
    assert_eq!(flight.frame(0.0, &[], &rows), []);
}
