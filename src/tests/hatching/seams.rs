//! Tests that marks are independent of tiles and levels of detail: no seam shows where these meet.

use crate::tests::common::{full, quantile, rough_height_m};
use crate::tests::hatching::grain::{Land, WINDOW_PX, between_deg};
use crate::tests::hatching::plane::{Inked, style};

fn layers(direction: &str, angle_deg: f64) -> String {
    format!(
        "[[hatching.layers]]\nmarks = \"line\"\ndirection = \"{direction}\"\nangle_deg = {}\n",
        angle_deg + if direction == "fixed" { 33.0 } else { 0.0 }
    )
}

const HILL_CAMERAS: [&str; 3] = ["200,-250,1300,0,-90,50", "-900,-1300,900,35,-35,50", "-800,500,1500,160,-70,50"];

/// Returns scales with directions; in the fast tier two that share neither.
fn ways() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of_scale = |scale| ["fixed", "slope", "contour"].map(|direction| (scale, direction));
    let all = ["blend", "add"].into_iter().flat_map(of_scale);
    all.filter(|way| full() || [("blend", "slope"), ("add", "contour")].contains(way))
}

/// Distance from a seam to the pixels that it is compared with.
const NEARBY_PX: i64 = 4;

/// Changes of ink at seams between patches, and near seams.
#[derive(Clone, Copy, Debug, Default)]
struct Seams {
    /// Sum of the changes of ink from pixel to pixel across seams.
    across: f64,
    nearby: f64,
    count: usize,
}

/// Adds the seams of a picture.
fn seen(seams: &mut Seams, shot: &Inked) {
    let [width, height] = shot.size_px.map(|side| side as i64);
    for y in 0..height {
        for x in 0..width {
            for (right, down) in [(1, 0), (0, 1)] {
                // Returns the patches of two adjacent pixels, and how much the ink differs between them.
                let pair = |k: i64| {
                    let (x, y) = (x + k * right, y + k * down);
                    let inside = x >= 0 && y >= 0 && x + right < width && y + down < height;
                    inside.then(|| {
                        let (i, j) = (y * width + x, (y + down) * width + x + right);
                        let [i, j] = [i, j].map(|at| at as usize);
                        ([shot.patch[i], shot.patch[j]], (shot.ink[i] - shot.ink[j]).abs())
                    })
                };
                let (Some(here), Some(before), Some(after)) = (pair(0), pair(-NEARBY_PX), pair(NEARBY_PX)) else {
                    continue;
                };
                let [first, next] = here.0;
                if first != next && first != 0 && next != 0 && before.0 == [first; 2] && after.0 == [next; 2] {
                    seams.across += here.1;
                    seams.nearby += 0.5 * (before.1 + after.1);
                    seams.count += 1;
                }
            }
        }
    }
}

/// Largest allowed ratio of the change of ink at seams to that near seams.
const ALLOWED: f64 = 1.15;

fn is_seamless(seams: Seams) -> bool {
    seams.across / seams.nearby < ALLOWED
}

/// Returns a picture with a planted error: in some patches marks are 3 pixels aside, or 3 pixels below.
fn broken(shot: &Inked) -> Inked {
    let [width, height] = shot.size_px;
    let moved = |i: usize| {
        let part = shot.patch[i] % 3;
        let (x, y) = (i % width + if part == 1 { 3 } else { 0 }, i / width + if part == 2 { 3 } else { 0 });
        shot.at(x.min(width - 1), y.min(height - 1))
    };
    let ink = (0..shot.ink.len()).map(moved).collect();
    Inked { ink, place_m: shot.place_m.clone(), patch: shot.patch.clone(), ..*shot }
}

