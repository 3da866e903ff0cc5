//! Tests of the outlines of trees from many sides, and of what all species must satisfy.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

use super::patch::face;
use super::{Corner, Detail, Grown, Part, canopy};

const SIDE_PX: usize = 64;
/// Elevations of the eyes in radians, and the number of eyes around each.
const ELEVATIONS: [(f64, u32); 4] = [(0.0, 8), (0.35, 6), (0.8, 5), (FRAC_PI_2, 1)];
/// Pixels per unit; the picture is 1.1 wide, and trees are 1 tall.
const PX: f64 = SIDE_PX as f64 / 1.1;

type Outline = Vec<bool>;

/// The side of a surface that is seen.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Outer,
    Inner,
}

/// Returns the pixels that a tree covers, seen from far away.
fn outline(corners: &[Corner], azimuth: f64, elevation: f64) -> Outline {
    sides(corners, azimuth, elevation).into_iter().map(|side| side == Some(Side::Outer)).collect()
}

/// Returns the side of a tree's surface at each pixel, seen from far away.
fn sides(corners: &[Corner], azimuth: f64, elevation: f64) -> Vec<Option<Side>> {
    let (sin, cos) = azimuth.sin_cos();
    let right = DVec3::new(-sin, cos, 0.0);
    let up = DVec3::new(-cos * elevation.sin(), -sin * elevation.sin(), elevation.cos());
    let towards_eye = right.cross(up);
    let on_picture = |at: DVec3| {
        let at = at - DVec3::Z * 0.5;
        [at.dot(right), at.dot(up)].map(|along| along * PX + SIDE_PX as f64 / 2.0)
    };
    let mut nearest = vec![(f64::MIN, None); SIDE_PX * SIDE_PX];
    for triangle in corners.chunks_exact(3) {
        let places = [0, 1, 2].map(|i| on_picture(triangle[i].at));
        let [columns, rows] = [0, 1].map(|axis| {
            let along = places.map(|place| place[axis]);
            let (low, high) = along.iter().fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(*at), high.max(*at)));
            (low.max(0.0) as usize, (high.max(0.0) as usize + 1).min(SIDE_PX))
        });
        for y in rows.0..rows.1 {
            for x in columns.0..columns.1 {
                let here = [x as f64 + 0.5, y as f64 + 0.5];
                let areas = [0, 1, 2].map(|i| {
                    let (a, b) = (places[i], places[(i + 1) % 3]);
                    (b[0] - a[0]) * (here[1] - a[1]) - (b[1] - a[1]) * (here[0] - a[0])
                });
                let side = if areas.iter().all(|area| *area >= 0.0) {
                    Side::Outer
                } else if areas.iter().all(|area| *area <= 0.0) {
                    Side::Inner
                } else {
                    continue;
                };
                // Each corner's weight is the area opposite to it.
                let depth = |i: usize| triangle[i].at.dot(towards_eye) * areas[(i + 1) % 3];
                let depth = (depth(0) + depth(1) + depth(2)) / areas.iter().sum::<f64>();
                let seen = &mut nearest[y * SIDE_PX + x];
                if depth > seen.0 {
                    *seen = (depth, Some(side));
                }
            }
        }
    }
    nearest.into_iter().map(|(_, side)| side).collect()
}

fn outlines(corners: &[Corner]) -> Vec<Outline> {
    let around = |(elevation, count): (f64, u32)| {
        (0..count).map(move |i| (f64::from(i) / f64::from(count) * TAU + elevation, elevation))
    };
    ELEVATIONS.into_iter().flat_map(around).map(|(azimuth, elevation)| outline(corners, azimuth, elevation)).collect()
}

/// Returns the intersection over union of outlines: the mean of all sides, and the worst.
fn likeness(a: &[Outline], b: &[Outline]) -> (f64, f64) {
    let of = |(a, b): (&Outline, &Outline)| {
        let count = |both: fn(bool, bool) -> bool| a.iter().zip(b).filter(|(a, b)| both(**a, **b)).count();
        count(|a, b| a && b) as f64 / count(|a, b| a || b) as f64
    };
    let all: Vec<f64> = a.iter().zip(b).map(of).collect();
    (all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(1.0, f64::min))
}

