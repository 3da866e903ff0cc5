//! The pictures that exist: those that the style requires.

use super::passes::Requirements;
use crate::composite::PICTURE_FORMAT;
use crate::gpu::target::Target;
use crate::gpu::{Gpu, GpuError};
use crate::lines::detector::ERRORS_FORMAT;
use crate::lines::strokes::StrokeTargets;
use crate::lines::strokes::id_image::IdTargets;
use crate::lines::strokes::stroke::InkTargets;
use crate::lines::threshold::LINE_FORMAT;
use crate::surface::form::{FORM_FORMAT, form_size};
use crate::surface::motion::MOTION_FORMAT;
use crate::surface::resolve::{NORMAL_FORMAT, POSITION_FORMAT};
use crate::surface::terrain::{DEPTH_FORMAT, ID_FORMAT};
use crate::tones::TONE_FORMAT;
use crate::tones::balance::BalanceTargets;

/// The pictures of a frame, all of one size.
pub struct Targets {
    requirements: Requirements,
    size_px: [u32; 2],
    /// Reversed depth of the mesh.
    pub depth: Target,
    /// Which patch.
    pub surface_id: Target,
    /// Of the surface.
    pub position: Target,
    /// Of the surface.
    pub normal: Target,
    /// From the previous frame.
    pub motion: Option<Target>,
    /// Of a style with lines.
    pub lines: Option<LineTargets>,
    /// Of a style with strokes.
    pub strokes: Option<StrokeTargets>,
    /// One pixel, for styles without lines: reading outside of it gives 0.
    pub no_line: Target,
    /// Colour and tone.
    pub tone: Target,
    /// Colour after water has run, of a style with watercolour.
    pub washed: Option<Target>,
    /// Of a style with hatching.
    pub hatching: Option<HatchingTargets>,
    /// The result.
    pub picture: Target,
}

/// The pictures of hatching.
pub struct HatchingTargets {
    /// The normal at the scale of marks.
    pub form: Target,
    /// What marks ink, before and after it is balanced.
    pub ink: BalanceTargets,
}

/// The pictures of lines.
pub struct LineTargets {
    /// Of the four axes.
    pub errors: Target,
    /// After the threshold.
    pub line: Target,
    /// After smoothing.
    pub smoothed: Target,
}

impl Targets {
    /// Makes them.
    ///
    /// # Errors
    /// [`GpuError::Limit`].
    pub fn new(gpu: &Gpu, requirements: &Requirements, size_px: [u32; 2]) -> Result<Self, GpuError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if let Some(side) = size_px.into_iter().find(|side| *side > limit) {
            return Err(GpuError::Limit { what: "a picture", wanted: side.into(), limit: limit.into() });
        }
        let size_px = size_px.map(|side| side.max(1));
        let storage = |label, format| Target::storage(gpu, label, size_px, format);
        Ok(Self {
            requirements: *requirements,
            size_px,
            depth: Target::attachment(gpu, "depth", size_px, DEPTH_FORMAT),
            surface_id: Target::attachment(gpu, "surface id", size_px, ID_FORMAT),
            position: storage("position", POSITION_FORMAT),
            normal: storage("normal", NORMAL_FORMAT),
            motion: requirements.motion.then(|| storage("motion", MOTION_FORMAT)),
            lines: requirements.detector.is_some().then(|| LineTargets {
                errors: storage("errors", ERRORS_FORMAT),
                line: storage("line", LINE_FORMAT),
                smoothed: storage("smoothed line", LINE_FORMAT),
            }),
            strokes: requirements.strokes.map(|parts| StrokeTargets {
                id_image: IdTargets::new(gpu, size_px, parts as f32 / 64.0),
                ink: InkTargets::new(gpu, size_px),
            }),
            hatching: requirements.hatching.map(|_| HatchingTargets {
                form: Target::storage(gpu, "form", form_size(size_px), FORM_FORMAT),
                ink: BalanceTargets::new(gpu, size_px, requirements.balance_px),
            }),
            no_line: Target::storage(gpu, "no line", [1, 1], LINE_FORMAT),
            tone: storage("tone", TONE_FORMAT),
            washed: requirements.watercolor.then(|| storage("washed", TONE_FORMAT)),
            picture: storage("picture", PICTURE_FORMAT),
        })
    }

    /// Whether these serve.
    pub fn fit(&self, requirements: &Requirements, size_px: [u32; 2]) -> bool {
        self.requirements == *requirements && self.size_px == size_px
    }

    /// Their size.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Bytes on the GPU.
    pub fn bytes(&self) -> u64 {
        let always =
            [&self.depth, &self.surface_id, &self.position, &self.normal, &self.no_line, &self.tone, &self.picture];
        let lines = self.lines.iter().flat_map(|lines| [&lines.errors, &lines.line, &lines.smoothed]);
        let strokes = self
            .strokes
            .iter()
            .flat_map(|strokes| [&strokes.id_image.ids, &strokes.id_image.depth, &strokes.ink.ink, &strokes.ink.ids]);
        let hatching = self.hatching.iter().flat_map(|hatching| [&hatching.form].into_iter().chain(hatching.ink.all()));
        always
            .into_iter()
            .chain(lines)
            .chain(strokes)
            .chain(hatching)
            .chain(&self.motion)
            .chain(&self.washed)
            .map(Target::bytes)
            .sum()
    }
}
