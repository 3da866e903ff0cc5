//! Switches of the style in a window, without waiting: the old style is drawn until all pipelines and cached values of
//! the new one are available.
//!
//! There is no list of them. Instead the frame is prewarmed: its passes run with a recorder that only requests
//! pipelines and values ([`Recorder::prewarm`]), as the first frame of a style, as the next one at rest, and as one
//! after a turn, because strokes run other passes in each. If the prewarming run has not requested something that a
//! frame needs, it is missing when the frame is recorded; such a frame is not submitted, and the last picture remains.
//!
//! Why: `docs/decisions/pipelines-in-background.md`.

use std::time::Instant;

use glam::{DQuat, DVec3};

use super::antialias::Antialias;
use super::eye::EyeMemory;
use super::passes::render_eyes;
use super::{FrameCpu, FrameInputs, Renderer, drawn_lines, prepare};
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
use crate::tones::fit::{FitMemory, Follows};
use crate::tones::masses::FrameMasses;
use crate::world::Surfaces;

/// Size of the pictures of a prewarming run, in pixels. Nothing is drawn on them.
const PREWARM_PX: [u32; 2] = [16, 16];
/// A turn, as a fraction of the field of view, after which strokes are rebuilt and continue those of the last frame.
const TURN: f64 = 0.25;

/// The state of the switch from one style to another.
#[derive(Default)]
pub(super) struct Switch {
    /// The style that frames are drawn with.
    shown: Option<Style>,
    /// The memory of each eye in prewarming runs. It is released some time after a switch, because a slider changes the
    /// style in every frame.
    prewarm: Option<Vec<EyeMemory>>,
    /// Name of the style whose pipelines have been compiled together ([`Renderer::build_together`]). An edited style
    /// has the same name, and needs few other pipelines or none.
    built: Option<String>,
    frames_since_switch: u64,
    /// Whether something was being built in the background at the last check.
    was_building: bool,
    /// Number of pipelines of the device that had been rebuilt at the last call of [`Renderer::reload_shaders`].
    seen_rebuilds: u64,
}

impl Switch {
    /// Creates the state of a renderer that shows no style yet.
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { seen_rebuilds: gpu.pipelines().rebuilds(), ..Self::default() }
    }
}

impl Renderer {
    /// Sets where pipelines and expensive cached values are built. [`Builds::InBackground`] is for windows: no frame
    /// waits for them, and [`Renderer::render`] draws the previous style until all are available.
    pub(crate) fn set_builds(&mut self, builds: Builds) {
        self.pools.compiles.builds = builds;
    }

    /// Requests the pipelines of a style that may be selected later. They are compiled one after another while nothing
    /// that is needed is ([`Renderer::take_built`]). Values are not made: they would be released before they are used.
    ///
    /// # Errors
    /// The errors of [`Renderer::render`].
    pub(crate) fn request_spares(
        &mut self,
        gpu: &Gpu,
        world: &Surfaces,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<(), GpuError> {
        let compiles = self.pools.compiles;
        let memories = self.switch.prewarm.take();
        self.pools.compiles.builds = Builds::Spare;
        let requested = self.prewarm_frames(gpu, world, rig, style, light, first_frames(&rig.eyes));
        self.pools.compiles = compiles;
        self.switch.prewarm = memories;
        gpu.pipelines().keep_spares();
        requested.map(|_| ())
    }

    /// Returns whether pipelines of other styles are still to be compiled.
    pub(crate) fn has_spares(&self, gpu: &Gpu) -> bool {
        gpu.pipelines().has_spares()
    }

    /// Returns whether something is being built in the background. When it is available, the picture may change.
    pub(crate) fn is_building(&self, gpu: &Gpu) -> bool {
        gpu.pipelines().is_building() || gpu.cache().is_making()
    }

    /// Takes the pipelines and values that have been built in the background. Does not wait.
    pub(crate) fn take_built(&mut self, gpu: &Gpu) {
        // Another renderer of the device may have taken pipelines that were compiled for this one.
        self.switch.was_building |= self.is_building(gpu);
        gpu.pipelines().take_built();
        gpu.cache().take_made();
        if !self.is_building(gpu) {
            gpu.pipelines().build_spare(gpu);
        }
        if self.switch.was_building && !self.is_building(gpu) {
            self.switch.was_building = false;
            // Earlier frames may have lacked what has been built, so they are not samples of the same picture.
            self.samples.forget();
        }
    }

    /// Returns whether the switch to `style` is complete, if pipelines are built in the background.
    pub(crate) fn shows(&self, style: &Style) -> bool {
        self.switch.shown.as_ref() == Some(style)
    }

    /// Returns whether the last frame drew new pictures. If not, it lacked something that is being built in the
    /// background, and the pictures are those of an earlier frame.
    pub(crate) fn drew(&self) -> bool {
        self.drew
    }

    /// Returns how many pipelines the frame thread has built itself.
    #[cfg(test)]
    pub(crate) fn built_at_once(&self) -> u64 {
        self.pools.compiles.built_at_once
    }

    /// Rebuilds the pipelines whose shader files have changed since the last call, and returns how many were rebuilt. A
    /// new pipeline replaces the old one if it is valid; errors are in
    /// [`Pipelines::shader_errors`](crate::gpu::pipelines::Pipelines::shader_errors).
    pub(crate) fn reload_shaders(&mut self, gpu: &Gpu) -> usize {
        gpu.pipelines().reload(gpu, &mut self.pools.compiles);
        let rebuilds = gpu.pipelines().rebuilds();
        let reloaded = rebuilds - std::mem::replace(&mut self.switch.seen_rebuilds, rebuilds);
        if reloaded > 0 {
            self.samples.forget();
        }
        reloaded as usize
    }

    /// Prepares the world and renders all eyes of a rig without waiting for pipelines: with `style` if all of them are
    /// available, otherwise with the previous style.
    ///
    /// # Errors
    /// The errors of [`Renderer::render`].
    pub(super) fn render_without_waiting(
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
        let prewarm_ms = begun.elapsed().as_secs_f64() * 1000.0;
        self.cpu = FrameCpu { record_ms: prewarm_ms, submit_ms: 0.0 };
        self.drew = false;
        let Some(shown) = self.switch.shown.take() else {
            // There is no style to draw yet, but tiles can already be loaded. Nothing computes the maps of this frame.
            let prepared = prepare(gpu, world, rig, style, light);
            world.terrain.forget_planned_maps();
            return Ok(prepared);
        };
        let prepared = prepare(gpu, world, rig, &shown, light);
        let drawn = self.record(gpu, world, &prepared, rig, &shown, light);
        self.switch.shown = Some(shown);
        self.cpu.record_ms += prewarm_ms;
        if !drawn? {
            // The frame is undone: the next one rebuilds its strokes and computes its maps.
            self.forget();
            world.terrain.forget_planned_maps();
        }
        Ok(prepared)
    }

    /// Requests everything that the first frames of a style need. Returns whether all of it is available; the rest is
    /// being built.
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
        self.prewarm_frames(gpu, world, rig, style, light, first_frames(&rig.eyes))
    }