#[test]
fn nothing_shows_where_patches_meet() {
    let hill = full().then(|| ("hill", Land::hill(1.0), HILL_CAMERAS));
    let rough = (
        "rough",
        Land::new(641, 20.0, rough_height_m),
        ["0,0,+2500,20,-90,50", "-900,-1300,+2500,35,-60,50", "-1800,2100,+2500,140,-70,50"],
    );
    for (name, land, cameras) in hill.into_iter().chain([rough]) {
        let Some(mut land) = land else { return };
        for (scale, direction) in ways() {
            let style = style(scale, 0.4, &layers(direction, 0.0));
            let (mut seams, mut planted) = (Seams::default(), Seams::default());
            for camera in cameras {
                let shot = land.shoot(camera, &style);
                seen(&mut seams, &shot);
                seen(&mut planted, &broken(&shot));
            }
            let part = |seams: Seams| seams.across / seams.nearby;
            println!(
                "{name} {scale} {direction}: ink changes {:.3} times as much at {} seams, {:.3} when broken",
                part(seams),
                seams.count,
                part(planted)
            );
            assert!(seams.count > 1000 && is_seamless(seams), "{name} {scale} {direction}: a seam shows: {seams:?}");
            assert!(!is_seamless(planted), "{name} {scale} {direction}: a planted seam was not detected: {planted:?}");
        }
    }
}

/// Returns the mean ink of windows in which patches meet, and of the others.
fn means(shots: &[Inked]) -> [f64; 2] {
    let (mut sums, mut counts) = ([0.0; 2], [0; 2]);
    for shot in shots {
        for window in shot.windows() {
            let at = |k: usize| {
                let [x, y] = window.first;
                shot.patch[(y + k / WINDOW_PX) * shot.size_px[0] + x + k % WINDOW_PX]
            };
            let is_whole = (0..WINDOW_PX * WINDOW_PX).all(|k| at(k) == at(0));
            sums[usize::from(is_whole)] += window.ink;
            counts[usize::from(is_whole)] += 1;
        }
    }
    assert!(counts[0] > 60 && counts[1] > 60, "{counts:?}");
    [sums[0] / f64::from(counts[0]), sums[1] / f64::from(counts[1])]
}

/// Returns the picture with a planted error: no ink where patches meet, three pixels wide.
fn cracked(shot: &Inked) -> Inked {
    let width = shot.size_px[0];
    let is_other = |i: usize, j: usize| shot.patch.get(j).is_some_and(|patch| *patch != shot.patch[i]);
    let is_crack = |i: usize| (1..=3).any(|k| is_other(i, i + k) || is_other(i, i + k * width));
    let ink = shot.ink.iter().enumerate().map(|(i, ink)| if is_crack(i) { 0.0 } else { *ink }).collect();
    Inked { ink, place_m: shot.place_m.clone(), patch: shot.patch.clone(), ..*shot }
}

#[test]
fn there_is_as_much_ink_where_patches_meet() {
    let Some(mut land) = Land::hill(1.0) else { return };
    let is_even = |[across, whole]: [f64; 2]| (across - whole).abs() < 0.016;
    for (scale, direction) in ways() {
        let style = style(scale, 0.4, &layers(direction, 0.0));
        let shots = HILL_CAMERAS.map(|camera| land.shoot(camera, &style));
        let (right, planted) = (means(&shots), means(&shots.each_ref().map(cracked)));
        println!("{scale} {direction}: ink where patches meet, and elsewhere {right:.4?}, cracked {planted:.4?}");
        assert!(is_even(right), "{scale} {direction}: ink differs where patches meet: {right:?}");
        assert!(!is_even(planted), "{scale} {direction}: a planted crack was not detected: {planted:?}");
    }
}

/// Returns the differences between two pictures of the same land, in direction and in ink of windows: 90th percentiles.
fn apart(a: &Inked, b: &Inked) -> [f64; 2] {
    let (a, b) = (a.windows(), b.windows());
    let pairs = || a.iter().zip(&b).inspect(|(a, b)| assert_eq!(a.first, b.first));
    let coherent = pairs().filter(|(a, b)| a.coherence.min(b.coherence) > 0.5);
    let mut angles: Vec<f64> = coherent.map(|(a, b)| between_deg(a.along, b.along)).collect();
    let mut inks: Vec<f64> = pairs().map(|(a, b)| (a.ink - b.ink).abs()).collect();
    assert!(angles.len() > 25, "{}", angles.len());
    [quantile(&mut angles, 0.9), quantile(&mut inks, 0.9)]
}

