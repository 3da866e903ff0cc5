//! Tests of the trees of lines, with planted errors that the checks must find.

use std::time::Instant;

use glam::DVec2;

use super::{BLOCK_POINTS, Block, BlockPoint, Chosen, LineTree, NO_CHILD, Sight};

/// A generator of pseudo-random numbers (splitmix64).
struct Random(u64);

impl Random {
    /// Returns a number from 0 to 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a position with coordinates from 0 to 1.
    fn place(&mut self) -> DVec2 {
        DVec2::new(self.unit(), self.unit())
    }

    /// Returns a random walk with steps of 2 m to 10 m that turns slowly.
    fn walk(&mut self, start_m: DVec2, count: usize) -> Vec<DVec2> {
        let (mut at_m, mut angle) = (start_m, 6.0 * self.unit());
        (0..count)
            .map(|_| {
                angle += self.unit() - 0.5;
                at_m += DVec2::from_angle(angle) * (2.0 + 8.0 * self.unit());
                at_m
            })
            .collect()
    }
}

/// Returns lines of many shapes.
fn shapes() -> Vec<(u32, Vec<DVec2>)> {
    let mut random = Random(1);
    let origin = DVec2::new(2_600_000.0, 1_200_000.0);
    let mut lines = Vec::new();
    for count in [2, 3, 5, 8, 63, 64, 65, 127, 128, 190, 1000, 3001] {
        let start_m = origin + 1000.0 * random.place();
        lines.push(random.walk(start_m, count));
    }
    let spiral = |i: usize| origin + DVec2::from_angle(0.1 * i as f64) * (5.0 + i as f64);
    lines.push((0..2000).map(spiral).collect());
    let zigzag = |i: usize| origin + DVec2::new(3.0 * i as f64, 20.0 * (i % 2) as f64 + (i % 7) as f64);
    lines.push((0..1500).map(zigzag).collect());
    let straight = |i: usize| origin + DVec2::new(4.0 * i as f64, -3.0 * i as f64);
    lines.push((0..700).map(straight).collect());
    for count in [4, 30, 700] {
        let mut ring: Vec<DVec2> = (0..count)
            .map(|i| {
                let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
                origin + DVec2::from_angle(angle) * (5.0 * f64::from(count)) * (1.0 + 0.1 * (9.0 * angle).sin())
            })
            .collect();
        ring.push(ring[0]);
        lines.push(ring);
    }
    // Long, with steps of 10 km.
    let coast = random.walk(DVec2::ZERO, 900).iter().map(|&at| at * 2000.0).collect();
    lines.push(coast);
    (0_u32..).zip(lines).collect()
}

/// Returns the position of a point in metres of the world.
fn world_m(block: &Block, point: &BlockPoint) -> DVec2 {
    block.origin_m + DVec2::from(point.at_m.map(f64::from))
}

/// Returns the distance of a point from a segment.
fn distance_m(at_m: DVec2, start_m: DVec2, end_m: DVec2) -> f64 {
    let along = end_m - start_m;
    let share = if along == DVec2::ZERO { 0.0 } else { (at_m - start_m).dot(along) / along.length_squared() };
    at_m.distance(start_m + along * share.clamp(0.0, 1.0))
}

/// Returns the length up to each vertex, in metres.
fn lengths_m(line: &[DVec2]) -> Vec<f32> {
    let mut length_m = 0.0;
    let mut before_m = line[0];
    line.iter()
        .map(|&at_m| {
            length_m += at_m.distance(before_m);
            before_m = at_m;
            length_m as f32
        })
        .collect()
}

