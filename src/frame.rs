//! A frame, from top to bottom: surface → lines and tones → composite, for each eye of a rig.
//!
//! `src/frame_passes.md` lists the passes with what each reads and writes. Window, files and measurements all come
//! through [`Frame::render`]. Passes are functions and own nothing: pipelines, buffers and uniforms come from the pools
//! that all eyes share, pictures and strokes from the memory of the eye. What a style does not call is not made, and
//! what is not called any more goes.

mod eye;
mod left;
mod switch;

use std::time::Instant;

pub use self::eye::EyeMemory;
use crate::composite;
use crate::gpu::pipelines::Builds;
use crate::gpu::pools::Pools;
use crate::gpu::recorder::{Cx, Submits};
use crate::gpu::timer::Timer;
use crate::gpu::trace::PassTrace;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::history::Step;
use crate::lines::strokes::{self, FrameStrokes};
use crate::lines::{detector, lsa, smooth, threshold};
pub use crate::scene::Light;
use crate::scene::view::{Rig, View};
use crate::style::Style;
use crate::style::hatching::Scale;
use crate::surface::edges::EdgeList;
use crate::surface::land::vertices::PatchMesh;
use crate::surface::meshes::DrawnMeshes;
use crate::surface::{self, land, mark_normal, meshes, motion};
use crate::tiles::terrain::{Prepared, TerrainView};
use crate::tones::{self, TONE, balance, fractal_hatching, hatching, watercolor};
use crate::world::Surfaces;

/// What the terrain is asked for a view.
pub fn terrain_view(view: &View) -> TerrainView {
    terrain_view_of(&Rig::mono(*view))
}

/// What the terrain is asked for all eyes of a rig: once.
pub fn terrain_view_of(rig: &Rig) -> TerrainView {
    TerrainView {
        camera_m: rig.origin_m,
        frusta: rig.eyes.iter().map(View::frustum).collect(),
        focal_px: rig.eyes.iter().map(View::focal_px).fold(0.0, f64::max),
        pixels: rig.eyes.iter().map(|eye| eye.part.size_px.map(f64::from).iter().product::<f64>()).sum(),
    }
}

/// Tiles and patches of a rig's next frame, with the horizons that the style's shadows ask for.
pub fn prepare(gpu: &Gpu, world: &mut Surfaces, rig: &Rig, style: &Style, light: &Light) -> Prepared {
    let terrain = &mut world.terrain;
    terrain.map_horizons(gpu, style.asks_for_horizons().then_some(light.to_sun));
    terrain.prepare(gpu, &terrain_view_of(rig))
}

/// From a frame to the next.
const STEP_S: f64 = 1.0 / 30.0;

/// What frames share and what their eyes remember, and the clock.
pub struct Frame {
    pools: Pools,
    eyes: Vec<EyeMemory>,
    timer: Timer,
    step_s: f64,
    submits: Submits,
    /// Whether the motion of every pixel is asked for.
    wants_motion: bool,
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
    light: &'a Light,
    step_s: f64,
    land_changes: bool,
    wants_motion: bool,
}

