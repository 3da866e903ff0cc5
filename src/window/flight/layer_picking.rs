//! A click on the picture selects the layer that drew there, in the inspector.

use std::time::Instant;

use glam::DVec2;

use super::Flight;
use super::controls::TOAST;
use super::navigate::ANSWER_CHECK;
use crate::frame::seen_light;
use crate::scene::view::{Rig, View};
use crate::style::layers::Layer;
use crate::surface::DISTANCE;
use crate::surface::water::WATER;
use crate::window::dock::Pane;
use crate::window::input::DOUBLE_CLICK;
use crate::window::layer_picking::{DrawnPart, InkPicture, LayerPicker, PickRequest};
use crate::window::toasts::About;

/// A click on the picture whose layer is not selected yet.
pub(super) struct LayerPicking {
    picker: LayerPicker,
    /// Position of a click that waits for a picture of the chosen style, in pixels of the window.
    waiting_px: Option<DVec2>,
    /// Style of the clicks that were requested from the GPU, and when no second click can follow any more.
    requested: Option<(usize, Instant)>,
    answer: Option<DrawnPart>,
    next_check: Instant,
}

impl LayerPicking {
    /// Creates the state without a click.
    pub(super) fn new() -> Self {
        Self { picker: LayerPicker::new(), waiting_px: None, requested: None, answer: None, next_check: Instant::now() }
    }

    /// Forgets the last click.
    pub(super) fn cancel(&mut self) {
        self.waiting_px = None;
        self.requested = None;
        self.answer = None;
        self.picker.forget();
    }

    /// Returns when to check for an answer, or to show it.
    pub(super) fn due_at(&self) -> Option<Instant> {
        let (_, shown_at) = self.requested?;
        Some(if self.answer.is_some() { shown_at } else { self.next_check })
    }
}

impl Flight {
    /// Selects the layer that drew at a position of the window, when the GPU has answered.
    pub(super) fn pick_layer(&mut self, cursor_px: DVec2) {
        self.layer_picking.cancel();
        self.layer_picking.waiting_px = Some(cursor_px);
        self.request_picked_layer();
    }

    /// Requests the layer for the last click, if the picture is that of the chosen style.
    pub(super) fn request_picked_layer(&mut self) {
        let Some(cursor_px) = self.layer_picking.waiting_px else { return };
        let Some((eye, part)) = self.eye_at(cursor_px) else {
            self.layer_picking.waiting_px = None;
            return;
        };
        let Some(renderer) = self.renderer.as_ref().filter(|renderer| self.shows_chosen_style() && renderer.drew())
        else {
            return;
        };
        let Some(distance) = renderer.eye_target(eye, &DISTANCE) else { return };
        let style = self.style();
        let ink_picture = |ink: crate::style::layers::StyleInk| {
            let picture = ink.layer.and_then(|layer| renderer.ink_target(eye, layer));
            InkPicture { ink, picture }
        };
        let pose = self.last.pose;
        let rig = Rig::mono(View::whole(pose, pose, renderer.size_px()));
        let request = PickRequest {
            inks: style.inks().into_iter().map(ink_picture).collect(),
            distance,
            water: renderer.eye_target(eye, &WATER),
            water_layer: style.layers.iter().position(|layer| matches!(layer, Layer::Water(_))),
            haze_m: seen_light(&self.world.surfaces, &rig, style, &self.light()).haze_m,
            part,
        };
        if self.layer_picking.picker.request(&self.gpu, request) {
            let now = Instant::now();
            self.layer_picking.waiting_px = None;
            self.layer_picking.requested = Some((self.settings.style, now + DOUBLE_CLICK));
            self.layer_picking.next_check = now + ANSWER_CHECK;
        }
    }

    /// Selects the layer in the inspector if the GPU has answered. Returns whether it has.
    pub(super) fn take_picked_layer(&mut self, now: Instant) -> bool {
        self.layer_picking.next_check = now + ANSWER_CHECK;
        while let Some(answer) = self.layer_picking.picker.take() {
            self.layer_picking.answer = Some(answer.part);
        }
        let Some((style, shown_at)) = self.layer_picking.requested else { return false };
        if self.layer_picking.answer.is_none() && !self.layer_picking.picker.is_waiting() {
            self.layer_picking.cancel();
            return false;
        }
        if now < shown_at {
            return false;
        }
        let Some(part) = self.layer_picking.answer else { return false };
        self.layer_picking.cancel();
        if style != self.settings.style || self.compared.is_some() {
            return false;
        }
        let Some(document) = self.styles.document(style) else { return false };
        let key = match part {
            DrawnPart::Layer(layer) => document.key_of_drawn(layer),
            DrawnPart::Tone => Some("tone".to_owned()),
            DrawnPart::Sky => Some("sky".to_owned()),
        };
        let Some(key) = key else { return false };
        let was_closed = !self.dock.is_shown(Pane::Style);
        self.dock.set_shown(Pane::Style, true);
        self.inspector.select(key.clone());
        self.needs_relayout = true;
        if was_closed {
            let title = crate::studio::rows::title(&key);
            let text = match part {
                DrawnPart::Layer(_) => format!("{title}: the layer that drew here (I closes the inspector)"),
                DrawnPart::Tone | DrawnPart::Sky => {
                    format!("{title}: no layer has drawn here (I closes the inspector)")
                }
            };
            self.say(About::Edit, text, TOAST);
        }
        true
    }
}