/// Returns a tree turned about its trunk and scaled.
fn moved(corners: &[Corner], turn: f64, scale: f64) -> Vec<Corner> {
    let (sin, cos) = turn.sin_cos();
    let at = |at: DVec3| DVec3::new(cos * at.x - sin * at.y, sin * at.x + cos * at.y, at.z) * scale;
    corners.iter().map(|corner| Corner { at: at(corner.at), ..*corner }).collect()
}

#[test]
fn a_tree_keeps_its_outline_from_near_to_the_middle_distance() {
    for grown in Grown::ALL {
        let (min_mean, least) = match grown {
            Grown::Conifer | Grown::Birch => (0.85, 0.75),
            // It is almost round from above: with a smaller bound a turned tree would pass.
            Grown::Broadleaf => (0.86, 0.8),
            // Its limbs are less than a pixel wide here.
            Grown::Snag => (0.7, 0.5),
        };
        let [near, middle] = [Detail::Near, Detail::Middle].map(|detail| grown.grow(detail));
        let outlines_near = outlines(&near);
        let is_like = |other: &[Corner]| {
            let (mean, worst) = likeness(&outlines_near, &outlines(other));
            mean >= min_mean && worst >= least
        };
        assert!(is_like(&middle), "{}", grown.name());
        assert!(is_like(&near));
        // Planted: a smaller tree, a turned one, and trees of other species.
        assert!(!is_like(&moved(&middle, 0.0, 0.85)));
        assert!(!is_like(&moved(&middle, TAU / 12.0, 1.0)), "{} turned", grown.name());
        for other in Grown::ALL.into_iter().filter(|other| *other != grown) {
            assert!(!is_like(&other.grow(Detail::Middle)), "{} as {}", grown.name(), other.name());
        }
    }
}

#[test]
fn species_differ_in_their_outlines() {
    let all = Grown::ALL.map(|grown| (grown, outlines(&grown.grow(Detail::Near))));
    for (i, (grown, outlines)) in all.iter().enumerate() {
        for (other, others) in &all[..i] {
            let (mean, _) = likeness(outlines, others);
            assert!(mean < 0.8, "{} and {}: {mean}", grown.name(), other.name());
        }
        // Planted: the same species.
        assert!(likeness(outlines, outlines).0 >= 0.8);
    }
}

/// Returns a canopy at half its width, so that all of it is in the picture.
fn narrow(corners: &[Corner]) -> Vec<Corner> {
    corners.iter().map(|corner| Corner { at: corner.at * DVec3::new(0.5, 0.5, 1.0), ..*corner }).collect()
}

#[test]
fn the_inside_of_a_tree_is_hardly_visible() {
    // The share of a tree that shows the inside of its surface, from the worst side.
    let inside = |corners: &[Corner]| {
        let shares = ELEVATIONS.into_iter().flat_map(|(elevation, count)| {
            (0..count).map(move |i| {
                let sides = sides(corners, f64::from(i) / f64::from(count) * TAU, elevation);
                let count = |of| sides.iter().filter(|side| **side == Some(of)).count() as f64;
                count(Side::Inner) / (count(Side::Inner) + count(Side::Outer))
            })
        });
        shares.fold(0.0, f64::max)
    };
    for grown in Grown::ALL {
        for corners in [grown.grow(Detail::Near), grown.grow(Detail::Middle), narrow(&canopy(grown))] {
            let what = format!("{} of {} triangles", grown.name(), corners.len() / 3);
            assert!(inside(&corners) < 0.01, "{what}: {}", inside(&corners));
            // Planted: a tenth of the triangles is missing.
            let is_kept = |i: usize| i % 10 != 4;
            let kept = corners.chunks_exact(3).enumerate().filter(|(i, _)| is_kept(*i));
            let holed: Vec<Corner> = kept.flat_map(|(_, triangle)| triangle.to_vec()).collect();
            assert!(inside(&holed) > 0.01, "{what}: {}", inside(&holed));
        }
    }
}

/// Returns the first fault of the triangles, if there is one.
fn fault(corners: &[Corner]) -> Option<String> {
    if !corners.len().is_multiple_of(3) {
        return Some(format!("{} corners", corners.len()));
    }
    for triangle in corners.chunks_exact(3) {
        let places = [0, 1, 2].map(|i| triangle[i].at);
        let twice_area = face(places).length();
        let longest = (0..3).map(|i| places[i].distance(places[(i + 1) % 3])).fold(0.0, f64::max);
        // The width of a triangle relative to its length.
        if twice_area.is_nan() || twice_area / longest < 1e-3 || twice_area / longest < 0.008 * longest {
            return Some(format!("a needle: {triangle:?}"));
        }
        for corner in triangle {
            if (corner.normal.length() - 1.0).abs() > 1e-9 || corner.normal.dot(face(places)) <= 0.1 * twice_area {
                return Some(format!("a normal: {triangle:?}"));
            }
            if !(0.0..=1.0).contains(&corner.sway) || (corner.at.z == 0.0 && corner.sway > 0.0) {
                return Some(format!("sway: {corner:?}"));
            }
        }
    }
    None
}

