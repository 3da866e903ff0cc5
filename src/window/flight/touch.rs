//! A click on the picture selects the layer that drew there, in the inspector.

use std::time::Instant;

use glam::DVec2;

use super::Flight;
use super::controls::TOAST;
use super::navigate::ANSWER_LOOK;
use crate::frame::seen_light;
use crate::scene::view::{Rig, View};
use crate::style::layers::Layer;
use crate::surface::DISTANCE;
use crate::surface::water::WATER;
use crate::window::dock::Pane;
use crate::window::input::DOUBLE_CLICK;
use crate::window::toasts::About;
use crate::window::touched::{Asked, AskedInk, Touched, Toucher};

/// The state of a click between two frames.
pub(super) struct Touch {
    toucher: Toucher,
    /// The click that waits for a picture of the chosen style.
    wish_px: Option<DVec2>,
    /// The clicks that have been asked about: the style, and when no second click can follow any more.
    asked: Option<(usize, Instant)>,
    answer: Option<Touched>,
    next_look: Instant,
}

impl Touch {
    /// Creates the state in which nothing was clicked on.
    pub(super) fn new() -> Self {
        Self { toucher: Toucher::new(), wish_px: None, asked: None, answer: None, next_look: Instant::now() }
    }

    /// Forgets the last click.
    pub(super) fn cancel(&mut self) {
        self.wish_px = None;
        self.asked = None;
        self.answer = None;
        self.toucher.forget();
    }

    /// Returns when to look for an answer, or to show it.
    pub(super) fn look_at(&self) -> Option<Instant> {
        let (_, shown_at) = self.asked?;
        Some(if self.answer.is_some() { shown_at } else { self.next_look })
    }
}

impl Flight {
    /// Asks which layer drew at a position of the window.
    pub(super) fn touch(&mut self, cursor_px: DVec2) {
        self.touch.cancel();
        self.touch.wish_px = Some(cursor_px);
        self.ask_touched();
    }

    /// Asks what the last click waits for, if the picture is that of the chosen style.
    pub(super) fn ask_touched(&mut self) {
        let Some(cursor_px) = self.touch.wish_px else { return };
        let Some((eye, part)) = self.eye_at(cursor_px) else {
            self.touch.wish_px = None;
            return;
        };
        let Some(renderer) = self.renderer.as_ref().filter(|renderer| renderer.shows(self.style())) else { return };
        let Some(distance) = renderer.eye_target(eye, &DISTANCE) else { return };
        let style = self.style();
        let ask = |ink: crate::style::layers::StyleInk| {
            let picture = ink.layer.and_then(|layer| renderer.ink_target(eye, layer));
            AskedInk { ink, picture }
        };
        let pose = self.last.pose;
        let rig = Rig::mono(View::whole(pose, pose, renderer.size_px()));
        let asked = Asked {
            inks: style.inks().into_iter().map(ask).collect(),
            distance,
            water: renderer.eye_target(eye, &WATER),
            water_layer: style.layers.iter().position(|layer| matches!(layer, Layer::Water(_))),
            haze_m: seen_light(&self.world.surfaces, &rig, style, &self.light()).haze_m,
            part,
        };
        if self.touch.toucher.ask(&self.gpu, asked) {
            let now = Instant::now();
            self.touch.wish_px = None;
            self.touch.asked = Some((self.settings.style, now + DOUBLE_CLICK));
            self.touch.next_look = now + ANSWER_LOOK;
        }
    }

    /// Shows the layer that the GPU has answered. Returns whether there is one.
    pub(super) fn take_touched(&mut self, now: Instant) -> bool {
        self.touch.next_look = now + ANSWER_LOOK;
        while let Some(answer) = self.touch.toucher.take() {
            self.touch.answer = Some(answer.touched);
        }
        let Some((style, shown_at)) = self.touch.asked else { return false };
        if self.touch.answer.is_none() && !self.touch.toucher.is_waiting() {
            self.touch.cancel();
            return false;
        }
        if now < shown_at {
            return false;
        }
        let Some(touched) = self.touch.answer else { return false };
        self.touch.cancel();
        if style != self.settings.style || self.compared.is_some() {
            return false;
        }
        let Some(document) = self.styles.document(style) else { return false };
        let key = match touched {
            Touched::Layer(layer) => document.key_of_drawn(layer),
            Touched::Tone => Some("tone".to_owned()),
            Touched::Sky => Some("sky".to_owned()),
        };
        let Some(key) = key else { return false };
        let is_news = !self.dock.is_shown(Pane::Style);
        self.dock.set_shown(Pane::Style, true);
        self.inspector.select(key.clone());
        self.inspector_is_old = true;
        if is_news {
            let text =
                format!("{}: the layer under the cursor (I closes the inspector)", crate::studio::rows::title(&key));
            self.say(About::Edit, text, TOAST);
        }
        true
    }
}
