//! The passes that exist: those that the style requires.

use super::targets::{LineTargets, Targets};
use crate::composite::CompositePass;
use crate::gpu::timer::Recorder;
use crate::gpu::{Gpu, GpuError};
use crate::lines::detector::{RoystanPass, SobelPass};
use crate::lines::lsa::LsaPass;
use crate::lines::smooth::SmoothPass;
use crate::lines::strokes::{self, StrokePasses};
use crate::lines::threshold::ThresholdPass;
use crate::style::hatching::Scale;
use crate::style::{Detector, Lines, Style, Tone};
use crate::surface::form::FormPass;
use crate::surface::horizons::HorizonsPass;
use crate::surface::mesh_resolve::MeshResolvePass;
use crate::surface::mesh_vertices::MeshVerticesPass;
use crate::surface::meshes::MeshesPass;
use crate::surface::motion::MotionPass;
use crate::surface::resolve::ResolvePass;
use crate::surface::terrain::TerrainPass;
use crate::surface::vertices::VerticesPass;
use crate::tiles::Terrain;
use crate::tones::balance;
use crate::tones::balance::balanced_ink::BalancedInkPass;
use crate::tones::balance::ink_sums::InkSumsPass;
use crate::tones::balance::ink_windows::InkWindowsPass;
use crate::tones::fractal_hatching::FractalHatchingPass;
use crate::tones::hatching::HatchingPass;
use crate::tones::plain::PlainPass;
use crate::tones::toon::ToonPass;
use crate::tones::watercolor::WatercolorPass;

/// What has to exist for a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Requirements {
    /// What finds lines, if there are any.
    pub detector: Option<Detector>,
    /// Whether lines are smoothed.
    pub antialias: bool,
    /// Pixels of the strokes' reference image per pixel of the picture, in 1/64; none if there are no strokes.
    pub strokes: Option<u32>,
    /// Tones in steps rather than Blinn-Phong.
    pub toon: bool,
    /// Whether tones run as water does.
    pub watercolor: bool,
    /// Whether tones know of cast shadows and of the visible sky.
    pub seen: bool,
    /// Whether tones are made of marks.
    pub hatching: Option<Scale>,
    /// Side of the cells in which their ink is balanced, in pixels; 0 if it is not.
    pub balance_px: u32,
    /// Whether screen motion is wanted.
    pub motion: bool,
    /// Whether meshes stand in the scene.
    pub meshes: bool,
}

impl Requirements {
    /// What `style` needs over bare land; [`Requirements::over`] adds what stands on it.
    pub fn of(style: &Style) -> Self {
        Self {
            detector: style.lines.as_ref().map(|lines| lines.detector),
            antialias: style.lines.as_ref().is_some_and(|lines| lines.antialias),
            strokes: style.strokes.as_ref().map(|strokes| (strokes.resolution * 64.0).round() as u32),
            toon: matches!(style.tone, Tone::Toon(_)),
            seen: matches!(style.tone, Tone::Toon(_)) && (style.light.shadow > 0.0 || style.light.occlusion > 0.0),
            watercolor: style.watercolor.is_some(),
            hatching: style.hatching.as_ref().map(|hatching| hatching.scale),
            balance_px: style.hatching.as_ref().filter(|hatching| hatching.balance).map_or(0, balance::cell_px),
            motion: false,
            meshes: false,
        }
    }

    /// The same over a terrain, with what stands on it.
    pub fn over(self, terrain: &Terrain) -> Self {
        Self { meshes: terrain.meshes().is_some(), ..self }
    }

