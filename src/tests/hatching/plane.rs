//! A plane whose geometry is known exactly, and pictures of its hatching.

use glam::{DVec2, DVec3};
use hachure::file::exr::Samples;
use hachure::frame::{Light, Renderer};
use hachure::picture::{self, PartRule, PictureRequest, aov};
use hachure::scene::view::{Pose, View};
use hachure::style::Style;

use crate::tests::common::{World, grid_of};

/// Half of the side of the land.
pub const HALF_M: f64 = 60_000.0;

/// A plane through the world's origin that rises toward the north by `tilt_deg`.
pub struct Plane {
    pub world: World,
    renderer: Option<Renderer>,
    tilt_rad: f64,
}

/// Largest difference between the mean ink of windows and a tone, for windows with hard and with soft borders.
#[derive(Clone, Copy, Debug, Default)]
pub struct Off {
    pub hard: f64,
    pub soft: f64,
}

/// Ink of a picture, row by row, with the points that its pixels show.
pub struct Inked {
    pub size_px: [usize; 2],
    pub view: View,
    /// From 0 (paper) to 1 (ink).
    pub ink: Vec<f64>,
    /// In the world; `None` for the sky.
    pub place_m: Vec<Option<DVec3>>,
    /// Id of the terrain's patch.
    pub patch: Vec<u32>,
}

impl Plane {
    pub fn new(tilt_deg: f64) -> Option<Self> {
        let slope = tilt_deg.to_radians().tan();
        let grid = grid_of(241, 241, HALF_M / 120.0, |_, y| y * slope);
        Some(Self { world: World::new(grid, 1.0)?, renderer: None, tilt_rad: tilt_deg.to_radians() })
    }

    pub fn normal(&self) -> DVec3 {
        DVec3::new(0.0, -self.tilt_rad.sin(), self.tilt_rad.cos())
    }

    /// Returns an eye at `distance_m` from the point `x_m` east on the plane's axis, looking at it, at an angle of
    /// `from_normal_deg` to the normal there; `around_deg` rotates it about the normal.
    pub fn eye(&self, x_m: f64, distance_m: f64, from_normal_deg: f64, around_deg: f64, fov_deg: f64) -> Pose {
        let normal = self.normal();
        let (sine, cosine) = around_deg.to_radians().sin_cos();
        let downhill = DVec3::X.cross(normal) * -1.0;
        let aside = downhill * cosine + DVec3::X * sine;
        let (sine, cosine) = from_normal_deg.to_radians().sin_cos();
        let back = normal * cosine + aside * sine;
        let forward = -back;
        let up = if from_normal_deg < 1.0 { -aside } else { normal };
        let right = forward.cross(up).normalize();
        Pose {
            position_m: DVec3::X * x_m + back * distance_m,
            forward,
            right,
            up: right.cross(forward),
            fov_rad: fov_deg.to_radians(),
        }
    }

    pub fn shoot(&mut self, pose: Pose, size_px: [u32; 2], style: &Style) -> Inked {
        shoot(&mut self.world, &mut self.renderer, pose, size_px, style)
    }

    /// Returns where the ray through a point of the picture meets the plane, in the world.
    pub fn hit(&self, view: &View, px: DVec2) -> DVec3 {
        let ray = view.ray(px);
        let normal = self.normal();
        view.pose.position_m - ray * (view.pose.position_m.dot(normal) / ray.dot(normal))
    }
}

pub fn shoot(
    world: &mut World,
    renderer: &mut Option<Renderer>,
    pose: Pose,
    size_px: [u32; 2],
    style: &Style,
) -> Inked {
    let planes = aov::planes("hatch,position,surface", style).unwrap();
    let light = Light { to_sun: DVec3::new(-0.5, 0.5, 0.7).normalize(), haze_m: 1e12, haze_srgb: None, focus: None };
    let request = PictureRequest { planes: &planes, ..PictureRequest::still(pose, size_px, style, light) };
    let (mut floats, mut patch): ([Vec<f64>; 4], _) = (Default::default(), Vec::new());
    let take = |band: picture::Band| {
        let mut rest = floats.iter_mut();
        for samples in band.planes {
            match samples {
                Samples::F32(values) => rest.next().unwrap().extend(values.into_iter().map(f64::from)),
                Samples::U32(values) => patch.extend(values),
            }
        }
        Ok::<_, std::convert::Infallible>(())
    };
    picture::render_in_parts(&world.gpu, renderer, &mut world.surfaces, &request, &PartRule::default(), take).unwrap();
    let [tone, x, y, z] = floats;
    let place = |i: usize| (patch[i] != 0).then(|| pose.position_m + DVec3::new(x[i], y[i], z[i]));
    Inked {
        size_px: size_px.map(|side| side as usize),
        view: View::whole(pose, pose, size_px),
        ink: tone.iter().map(|tone| 1.0 - tone).collect(),
        place_m: (0..patch.len()).map(place).collect(),
        patch,
    }
}

