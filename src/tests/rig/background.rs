//! Tests switching styles as in a window: a frame waits for no pipeline, and no picture mixes two styles.

use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::gpu::pipelines::Builds;
use hachure::scene::view::{Pose, Rig};
use hachure::style::Style;

use crate::tests::common::{World, full, preset, presets};
use crate::tests::rig::{START, bytes, draw_rig, hill_apart, light, view};

const PATIENCE: Duration = Duration::from_secs(180);

/// A renderer that builds pipelines in the background, and one that draws the same frames and waits for its pipelines.
struct Twins {
    background: Renderer,
    waiting: Renderer,
    /// The world of the waiting renderer, on its own device, so that it shares no pipelines.
    apart: World,
    pose: Pose,
    /// Number of pictures drawn in the previous style.
    of_before: usize,
    record_ms: Vec<f64>,
    /// Times of the first frame that requests another style: in the background, and where it waits.
    begins_ms: Vec<f64>,
    waits_ms: Vec<f64>,
}

impl Twins {
    fn new(world: &World) -> Option<Self> {
        let mut background = Renderer::new(&world.gpu).unwrap();
        background.set_builds(Builds::InBackground);
        let apart = hill_apart()?;
        let waiting = Renderer::new(&apart.gpu).unwrap();
        let (record_ms, begins_ms, waits_ms) = Default::default();
        let pose = world.pose(START);
        Some(Self { background, waiting, apart, pose, of_before: 0, record_ms, begins_ms, waits_ms })
    }

    /// Requests a frame of `asked`, and checks that the picture is bit-identical to a frame of it, or of the style
    /// before.
    fn step(&mut self, world: &mut World, asked: &Style, before: Option<&Style>, pose: Pose) {
        let view = view(self.pose, pose);
        self.pose = pose;
        self.background.render(&world.gpu, &mut world.surfaces, &view, asked, &light()).unwrap();
        world.gpu.wait();
        let Some(shown) = [Some(asked), before].into_iter().flatten().find(|style| self.background.shows(style)) else {
            assert!(self.background.target(&PICTURE).is_none() && before.is_none(), "{}", asked.name);
            return;
        };
        self.record_ms.push(self.background.record_ms());
        self.of_before += usize::from(shown != asked);
        draw_rig(&mut self.apart, &mut self.waiting, shown, &Rig::mono(view));
        let background = bytes(world, &self.background, 0, &PICTURE);
        let waiting = bytes(&self.apart, &self.waiting, 0, &PICTURE);
        let differing = background.iter().zip(&waiting).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 0, "the picture while {} was requested is not one of {}", asked.name, shown.name);
    }

    /// Draws frames until the requested style is shown.
    fn switch(&mut self, world: &mut World, asked: &Style, before: Option<&Style>) {
        let begun = Instant::now();
        let steps = self.record_ms.len();
        while !self.background.shows(asked) {
            self.step(world, asked, before, self.pose);
            if before.is_some() && self.record_ms.len() == steps + 1 {
                self.begins_ms.push(self.record_ms[steps]);
            }
            assert!(
                begun.elapsed() < PATIENCE,
                "{} was not shown: {:?}",
                asked.name,
                world.gpu.pipelines().shader_errors()
            );
            std::thread::sleep(Duration::from_millis(20));
        }
        // The waiting renderer has just drawn its first frame of the style.
        self.waits_ms.push(self.waiting.record_ms());
    }
}

fn median(times_ms: &mut [f64]) -> f64 {
    times_ms.sort_by(f64::total_cmp);
    times_ms[times_ms.len() / 2]
}

#[test]
fn a_switch_waits_for_no_pipeline_and_shows_no_mixture() {
    let Some(mut world) = hill_apart() else { return };
    let (names, least_built, least_before) =
        if full() { (presets(), 40, 10) } else { (vec!["plain", "strokes"], 20, 2) };
    let styles: Vec<Style> = names.into_iter().map(preset).collect();
    let Some(mut twins) = Twins::new(&world) else { return };
    let mut before = None;
    for style in &styles {
        twins.switch(&mut world, style, before);
        // Frames after the first one were prewarmed, too: at rest, in motion, and after a turn.
        let pose = twins.pose;
        let moved = Pose { position_m: pose.position_m + pose.right * 0.01, ..pose };
        let turn = DQuat::from_axis_angle(DVec3::Z, -0.2);
        let turned = Pose { forward: turn * moved.forward, right: turn * moved.right, up: turn * moved.up, ..moved };
        for pose in [pose, moved, turned, turned, pose] {
            twins.step(&mut world, style, before, pose);
            assert!(twins.background.shows(style) && !twins.background.is_building(&world.gpu), "{}", style.name);
        }
        before = Some(style);
    }
    assert_eq!(twins.background.built_at_once(), 0);
    assert!(twins.of_before > least_before, "only {} frames in the previous style", twins.of_before);
    let at_once = twins.waiting.built_at_once();
    // Control: without background builds, frames wait for their pipelines.
    assert!(at_once > least_built, "{at_once}");
    let [all_ms, begins_ms, waits_ms] =
        [&mut twins.record_ms, &mut twins.begins_ms, &mut twins.waits_ms].map(|times_ms| median(times_ms));
    println!(
        "{} frames, {} of them in the previous style; median recording time {all_ms:.2} ms, {begins_ms:.2} ms where \
         a switch begins, {waits_ms:.2} ms where frames wait",
        twins.record_ms.len(),
        twins.of_before
    );
    // On a machine without other load the ratio is about a hundred.
    assert!(
        begins_ms < 0.5 * waits_ms,
        "a switch takes {begins_ms} ms in the background, {waits_ms} ms where frames wait"
    );
    world.gpu.check().unwrap();
}

