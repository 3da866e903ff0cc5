//! A frame, from top to bottom: surface → lines and tones → composite.
//!
//! `src/frame_passes.md` lists the passes with what each reads and writes. Window, files and measurements all come
//! through [`Frame::render`].

mod passes;
mod targets;

pub use passes::Requirements;
pub use targets::Targets;

use self::passes::Passes;
use crate::composite;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::timer::{PassTime, Timer};
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::history::Step;
use crate::lines::strokes::{StrokePasses, contour_edges};
pub use crate::scene::Light;
use crate::style::{Lines, Style, Tone};
use crate::surface::view::View;
use crate::surface::{form, mesh_resolve, meshes, terrain as draw};
use crate::tiles::Terrain;
use crate::tiles::terrain::{Prepared, TerrainView};
use crate::tones::hatching::uniform::{HatchLayerUniform, HatchUniform};
use crate::tones::hatching::{self, axes};
use crate::tones::light::LightUniform;
use crate::tones::plain::PlainLight;
use crate::tones::{toon, watercolor};

/// Every struct that Rust writes and a shader reads.
pub fn shared_structs() -> Vec<crate::gpu::shared::SharedStruct> {
    vec![
        crate::surface::view::ViewUniform::shared(),
        crate::tiles::terrain_buffers::TerrainUniform::shared(),
        crate::tiles::page_table::LevelInfo::shared(),
        crate::tiles::page_table::TileRow::shared(),
        crate::tiles::page_table::TileRecord::shared(),
        crate::tiles::selection::PatchInstance::shared(),
        crate::surface::horizons::HorizonsUniform::shared(),
        crate::tiles::horizon_maps::HorizonJob::shared(),
        crate::surface::mesh_vertices::MeshInstance::shared(),
        crate::surface::mesh_vertices::MeshTriangle::shared(),
        crate::lines::lsa::LsaUniform::shared(),
        crate::lines::threshold::ThresholdUniform::shared(),
        crate::lines::strokes::StrokesUniform::shared(),
        crate::lines::strokes::Edge::shared(),
        crate::lines::strokes::points::Point::shared(),
        crate::lines::strokes::scan::ScanSource::shared(),
        crate::lines::strokes::Piece::shared(),
        crate::lines::strokes::StrokeCounts::shared(),
        crate::lines::strokes::Chain::shared(),
        crate::lines::strokes::Place::shared(),
        crate::lines::strokes::ChainRulesUniform::shared(),
        crate::lines::strokes::ChainPlan::shared(),
        crate::lines::strokes::samples::Sample::shared(),
        crate::lines::strokes::samples::Match::shared(),
        crate::lines::strokes::samples::SampleCounts::shared(),
        crate::lines::strokes::samples::CarryUniform::shared(),
        crate::lines::strokes::carry::Heritage::shared(),
        crate::lines::strokes::texture::Brush::shared(),
        crate::tones::plain::PlainUniform::shared(),
        LightUniform::shared(),
        toon::ToonUniform::shared(),
        watercolor::WatercolorUniform::shared(),
        watercolor::Anchor::shared(),
        crate::tones::balance::BalanceUniform::shared(),
        HatchLayerUniform::shared(),
        HatchUniform::shared(),
        axes::Axis::shared(),
        axes::Cell::shared(),
        composite::CompositeUniform::shared(),
        composite::present::PresentUniform::shared(),
    ]
}

/// What the terrain is asked for a view.
pub fn terrain_view(view: &View) -> TerrainView {
    TerrainView {
        camera_m: view.pose.position_m,
        frusta: vec![view.frustum()],
        focal_px: view.focal_px(),
        pixels: view.part.size_px.map(f64::from).iter().product(),
    }
}

/// From a frame to the next.
const STEP_S: f64 = 1.0 / 30.0;

/// The passes and targets of a style, and the clock.
pub struct Frame {
    passes: Passes,
    targets: Targets,
    timer: Timer,
    view: GrowingBuffer,
    step_s: f64,
}

impl Frame {
    /// Builds what `requirements` names, and nothing else, for pictures of `size_px`.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when a target is larger than the device can hold, [`GpuError::Device`].
    pub fn new(gpu: &Gpu, requirements: Requirements, size_px: [u32; 2]) -> Result<Self, GpuError> {
        Ok(Self {
            passes: Passes::new(gpu, &requirements)?,
            targets: Targets::new(gpu, &requirements, size_px)?,
            timer: Timer::new(gpu)?,
            view: GrowingBuffer::new(gpu, "view", wgpu::BufferUsages::UNIFORM),
            step_s: STEP_S,
        })
    }

    /// Makes the frame fit another style or size; what stays is kept.
    ///
    /// # Errors
    /// As [`Frame::new`].
    pub fn adapt(&mut self, gpu: &Gpu, requirements: Requirements, size_px: [u32; 2]) -> Result<(), GpuError> {
        if !self.targets.fit(&requirements, size_px) {
            self.targets = Targets::new(gpu, &requirements, size_px)?;
            if let Some(strokes) = &mut self.passes.strokes {
                strokes.forget();
            }
        }
        self.passes.adapt(gpu, &requirements)
    }

