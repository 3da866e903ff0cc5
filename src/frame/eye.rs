//! The memory of an eye from frame to frame: its pictures and its strokes.

use crate::gpu::pools::KEEP_FRAMES;
use crate::gpu::target::{Target, Targets};
use crate::gpu::wgsl::shared::view::View as ViewUniform;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::StrokeMemory;
use crate::scene::view::View;
use crate::style::{Strokes, Style};

/// The pictures and strokes of an eye, which persist from frame to frame.
#[derive(Default)]
pub(crate) struct EyeMemory {
    /// The pictures of the eye.
    pub targets: Targets,
    /// The view of the last frame, as its shaders read it.
    pub(super) view: Option<ViewUniform>,
    /// The strokes; `None` if no recent style has any.
    pub strokes: Option<StrokeMemory>,
    /// The picture of each layer's ink in the last frame, by the index of the layer in the style.
    pub(super) layer_inks: Vec<Option<Target>>,
    /// The name of the style of the last frame and its strokes, if it had any.
    drawn: Option<(String, Strokes)>,
    /// Number of successive frames, up to the last, whose style has no strokes.
    frames_without_strokes: u64,
}

impl EyeMemory {
    /// Begins a frame, with textures for pictures of `room_px`. Returns whether all pictures were released.
    ///
    /// # Errors
    /// [`GpuError::Limit`] if the pictures are larger than the device allows.
    pub(super) fn begin_frame(
        &mut self,
        gpu: &Gpu,
        view: &View,
        style: &Style,
        room_px: Option<[u32; 2]>,
    ) -> Result<bool, GpuError> {
        self.layer_inks.clear();
        let stays = self.targets.begin_frame(gpu, view.part.size_px, room_px)?;
        match (style.strokes(), &mut self.strokes) {
            (Some(_), None) => self.strokes = Some(StrokeMemory::new(gpu)?),
            // Strokes continue only if the last frame had the same style, at most with changed values.
            (Some(new), Some(strokes)) => match &self.drawn {
                Some((name, drawn)) if stays && *name == style.name && new.continues(drawn) => {
                    if !new.draws_as(drawn) {
                        strokes.rebuild_next();
                    }
                }
                _ => strokes.forget(),
            },
            (None, Some(_)) if self.frames_without_strokes > KEEP_FRAMES => self.strokes = None,
            _ => {}
        }
        self.frames_without_strokes = if style.strokes().is_some() { 0 } else { self.frames_without_strokes + 1 };
        let is_drawn = |(name, drawn): &(String, Strokes)| *name == style.name && style.strokes() == Some(drawn);
        if !self.drawn.as_ref().is_some_and(is_drawn) {
            self.drawn = style.strokes().map(|strokes| (style.name.clone(), strokes.clone()));
        }
        Ok(!stays)
    }

    /// Returns whether strokes of the last frame are still fading in or out.
    pub(super) fn has_settling_strokes(&self) -> bool {
        self.drawn_strokes().is_some_and(StrokeMemory::is_settling)
    }

    /// Returns the strokes of the last frame, if its style has any.
    pub(super) fn drawn_strokes(&self) -> Option<&StrokeMemory> {
        self.strokes.as_ref().filter(|_| self.drawn.is_some())
    }
}
