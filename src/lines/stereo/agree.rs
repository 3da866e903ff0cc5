//! Removes lines without a partner in the other eye. See `shaders/lines/stereo/agree.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// Line strength (0 no line, 1 full) of lines that the other eye has as well, or cannot have.
pub(crate) const AGREED: TargetKind = TargetKind::storage(
    "agreed line",
    wgpu::TextureFormat::R32Float,
    Group::Lines.shows("Detected lines that both eyes of a stereo pair have"),
);

/// The pictures of an eye that the comparison reads.
pub(crate) struct Eye {
    pub view: Resource,
    pub distance: Target,
    /// Line strength, before the comparison.
    pub line: Target,
}

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    /// The eye whose lines are checked.
    pub own: &'a Eye,
    /// The eye in which their partners are sought.
    pub other: &'a Eye,
    pub agreed: &'a Target,
}

/// Limits an eye's lines by those of the other eye.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let Inputs { own, other, agreed } = inputs;
    let resources = [
        ("view", own.view.clone()),
        ("other_view", other.view.clone()),
        ("distance_m", (&own.distance).into()),
        ("other_distance_m", (&other.distance).into()),
        ("line", (&own.line).into()),
        ("other_line", (&other.line).into()),
        ("agreed", (*agreed).into()),
    ];
    recorder.pixels("lines/stereo/agree", agreed.size_px(), &resources);
}
