//! How a window goes from a style to another without waiting: the old one is drawn until all is there that the new one
//! needs.
//!
//! What that is nobody lists. The frame itself is prewarmed: its passes run with a recorder that only asks
//! ([`Recorder::prewarm`]), as the first frame of a style, as the next one at rest, and as one after a turn, for strokes do
//! something else in each. What the prewarming run did not meet is missed when a frame is recorded; nothing of such a frame
//! is submitted, and the last picture stays.
//!
//! Why: `docs/decisions/pipelines-in-background.md`.

use std::time::Instant;

use glam::{DQuat, DVec3};

use super::antialias::Antialias;
use super::eye::EyeMemory;
use super::passes::render_eyes;
use super::{FrameInputs, Renderer, drawn_lines, prepare};
use crate::composite::temporal_aa::Plan;
use crate::gpu::pipelines::Builds;
use crate::gpu::pools::KEEP_FRAMES;
use crate::gpu::recorder::Recorder;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::StrokeMemory;
use crate::scene::Light;
use crate::scene::view::{Part, Pose, Rig, View};
use crate::style::Style;
use crate::surface::land::vertices::PatchMesh;
use crate::surface::rows::RowPlan;
use crate::tiles::selection::Selection;
use crate::tiles::terrain::Prepared;
use crate::world::Surfaces;

/// Pictures of a prewarming run are this large: nothing is drawn on them.
const PREWARM_PX: [u32; 2] = [16, 16];
/// A turn by this part of the field of view brings strokes that take over from those before.
const TURN: f64 = 0.25;

/// Which style is drawn while another one is asked for.
#[derive(Default)]
pub(super) struct Switch {
    shown: Option<Style>,
    /// What prewarming runs keep for each eye. It is kept for a while after a switch, because a slider changes the style
    /// in each frame.
    prewarm: Option<Vec<EyeMemory>>,
    frames_since_switch: u64,
    /// Whether something was being made in the background when this was last looked at.
    was_building: bool,
    /// How many pipelines of the device had been compiled again when this renderer last looked.
    seen_rebuilds: u64,
}

impl Switch {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { seen_rebuilds: gpu.pipelines().rebuilds(), ..Self::default() }
    }
}

impl Renderer {
    /// Where pipelines are built, and what else takes long to make. [`Builds::InBackground`] is for windows: a frame then
    /// never waits for them, and [`Renderer::render`] draws the style before until all is there.
    pub fn set_builds(&mut self, builds: Builds) {
        self.pools.compiles.builds = builds;
    }

    /// Whether something is being made beside: when it is there, the picture may be another one.
    pub fn is_building(&self, gpu: &Gpu) -> bool {
        gpu.pipelines().is_building() || gpu.cache().is_making()
    }

    /// Takes what was made beside; waits for nothing.
    pub fn take_built(&mut self, gpu: &Gpu) {
        // Another renderer of the device may take over what was compiled for this one.
        self.switch.was_building |= self.is_building(gpu);
        gpu.pipelines().take_built();
        gpu.cache().take_made();
        if self.switch.was_building && !self.is_building(gpu) {
            self.switch.was_building = false;
            // What was drawn before is another picture.
            self.samples.forget();
        }
    }

    /// Whether the last picture is of `style`.
    pub fn shows(&self, style: &Style) -> bool {
        self.switch.shown.as_ref() == Some(style)
    }

    /// Whether the last frame drew new pictures. If not, it lacked what is built beside, and the pictures are those of
    /// before.
    pub fn drew(&self) -> bool {
        self.drew
    }

    /// How many pipelines the thread that draws has built itself.
    pub fn built_at_once(&self) -> u64 {
        self.pools.compiles.built_at_once
    }

    /// Builds anew what is made of shaders whose files have changed since the last call, and returns how many pipelines
    /// that are. Each replaces the old one when it holds; errors are in [`Pipelines::shader_errors`](crate::gpu::pipelines::Pipelines::shader_errors).
    pub fn reload_shaders(&mut self, gpu: &Gpu) -> usize {
        gpu.pipelines().reload(gpu, &mut self.pools.compiles);
        let rebuilds = gpu.pipelines().rebuilds();
        let reloaded = rebuilds - std::mem::replace(&mut self.switch.seen_rebuilds, rebuilds);
        if reloaded > 0 {
            self.samples.forget();
        }
        reloaded as usize
    }

