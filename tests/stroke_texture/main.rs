//! Stroke textures: tiles without a seam, the same on every machine, that take as much ink as pressure asks for on all
//! levels; and the shader's rule is that of its twin.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

mod common;

use std::path::Path;

use common::World;
use common::hill::Hill;
use glam::DVec3;
use hachure::frame::{Frame, Light, Requirements};
use hachure::gpu::Gpu;
use hachure::gpu::readback::{read_as, read_buffer};
use hachure::gpu::shader::{SHADERS, compose, compose_text};
use hachure::lines::strokes::texture::{Brush, Level, StrokeTexture, grow};
use hachure::style::texture::{Recipe, names};
use hachure::style::{Style, StyleError, preset_text};
use hachure::surface::view::{Part, View};

const PRESSURES: [f32; 6] = [0.1, 0.2, 0.4, 0.6, 0.8, 1.0];

/// One that stays as it is, so that its bits can be told.
const RECIPE: &str = r#"
description = "for tests"
[tile]
along_px = 128
across_px = 32
seed = 7
[touch]
nominal_width_px = 8.0
spread = 0.5
softness = 0.1
response = 1.0
fill = 1.0
border_px = 2.0
border_part = 0.5
border_pressure = 0.2
[pigment]
density = 0.8
variation = 0.2
along_px = 20.5
across_px = 2.0
[[marks]]
along_px = 12.3
across_px = 1.0
weight = 1.0
wander_px = 2.0
[[marks]]
along_px = 2.0
across_px = 2.5
weight = 0.5
"#;

fn recipe(name: &str) -> Recipe {
    Recipe::load(name, Path::new("")).unwrap()
}

fn recipes() -> Vec<(&'static str, Recipe)> {
    names().into_iter().map(|name| (name, recipe(name))).collect()
}

/// Root of the mean square difference between neighbours, for each step from a column to the next and back to the
/// first; both channels.
fn steps(level: &Level, columns: usize) -> Vec<[f64; 2]> {
    let width = level.size_px[0] as usize;
    let step = |x: usize| {
        let next = (x + 1) % columns;
        [0, 1].map(|channel| {
            let squares = level.texels.chunks_exact(width).map(|row| {
                let difference = f64::from(row[next][channel]) - f64::from(row[x][channel]);
                difference * difference
            });
            (squares.sum::<f64>() / f64::from(level.size_px[1])).sqrt()
        })
    };
    (0..columns).map(step).collect()
}

/// The last step against the largest of the others.
fn has_seam(level: &Level, columns: usize) -> bool {
    let steps = steps(level, columns);
    let (seam, inside) = steps.split_last().unwrap();
    [0, 1].into_iter().any(|channel| seam[channel] > inside.iter().map(|step| step[channel]).fold(0.0, f64::max))
}

/// Rows become columns.
fn turned(level: &Level) -> Level {
    let [width, height] = level.size_px.map(|side| side as usize);
    let texels = (0..width).flat_map(|x| (0..height).map(move |y| (x, y)));
    Level {
        size_px: [level.size_px[1], level.size_px[0]],
        texels: texels.map(|(x, y)| level.texels[y * width + x]).collect(),
    }
}

#[test]
fn tiles_have_no_seam() {
    for (name, recipe) in recipes() {
        for level in &grow(&recipe)[..3] {
            let columns = level.size_px[0] as usize;
            assert!(!has_seam(level, columns), "{name}, along");
            assert!(!has_seam(&turned(level), level.size_px[1] as usize), "{name}, across");
        }
        // Planted: a tile that is cut off has one.
        let level = &grow(&recipe)[0];
        assert!(has_seam(level, level.size_px[0] as usize * 3 / 4 + 5), "{name}: a cut is not noticed");
    }
}

#[test]
fn tiles_are_the_same_everywhere() {
    let recipe = Recipe::parse("test", RECIPE).unwrap();
    let bits = |recipe: &Recipe| {
        let levels = grow(recipe);
        let bytes: Vec<u8> = levels.iter().flat_map(|level| level.texels.iter().flatten().copied()).collect();
        (levels.len(), crc32fast::hash(&bytes))
    };
    let here = bits(&recipe);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| bits(&recipe)), here);
    }
    assert_eq!(here, (6, HERE));
    // Planted: another seed, another tile.
    let mut other = recipe.clone();
    other.tile.seed += 1;
    assert_ne!(bits(&other), here);
}

