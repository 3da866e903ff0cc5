//! Tests pictures that are a part of larger textures: they are those of textures of their own size, and another size
//! makes no GPU object.

use std::sync::Arc;

use glam::DVec3;
use hachure::composite::PICTURE;
use hachure::frame::{Antialias, Renderer};
use hachure::gpu::readback::read;
use hachure::scene::forest::Form;
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Rig, View};
use hachure::style::{Detector, ReliefKind, Style};
use hachure::surface::{DISTANCE, NORMAL};

use crate::tests::common::{World, full, preset, presets};
use crate::tests::helpers::{forest, shapes};
use crate::tests::rig::{draw_rig, hill, light, luma};

const ROOM_PX: [u32; 2] = [113, 65];
const SIZE_PX: [u32; 2] = [75, 43];

/// Returns a hill with a model, trees and a sea.
fn land() -> Option<World> {
    let (hill, mut world) = shapes::hill()?;
    let at_m = DVec3::new(850.0, -850.0, 0.0);
    let at_m = at_m.with_z(hill.height_m(at_m.x, at_m.y) + 10.0);
    let mesh = Arc::new(shapes::mesh(shapes::cube()));
    shapes::place(&mut world, &mesh, &shapes::stance(at_m, 0.0, 10.0));
    world.surfaces.set_forest(Some(forest::of(Form::Conifer, 4.0, 20.0)));
    world.surfaces.set_sea_level(Some(30.0));
    Some(world)
}

/// Styles of all kinds, and what presets have not. In the fast tier two that have most passes between them.
fn styles() -> Vec<Style> {
    let changed = |name: &str, change: fn(&mut Style)| {
        let mut style = preset(name);
        change(&mut style);
        style.name += " (changed)";
        style
    };
    if !full() {
        let with_most = changed("wash", |style| {
            style.set_hatching(preset("crosshatch").hatching().cloned());
            style.set_lines(preset("lsa").lines().cloned());
            style.set_tone_lines(preset("tone-lines").tone_lines().cloned());
            style.relief = preset("relief").relief;
        });
        return vec![preset("lsa"), with_most];
    }
    let mut styles: Vec<Style> = presets().into_iter().map(preset).collect();
    styles.push(changed("lsa", |style| style.lines_mut().unwrap().detector = Detector::Curvature));
    styles.push(changed("suggestive", |style| style.strokes_mut().unwrap().ridge_apparent = true));
    styles.push(changed("strokes", |style| style.strokes_mut().unwrap().resolution = 0.5));
    for kind in [ReliefKind::Scaling, ReliefKind::Exaggerated] {
        let mut style = preset("relief");
        style.relief.as_mut().unwrap().kind = kind;
        style.name = format!("relief {}", kind.name());
        styles.push(style);
    }
    styles
}

/// The eyes of a frame.
#[derive(Clone, Copy)]
enum Eyes {
    One,
    Two,
}

impl Eyes {
    fn rig(self, world: &World, size_px: [u32; 2], turn: u32) -> Rig {
        let pose = |turn: u32| world.pose(&format!("900,-900,+20,{},3,60", 315 + turn));
        let view = View::whole(pose(turn.saturating_sub(1)), pose(turn), size_px);
        match self {
            Self::One => Rig::mono(view),
            Self::Two => Pair { ipd_m: 0.5, convergence_m: None }.rig(&view),
        }
    }
}

/// Draws some frames of the smaller size after one of the largest, and returns the pictures of the last one.
fn drawn(
    world: &mut World,
    style: &Style,
    eyes: Eyes,
    antialias: Antialias,
    room_px: Option<[u32; 2]>,
) -> Vec<Vec<u8>> {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_room(room_px);
    renderer.set_antialias(antialias);
    draw_rig(world, &mut renderer, style, &eyes.rig(world, ROOM_PX, 40));
    renderer.forget();
    for turn in 0..2 {
        let rig = eyes.rig(world, SIZE_PX, turn);
        draw_rig(world, &mut renderer, style, &rig);
    }
    let mut pictures = Vec::new();
    let count = if matches!(eyes, Eyes::One) { 1 } else { 2 };
    for eye in 0..count {
        for kind in [&PICTURE, &DISTANCE, &NORMAL] {
            // A style without tones of the surface has no normals.
            let Some(target) = renderer.eye_target(eye, kind) else {
                assert!(kind.name == NORMAL.name, "{}", kind.name);
                continue;
            };
            assert_eq!((target.size_px(), target.is_part()), (SIZE_PX, room_px.is_some()), "{}", target.name);
            pictures.push(read(&world.gpu, target, [0, 0], SIZE_PX).unwrap());
        }
    }
    pictures
}