fn is_same([angle_deg, ink]: [f64; 2]) -> bool {
    angle_deg < 1.0 && ink < 0.01
}

#[test]
fn coarser_tiles_have_the_same_marks() {
    let hill = ("hill", Land::hill(1.0), "-900,-1300,900,35,-35,50");
    let rough = full().then(|| ("rough", Land::new(641, 20.0, rough_height_m), "0,0,+4000,20,-70,50"));
    for (name, land, camera) in [hill].into_iter().chain(rough) {
        let Some(mut land) = land else { return };
        for (scale, direction) in ways() {
            let shots = [(0.25, 0.0), (2.0, 0.0), (2.0, 8.0)].map(|(lod_error_px, turn_deg)| {
                land.world.surfaces.terrain.set_lod_error_px(lod_error_px);
                land.shoot(camera, &style(scale, 0.4, &layers(direction, turn_deg)))
            });
            let patches = |shot: &Inked| shot.patch.iter().collect::<std::collections::BTreeSet<_>>().len();
            let [fine, coarse, turned] = &shots;
            let off = apart(fine, coarse);
            assert!(patches(fine) > 2 * patches(coarse));
            assert!(is_same(off), "{name} {scale} {direction}: marks on coarser tiles differ: {off:?}");
            assert!(!is_same(apart(fine, turned)), "other directions were not detected");
            println!("{name} {scale} {direction}: {off:.3?}, patches {} {}", patches(&shots[0]), patches(&shots[1]));
        }
    }
}

/// Returns the number of frames of a climb through two octaves; in the fast tier it ends after more than one.
fn frames() -> i32 {
    if full() { 36 } else { 24 }
}

/// A frame stands out if its change of ink is more than this factor times the median.
const STANDS_OUT: f64 = 1.3;

/// Returns the largest mean change of ink on the ground from one frame to the next, and its ratio to the median.
fn worst(shots: &[Inked]) -> (f64, f64) {
    let mean = |pair: &[Inked]| {
        let changes: Vec<f64> = pair[0].changes(&pair[1]).into_iter().flatten().collect();
        changes.iter().sum::<f64>() / changes.len() as f64
    };
    let mut changes: Vec<f64> = shots.windows(2).map(mean).collect();
    let most = changes.iter().copied().fold(0.0, f64::max);
    (most, most / quantile(&mut changes, 0.5))
}

#[test]
fn no_frame_of_a_climb_stands_out() {
    let Some(mut land) = Land::hill(3.0) else { return };
    // In the fast tier only marks that are added: the zoom in `continuous` has marks that blend.
    let all = [("add", "slope"), ("blend", "slope"), ("blend", "contour")];
    for (scale, direction) in all.into_iter().take(if full() { all.len() } else { 1 }) {
        let style = style(scale, 0.4, &layers(direction, 0.0));
        let mut shots: Vec<Inked> = (0..frames())
            .map(|i| land.shoot(&format!("700,-750,{},0,-80,50", 1500.0 * 1.04_f64.powi(i)), &style))
            .collect();
        let (most, part) = worst(&shots);
        println!("{scale} {direction}: ink changes by {most:.4} at most, {part:.2} times the median");
        assert!(part < STANDS_OUT, "{scale} {direction}: {part}");
        // Planted error: one frame with its own level.
        let other = self::style(scale, 0.4, &format!("{}size = 1.2\n", layers(direction, 0.0)));
        shots[20] = land.shoot(&format!("700,-750,{},0,-80,50", 1500.0 * 1.04_f64.powi(20)), &other);
        assert!(worst(&shots).1 > STANDS_OUT, "{scale} {direction}: a planted frame was not detected");
    }
}
