//! Tests switching styles as in a window: a frame waits for no pipeline, and no picture mixes two styles.

use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::gpu::pipelines::Builds;
use hachure::scene::view::{Pose, Rig};
use hachure::style::Style;

use crate::tests::common::World;
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
    let styles: Vec<Style> =
        crate::tests::common::presets().into_iter().map(|name| Style::load(name).unwrap()).collect();
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
    assert!(twins.of_before > 10, "only {} frames in the previous style", twins.of_before);
    let at_once = twins.waiting.built_at_once();
    // Control: without background builds, frames wait for their pipelines.
    assert!(at_once > 40, "{at_once}");
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
    let style = Style::load("pen").unwrap();
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