/// Counts the blocks that are farther from their original vertices, or from points between these, than their error
/// times `factor`; of those that are not leaves and whose error is above 0.1 m. Returns this and the number of all.
fn count_wrong_errors(tree: &LineTree, lines: &[(u32, Vec<DVec2>)], factor: f64) -> (usize, usize) {
    let (mut wrong, mut all) = (0, 0);
    for block in tree.blocks() {
        let line = &lines[block.feature as usize].1;
        let lengths = lengths_m(line);
        let points = tree.points(block);
        let first = lengths.iter().position(|&length| length == points[0].along_m).unwrap();
        let last = lengths.iter().position(|&length| length == points[points.len() - 1].along_m).unwrap();
        let part = &line[first..=last];
        let world: Vec<DVec2> = points.iter().map(|point| world_m(block, point)).collect();
        let samples = part.iter().copied().chain(part.windows(2).map(|ends| ends[0].lerp(ends[1], 0.37)));
        let measured_m = samples
            .map(|at_m| world.windows(2).map(|ends| distance_m(at_m, ends[0], ends[1])).fold(f64::INFINITY, f64::min))
            .fold(0.0, f64::max);
        if block.children == [NO_CHILD; 2] {
            // Nothing but the rounding of positions, at most half of the coarsest grid of the line.
            assert_eq!(block.error_m, 0.0);
            let size_m = line.iter().fold(0.0_f64, |size, at_m| size.max(at_m.distance(line[0])));
            assert!(measured_m < 1e-3 + size_m * 2.0_f64.powi(-22), "{measured_m}");
            continue;
        }
        let bound_m = f64::from(block.error_m);
        assert!(measured_m <= 1e-6 + bound_m || factor != 1.0, "{measured_m} {bound_m}");
        if bound_m > 0.1 {
            all += 1;
            wrong += usize::from(measured_m > factor * bound_m);
        }
    }
    (wrong, all)
}

/// Checks that blocks cover lines exactly once from end to end, and returns what is wrong.
fn find_gap(tree: &LineTree, chosen: &[u32], lines: &[(u32, Vec<DVec2>)]) -> Option<String> {
    for (feature, line) in lines {
        let mut blocks: Vec<&Block> = chosen.iter().map(|&index| &tree.blocks()[index as usize]).collect();
        blocks.retain(|block| block.feature == *feature);
        // `choose` lists the blocks of a line in its order, so they need not be sorted.
        let mut end: Option<(DVec2, f32)> = None;
        for block in &blocks {
            let points = tree.points(block);
            let (first, last) = (points[0], points[points.len() - 1]);
            let start = (world_m(block, &first), first.along_m);
            let before = end.unwrap_or((start.0, 0.0));
            if start != before {
                return Some(format!("feature {feature}: {before:?} is followed by {start:?}"));
            }
            end = Some((world_m(block, &last), last.along_m));
        }
        let length_m = lengths_m(line).last().copied();
        if end.map(|(_, along_m)| along_m) != length_m {
            return Some(format!("feature {feature}: ends at {end:?} of {length_m:?}"));
        }
    }
    None
}

/// Chooses with a camera at a position; a pixel is `per_m` of the distance.
fn choose_from(tree: &LineTree, eye_m: DVec2, per_m: f64, most: usize) -> (Vec<u32>, Chosen) {
    let sight = Sight {
        is_seen: &|_, _| true,
        pixel_m: &|low_m, high_m| per_m * eye_m.distance(eye_m.clamp(low_m, high_m)),
        is_drawn: &|_| true,
        error_px: 0.5,
    };
    let mut chosen = vec![7];
    let report = tree.choose(&sight, most, &mut chosen);
    (chosen, report)
}

/// Chooses everything for a pixel of a constant width.
fn choose_flat(tree: &LineTree, pixel_m: f64, most: usize) -> (Vec<u32>, Chosen) {
    let sight = Sight { is_seen: &|_, _| true, pixel_m: &|_, _| pixel_m, is_drawn: &|_| true, error_px: 0.5 };
    let mut chosen = Vec::new();
    let report = tree.choose(&sight, most, &mut chosen);
    (chosen, report)
}

#[test]
fn errors_are_upper_bounds() {
    let lines = shapes();
    let tree = LineTree::new(lines.clone());
    let (wrong, all) = count_wrong_errors(&tree, &lines, 1.0);
    assert_eq!(wrong, 0);
    assert!(all > 100, "{all}");
}

/// Planted: errors that are too small by a factor of 4. The bounds are tight enough for nearly all to be noticed.
#[test]
fn errors_that_are_too_small_are_noticed() {
    let lines = shapes();
    let tree = LineTree::new(lines.clone());
    let (wrong, all) = count_wrong_errors(&tree, &lines, 0.25);
    assert!(wrong * 10 > all * 9, "{wrong} of {all}");
}

