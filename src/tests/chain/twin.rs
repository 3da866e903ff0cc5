//! The GPU's chains equal those of the CPU twin, bit for bit.

use std::collections::BTreeSet;
use std::time::Instant;

use hachure::lines::strokes::chain::MAX_SEGMENTS;
use hachure::lines::strokes::twin::{self, Chained};
use hachure::lines::strokes::{Chain, ChainPosition, ChainRules, Segment};

use crate::tests::chain::Bench;
use crate::tests::chain::must::assert_chains;
use crate::tests::chain::scenes::{Dice, alone, moved, picture, ring, scene, segment, shuffled, wander};
use crate::tests::common::full;

/// Returns the chains of the segments first..first + count, numbered as if these segments were alone.
fn part(all: &Chained, first: usize, count: usize) -> Chained {
    let of_place = |place: usize| all.ordered[place] as usize / 2;
    let begin = all.chains.partition_point(|chain| of_place(chain.first as usize) < first);
    let end = all.chains.partition_point(|chain| of_place(chain.first as usize) < first + count);
    let places = first..first + count;
    Chained {
        ordered: all.ordered[places.clone()].iter().map(|state| state.wrapping_sub(2 * first as u32)).collect(),
        chains: all.chains[begin..end]
            .iter()
            .map(|chain| Chain { first: chain.first.wrapping_sub(first as u32), ..*chain })
            .collect(),
        places: all.places[places]
            .iter()
            .map(|place| ChainPosition { chain: place.chain.wrapping_sub(begin as u32), ..*place })
            .collect(),
    }
}

#[test]
fn ten_thousand_inputs_are_chained_as_by_the_twin() {
    const PLANES: i64 = 20;
    const SCENES: i64 = 470;
    let mut rules = ChainRules::default();
    let Some(mut bench) = Bench::new(1 << 15, rules) else { return };
    let mut compared = 0;
    let (mut closed, mut longest) = (0, 0);
    let planes: Vec<i64> = if full() { (0..PLANES).collect() } else { vec![0, 17, 18, 19] };
    for &plane in &planes {
        // Most planes use the default rules, some use others.
        rules = match plane {
            17 => ChainRules::new(1.0, 0.5),
            18 => ChainRules::new(20.0, 1.5),
            19 => ChainRules { reach_units: 1023, min_cos_squared: 0 },
            _ => ChainRules::default(),
        };
        bench.rules = rules;
        let scenes: Vec<Vec<Segment>> = (0..SCENES).map(|i| scene(plane * SCENES + i)).collect();
        let all: Vec<Segment> = (0..SCENES as i32)
            .zip(&scenes)
            .flat_map(|(i, scene)| {
                let by = [(i % 25 - 12) * 16384 + 5, (i / 25 - 9) * 16384 - 11];
                scene.iter().map(move |segment| moved(segment, by))
            })
            .collect();
        let chained = bench.chain(&all);
        let mut first = 0;
        for (i, scene) in scenes.iter().enumerate() {
            let expected = twin::chain(scene, &rules);
            assert_eq!(part(&chained, first, scene.len()), expected, "plane {plane}, scene {i}");
            assert_chains(scene, &expected, &rules);
            closed += expected.chains.iter().filter(|chain| chain.is_closed == 1).count();
            longest = expected.chains.iter().map(|chain| chain.count).max().unwrap_or(0).max(longest);
            first += scene.len();
            compared += 1;
        }
    }
    let least = 50 * planes.len();
    assert!(closed > least && longest > 20, "{closed} loops, at most {longest} segments: the scenes test too little");
    rules = ChainRules::default();
    bench.rules = rules;
    for number in 0..if full() { 600 } else { 40 } {
        let segments = alone(number);
        let expected = twin::chain(&segments, &rules);
        assert_eq!(bench.chain(&segments), expected, "input {number}");
        compared += 1;
    }
    assert!(compared == 10_000 || !full(), "{compared}");
}

#[test]
fn a_loop_is_one_closed_chain() {
    let rules = ChainRules::new(4.0, 1.4);
    let dice = &mut Dice::new(3);
    for count in [5, 6, 17, 255, 256, 257, 1023, 4097] {
        let segments = ring(dice, [0, 0], f64::from(count) * 40.0, count);
        let segments = shuffled(dice, segments);
        let chained = twin::chain(&segments, &rules);
        assert_chains(&segments, &chained, &rules);
        assert_eq!(chained.chains.len(), 1, "{count}");
        assert_eq!((chained.chains[0].count, chained.chains[0].is_closed), (count as u32, 1));
        let least = (0..segments.len()).min_by_key(|&p| (segments[p].key, p)).unwrap();
        assert_eq!(chained.ordered[0], 2 * least as u32, "the loop does not begin at its least segment, from a to b");
        let Some(mut bench) = Bench::new(1 << 13, rules) else { continue };
        assert_eq!(bench.chain(&segments), chained, "{count}");
    }
    // Two segments face each other, with a turn of nearly 90 degrees at each end; each end is a little before the
    // other.
    let rules = ChainRules { reach_units: 200, min_cos_squared: 0 };
    let segments = [segment([0, 0], [300, 0], 9), segment([300, 0], [0, 0], 4)];
    assert_eq!(twin::chain(&segments, &rules).chains.len(), 2, "a reversal was joined");
    let segments = [segment([0, 0], [0, 0], 9), segment([3, 0], [3, 0], 4)];
    let chained = twin::chain(&segments, &rules);
    assert_eq!((chained.chains.len(), chained.chains[0].is_closed, chained.ordered[0]), (1, 1, 2));
}

