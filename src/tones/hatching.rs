//! Tones made of marks. See `shaders/tones/hatching.wgsl`.

pub mod axes;
pub mod maps;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use self::maps::Maps;
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::hatching::{Direction, Hatching, Layer, MOST_LAYERS};

/// Ink of marks, 0 to 1.
pub const MARKS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct HatchLayerUniform {
    direction: u32,
    map: u32,
    size: f32,
    turn: f32,
    fixed_direction: [f32; 2],
    pad: [f32; 2],
}

crate::gpu::shared::describe!(HatchLayerUniform as "HatchLayer" in "tones/hatching": direction, map, size, turn, fixed_direction, pad);

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct HatchUniform {
    layers: [HatchLayerUniform; MOST_LAYERS],
    begins: [f32; MOST_LAYERS],
    spans: [f32; MOST_LAYERS],
    comes_from: [f32; MOST_LAYERS],
    comes_full: [f32; MOST_LAYERS],
    goes_from: [f32; MOST_LAYERS],
    goes_full: [f32; MOST_LAYERS],
    count: u32,
    level_count: i32,
    first_level: i32,
    softness: f32,
    side: u32,
    length_px: f32,
    width_px: f32,
    pad: f32,
}

crate::gpu::shared::describe!(HatchUniform as "Hatch" in "tones/hatching": layers, begins, spans, comes_from, comes_full, goes_from, goes_full, count, level_count, first_level, softness, side, length_px, width_px, pad);

impl HatchLayerUniform {
    fn new(layer: &Layer, map: usize) -> Self {
        let direction = match layer.direction {
            Direction::Fixed => 0,
            Direction::Slope => 1,
            Direction::Contour => 2,
            Direction::Sight => 3,
        };
        let turn = if layer.direction == Direction::Fixed { 0.0 } else { layer.angle_deg * 32.0 / 360.0 };
        let fixed_direction = axes::to_azimuth(axes::fixed_rad(layer)).as_vec2().to_array();
        Self { direction, map: map as u32, size: layer.size, turn, fixed_direction, pad: [0.0; 2] }
    }
}

/// Degrees of slope over which a layer comes, and goes, on each side of its limit.
const SLOPE_BORDER_DEG: f32 = 3.0;

impl HatchUniform {
    fn new(hatching: &Hatching, side: u32) -> Self {
        let layers = &hatching.layers;
        let mut uniform = Self {
            count: layers.len() as u32,
            level_count: axes::LEVELS as i32,
            first_level: axes::FIRST_LEVEL,
            softness: hatching.softness,
            side,
            begins: [f32::MAX; MOST_LAYERS],
            // A layer that is not there likes no slope.
            comes_from: [2.0; MOST_LAYERS],
            comes_full: [3.0; MOST_LAYERS],
            goes_from: [2.0; MOST_LAYERS],
            goes_full: [3.0; MOST_LAYERS],
            ..Self::zeroed()
        };
        let density = |darkness: f32| -(1.0 - darkness).ln();
        for (i, layer) in layers.iter().enumerate() {
            uniform.layers[i] = HatchLayerUniform::new(layer, i);
            // Lighter tones than the first layer's are its own too.
            uniform.begins[i] = if i == 0 { 0.0 } else { density(layer.from) };
            uniform.spans[i] = layers.get(i + 1).map_or(f32::MAX, |next| density(next.from) - uniform.begins[i]);
            let sine = |deg: f32| deg.to_radians().sin();
            let [low, high] = layer.slope_deg;
            if low <= 0.0 {
                [uniform.comes_from[i], uniform.comes_full[i]] = [-2.0, -1.0];
            } else {
                [uniform.comes_from[i], uniform.comes_full[i]] =
                    [sine(low - SLOPE_BORDER_DEG), sine(low + SLOPE_BORDER_DEG)];
            }
            if high < 90.0 {
                [uniform.goes_from[i], uniform.goes_full[i]] =
                    [sine(high - SLOPE_BORDER_DEG), sine(high + SLOPE_BORDER_DEG)];
            }
        }
        uniform
    }
}

/// The pass.
pub struct HatchingPass {
    pass: ComputePass,
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
    /// Out: ink.
    pub marks: &'a Target,
}

impl HatchingPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            pass: ComputePass::new(gpu, "tones/hatching"),
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
                Err(error) => return tracing::warn!("{error}; nothing is hatched"),
            }
        }
        let Some(maps) = &self.maps else { return };
        let uniform = HatchUniform::new(hatching, maps.side_px);
        self.uniform.write(gpu, &[uniform]);
        let directions = axes::axes(&hatching.layers);
        self.phases.write(gpu, &axes::phases(&directions, camera_m, f64::from(maps.side_px)));
        let directions: Vec<_> = directions.iter().map(|axis| axis.as_vec3().extend(0.0).to_array()).collect();
        self.axes.write(gpu, &directions);
        let resources = [
            ("maps", maps.binding()),
            ("view", inputs.view),
            ("hatch", self.uniform.binding()),
            ("axes", self.axes.binding()),
            ("phases", self.phases.binding()),
            ("position", texture(&inputs.position.view)),
            ("normal", texture(&inputs.normal.view)),
            ("form", texture(&inputs.form.view)),
            ("tone", texture(&inputs.tone.view)),
            ("marks", texture(&inputs.marks.view)),
        ];
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
