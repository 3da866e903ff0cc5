//! The hatching marks of an eye, and, for files of lines, each set of marks separately.

use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, TargetKind, Targets};
use crate::style::hatching::{MAX_SETS, Zoom};
use crate::tones::{balance, fractal_hatching, hatching};

/// The cover of one set of marks, as `cover` of all sets in [`balance`].
const SET_COVER: TargetKind = TargetKind::storage(
    "cover of a set",
    wgpu::TextureFormat::Rgba16Float,
    Group::Ink.shows("Ink of one set of hatching marks before its balance"),
);
/// The ink of each set of marks, 0 to 1.
pub(super) const SET_INKS: [TargetKind; MAX_SETS] = [
    TargetKind::storage(
        "marks of set 1",
        wgpu::TextureFormat::R32Float,
        Group::Ink.shows("Ink of set 1 of hatching marks"),
    ),
    TargetKind::storage(
        "marks of set 2",
        wgpu::TextureFormat::R32Float,
        Group::Ink.shows("Ink of set 2 of hatching marks"),
    ),
    TargetKind::storage(
        "marks of set 3",
        wgpu::TextureFormat::R32Float,
        Group::Ink.shows("Ink of set 3 of hatching marks"),
    ),
    TargetKind::storage(
        "marks of set 4",
        wgpu::TextureFormat::R32Float,
        Group::Ink.shows("Ink of set 4 of hatching marks"),
    ),
];

/// Draws the marks with the pass for the style's [`Scale`].
pub(super) fn hatch(recorder: &mut Recorder<'_>, marks: &hatching::Inputs<'_>) {
    match marks.hatching.zoom {
        Zoom::Blend => hatching::run(recorder, marks),
        Zoom::Add => fractal_hatching::run(recorder, marks),
    }
}

/// Draws each set of marks separately, with the ink that it has among all sets: the ink balance is that of all of them.
pub(super) fn draw(
    recorder: &mut Recorder<'_>,
    marks: &hatching::Inputs<'_>,
    balance: &balance::Inputs,
    targets: &mut Targets,
) {
    let cover = &targets.whole(recorder.gpu(), &SET_COVER);
    for (set, kind) in SET_INKS.iter().enumerate().take(marks.hatching.sets.len()) {
        hatch(recorder, &hatching::Inputs { set: Some(set), cover, ..*marks });
        let ink = targets.whole(recorder.gpu(), kind);
        balance::draw(recorder, &balance::Inputs { cover: cover.clone(), marks: ink, ..balance.clone() }, None);
    }
}