/// Of [`RECIPE`], whatever the machine.
const HERE: u32 = 3_348_655_921;

/// What a rule with uniform thresholds takes, by integration.
fn promised(brush: &Brush, pressure: f32) -> f64 {
    let ink = |i: u16| f64::from(brush.ink([1.0, (f32::from(i) + 0.5) / 4096.0], pressure, 0.0, 1e3));
    (0..4096).map(ink).sum::<f64>() / 4096.0
}

#[test]
fn ink_grows_with_pressure_as_promised() {
    for (name, recipe) in recipes() {
        let (level, brush) = (&grow(&recipe)[0], Brush::of(&recipe));
        let density = f64::from(recipe.pigment.density);
        assert_eq!(level.mean_ink(&brush, 0.0), 0.0, "{name}");
        let means: Vec<f64> = (0..=20).map(|i| level.mean_ink(&brush, i as f32 / 20.0)).collect();
        assert!(means.is_sorted(), "{name}: {means:?}");
        for pressure in PRESSURES {
            let (mean, asked) = (level.mean_ink(&brush, pressure), density * promised(&brush, pressure));
            assert!((mean - asked).abs() < 0.01, "{name} at {pressure}: {mean}, not {asked}");
        }
        let full = level.mean_ink(&brush, 1.0);
        let bounds = match name {
            "pen" | "brush" => 0.95..=1.0,
            "dry-ink" => 0.6..=0.8,
            "charcoal" => 0.85..=0.95,
            _ => 0.85..=0.92,
        };
        println!("{name}: {:.3} at 0.2, {:.3} at 0.5, {full:.3} at 1", means[4], means[10]);
        assert!(bounds.contains(&full), "{name}: {full}");
        // Planted: thresholds as the marks have them, which crowd around their middle.
        let crowded = level.texels.iter().map(|[pigment, threshold]| [*pigment, 64 + threshold / 2]);
        let crowded = Level { size_px: level.size_px, texels: crowded.collect() };
        let is_far =
            |pressure: &f32| (crowded.mean_ink(&brush, *pressure) - density * promised(&brush, *pressure)).abs() > 0.01;
        assert!(PRESSURES.iter().any(is_far), "{name}");
    }
}

/// Averages of 2 × 2 and nothing else.
fn averaged(level: &Level) -> Level {
    let size_px = level.size_px.map(|side| side / 2);
    let width = level.size_px[0] as usize;
    let texel = |x: usize, y: usize| {
        let first = 2 * y * width + 2 * x;
        let places = [first, first + 1, first + width, first + width + 1];
        [0, 1].map(|channel| {
            (places.iter().map(|place| u32::from(level.texels[*place][channel])).sum::<u32>() as f32 / 4.0) as u8
        })
    };
    let places = (0..size_px[1] as usize).flat_map(|y| (0..size_px[0] as usize).map(move |x| (x, y)));
    Level { size_px, texels: places.map(|(x, y)| texel(x, y)).collect() }
}

/// How far a level's mean ink is from the finest level's at most, as a part of it.
fn loss(levels: &[Level], brush: &Brush) -> f64 {
    let mean = |level: &Level, pressure: f32| level.mean_ink(brush, pressure) / levels[0].mean_ink(brush, pressure);
    let losses = levels.iter().flat_map(|level| PRESSURES.iter().map(|pressure| (mean(level, *pressure) - 1.0).abs()));
    losses.fold(0.0, f64::max)
}

#[test]
fn levels_keep_the_ink() {
    for (name, recipe) in recipes() {
        let begin = std::time::Instant::now();
        let (levels, brush) = (grow(&recipe), Brush::of(&recipe));
        println!("{name}: grown in {:.1} ms", begin.elapsed().as_secs_f64() * 1e3);
        assert_eq!(levels.len(), 6, "{name}");
        let kept = loss(&levels, &brush);
        println!("{name}: levels differ by {kept:.4} at most");
        assert!(kept < 0.02, "{name}: {kept}");
        // Planted: averaging alone, as textures of colours have it. A pen's middle takes ink whatever the threshold.
        let mut plain = vec![levels[0].clone()];
        for i in 0..5 {
            plain.push(averaged(&plain[i]));
        }
        let lost = loss(&plain, &brush);
        println!("{name}: by {lost:.4} if only averaged");
        assert!(name == "pen" || lost > 0.02, "{name}: {lost}");
    }
}