    /// Compiles what the first frame of a style needs on all cores, if pipelines are built at once. Without it, each
    /// pass would compile its own pipeline while the other passes wait.
    ///
    /// # Errors
    /// The errors of [`Renderer::render`].
    pub(super) fn build_together(
        &mut self,
        gpu: &Gpu,
        world: &Surfaces,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<(), GpuError> {
        if self.pools.compiles.builds != Builds::AtOnce
            || rig.eyes.is_empty()
            || self.switch.built.as_ref() == Some(&style.name)
        {
            return Ok(());
        }
        self.switch.built = Some(style.name.clone());
        let counts = self.pools.compiles.counts;
        self.pools.compiles.builds = Builds::Collected;
        let [first, ..] = first_frames(&rig.eyes);
        let collected = self.prewarm_frames(gpu, world, rig, style, light, [first]);
        self.pools.compiles.builds = Builds::AtOnce;
        self.switch.prewarm = None;
        collected?;
        gpu.pipelines().build_collected(gpu, &mut self.pools.compiles);
        self.pools.compiles.counts = counts;
        Ok(())
    }

    /// Requests what frames with these eyes need. Returns whether all of it is available.
    fn prewarm_frames(
        &mut self,
        gpu: &Gpu,
        world: &Surfaces,
        rig: &Rig,
        style: &Style,
        light: &Light,
        frames: impl IntoIterator<Item = Vec<View>>,
    ) -> Result<bool, GpuError> {
        let memories = self.switch.prewarm.get_or_insert_default();
        memories.resize_with(rig.eyes.len(), EyeMemory::default);
        memories.iter_mut().filter_map(|memory| memory.strokes.as_mut()).for_each(StrokeMemory::forget);
        let lines = drawn_lines(world, style);
        let lines = lines.as_deref();
        let mut is_complete = true;
        for eyes in frames {
            for (memory, view) in memories.iter_mut().zip(&eyes) {
                memory.begin_frame(gpu, view, style, self.room_px)?;
            }
            let rig = &Rig { eyes, ..*rig };
            let mut recorder = Recorder::prewarm(gpu, &mut self.pools, &mut self.timer);
            let mesh = &PatchMesh::upload(&mut recorder, &Selection::default());
            let (step_s, land_changes) = (self.step_s, false);
            let (wants_motion, wants_mark_sets) = (self.wants_motion, self.wants_mark_sets);
            let wants_ids = self.wants_ids;
            let temporal_aa = (self.samples.antialias == Antialias::Temporal).then(Plan::default);
            let hidden = &self.hidden;
            let rows = style.rows().map(|_| RowPlan::prewarm(gpu));
            let follows = Follows { begins: true, step_s };
            let fit = FitMemory::default().frame(&mut recorder, style, follows);
            let inputs = FrameInputs {
                world,
                mesh,
                rig,
                style,
                lines,
                light,
                step_s,
                stroke_pause_s: self.stroke_pause_s,
                land_changes,
                wants_motion,
                wants_ids,
                wants_mark_sets,
                only_strokes: self.only_strokes,
                hidden,
                is_dry: false,
                rows: rows.as_ref(),
                temporal_aa,
                fit,
                masses: FrameMasses::of(rig, style),
                line_gaps: &self.line_gaps,
            };
            render_eyes(&mut recorder, &inputs, memories);
            is_complete &= recorder.is_complete();
        }
        Ok(is_complete)
    }
}

/// Returns the eyes in the first frame of a style, in the next one at rest, and in one after a turn.
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
