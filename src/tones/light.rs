//! `Light` in `shaders/shared/light.wgsl`: how a style and a scene light the land.

use bytemuck::{Pod, Zeroable};

use crate::scene;
use crate::style::{Shading, Style};

/// As the shaders read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LightUniform {
    to_sun: [f32; 3],
    wrap: f32,
    ambient: f32,
    shadow: f32,
    occlusion: f32,
    slope: f32,
    exposure: f32,
    contrast: f32,
    haze_m: f32,
    faintest: f32,
}

crate::gpu::shared::describe!(LightUniform as "Light" in "tones/toon": to_sun, wrap, ambient, shadow, occlusion, slope, exposure, contrast, haze_m, faintest);

impl LightUniform {
    /// Of a style in a scene's light.
    pub fn new(style: &Style, light: &scene::Light) -> Self {
        let Shading { wrap, ambient, shadow, occlusion, slope, exposure, contrast } = style.light;
        Self {
            to_sun: light.to_sun.as_vec3().to_array(),
            wrap,
            ambient,
            shadow,
            occlusion,
            slope,
            exposure,
            contrast,
            haze_m: light.haze_m as f32,
            faintest: style.haze.faintest_tone,
        }
    }
}
