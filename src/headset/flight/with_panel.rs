//! The panel of a flight in the hands of its user, and the messages on it.

use std::time::{Duration, Instant};

use super::Flight;
use crate::headset::error::HeadsetError;
use crate::headset::menu::{MenuAction, MenuInput};
use crate::headset::panel::{Body, Page};
use crate::headset::stage::Eye;
use crate::headset::travel::HandInput;
use crate::style::StyleError;

/// Time for which the panel shows that a request failed.
const NOTICE: Duration = Duration::from_secs(6);

impl Flight {
    /// Reads the controllers, and carries out their requests to the panel. Returns the input that the flight follows.
    pub(super) fn follow_hands(&mut self, eyes: &[Eye; 2], step_s: f64) -> Result<HandInput, HeadsetError> {
        let is_focused = self.headset.is_focused();
        let (hand_input, menu_input) = match is_focused {
            true => self.hands.read(&self.headset.session, step_s)?,
            false => (HandInput::default(), MenuInput::default()),
        };
        // Until the first picture, the panel shows the current work.
        if self.shown.is_none() && self.drawn == 0 {
            return Ok(HandInput::default());
        }
        if !is_focused {
            self.menu.cancel();
            return Ok(hand_input);
        }
        let had_hands = self.menu.has_hands();
        let (actions, is_new) = self.menu.advance(&menu_input, step_s, &self.styles);
        if is_new {
            self.quad.place(eyes, self.headset.floor_m);
        }
        for action in actions {
            let done = match action {
                MenuAction::Style(name) => self.styles.choose(&name),
                MenuAction::Move(control, to) => self.styles.set_control(control, to),
                MenuAction::Release => {
                    self.styles.release();
                    Ok(())
                }
            };
            self.say(done);
        }
        if had_hands || self.menu.has_hands() {
            return Ok(HandInput::default());
        }
        if hand_input.next_style {
            let done = self.styles.choose_next();
            self.say(done);
        }
        Ok(hand_input)
    }

    /// Says on the panel what could not be done.
    fn say(&mut self, done: Result<(), StyleError>) {
        if let Err(error) = done {
            tracing::warn!("{error}");
            self.notice = Some((error.to_string(), Instant::now() + NOTICE));
            self.notice_is_new = true;
        }
    }

    /// Draws the page of the panel, if it is open, or if something could not be done.
    pub(super) fn draw_panel(&mut self, eyes: &[Eye; 2]) -> Result<(), HeadsetError> {
        let notice = self.notice.take().filter(|(_, until)| Instant::now() < *until);
        let page = if self.menu.is_open() {
            let controller = self.hands.controller(self.headset.instance(), &self.headset.session)?;
            let doing = self.doing();
            self.menu.page(&self.styles, controller, doing, &self.name)
        } else {
            let page = |(text, _): &(String, Instant)| Page {
                title: "This style cannot be drawn".to_owned(),
                body: Body::Text(text.clone()),
                ..Page::default()
            };
            notice.as_ref().map(page)
        };
        self.notice = notice;
        let Some(page) = page else { return Ok(()) };
        if std::mem::take(&mut self.notice_is_new) || !self.quad.is_placed() {
            self.quad.place(eyes, self.headset.floor_m);
        }
        self.quad.draw(page)
    }

    /// Returns the work that remains before the view is complete, and its progress, 0 to 1.
    fn doing(&mut self) -> Option<(String, Option<f32>)> {
        if let Some(opening) = &self.opening {
            return Some(opening.doing());
        }
        let [loaded, wanted] = self.tiles;
        if self.shown.is_none() {
            let left = self.headset.gpu.pipelines().being_built();
            self.most_built = self.most_built.max(left);
            let built = self.most_built - left;
            let text = match self.most_built {
                0 => format!("Loading land: {loaded} of {wanted} tiles"),
                most => format!("Building {}: {built} of {most} shaders", self.styles.title()),
            };
            let done = (self.most_built > 0).then(|| built as f32 / self.most_built as f32);
            return Some((text, done));
        }
        let text = format!("Loading land: {loaded} of {wanted} tiles");
        (loaded < wanted).then(|| (text, Some(loaded as f32 / wanted as f32)))
    }
}
