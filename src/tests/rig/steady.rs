//! Tests that a steady frame creates no GPU objects, and measures how long recording takes.

use hachure::frame::Renderer;
use hachure::scene::view::Rig;
use hachure::style::Style;

use crate::tests::common::full;
use crate::tests::rig::{START, draw_rig, hill_apart, view};

#[test]
fn a_steady_frame_makes_no_gpu_object() {
    let Some(mut world) = hill_apart() else { return };
    let pose = world.pose(START);
    for name in crate::tests::common::presets() {
        let mut style = Style::load(name).unwrap();
        if !full() {
            // Strokes that are rebuilt more often draw both kinds of frames in fewer frames.
            style.strokes_mut().into_iter().for_each(|strokes| strokes.update_every = strokes.update_every.min(3));
        }
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let rig = Rig::mono(view(pose, pose));
        let updates = style.strokes().map_or(1, |strokes| strokes.update_every);
        // The loop draws both kinds of frames of a style with strokes, and uses both of its lists of samples.
        for _ in 0..2 * updates + 2 {
            draw_rig(&mut world, &mut renderer, &style, &rig);
        }
        let before = world.gpu.objects_made();
        for _ in 0..2 * updates {
            draw_rig(&mut world, &mut renderer, &style, &rig);
        }
        assert_eq!(world.gpu.objects_made() - before, 0, "{name}");
        // Control: another renderer creates its own objects.
        let mut other = Renderer::new(&world.gpu).unwrap();
        draw_rig(&mut world, &mut other, &style, &rig);
        assert!(world.gpu.objects_made() - before > 5, "{name}");
    }
}

/// Run with `cargo test --release --lib tests::rig -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn recording_takes_milliseconds() {
    let Some(mut world) = hill_apart() else { return };
    let pose = world.pose(START);
    for name in crate::tests::common::presets() {
        let style = Style::load(name).unwrap();
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let rig = Rig::mono(view(pose, pose));
        let mut times_ms = Vec::new();
        for _ in 0..60 {
            draw_rig(&mut world, &mut renderer, &style, &rig);
            world.gpu.wait();
            times_ms.push(renderer.record_ms());
        }
        times_ms.sort_by(f64::total_cmp);
        println!("{name}: {:.3} ms median, {:.3} ms at most", times_ms[30], times_ms[59]);
    }
}