fn top(corners: &[Corner]) -> f64 {
    corners.iter().map(|corner| corner.at.z).fold(f64::MIN, f64::max)
}

fn bottom(corners: &[Corner]) -> f64 {
    corners.iter().map(|corner| corner.at.z).fold(f64::MAX, f64::min)
}

fn radius(corners: &[Corner]) -> f64 {
    corners.iter().map(|corner| corner.at.truncate().length()).fold(0.0, f64::max)
}

#[test]
fn trees_are_one_tall_of_so_many_triangles_and_look_outward() {
    for grown in Grown::ALL {
        for (detail, counts) in [(Detail::Near, 500..=1800), (Detail::Middle, 120..=300)] {
            let corners = grown.grow(detail);
            assert_eq!(fault(&corners), None, "{} {detail:?}", grown.name());
            assert!(counts.contains(&(corners.len() / 3)), "{} {detail:?}: {}", grown.name(), corners.len() / 3);
            assert!(bottom(&corners).abs() < 1e-9 && (top(&corners) - 1.0).abs() < 1e-9);
            assert!(radius(&corners) <= 0.5, "{} {}", grown.name(), radius(&corners));
            let most = corners.iter().map(|corner| corner.sway).fold(0.0, f64::max);
            assert!(most > 0.6, "{} {detail:?}: {most}", grown.name());
            let has_leaves = corners.iter().any(|corner| corner.part == Part::Leaf);
            assert_eq!(has_leaves, grown != Grown::Snag);
            assert!(corners.iter().any(|corner| corner.part == Part::Bark));
        }
    }
}

#[test]
fn faults_of_triangles_are_found() {
    let tree = Grown::Birch.grow(Detail::Middle);
    assert_eq!(fault(&tree), None);
    let spoiled: [fn(&mut Vec<Corner>); 6] = [
        |tree| tree.swap(0, 1),
        |tree| tree[4].normal *= 0.9,
        |tree| tree[4].normal = -tree[4].normal,
        |tree| tree[5].at = tree[4].at,
        |tree| tree[7].sway = 1.2,
        |tree| tree.truncate(7),
    ];
    for spoil in spoiled {
        let mut tree = tree.clone();
        spoil(&mut tree);
        assert!(fault(&tree).is_some());
    }
}

/// Returns how often the upper edge of an outline turns from rising to falling, by two pixels or more.
fn peaks(outline: &Outline) -> usize {
    let heights = (0..SIDE_PX).filter_map(|x| (0..SIDE_PX).rev().find(|y| outline[y * SIDE_PX + x]));
    let (mut low, mut high, mut rises, mut count) = (0, 0, true, 0);
    for height in heights {
        if rises {
            high = high.max(height);
            if height + 2 <= high {
                (count, rises, low) = (count + 1, false, height);
            }
        } else {
            low = low.min(height);
            if height >= low + 2 {
                (rises, high) = (true, height);
            }
        }
    }
    count
}

#[test]
fn a_canopy_is_a_clump_of_crowns() {
    for grown in Grown::ALL {
        let corners = canopy(grown);
        assert_eq!(fault(&corners), None, "{}", grown.name());
        assert!((60..=160).contains(&(corners.len() / 3)), "{}: {}", grown.name(), corners.len() / 3);
        assert!((bottom(&corners) + 0.35).abs() < 1e-9 && (top(&corners) - 1.0).abs() < 1e-9);
        assert!((1.0..1.05).contains(&radius(&corners)), "{} {}", grown.name(), radius(&corners));
        let least = (0..8).map(|i| peaks(&outline(&narrow(&corners), f64::from(i) * 0.8, 0.1))).min();
        assert!(least >= Some(2), "{}: {least:?}", grown.name());
        // Planted: the mound alone has one peak.
        let mound = &narrow(&corners)[..15 * 3];
        assert_eq!(peaks(&outline(mound, 0.0, 0.1)), 1);
    }
}
