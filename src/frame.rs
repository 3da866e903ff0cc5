//! Draws a frame: surface → lines and tones → composite, for each eye of a rig.
//!
//! `src/frame_passes.md` lists the passes with what each reads and writes. The window, files and measurements all draw
//! with [`Renderer::render`]. Passes are functions and own nothing: pipelines and cached values belong to the device,
//! buffers and uniforms come from the renderer's pools, which all eyes share, and pictures and strokes belong to the
//! memory of an eye. Resources are created when a pass first requests them, and released when none has for a while.

mod antialias;
mod bend;
mod dry;
mod eye;
mod land_maps;
mod in_use;
mod inks;
mod line_gaps;
mod lines;
mod mark_sets;
mod passes;
mod results;
mod rows;
mod shade;
mod surface_readback;
mod switch;
mod tones;
mod trees;
mod water;

use std::borrow::Cow;
use std::time::Instant;

pub use self::antialias::Antialias;
#[cfg(test)]
pub(crate) use self::antialias::SAMPLES_AT_REST;
pub(crate) use self::eye::EyeMemory;
pub use self::line_gaps::LineGap;
#[cfg(test)]
pub(crate) use self::results::DrawnMeshCounts;
pub(crate) use self::surface_readback::SeenDistances;
pub use crate::composite::PICTURE;
use crate::composite::temporal_aa;
use crate::gpu::finite::NonFinite;
use crate::gpu::pipelines::Builds;
use crate::gpu::pools::Pools;
use crate::gpu::recorder::{Recorder, Submits};
use crate::gpu::timer::Timer;
use crate::gpu::trace::PassTrace;
use crate::gpu::{Gpu, GpuError};
use crate::imagery::ResidentImagery;
use crate::lines::strokes;
pub use crate::scene::Light;
use crate::scene::view::{Rig, View};
use crate::style::{self, Lines, Style};
pub use crate::surface::DISTANCE;
use crate::surface::hidden::HiddenArea;
use crate::surface::lakes;
use crate::surface::land::vertices::PatchMesh;
use crate::surface::rows::RowPlan;
use crate::surface::rows::blocks::RowMemory;
#[cfg(test)]
use crate::surface::rows::reach::Culling;
pub use crate::tiles::terrain::Prepared;
use crate::tiles::terrain::{Loading, TerrainView};
use crate::tones::fit::FrameFit;
use crate::tones::masses::FrameMasses;
use crate::world::Surfaces;

/// Returns the view for which the terrain selects tiles and patches, once for all eyes of a rig. The horizon is
/// `horizon_rad` below level; 0 means the earth's own curvature.
pub(crate) fn terrain_view_of(rig: &Rig, horizon_rad: f64) -> TerrainView {
    TerrainView {
        camera_m: rig.origin_m,
        frusta: rig.eyes.iter().map(View::frustum).collect(),
        focal_px: rig.eyes.iter().map(View::focal_px).fold(0.0, f64::max),
        pixels: rig.eyes.iter().map(|eye| eye.part.size_px.map(f64::from).iter().product::<f64>()).sum(),
        horizon_rad,
    }
}

/// Prepares the world for a rig's next frame: loads tiles, selects patches, and plans the horizon and water maps that
/// the style needs.
pub fn prepare(gpu: &Gpu, world: &mut Surfaces, rig: &Rig, style: &Style, light: &Light) -> Prepared {
    let sea_level_m = world.sea_level_m();
    let terrain = &mut world.terrain;
    terrain.map_water(gpu, style.water().map(|_| sea_level_m));
    terrain.map_horizons(gpu, style.needs_horizons().then_some(light.to_sun));
    let prepared = terrain.prepare(gpu, &terrain_view_of(rig, style.panorama.horizon_rad()));
    world.follow_drainage(gpu, rig, style);
    world.follow_features(gpu, rig, style);
    world.follow_imagery(gpu, rig, style);
    prepared
}

/// Returns the detected lines that a style draws. A style with strokes but no detected lines draws them on trees only.
fn drawn_lines<'a>(world: &Surfaces, style: &'a Style) -> Option<Cow<'a, Lines>> {
    let of_trees = || world.forest().and(style.strokes()).map(Lines::of_trees).map(Cow::Owned);
    style.lines().map(Cow::Borrowed).or_else(of_trees)
}