/// Ink of a stroke for each pixel of its width.
fn ink_of_stroke(level: &Level, brush: &Brush, width_px: f32, pressure: f32) -> f64 {
    let [width, height] = level.size_px.map(|side| side as i64);
    let half_width_px = 0.5 * width_px;
    let rows = half_width_px.ceil() as i64 + 1;
    let mut ink = 0.0;
    for (x, row) in (0..width).flat_map(|x| (-rows..rows).map(move |row| (x, row))) {
        let across_px = row as f32 + 0.5;
        let [u, v] = brush.uv(x as f32 + 0.5, across_px, half_width_px, 1);
        let place = [u * width as f32, v * height as f32].map(|at| at.floor() as i64);
        let texel = level.texels[(place[1].rem_euclid(height) * width + place[0].rem_euclid(width)) as usize];
        let covered = (half_width_px - across_px.abs() + 0.5).clamp(0.0, 1.0);
        let texel = texel.map(|byte| f32::from(byte) / 255.0);
        ink += f64::from(covered * brush.ink(texel, pressure, across_px.abs(), half_width_px));
    }
    ink / (width as f64 * f64::from(width_px))
}

#[test]
fn thin_strokes_are_not_washed_out() {
    for (name, recipe) in recipes() {
        let (level, brush) = (&grow(&recipe)[0], Brush::of(&recipe));
        for pressure in [0.4, 0.7, 1.0] {
            let inks = [2.0, 4.0, 8.0, 16.0, 32.0].map(|width_px| ink_of_stroke(level, &brush, width_px, pressure));
            println!("{name} at {pressure}: {inks:.3?} for 2 to 32 px");
            assert!(inks[0] >= 0.6 * inks[4], "{name} at {pressure}: {inks:?}");
        }
        // Planted: a border that is as wide in thin strokes as in wide ones.
        let wide = Brush { border_px: 8.0, border_part: 8.0, border_pressure: 0.0, ..brush };
        let [thin, thick] = [2.0, 32.0].map(|width_px| ink_of_stroke(level, &wide, width_px, 0.4));
        assert!(name == "pen" || thin < 0.6 * thick, "{name}: {thin}, {thick}");
    }
}

