//! The gallery of a flight, and its favourites.

use std::path::Path;
use std::sync::mpsc::TryRecvError;
use std::time::Instant;

use super::Flight;
use crate::studio::document::StyleDocument;
use crate::studio::folder::StyleSearch;
use crate::window::WindowError;
use crate::window::gallery::thumbnails::Scene;
use crate::window::gallery::{Choice, families, thumbnail_px};
use crate::window::toasts::About;

use super::controls::TOAST;

impl Flight {
    /// Opens or closes the gallery.
    pub(super) fn toggle_gallery(&mut self) {
        self.gallery.is_open = !self.gallery.is_open;
        if self.gallery.is_open {
            self.thumbnails.wake(Instant::now());
            let path = self.styles.document(self.settings.style).and_then(StyleDocument::path);
            let folder = path.and_then(Path::parent).unwrap_or(Path::new(""));
            self.style_search = StyleSearch::start(folder.to_owned());
        } else {
            self.thumbnails.sleep();
            self.style_search = None;
        }
    }

    /// Carries out the user's choices in the gallery.
    pub(super) fn choose(&mut self, choices: Vec<Choice>) {
        for choice in choices {
            match choice {
                Choice::Style(style) => self.settings.style = style,
                Choice::Favourite(style, digit) => self.set_favourite(style, digit),
                Choice::Close => self.toggle_gallery(),
            }
        }
    }

    /// Carries out a digit, counted from 0: over a thumbnail it makes the style a favourite, otherwise it chooses one.
    pub(super) fn digit(&mut self, digit: usize) {
        if let Some(style) = self.gallery.hovered() {
            self.set_favourite(style, Some(digit));
            return;
        }
        let Some(name) = self.favourites.get(digit).map(str::to_owned) else {
            let text = format!("No style is favourite {}; the gallery (G) sets favourites", digit + 1);
            self.say(About::Style, text, TOAST);
            return;
        };
        match self.styles.place_of(&name) {
            Some(style) => self.settings.style = style,
            None => match StyleDocument::open(&name) {
                Ok(document) => self.settings.style = self.styles.add(document),
                Err(error) => self.say(About::Style, error.to_string(), TOAST),
            },
        }
    }

    fn set_favourite(&mut self, style: usize, digit: Option<usize>) {
        let name = self.styles.list()[style].name.clone();
        let text = match (self.favourites.set(digit, &self.styles.lasting_name(style)), digit) {
            (Err(error), _) => error,
            (Ok(()), Some(digit)) => format!("{name} is favourite {}", digit + 1),
            (Ok(()), None) => format!("{name} is no favourite"),
        };
        self.say(About::Style, text, TOAST);
        self.needs_relayout = true;
    }

    /// Draws thumbnails of the gallery while the camera is at rest, and takes the styles that its folder has. Returns
    /// whether the gallery has changed.
    pub(super) fn fill_gallery(&mut self, is_still: bool) -> Result<bool, WindowError> {
        if !self.gallery.is_open {
            return Ok(false);
        }
        let mut has_news = false;
        let now = Instant::now();
        while let Some(search) = &self.style_search {
            match search.take() {
                Ok(document) if self.styles.place_of(document.name()).is_none() => {
                    self.styles.add(document);
                    has_news = true;
                }
                Ok(_) => {}
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => self.style_search = None,
            }
            self.thumbnails.wake(now);
        }
        if !is_still {
            self.thumbnails.wake(now);
            return Ok(has_news);
        }
        let scene =
            Scene { pose: self.camera.pose(), light: self.light(), shown_px: thumbnail_px(self.overlay.context()) };
        let order: Vec<usize> = families(&self.styles).into_iter().flat_map(|(_, group)| group).collect();
        let (world, overlay) = (&mut self.world.surfaces, &mut self.overlay);
        has_news |= self.thumbnails.work(&self.gpu, world, overlay, scene, self.styles.list(), &order)?;
        Ok(has_news)
    }

    /// Notices that another style was chosen.
    pub(super) fn style_changed(&mut self, before: usize) {
        self.previous_style = before;
        self.thumbnails.wake(Instant::now());
    }
}
