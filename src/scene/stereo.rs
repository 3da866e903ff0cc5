//! Two eyes beside a camera, and which of them a picture shows.
//!
//! Why: `docs/decisions/stereo.md`.

use std::fmt;
use std::str::FromStr;

use super::view::{Lens, Pose, Rig, View};

/// Between the eyes of most people.
pub const IPD_M: f64 = 0.065;

/// Eyes so far apart, of the nearest land that is seen, show a mountain as a thing on a table.
pub const HYPERSTEREO: f64 = 1.0 / 30.0;

/// Which eyes a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Eyes {
    /// One, at the camera.
    #[default]
    Mono,
    /// The left one of a pair.
    Left,
    /// The right one of a pair.
    Right,
    /// Both, the left one on the left.
    SideBySide,
    /// Both in one picture: the left one for a red glass, the right one for a cyan glass.
    Anaglyph,
    /// The same without colours of its own.
    GreyAnaglyph,
}

impl Eyes {
    /// Their names, in the order of the variants.
    pub const NAMES: [(&str, Self); 6] = [
        ("mono", Self::Mono),
        ("left", Self::Left),
        ("right", Self::Right),
        ("side-by-side", Self::SideBySide),
        ("anaglyph", Self::Anaglyph),
        ("grey-anaglyph", Self::GreyAnaglyph),
    ];

    /// Which eyes of a pair are read, left to right: 0 is the left one.
    pub fn of_pair(self) -> &'static [usize] {
        match self {
            Self::Mono => &[],
            Self::Left => &[0],
            Self::Right => &[1],
            Self::SideBySide | Self::Anaglyph | Self::GreyAnaglyph => &[0, 1],
        }
    }

    /// Whether both are in the same pixels.
    pub fn are_merged(self) -> bool {
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

/// How two eyes stand to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// From the left eye to the right one, along the camera's right.
    pub ipd_m: f64,
    /// Along the axis: what is there has no parallax on the picture. None is infinitely far. The axes are parallel all
    /// the same; the lenses are shifted.
    pub convergence_m: Option<f64>,
}

impl Default for Pair {
    fn default() -> Self {
        Self { ipd_m: IPD_M, convergence_m: None }
    }
}

impl Pair {
    /// The left and the right eye of a camera, whose place is the origin of both.
    pub fn rig(&self, camera: &View) -> Rig {
        self.rig_after(self, camera)
    }

    /// As [`Pair::rig`], of eyes that stood otherwise a frame ago.
    pub fn rig_after(&self, before: &Self, camera: &View) -> Rig {
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

    /// Of an eye that stands aside: the middle of its picture is where the camera's axis is at the convergence. None is
    /// the camera's own.
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

    /// How far to the right of the left eye's picture of it the right eye has a point, in pixels.
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
            // At any place across the axis.
            for aside_m in [DVec2::ZERO, DVec2::new(0.3, -0.2)] {
                let at_m = camera.pose.position_m + DVec3::new(aside_m.x, 1.0, aside_m.y) * away_m;
                let inverse = convergence_m.map_or(0.0, f64::recip);
                let expected = 0.5 * focal_px * (inverse - 1.0 / away_m);
                let found = parallax_px(&pair, at_m);
                assert!((found - expected).abs() < 1e-6, "{convergence_m:?}, {away_m} m: {found}, not {expected} px");
                // Planted: eyes exchanged.
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
