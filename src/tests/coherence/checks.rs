//! The checks on samples and ink that were read back; each error names the place.

use glam::{Vec2, Vec3};
use hachure::lines::strokes::samples::{MAX_SAMPLES, SPACING_PX, Sample, SampleCounts};
use hachure::scene::view::View;
use hachure::style::Style;

use crate::tests::coherence::SIZE_PX;

fn check(holds: bool, place: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(place()) }
}

/// Describes the defect of sample `at`.
fn named(at: usize, samples: &[Sample], what: &str) -> String {
    format!("sample {at} {what}: {:?}", samples[at])
}

/// Checks that the position of each sample in the world projects to its position in the picture.
pub fn where_they_say(view: &View, samples: &[Sample]) -> Result<(), String> {
    samples.iter().enumerate().try_for_each(|(at, own)| {
        let there = view.place_px(Vec3::from(own.position_m).as_dvec3());
        let apart_px = there.map_or(f64::INFINITY, |there| there.distance(Vec2::from(own.px).as_dvec2()));
        check(apart_px < 0.05, || named(at, samples, &format!("is {apart_px} px from its projection")))
    })
}

/// Checks that strokes begin and end, one after the other.
pub fn in_strokes(counts: &SampleCounts, samples: &[Sample]) -> Result<(), String> {
    let mut strokes = 0;
    let mut is_inside = false;
    for (at, own) in samples.iter().enumerate() {
        let (begins, ends) = (own.flags & Sample::FIRST != 0, own.flags & Sample::LAST != 0);
        check(begins != is_inside, || {
            named(at, samples, if begins { "begins within a stroke" } else { "belongs to no stroke" })
        })?;
        strokes += u32::from(begins);
        is_inside = !ends;
    }
    check(!is_inside, || "the last stroke does not end".to_owned())?;
    check(strokes >= counts.strokes, || format!("{strokes} strokes begin, fewer than counted: {counts:?}"))
}

/// Checks that neighbouring samples of a stroke are at most [`SPACING_PX`] apart and never coincide. This holds for
/// their own positions, without the offset by which the previous line holds them, which adds a little.
pub fn evenly_apart(samples: &[Sample]) -> Result<(), String> {
    for (at, pair) in samples.windows(2).enumerate().filter(|(_, pair)| pair[0].flags & Sample::LAST == 0) {
        let drawn_px = Vec2::from(pair[0].px).distance(Vec2::from(pair[1].px));
        check(drawn_px < SPACING_PX + 6.0, || named(at, samples, &format!("is {drawn_px:.2} px from the next one")))?;
        // Fading samples keep their positions while the world moves on.
        if pair[0].flags & Sample::FADING != 0 {
            continue;
        }
        let [a, b] = [pair[0], pair[1]].map(|own| Vec2::from(own.px) - Vec2::from(own.held_px));
        let apart_px = a.distance(b);
        let is_even = (MIN_PX..MAX_PX).contains(&apart_px);
        check(is_even, || named(at, samples, &format!("is {apart_px:.2} px from the next one")))?;
    }
    Ok(())
}

/// Least distance between samples: the shortest stroke, a little longer than 4 px, has three segments.
const MIN_PX: f32 = 4.0 / 3.0 - 0.08;
/// Largest distance between samples: lengths are rounded to 1/16 px, and in ten frames of a slow flight neighbours move
/// apart by less than the rest of the margin.
const MAX_PX: f32 = SPACING_PX + 0.1;

/// Returns how far lines grow in a frame of 1/30 s, in pixels.
pub fn growth_px(style: &Style) -> f32 {
    16.0 / (30.0 * style.strokes().expect("a style of strokes").fade_s)
}

