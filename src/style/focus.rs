//! The `[focus]` section of a style: where the picture has its strongest contrast.

use glam::DVec2;

use super::Color;
use super::parameters::{Range, parameters};
use crate::scene::focus::{Focus as SeenFocus, FocusAbout};

parameters! {
    /// The region of strongest contrast. Away from it ink becomes thinner, tones fade and detail decreases. A focus in
    /// the scene file takes precedence.
    pub struct Focus {
        /// Fraction of the contrast that is lost far from the focus.
        strength called "Loss of contrast": f32 = 0.7 => Range::Within(0.0, 1.0);
        /// Distance of the focus from the eye, not on maps; without it the focus is a position on the picture.
        distance_m: Option<f32> => Range::Above(0.0), soft 100_000.0;
        /// Range before and behind that distance in which contrast is full.
        depth_m called "Range of distances": f32 = 1000.0 => Range::Above(0.0), soft 100_000.0;
        /// Horizontal position of the focus on the picture: 0 is the left edge, 1 the right edge.
        across called "Position across": f32 = 0.5 => Range::Within(0.0, 1.0);
        /// Vertical position of the focus on the picture: 0 is the top edge, 1 the bottom edge.
        down called "Position down": f32 = 0.6 => Range::Within(0.0, 1.0);
        /// Radius around that position in which contrast is full, as a fraction of the picture's height.
        radius: f32 = 0.25 => Range::Within(0.01, 10.0);
        /// Colour that tones fade to far from the focus; the default is bare paper, or the haze colour where haze is
        /// dark.
        color called "Fading colour": Option<Color>;
    }
}

impl Focus {
    /// Returns the focus in the form that a frame uses.
    pub(crate) fn seen(&self) -> SeenFocus {
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
