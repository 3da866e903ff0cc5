//! Temporal carry-over: new strokes continue old ones, old strokes fade, and between updates all strokes move with the
//! world.
//!
//! An update rebuilds strokes without regard to the previous ones: their ends, numbers and textures would jump. So each
//! sample looks up where it was in the previous frame and which stroke was there (`look`), and takes over that stroke's
//! identity, texture parameter and pressure, and part of its position (`temporal`). The samples of a chain vote for the
//! offset of the whole chain on its texture (`vote`); texture parameters that perspective has stretched are evened out
//! toward it. Old strokes that no new one covers remain and shrink (`fading`, `keep`).
//!
//! Active Strokes (Bénard et al. 2012) keep lines and bend them to follow the new contours; here the new lines are
//! kept, and continue the appearance of the old ones. That needs no topology of its own: a line that splits is two
//! chains that both find the old one.
//!
//! Why: `docs/decisions/stroke-carry-over.md`.

use super::chain::Chains;
use super::samples::{MAX_SAMPLES, SampleWork};
use super::{Lists, MAX_FRAME_SEGMENTS};
use crate::gpu::bind::Resource;
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Recorder;
use crate::gpu::scan::{self, Count};
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::shared::stroke_samples::Heritage;

/// The [`Heritage`] of each chain.
const HERITAGES: BufferKind = BufferKind::storage("heritages");
/// Flags of the previous frame's samples that are gone.
const GONE: BufferKind = BufferKind::storage("gone samples");
/// Index at which each kept sample is stored.
const KEPT: BufferKind = BufferKind::storage("kept places");

/// Finds for each sample the stroke that was at its place in the previous frame, whose stroke ids are `ids`.
pub(crate) fn look(recorder: &mut Recorder<'_>, view: &Resource, work: &SampleWork, ids: &Target) {
    let resources = [
        ("view", view.clone()),
        work.sample_counts(),
        work.samples(),
        work.old_samples(),
        ("ids", ids.into()),
        work.matches(),
        work.temporal(),
    ];
    let (arguments, offset) = work.per_fresh();
    recorder.indirect("lines/strokes/look", arguments, offset, &resources);
}

/// Lets the samples of this frame continue the strokes that they found.
pub(crate) fn take_over(
    recorder: &mut Recorder<'_>,
    view: &Resource,
    lists: &Lists,
    chains: &Chains,
    work: &SampleWork,
) {
    let bytes = u64::from(MAX_FRAME_SEGMENTS) * size_of::<Heritage>() as u64;
    let heritages = ("heritages", recorder.buffer(&HERITAGES, bytes).binding());
    let (arguments, offset) = chains.per_segment();
    let resources =
        [work.temporal(), lists.counts(), work.starts(), work.sample_counts(), work.matches(), heritages.clone()];
    recorder.indirect("lines/strokes/vote", arguments, offset, &resources);
    let resources = [
        ("view", view.clone()),
        work.temporal(),
        lists.counts(),
        chains.named(),
        work.starts(),
        work.matches(),
        heritages,
        work.samples(),
        work.sample_counts(),
    ];
    let (arguments, offset) = work.per_fresh();
    recorder.indirect("lines/strokes/temporal", arguments, offset, &resources);
}

/// Adds to the list of this frame the strokes of the previous frame that remain where `ids` has no stroke of this
/// frame.
pub(crate) fn keep(recorder: &mut Recorder<'_>, view: &Resource, work: &SampleWork, ids: &Target, depth: &Target) {
    let gone = ("gone", recorder.buffer(&GONE, 4 * u64::from(MAX_SAMPLES)).binding());
    let places = recorder.buffer(&KEPT, 4 * (u64::from(MAX_SAMPLES) + 1));
    let resources = [
        ("view", view.clone()),
        work.temporal(),
        work.old_sample_counts(),
        work.old_samples(),
        work.samples(),
        ("ids", ids.into()),
        ("depth", depth.into()),
        gone.clone(),
    ];
    let (arguments, offset) = work.per_old();
    recorder.indirect("lines/strokes/fading", arguments, offset, &resources);
    for stage in 0_u32..2 {
        let resources = [
            ("stage", recorder.uniform("stage", &stage)),
            ("view", view.clone()),
            work.temporal(),
            work.old_sample_counts(),
            work.old_samples(),
            gone.clone(),
            ("places", places.binding()),
            work.sample_counts(),
            work.samples(),
            work.named_draws(),
        ];
        recorder.indirect("lines/strokes/keep", arguments, offset, &resources);
        if stage == 0 {
            let numbers = &work.before.counts;
            scan::run(recorder, Count::Counted { numbers, index: 0, capacity: MAX_SAMPLES }, &places);
        }
    }
}

/// Turns the lengths of the previous frame's samples into pixels of this frame's picture, which has another size.
pub(crate) fn resize(recorder: &mut Recorder<'_>, view: &Resource, work: &SampleWork) {
    let resources = [("view", view.clone()), work.temporal(), work.old_sample_counts(), work.old_samples()];
    let (arguments, offset) = work.per_old();
    recorder.indirect("lines/strokes/resize", arguments, offset, &resources);
}

/// Moves the strokes of the previous frame into this one.
pub(crate) fn advance(recorder: &mut Recorder<'_>, view: &Resource, work: &SampleWork) {
    let resources = [
        ("view", view.clone()),
        work.temporal(),
        work.old_sample_counts(),
        work.old_samples(),
        work.sample_counts(),
        work.samples(),
        work.named_draws(),
    ];
    let (arguments, offset) = work.per_old();
    recorder.indirect("lines/strokes/advance", arguments, offset, &resources);
}