impl Inked {
    pub fn at(&self, x: usize, y: usize) -> f64 {
        self.ink[y * self.size_px[0] + x]
    }

    /// Returns the ink between pixels, whose centres are at half numbers; `None` outside.
    pub fn between(&self, px: DVec2) -> Option<f64> {
        let place = px - 0.5;
        let whole = place.floor();
        let inside = whole.cmpge(DVec2::ZERO).all()
            && whole.x + 1.0 < self.size_px[0] as f64
            && whole.y + 1.0 < self.size_px[1] as f64;
        if !inside {
            return None;
        }
        let (x, y, f) = (whole.x as usize, whole.y as usize, place - whole);
        let upper = self.at(x, y) * (1.0 - f.x) + self.at(x + 1, y) * f.x;
        let lower = self.at(x, y + 1) * (1.0 - f.x) + self.at(x + 1, y + 1) * f.x;
        Some(upper * (1.0 - f.y) + lower * f.y)
    }

    /// Returns the largest difference between the mean ink of a square of `side` pixels and `darkness`, over squares
    /// that overlap by half: with the hard border of a square, which cuts marks, and with a Gaussian of the same
    /// spread.
    pub fn worst_window(&self, side: usize, darkness: f64) -> Off {
        let [width, height] = self.size_px;
        let sigma = side as f64 / 12.0_f64.sqrt();
        let reach = (2.4 * sigma).ceil() as i64;
        let bell: Vec<f64> = (-reach..=reach).map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp()).collect();
        let whole: f64 = bell.iter().sum();
        // Gaussian sums along rows in the columns of the windows' middles, then down these columns; too near the border
        // there are none.
        let inside = |at: usize, size: usize| at as i64 >= reach && (at as i64) < size as i64 - reach;
        let mut rows = vec![0.0; self.ink.len()];
        for y in 0..height {
            for x in (0..width).step_by(side / 2).filter(|x| inside(*x, width)) {
                let first = y * width + x - reach as usize;
                rows[y * width + x] = bell.iter().zip(&self.ink[first..]).map(|(weight, ink)| weight * ink).sum();
            }
        }
        let mut off = Off::default();
        for y in (0..=height - side).step_by(side / 2) {
            for x in (0..=width - side).step_by(side / 2) {
                let sum: f64 = (y..y + side).map(|y| self.ink[y * width + x..][..side].iter().sum::<f64>()).sum();
                off.hard = off.hard.max((sum / (side * side) as f64 - darkness).abs());
                let (x, y) = (x + side / 2, y + side / 2);
                if inside(x, width) && inside(y, height) {
                    let rows = (y - reach as usize..).step_by(1).map(|y| rows[y * width + x]);
                    let sum: f64 = bell.iter().zip(rows).map(|(weight, row)| weight * row).sum();
                    off.soft = off.soft.max((sum / (whole * whole) - darkness).abs());
                }
            }
        }
        off
    }

    pub fn mean(&self) -> f64 {
        self.ink.iter().sum::<f64>() / self.ink.len() as f64
    }
}

/// Returns a style of even tone `1 - darkness` with the given layers (TOML tables).
pub fn style(scale: &str, darkness: f64, layers: &str) -> Style {
    let tone = 1.0 - darkness;
    let text = format!(
        "name = \"even\"\ndescription = \"an even tone\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = {tone}\n\
         lightest = {tone}\nwash = 0.0\n[hatching]\nscale = \"{scale}\"\n{layers}"
    );
    Style::parse("even", &text).unwrap()
}

/// Returns one layer of marks in a fixed direction.
pub fn fixed(marks: &str, angle_deg: f64) -> String {
    format!("[[hatching.layers]]\nmarks = \"{marks}\"\ndirection = \"fixed\"\nangle_deg = {angle_deg}\n")
}
