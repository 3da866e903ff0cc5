//! The focus of a picture: a place, a distance or a region of the page around which everything has full contrast.
//!
//! Draughtsmen give one place the darkest darks, the sharpest edges and the most detail, and hold back around it. The
//! remaining contrast at a distance d from the focus is 1 − strength · (1 − exp(−(d / extent − 1)²)), and 1 within
//! `extent`. It depends on the position alone, so it does not flicker as the camera moves. The GPU implementation is
//! `shaders/shared/focus.wgsl`. Why: `docs/decisions/focus.md`.

use glam::{DVec2, DVec3};
use serde::Deserialize;

use crate::gpu::bind::Resource;
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Recorder;
pub(crate) use crate::gpu::wgsl::shared::focus::Focus as FocusUniform;
use crate::gpu::wgsl::shared::focus::{AT_DISTANCE, AT_PLACE, NO_FOCUS, ON_PICTURE, THINNER};
use crate::gpu::wgsl::shared::view::View as ViewUniform;

/// The place where contrast is strongest, and its falloff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// The centre of the focus.
    pub about: FocusAbout,
    /// Radius of full contrast: in metres, or in picture heights for [`FocusAbout::Picture`]. Greater than 0.
    pub extent: f64,
    /// Share of the contrast that is lost far from the focus, 0 to 1.
    pub strength: f64,
}

/// The centre of a focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusAbout {
    /// A distance from the eye.
    Distance {
        /// Distance in metres, greater than 0.
        distance_m: f64,
    },
    /// A point of the picture.
    Picture {
        /// Position from the upper left corner, in fractions of width and height.
        at: DVec2,
    },
    /// A place in the world.
    Place {
        /// East, north and up, in metres; in a frame's light relative to the rig's origin, on the curved earth.
        at_m: DVec3,
        /// Whether height counts in the distance from the place.
        has_height: bool,
        /// Unit vector away from the earth's centre.
        up: DVec3,
    },
}

/// The focus of a scene: a place and its fall-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneFocus {
    /// East and north in the world's frame, in metres.
    pub place_m: DVec2,
    /// Height in metres; `None` puts every height above the place into the focus.
    pub height_m: Option<f64>,
    /// Radius of full contrast in metres, greater than 0.
    pub radius_m: f64,
    /// Share of the contrast that is lost far from the place, 0 to 1.
    pub strength: f64,
}

/// Default share of the contrast that is lost far from the focus.
pub(crate) const STRENGTH: f64 = 0.7;

impl std::fmt::Display for SceneFocus {
    /// Writes `EAST,NORTH,RADIUS,STRENGTH`, which can be parsed again.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { place_m, radius_m, strength, .. } = self;
        write!(f, "{},{},{radius_m},{strength}", place_m.x, place_m.y)
    }
}

impl std::str::FromStr for SceneFocus {
    type Err = String;

    /// Parses `EAST,NORTH,RADIUS` and an optional strength.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "it must be EAST,NORTH,RADIUS in metres, and optionally a strength from 0 to 1, like \
                        1200,-300,2000,0.7"
        };
        let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([east_m, north_m, radius_m, strength @ ..]) if strength.len() < 2 => {
                let strength = strength.first().copied().unwrap_or(STRENGTH);
                let focus =
                    Self { place_m: DVec2::new(*east_m, *north_m), height_m: None, radius_m: *radius_m, strength };
                focus.check().map(|()| focus).map_err(|(_, cause)| cause.to_owned())
            }
            _ => Err(wrong().to_owned()),
        }
    }
}

/// `[focus]` of a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FocusToml {
    place: Vec<f64>,
    radius_m: f64,
    strength: Option<f64>,
}

impl FocusToml {
    /// Validates the section; the error is the key and what is wrong with it.
    pub(super) fn checked(&self) -> Result<SceneFocus, (&'static str, &'static str)> {
        let (place_m, height_m) = match *self.place.as_slice() {
            [east_m, north_m] => ([east_m, north_m], None),
            [east_m, north_m, height_m] => ([east_m, north_m], Some(height_m)),
            _ => ([f64::NAN; 2], None),
        };
        let strength = self.strength.unwrap_or(STRENGTH);
        let focus = SceneFocus { place_m: place_m.into(), height_m, radius_m: self.radius_m, strength };
        focus.check().map(|()| focus)
    }
}

impl SceneFocus {
    /// Checks that the numbers are in range.
    ///
    /// # Errors
    /// The key in the scene's section `focus`, and the cause.
    pub(crate) fn check(&self) -> Result<(), (&'static str, &'static str)> {
        let heights_m = self.height_m.unwrap_or(0.0);
        if !self.place_m.is_finite() || !heights_m.is_finite() {
            return Err(("focus.place", "it must be an east, a north and optionally a height, in finite metres"));
        }
        if !(self.radius_m.is_finite() && self.radius_m > 0.0) {
            return Err(("focus.radius_m", "the radius must be finite and greater than 0"));
        }
        if !(0.0..=1.0).contains(&self.strength) {
            return Err(("focus.strength", "the strength must be between 0 and 1"));
        }
        Ok(())
    }

    /// Returns the focus in the world's frame.
    pub(crate) fn focus(&self) -> Focus {
        let (at_m, has_height) = (self.place_m.extend(self.height_m.unwrap_or(0.0)), self.height_m.is_some());
        let about = FocusAbout::Place { at_m, has_height, up: DVec3::Z };
        Focus { about, extent: self.radius_m, strength: self.strength }
    }
}

