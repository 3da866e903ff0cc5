//! Tests the warp of light, function by function.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use hachure::gpu::Gpu;
use hachure::gpu::readback::read_buffer;

use crate::tests::common::gpu;
use crate::tests::helpers::probe;

const PROBE: &str = r"
#import hachure::light_warp::{warp_of, inverse_warp_of, warp_light, scale_less_one}
struct Question { direction: vec3<f32>, most: f32, along: vec2<f32>, least: f32, pad: f32 }
struct Answer { there: vec4<f32>, back: vec4<f32>, inverse: vec4<f32>, scale: vec4<f32> }
@group(0) @binding(0) var<storage, read> questions: array<Question>;
@group(0) @binding(1) var<storage, read_write> answers: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let question = questions[id.x];
    let warp = warp_of(question.most, question.least, question.along);
    let inverse = inverse_warp_of(question.most, question.least, question.along);
    let there = warp_light(warp, question.direction);
    let back = warp_light(inverse, there.direction);
    let unwarped = warp_light(inverse, question.direction);
    answers[id.x] = Answer(vec4<f32>(there.direction, there.growth), vec4<f32>(back.direction, back.growth),
        vec4<f32>(unwarped.direction, unwarped.growth), vec4<f32>(scale_less_one(question.most), 0.0, 0.0, 0.0));
}
";

#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Question {
    direction: [f32; 3],
    most: f32,
    along: [f32; 2],
    least: f32,
    pad: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Answer {
    /// W of the direction (xyz), and the growth of solid angles (w).
    there: [f32; 4],
    /// The inverse of `there`.
    back: [f32; 4],
    /// The inverse warp of the direction itself.
    inverse: [f32; 4],
    /// λ − 1 of the greater curvature.
    scale: [f32; 4],
}

fn ask(gpu: &Gpu, questions: &[Question]) -> Vec<Answer> {
    let mut padded = questions.to_vec();
    padded.resize(questions.len().next_multiple_of(probe::THREADS), questions[0]);
    let answers = vec![0_u8; padded.len() * size_of::<Answer>()];
    let buffers = [bytemuck::cast_slice(&padded), &answers[..]].map(|contents| probe::storage(gpu, contents));
    probe::run(gpu, PROBE, buffers.iter().map(wgpu::Buffer::as_entire_binding), padded.len());
    read_buffer(gpu, &buffers[1], questions.len()).unwrap()
}

/// Curvatures times α, and the direction of the first, in radians.
type Bend = (f64, f64, f64);

/// Curvatures from 0 to far beyond real ones, equal ones and opposite ones.
const BENDS: [Bend; 8] = [
    (0.0, 0.0, 0.3),
    (0.5, 0.5, 1.0),
    (1.0, -1.0, 0.7),
    (4.0, 0.2, 2.5),
    (-0.3, -3.0, 1.9),
    (50.0, -50.0, 0.1),
    (1e9, 1e9, 0.0),
    (-1e9, -1e12, 2.0),
];

fn question(direction: DVec3, (most, least, turn): Bend) -> Question {
    Question {
        direction: direction.as_vec3().to_array(),
        most: most as f32,
        along: DVec2::from_angle(turn).as_vec2().to_array(),
        least: least as f32,
        pad: 0.0,
    }
}

/// Returns directions all over the sphere, including both poles.
fn sphere(count: u32) -> Vec<DVec3> {
    let spiral = (0..count).map(|i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        (DVec2::from_angle(2.399_963 * f64::from(i)) * (1.0 - z * z).sqrt()).extend(z)
    });
    spiral.chain([DVec3::Z, -DVec3::Z, DVec3::X]).collect()
}

fn direction(answer: [f32; 4]) -> DVec3 {
    DVec3::new(answer[0].into(), answer[1].into(), answer[2].into())
}

fn scale(alpha_kappa: f64) -> f64 {
    (alpha_kappa.atan() / 6.0 + PI / 4.0).tan()
}

/// Returns the paper's W of a direction, and the paper's J of its inverse, in the paper's frame of u, v and z.
fn papers(light: DVec3, (most, least, turn): Bend) -> (DVec3, f64) {
    let (u, v) = (DVec2::from_angle(turn), DVec2::from_angle(turn).perp());
    let [lu, lv, lz] = [light.truncate().dot(u), light.truncate().dot(v), light.z];
    let [a, b] = [scale(most), scale(least)];
    let t = (1.0 + lz).powi(2) / ((1.0 + lz).powi(2) + a * a * lu * lu + b * b * lv * lv);
    let warped = (u * (2.0 * t * a * lu / (1.0 + lz)) + v * (2.0 * t * b * lv / (1.0 + lz))).extend(2.0 * t - 1.0);
    let below = a * a * b * b * (1.0 + lz).powi(2) + b * b * lu * lu + a * a * lv * lv;
    (warped, 4.0 * a.powi(3) * b.powi(3) * (1.0 + lz).powi(2) / (below * below))
}

