//! The camera, as scene files, camera paths and the command line write it: `x,y,z,yaw,pitch,fov`.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use crate::file::message::shown;

/// The narrowest and the widest vertical field of view, in degrees.
pub const FOV_RANGE_DEG: [f64; 2] = [0.1, 170.0];

/// No coordinate may be larger: more than twice the earth's circumference, small enough that nothing overflows.
pub const LARGEST_COORDINATE_M: f64 = 1e8;

/// The most turns a yaw may hold: 1000, so that its fractions of a degree keep their digits.
const LARGEST_YAW_DEG: f64 = 360_000.0;

/// The fields in the order in which they are written.
const FIELDS: [&str; 6] = ["x", "y", "z", "yaw", "pitch", "fov"];

/// Where the picture is taken from, and how.
///
/// Written and parsed as `x,y,z,yaw,pitch,fov`; z is written `+h` for h metres above the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// East, north, up in the world's frame, in metres. z is above the ground if [`Camera::height_above_ground`].
    pub position_m: DVec3,
    /// Whether z counts from the ground below the camera (it was given as `+h`). [`Camera::on_ground`] resolves it.
    pub height_above_ground: bool,
    /// Clockwise from north, in degrees. Not wrapped: 370 looks where 10 does.
    pub yaw_deg: f64,
    /// Up from the horizon, in degrees, −90 to 90.
    pub pitch_deg: f64,
    /// Vertical field of view in degrees, within [`FOV_RANGE_DEG`].
    pub fov_deg: f64,
}

/// Why a text is no camera.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// Too few or too many fields.
    #[error("a camera is x,y,z,yaw,pitch,fov (6 numbers), but `{}` has {found}", shown(text))]
    FieldCount {
        /// What was given.
        text: String,
        /// Its number of fields.
        found: usize,
    },
    /// A field that is no number, or not one that it may hold.
    #[error("the camera's {field} is `{}`: {cause}", shown(value))]
    Field {
        /// One of x, y, z, yaw, pitch, fov.
        field: &'static str,
        /// What was given.
        value: String,
        /// What is wrong with it.
        cause: String,
    },
}

impl Camera {
    /// The unit vector along which the camera looks, in the world's frame.
    pub fn forward(&self) -> DVec3 {
        let (sin_yaw, cos_yaw) = self.yaw_deg.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch_deg.to_radians().sin_cos();
        DVec3::new(sin_yaw * cos_pitch, cos_yaw * cos_pitch, sin_pitch)
    }

    /// The unit vector to the right of the picture, in the world's frame; always level.
    pub fn right(&self) -> DVec3 {
        let (sin_yaw, cos_yaw) = self.yaw_deg.to_radians().sin_cos();
        DVec3::new(cos_yaw, -sin_yaw, 0.0)
    }

    /// The unit vector to the top of the picture, in the world's frame.
    pub fn up(&self) -> DVec3 {
        self.right().cross(self.forward())
    }

    /// The same camera with z in the world's frame. `ground_m(x, y)` is the height of the ground in metres; it is
    /// asked only for a camera above ground.
    pub fn on_ground(&self, ground_m: impl FnOnce(f64, f64) -> f64) -> Self {
        if !self.height_above_ground {
            return *self;
        }
        let mut camera = *self;
        camera.position_m.z += ground_m(camera.position_m.x, camera.position_m.y);
        camera.height_above_ground = false;
        camera
    }

    /// Parses the six fields of a camera, in the order x, y, z, yaw, pitch, fov.
    ///
    /// # Errors
    /// Names the first field that is no number or out of its range.
    pub fn from_fields(fields: [&str; 6]) -> Result<Self, CameraError> {
        let z = fields[2].trim();
        let height_above_ground = z.starts_with('+');
        let z = z.strip_prefix('+').unwrap_or(z);
        let mut numbers = [0.0; 6];
        for (index, text) in fields.into_iter().enumerate() {
            let text = if index == 2 { z } else { text.trim() };
            numbers[index] = number(FIELDS[index], text)?;
        }
        let [x, y, z, yaw_deg, pitch_deg, fov_deg] = numbers;
        for (field, value) in [("x", x), ("y", y), ("z", z)] {
            in_range(field, value, [-LARGEST_COORDINATE_M, LARGEST_COORDINATE_M], "m")?;
        }
        in_range("yaw", yaw_deg, [-LARGEST_YAW_DEG, LARGEST_YAW_DEG], "degrees")?;
        in_range("pitch", pitch_deg, [-90.0, 90.0], "degrees")?;
        in_range("fov", fov_deg, FOV_RANGE_DEG, "degrees")?;
        Ok(Self { position_m: DVec3::new(x, y, z), height_above_ground, yaw_deg, pitch_deg, fov_deg })
    }
}

fn number(field: &'static str, text: &str) -> Result<f64, CameraError> {
    let wrong = |cause: &str| CameraError::Field { field, value: text.to_owned(), cause: cause.to_owned() };
    // Only z may carry a plus, and there it has been taken off: `++5` is a slip, not a number.
    if field == "z" && text.starts_with('+') {
        return Err(wrong("not a number"));
    }
    let value: f64 = text.parse().map_err(|_| wrong("not a number"))?;
    if value.is_finite() { Ok(value) } else { Err(wrong("not finite")) }
}

fn in_range(field: &'static str, value: f64, [low, high]: [f64; 2], unit: &str) -> Result<(), CameraError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let cause = format!("it must be between {low} and {high} {unit}");
    let value = if value.abs() < 1e12 { value.to_string() } else { format!("{value:e}") };
    Err(CameraError::Field { field, value, cause })
}

impl FromStr for Camera {
    type Err = CameraError;

    fn from_str(text: &str) -> Result<Self, CameraError> {
        let fields: Vec<&str> = text.split(',').collect();
        match <[&str; 6]>::try_from(fields) {
            Ok(fields) => Self::from_fields(fields),
            Err(fields) => Err(CameraError::FieldCount { text: text.to_owned(), found: fields.len() }),
        }
    }
}

impl fmt::Display for Camera {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.position_m;
        let plus = if self.height_above_ground { "+" } else { "" };
        write!(f, "{x},{y},{plus}{z},{},{},{}", self.yaw_deg, self.pitch_deg, self.fov_deg)
    }
}
