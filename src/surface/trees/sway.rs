//! How the trees in view sway in the wind, in this frame and in the one before. See `shaders/surface/trees/sway.wgsl`.

use glam::DVec3;

use super::place::{IMPOSTOR_PX, MIDDLE_PX, MOST_TREES};
use super::{DrawnTrees, TREE_LISTS};
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::shared::wind::Sway;
use crate::gpu::wgsl::surface::trees::sway::SWAY_GROUPS;
use crate::scene::view::Clock;
use crate::scene::wind::{Wind, WindUniform};

pub(super) const STEP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// From where a part of a tree is to where it was in the previous frame, in metres, where the surface id says that there
/// is one; elsewhere it means nothing.
pub const TREE_STEP: TargetKind = TargetKind::attachment("tree step", STEP_FORMAT);

/// A [`Sway`] for each tree.
const SWAYS: BufferKind = BufferKind::storage("tree sways");
/// Leaves do not flutter on trees that are smaller on the picture than where the last ones become impostors, by that.
const STILL: f64 = 1.4;

/// What the pass reads.
pub struct Inputs<'a> {
    /// The wind.
    pub wind: Wind,
    /// When the frame is drawn.
    pub clock: Clock,
    /// The rig's origin in the world, which positions count from.
    pub origin_m: DVec3,
    /// As [`place`](super::place::Inputs::detail) has it.
    pub detail: f64,
    /// Those in view.
    pub trees: &'a DrawnTrees,
    /// Out: [`TREE_STEP`], which the passes draw on that draw trees.
    pub step: Target,
}

/// Trees that sway, for the passes that draw them.
pub struct Swaying {
    wind: Resource,
    sways: Resource,
    /// [`TREE_STEP`].
    pub step: Target,
}

impl Swaying {
    /// As shaders read it.
    pub(super) fn resources(&self) -> [Named; 2] {
        [("wind", self.wind.clone()), ("tree_sways", self.sways.clone())]
    }
}

/// Finds how they sway.
pub fn run(recorder: &mut Recorder<'_>, inputs: Inputs<'_>) -> Swaying {
    let Inputs { wind, clock, origin_m, detail, trees, step } = inputs;
    let uniform = WindUniform {
        still_px: (STILL * IMPOSTOR_PX / detail) as f32,
        flutter_px: (MIDDLE_PX / detail) as f32,
        counter: trees.shared.species.len() as u32 * TREE_LISTS * super::DRAW_WORDS,
        ..wind.uniform(origin_m.truncate(), clock)
    };
    let wind = recorder.uniform("wind", &uniform);
    let sways = recorder.buffer(&SWAYS, u64::from(MOST_TREES) * size_of::<Sway>() as u64).binding();
    let resources = [
        ("wind", wind.clone()),
        ("tree_instances", trees.instances.binding()),
        ("tree_draws", trees.draws.binding()),
        ("tree_sways", sways.clone()),
    ];
    recorder.groups("surface/trees/sway", [SWAY_GROUPS, 1], &resources);
    Swaying { wind, sways, step }
}