    /// How much time passes from each frame to the next, in seconds: strokes come and go by it. 1/30 until told.
    pub fn set_step_s(&mut self, step_s: f64) {
        self.step_s = step_s.max(0.0);
    }

    /// Renders a view. The pictures are in [`Frame::targets`] when the GPU is done.
    ///
    /// # Panics
    /// When the style needs a pass that the frame was not made for.
    pub fn render(&mut self, gpu: &Gpu, terrain: &mut Terrain, view: &View, style: &Style, light: &Light) -> Prepared {
        let size_px = view.part.size_px;
        let terrain_view = terrain_view(view);
        terrain.map_horizons(gpu, Requirements::of(style).seen.then_some(light.to_sun));
        let prepared = terrain.prepare(gpu, &terrain_view);
        let world = terrain.resources();
        self.view.write(gpu, &[view.uniform()]);
        let view_resource = || self.view.binding();
        let targets = &self.targets;
        let passes = &mut self.passes;
        let camera_m = view.pose.position_m;
        let light = &light.from_above(camera_m.z - f64::from(terrain.range_m()[1]));

        let mut finds_edges = false;
        if let (Some(strokes), Some(pass)) = (&style.strokes, &mut passes.strokes) {
            let mesh_m = terrain.meshes().map_or(f64::INFINITY, |placed| placed.nearest_m(camera_m));
            let step = Step { step_s: self.step_s, nearest_m: terrain.nearest_m(camera_m).min(mesh_m) };
            finds_edges = pass.begin(gpu, strokes, view, light.haze_m, step);
        }

        let mut frame = self.timer.record(gpu);
        let recorder = &mut frame;
        // Surface: place the vertices, rasterise depth and id, compute the rest.
        for batch in passes.vertices.upload(gpu, &prepared.selection) {
            passes.vertices.run(gpu, recorder, batch, &world);
            let inputs = draw::Inputs {
                view: view_resource(),
                terrain: &world,
                solid: prepared.selection.solid.len() as u32,
                batch,
                mesh: &passes.vertices,
                depth: &targets.depth,
                surface_id: &targets.surface_id,
            };
            passes.terrain.run(gpu, recorder, &inputs);
            if let (true, Some(pass)) = (finds_edges, &mut passes.strokes) {
                let mesh = &passes.vertices;
                pass.find(
                    gpu,
                    recorder,
                    &contour_edges::Inputs { view: view_resource(), terrain: &world, batch, mesh },
                );
            }
        }
        let (position, normal) = (&targets.position, &targets.normal);
        let (depth, surface_id) = (&targets.depth, &targets.surface_id);
        // What stands on the land: the same once more.
        if let (Some(vertices), Some(draw), Some(placed)) =
            (&mut passes.mesh_vertices, &passes.meshes, terrain.meshes())
        {
            vertices.upload(gpu, placed, view, &terrain.earth_curvature(camera_m.z));
            vertices.run(gpu, recorder, terrain.uniform());
            let inputs = meshes::Inputs { view: view_resource(), meshes: vertices, depth, surface_id };
            draw.run(gpu, recorder, &inputs);
            if let (true, Some(pass)) = (finds_edges, &mut passes.strokes) {
                pass.find_on_meshes(gpu, recorder, view_resource(), vertices);
            }
        }
        passes.resolve.run(gpu, recorder, size_px, view_resource(), &world, &targets.depth, position, normal);
        if let (Some(pass), Some(vertices)) = (&passes.mesh_resolve, &passes.mesh_vertices) {
            let view = view_resource();
            let inputs = mesh_resolve::Inputs { view, meshes: vertices, surface_id, depth, position, normal };
            pass.run(gpu, recorder, size_px, &inputs);
        }
        if let (Some(pass), Some(drawn)) = (&passes.form, &targets.hatching) {
            let inputs = form::Inputs {
                view: view_resource(),
                terrain: &world,
                surface_id,
                position,
                normal,
                form: &drawn.form,
            };
            pass.run(gpu, recorder, inputs);
        }
        if let (Some(pass), Some(motion)) = (&passes.motion, &targets.motion) {
            pass.run(gpu, recorder, size_px, view_resource(), position, motion);
        }

        // What the land sees of the sun and of the sky, where that is not known yet.
        if let (Some(pass), Some(seen)) = (&mut passes.horizons, terrain.horizon_maps()) {
            pass.run(gpu, recorder, &world, seen);
        }

        // Lines: detect, threshold, smooth.
        let mut line = &targets.no_line;
        if let (Some(lines), Some(drawn)) = (&style.lines, &targets.lines) {
            passes.detect(gpu, recorder, size_px, lines, view_resource(), targets);
            passes.threshold(gpu, recorder, size_px, lines, view_resource(), drawn);
            line = &drawn.line;
            if let (true, Some(pass)) = (lines.antialias, &passes.smooth) {
                pass.run(gpu, recorder, size_px, view_resource(), &drawn.line, &drawn.smoothed);
                line = &drawn.smoothed;
            }
        }

        let mut ink = &targets.no_line;
        // Strokes: see what is visible of the edges, chain it, draw it.
        if let (Some(_), Some(pass), Some(drawn)) = (&style.strokes, &mut passes.strokes, &targets.strokes) {
            if finds_edges {
                pass.update(gpu, recorder, view_resource(), &targets.depth, drawn);
            } else {
                pass.advance(gpu, recorder, view_resource(), drawn);
            }
            ink = &drawn.ink.ink;
        }

        // Tones.
        let tone = &targets.tone;
        match &style.tone {
            Tone::Plain => {
                let plain = PlainLight {
                    to_sun: light.to_sun.as_vec3().to_array(),
                    camera_z_m: view.pose.position_m.z as f32,
                    range_m: terrain.range_m(),
                };
                let pass = passes.plain.as_mut().expect("the frame was made for this style");
                pass.run(gpu, recorder, size_px, plain, view_resource(), terrain.uniform(), position, normal, tone);
            }
            Tone::Toon(steps) => {
                let pass = passes.toon.as_mut().expect("the frame was made for this style");
                let land = toon::Land { camera_z_m: view.pose.position_m.z as f32, range_m: terrain.range_m() };
                let inputs = toon::Inputs {
                    view: view_resource(),
                    terrain: terrain.uniform(),
                    seen: terrain.horizon_map_resources(),
                    position,
                    normal,
                    tone,
                };
                pass.run(gpu, recorder, size_px, steps, LightUniform::new(style, light), land, inputs);
            }
        }

        let mut colors = tone;
        if let (Some(water), Some(pass), Some(washed)) = (&style.watercolor, &mut passes.watercolor, &targets.washed) {
            let inputs = watercolor::Inputs { view: view_resource(), position, tone, washed };
            pass.run(gpu, recorder, size_px, water, view.pose.position_m, inputs);
            colors = washed;
        }
        let mut marks = &targets.no_line;
        if let (Some(style), Some(drawn)) = (&style.hatching, &targets.hatching) {
            let inputs = hatching::Inputs {
                view: view_resource(),
                position,
                normal,
                form: &drawn.form,
                tone,
                cover: &drawn.ink.cover,
            };
            let camera_m = view.pose.position_m;
            if let Some(pass) = &mut passes.hatching {
                pass.run(gpu, recorder, size_px, style, camera_m, inputs);
            } else if let Some(pass) = &mut passes.fractal_hatching {
                pass.run(gpu, recorder, size_px, style, camera_m, inputs);
            }
            let balance = &drawn.ink;
            if let (Some(sums), Some(windows)) = (&passes.ink_sums, &passes.ink_windows) {
                sums.run(gpu, recorder, view_resource(), balance);
                windows.run(gpu, recorder, balance);
            }
            if let Some(pass) = &passes.balanced_ink {
                pass.run(gpu, recorder, size_px, view_resource(), balance);
            }
            marks = &balance.marks;
        }

        // Composite.
        let picture = &targets.picture;
        let inputs = composite::Inputs { view: view_resource(), position, tone: colors, line, ink, marks, picture };
        passes.composite.run(gpu, recorder, size_px, style, light, inputs);
        frame.submit();
        prepared
    }