    /// As [`Renderer::render`], without waiting for what is built beside.
    pub(super) fn render_what_is_there(
        &mut self,
        gpu: &Gpu,
        world: &mut Surfaces,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<Prepared, GpuError> {
        self.take_built(gpu);
        let begun = Instant::now();
        if !self.shows(style) && self.prewarm(gpu, world, rig, style, light)? {
            self.switch.shown = Some(style.clone());
            self.switch.frames_since_switch = 0;
        }
        self.switch.frames_since_switch += 1;
        if self.switch.frames_since_switch > KEEP_FRAMES && self.shows(style) {
            self.switch.prewarm = None;
        }
        let rehearsal_ms = begun.elapsed().as_secs_f64() * 1000.0;
        self.record_ms = rehearsal_ms;
        self.drew = false;
        let Some(shown) = self.switch.shown.take() else {
            // Tiles come meanwhile.
            return Ok(prepare(gpu, world, rig, style, light));
        };
        let prepared = prepare(gpu, world, rig, &shown, light);
        let drawn = self.record(gpu, world, &prepared, rig, &shown, light);
        self.switch.shown = Some(shown);
        self.record_ms += rehearsal_ms;
        if !drawn? {
            // As if it had not been: its strokes begin anew, and its maps are made by another frame.
            self.forget();
            world.terrain.forget_planned_maps();
        }
        Ok(prepared)
    }

    /// Whether all is there that the first frames of a style need; what is not begins to be built.
    fn prewarm(
        &mut self,
        gpu: &Gpu,
        world: &mut Surfaces,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<bool, GpuError> {
        if style.needs_horizons() {
            world.terrain.map_horizons(gpu, Some(light.to_sun));
        }
        if style.water().is_some() {
            let sea_level_m = world.sea_level_m();
            world.terrain.map_water(gpu, Some(sea_level_m));
        }
        let memories = self.switch.prewarm.get_or_insert_default();
        memories.resize_with(rig.eyes.len(), EyeMemory::default);
        memories.iter_mut().filter_map(|memory| memory.strokes.as_mut()).for_each(StrokeMemory::forget);
        let lines = drawn_lines(world, style);
        let lines = lines.as_deref();
        let mut is_complete = true;
        for eyes in first_frames(&rig.eyes) {
            for (memory, view) in memories.iter_mut().zip(&eyes) {
                memory.begin_frame(gpu, view, style)?;
            }
            let rig = &Rig { eyes, ..*rig };
            let mut recorder = Recorder::prewarm(gpu, &mut self.pools, &mut self.timer);
            let mesh = &PatchMesh::upload(&mut recorder, &Selection::default());
            let (step_s, land_changes) = (self.step_s, false);
            let (wants_motion, wants_mark_layers) = (self.wants_motion, self.wants_mark_layers);
            let temporal_aa = (self.samples.antialias == Antialias::Temporal).then(Plan::default);
            let hidden = &self.hidden;
            let rows = style.rows().map(|_| RowPlan::prewarm(gpu));
            let inputs = FrameInputs {
                world,
                mesh,
                rig,
                style,
                lines,
                light,
                step_s,
                land_changes,
                wants_motion,
                wants_mark_layers,
                hidden,
                rows: rows.as_ref(),
                temporal_aa,
            };
            render_eyes(&mut recorder, &inputs, memories);
            is_complete &= recorder.is_complete();
        }
        Ok(is_complete)
    }
}

/// The eyes in the first frame of a style, in the next one, and in one after a turn.
fn first_frames(eyes: &[View]) -> [Vec<View>; 3] {
    let frame = |turn_rad: f64| {
        let turn = DQuat::from_axis_angle(DVec3::Z, turn_rad);
        let turned =
            |pose: Pose| Pose { forward: turn * pose.forward, right: turn * pose.right, up: turn * pose.up, ..pose };
        let small = |view: &View| {
            let (previous, pose) = (view.pose, turned(view.pose));
            View { pose, previous, picture_px: PREWARM_PX, part: Part::whole(PREWARM_PX), ..*view }
        };
        eyes.iter().map(small).collect()
    };
    [frame(0.0), frame(0.0), frame(TURN * eyes[0].fov_rad())]
}