impl Focus {
    /// Returns the focus for a rig at `origin_m` in the world. `bend` maps positions on the flat map, relative to that
    /// origin, to positions on the curved earth.
    #[must_use]
    pub(crate) fn seen_from(self, origin_m: DVec3, bend: impl Fn(DVec3) -> DVec3) -> Self {
        let FocusAbout::Place { at_m, has_height, .. } = self.about else { return self };
        let flat_m = at_m - origin_m;
        let up = (bend(flat_m + DVec3::Z) - bend(flat_m)).normalize_or(DVec3::Z);
        Self { about: FocusAbout::Place { at_m: bend(flat_m), has_height, up }, ..self }
    }

    /// Returns the remaining contrast, 0 to 1, of a point `at_m` from the rig's origin that is seen at pixel `px`.
    pub(crate) fn left(&self, view: &ViewUniform, at_m: [f32; 3], px: [f32; 2]) -> f32 {
        let at_m = DVec3::from_array(at_m.map(f64::from));
        let off = match self.about {
            FocusAbout::Distance { distance_m } => {
                (at_m.distance(DVec3::from_array(view.eye_m.map(f64::from))) - distance_m).abs()
            }
            FocusAbout::Picture { at } => {
                let [x, y] = [0, 1].map(|axis| f64::from(px[axis]) + f64::from(view.origin_px[axis]));
                let picture_px = DVec2::from_array(view.picture_px.map(f64::from));
                DVec2::new(x, y).distance(at * picture_px) / picture_px.y
            }
            FocusAbout::Place { at_m: place_m, has_height, up } => {
                let away_m = at_m - place_m;
                let up = if has_height { DVec3::ZERO } else { up };
                (away_m - up * away_m.dot(up)).length()
            }
        };
        let t = (off / self.extent - 1.0).max(0.0);
        (1.0 - self.strength * (1.0 - (-t * t).exp())) as f32
    }

    /// Returns the relative width of a line where the share `left` of its contrast remains.
    pub(crate) fn width(left: f32) -> f32 {
        1.0 - THINNER * (1.0 - left)
    }
}

/// The focus for shaders. It is a storage buffer because one driver fails where branches depend on more than three
/// uniform buffers (`docs/decisions/software-drivers.md`).
const FOCUS: BufferKind = BufferKind::storage("focus");

impl FocusUniform {
    /// Uploads the focus and returns its binding for the passes of this frame.
    pub(crate) fn on_gpu(recorder: &mut Recorder<'_>, focus: Option<&Focus>) -> Resource {
        recorder.upload(&FOCUS, &[Self::new(focus)]).binding()
    }

    /// Converts the focus of a frame's light to its GPU form.
    pub(crate) fn new(focus: Option<&Focus>) -> Self {
        let Some(&Focus { about, extent, strength }) = focus else {
            return Self { about: NO_FOCUS, ..Self::default() };
        };
        let (extent, strength) = (extent as f32, strength as f32);
        let uniform = Self { extent, strength, ..Self::default() };
        match about {
            FocusAbout::Distance { distance_m } => {
                Self { about: AT_DISTANCE, distance_m: distance_m as f32, ..uniform }
            }
            FocusAbout::Picture { at } => {
                Self { about: ON_PICTURE, at: at.as_vec2().extend(0.0).to_array(), ..uniform }
            }
            FocusAbout::Place { at_m, has_height, up } => {
                let axis = if has_height { DVec3::ZERO } else { up };
                Self { about: AT_PLACE, at: at_m.as_vec3().to_array(), axis: axis.as_vec3().to_array(), ..uniform }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn a_place_with_a_radius_is_read() {
        let focus: SceneFocus = "1200, -300,2000".parse().unwrap();
        assert_eq!((focus.place_m, focus.radius_m), (DVec2::new(1200.0, -300.0), 2000.0));
        assert_eq!((focus.height_m, focus.strength), (None, STRENGTH));
        assert_eq!(focus.to_string().parse(), Ok(focus));
        assert_eq!("0,0,5,0.25".parse::<SceneFocus>().unwrap().strength, 0.25);
        for wrong in ["", "1,2", "1,2,0", "1,2,-3", "nan,0,1", "1,2,inf", "1,2,3,2", "1,2,3,0.5,6", "a,b,c"] {
            assert!(wrong.parse::<SceneFocus>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn contrast_falls_smoothly_away_from_a_place() {
        let focus = SceneFocus { place_m: DVec2::new(500.0, 0.0), height_m: None, radius_m: 100.0, strength: 0.8 };
        let seen = focus.focus().seen_from(DVec3::new(400.0, 0.0, 50.0), |flat_m| flat_m);
        let left = |at_m: [f32; 3]| seen.left(&ViewUniform::default(), at_m, [0.0; 2]);
        assert_eq!([left([100.0, 0.0, -50.0]), left([200.0, 0.0, 1e4])], [1.0; 2], "any height is in the focus");
        assert!((left([300.0, 0.0, 0.0]) - (1.0 - 0.8 * (1.0 - (-1.0_f32).exp()))).abs() < 1e-6);
        assert!((left([1e5, 0.0, 0.0]) - 0.2).abs() < 1e-6);
        let low = Focus { about: FocusAbout::Place { at_m: DVec3::ZERO, has_height: true, up: DVec3::Z }, ..seen };
        assert!(low.left(&ViewUniform::default(), [0.0, 0.0, 1e4], [0.0; 2]) < 0.21);
    }
}
