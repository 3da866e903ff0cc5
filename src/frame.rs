//! A frame, from top to bottom: surface → lines and tones → composite, for each eye of a rig.
//!
//! `src/frame_passes.md` lists the passes with what each reads and writes. Window, files and measurements all come
//! through [`Renderer::render`]. Passes are functions and own nothing: pipelines, buffers and uniforms come from the pools
//! that all eyes share, pictures and strokes from the memory of the eye. What a style does not call is not made, and
//! what is not called any more goes.

mod antialias;
mod bend;
mod eye;
mod land_maps;
mod inks;
mod left;
mod lines;
mod mark_layers;
mod passes;
mod rows;
mod shade;
mod switch;
mod trees;
mod water;

use std::borrow::Cow;
use std::time::Instant;

pub use self::antialias::{Antialias, SAMPLES_AT_REST};
pub use self::eye::EyeMemory;
pub use self::left::DrawnMeshCounts;
pub use crate::composite::PICTURE;
use crate::composite::temporal_aa;
use crate::gpu::pipelines::Builds;
use crate::gpu::pools::Pools;
use crate::gpu::recorder::{Recorder, Submits};
use crate::gpu::timer::Timer;
use crate::gpu::trace::PassTrace;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes;
pub use crate::scene::Light;
use crate::scene::view::{Rig, View};
use crate::style::{self, Lines, Style};
pub use crate::surface::POSITION;
use crate::surface::hidden::HiddenArea;
use crate::surface::land::vertices::PatchMesh;
use crate::surface::rows::RowPlan;
use crate::surface::rows::blocks::RowMemory;
pub use crate::tiles::terrain::Prepared;
use crate::tiles::terrain::{Loading, TerrainView};
use crate::world::Surfaces;

/// What the terrain is asked for a view.
pub fn terrain_view(view: &View) -> TerrainView {
    terrain_view_of(&Rig::mono(*view), 0.0)
}

/// What the terrain is asked for all eyes of a rig: once. The horizon lies `horizon_rad` below level, or with 0 as the
/// earth has it.
pub fn terrain_view_of(rig: &Rig, horizon_rad: f64) -> TerrainView {
    TerrainView {
        camera_m: rig.origin_m,
        frusta: rig.eyes.iter().map(View::frustum).collect(),
        focal_px: rig.eyes.iter().map(View::focal_px).fold(0.0, f64::max),
        pixels: rig.eyes.iter().map(|eye| eye.part.size_px.map(f64::from).iter().product::<f64>()).sum(),
        horizon_rad,
    }
}

/// Tiles and patches of a rig's next frame, with the maps that the style's shadows and water ask for.
pub fn prepare(gpu: &Gpu, world: &mut Surfaces, rig: &Rig, style: &Style, light: &Light) -> Prepared {
    let sea_level_m = world.sea_level_m();
    let terrain = &mut world.terrain;
    terrain.map_water(gpu, style.water().map(|_| sea_level_m));
    terrain.map_horizons(gpu, style.needs_horizons().then_some(light.to_sun));
    terrain.prepare(gpu, &terrain_view_of(rig, style.panorama.horizon_rad()))
}

/// The lines of a style; in one that has strokes instead, those of trees.
fn drawn_lines<'a>(world: &Surfaces, style: &'a Style) -> Option<Cow<'a, Lines>> {
    let of_trees = || world.forest().and(style.strokes()).map(Lines::of_trees).map(Cow::Owned);
    style.lines().map(Cow::Borrowed).or_else(of_trees)
}

/// The light and air of a rig's frame, which sees a focus from its origin: that of the scene, or of the style.
pub(crate) fn seen_light(world: &Surfaces, rig: &Rig, style: &Style, light: &Light) -> Light {
    let terrain = &world.terrain;
    let earth = terrain.earth_curvature(rig.origin_m.z);
    let focus = light.focus.or_else(|| style.focus.as_ref().map(style::Focus::seen));
    let focus = focus.map(|focus| focus.seen_from(rig.origin_m, |flat_m| earth.bend(flat_m)));
    Light { focus, ..light.from_above(rig.origin_m.z - f64::from(terrain.range_m()[1])) }
}