#[test]
fn the_warp_is_the_papers_and_its_inverse_takes_it_back() {
    let Some(gpu) = gpu() else { return };
    let directions = sphere(4000);
    for bend in BENDS {
        let answers = ask(&gpu, &directions.iter().map(|light| question(*light, bend)).collect::<Vec<_>>());
        // Distance of W⁻¹(W(l)) from l, distance of W from the paper's, and relative difference of the inverse's J from
        // the paper's.
        let mut most = [0.0_f64; 3];
        let mut planted = [0.0_f64; 2];
        let turned = (bend.0, bend.1, bend.2 + PI / 2.0);
        for (light, answer) in directions.iter().zip(&answers) {
            let is_defined = answer.there.iter().chain(&answer.inverse).all(|value| value.is_finite());
            assert!(is_defined && answer.inverse[3] > 0.0, "{light} {bend:?}: {answer:?}");
            most[0] = most[0].max(direction(answer.back).distance(*light));
            // W is undefined at the far pole.
            if light.z > -0.999 {
                let (warped, growth) = papers(*light, bend);
                most[1] = most[1].max(direction(answer.there).distance(warped));
                most[2] = most[2].max((f64::from(answer.inverse[3]) / growth - 1.0).abs());
                let (exchanged, _) = papers(*light, turned);
                planted[0] = planted[0].max(direction(answer.there).distance(exchanged));
                planted[1] = planted[1].max((1.0 / growth - 1.0).abs());
            }
        }
        println!("{bend:?}: there and back {:.1e}, W {:.1e}, J {:.1e}", most[0], most[1], most[2]);
        assert!(most[0] < 1e-5 && most[1] < 1e-5 && most[2] < 1e-4, "{bend:?}: {most:?}");
        // Planted: swapped directions; the Jacobian left out.
        assert!((scale(bend.0) - scale(bend.1)).abs() < 0.01 || planted[0] > 0.05, "{planted:?}");
        assert!(bend.0 == 0.0 || planted[1] > 0.1, "{planted:?}");
    }
}

#[test]
fn growth_is_what_solid_angles_do() {
    let Some(gpu) = gpu() else { return };
    let (directions, step) = (sphere(500), 2e-3);
    for bend in BENDS {
        let mut questions = Vec::new();
        for light in &directions {
            let [a, b] = [light.any_orthonormal_vector(), light.cross(light.any_orthonormal_vector())];
            questions.push(question(*light, bend));
            for side in [a, -a, b, -b] {
                questions.push(question((*light + step * side).normalize(), bend));
            }
        }
        let answers = ask(&gpu, &questions);
        let mut most = 0.0_f64;
        // At the far pole the warp is discontinuous, unless it is the same in all directions.
        for (five, _) in answers.chunks_exact(5).zip(&directions).filter(|(_, light)| light.z > -0.98) {
            let at = |i: usize| direction(five[i].inverse);
            let grown = ((at(1) - at(2)) / (2.0 * step)).cross((at(3) - at(4)) / (2.0 * step)).length();
            most = most.max((f64::from(five[0].inverse[3]) / grown - 1.0).abs());
        }
        println!("{bend:?}: J from finite differences by {most:.1e}");
        assert!(most < 1e-3, "{bend:?}: {most}");
    }
}

#[test]
fn the_light_of_a_white_sky_is_kept() {
    let Some(gpu) = gpu() else { return };
    // With few lights the sum is inexact where the warp is strongest, so the pass divides by the result of a white sky.
    for (count, most) in [(20_000_u32, 1e-3), (54, 0.05)] {
        let directions = &sphere(count)[..count as usize];
        let mut off = [0.0_f64; 2];
        for bend in BENDS {
            let answers = ask(&gpu, &directions.iter().map(|light| question(*light, bend)).collect::<Vec<_>>());
            let all: f64 = answers.iter().map(|answer| f64::from(answer.inverse[3]) / f64::from(count)).sum();
            // Planted: the Jacobian of the warp in place of that of its inverse.
            let wrong: f64 = answers.iter().map(|answer| 1.0 / f64::from(answer.inverse[3]) / f64::from(count)).sum();
            off = [off[0].max((all - 1.0).abs()), off[1].max((wrong - 1.0).abs())];
        }
        println!("{count} lights: a white sky is off by {:.1e} (planted {:.1e})", off[0], off[1]);
        assert!(off[0] < most && off[1] > 0.05, "{off:?}");
    }
}

#[test]
fn scales_lie_between_their_bounds() {
    let Some(gpu) = gpu() else { return };
    let asked = [0.0, 1e-30, 1.0, -1.0, 1e30, -1e30, f64::from(f32::MAX)];
    let questions: Vec<Question> = asked.iter().map(|kappa| question(DVec3::X, (*kappa, 0.0, 0.0))).collect();
    for (kappa, answer) in asked.iter().zip(ask(&gpu, &questions)) {
        let own = f64::from(answer.scale[0]);
        assert!((own - (scale(*kappa) - 1.0)).abs() < 1e-5, "{kappa}: {own}");
        assert!(own < 0.7321 && own > -0.4227);
    }
    // A curvature of 0 gives exactly 0, and light keeps its direction.
    let still = ask(&gpu, &[question(DVec3::new(0.48, 0.6, 0.64), (0.0, 0.0, TAU / 7.0))])[0];
    assert_eq!((still.there, still.scale[0]), ([0.48, 0.6, 0.64, 1.0], 0.0));
}
