//! The comparison of the current style with another one: while a key is held, or on both sides of a divider.

use super::Flight;
use super::controls::TOAST;
use crate::frame::{Antialias, Light, Renderer};
use crate::gpu::pipelines::Builds;
use crate::scene::stereo::Eyes;
use crate::scene::view::Rig;
use crate::studio::document::StyleDocument;
use crate::style::Style;
use crate::window::WindowError;
use crate::window::divider::{Divider, Left};
use crate::window::toasts::About;

/// A divider with the style on its left and the renderer that draws it.
pub(super) struct Compared {
    pub divider: Divider,
    renderer: Option<Renderer>,
    style: Style,
    /// The style at the resolution of the picture.
    drawn: Style,
    of: LeftOf,
}

/// The state that decided the left style: the choice, the current style, and whether that has edits that are not saved.
type LeftOf = (Left, usize, bool);

impl Compared {
    /// Returns the renderer with the picture of the left style, if it has been drawn.
    pub(super) fn drawn(&self) -> Option<&Renderer> {
        self.renderer.as_ref()
    }

    /// Returns whether the left style is drawn.
    pub(super) fn is_ready(&self) -> bool {
        self.renderer.as_ref().is_some_and(|renderer| renderer.shows(&self.drawn))
    }

    /// Returns whether the left picture is still changing.
    pub(super) fn is_settling(&self) -> bool {
        self.renderer.as_ref().is_some_and(|renderer| renderer.is_settling() || renderer.may_sway())
    }

    /// Returns the renderer, for what has been built in the background.
    pub(super) fn renderer_mut(&mut self) -> Option<&mut Renderer> {
        self.renderer.as_mut()
    }

    /// Begins with a new renderer, because the history is of another land.
    pub(super) fn begin_again(&mut self) {
        self.renderer = None;
    }
}

impl Flight {
    /// Compares with the style before while a key is held: the style without the edits that are not saved, or the style
    /// that was chosen before.
    pub(super) fn compare(&mut self, is_held: bool) {
        if is_held == self.compared.is_some() {
            return;
        }
        self.compared = None;
        self.stale = true;
        // The other style appears at once: strokes do not fade over, and the mean of frames begins again.
        if let Some(renderer) = &mut self.renderer {
            renderer.forget();
        }
        if !is_held {
            return;
        }
        let document = self.styles.document(self.settings.style);
        let (style, text) = match document.filter(|document| document.is_edited()).and_then(StyleDocument::saved_style)
        {
            Some(saved) => (saved, "before the edits"),
            None => (self.styles.list()[self.previous_style].clone(), "the style before"),
        };
        self.say(About::Style, format!("{}: {text}", style.name), TOAST / 2);
        self.compared = Some(style);
    }

    /// Shows the divider between two styles, or removes it.
    pub(super) fn toggle_divider(&mut self) {
        self.needs_relayout = true;
        self.stale = true;
        if self.divided.take().is_some() {
            return;
        }
        if self.settings.eyes != Eyes::Mono {
            self.say(About::Style, "Two styles are compared with one eye only".to_owned(), TOAST);
            return;
        }
        let style = self.settings.style;
        let (.., is_edited) = self.kind_of(Left::Saved);
        let left = match self.previous_style {
            _ if is_edited => Left::Saved,
            previous if previous != style => Left::Style(previous),
            _ => Left::Saved,
        };
        let style = self.left_style(left);
        let (drawn, of) = (style.clone(), self.kind_of(left));
        self.divided = Some(Compared { divider: Divider::new(left), renderer: None, style, drawn, of });
    }

    /// Takes the divider from the panels, or removes it.
    pub(super) fn follow_divider(&mut self, divider: Option<Divider>) {
        let Some(divided) = &mut self.divided else { return };
        match divider {
            Some(divider) => {
                self.stale |= divided.divider.left != divider.left;
                self.needs_relayout |= divided.divider != divider;
                divided.divider = divider;
            }
            None => self.toggle_divider(),
        }
    }

    /// Returns what the left style depends on.
    fn kind_of(&self, left: Left) -> LeftOf {
        let style = self.settings.style;
        (left, style, self.styles.document(style).is_some_and(StyleDocument::is_edited))
    }

    /// Returns the style left of the divider.
    fn left_style(&self, left: Left) -> Style {
        let present = self.settings.style;
        match left {
            Left::Saved => self
                .styles
                .document(present)
                .and_then(StyleDocument::saved_style)
                .unwrap_or_else(|| self.styles.list()[present].clone()),
            Left::Style(style) => self.styles.list()[style].clone(),
        }
    }

    /// Renders the style left of the divider, with the view of the current picture.
    ///
    /// # Errors
    /// Fails if the GPU fails.
    pub(super) fn render_left(
        &mut self,
        rig: &Rig,
        light: &Light,
        step_s: f64,
        (antialias, scale, room_px): (Antialias, f64, Option<[u32; 2]>),
    ) -> Result<(), WindowError> {
        let Some(mut divided) = self.divided.take_if(|_| self.settings.eyes == Eyes::Mono) else { return Ok(()) };
        let left = divided.divider.left;
        let of = self.kind_of(left);
        let is_old = match left {
            Left::Saved => of != divided.of,
            Left::Style(style) => self.styles.list()[style] != divided.style,
        };
        if is_old {
            divided.style = self.left_style(left);
            // Strokes of the other style would fade over.
            divided.renderer.iter_mut().for_each(Renderer::forget);
        }
        divided.of = of;
        let renderer = Renderer::or_new(&mut divided.renderer, &self.gpu)?;
        renderer.set_step_s(step_s);
        renderer.set_antialias(antialias);
        renderer.set_room(room_px);
        renderer.set_builds(Builds::InBackground);
        divided.drawn = divided.style.scaled(scale);
        renderer.render_eyes(&self.gpu, &mut self.world.surfaces, rig, &divided.drawn, light)?;
        self.divided = Some(divided);
        Ok(())
    }
}
