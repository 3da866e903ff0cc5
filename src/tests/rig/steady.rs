//! Tests that a steady frame creates no GPU objects, and measures how long recording takes.

use std::collections::BTreeSet;

use hachure::frame::Renderer;
use hachure::gpu::trace::{FrameCounts, Work};
use hachure::scene::view::{Rig, View};
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

/// Prints what each preset's frames consist of, and the CPU time to record and submit them, at a size at which drawing
/// itself takes little.
///
/// Run with `cargo test --release --lib tests::rig::steady -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn recording_takes_milliseconds() {
    let Some(mut world) = hill_apart() else { return };
    let pose = world.pose(START);
    println!("| preset | names | passes | dispatches | indirect | draws | copies | barriers | record ms | submit ms |");
    for name in crate::tests::common::presets() {
        let mut style = Style::load(name).unwrap();
        style.strokes_mut().into_iter().for_each(|strokes| strokes.update_every = 1);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let rig = Rig::mono(View::whole(pose, pose, [64, 36]));
        renderer.set_traces(true);
        (0..3).for_each(|_| draw_rig(&mut world, &mut renderer, &style, &rig));
        let counts = FrameCounts::of(renderer.trace());
        let names: BTreeSet<&str> = renderer.trace().iter().map(|pass| pass.name).collect();
        let indirect = renderer.trace().iter().filter(|pass| matches!(pass.work, Work::Indirect(_))).count();
        if std::env::var_os("HACHURE_LIST").is_some() {
            let of = |name: &str| renderer.trace().iter().filter(|pass| pass.name == name).count();
            names.iter().for_each(|name| println!("  {:3} {name}", of(name)));
        }
        renderer.set_traces(false);
        let [mut record_ms, mut submit_ms] = [Vec::new(), Vec::new()];
        for _ in 0..60 {
            draw_rig(&mut world, &mut renderer, &style, &rig);
            world.gpu.wait();
            record_ms.push(renderer.cpu().record_ms);
            submit_ms.push(renderer.cpu().submit_ms);
        }
        let median = |times_ms: &mut Vec<f64>| {
            times_ms.sort_by(f64::total_cmp);
            times_ms[30]
        };
        let [record_ms, submit_ms] = [median(&mut record_ms), median(&mut submit_ms)];
        let FrameCounts { passes, dispatches, draws, copies, barriers } = counts;
        println!(
            "| `{name}` | {} | {passes} | {dispatches} | {indirect} | {draws} | {copies} | {barriers} | {record_ms:.3} | \
             {submit_ms:.3} |",
            names.len()
        );
    }
}
