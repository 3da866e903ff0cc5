//! Tones made of marks. See `shaders/tones/hatching.wgsl`.
//!
//! Why: `docs/decisions/hatching.md`.

pub mod axes;
pub mod maps;
pub mod uniform;

use glam::DVec3;

use self::maps::Maps;
use self::uniform::HatchUniform;
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::hatching::Hatching;

/// The pass.
pub struct HatchingPass {
    /// With what swelling marks need, and without.
    passes: [Option<ComputePass>; 2],
    uniform: GrowingBuffer,
    axes: GrowingBuffer,
    phases: GrowingBuffer,
    maps: Option<Maps>,
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// The normal at the scale of marks.
    pub form: &'a Target,
    /// Its alpha is the tone that is asked for.
    pub tone: &'a Target,
    /// Out: what marks ink, and would if they were darker.
    pub cover: &'a Target,
}

impl<'a> Inputs<'a> {
    /// By the names in the shaders.
    pub(super) fn resources(self) -> [Named<'a>; 6] {
        [
            ("view", self.view),
            ("position", texture(&self.position.view)),
            ("normal", texture(&self.normal.view)),
            ("form", texture(&self.form.view)),
            ("tone", texture(&self.tone.view)),
            ("cover", texture(&self.cover.view)),
        ]
    }
}

impl HatchingPass {
    /// Its pipelines are built when marks ask for them.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            passes: [None, None],
            uniform: GrowingBuffer::new(gpu, "hatch", wgpu::BufferUsages::UNIFORM),
            axes: GrowingBuffer::new(gpu, "axes", wgpu::BufferUsages::STORAGE),
            phases: GrowingBuffer::new(gpu, "phases", wgpu::BufferUsages::STORAGE),
            maps: None,
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
        if self.maps.as_ref().is_none_or(|maps| !maps.are_of(hatching)) {
            match Maps::new(gpu, hatching) {
                Ok(maps) => self.maps = Some(maps),
                // Checked when the style was loaded: somebody has taken a picture away since.
                Err(error) => return tracing::warn!("{error}; nothing is hatched"),
            }
        }
        let Some(maps) = &self.maps else { return };
        let uniform = HatchUniform::new(hatching, (axes::FIRST_LEVEL, axes::LEVELS), maps.side_px);
        self.uniform.write(gpu, &[uniform]);
        let directions = axes::axes(&hatching.layers);
        self.phases.write(gpu, &axes::phases(&directions, camera_m, f64::from(maps.side_px)));
        self.axes.write(gpu, &axes::directions(&directions));
        let mut resources = vec![
            ("maps", maps.binding()),
            ("hatch", self.uniform.binding()),
            ("axes", self.axes.binding()),
            ("phases", self.phases.binding()),
        ];
        resources.extend(inputs.resources());
        let swells = hatching.layers.iter().filter_map(|layer| layer.recipe.as_ref()).any(uniform::swells);
        let (i, definitions): (_, &[&str]) = if swells { (0, &["SWELLING"]) } else { (1, &[]) };
        let pass = self.passes[i].get_or_insert_with(|| ComputePass::variant(gpu, "tones/hatching", definitions));
        pass.run(gpu, recorder, size_px, &resources);
    }
}