    /// The names of the passes that run, in drawing order, as the timer has them.
    pub fn passes(&self) -> Vec<&'static str> {
        let detector = self.detector.map(|detector| match detector {
            Detector::Lsa => "lines/lsa",
            Detector::Sobel => "lines/sobel",
            Detector::Roystan => "lines/roystan",
        });
        // Edges are found while the vertices of their batch are there, the rest is drawn with the lines.
        let (edges, strokes) =
            if self.strokes.is_some() { strokes::PASSES.split_at(strokes::FINDING) } else { Default::default() };
        let (of_land, of_meshes) = edges.split_at(edges.len().min(strokes::FINDING_ON_LAND));
        let meshes = if self.meshes { &["surface/mesh_vertices", "surface/meshes"] } else { [].as_slice() };
        let of_meshes = if self.meshes { of_meshes } else { &[] };
        let surface = [&["surface/vertices", "surface/terrain"], of_land, meshes, of_meshes].concat();
        let lines = [
            Some("surface/resolve"),
            self.meshes.then_some("surface/mesh_resolve"),
            self.hatching.map(|_| "surface/form"),
            self.motion.then_some("surface/motion"),
            self.seen.then_some("surface/horizons"),
            detector,
            detector.map(|_| "lines/threshold"),
            self.antialias.then_some("lines/smooth"),
        ];
        let is_balanced = self.balance_px > 0;
        let tones = [
            Some(if self.toon { "tones/toon" } else { "tones/plain" }),
            self.watercolor.then_some("tones/watercolor"),
            self.hatching.map(|scale| match scale {
                Scale::Blend => "tones/hatching",
                Scale::Add => "tones/fractal_hatching",
            }),
            is_balanced.then_some("tones/balance/ink_sums"),
            is_balanced.then_some("tones/balance/ink_windows"),
            self.hatching.map(|_| "tones/balance/balanced_ink"),
            Some("composite/composite"),
        ];
        let first = surface.into_iter().chain(lines.into_iter().flatten());
        first.chain(strokes.iter().copied()).chain(tones.into_iter().flatten()).collect()
    }
}

/// The passes of a frame.
pub(super) struct Passes {
    pub vertices: VerticesPass,
    pub terrain: TerrainPass,
    pub mesh_vertices: Option<MeshVerticesPass>,
    pub meshes: Option<MeshesPass>,
    pub resolve: ResolvePass,
    pub mesh_resolve: Option<MeshResolvePass>,
    pub motion: Option<MotionPass>,
    pub horizons: Option<HorizonsPass>,
    pub lsa: Option<LsaPass>,
    pub sobel: Option<SobelPass>,
    pub roystan: Option<RoystanPass>,
    pub threshold: Option<ThresholdPass>,
    pub smooth: Option<SmoothPass>,
    pub strokes: Option<StrokePasses>,
    pub toon: Option<ToonPass>,
    pub plain: Option<PlainPass>,
    pub watercolor: Option<WatercolorPass>,
    pub form: Option<FormPass>,
    pub hatching: Option<HatchingPass>,
    pub fractal_hatching: Option<FractalHatchingPass>,
    pub ink_sums: Option<InkSumsPass>,
    pub ink_windows: Option<InkWindowsPass>,
    pub balanced_ink: Option<BalancedInkPass>,
    pub composite: CompositePass,
}

/// Makes a pass when it is wanted and not there, drops it when it is not wanted.
fn keep<T>(slot: &mut Option<T>, wanted: bool, make: impl FnOnce() -> T) {
    match (wanted, slot.is_some()) {
        (true, false) => *slot = Some(make()),
        (false, true) => *slot = None,
        _ => {}
    }
}

impl Passes {
    pub fn new(gpu: &Gpu, requirements: &Requirements) -> Result<Self, GpuError> {
        let mut passes = Self {
            vertices: VerticesPass::new(gpu),
            terrain: TerrainPass::new(gpu),
            mesh_vertices: None,
            meshes: None,
            resolve: ResolvePass::new(gpu),
            mesh_resolve: None,
            motion: None,
            horizons: None,
            lsa: None,
            sobel: None,
            roystan: None,
            threshold: None,
            smooth: None,
            strokes: None,
            toon: None,
            plain: None,
            watercolor: None,
            form: None,
            hatching: None,
            fractal_hatching: None,
            ink_sums: None,
            ink_windows: None,
            balanced_ink: None,
            composite: CompositePass::new(gpu),
        };
        passes.adapt(gpu, requirements)?;
        Ok(passes)
    }