/// Returns the light and haze of a rig's frame, thinned by the height of the eyes, with the focus of the scene, or else
/// that of the style, relative to the rig's origin.
pub(crate) fn seen_light(world: &Surfaces, rig: &Rig, style: &Style, light: &Light) -> Light {
    let terrain = &world.terrain;
    let earth = terrain.earth_curvature(rig.origin_m.z);
    let focus = light.focus.or_else(|| style.focus.as_ref().map(style::Focus::seen));
    let focus = focus.map(|focus| focus.seen_from(rig.origin_m, |flat_m| earth.bend(flat_m)));
    Light { focus, ..light.for_eye_above(rig.origin_m.z - f64::from(terrain.range_m()[1])) }
}

/// Default time from one frame to the next, in seconds.
const STEP_S: f64 = 1.0 / 30.0;

/// Draws frames. It holds the resources that frames share and the history of each eye.
pub struct Renderer {
    pools: Pools,
    eyes: Vec<EyeMemory>,
    timer: Timer,
    /// Time from one frame to the next, in seconds.
    step_s: f64,
    /// Shortest time between two rebuilds of the strokes while the camera moves, in seconds.
    stroke_pause_s: f64,
    submits: Submits,
    /// The sea of the last frame; `None` before the first.
    sea_level_m: Option<Option<f64>>,
    /// Whether frames write the motion of each pixel even if the style does not need it.
    wants_motion: bool,
    /// Whether frames draw surface ids even if the world is only land.
    wants_ids: bool,
    /// Whether frames also draw each set of hatching marks separately.
    wants_mark_sets: bool,
    /// Whether frames end when their strokes are drawn.
    only_strokes: bool,
    /// Size of the largest picture for which textures have room.
    room_px: Option<[u32; 2]>,
    /// The hidden area of each eye; eyes beyond its end have none.
    hidden: Vec<HiddenArea>,
    samples: antialias::Samples,
    /// Whether trees that wind moves may be in view of the last frame.
    may_sway: bool,
    /// The blocks of rows of hachures that have been built.
    rows: RowMemory,
    /// Numbers that are not finite in pictures of checked frames.
    non_finite: Vec<NonFinite>,
    /// The traces of the last frame's passes, if frames are traced.
    trace: Option<Vec<PassTrace>>,
    /// CPU time of the last frame.
    cpu: FrameCpu,
    /// Whether the last frame was submitted.
    drew: bool,
    switch: switch::Switch,
    /// The views that are known to be without water.
    dry: dry::DryViews,
    tones: tones::Tones,
    /// The gaps of contour lines in the next frames.
    line_gaps: Vec<LineGap>,
    /// Whether streams and ridge lines were being computed for the last frame, and how often some had arrived.
    drainage_is_late: bool,
    /// Whether tiles of images on the land were missing or fading in, in the last frame.
    imagery_is_late: bool,
    drainage_arrivals: u64,
}

/// CPU time that a frame takes of the thread that draws it, without the time for tiles and patches
/// ([`Prepared::prepare_ms`]) and without waiting for the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FrameCpu {
    /// Time to record the passes and to encode them for the driver, in milliseconds.
    pub record_ms: f64,
    /// Time to upload uniforms and to submit, in milliseconds. It is meaningless if each pass of a software driver was
    /// submitted and waited for separately.
    pub submit_ms: f64,
}

/// The inputs that the passes of all eyes share.
struct FrameInputs<'a> {
    world: &'a Surfaces,
    mesh: &'a PatchMesh,
    rig: &'a Rig,
    style: &'a Style,
    /// The detected lines to draw; only those of trees if the style has strokes instead.
    lines: Option<&'a Lines>,
    light: &'a Light,
    /// Time since the previous frame, in seconds; 0 between samples of a picture at rest.
    step_s: f64,
    /// Shortest time between two rebuilds of the strokes while the camera moves, in seconds.
    stroke_pause_s: f64,
    /// Whether tiles of this view have arrived or are missing.
    land_changes: bool,
    wants_motion: bool,
    wants_ids: bool,
    wants_mark_sets: bool,
    /// Whether the frame ends when its strokes are drawn.
    only_strokes: bool,
    hidden: &'a [HiddenArea],
    /// Whether the view is known to have no water.
    is_dry: bool,
    /// The blocks of rows to build and draw, in a style with rows of hachures.
    rows: Option<&'a RowPlan>,
    /// How the frame continues the temporal mean; `None` without temporal anti-aliasing.
    temporal_aa: Option<temporal_aa::Plan>,
    /// The curve that fits the tones to the picture, in a style that does so.
    fit: Option<FrameFit>,
    /// The edited masses of stepped tones, in a style that edits them and a frame that can.
    masses: Option<FrameMasses>,
    /// The gaps of contour lines.
    line_gaps: &'a [LineGap],
}