#[test]
fn blocks_are_consistent() {
    let lines = shapes();
    let tree = LineTree::new(lines.clone());
    let mut is_child = vec![false; tree.blocks().len()];
    for block in tree.blocks() {
        let points = tree.points(block);
        assert!((2..=BLOCK_POINTS).contains(&points.len()));
        assert!(points.windows(2).all(|pair| pair[0].along_m < pair[1].along_m));
        assert!(points.len() == 2 || points.windows(2).all(|pair| pair[0].at_m != pair[1].at_m));
        let slack_m = DVec2::splat(1e-3 + (block.high_m - block.low_m).max_element() * 1e-6);
        for point in points {
            let at_m = world_m(block, point);
            assert!(at_m.cmpge(block.low_m - slack_m).all() && at_m.cmple(block.high_m + slack_m).all());
        }
        let children: Vec<u32> = block.children.into_iter().filter(|&child| child != NO_CHILD).collect();
        let mut below = 0;
        for &child in &children {
            assert!(!std::mem::replace(&mut is_child[child as usize], true));
            let child = &tree.blocks()[child as usize];
            assert!(child.error_m <= block.error_m && child.feature == block.feature);
            assert!(child.low_m.cmpge(block.low_m).all() && child.high_m.cmple(block.high_m).all());
            below += tree.points(child).len();
        }
        assert!(children.is_empty() || points.len() < below);
    }
    assert_eq!(is_child.iter().filter(|&&is_child| !is_child).count(), lines.len());
    // The roots have few segments.
    assert!(tree.roots.iter().all(|root| tree.blocks()[root.block as usize].count <= 4));
}

/// Leaves hold the vertices; all vertices of all lines are there.
#[test]
fn leaves_hold_the_vertices() {
    let lines = shapes();
    let tree = LineTree::new(lines.clone());
    let (chosen, report) = choose_flat(&tree, 0.0, usize::MAX);
    assert_eq!(report, Chosen { raised: 1.0, left_out: 0 });
    for (feature, line) in &lines {
        let mut held: Vec<DVec2> = Vec::new();
        for block in chosen.iter().map(|&index| &tree.blocks()[index as usize]) {
            if block.feature == *feature {
                held.pop();
                held.extend(tree.points(block).iter().map(|point| world_m(block, point)));
            }
        }
        assert_eq!(held.len(), line.len());
        let size_m = line.iter().fold(0.0_f64, |size, at_m| size.max(at_m.distance(line[0])));
        let allowed_m = 1e-4 + size_m * 2.0_f64.powi(-23);
        assert!(held.iter().zip(line).all(|(held, at)| held.distance(*at) <= allowed_m));
    }
}

#[test]
fn choices_cover_lines_once() {
    let lines = shapes();
    let tree = LineTree::new(lines.clone());
    let mut random = Random(9);
    let mut sizes = Vec::new();
    for _ in 0..40 {
        let eye_m =
            DVec2::new(2_600_000.0, 1_200_000.0) + 6000.0 * DVec2::new(random.unit() - 0.5, random.unit() - 0.5);
        // So small a pixel that no group is smaller than half of it.
        let (chosen, report) = choose_from(&tree, eye_m, 0.02 * random.unit().powi(2), usize::MAX);
        assert_eq!(report, Chosen { raised: 1.0, left_out: 0 });
        assert_eq!(find_gap(&tree, &chosen, &lines), None);
        sizes.push(chosen.len());
    }
    // Levels are mixed.
    sizes.sort_unstable();
    assert!(sizes[0] + 20 < sizes[39], "{sizes:?}");
}