#[test]
fn mistakes_are_told_in_one_line() {
    let spoil = |from: &str, to: &str| {
        assert!(RECIPE.contains(from), "{from}");
        RECIPE.replacen(from, to, 1)
    };
    let spoiled = [
        (spoil("fill = 1.0", "fil = 1.0"), "line 12: unknown field `fil`"),
        (spoil("seed = 7\n", ""), "missing field `seed`"),
        (spoil("fill = 1.0", "fill = 1.5"), "touch.fill is 1.5, not between 0.05 and 1"),
        (spoil("softness = 0.1", "softness = 0.0"), "touch.softness is 0,"),
        (spoil("response = 1.0", "response = nan"), "touch.response is NaN"),
        (spoil("along_px = 128", "along_px = 100"), "tile.along_px is 100, not a power of two from 64 to 2048"),
        (spoil("along_px = 128", "along_px = -1"), "line 4: "),
        (spoil("weight = 0.5", "weight = -0.5"), "marks.weight is -0.5"),
        (spoil("along_px = 12.3", "along_px = 1e9"), "marks.along_px is 1000000000"),
        (RECIPE.split("[[marks]]").next().unwrap().to_owned() + "marks = []", "line"),
        ("[".to_owned(), "line 1: "),
    ];
    for (text, cause) in spoiled {
        let error = Recipe::parse("mine.toml", &text).unwrap_err().to_string();
        assert!(error.starts_with("mine.toml: ") && error.contains(cause), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    assert!(Recipe::parse("mine.toml", RECIPE).is_ok());
}

#[test]
fn a_style_names_a_texture_or_a_file_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let style = |texture: &str| {
        let text = preset_text("charcoal").unwrap().replace("\"charcoal\"\nwidth", &format!("\"{texture}\"\nwidth"));
        assert!(text.contains(texture));
        let path = folder.path().join("style.toml");
        hachure::file::atomic::write(&path, text.as_bytes()).unwrap();
        Style::load(path.to_str().unwrap()).map(|style| style.strokes.unwrap().texture.unwrap())
    };
    assert_eq!(style("pencil").unwrap(), recipe("pencil"));
    hachure::file::atomic::write(&folder.path().join("mine.toml"), RECIPE.as_bytes()).unwrap();
    assert_eq!(style("mine.toml").unwrap(), Recipe::parse("test", RECIPE).unwrap());
    // What is wrong is told with the texture's own name.
    let error = style("crayon").unwrap_err();
    assert!(matches!(error, StyleError::UnknownTexture { .. }));
    assert!(error.to_string().starts_with("crayon: no such stroke texture; there is pen, brush, pencil"), "{error}");
    assert!(style("nowhere.toml").unwrap_err().to_string().ends_with("nowhere.toml: cannot read the stroke texture"));
    hachure::file::atomic::write(&folder.path().join("broken.toml"), b"tile = 3").unwrap();
    let error = style("broken.toml").unwrap_err().to_string();
    assert!(error.contains("broken.toml: line 1: ") && error.lines().count() == 1, "{error}");
    assert!(Style::load("strokes").unwrap().strokes.unwrap().texture.is_none());
}

/// The shader's functions at many places, and the tile's texels at all levels.
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
    // The texel is the place's, in tiles, here.
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

/// What the GPU says: ink and place on the tile, and texels.
fn probe(gpu: &Gpu, recipe: &Recipe, places: &[Place]) -> (Vec<[f32; 4]>, Vec<[f32; 4]>) {
    use wgpu::util::{BufferInitDescriptor, DeviceExt};
    let module = compose_text("probe", PROBE).unwrap_or_else(|error| panic!("{error}"));
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let buffer = |contents: &[u8]| {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        gpu.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
    };
    let texture = StrokeTexture::new(gpu, recipe);
    let inputs = buffer(bytemuck::cast_slice(places));
    let outputs = [(); 2].map(|()| buffer(&vec![0; places.len() * 16]));
    let mut resources: Vec<wgpu::BindingResource<'_>> =
        texture.resources().into_iter().map(|(_, resource)| resource).collect();
    resources.push(inputs.as_entire_binding());
    resources.extend(outputs.iter().map(wgpu::Buffer::as_entire_binding));
    let entries = (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries.collect::<Vec<_>>(),
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(places.len() as u32 / 64, 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    let [answers, texels] = outputs.map(|buffer| read_buffer(gpu, &buffer, places.len()).unwrap());
    (answers, texels)
}

/// How far the GPU's answers are from the twin's: ink, and place on the tile.
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
    let Some(gpu) = common::gpu() else { return };
    for (name, recipe) in recipes() {
        // A low-discrepancy walk through all that the functions can be asked.
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
        let (answers, _) = probe(&gpu, &recipe, &places);
        let brush = Brush::of(&recipe);
        let [ink, uv] = distance(&brush, &places, &answers);
        println!("{name}: ink within {ink:e}, place within {uv:e} tiles");
        assert!(ink < 1e-3 && uv < 1e-4, "{name}: {ink}, {uv}");
        assert!(places.iter().zip(&answers).all(|(place, answer)| place.pressure > 0.0 || answer[0] == 0.0));
        // Planted: other numbers.
        let spoiled = [
            Brush { response: brush.response * 1.1, ..brush },
            Brush { fill: brush.fill * 0.97, ..brush },
            Brush { border_px: brush.border_px + 0.5, border_part: 1.0, ..brush },
        ];
        for other in spoiled {
            assert!(distance(&other, &places, &answers)[0] > 1e-3, "{name}: {other:?}");
        }
    }
}

#[test]
fn the_tile_on_the_gpu_is_the_one_that_was_grown() {
    let Some(gpu) = common::gpu() else { return };
    let recipe = recipe("charcoal");
    for (level, number) in grow(&recipe).iter().zip(0_u8..) {
        let [width, height] = level.size_px;
        let texels: Vec<(u32, u32)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
        let place = |(x, y): (u32, u32)| Place {
            // One tile on and two back: it repeats.
            texel: [(x as f32 + 0.5) / width as f32 + 1.0, (y as f32 + 0.5) / height as f32 - 2.0],
            pressure: 0.0,
            from_middle_px: 0.0,
            half_width_px: 1.0,
            along_px: 0.0,
            id: 0,
            level: number.into(),
        };
        let places: Vec<Place> = texels.into_iter().map(place).collect();
        let (_, seen) = probe(&gpu, &recipe, &places);
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

const SIZE_PX: [u32; 2] = [480, 270];

/// The ink of strokes, as 16-bit floats.
fn ink(world: &mut World, frame: &mut Option<Frame>, style: &Style) -> Vec<u16> {
    let pose = world.pose("900,-900,+20,315,3,60");
    let view = View { pose, previous: pose, picture_px: SIZE_PX, part: Part::whole(SIZE_PX) };
    let light = Light { to_sun: DVec3::Z, haze_m: 30_000.0, haze_srgb: None };
    let gpu = &world.gpu;
    match frame {
        Some(frame) => frame.adapt(gpu, Requirements::of(style), SIZE_PX).unwrap(),
        None => *frame = Some(Frame::new(gpu, Requirements::of(style), SIZE_PX).unwrap()),
    }
    let frame = frame.as_mut().unwrap();
    frame.render(gpu, &mut world.terrain, &view, style, &light);
    read_as(gpu, &frame.targets().strokes.as_ref().unwrap().ink.ink, [0, 0], SIZE_PX).unwrap()
}

/// The texture that a frame draws with.
fn drawn_with(frame: &Option<Frame>) -> Option<wgpu::Texture> {
    frame.as_ref().unwrap().strokes().unwrap().texture().map(|texture| texture.texture().clone())
}

#[test]
fn solid_strokes_know_of_no_texture() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let mut frame = None;
    let style = |texture: Option<Recipe>| {
        let mut style = Style::load("strokes").unwrap();
        let strokes = style.strokes.as_mut().unwrap();
        (strokes.texture, strokes.faintest, strokes.taper_px) = (texture, 1.0, 0.0);
        // Each picture by itself.
        (strokes.carry, strokes.update_every) = (false, 1);
        style
    };
    let solid = ink(&mut world, &mut frame, &style(None));
    assert!(drawn_with(&frame).is_none() && solid.iter().filter(|ink| **ink > 0).count() > 500);
    let pencil = ink(&mut world, &mut frame, &style(Some(recipe("pencil"))));
    let kept = drawn_with(&frame);
    assert_ne!(pencil, solid);
    // The texture stays while the style does, and goes with it.
    assert!(ink(&mut world, &mut frame, &style(Some(recipe("pencil")))) == pencil);
    assert!(kept.is_some() && drawn_with(&frame) == kept);
    let charcoal = ink(&mut world, &mut frame, &style(Some(recipe("charcoal"))));
    assert!(drawn_with(&frame) != kept && charcoal != pencil);
    assert!(ink(&mut world, &mut frame, &style(None)) == solid, "solid strokes have changed");
    assert!(drawn_with(&frame).is_none());
    // A texture that takes all the ink is solid, but for the last pixels of strokes.
    let mut full = recipe("pen");
    (full.pigment.density, full.pigment.variation) = (1.0, 0.0);
    (full.touch.softness, full.touch.response, full.touch.fill) = (0.01, 0.05, 1.0);
    (full.touch.border_px, full.touch.border_pressure) = (0.0, 1.0);
    let share = |drawn: &[u16]| {
        let differ = drawn.iter().zip(&solid).filter(|(a, b)| a != b).count();
        differ as f64 / solid.iter().filter(|ink| **ink > 0).count() as f64
    };
    let drawn = ink(&mut world, &mut frame, &style(Some(full)));
    println!("{:.4} of the inked pixels differ; by a pencil {:.4}", share(&drawn), share(&pencil));
    assert!(share(&drawn) < 0.02 && share(&pencil) > 0.5);
}

#[test]
fn only_textured_strokes_read_the_texture() {
    assert!(SHADERS.iter().any(|(name, _)| *name == "lines/strokes/stroke"));
    let module = compose("lines/strokes/stroke").unwrap();
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
    let info = validator.validate(&module).unwrap();
    let reads = |entry: &str| {
        let index = module.entry_points.iter().position(|point| point.name == entry).unwrap();
        let of_texture = |name: &str| name.starts_with("brush");
        let uses =
            module.global_variables.iter().filter(|(_, variable)| variable.name.as_deref().is_some_and(of_texture));
        uses.filter(|(handle, _)| !info.get_entry_point(index)[*handle].is_empty()).count()
    };
    assert_eq!((reads("fragment"), reads("textured")), (0, 3));
}