    pub fn adapt(&mut self, gpu: &Gpu, requirements: &Requirements) -> Result<(), GpuError> {
        let detector = requirements.detector;
        keep(&mut self.mesh_vertices, requirements.meshes, || MeshVerticesPass::new(gpu));
        keep(&mut self.meshes, requirements.meshes, || MeshesPass::new(gpu));
        keep(&mut self.mesh_resolve, requirements.meshes, || MeshResolvePass::new(gpu));
        keep(&mut self.motion, requirements.motion, || MotionPass::new(gpu));
        keep(&mut self.horizons, requirements.seen, || HorizonsPass::new(gpu));
        keep(&mut self.lsa, detector == Some(Detector::Lsa), || LsaPass::new(gpu));
        keep(&mut self.sobel, detector == Some(Detector::Sobel), || SobelPass::new(gpu));
        keep(&mut self.roystan, detector == Some(Detector::Roystan), || RoystanPass::new(gpu));
        keep(&mut self.threshold, detector.is_some(), || ThresholdPass::new(gpu));
        keep(&mut self.smooth, requirements.antialias, || SmoothPass::new(gpu));
        match (requirements.strokes, &self.strokes) {
            (Some(_), None) => self.strokes = Some(StrokePasses::new(gpu)?),
            (None, Some(_)) => self.strokes = None,
            _ => {}
        }
        if self.toon.as_ref().is_some_and(|toon| toon.sees() != requirements.seen) {
            self.toon = None;
        }
        keep(&mut self.toon, requirements.toon, || ToonPass::new(gpu, requirements.seen));
        if let Some(strokes) = &mut self.strokes {
            strokes.set_meshes(gpu, requirements.meshes);
        }
        keep(&mut self.plain, !requirements.toon, || PlainPass::new(gpu));
        keep(&mut self.watercolor, requirements.watercolor, || WatercolorPass::new(gpu));
        keep(&mut self.form, requirements.hatching.is_some(), || FormPass::new(gpu));
        let hatching = requirements.hatching;
        keep(&mut self.hatching, hatching == Some(Scale::Blend), || HatchingPass::new(gpu));
        keep(&mut self.ink_sums, requirements.balance_px > 0, || InkSumsPass::new(gpu));
        keep(&mut self.ink_windows, requirements.balance_px > 0, || InkWindowsPass::new(gpu));
        keep(&mut self.balanced_ink, requirements.hatching.is_some(), || BalancedInkPass::new(gpu));
        keep(&mut self.fractal_hatching, hatching == Some(Scale::Add), || FractalHatchingPass::new(gpu));
        Ok(())
    }

    /// Runs the style's detector.
    pub fn detect(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        lines: &Lines,
        view: wgpu::BindingResource<'_>,
        targets: &Targets,
    ) {
        let Some(drawn) = &targets.lines else { return };
        let (position, normal, errors) = (&targets.position, &targets.normal, &drawn.errors);
        if let Some(pass) = &mut self.lsa {
            pass.run(gpu, recorder, size_px, lines.epsilon, view, position, normal, errors);
        } else if let Some(pass) = &self.sobel {
            pass.run(gpu, recorder, size_px, view, position, errors);
        } else if let Some(pass) = &self.roystan {
            pass.run(gpu, recorder, size_px, view, position, normal, errors);
        }
    }

    /// Errors → lines.
    pub fn threshold(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        lines: &Lines,
        view: wgpu::BindingResource<'_>,
        drawn: &LineTargets,
    ) {
        if let Some(pass) = &mut self.threshold {
            pass.run(gpu, recorder, size_px, lines, view, &drawn.errors, &drawn.line);
        }
    }
}