/// Planted: a block is missing, doubled, or replaced by one child.
#[test]
fn gaps_are_noticed() {
    let lines = shapes();
    let tree = LineTree::new(lines.clone());
    let (chosen, _) = choose_flat(&tree, 2.0, usize::MAX);
    assert_eq!(find_gap(&tree, &chosen, &lines), None);
    for at in 0..chosen.len() {
        let mut fewer = chosen.clone();
        fewer.remove(at);
        assert!(find_gap(&tree, &fewer, &lines).is_some());
        let mut doubled = chosen.clone();
        doubled.insert(at, chosen[at]);
        assert!(find_gap(&tree, &doubled, &lines).is_some());
        if let [left, right] = tree.blocks()[chosen[at] as usize].children
            && right != NO_CHILD
        {
            let mut replaced = chosen.clone();
            replaced[at] = left;
            assert!(find_gap(&tree, &replaced, &lines).is_some());
        }
    }
}

/// The chosen blocks are fine enough, and their parents are not.
#[test]
fn wider_pixels_choose_coarser_blocks() {
    let tree = LineTree::new(shapes());
    let mut parents = vec![NO_CHILD; tree.blocks().len()];
    for (index, block) in (0_u32..).zip(tree.blocks()) {
        for child in block.children.into_iter().filter(|&child| child != NO_CHILD) {
            parents[child as usize] = index;
        }
    }
    let mut points_before = usize::MAX;
    for pixel_m in [0.0, 0.5, 2.0, 8.0, 32.0, 1000.0] {
        let (chosen, _) = choose_flat(&tree, pixel_m, usize::MAX);
        let mut points = 0;
        for &index in &chosen {
            let block = &tree.blocks()[index as usize];
            // Of all but the coast, which is much larger.
            points += if block.feature < 18 { tree.points(block).len() } else { 0 };
            assert!(f64::from(block.error_m) <= 0.5 * pixel_m);
            if let Some(parent) = tree.blocks().get(parents[index as usize] as usize) {
                assert!(f64::from(parent.error_m) > 0.5 * pixel_m);
            }
        }
        assert!(points < points_before, "{pixel_m}: {points}");
        points_before = points;
    }
    assert!(points_before < 500, "{points_before}");
}

#[test]
fn only_what_is_seen_and_drawn_is_chosen() {
    let lines = shapes();
    let tree = LineTree::new(lines.clone());
    let (low_m, high_m) = (DVec2::new(2_600_100.0, 1_199_800.0), DVec2::new(2_600_300.0, 1_200_400.0));
    let is_seen = |low: DVec2, high: DVec2| low.cmple(high_m).all() && high.cmpge(low_m).all();
    let sight = Sight {
        is_seen: &is_seen,
        pixel_m: &|_, _| 0.0,
        is_drawn: &|feature| !feature.is_multiple_of(3),
        error_px: 1.0,
    };
    let mut chosen = Vec::new();
    tree.choose(&sight, usize::MAX, &mut chosen);
    // Every leaf that is seen and drawn, and nothing else.
    let expected = |block: &Block| {
        block.children == [NO_CHILD; 2] && is_seen(block.low_m, block.high_m) && !block.feature.is_multiple_of(3)
    };
    let mut expected: Vec<u32> =
        (0_u32..).zip(tree.blocks()).filter(|(_, block)| expected(block)).map(|(index, _)| index).collect();
    assert!(expected.len() > 5 && expected.len() * 2 < tree.blocks().len());
    chosen.sort_unstable();
    expected.sort_unstable();
    assert_eq!(chosen, expected);
}

