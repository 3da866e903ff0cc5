//! Light in a few steps. See `shaders/tones/toon.wgsl`.

mod ramp;

use bytemuck::{Pod, Zeroable};

use self::ramp::RampTable;
use super::light::LightUniform;
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::Toon;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ToonUniform {
    steps: f32,
    darkest: f32,
    lightest: f32,
    softness: f32,
    wash: f32,
    row_first: f32,
    row_scale: f32,
    by: u32,
    camera_z_m: f32,
    low_m: f32,
    high_m: f32,
    pad: f32,
}

crate::gpu::shared::describe!(ToonUniform as "Toon" in "tones/toon": steps, darkest, lightest, softness, wash, row_first, row_scale, by, camera_z_m, low_m, high_m, pad);

/// What colours need to know of the land.
#[derive(Clone, Copy, Debug)]
pub struct Land {
    /// The camera's height in the world.
    pub camera_z_m: f32,
    /// The lowest and the highest place.
    pub range_m: [f32; 2],
}

/// The pass.
pub struct ToonPass {
    pass: ComputePass,
    sees: bool,
    light: GrowingBuffer,
    uniform: GrowingBuffer,
    ramp: RampTable,
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// `Terrain`, for the earth's curvature.
    pub terrain: Named<'a>,
    /// What the land sees, for a pass that asks.
    pub seen: Option<[Named<'a>; 5]>,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// Out: colour, and the tone that is asked for.
    pub tone: &'a Target,
}

impl ToonPass {
    /// Builds the pipeline: the one that asks what the land sees of the sun and the sky, or the cheaper one.
    pub fn new(gpu: &Gpu, sees: bool) -> Self {
        Self {
            pass: ComputePass::variant(gpu, "tones/toon", if sees { &["SEEN"] } else { &[] }),
            sees,
            light: GrowingBuffer::new(gpu, "light", wgpu::BufferUsages::UNIFORM),
            uniform: GrowingBuffer::new(gpu, "toon", wgpu::BufferUsages::UNIFORM),
            ramp: RampTable::new(gpu, None),
        }
    }

    /// Whether it asks what the land sees.
    pub fn sees(&self) -> bool {
        self.sees
    }

    /// Tones what the inputs show.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        toon: &Toon,
        light: LightUniform,
        land: Land,
        inputs: Inputs<'_>,
    ) {
        if !self.ramp.is_of(toon.ramp.as_ref()) {
            self.ramp = RampTable::new(gpu, toon.ramp.as_ref());
        }
        let [row_first, row_scale] = self.ramp.row_px;
        let [low_m, high_m] = land.range_m;
        let uniform = ToonUniform {
            steps: toon.steps as f32,
            darkest: toon.darkest,
            lightest: toon.lightest,
            softness: toon.softness.max(1e-3),
            wash: toon.wash,
            row_first,
            row_scale,
            by: self.ramp.by,
            camera_z_m: land.camera_z_m,
            low_m,
            high_m: high_m.max(low_m + 1.0),
            pad: 0.0,
        };
        self.uniform.write(gpu, &[uniform]);
        self.light.write(gpu, &[light]);
        let mut resources = vec![
            ("view", inputs.view),
            ("light", self.light.binding()),
            ("toon", self.uniform.binding()),
            ("ramp", texture(&self.ramp.view)),
            inputs.terrain,
            ("position", texture(&inputs.position.view)),
            ("normal", texture(&inputs.normal.view)),
            ("tone", texture(&inputs.tone.view)),
        ];
        if self.sees {
            resources.extend(inputs.seen.into_iter().flatten());
        }
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