impl Frame {
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
            trace: None,
            record_ms: 0.0,
            drew: false,
            switch: switch::Switch::default(),
        })
    }

    /// The frame that is there, or a new one.
    ///
    /// # Errors
    /// As [`Frame::new`].
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

    /// The next frame takes nothing over from the last one: its strokes are made anew.
    pub fn forget(&mut self) {
        self.eyes.iter_mut().filter_map(|eye| eye.strokes.as_mut()).for_each(strokes::StrokeMemory::forget);
    }

    /// Whether frames submit all passes at once where the driver would have them one by one.
    pub fn set_submits(&mut self, submits: Submits) {
        self.submits = submits;
    }

    /// Whether [`motion::MOTION`] is made, which no style asks for by itself.
    pub fn set_wants_motion(&mut self, wants_motion: bool) {
        self.wants_motion = wants_motion;
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
    /// are built beside ([`Frame::set_builds`]), they may be those of the style before.
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

    /// As [`Frame::render`], the views of all eyes of a rig.
    ///
    /// # Errors
    /// As [`Frame::render`].
    pub fn render_eyes(
        &mut self,
        gpu: &Gpu,
        world: &mut Surfaces,
        rig: &Rig,
        style: &Style,
        light: &Light,
    ) -> Result<Prepared, GpuError> {
        if self.pools.pipelines.builds() == Builds::Beside {
            return self.render_what_is_there(gpu, world, rig, style, light);
        }
        let prepared = prepare(gpu, world, rig, style, light);
        self.render_rig(gpu, world, &prepared, rig, style, light)?;
        Ok(prepared)
    }

    /// Renders all eyes of a rig, for which `world` was prepared, in one frame.
    ///
    /// # Errors
    /// As [`Frame::render`].
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
        let trouble = self.shader_troubles().first().map(|error| (*error).clone());
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
        let light = &light.from_above(rig.origin_m.z - f64::from(world.terrain.range_m()[1]));
        let mut cx = Cx::new(gpu, &mut self.pools, &mut self.timer, self.submits, self.trace.is_some());
        let mesh = &PatchMesh::upload(&mut cx, &prepared.selection);
        let (step_s, wants_motion) = (self.step_s, self.wants_motion);
        let land_changes = prepared.tiles.loaded > 0 || prepared.tiles.late;
        let seen = FrameInputs { world, mesh, rig, style, light, step_s, land_changes, wants_motion };
        for (eye, memory) in self.eyes.iter_mut().enumerate() {
            render_eye(&mut cx, &seen, eye, memory);
        }
        let is_complete = cx.is_complete();
        self.trace = cx.submit();
        self.record_ms = begun.elapsed().as_secs_f64() * 1000.0;
        self.drew = is_complete;
        Ok(is_complete)
    }
}

