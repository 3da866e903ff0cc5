//! Lines that have no partner in the other eye go. See `shaders/lines/stereo/agree.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// Lines that the other eye has as well, or cannot have: 0 none, 1 full.
pub const AGREED: TargetKind = TargetKind::storage("agreed line", wgpu::TextureFormat::R32Float);

/// What an eye has before both agree.
pub struct Eye {
    /// `View`.
    pub view: Resource,
    /// Of the surface.
    pub position: Target,
    /// Its lines.
    pub line: Target,
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// Whose lines are looked at.
    pub own: &'a Eye,
    /// Where their partners are.
    pub other: &'a Eye,
    /// Out: [`AGREED`].
    pub agreed: &'a Target,
}

/// Bounds an eye's lines by those of the other.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let Inputs { own, other, agreed } = inputs;
    let resources = [
        ("view", own.view.clone()),
        ("other_view", other.view.clone()),
        ("position", (&own.position).into()),
        ("other_position", (&other.position).into()),
        ("line", (&own.line).into()),
        ("other_line", (&other.line).into()),
        ("agreed", (*agreed).into()),
    ];
    recorder.pixels("lines/stereo/agree", agreed.size_px(), &resources);
}
