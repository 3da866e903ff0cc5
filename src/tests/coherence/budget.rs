//! Strokes stay within the budget, and strokes that are left out are reported.

use std::collections::HashMap;

use hachure::lines::strokes::{AsyncStrokeNumbers, LeftOut};

use crate::tests::coherence::{Flight, mountains, strokes};
use crate::tests::common::full;

#[test]
fn the_budget_leaves_out_the_shortest() {
    let Some(mut world) = mountains() else { return };
    let mut lengths = |budget_px: f32| {
        let mut flight = Flight::new(&world, strokes(|own| own.budget_px = budget_px));
        let (_, counts, samples) = flight.fly(&mut world, 0);
        let mut lengths: HashMap<u32, usize> = HashMap::new();
        samples.iter().for_each(|sample| *lengths.entry(sample.stroke).or_default() += 1);
        (counts, lengths)
    };
    let (all, every) = lengths(400_000.0);
    assert_eq!(all.left_out, 0);
    let (few, kept) = lengths(500.0);
    assert!(few.samples <= 250 && few.samples > 125 && few.left_out > 0, "{few:?}");
    assert_eq!(few.strokes + few.left_out, all.strokes);
    // The strokes that are kept are the longest, within a quarter of an octave.
    let shortest = kept.values().min().unwrap();
    let longest_lost = every.iter().filter(|(stroke, _)| !kept.contains_key(stroke)).map(|(_, size)| size).max();
    assert!(*longest_lost.unwrap() as f64 <= *shortest as f64 * 1.3, "{longest_lost:?} {shortest}");
    // A budget smaller than a single stroke cuts that stroke off.
    let (one, _) = lengths(100.0);
    assert!(one.samples <= 50 && one.samples > 1, "{one:?}");
}

#[test]
fn what_is_left_out_is_reported_without_waiting() {
    let Some(mut world) = mountains() else { return };
    let mut reported = |budget_px: f32| {
        let mut flight = Flight::new(&world, strokes(|own| own.budget_px = budget_px));
        let mut numbers = AsyncStrokeNumbers::default();
        assert_eq!(numbers.last(), None);
        // Readbacks of several updates, and of frames between them, where nothing is recounted.
        for frame in 0..if full() { 12 } else { 6 } {
            let (_, counts, _) = flight.fly(&mut world, frame);
            let passes = flight.renderer.strokes();
            numbers.request(&world.gpu, passes);
            let left_out = passes.unwrap().left_out(&world.gpu).unwrap();
            assert_eq!(left_out.strokes, counts.left_out);
            // The GPU has finished, so the numbers have arrived.
            let last = numbers.last().unwrap();
            assert_eq!((last.left_out, last.drawn), (left_out, counts.strokes), "frame {frame}");
        }
        let last = numbers.last().unwrap().left_out;
        // Without polling, excess readbacks are not started, and the others finish.
        (0..20).for_each(|_| numbers.request(&world.gpu, flight.renderer.strokes()));
        world.gpu.wait();
        assert_eq!(numbers.last().unwrap().left_out, last);
        // After a change to a style without strokes, earlier readbacks are discarded.
        numbers.request(&world.gpu, flight.renderer.strokes());
        numbers.request(&world.gpu, None);
        world.gpu.wait();
        assert_eq!(numbers.last(), None);
        last
    };
    let little = reported(100.0);
    assert!(little.strokes > 0 && little.message().unwrap().contains(&format!("{} strokes", little.strokes)));
    let usual = reported(strokes(|_| {}).strokes().unwrap().budget_px);
    assert_eq!((usual, usual.message()), (LeftOut::default(), None));
}