/// From a frame to the next.
const STEP_S: f64 = 1.0 / 30.0;

/// What frames share and what their eyes remember, and the clock.
pub struct Renderer {
    pools: Pools,
    eyes: Vec<EyeMemory>,
    timer: Timer,
    step_s: f64,
    submits: Submits,
    /// Whether the motion of every pixel is asked for.
    wants_motion: bool,
    /// Whether the ink of each layer of marks is asked for.
    wants_mark_layers: bool,
    /// Of each eye, if there is any.
    hidden: Vec<HiddenArea>,
    samples: antialias::Samples,
    /// The last frame may have shown trees that wind moves.
    may_sway: bool,
    /// Of styles with rows of hachures.
    rows: RowMemory,
    trace: Option<Vec<PassTrace>>,
    record_ms: f64,
    drew: bool,
    switch: switch::Switch,
}

/// What an eye's passes share.
struct FrameInputs<'a> {
    world: &'a Surfaces,
    mesh: &'a PatchMesh,
    rig: &'a Rig,
    style: &'a Style,
    /// The style's, or those of trees where it has strokes instead.
    lines: Option<&'a Lines>,
    light: &'a Light,
    step_s: f64,
    land_changes: bool,
    wants_motion: bool,
    wants_mark_layers: bool,
    hidden: &'a [HiddenArea],
    /// Of a style with rows of hachures.
    rows: Option<&'a RowPlan>,
    /// Where frames are samples of one picture.
    temporal_aa: Option<temporal_aa::Plan>,
}

