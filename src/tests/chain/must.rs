//! The properties that chains must have, checked without the twin; planted errors are found.

use std::collections::BTreeSet;

use hachure::lines::strokes::twin::{self, Chained};
use hachure::lines::strokes::{ChainRules, Segment};

use crate::tests::chain::Bench;
use crate::tests::chain::scenes::{Dice, moved, segment, shuffled, wander};

/// Checks the properties that chains must have, whatever the twin says.
pub fn assert_chains(segments: &[Segment], chained: &Chained, rules: &ChainRules) {
    let mut seen = vec![false; segments.len()];
    for state in &chained.ordered {
        assert!(!std::mem::replace(&mut seen[*state as usize / 2], true), "segment {} is in two chains", state / 2);
    }
    assert_eq!(chained.ordered.len(), segments.len());
    let end = |end: u32| {
        let p = &segments[end as usize / 2];
        if end.is_multiple_of(2) { p.a } else { p.b }
    };
    let vector = |a: [i32; 2], b: [i32; 2]| [f64::from(b[0]) - f64::from(a[0]), f64::from(b[1]) - f64::from(a[1])];
    let length = |v: [f64; 2]| v[0].hypot(v[1]);
    let mut joined = BTreeSet::new();
    let mut join = |left: u32, entered: u32| {
        assert!(joined.insert(left) && joined.insert(entered), "an end is joined twice");
        let delta = vector(end(left), end(entered));
        assert!(length(delta) <= f64::from(rules.reach_units), "{left} to {entered} is too far");
        let (u, v) = (vector(end(left ^ 1), end(left)), vector(end(entered), end(entered ^ 1)));
        if length(u) > 0.0 && length(v) > 0.0 {
            let widest = (f64::from(rules.min_cos_squared) / 4096.0).sqrt().acos();
            let angle = ((u[0] * v[0] + u[1] * v[1]) / length(u) / length(v)).clamp(-1.0, 1.0).acos();
            // Directions are rounded to 1/64 at worst, at each of the two ends.
            assert!(angle <= widest + 0.04, "{left} to {entered} turns by {angle}");
        }
        length(delta)
    };
    let mut place = 0;
    let mut previous_head = None;
    for (number, chain) in chained.chains.iter().enumerate() {
        assert_eq!(chain.first as usize, place);
        assert!(chain.count > 0);
        let states = &chained.ordered[place..place + chain.count as usize];
        let head = states[0] / 2;
        assert!(previous_head < Some(head), "chains are not in the order of their first segments");
        previous_head = Some(head);
        assert_eq!(chain.key, segments[head as usize].key);
        let mut sum = 0.0;
        for (i, state) in states.iter().enumerate() {
            if i > 0 {
                sum += join(states[i - 1] ^ 1, *state);
            }
            let begin = chained.places[place + i];
            assert_eq!(begin.chain as usize, number);
            // For each segment, two lengths are rounded down, by a unit or by 2^-14.
            assert!((sum - f64::from(begin.begin_units)).abs() <= 2.0 * i as f64 + sum / 16000.0, "{sum} {begin:?}");
            sum += length(vector(end(*state), end(state ^ 1)));
        }
        if chain.is_closed == 1 {
            sum += join(states[states.len() - 1] ^ 1, states[0]);
        }
        assert!((sum - f64::from(chain.length_units)).abs() <= 2.0 * states.len() as f64 + sum / 16000.0);
        place += chain.count as usize;
    }
    assert_eq!(place, segments.len());
}

/// Planted errors are found: a wrong link, order, distance and angle.
#[test]
fn planted_errors_are_found() {
    let rules = ChainRules::default();
    let Some(mut bench) = Bench::new(1 << 12, rules) else { return };
    let segments = shuffled(&mut Dice::new(8), wander(&mut Dice::new(9), 300, 30, 5));
    let chained = bench.chain(&segments);
    assert_eq!(chained, twin::chain(&segments, &rules));
    assert!(chained.chains.iter().any(|chain| chain.count > 3));

    // Link: a segment moved out of the reach of its neighbours.
    let mut changed = segments.clone();
    let middle = chained.ordered[chained.chains.iter().find(|chain| chain.count > 3).unwrap().first as usize + 1];
    changed[middle as usize / 2] = moved(&changed[middle as usize / 2], [0, 5000]);
    assert_ne!(bench.chain(&changed), twin::chain(&segments, &rules));
    // Order: two segments exchanged in memory.
    let mut swapped = segments.clone();
    swapped.swap(0, 1);
    assert_ne!(bench.chain(&swapped), twin::chain(&segments, &rules));
    // Distance: a reach that is a unit shorter, where a gap is exactly as long as the reach.
    let gap = [segment([0, 0], [100, 0], 1), segment([164, 0], [300, 0], 2)];
    assert_eq!(bench.chain(&gap), twin::chain(&gap, &rules));
    assert_eq!(bench.chain(&gap).chains.len(), 1);
    bench.rules = ChainRules { reach_units: 63, ..rules };
    assert_ne!(bench.chain(&gap), twin::chain(&gap, &rules));
    // Angle: another largest angle, on the wandering line.
    bench.rules = ChainRules::new(4.0, 0.3);
    assert_ne!(bench.chain(&segments), twin::chain(&segments, &rules));
    // The properties reject a reversed segment and a torn chain.
    let spoiled = |spoil: fn(&mut Chained)| {
        let mut wrong = chained.clone();
        spoil(&mut wrong);
        std::panic::catch_unwind(|| assert_chains(&segments, &wrong, &rules)).is_err()
    };
    assert!(!spoiled(|_| ()));
    assert!(spoiled(|wrong| wrong.ordered[1] ^= 1));
    assert!(spoiled(|wrong| wrong.ordered.swap(0, 2)));
    assert!(spoiled(|wrong| wrong.places[1].begin_units += 100));
    assert!(spoiled(|wrong| wrong.chains[0].count -= 1));
    assert!(spoiled(|wrong| wrong.ordered[0] = wrong.ordered[1]));
}