/// The passes of one eye.
fn render_eye(cx: &mut Cx<'_>, seen: &FrameInputs<'_>, eye: usize, memory: &mut EyeMemory) {
    let &FrameInputs { world, mesh, rig, style, light, .. } = seen;
    let terrain = &world.terrain;
    let gpu = cx.gpu();
    let view_of_eye = &rig.eyes[eye];
    let view = &cx.uniform("view", &view_of_eye.uniform(rig.origin_m));
    let heights = &terrain.resources();
    let EyeMemory { targets, strokes: stroke_memory, .. } = memory;

    let strokes = style.strokes.as_ref().zip(stroke_memory.as_mut()).map(|(strokes, memory)| {
        let nearest_m = world.nearest_m(rig.origin_m);
        let step = Step { step_s: seen.step_s, nearest_m, origin_m: rig.origin_m, land_changes: seen.land_changes };
        FrameStrokes::begin(cx, memory, strokes, view_of_eye, light.haze_m, step)
    });
    let edges = strokes.as_ref().and_then(FrameStrokes::wants_edges).map(|rules| EdgeList::begin(cx, rules));
    let edges = edges.as_ref();

    // Surface: place the vertices, rasterise depth and id, compute the rest.
    let (depth, surface_id) = (&targets.whole(gpu, &surface::DEPTH), &targets.whole(gpu, &surface::SURFACE_ID));
    for &batch in &mesh.batches {
        if eye == 0 || mesh.batches.len() > 1 {
            mesh.place(cx, batch, heights);
        }
        land::raster::run(cx, &land::raster::Inputs { view, terrain: heights, mesh, batch, depth, surface_id });
        if let Some(edges) = edges {
            land::edges::run(cx, edges, &land::edges::Inputs { view, terrain: heights, mesh, batch });
        }
    }
    // What stands on the land: the same once more.
    let meshes = world.meshes().map(|placed| {
        let meshes = DrawnMeshes::of(cx, placed);
        meshes::cull::run(cx, view, rig.origin_m, terrain.uniform(), &meshes);
        meshes::vertices::run(cx, &meshes, terrain.uniform());
        meshes::raster::run(cx, &meshes::raster::Inputs { view, meshes: &meshes, depth, surface_id });
        if let Some(edges) = edges {
            meshes::edges::run(cx, edges, view, &meshes);
        }
        meshes
    });
    let (position, normal) = (&targets.whole(gpu, &surface::POSITION), &targets.whole(gpu, &surface::NORMAL));
    land::resolve::run(cx, &land::resolve::Inputs { view, terrain: heights, depth, position, normal });
    if let Some(meshes) = &meshes {
        meshes::resolve::run(cx, &meshes::resolve::Inputs { view, meshes, surface_id, depth, position, normal });
    }
    if seen.wants_motion {
        let motion = &targets.whole(gpu, &motion::MOTION);
        motion::run(cx, &motion::Inputs { view, position, motion });
    }

    // What the land sees of the sun and of the sky, where that is not known yet: once for all eyes.
    let horizon_tiles = terrain.horizon_maps().filter(|_| style.asks_for_horizons());
    if let (0, Some(tiles)) = (eye, horizon_tiles) {
        land::horizons::run(cx, heights, tiles);
    }

    // Lines: detect, threshold, smooth.
    let nothing = targets.sized(gpu, &composite::NOTHING, [1, 1]);
    let line = style.lines.as_ref().map_or(nothing.clone(), |lines| {
        let errors = &targets.whole(gpu, &detector::ERRORS);
        let line = targets.whole(gpu, &threshold::LINE);
        let directions = lines.has_eight_directions().then(|| targets.whole(gpu, &lsa::DIRECTIONS));
        let directions = directions.as_ref();
        detector::run(cx, lines, &detector::Inputs { view, position, normal, errors, directions });
        threshold::run(cx, lines, &threshold::Inputs { view, errors, directions, line: &line });
        if !lines.antialias {
            return line;
        }
        let smoothed = targets.whole(gpu, &smooth::SMOOTHED);
        smooth::run(cx, &smooth::Inputs { view, line: &line, smoothed: &smoothed });
        smoothed
    });

    // Strokes: see what is visible of the edges, chain it, draw it.
    let ink = match (&style.strokes, &strokes) {
        (Some(style), Some(strokes)) => {
            strokes.draw(cx, strokes::Inputs { view, depth, edges, targets, resolution: style.resolution })
        }
        _ => nothing.clone(),
    };

    // Tones.
    let tone = targets.whole(gpu, &TONE);
    let inputs = tones::Inputs {
        view,
        terrain: terrain.uniform(),
        horizon_maps: horizon_tiles.and_then(|_| terrain.horizon_map_resources()),
        style,
        light,
        camera_z_m: rig.origin_m.z as f32,
        range_m: terrain.range_m(),
        position,
        normal,
        tone: &tone,
    };
    tones::run(cx, &inputs);
    let colors = style.watercolor.as_ref().map_or(tone.clone(), |watercolor| {
        let washed = targets.whole(gpu, &watercolor::WASHED);
        let origin_m = rig.origin_m;
        let inputs = watercolor::Inputs { view, watercolor, origin_m, position, tone: &tone, washed: &washed };
        watercolor::run(cx, &inputs);
        washed
    });
    let marks = style.hatching.as_ref().map_or(nothing, |hatching| {
        let size = mark_normal::mark_normal_size(targets.size_px());
        let mark_normal = &targets.sized(gpu, &mark_normal::MARK_NORMAL, size);
        let seen = mark_normal::Inputs { view, terrain: heights, surface_id, position, normal, mark_normal };
        mark_normal::run(cx, &seen);
        let balance = balance::Inputs::new(cx, targets, view, hatching);
        let (tone, cover, origin_m) = (&tone, &balance.cover, rig.origin_m);
        let inputs = hatching::Inputs { view, hatching, origin_m, position, normal, mark_normal, tone, cover };
        match hatching.scale {
            Scale::Blend => hatching::run(cx, &inputs),
            Scale::Add => fractal_hatching::run(cx, &inputs),
        }
        balance::run(cx, &balance);
        balance.marks
    });

    // Composite.
    let picture = &targets.whole(gpu, &composite::PICTURE);
    let (tone, line, ink, marks) = (&colors, &line, &ink, &marks);
    composite::run(cx, &composite::Inputs { view, style, light, position, tone, line, ink, marks, picture });
}
