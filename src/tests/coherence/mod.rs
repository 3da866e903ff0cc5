//! Strokes from frame to frame: they stay in place, take over from the strokes of the previous update, grow and shrink
//! along their own length, and stay within the budget.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

mod budget;
mod checks;
mod extremes;
mod growth;
mod places;
mod resized;
mod sheet;
mod steady;

use std::sync::OnceLock;

use common::{World, full};
use glam::DVec3;
use hachure::frame::Renderer;
use hachure::lines::strokes::samples::{Sample, SampleCounts};
use hachure::scene::view::{Pose, View};
use hachure::source::{HeightGrid, Silent, procedural};
use hachure::style::{self, Style};

use crate::tests::common::draw::{NOON, draw};

const SIZE_PX: [u32; 2] = [320, 180];
/// The start of a slow flight: a metre and an eighth of a degree per frame.
const START: &str = "-300,-2500,+350,20,-6,60";
const STEP_M: f64 = 1.0;

/// Returns mountains like those of the built-in world, but smaller. They are generated once.
fn mountains() -> Option<World> {
    static GRID: OnceLock<HeightGrid> = OnceLock::new();
    let grid = GRID.get_or_init(|| procedural::generate_sized(1, 512, 24.0, &Silent));
    World::new(grid.clone(), 1.0)
}

/// Returns the preset `strokes` with other strokes. In the fast tier it has no water, of which strokes are independent.
fn strokes(change: impl FnOnce(&mut style::Strokes)) -> Style {
    let mut style = common::all_lines("strokes");
    change(style.strokes_mut().unwrap());
    if !full() {
        style.set_water(None);
    }
    style
}

/// Returns the pose of one frame of the flight.
fn pose(world: &World, frame: u32) -> Pose {
    let mut pose = world.pose(START);
    pose.position_m += DVec3::new(0.3, 1.0, 0.0).normalize() * (STEP_M * f64::from(frame));
    let turn = glam::DQuat::from_rotation_z(-0.125_f64.to_radians() * f64::from(frame));
    for axis in [&mut pose.forward, &mut pose.right, &mut pose.up] {
        *axis = turn * *axis;
    }
    pose
}

struct Flight {
    style: Style,
    renderer: Renderer,
    last: Option<View>,
}

impl Flight {
    /// Begins a flight. In the fast tier its frames end when their strokes are drawn, and have no picture.
    fn new(world: &World, style: Style) -> Self {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_only_strokes(!full());
        Self { style, renderer, last: None }
    }

    /// Draws one frame of the slow flight.
    fn fly(&mut self, world: &mut World, frame: u32) -> (View, SampleCounts, Vec<Sample>) {
        let pose = pose(world, frame);
        self.draw(world, pose)
    }

    fn draw(&mut self, world: &mut World, pose: Pose) -> (View, SampleCounts, Vec<Sample>) {
        let previous = self.last.map_or(pose, |last| last.pose);
        let view = View::whole(previous, pose, SIZE_PX);
        self.last = Some(view);
        draw(&world.gpu, &mut world.surfaces, &mut self.renderer, &view, &self.style, &NOON);
        let (counts, samples) = self.renderer.strokes().unwrap().samples().read(&world.gpu).unwrap();
        (view, counts, samples)
    }
}
