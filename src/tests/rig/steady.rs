//! Tests that a steady frame creates no GPU objects, and measures how long recording takes.

use std::collections::BTreeSet;

use hachure::frame::Renderer;
use hachure::gpu::recorder::Submits;
use hachure::gpu::trace::FrameCounts;
use hachure::scene::view::{Rig, View};
use hachure::style::Style;

use crate::tests::common::{full, preset};
use crate::tests::rig::{START, draw_rig, few_presets, hill, hill_apart, view};

#[test]
fn a_steady_frame_makes_no_gpu_object() {
    let Some(mut world) = hill() else { return };
    let pose = world.pose(START);
    for name in few_presets() {
        let mut style = preset(name);
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
/// itself takes little; then the time of whole frames, with their passes together and with each pass timed. A GPU may
/// measure the latter at `HACHURE_SIZE=1920x1080`.
///
/// Run with `cargo test --release --lib tests::rig::steady -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn print_the_cost_of_recording() {
    let Some(mut world) = hill_apart() else { return };
    let pose = world.pose(START);
    let size = std::env::var("HACHURE_SIZE").unwrap_or_else(|_| "64x36".to_owned());
    let size_px: Vec<u32> = size.split('x').map(|side| side.parse().unwrap()).collect();
    println!(
        "| preset | passes | wgpu passes | dispatches | draws | copies | barriers | record ms | submit ms | frame ms | \
         with each pass timed ms |"
    );
    for name in crate::tests::common::presets() {
        let mut style = Style::load(name).unwrap();
        style.strokes_mut().into_iter().for_each(|strokes| strokes.update_every = 1);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let rig = Rig::mono(View::whole(pose, pose, [size_px[0], size_px[1]]));
        renderer.set_traces(true);
        (0..3).for_each(|_| draw_rig(&mut world, &mut renderer, &style, &rig));
        let counts = FrameCounts::of(renderer.trace());
        let names: BTreeSet<&str> = renderer.trace().iter().map(|pass| pass.name).collect();
        if std::env::var_os("HACHURE_LIST").is_some() {
            let of = |name: &str| renderer.trace().iter().filter(|pass| pass.name == name).count();
            names.iter().for_each(|name| println!("  {:3} {name}", of(name)));
        }
        renderer.set_traces(false);
        let [mut record_ms, mut submit_ms, mut whole_ms, mut timed_ms] = [const { Vec::new() }; 4];
        for submits in [Submits::Whole, Submits::Timed] {
            renderer.set_submits(submits);
            for _ in 0..60 {
                let begun = std::time::Instant::now();
                draw_rig(&mut world, &mut renderer, &style, &rig);
                world.gpu.wait();
                let frame_ms = begun.elapsed().as_secs_f64() * 1000.0;
                while renderer.take_times().is_some() {}
                if submits == Submits::Timed {
                    timed_ms.push(frame_ms);
                    continue;
                }
                whole_ms.push(frame_ms);
                record_ms.push(renderer.cpu().record_ms);
                submit_ms.push(renderer.cpu().submit_ms);
            }
        }
        let times_ms = [record_ms, submit_ms, whole_ms, timed_ms].map(|mut times_ms| {
            times_ms.sort_by(f64::total_cmp);
            format!("{:.3}", times_ms[30])
        });
        let FrameCounts { wgpu_passes, dispatches, draws, copies, barriers } = counts;
        println!(
            "| `{name}` | {} | {wgpu_passes} | {dispatches} | {draws} | {copies} | {barriers} | {} |",
            names.len(),
            times_ms.join(" | ")
        );
    }
}
