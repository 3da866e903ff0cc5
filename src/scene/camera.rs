//! The camera, written in scene files, camera paths and on the command line as `x,y,z,yaw,pitch,fov`.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use crate::file::message::shown;

/// Smallest and largest vertical field of view, in degrees.
pub(crate) const FOV_RANGE_DEG: [f64; 2] = [0.1, 170.0];

/// Largest absolute coordinate: more than twice the earth's circumference, and small enough that nothing overflows.
pub(crate) const LARGEST_COORDINATE_M: f64 = 1e8;

/// Largest absolute yaw: 1000 turns, so that fractions of a degree keep their digits.
const LARGEST_YAW_DEG: f64 = 360_000.0;

/// The fields in the order in which they are written.
const FIELDS: [&str; 6] = ["x", "y", "z", "yaw", "pitch", "fov"];

/// The position, direction and field of view of a camera.
///
/// It is written and parsed as `x,y,z,yaw,pitch,fov`; z is written `+h` for h metres above the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// East, north, up in the world's frame, in metres. z is above the ground if [`Camera::height_above_ground`].
    pub position_m: DVec3,
    /// Whether z is relative to the ground below the camera (it was given as `+h`). [`Camera::on_ground`] resolves it.
    pub height_above_ground: bool,
    /// Clockwise from north, in degrees. Not wrapped: 370 and 10 look the same way.
    pub yaw_deg: f64,
    /// Elevation above the horizon, in degrees, −90 to 90.
    pub pitch_deg: f64,
    /// Vertical field of view in degrees, within [`FOV_RANGE_DEG`].
    pub fov_deg: f64,
}

/// Why a text is not a valid camera.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// There are too few or too many fields.
    #[error("a camera is x,y,z,yaw,pitch,fov (6 numbers), but this has {found}")]
    FieldCount {
        /// Number of fields in the text.
        found: usize,
    },
    /// A field is not a number, or is out of range.
    #[error("the camera's {field} is `{}`: {cause}", shown(value))]
    Field {
        /// One of x, y, z, yaw, pitch, fov.
        field: &'static str,
        value: String,
        /// The reason why the value is invalid.
        cause: String,
    },
}

impl Camera {
    /// Returns the unit vector along which the camera looks, in the world's frame.
    pub fn forward(&self) -> DVec3 {
        let (sin_yaw, cos_yaw) = self.yaw_deg.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch_deg.to_radians().sin_cos();
        DVec3::new(sin_yaw * cos_pitch, cos_yaw * cos_pitch, sin_pitch)
    }

    /// Returns the unit vector to the right of the picture, in the world's frame; it is always level.
    pub fn right(&self) -> DVec3 {
        let (sin_yaw, cos_yaw) = self.yaw_deg.to_radians().sin_cos();
        DVec3::new(cos_yaw, -sin_yaw, 0.0)
    }

    /// Returns the unit vector to the top of the picture, in the world's frame.
    pub fn up(&self) -> DVec3 {
        self.right().cross(self.forward())
    }

    /// Returns the camera with z in the world's frame. `ground_m(x, y)` is the height of the ground in metres; it is
    /// called only for a camera above the ground.
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
    /// The first field that is not a number or is out of range.
    pub(crate) fn from_fields(fields: [&str; 6]) -> Result<Self, CameraError> {
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
    // Only z may have a plus sign, which has been removed here: `++5` is a typing error, not a number.
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
            Err(fields) => Err(CameraError::FieldCount { found: fields.len() }),
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
