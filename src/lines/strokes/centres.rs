//! Draws the centre lines of strokes. See `shaders/lines/strokes/centres.wgsl`.

use super::samples::SampleWork;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::{Group, Target, TargetKind};

/// The number of a sample plus 1; 0 where there is no centre line.
pub(crate) const CENTRES: TargetKind = TargetKind::attachment(
    "stroke centres",
    wgpu::TextureFormat::R32Uint,
    Group::Strokes.shows("Centre lines of strokes, each sample in a colour of its own"),
);

const DRAW: Draw = Draw {
    colors: [replaced(wgpu::TextureFormat::R32Uint), None, None, None, None],
    ..Draw::triangles("lines/strokes/centres")
};

/// Draws the centre lines of this frame's strokes.
pub(crate) fn run(recorder: &mut Recorder<'_>, view: &Resource, work: &SampleWork, centres: &Target) {
    let drawing = recorder.drawing(&DRAW, &[("view", view.clone()), work.sample_counts(), work.samples()]);
    let on = Attachments { colors: &[centres], depth: None, clears: Clears::All };
    recorder.render(DRAW.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&work.now.draws.raw, 0);
    });
}
