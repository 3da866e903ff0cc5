//! Hatching by the zoom rule: coming nearer only ever adds marks. See `shaders/tones/fractal_hatching.wgsl`.
//!
//! This is the fractal scale rule. Why: `docs/decisions/zoom-rule.md`.

use glam::DVec3;

use super::hatching::uniform::HatchUniform;
use super::hatching::{Inputs, axes};
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::ComputePass;
use crate::gpu::timer::Recorder;
use crate::style::hatching::Hatching;
use crate::style::marks::Kind;

/// The pass.
pub struct FractalHatchingPass {
    // Of marks that end, and of lines alone: built when a style asks for them.
    passes: [Option<ComputePass>; 2],
    uniform: GrowingBuffer,
    axes: GrowingBuffer,
    cells: GrowingBuffer,
}

impl FractalHatchingPass {
    /// Its pipelines are built when marks ask for them.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            passes: [None, None],
            uniform: GrowingBuffer::new(gpu, "hatch", wgpu::BufferUsages::UNIFORM),
            axes: GrowingBuffer::new(gpu, "axes", wgpu::BufferUsages::STORAGE),
            cells: GrowingBuffer::new(gpu, "cells", wgpu::BufferUsages::STORAGE),
        }
    }

    /// Hatches what a camera at `camera_m` sees.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        hatching: &Hatching,
        camera_m: DVec3,
        inputs: Inputs<'_>,
    ) {
        self.uniform.write(gpu, &[HatchUniform::new(hatching, (axes::FIRST_OCTAVE, axes::OCTAVES), 1)]);
        let directions = axes::axes(&hatching.layers);
        self.cells.write(gpu, &axes::cells(&directions, camera_m));
        self.axes.write(gpu, &axes::directions(&directions));
        let mut resources =
            vec![("hatch", self.uniform.binding()), ("axes", self.axes.binding()), ("cells", self.cells.binding())];
        resources.extend(inputs.resources());
        let is_ended =
            hatching.layers.iter().any(|layer| layer.recipe.as_ref().is_none_or(|recipe| recipe.kind != Kind::Line));
        let (i, definitions): (_, &[&str]) = if is_ended { (0, &["ENDED"]) } else { (1, &[]) };
        let pass =
            self.passes[i].get_or_insert_with(|| ComputePass::variant(gpu, "tones/fractal_hatching", definitions));
        pass.run(gpu, recorder, size_px, &resources);
    }
}
