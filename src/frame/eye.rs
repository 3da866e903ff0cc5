//! What an eye keeps from frame to frame: its pictures and its strokes.

use crate::gpu::pools::KEEP_FRAMES;
use crate::gpu::target::Targets;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::StrokeMemory;
use crate::scene::view::View;
use crate::style::{Strokes, Style};

/// The memory of an eye.
#[derive(Default)]
pub struct EyeMemory {
    /// All of one size.
    pub targets: Targets,
    /// Of a style with strokes.
    pub strokes: Option<StrokeMemory>,
    /// The name of the style of the last frame and its strokes, if it had any.
    drawn: Option<(String, Strokes)>,
    frames_without_strokes: u64,
}

impl EyeMemory {
    /// Begins a frame. Whether pictures of another size went.
    ///
    /// # Errors
    /// [`GpuError::Limit`].
    pub(super) fn begin_frame(&mut self, gpu: &Gpu, view: &View, style: &Style) -> Result<bool, GpuError> {
        let stays = self.targets.begin_frame(gpu, view.part.size_px)?;
        match (style.strokes(), &mut self.strokes) {
            (Some(_), None) => self.strokes = Some(StrokeMemory::new(gpu)?),
            // Strokes of another style, or of long ago, do not continue in this one's.
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

    /// Whether strokes of the last frame are still coming or going.
    pub(super) fn has_settling_strokes(&self) -> bool {
        self.drawn_strokes().is_some_and(StrokeMemory::is_settling)
    }

    /// The strokes of the last frame, if its style has any.
    pub(super) fn drawn_strokes(&self) -> Option<&StrokeMemory> {
        self.strokes.as_ref().filter(|_| self.drawn.is_some())
    }
}
