//! Tests that the shader's rule equals its CPU twin, and that the texture on the GPU is the generated one.

use hachure::gpu::Gpu;
use hachure::gpu::bind::{Named, Resource};
use hachure::gpu::readback::read_buffer;
use hachure::lines::strokes::texture::{Brush, StrokeTexture, grow};
use hachure::style::texture::Recipe;

use crate::tests::common::gpu;
use crate::tests::helpers::probe;
use crate::tests::stroke_texture::{of_picture, recipe, recipes};

/// Evaluates the shader's functions at many points, and samples the texture at all levels.
const PROBE: &str = r"
#import hachure::brush::{Brush, brush_uv, brush_ink}
struct Place { texel: vec2<f32>, pressure: f32, from_middle_px: f32, half_width_px: f32, along_px: f32, id: u32, level: f32 }
@group(0) @binding(0) var<uniform> brush: Brush;
@group(0) @binding(1) var brush_tile: texture_2d<f32>;
@group(0) @binding(2) var brush_sampler: sampler;
@group(0) @binding(3) var<storage, read> places: array<Place>;
@group(0) @binding(4) var<storage, read_write> answers: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> texels: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let place = places[id.x];
    let uv = brush_uv(brush, place.along_px, place.from_middle_px, place.half_width_px, place.id);
    let ink = brush_ink(brush, place.texel, place.pressure, place.from_middle_px, place.half_width_px);
    answers[id.x] = vec4<f32>(ink, uv, 0.0);
    // Here `texel` is a position, in tiles.
    texels[id.x] = textureSampleLevel(brush_tile, brush_sampler, place.texel, place.level);
}
";

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Place {
    texel: [f32; 2],
    pressure: f32,
    from_middle_px: f32,
    half_width_px: f32,
    along_px: f32,
    id: u32,
    level: f32,
}

/// Returns results of the GPU: ink and texture coordinates, and texels.
fn answers(gpu: &Gpu, recipe: &Recipe, places: &[Place]) -> (Vec<[f32; 4]>, Vec<[f32; 4]>) {
    let texture = StrokeTexture::new(gpu, recipe);
    let inputs = probe::storage(gpu, bytemuck::cast_slice(places));
    let outputs = [(); 2].map(|()| probe::storage(gpu, &vec![0; places.len() * 16]));
    let named = texture.resources();
    fn resource((_, resource): &Named) -> wgpu::BindingResource<'_> {
        match resource {
            Resource::Buffer(buffer) => buffer.raw.as_entire_binding(),
            Resource::Texture(_, view) => wgpu::BindingResource::TextureView(view),
            Resource::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
            Resource::Target(target) => wgpu::BindingResource::TextureView(&target.view),
        }
    }
    let mut resources: Vec<wgpu::BindingResource<'_>> = named.iter().map(resource).collect();
    resources.push(inputs.as_entire_binding());
    resources.extend(outputs.iter().map(wgpu::Buffer::as_entire_binding));
    probe::run(gpu, PROBE, resources, places.len());
    let [answers, texels] = outputs.map(|buffer| read_buffer(gpu, &buffer, places.len()).unwrap());
    (answers, texels)
}

/// Returns the largest differences between the GPU and the twin: in ink, and in texture coordinates.
fn distance(brush: &Brush, places: &[Place], answers: &[[f32; 4]]) -> [f32; 2] {
    let mut most = [0.0_f32; 2];
    for (place, answer) in places.iter().zip(answers) {
        let ink = brush.ink(place.texel, place.pressure, place.from_middle_px, place.half_width_px);
        let [u, v] = brush.uv(place.along_px, place.from_middle_px, place.half_width_px, place.id);
        most[0] = most[0].max((ink - answer[0]).abs());
        most[1] = most[1].max((u - answer[1]).abs().max((v - answer[2]).abs()));
    }
    most
}

#[test]
fn the_shader_does_what_its_twin_says() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    of_picture::write_stroke(&folder.path().join("scan.png"), 128);
    let picture = ("picture", Recipe::load("scan.png", folder.path()).unwrap());
    for (name, recipe) in recipes().into_iter().chain([picture]) {
        // A low-discrepancy sequence over the whole domain of the functions.
        let part = |i: u32, step: f64| ((f64::from(i) * step) % 1.0) as f32;
        let places: Vec<Place> = (0..8192)
            .map(|i| {
                let half_width_px = 0.4 + 20.0 * part(i, 0.618_034) * part(i, 0.618_034);
                Place {
                    texel: [part(i, 0.754_878), part(i, 0.569_84)],
                    pressure: if i % 97 == 0 { 0.0 } else { part(i, 0.819_173) * 1.05 },
                    from_middle_px: (half_width_px + 0.5) * part(i, 0.671_044),
                    half_width_px,
                    along_px: 3000.0 * part(i, 0.549_7),
                    id: i.wrapping_mul(2_654_435_761),
                    level: 0.0,
                }
            })
            .collect();
        let (answers, _) = answers(&gpu, &recipe, &places);
        let brush = Brush::of(&recipe);
        let [ink, uv] = distance(&brush, &places, &answers);
        println!("{name}: ink within {ink:e}, place within {uv:e} tiles");
        assert!(ink < 1e-3 && uv < 1e-4, "{name}: {ink}, {uv}");
        assert!(places.iter().zip(&answers).all(|(place, answer)| place.pressure > 0.0 || answer[0] == 0.0));
        // Planted: other parameters.
        let spoiled = [
            Brush { response: brush.response * 1.1, ..brush },
            Brush { fill: brush.fill * 0.97, ..brush },
            Brush { border_px: brush.border_px + 0.5, border_part: 1.0, border_pressure: 0.1, ..brush },
        ];
        for other in spoiled {
            assert!(distance(&other, &places, &answers)[0] > 1e-3, "{name}: {other:?}");
        }
    }
}

#[test]
fn the_tile_on_the_gpu_is_the_one_that_was_grown() {
    let Some(gpu) = gpu() else { return };
    let recipe = recipe("charcoal");
    for (level, number) in grow(&recipe).iter().zip(0_u8..) {
        let [width, height] = level.size_px;
        let texels: Vec<(u32, u32)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
        let place = |(x, y): (u32, u32)| Place {
            // One tile further and two back: the texture repeats.
            texel: [(x as f32 + 0.5) / width as f32 + 1.0, (y as f32 + 0.5) / height as f32 - 2.0],
            pressure: 0.0,
            from_middle_px: 0.0,
            half_width_px: 1.0,
            along_px: 0.0,
            id: 0,
            level: number.into(),
        };
        let places: Vec<Place> = texels.into_iter().map(place).collect();
        let (_, seen) = answers(&gpu, &recipe, &places);
        let is_near = |texels: &[[u8; 2]]| {
            texels.iter().zip(&seen).all(|(texel, seen)| {
                (0..2).all(|channel| (f32::from(texel[channel]) / 255.0 - seen[channel]).abs() < 0.01)
            })
        };
        assert!(is_near(&level.texels), "level {number}");
        // Planted: a texel further.
        let mut moved = level.texels.clone();
        moved.rotate_left(1);
        assert!(!is_near(&moved), "level {number}");
    }
}