impl Renderer {
    /// Creates a renderer that has drawn nothing yet.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the GPU timer cannot be created.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            pools: Pools::new(gpu),
            eyes: Vec::new(),
            timer: Timer::new(gpu)?,
            step_s: STEP_S,
            stroke_pause_s: 0.0,
            submits: Submits::default(),
            sea_level_m: None,
            wants_motion: false,
            wants_ids: false,
            wants_mark_sets: false,
            only_strokes: false,
            room_px: None,
            hidden: Vec::new(),
            samples: antialias::Samples::default(),
            may_sway: false,
            rows: RowMemory::default(),
            non_finite: Vec::new(),
            trace: None,
            cpu: FrameCpu::default(),
            drew: false,
            switch: switch::Switch::new(gpu),
            dry: dry::DryViews::default(),
            tones: tones::Tones::default(),
            line_gaps: Vec::new(),
            drainage_is_late: false,
            imagery_is_late: false,
            drainage_arrivals: 0,
        })
    }

    /// Returns the renderer, and creates it first if there is none.
    ///
    /// # Errors
    /// The errors of [`Renderer::new`].
    pub(crate) fn or_new<'a>(renderer: &'a mut Option<Self>, gpu: &Gpu) -> Result<&'a mut Self, GpuError> {
        if renderer.is_none() {
            *renderer = Some(Self::new(gpu)?);
        }
        Ok(renderer.as_mut().unwrap_or_else(|| unreachable!("it was just created")))
    }

    /// Sets the time from each frame to the next, in seconds, by which strokes fade in and out. The default is 1/30.
    pub fn set_step_s(&mut self, step_s: f64) {
        self.step_s = step_s.max(0.0);
    }

    /// Returns the time from each frame to the next, in seconds.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Discards the history: the next frame rebuilds its strokes, and does not continue the temporal mean.
    pub fn forget(&mut self) {
        self.samples.forget();
        self.tones.forget();
        self.eyes.iter_mut().filter_map(|eye| eye.strokes.as_mut()).for_each(strokes::StrokeMemory::forget);
    }

    /// Sets how the passes of a frame are submitted: [`Submits::Timed`] to measure each pass, [`Submits::Checked`] to
    /// search what each pass writes for NaN and infinity ([`Renderer::take_non_finite`]).
    pub(crate) fn set_submits(&mut self, submits: Submits) {
        self.submits = submits;
    }

    /// Sets the tag that is taken with the times of the next frames ([`Renderer::take_tagged_times`]).
    pub(crate) fn set_frame_tag(&mut self, tag: u64) {
        self.timer.tag = tag;
    }

    /// Sets whether frames write [`MOTION`](crate::surface::motion::MOTION), which otherwise only temporal
    /// anti-aliasing needs.
    pub(crate) fn set_wants_motion(&mut self, wants_motion: bool) {
        self.wants_motion = wants_motion;
    }

    /// Sets whether frames write [`SURFACE_ID`](crate::surface::SURFACE_ID), which a world that is only land does not
    /// need.
    pub(crate) fn set_wants_ids(&mut self, wants_ids: bool) {
        self.wants_ids = wants_ids;
    }

    /// Plants an error: every view counts as one without water.
    #[cfg(test)]
    pub(crate) fn assume_dry(&mut self) {
        self.dry.assumed = true;
    }

    /// Sets how blocks of rows that are out of view are culled.
    #[cfg(test)]
    pub(crate) fn set_row_culling(&mut self, culling: Culling) {
        self.rows.culling = culling;
    }

    /// Returns how many blocks of rows the last frame may have drawn.
    #[cfg(test)]
    pub(crate) fn row_blocks(&self) -> usize {
        self.rows.seen().len()
    }

    /// Sets whether each set of hatching marks is also drawn separately, for [`Renderer::mark_set`].
    pub(crate) fn set_wants_mark_sets(&mut self, wants_mark_sets: bool) {
        self.wants_mark_sets = wants_mark_sets;
    }

    /// Sets whether frames end when their strokes are drawn, and have no picture. The strokes of the next frame
    /// continue them as those of complete frames.
    pub(crate) fn set_only_strokes(&mut self, only_strokes: bool) {
        self.only_strokes = only_strokes;
    }

    /// Sets the shortest time between two rebuilds of the strokes while the camera moves, in seconds; 0 by default. A style
    /// may have a longer one.
    pub(crate) fn set_stroke_pause_s(&mut self, pause_s: f64) {
        self.stroke_pause_s = pause_s;
    }

    /// Sets the size of the largest pictures, in pixels, for which the textures of each eye have room. Pictures of other
    /// sizes then need no new textures, and strokes and the temporal mean continue when the size changes. With `None`,
    /// the default, textures are as large as pictures, and strokes and the mean begin again in another size.
    pub(crate) fn set_room(&mut self, room_px: Option<[u32; 2]>) {
        self.room_px = room_px;
    }

    /// Sets the number of the next frame in its film, from which the points that temporal anti-aliasing samples follow.
    pub(crate) fn begin_at(&mut self, frame: u64) {
        self.samples.begin_at(frame);
    }

    /// Sets the area of each eye's picture that is hidden and not drawn. An eye beyond the end of the list has none.
    pub(crate) fn set_hidden(&mut self, hidden: Vec<HiddenArea>) {
        self.hidden = hidden;
    }

    /// Sets how frames are anti-aliased. With [`Antialias::Temporal`], a frame continues the mean only if each view
    /// continues the one that the last frame drew ([`View::previous`]); otherwise it starts a new mean.
    pub fn set_antialias(&mut self, antialias: Antialias) {
        self.samples.antialias = antialias;
    }

    /// Returns how frames are anti-aliased.
    pub fn antialias(&self) -> Antialias {
        self.samples.antialias
    }

    /// Returns `rig` with the jitter of the next frame's sample. [`Renderer::render_eyes`] applies it; callers of
    /// [`prepare`] and [`Renderer::render_rig`] pass this rig to both.
    pub(crate) fn jittered(&self, rig: &Rig, style: &Style) -> Rig {
        let jitter_px = self.samples.jitter_px(rig, style, self.has_settling_strokes());
        let eyes = rig.eyes.iter().map(|eye| View { jitter_px: eye.jitter_px + jitter_px, ..*eye });
        Rig { eyes: eyes.collect(), ..*rig }
    }

    /// Sets whether frames are traced from the next one on: what each pass reads and writes.
    pub(crate) fn set_traces(&mut self, traces: bool) {
        self.trace = traces.then(Vec::new);
    }

    /// Returns the passes of the last frame in the order in which they ran; none unless frames are traced.
    pub(crate) fn trace(&self) -> &[PassTrace] {
        self.trace.as_deref().unwrap_or_default()
    }

    /// Prepares the world and renders the view of one eye. Its pictures are complete when the GPU has finished. If
    /// pipelines are built in the background ([`Renderer::set_builds`]), the frame may be of the previous style.
    ///
    /// # Errors
    /// [`GpuError::Limit`] if a picture or a buffer is larger than the device allows, [`GpuError::Shader`] if a shader
    /// is invalid.
    pub fn render(
        &mut self,
        gpu: &Gpu,
        world: &mut Surfaces,
        view: &View,
        style: &Style,
        light: &Light,
    ) -> Result<Prepared, GpuError> {
        self.render_eyes(gpu, world, &Rig::mono(*view), style, light)
    }

    /// Prepares the world and renders all eyes of a rig, as [`Renderer::render`] does for one.
    ///
    /// # Errors
    /// The errors of [`Renderer::render`].
    pub fn render_eyes(
        &mut self,
        gpu: &Gpu,
        world: &mut Surfaces,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<Prepared, GpuError> {
        let rig = &self.jittered(rig, style);
        if self.pools.compiles.builds == Builds::InBackground {
            return self.render_without_waiting(gpu, world, rig, style, light);
        }
        let prepared = prepare(gpu, world, rig, style, light);
        self.render_rig(gpu, world, &prepared, rig, style, light)?;
        Ok(prepared)
    }

    /// Renders one frame of all eyes of a rig, for which [`prepare`] has prepared `world`.
    ///
    /// # Errors
    /// The errors of [`Renderer::render`].
    pub fn render_rig(
        &mut self,
        gpu: &Gpu,
        world: &Surfaces,
        prepared: &Prepared,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<(), GpuError> {
        let begun = Instant::now();
        self.build_together(gpu, world, rig, style, light)?;
        let build_ms = begun.elapsed().as_secs_f64() * 1000.0;
        let is_drawn = self.record(gpu, world, prepared, rig, style, light)?;
        self.cpu.record_ms += build_ms;
        if is_drawn {
            return Ok(());
        }
        // A pipeline is missing, so nothing was drawn: its shader is invalid, or it is still being built.
        let error = gpu.pipelines().shader_errors().into_iter().next();
        error.map_or(Ok(()), |error| Err(GpuError::Shader(error)))
    }

    /// Notes a frame of a style in the resources that have a history of their own, and releases those that no style has
    /// needed for a while.
    fn skip_unused(&mut self, style: &Style) {
        if style.rows().is_none() {
            self.rows.skip();
        }
        if style.water().is_none() {
            self.dry.skip();
        }
    }

    /// Records and submits a frame. Returns `false`, and submits nothing, if a pipeline or a cached value is still
    /// being built.
    fn record(
        &mut self,
        gpu: &Gpu,
        world: &Surfaces,
        prepared: &Prepared,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<bool, GpuError> {
        self.drew = false;
        self.eyes.resize_with(rig.eyes.len(), EyeMemory::default);
        let mut resized = false;
        for (memory, view) in self.eyes.iter_mut().zip(&rig.eyes) {
            resized |= memory.begin_frame(gpu, view, style, self.room_px)?;
            memory.view = Some(view.uniform(rig.origin_m));
        }
        if resized {
            // Bind groups refer to the pictures of the old size.
            self.pools.groups.clear();
        }
        let begun = Instant::now();
        let water_maps = style.water().and_then(|_| world.terrain.water_maps_in_view());
        let is_dry = water_maps.as_ref().is_some_and(|maps| self.dry.is_dry(maps));
        self.skip_unused(style);
        let strokes_settle = self.has_settling_strokes();
        let light = &seen_light(world, rig, style, light);
        let mut recorder = Recorder::new(gpu, &mut self.pools, &mut self.timer, self.submits, self.trace.is_some());
        let mesh = &PatchMesh::upload(&mut recorder, &prepared.selection);
        let (wants_motion, wants_mark_sets) = (self.wants_motion, self.wants_mark_sets);
        let wants_ids = self.wants_ids;
        let only_strokes = self.only_strokes;
        let sea_level_m = world.sea_level_m();
        self.drainage_is_late = world.drainage().is_under_way();
        let arrivals = world.drainage().arrivals();
        let drainage_changes =
            std::mem::replace(&mut self.drainage_arrivals, arrivals) != arrivals || self.drainage_is_late;
        let imagery = world.imagery().filter(|_| style.image.is_used());
        self.imagery_is_late = imagery.is_some_and(ResidentImagery::is_late);
        let imagery_changes = imagery.is_some_and(ResidentImagery::changes);
        let sea_changes = self.sea_level_m.replace(sea_level_m).is_some_and(|before| before != sea_level_m);
        let land_changes = prepared.tiles.loaded > 0 || prepared.tiles.late || sea_changes;
        // This is known of the last frame's view only. A different view is not at rest anyway.
        let sways = self.may_sway && !rig.clock().is_still();
        let changes =
            land_changes || strokes_settle || sways || self.tones.is_settling() || drainage_changes || imagery_changes;
        let error_px = prepared.detail.error_px;
        let has_room = self.room_px.is_some() && !resized;
        let inputs = antialias::SampleInputs { rig, style, light, error_px, changes, has_room };
        let temporal_aa = self.samples.plan(&inputs);
        // No time passes between samples of a picture at rest, so strokes do not fade between them.
        let step_s = if self.samples.rests() { 0.0 } else { self.step_s };
        let fit = self.tones.frame(&mut recorder, &tones::TonesInputs { rig, style, light, step_s, land_changes });
        let masses = self.tones.masses(&mut recorder, rig, style);
        let hidden = &self.hidden;
        let lines = drawn_lines(world, style);
        let lines = lines.as_deref();
        let all_tiles = !land_changes || world.terrain.options().loading == Loading::Wait;
        let rows =
            style.rows().map(|rows| self.rows.plan(gpu, &world.terrain, &prepared.selection, rig, rows, all_tiles));
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
            only_strokes,
            hidden,
            is_dry,
            rows: rows.as_ref(),
            temporal_aa,
            fit,
            masses,
            line_gaps: &self.line_gaps,
        };
        self.may_sway = passes::render_eyes(&mut recorder, &inputs, &mut self.eyes);
        let is_complete = recorder.is_complete();
        let submitted = recorder.submit()?;
        self.trace = submitted.trace.filter(|_| self.trace.is_some());
        self.non_finite.extend(submitted.non_finite);
        let submit_ms = submitted.submit_ms;
        self.cpu = FrameCpu { record_ms: begun.elapsed().as_secs_f64() * 1000.0 - submit_ms, submit_ms };
        self.drew = is_complete;
        if is_complete {
            if let Some(maps) = water_maps.filter(|_| !is_dry) {
                let found = self.pools.buffers.get(&lakes::seen::ARGUMENTS);
                self.dry.request(gpu, maps, found.as_ref());
            }
            self.measure_trace(gpu, world)?;
        } else {
            self.rows.forget_planned();
        }
        Ok(is_complete)
    }
}
