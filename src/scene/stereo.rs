//! Stereo pairs: two eyes placed around a camera, and which of them a picture shows.
//!
//! Why: `docs/decisions/stereo.md`.

use std::fmt;
use std::str::FromStr;

use super::view::{Lens, Pose, Rig, View};

/// Mean distance between human eyes, in metres.
pub const IPD_M: f64 = 0.065;

/// Ratio of eye separation to the nearest visible land at which a mountain looks like a model on a table.
pub(crate) const HYPERSTEREO: f64 = 1.0 / 30.0;

/// Which eyes a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Eyes {
    /// A single eye at the camera.
    #[default]
    Mono,
    /// The left eye of a stereo pair.
    Left,
    /// The right eye of a stereo pair.
    Right,
    /// Both eyes, the left one on the left.
    SideBySide,
    /// Both eyes in one picture, for red-cyan glasses: the left eye for the red glass, the right eye for the cyan
    /// glass.
    Anaglyph,
    /// An anaglyph in greyscale.
    GreyAnaglyph,
}

impl Eyes {
    /// The names on the command line, in the order of the variants.
    pub(crate) const NAMES: [(&str, Self); 6] = [
        ("mono", Self::Mono),
        ("left", Self::Left),
        ("right", Self::Right),
        ("side-by-side", Self::SideBySide),
        ("anaglyph", Self::Anaglyph),
        ("grey-anaglyph", Self::GreyAnaglyph),
    ];

    /// Returns the eyes of a pair that are shown, left to right: 0 is the left one. Empty for mono.
    pub(crate) fn of_pair(self) -> &'static [usize] {
        match self {
            Self::Mono => &[],
            Self::Left => &[0],
            Self::Right => &[1],
            Self::SideBySide | Self::Anaglyph | Self::GreyAnaglyph => &[0, 1],
        }
    }

    /// Whether both eyes share the same pixels.
    pub(crate) fn are_merged(self) -> bool {
        matches!(self, Self::Anaglyph | Self::GreyAnaglyph)
    }
}

impl FromStr for Eyes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::NAMES.iter().find(|(name, _)| *name == text);
        known
            .map(|(_, eyes)| *eyes)
            .ok_or_else(|| "it must be mono, left, right, side-by-side, anaglyph or grey-anaglyph".to_owned())
    }
}

impl fmt::Display for Eyes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(_, eyes)| eyes == self).map_or("", |(name, _)| name);
        out.write_str(name)
    }
}

/// The geometry of a stereo pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Distance from the left eye to the right one, along the camera's right axis.
    pub ipd_m: f64,
    /// Distance along the axis that has no parallax in the picture; `None` is infinity. The axes stay parallel; the
    /// lenses are shifted instead.
    pub convergence_m: Option<f64>,
}

impl Default for Pair {
    fn default() -> Self {
        Self { ipd_m: IPD_M, convergence_m: None }
    }
}

impl Pair {
    /// Returns the left and the right eye of a camera, whose position is the rig's origin.
    pub fn rig(&self, camera: &View) -> Rig {
        self.rig_after(self, camera)
    }

    /// Returns [`Pair::rig`] for eyes that had the geometry `before` in the previous frame.
    pub(crate) fn rig_after(&self, before: &Self, camera: &View) -> Rig {
        let eye = |side: f64| {
            let seen = |pair: &Self, pose: Pose| {
                let aside_m = 0.5 * side * pair.ipd_m;
                let lens = pair.lens(aside_m, &pose, camera.picture_px);
                (Pose { position_m: pose.position_m + pose.right * aside_m, ..pose }, lens)
            };
            let (pose, lens) = seen(self, camera.pose);
            let (previous, previous_lens) = seen(before, camera.previous);
            View { pose, previous, lens, previous_lens, ..*camera }
        };
        Rig { origin_m: camera.pose.position_m, eyes: vec![eye(-1.0), eye(1.0)] }
    }

    /// Returns the lens of an eye at `aside_m` to the right of the camera: the centre of its picture is on the camera's
    /// axis at the convergence distance. `None` is the camera's own lens.
    fn lens(&self, aside_m: f64, pose: &Pose, picture_px: [u32; 2]) -> Option<Lens> {
        let shift = self.convergence_m.map_or(0.0, |away_m| aside_m / away_m);
        let up = (0.5 * pose.fov_rad).tan();
        let across = up * f64::from(picture_px[0]) / f64::from(picture_px[1]);
        (shift != 0.0).then_some(Lens { left: across + shift, right: across - shift, up, down: up })
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    const SIZE_PX: [u32; 2] = [640, 360];

    fn camera() -> View {
        let (forward, right) = (DVec3::Y, DVec3::X);
        let pose = Pose { position_m: DVec3::new(5.0, 6.0, 7.0), forward, right, up: DVec3::Z, fov_rad: 1.0 };
        View::whole(pose, pose, SIZE_PX)
    }

    /// Returns how much farther to the right a point is in the right eye's picture than in the left eye's, in pixels.
    fn parallax_px(pair: &Pair, at_m: DVec3) -> f64 {
        let [left, right] = [0, 1].map(|eye| {
            let view = pair.rig(&camera()).eyes[eye];
            view.place_px(at_m - view.pose.position_m).unwrap()
        });
        assert!((left.y - right.y).abs() < 1e-9, "eyes are level");
        right.x - left.x
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        for (name, eyes) in Eyes::NAMES {
            assert_eq!((name.parse(), eyes.to_string().as_str()), (Ok(eyes), name));
        }
        assert!("both".parse::<Eyes>().unwrap_err().contains("side-by-side"));
    }

    #[test]
    fn parallax_is_that_of_the_distance() {
        let camera = camera();
        let focal_px = camera.focal_px();
        for (convergence_m, away_m) in
            [(None, 4.0), (None, 1e6), (Some(10.0), 4.0), (Some(10.0), 10.0), (Some(2.0), 1e6)]
        {
            let pair = Pair { ipd_m: 0.5, convergence_m };
            // At any position across the axis.
            for aside_m in [DVec2::ZERO, DVec2::new(0.3, -0.2)] {
                let at_m = camera.pose.position_m + DVec3::new(aside_m.x, 1.0, aside_m.y) * away_m;
                let inverse = convergence_m.map_or(0.0, f64::recip);
                let expected = 0.5 * focal_px * (inverse - 1.0 / away_m);
                let found = parallax_px(&pair, at_m);
                assert!((found - expected).abs() < 1e-6, "{convergence_m:?}, {away_m} m: {found}, not {expected} px");
                // Planted: the eyes are swapped.
                let exchanged = parallax_px(&Pair { ipd_m: -0.5, convergence_m }, at_m);
                assert!(expected.abs() < 1e-3 || (exchanged - expected).abs() > 1e-3);
            }
        }
    }

    #[test]
    fn eyes_at_one_place_are_the_camera() {
        let camera = camera();
        for convergence_m in [None, Some(3.0)] {
            let rig = Pair { ipd_m: 0.0, convergence_m }.rig(&camera);
            assert_eq!(rig.eyes, [camera, camera]);
        }
        assert_ne!(Pair::default().rig(&camera).eyes[0], camera);
    }
}