    /// The pictures of the last frame.
    pub fn targets(&self) -> &Targets {
        &self.targets
    }

    /// The mesh as the last picture drew it, for measurements: 17 × 17 vertices for each leaf of its selection, row by
    /// row, relative to the camera in metres (the fourth number is 1). None when the selection was so large that it was
    /// drawn in several batches: only the last of them is left.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub fn drawn_vertices(&self, gpu: &Gpu, drawn: &Prepared) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        self.passes.vertices.read(gpu, drawn.selection.leaves.len())
    }

    /// As [`Frame::drawn_vertices`], of all that stands on the land, if anything does.
    ///
    /// # Errors
    /// As [`Frame::drawn_vertices`].
    pub fn drawn_mesh_vertices(&self, gpu: &Gpu) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        self.passes.mesh_vertices.as_ref().map(|pass| pass.read(gpu)).transpose()
    }

    /// The times of the oldest finished frame that has not been asked for.
    pub fn take_times(&mut self) -> Option<Vec<PassTime>> {
        self.timer.take()
    }

    /// Whether the next frame of the same view would be another picture: strokes are still coming or going.
    pub fn is_settling(&self) -> bool {
        self.passes.strokes.as_ref().is_some_and(StrokePasses::is_settling)
    }

    /// The passes of strokes, if the style has any, with what the last frame left: for measurements.
    pub fn strokes(&self) -> Option<&StrokePasses> {
        self.passes.strokes.as_ref()
    }

    /// Which line picture the style's composite read, if any.
    pub fn line_target(&self, lines: &Lines) -> Option<&crate::gpu::target::Target> {
        self.targets.lines.as_ref().map(|drawn| if lines.antialias { &drawn.smoothed } else { &drawn.line })
    }
}