impl Renderer {
    /// Of nothing yet.
    ///
    /// # Errors
    /// [`GpuError::Device`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            pools: Pools::new(gpu),
            eyes: Vec::new(),
            timer: Timer::new(gpu)?,
            step_s: STEP_S,
            submits: Submits::default(),
            wants_motion: false,
            wants_mark_layers: false,
            hidden: Vec::new(),
            samples: antialias::Samples::default(),
            may_sway: false,
            rows: RowMemory::default(),
            trace: None,
            record_ms: 0.0,
            drew: false,
            switch: switch::Switch::new(gpu),
        })
    }

    /// The frame that is there, or a new one.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn or_new<'a>(frame: &'a mut Option<Self>, gpu: &Gpu) -> Result<&'a mut Self, GpuError> {
        if frame.is_none() {
            *frame = Some(Self::new(gpu)?);
        }
        Ok(frame.as_mut().unwrap_or_else(|| unreachable!("it was just made")))
    }

    /// How much time passes from each frame to the next, in seconds: strokes come and go by it. 1/30 until told.
    pub fn set_step_s(&mut self, step_s: f64) {
        self.step_s = step_s.max(0.0);
    }

    /// How much time passes from each frame to the next, in seconds.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// The next frame takes nothing over from the last one: its strokes are made anew.
    pub fn forget(&mut self) {
        self.samples.forget();
        self.eyes.iter_mut().filter_map(|eye| eye.strokes.as_mut()).for_each(strokes::StrokeMemory::forget);
    }

    /// Sets how the passes of a frame are submitted; [`Submits::Timed`] where pass times are wanted.
    pub fn set_submits(&mut self, submits: Submits) {
        self.submits = submits;
    }

    /// Whether [`MOTION`](crate::surface::motion::MOTION) is made, which no style asks for by itself.
    pub fn set_wants_motion(&mut self, wants_motion: bool) {
        self.wants_motion = wants_motion;
    }

    /// Whether each layer of hatching is drawn by itself as well ([`Renderer::mark_layer`]).
    pub fn set_wants_mark_layers(&mut self, wants_mark_layers: bool) {
        self.wants_mark_layers = wants_mark_layers;
    }

    /// What nobody sees of each eye's picture, and is not drawn; an eye that is not in the list is seen whole.
    pub fn set_hidden(&mut self, hidden: Vec<HiddenArea>) {
        self.hidden = hidden;
    }

    /// How frames smooth their edges. Those of [`Antialias::Temporal`] follow each other: each view's
    /// [`previous`](View::previous) is what the last frame drew, or its picture begins anew.
    pub fn set_antialias(&mut self, antialias: Antialias) {
        self.samples.antialias = antialias;
    }

    /// How frames smooth their edges.
    pub fn antialias(&self) -> Antialias {
        self.samples.antialias
    }

    /// The eyes of `rig` as the next frame samples them: what [`Renderer::render_rig`] and [`prepare`] are to be called
    /// with where [`Renderer::render_eyes`] is not.
    pub fn jittered(&self, rig: &Rig, style: &Style) -> Rig {
        let jitter_px = self.samples.jitter_px(rig, style, self.has_settling_strokes());
        let eyes = rig.eyes.iter().map(|eye| View { jitter_px: eye.jitter_px + jitter_px, ..*eye });
        Rig { eyes: eyes.collect(), ..*rig }
    }

    /// From the next frame on, keeps what its passes read and wrote.
    pub fn set_traces(&mut self, traces: bool) {
        self.trace = traces.then(Vec::new);
    }

    /// The passes of the last frame in the order in which they ran, if frames are traced.
    pub fn trace(&self) -> &[PassTrace] {
        self.trace.as_deref().unwrap_or_default()
    }

    /// Prepares the world and renders the view of one eye. The pictures are there when the GPU is done. Where pipelines
    /// are built beside ([`Renderer::set_builds`]), they may be those of the style before.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when a picture or a list is larger than the device can hold, [`GpuError::Shader`] when a
    /// shader does not hold.
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

    /// As [`Renderer::render`], of all eyes of a rig.
    ///
    /// # Errors
    /// As [`Renderer::render`].
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
            return self.render_what_is_there(gpu, world, rig, style, light);
        }
        let prepared = prepare(gpu, world, rig, style, light);
        self.render_rig(gpu, world, &prepared, rig, style, light)?;
        Ok(prepared)
    }

    /// Renders all eyes of a rig, for which `world` was prepared, in one frame.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_rig(
        &mut self,
        gpu: &Gpu,
        world: &Surfaces,
        prepared: &Prepared,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<(), GpuError> {
        if self.record(gpu, world, prepared, rig, style, light)? {
            return Ok(());
        }
        // Without its pipelines nothing was drawn.
        let trouble = gpu.pipelines().shader_errors().into_iter().next();
        trouble.map_or(Ok(()), |trouble| Err(GpuError::Shader(trouble)))
    }

    /// Records and submits a frame. Whether all was there that it needs; if not, nothing is submitted.
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
        let mut grew = false;
        for (memory, view) in self.eyes.iter_mut().zip(&rig.eyes) {
            grew |= memory.begin_frame(gpu, view, style)?;
        }
        if grew {
            // Bind groups hold the pictures of the old size.
            self.pools.groups.clear();
        }
        let begun = Instant::now();
        let strokes_settle = self.has_settling_strokes();
        let light = &seen_light(world, rig, style, light);
        let mut recorder = Recorder::new(gpu, &mut self.pools, &mut self.timer, self.submits, self.trace.is_some());
        let mesh = &PatchMesh::upload(&mut recorder, &prepared.selection);
        let (wants_motion, wants_mark_layers) = (self.wants_motion, self.wants_mark_layers);
        let land_changes = prepared.tiles.loaded > 0 || prepared.tiles.late;
        // Of another view than the last one's it need not be known: that is none at rest.
        let sways = self.may_sway && !rig.clock().is_still();
        let changes = land_changes || strokes_settle || sways;
        let error_px = prepared.detail.error_px;
        let temporal_aa = self.samples.plan(&antialias::Asked { rig, style, light, error_px, changes });
        // No time passes between samples: strokes neither come nor go.
        let step_s = if self.samples.rests() { 0.0 } else { self.step_s };
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
            land_changes,
            wants_motion,
            wants_mark_layers,
            hidden,
            rows: rows.as_ref(),
            temporal_aa,
        };
        self.may_sway = passes::render_eyes(&mut recorder, &inputs, &mut self.eyes);
        let is_complete = recorder.is_complete();
        self.trace = recorder.submit();
        self.record_ms = begun.elapsed().as_secs_f64() * 1000.0;
        self.drew = is_complete;
        if !is_complete {
            self.rows.forget_planned();
        }
        Ok(is_complete)
    }
}
