//! Lines appear and disappear by growing and shrinking, by a bounded step per frame.

use hachure::lines::strokes::samples::{Sample, SampleCounts};
use hachure::scene::view::View;
use hachure::style::Style;

use crate::tests::coherence::checks::{comes_from, grows, growth_px, reached_px, was_in_picture};
use crate::tests::coherence::{Flight, mountains, pose, strokes};
use crate::tests::common::full;

/// Returns a style without merging of parallel lines, so that more of them appear and disappear.
fn crowded(update_every: u32) -> Style {
    strokes(|own| {
        own.update_every = update_every;
        own.merge_px = 0.0;
    })
}

#[test]
fn new_lines_grow_and_old_ones_shrink() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, strokes(|own| own.update_every = 1));
    // The first picture is drawn whole.
    let (_, _, samples) = flight.fly(&mut world, 0);
    assert!(samples.iter().all(|sample| sample.shown_px > 0.0));
    // Lines that enter the view at its side, and lines that become hidden, take their time.
    let (mut growing, mut fading) = (0, 0);
    let (last, stride, least) = if full() { (24, 4, [20, 5]) } else { (12, 8, [10, 3]) };
    for frame in 1..=last {
        let (_, _, samples) = flight.fly(&mut world, stride * frame);
        growing += samples.iter().filter(|own| own.flags & Sample::FADING == 0 && own.shown_px <= 0.0).count();
        fading += samples.iter().filter(|own| own.flags & Sample::FADING != 0 && own.shown_px > 0.0).count();
    }
    assert!(growing > least[0] && fading > least[1], "{growing} {fading}");
    // At rest all growing and fading ends; in the fast tier four times as soon.
    if !full() {
        flight.style.strokes_mut().unwrap().fade_s = 0.2;
    }
    let rest = pose(&world, 96);
    let mut frames = 0;
    while flight.renderer.is_settling() && frames < 200 {
        flight.draw(&mut world, rest);
        frames += 1;
    }
    let (_, _, samples) = flight.draw(&mut world, rest);
    assert!(frames > 10 && frames < 200, "{frames}");
    let hidden = samples.iter().filter(|own| own.shown_px <= 0.0 || own.flags & Sample::FADING != 0).count();
    // A stroke that another one covers cannot find itself again.
    assert!(hidden <= samples.len() / 100, "{hidden} of {}", samples.len());
}

#[test]
fn lines_grow_no_faster_than_their_speed() {
    let Some(mut world) = mountains() else { return };
    // With updates in between only, and with an update in every frame.
    let frames_of = if full() { [(10, 40), (1, 40)] } else { [(10, 16), (1, 10)] };
    for (update_every, frames) in frames_of {
        let mut flight = Flight::new(&world, crowded(update_every));
        let growth_px = growth_px(&flight.style);
        let mut before: Option<(SampleCounts, Vec<Sample>)> = None;
        let (mut updated, mut before_counts): (Option<View>, Option<SampleCounts>) = (None, None);
        let (mut between, mut growing) = (0, 0);
        for frame in 0..frames {
            let (view, counts, samples) = flight.fly(&mut world, frame);
            if let (Some((old_counts, old)), Some(updated)) = (before, &updated) {
                assert_eq!(comes_from(&old, updated, (&view, &samples), growth_px), Ok(()), "frame {frame}");
                growing += samples.iter().filter(|own| own.flags & Sample::FADING == 0 && own.shown_px < 0.0).count();
                // The counts are those of the last update, so equal counts mean that there was no update.
                if update_every > 1 && old_counts == counts {
                    assert_eq!(grows(&old, &samples, growth_px), Ok(()), "frame {frame}");
                    between += 1;
                }
            }
            if before_counts != Some(counts) {
                updated = Some(view);
            }
            before_counts = Some(counts);
            before = Some((counts, samples));
        }
        let least = |of_forty: usize| of_forty * frames as usize / 40;
        assert!(growing > least(50), "{growing} samples that grow");
        assert!(between > least(20) || update_every == 1, "{between} frames between updates");
    }
}

#[test]
fn lines_that_jump_are_found() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, if full() { strokes(|_| {}) } else { crowded(10) });
    let growth_px = growth_px(&flight.style);
    // Fly until some lines grow and others fade, and then take a frame between updates. In the fast tier every second
    // step is long: after it there is an update with many new lines, and none after the short one.
    let place = |frame: u32| if full() { 4 * frame } else { frame / 2 * 24 + frame % 2 };
    let mut pair = None;
    let mut before: Option<(SampleCounts, Vec<Sample>)> = None;
    for frame in 0..60 {
        let (_, counts, samples) = flight.fly(&mut world, place(frame));
        let is_part = |own: &Sample| own.flags & Sample::FADING == 0 && own.shown_px < -3.0;
        let goes = |own: &Sample| own.flags & Sample::FADING != 0;
        if let Some((_, old)) = before.filter(|(old, _)| *old == counts)
            && let (Some(coming), Some(going)) = (old.iter().position(is_part), old.iter().position(goes))
        {
            pair = Some((old, samples, coming, going));
            break;
        }
        before = Some((counts, samples));
    }
    let (old, new, coming, going) = pair.expect("lines that come and go");
    assert_eq!(grows(&old, &new, growth_px), Ok(()));
    let error = |at: usize, jump_px: f32| {
        let mut jumped = new.clone();
        jumped[at].shown_px += jump_px;
        grows(&old, &jumped, growth_px).unwrap_err()
    };
    for error in [error(coming, 2.0), error(coming, 0.1)] {
        assert!(error.starts_with(&format!("sample {coming} ")) && error.contains("grows"), "{error}");
    }
    for error in [error(going, 0.1), error(going, -2.0)] {
        assert!(error.starts_with(&format!("sample {going} ")) && error.contains("fades"), "{error}");
    }
    // A step of twice the allowed growth is rejected.
    let twice = grows(&old, &new, 0.5 * growth_px).unwrap_err();
    assert!(twice.starts_with("sample "), "{twice}");
}

#[test]
fn lines_that_come_at_once_are_found() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, crowded(1));
    let growth_px = growth_px(&flight.style);
    let (mut updated, _, mut old) = flight.fly(&mut world, 0);
    for frame in 1..60 {
        let (view, _, new) = flight.fly(&mut world, frame);
        // A sample of a line that has not appeared yet and is apart from all lines that have.
        let is_coming = |own: &Sample| own.flags & Sample::FADING == 0 && own.shown_px < -1.0;
        let is_apart = |own: &Sample| reached_px(&old, own) < 4.0 && was_in_picture(&updated, &view, own);
        if let Some(at) = new.iter().position(|own| is_coming(own) && is_apart(own)) {
            let comes = |shown_px: f32| {
                let mut changed = new.clone();
                changed[at].shown_px = shown_px;
                comes_from(&old, &updated, (&view, &changed), growth_px)
            };
            assert_eq!((comes(new[at].shown_px), comes(0.9 * growth_px)), (Ok(()), Ok(())));
            let error = comes(8.0).unwrap_err();
            assert!(error.starts_with(&format!("sample {at} ")) && error.contains("comes at once"), "{error}");
            return;
        }
        (updated, old) = (view, new);
    }
    panic!("no line comes");
}