/// Counts bytes that differ in each picture.
fn differing(a: &[Vec<u8>], b: &[Vec<u8>]) -> Vec<usize> {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).filter(|(a, b)| a != b).count()).collect()
}

/// Returns the largest difference of two bytes.
fn furthest(a: &[Vec<u8>], b: &[Vec<u8>]) -> u8 {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| a.iter().zip(b));
    pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

#[test]
fn a_part_of_a_texture_is_drawn_as_a_texture_of_its_own() {
    let Some(mut world) = land() else { return };
    let mut wrong = Vec::new();
    let mut of_styles = Vec::new();
    for style in styles() {
        let all = [(Eyes::One, Antialias::None), (Eyes::Two, Antialias::None), (Eyes::One, Antialias::Temporal)];
        let cases = match &*style.name {
            _ if full() => &all[..],
            "lsa" => &all[2..],
            _ => &all[1..2],
        };
        for &(eyes, antialias) in cases {
            let mut of = |room_px| drawn(&mut world, &style, eyes, antialias, room_px);
            let (own, part) = (of(None), of(Some(ROOM_PX)));
            let differing = differing(&own, &part);
            // A sampler rounds its weights, and in a larger texture its places are other numbers.
            let allowed = if style.tone_lines().is_some() { 20 } else { 0 };
            if differing.iter().any(|count| *count > allowed) || furthest(&own, &part) > 1 {
                let eyes = if matches!(eyes, Eyes::One) { "one eye" } else { "two eyes" };
                wrong.push(format!("{}, {eyes}, {antialias}: {differing:?}", style.name));
            }
            of_styles.push(part);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Planted: another style.
    let last = &of_styles[of_styles.len() - 1];
    assert!(differing(&of_styles[0][..1], &last[..1])[0] > 1000);
}

#[test]
fn the_mean_continues_in_another_size() {
    let Some(mut world) = hill() else { return };
    let style = preset("lsa");
    let mut luma_after = |frames: &[([u32; 2], usize)], room_px: Option<[u32; 2]>| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_room(room_px);
        renderer.set_antialias(Antialias::Temporal);
        for (size_px, count) in frames {
            for _ in 0..*count {
                // Unlike the other tests' frames, these are displaced from sample to sample.
                let rig = Eyes::One.rig(&world, *size_px, 0);
                renderer.render_eyes(&world.gpu, &mut world.surfaces, &rig, &style, &light()).unwrap();
            }
        }
        luma(&world, &renderer)
    };
    let converged = luma_after(&[(SIZE_PX, if full() { 64 } else { 32 })], None);
    let error = |drawn: &[f32]| -> f64 {
        let errors = drawn.iter().zip(&converged).map(|(a, b)| f64::from((a - b).abs()));
        errors.sum::<f64>() / converged.len() as f64
    };
    let continued = error(&luma_after(&[(ROOM_PX, 16), (SIZE_PX, 1)], Some(ROOM_PX)));
    let anew = error(&luma_after(&[(ROOM_PX, 16), (SIZE_PX, 1)], None));
    println!("mean error of the first frame in another size: {continued:.4}, without room {anew:.4}");
    assert!(continued < 0.8 * anew, "{continued} {anew}");
}

#[test]
fn a_size_that_was_drawn_before_makes_no_object() {
    let Some(mut world) = hill() else { return };
    let sizes_px = [ROOM_PX, SIZE_PX, [38, 22], [85, 49]];
    let names = if full() { vec!["crosshatch", "wash"] } else { vec!["strokes"] };
    for name in names {
        let mut style = preset(name);
        // Every frame is an update, so that each size has had all its passes.
        style.strokes_mut().into_iter().for_each(|strokes| strokes.update_every = 1);
        let made = |world: &mut World, room_px| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            renderer.set_room(room_px);
            let mut made = 0;
            for round in 0..3 {
                for size_px in sizes_px {
                    let before = world.gpu.objects_made();
                    draw_rig(world, &mut renderer, &style, &Eyes::One.rig(world, size_px, 0));
                    made += if round == 2 { world.gpu.objects_made() - before } else { 0 };
                }
            }
            made
        };
        let with_room = made(&mut world, Some(ROOM_PX));
        assert_eq!(with_room, 0, "{name}");
        // Planted: without room, each size has textures of its own.
        assert!(made(&mut world, None) > 20, "{name}");
    }
}