#[test]
fn budgets_are_kept() {
    let lines = shapes();
    let tree = LineTree::new(lines.clone());
    let eye_m = DVec2::new(2_605_000.0, 1_200_000.0);
    let (all, _) = choose_from(&tree, eye_m, 1e-4, usize::MAX);
    let (same, report) = choose_from(&tree, eye_m, 1e-4, all.len());
    assert_eq!((&same, report), (&all, Chosen { raised: 1.0, left_out: 0 }));
    let (fewer, report) = choose_from(&tree, eye_m, 1e-4, all.len() / 2);
    assert!(fewer.len() <= all.len() / 2 && report.raised >= 2.0 && report.left_out == 0, "{report:?}");
    assert_eq!(find_gap(&tree, &fewer, &lines), None);
    // The error is not raised more than needed.
    let sight = Sight {
        is_seen: &|_, _| true,
        pixel_m: &|low_m, high_m| 1e-4 * eye_m.distance(eye_m.clamp(low_m, high_m)),
        is_drawn: &|_| true,
        error_px: 0.25 * report.raised,
    };
    let mut finer = Vec::new();
    tree.choose(&sight, usize::MAX, &mut finer);
    assert!(finer.len() > all.len() / 2);

    // Nothing suffices: the nearest blocks.
    let (few, report) = choose_flat(&tree, 0.0, 10);
    assert_eq!(few.len(), 10);
    assert_eq!(report.left_out, tree.blocks().iter().filter(|block| block.children == [NO_CHILD; 2]).count() - 10);
    let (few, report) = choose_from(&tree, eye_m, 1e-9, 10);
    let (many, _) = choose_from(&tree, eye_m, 1e-9 * report.raised, usize::MAX);
    assert_eq!(report.left_out, many.len() - 10);
    let far_m = |index: &u32| {
        let block = &tree.blocks()[*index as usize];
        eye_m.distance(eye_m.clamp(block.low_m, block.high_m))
    };
    let farthest_m = few.iter().map(far_m).fold(0.0, f64::max);
    let nearest_m = many.iter().filter(|index| !few.contains(index)).map(far_m).fold(f64::INFINITY, f64::min);
    assert!(farthest_m <= nearest_m);
    assert_eq!(choose_flat(&tree, 0.0, 0).0, Vec::<u32>::new());
}

#[test]
fn results_are_deterministic() {
    let (one, other) = (LineTree::new(shapes()), LineTree::new(shapes()));
    assert!(one == other);
    let eye_m = DVec2::new(2_601_000.0, 1_200_000.0);
    for most in [usize::MAX, 50, 10] {
        assert_eq!(choose_from(&one, eye_m, 1e-3, most), choose_from(&other, eye_m, 1e-3, most));
    }
}

#[test]
fn hostile_lines_do_no_harm() {
    let nan = DVec2::new(f64::NAN, 0.0);
    let at = |x: f64| DVec2::new(x, 1.0);
    let points_of = |line: Vec<DVec2>| {
        let tree = LineTree::new([(3, line)]);
        let (chosen, _) = choose_flat(&tree, 0.0, usize::MAX);
        let blocks = chosen.iter().map(|&index| &tree.blocks()[index as usize]);
        blocks
            .map(|block| tree.points(block).iter().map(|point| (world_m(block, point).x, point.along_m)).collect())
            .collect::<Vec<Vec<(f64, f32)>>>()
    };
    assert!(points_of(vec![]).is_empty());
    assert!(points_of(vec![nan; 5]).is_empty());
    // A dot.
    assert_eq!(points_of(vec![at(5.0)]), [vec![(5.0, 0.0); 2]]);
    assert_eq!(points_of(vec![at(5.0); 300]), [vec![(5.0, 0.0); 2]]);
    assert_eq!(LineTree::new([(3, vec![at(5.0); 300])]).blocks().len(), 1);
    // Repeated vertices.
    let repeated = vec![at(1.0), at(1.0), at(2.0), at(2.0), at(2.0), at(4.0), at(4.0)];
    assert_eq!(points_of(repeated), [[(1.0, 0.0), (2.0, 1.0), (4.0, 3.0)]]);
    // Differences below the grid.
    assert_eq!(points_of(vec![at(1.0), at(1.0 + 1e-9)]), [[(1.0, 0.0), (1.0, (1.0_f64 + 1e-9 - 1.0) as f32)]]);
    let near = vec![at(1.0), at(1.0 + 1e-9), at(2.0), at(3.0 - 1e-9), at(3.0)];
    assert_eq!(points_of(near), [[(1.0, 0.0), (2.0, 1.0), (3.0, 2.0)]]);
    // Invalid vertices split the line, and the gap has no length.
    for bad in [nan, DVec2::splat(f64::INFINITY), DVec2::new(0.0, f64::NEG_INFINITY), at(1e300), at(-2e9)] {
        let line = vec![bad, at(1.0), at(2.0), bad, bad, at(7.0), at(9.0), bad];
        let pieces = points_of(line);
        assert_eq!(pieces.len(), 2);
        assert!(pieces.contains(&vec![(1.0, 0.0), (2.0, 1.0)]) && pieces.contains(&vec![(7.0, 1.0), (9.0, 3.0)]));
    }
    // Far apart, and far from the origin.
    let mut random = Random(4);
    let lines: Vec<(u32, Vec<DVec2>)> = (0..4)
        .map(|feature| {
            let size = [4e7, 1e9, 1e9, 100.0][feature as usize];
            let middle = [0.0, 0.0, 0.0, 9.9e8][feature as usize];
            let mut line: Vec<DVec2> = (0..500).map(|_| middle + size * (2.0 * random.place() - 1.0)).collect();
            if feature == 2 {
                // Steps of 1 m between ones of 1000 km.
                line = line.iter().flat_map(|&at| [at, at + 1.0, at * 0.999]).collect();
            }
            (feature, line)
        })
        .collect();
    let tree = LineTree::new(lines.clone());
    for pixel_m in [0.0, 10.0, 1e6, 1e8] {
        let (chosen, _) = choose_flat(&tree, pixel_m, usize::MAX);
        // Feature 3 is a group of its own, smaller than a pixel, at most once.
        assert_eq!(find_gap(&tree, &chosen, &lines), None);
    }
    for block in tree.blocks() {
        let points = tree.points(block);
        assert!(block.error_m.is_finite() && points.iter().all(|point| point.at_m.iter().all(|at| at.is_finite())));
    }
    // Hostile views.
    for pixel_m in [f64::NAN, f64::INFINITY, -1.0] {
        for error_px in [f64::NAN, 0.0, -1.0, f64::INFINITY, 1.0] {
            let sight = Sight { is_seen: &|_, _| true, pixel_m: &|_, _| pixel_m, is_drawn: &|_| true, error_px };
            let mut chosen = Vec::new();
            for most in [0, 1, 20, usize::MAX] {
                let report = tree.choose(&sight, most, &mut chosen);
                assert!(chosen.len() <= most && report.raised >= 1.0);
            }
        }
    }
    let empty = LineTree::new([]);
    assert_eq!(choose_flat(&empty, 1.0, 5), (vec![], Chosen { raised: 1.0, left_out: 0 }));
}

