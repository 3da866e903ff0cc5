//! The sway of the trees in view, in this frame and in the previous one. See `shaders/surface/trees/sway.wgsl`.

use glam::DVec3;

use super::DrawnTrees;
use super::place::{IMPOSTOR_PX, MAX_INSTANCES, MIDDLE_PX};
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::shared::wind::Sway;
use crate::gpu::wgsl::surface::trees::sway::SWAY_GROUPS;
use crate::scene::view::Clock;
use crate::scene::wind::{Wind, WindUniform};

pub(super) const STEP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Vector from a part of a tree to its position in the previous frame, in metres, at pixels whose surface id is a tree;
/// undefined elsewhere.
pub(crate) const TREE_STEP: TargetKind = TargetKind::attachment(
    "tree step",
    STEP_FORMAT,
    Group::Trees.shows("Motion of each part of a tree in the wind since the frame before, in metres"),
);

/// A [`Sway`] for each tree.
const SWAYS: BufferKind = BufferKind::storage("tree sways");
/// Leaves do not flutter on trees that are smaller than this multiple of the size at which trees become impostors.
const STILL: f64 = 1.4;

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub wind: Wind,
    /// The time at which the frame is drawn.
    pub clock: Clock,
    /// The rig's origin in the world, to which positions are relative.
    pub origin_m: DVec3,
    /// Factor of the level of detail, as in [`place::Inputs::detail`](super::place::Inputs::detail).
    pub detail: f64,
    /// The trees in view.
    pub trees: &'a DrawnTrees,
    /// Number of places for their instances.
    pub instances: u32,
    /// [`TREE_STEP`], an attachment of the passes that draw trees.
    pub step: Target,
}

/// The sway of trees, for the passes that draw them.
pub(crate) struct Swaying {
    wind: Resource,
    sways: Resource,
    pub step: Target,
}

impl Swaying {
    /// Returns the bindings of the wind and of each tree's sway.
    pub(super) fn resources(&self) -> [Named; 2] {
        [("wind", self.wind.clone()), ("tree_sways", self.sways.clone())]
    }
}

/// Computes how the trees sway.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: Inputs<'_>) -> Swaying {
    let Inputs { wind, clock, origin_m, detail, trees, instances, step } = inputs;
    let uniform = WindUniform {
        still_px: (STILL * IMPOSTOR_PX / detail) as f32,
        flutter_px: (MIDDLE_PX / detail) as f32,
        instances,
        ..wind.uniform(origin_m.truncate(), clock)
    };
    let wind = recorder.uniform("wind", &uniform);
    let sways = recorder.buffer(&SWAYS, u64::from(MAX_INSTANCES) * size_of::<Sway>() as u64).binding();
    let resources = [
        ("wind", wind.clone()),
        ("tree_instances", trees.instances.binding()),
        ("tree_keys", trees.keys.binding()),
        ("tree_sways", sways.clone()),
    ];
    recorder.groups("surface/trees/sway", [SWAY_GROUPS, 1], &resources);
    Swaying { wind, sways, step }
}
