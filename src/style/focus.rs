//! Focus of a style.

use glam::DVec2;

use super::Color;
use super::parameters::{Range, parameters};
use crate::scene::focus::{Focus as SeenFocus, FocusAbout};

parameters! {
    /// Where the strongest contrast is: away from it ink thins, tones go toward the haze and detail drops. A place that a
    /// scene names comes before it.
    pub struct Focus {
        /// How much of the contrast is gone far from the focus.
        strength: f32 = 0.7 => Range::Within(0.0, 1.0);
        /// Distance of the focus from the eye; without it the focus is a place on the picture, and on maps there is none.
        distance_m: Option<f32> => Range::Above(0.0);
        /// How far before and behind that distance contrast is full.
        depth_m: f32 = 1000.0 => Range::Above(0.0);
        /// Where on the picture the focus is, from its left, in parts of its width.
        across: f32 = 0.5 => Range::Within(0.0, 1.0);
        /// The same from its top, in parts of its height.
        down: f32 = 0.6 => Range::Within(0.0, 1.0);
        /// How far about that place contrast is full, in parts of the picture's height.
        radius: f32 = 0.25 => Range::Within(0.01, 10.0);
        /// What tones far from the focus go to; without it bare paper, or the haze in styles whose haze is dark.
        color: Option<Color>;
    }
}

impl Focus {
    /// As a frame has it.
    pub fn seen(&self) -> SeenFocus {
        let strength = self.strength.into();
        match self.distance_m {
            Some(distance_m) => {
                let about = FocusAbout::Distance { distance_m: distance_m.into() };
                SeenFocus { about, extent: self.depth_m.into(), strength }
            }
            None => {
                let about = FocusAbout::Picture { at: DVec2::new(self.across.into(), self.down.into()) };
                SeenFocus { about, extent: self.radius.into(), strength }
            }
        }
    }
}