/// Returns lines of 1 to 4 vertices, at random places in a square of 100 km.
fn tiny_lines(count: u32) -> impl Iterator<Item = (u32, Vec<DVec2>)> {
    let mut random = Random(5);
    (0..count).map(move |feature| {
        let at_m = 1e5 * random.place();
        (feature, random.walk(at_m, 1 + feature as usize % 4))
    })
}

/// Every line that is drawn is near a chosen one.
#[test]
fn groups_smaller_than_a_pixel_are_drawn_as_one_line() {
    let lines: Vec<_> = tiny_lines(20_000).collect();
    let tree = LineTree::new(lines.clone());
    let is_drawn = |feature: u32| feature.is_multiple_of(3);
    let pixel_m = 4000.0;
    let sight = Sight { is_seen: &|_, _| true, pixel_m: &|_, _| pixel_m, is_drawn: &is_drawn, error_px: 1.0 };
    let mut chosen = Vec::new();
    let report = tree.choose(&sight, usize::MAX, &mut chosen);
    assert_eq!(report, Chosen { raised: 1.0, left_out: 0 });
    assert!((500..5000).contains(&chosen.len()), "{}", chosen.len());
    let middles: Vec<DVec2> = chosen.iter().map(|&index| tree.blocks()[index as usize].low_m).collect();
    assert!(chosen.iter().all(|&index| is_drawn(tree.blocks()[index as usize].feature)));
    for (_, line) in lines.iter().filter(|(feature, _)| is_drawn(*feature)).step_by(10) {
        assert!(middles.iter().any(|middle| middle.distance(line[0]) < pixel_m + 100.0));
    }
}

