//! The area of an eye's picture that is not visible through the lenses of a headset: mostly its corners.
//!
//! Runtimes report this area as triangles (`XR_KHR_visibility_mask`). They are drawn first, at the near plane, so the
//! depth test rejects every surface behind them, and later passes treat them as sky. See `shaders/surface/hidden.wgsl`.
//!
//! Why: `docs/decisions/headset.md`.

use crate::gpu::buffer::BufferKind;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::Target;
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

const HIDDEN: BufferKind = BufferKind::storage("hidden area");

const DRAW: Draw = Draw {
    colors: [replaced(ID_FORMAT), None, None, None, None],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    ..Draw::triangles("surface/hidden")
};

/// The pass without surface ids.
const DEPTH: Draw = Draw { fragment: "", colors: [None, None, None, None, None], ..DRAW };

/// The area of an eye's picture that is not visible.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct HiddenArea {
    /// Triangle corners, three per triangle, in normalised device coordinates (−1 to 1, y up).
    pub corners: Vec<[f32; 2]>,
}

/// Clears depth and surface ids, if they are wanted, and draws the hidden area into them. A prewarming run draws nothing.
pub(crate) fn run(recorder: &mut Recorder<'_>, area: &HiddenArea, depth: &Target, surface_id: Option<&Target>) {
    let resources = [("corners", recorder.upload(&HIDDEN, &area.corners).binding())];
    let drawing = recorder.drawing(if surface_id.is_some() { &DRAW } else { &DEPTH }, &resources);
    let on = Attachments { colors: surface_id.as_slice(), depth: Some(depth), clears: Clears::All };
    recorder.render(DRAW.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw(0..area.corners.len() as u32, 0..1);
    });
}