/// Checks two successive frames without an update between them: new lines grow by no more than `growth_px`, and fading
/// lines shrink by exactly that.
pub fn grows(before: &[Sample], now: &[Sample], growth_px: f32) -> Result<(), String> {
    check(before.len() == now.len(), || format!("{} samples became {}", before.len(), now.len()))?;
    before.iter().zip(now).enumerate().try_for_each(|(at, (old, new))| {
        let by_px = new.shown_px - old.shown_px;
        if new.flags & Sample::FADING == 0 {
            check(by_px <= growth_px + 1e-3, || named(at, now, &format!("grows by {by_px} px")))
        } else {
            check((by_px + growth_px).abs() <= 1e-3, || named(at, now, &format!("fades by {} px", -by_px)))
        }
    })
}

/// Checks two successive frames of a slow flight, with or without an update between them: lines start to grow, or
/// continue from where they were shown. Lines that were outside the picture at the previous update, whose view is
/// `updated`, may appear at once.
pub fn comes_from(
    before: &[Sample],
    updated: &View,
    (view, now): (&View, &[Sample]),
    growth_px: f32,
) -> Result<(), String> {
    let is_new = |own: &Sample| own.flags & Sample::FADING == 0 && was_in_picture(updated, view, own);
    now.iter().enumerate().filter(|(_, own)| is_new(own)).try_for_each(|(at, own)| {
        let goes_on = own.shown_px <= growth_px || own.shown_px <= reached_px(before, own) + growth_px + FRAME_PX;
        check(goes_on, || named(at, now, "comes at once"))
    })
}

/// Returns whether a sample of `view` was inside the picture of `updated`, apart from a border of one pixel.
pub fn was_in_picture(updated: &View, view: &View, own: &Sample) -> bool {
    let step_m = view.pose.position_m - updated.pose.position_m;
    let before_px = updated.place_px(Vec3::from(own.position_m).as_dvec3() + step_m);
    let size_px = SIZE_PX.map(f64::from);
    before_px.is_some_and(|px| (1.0..size_px[0] - 1.0).contains(&px.x) && (1.0..size_px[1] - 1.0).contains(&px.y))
}

/// Returns the [`Sample::shown_px`] that the lines of the previous frame reach at the position of a sample.
pub fn reached_px(before: &[Sample], own: &Sample) -> f32 {
    let reach_px = |old: &Sample| old.shown_px - Vec2::from(old.px).distance(Vec2::from(own.px));
    before.iter().map(reach_px).fold(f32::NEG_INFINITY, f32::max)
}

/// Largest movement of the world in the picture between two frames, in pixels.
const FRAME_PX: f32 = 2.0;

/// Checks that all numbers are finite and in their ranges.
pub fn finite(counts: &SampleCounts, samples: &[Sample]) -> Result<(), String> {
    let all = counts.samples as usize;
    let fit = counts.samples <= MAX_SAMPLES && counts.fresh <= counts.samples && all == samples.len();
    check(fit, || format!("{} samples were read, which does not match {counts:?}", samples.len()))?;
    samples.iter().enumerate().try_for_each(|(at, own)| {
        let numbers = [own.pressure, own.along_px, own.half_width_px, own.shown_px, own.depth_m];
        let mut all = own.position_m.iter().chain(&own.px).chain(&own.held_px).chain(&numbers);
        check(all.all(|number| number.is_finite()), || named(at, samples, "is not finite"))?;
        let is_in_range = own.stroke != 0 && own.half_width_px >= 0.0 && (0.0..=1.0).contains(&own.pressure);
        check(is_in_range, || named(at, samples, "is out of range"))
    })
}

/// Checks that ink is from 0 to 1 and belongs to existing segments.
pub fn inked(ink: &[f32], ids: &[u32], samples: &[Sample]) -> Result<(), String> {
    let width = SIZE_PX[0] as usize;
    ink.iter().zip(ids).enumerate().try_for_each(|(pixel, (ink, id))| {
        let at = || format!("pixel {}, {}", pixel % width, pixel / width);
        check((0.0..=1.0).contains(ink), || format!("{} has {ink} of ink", at()))?;
        let Some(number) = (*id as usize).checked_sub(1) else { return Ok(()) };
        let begins_segment = number + 1 < samples.len() && samples[number].flags & Sample::LAST == 0;
        check(begins_segment, || format!("{} refers to sample {id} - 1, where no segment begins", at()))
    })
}