#[test]
fn a_million_tiny_lines_are_few_from_afar() {
    let tree = LineTree::new(tiny_lines(1_000_000));
    let (chosen, report) = choose_flat(&tree, 5000.0, usize::MAX);
    assert_eq!(report, Chosen { raised: 1.0, left_out: 0 });
    assert!((1600..6000).contains(&chosen.len()), "{}", chosen.len());
    let (chosen, _) = choose_flat(&tree, 1e6, 10_000);
    assert_eq!(chosen.len(), 1);
    // In a near view, the error is raised.
    let (chosen, report) = choose_from(&tree, DVec2::splat(5e4), 1e-3, 80_000);
    assert!(chosen.len() <= 80_000 && report.raised > 1.0 && report.left_out == 0, "{report:?}");
}

/// Returns the processor time of this thread in seconds, which a busy machine does not lengthen as much as wall time;
/// where there is no procfs, the wall time since `start`.
fn processor_s(start: Instant) -> f64 {
    let status = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let spent_ns = status.and_then(|status| status.split(' ').next()?.parse::<f64>().ok());
    spent_ns.map_or_else(|| start.elapsed().as_secs_f64(), |spent_ns| 1e-9 * spent_ns)
}

/// Prints sizes, processor times of building, and the shortest of 20 times of choosing. Run with
/// `cargo test --release -- --ignored --nocapture measure`.
#[test]
#[ignore = "prints measurements"]
#[allow(clippy::print_stdout, reason = "it prints what it measures")]
fn measure() {
    let epoch = Instant::now();
    let report = |name: &str, tree: &LineTree, vertices: usize, build_s: f64| {
        let bytes = tree.bytes() as f64;
        println!(
            "{name}: built in {build_s:.2} s, {:.0} MB, {:.1} B per vertex, {} blocks, {} points",
            bytes / 1e6,
            bytes / vertices as f64,
            tree.blocks().len(),
            tree.points.len()
        );
        let middle_m = DVec2::splat(5e4);
        for (view, eye_m, height_m, reach_m) in [
            ("whole, flat", middle_m, 1e5, 1e6),
            ("from 3 km above, to 100 km", middle_m, 3000.0, 1e6),
            ("from 100 m above, to 20 km", middle_m, 100.0, 2e4),
            ("on the ground, to 2 km", middle_m, 2.0, 2e3),
        ] {
            let per_m = 1e-3;
            let away_m = |low_m: DVec2, high_m: DVec2| eye_m.distance(eye_m.clamp(low_m, high_m));
            let sight = Sight {
                is_seen: &|low_m, high_m| away_m(low_m, high_m) < reach_m,
                pixel_m: &|low_m, high_m| per_m * away_m(low_m, high_m).hypot(height_m),
                is_drawn: &|_| true,
                error_px: 0.5,
            };
            let mut chosen = Vec::new();
            for most in [usize::MAX, 20_000] {
                let mut time_ms = f64::INFINITY;
                let mut report = None;
                for _ in 0..20 {
                    let start = Instant::now();
                    report = Some(tree.choose(&sight, most, &mut chosen));
                    time_ms = time_ms.min(1e3 * start.elapsed().as_secs_f64());
                }
                let points: usize = chosen.iter().map(|&index| tree.points(&tree.blocks()[index as usize]).len()).sum();
                println!(
                    "  {view}, at most {most}: {time_ms:.2} ms, {} blocks, {points} points, {report:?}",
                    chosen.len()
                );
            }
        }
    };
    for (count, length) in [(1000, 10_000), (1, 10_000_000)] {
        let mut random = Random(2);
        let lines: Vec<(u32, Vec<DVec2>)> = (0..count)
            .map(|feature| {
                (feature, {
                    let start_m = 1e5 * random.place();
                    random.walk(start_m, length)
                })
            })
            .collect();
        let start_s = processor_s(epoch);
        let tree = LineTree::new(lines);
        report(&format!("{count} × {length}"), &tree, count as usize * length, processor_s(epoch) - start_s);
    }
    let lines: Vec<(u32, Vec<DVec2>)> = tiny_lines(1_000_000).collect();
    let vertices = lines.iter().map(|(_, line)| line.len()).sum();
    let start_s = processor_s(epoch);
    let tree = LineTree::new(lines);
    report("1 000 000 tiny lines", &tree, vertices, processor_s(epoch) - start_s);
}