/// A chain described independently of the order of segments: key, direction and beginning of each segment; whether the
/// chain is closed; its length.
type Named = (Vec<(u32, u32, u32)>, u32, u32);

#[test]
fn the_order_of_segments_does_not_matter_where_keys_differ() {
    let rules = ChainRules::default();
    let mut bench = Bench::new(1 << 12, rules);
    for number in 0..400 {
        let dice = &mut Dice::new(77_000 + number);
        let mut segments = scene(number);
        let keys = shuffled(dice, (0..segments.len() as u32).map(|key| segment([0; 2], [0; 2], key)).collect());
        segments.iter_mut().zip(keys).for_each(|(segment, from)| segment.key = from.key * 3 + 1);
        let other = shuffled(dice, segments.clone());
        let by_key = |segments: &[Segment], chained: &Chained| -> BTreeSet<Named> {
            let of_chain = |chain: &Chain| {
                let range = chain.first as usize..(chain.first + chain.count) as usize;
                let states = chained.ordered[range.clone()].iter().zip(&chained.places[range]);
                let named = states.map(|(s, place)| (segments[*s as usize / 2].key, s & 1, place.begin_units));
                (named.collect(), chain.is_closed, chain.length_units)
            };
            chained.chains.iter().map(of_chain).collect()
        };
        let expected = by_key(&segments, &twin::chain(&segments, &rules));
        assert_eq!(by_key(&other, &twin::chain(&other, &rules)), expected, "scene {number}");
        if let (Some(bench), 0..60) = (&mut bench, number) {
            assert_eq!(by_key(&other, &bench.chain(&other)), expected, "scene {number} on the GPU");
        }
    }
}

#[test]
fn a_count_above_the_capacity_is_cut() {
    let rules = ChainRules::default();
    let Some(mut bench) = Bench::new(100, rules) else { return };
    let segments = wander(&mut Dice::new(5), 100, 30, 5);
    bench.upload(&segments, 5000);
    bench.run();
    assert_eq!(bench.read(100), twin::chain(&segments, &rules));
    assert!(bench.chain(&[]).chains.is_empty());
}

#[test]
fn a_million_segments_and_how_long_they_take() {
    let rules = ChainRules::default();
    // The largest capacity takes a minute on a software driver.
    let capacity = if full() { MAX_SEGMENTS } else { 1 << 14 };
    let Some(mut bench) = Bench::new(capacity, rules) else { return };
    println!("{}", bench.gpu.description());
    for count in [1_000, 10_000, 100_000, 1_000_000].into_iter().filter(|count| *count <= capacity as usize) {
        let segments = picture(count);
        bench.upload(&segments, count as u32);
        let mut times_ms: Vec<f64> = (0..3)
            .map(|_| {
                let start = Instant::now();
                bench.run();
                start.elapsed().as_secs_f64() * 1000.0
            })
            .collect();
        times_ms.sort_by(f64::total_cmp);
        let start = Instant::now();
        let expected = twin::chain(&segments, &rules);
        let twin_ms = start.elapsed().as_secs_f64() * 1000.0;
        let longest = expected.chains.iter().map(|chain| chain.count).max().unwrap();
        println!(
            "{count} segments: {:.1} ms (fastest of 3; slowest {:.1}), twin {twin_ms:.0} ms; {} chains, longest {longest}",
            times_ms[0],
            times_ms[2],
            expected.chains.len()
        );
        for time in bench.timer.take().unwrap_or_default().1 {
            println!("    {} {:.2} ms", time.name, time.gpu_ms);
        }
        assert!(bench.read(count) == expected, "{count} segments differ");
    }
    // One chain, and one loop, each as long as the capacity allows.
    let side = capacity as i32;
    let row = |i: i32| [(i % side) * 3 - (side * 3) / 2, 0];
    let line: Vec<Segment> = (0..side).map(|i| segment(row(i), [row(i)[0] + 3, 0], (i ^ 0x5555) as u32)).collect();
    let start = Instant::now();
    let chained = bench.chain(&line);
    println!("one chain of {side}: {:.0} ms with reading", start.elapsed().as_secs_f64() * 1000.0);
    assert!(chained == twin::chain(&line, &rules), "the longest chain differs");
    let dice = &mut Dice::new(1);
    let segments = ring(dice, [0, 0], 2_000_000.0, side);
    let chained = bench.chain(&segments);
    assert!(chained == twin::chain(&segments, &rules), "the longest loop differs");
    println!("one loop of {side}: {} chains, {} closed", chained.chains.len(), chained.chains[0].is_closed);
}