#[test]
fn what_is_under_way_is_waited_for_where_frames_wait() {
    let Some(mut world) = hill_apart() else { return };
    let style = Style::load(if full() { "pen" } else { "plain" }).unwrap();
    let Some(mut twins) = Twins::new(&world) else { return };
    let pose = twins.pose;
    twins.step(&mut world, &style, None, pose);
    assert!(twins.background.is_building(&world.gpu) && !twins.background.shows(&style));
    // Screenshots wait for pipelines, too.
    twins.background.set_builds(Builds::AtOnce);
    let rig = Rig::mono(view(pose, pose));
    draw_rig(&mut world, &mut twins.background, &style, &rig);
    draw_rig(&mut twins.apart, &mut twins.waiting, &style, &rig);
    let (a, b) = (bytes(&world, &twins.background, 0, &PICTURE), bytes(&twins.apart, &twins.waiting, 0, &PICTURE));
    assert!(a == b && twins.background.built_at_once() > 0);
}

#[test]
fn spare_pipelines_are_there_when_their_style_is_chosen() {
    let Some(mut world) = hill_apart() else { return };
    let [shown, spared, other] = ["lsa", "crosshatch", "hachures"].map(|name| Style::load(name).unwrap());
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_builds(Builds::InBackground);
    let pose = world.pose(START);
    let view = view(pose, pose);
    // Draws until a style is shown; returns how many frames and pipelines that took, and the milliseconds.
    let show = |world: &mut World, renderer: &mut Renderer, style: &Style| {
        let (begun, builds, mut frames) = (Instant::now(), world.gpu.pipelines().builds(), 0);
        while !renderer.shows(style) {
            renderer.render(&world.gpu, &mut world.surfaces, &view, style, &light()).unwrap();
            world.gpu.wait();
            frames += 1;
            assert!(begun.elapsed() < PATIENCE, "{} was not shown", style.name);
            std::thread::sleep(Duration::from_millis(2));
        }
        (frames, world.gpu.pipelines().builds() - builds, begun.elapsed().as_secs_f64() * 1000.0)
    };
    show(&mut world, &mut renderer, &shown);
    let begun = Instant::now();
    renderer.request_spares(&world.gpu, &world.surfaces, &Rig::mono(view), &spared, &light()).unwrap();
    let request_ms = begun.elapsed().as_secs_f64() * 1000.0;
    assert!(renderer.has_spares(&world.gpu));
    let (mut frames, mut record_ms, builds) = (0, 0.0_f64, world.gpu.pipelines().builds());
    while renderer.has_spares(&world.gpu) {
        let before = world.gpu.pipelines().builds();
        renderer.render(&world.gpu, &mut world.surfaces, &view, &shown, &light()).unwrap();
        world.gpu.wait();
        // Frames go on in the shown style as if nothing were being compiled, while one pipeline at a time is.
        assert!(renderer.drew() && renderer.shows(&shown) && !renderer.is_building(&world.gpu));
        assert!(world.gpu.pipelines().builds() <= before + 1);
        (frames, record_ms) = (frames + 1, record_ms.max(renderer.record_ms()));
    }
    let spares = world.gpu.pipelines().builds() - builds;
    let (of_spared, needed, spared_ms) = show(&mut world, &mut renderer, &spared);
    // Planted error: a style whose pipelines nobody requested before.
    let (of_other, needed_by_other, other_ms) = show(&mut world, &mut renderer, &other);
    println!(
        "{spares} spare pipelines (requested in {request_ms:.1} ms) in {frames} frames of at most {record_ms:.1} ms; \
         then {needed} were missing, shown after {of_spared} frames and {spared_ms:.0} ms; of a style without spares \
         {needed_by_other}, {of_other} frames, {other_ms:.0} ms"
    );
    assert!(spares > 30 && needed <= 2, "{spares} spares, {needed} were missing");
    assert!(needed_by_other > 3 && renderer.built_at_once() == 0);
    world.gpu.check().unwrap();
}
