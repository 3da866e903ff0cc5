//! Camera paths: CSV with the header `t,x,y,z,yaw,pitch,fov`, and a C1 spline through its rows. A last column `ease` may
//! follow.
//!
//! The spline is a cubic Hermite spline over the rows' own times. A row's tangent is the derivative of the parabola
//! through the row and its two neighbours, which on evenly spaced rows equals Catmull-Rom; the first and last row take
//! the slope of the one segment that they have.
//!
//! Two rows with the same time are a jump: one curve ends at the first row and another begins at the second, and at
//! that time the second row applies. No tangent takes a slope across a jump.
//!
//! `ease` is the part of its speed that the camera loses at a row: the tangent is multiplied by 1 − ease. With 0 the
//! camera passes through, with 1 it comes to rest. The curve stays C1 (`docs/decisions/camera-paths.md`).

use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::camera::{Camera, FOV_RANGE_DEG};
use super::embedded;
use crate::file::input::{LARGEST_PATH_BYTES, read_text};
use crate::file::message::{did_you_mean, named, printable, shown};

/// The columns in the required order.
pub(crate) const HEADER: [&str; 7] = ["t", "x", "y", "z", "yaw", "pitch", "fov"];

/// The column that may follow.
pub(crate) const EASE: &str = "ease";

/// Smallest allowed time between rows, in seconds; shorter steps are probably mistakes, and slopes must stay finite.
pub(crate) const SHORTEST_STEP_S: f64 = 1e-6;

/// Largest allowed absolute time, in seconds: a year.
pub(crate) const LATEST_S: f64 = 366.0 * 86_400.0;

/// The interpolated values: x, y, z, yaw (unwrapped), pitch, fov.
type Values = [f64; 6];

/// A moving camera: a C1 curve through the rows of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    times_s: Vec<f64>,
    values: Vec<Values>,
    tangents: Vec<Values>,
    height_above_ground: bool,
}

/// Why a file is not a valid camera path. One line that names the file, the line and the cause.
#[derive(Debug, thiserror::Error)]
pub enum PathError {
    /// The file cannot be read.
    #[error("cannot read the camera path {}: {cause}", named(path))]
    Open {
        /// Path of the file.
        path: PathBuf,
        #[source]
        cause: io::Error,
    },
    /// A line is wrong.
    #[error("{}:{line}: {cause}", named(path))]
    Line {
        /// Path of the file.
        path: PathBuf,
        /// Line number, counted from 1 with the header.
        line: u64,
        /// The reason why the line is invalid.
        cause: String,
    },
}

impl PathError {
    /// Returns whether the path was given as a bare name, like a built-in path, but no such path exists.
    pub(crate) fn is_unknown_name(&self) -> bool {
        match self {
            Self::Open { path, cause } => {
                cause.kind() == ErrorKind::NotFound && !path.to_string_lossy().contains(['.', '/', '\\'])
            }
            _ => false,
        }
    }
}

/// One row of the file, with its line number for messages.
struct Row {
    line: u64,
    time_s: f64,
    camera: Camera,
    ease: f64,
}

/// A row of a path's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Key {
    /// Line number, counted from 1 with the header.
    pub line: u64,
    /// Time on the file's own clock.
    pub time_s: f64,
    pub camera: Camera,
    /// The part of its speed that the camera loses here, 0 to 1.
    pub ease: f64,
}

impl CameraPath {
    /// Reads a path whose z values are either all in the world's frame or all above the ground (`+h`). In the second
    /// case the sampled cameras are above the ground as well, so the flight follows the terrain.
    ///
    /// # Errors
    /// A file that cannot be read; a header other than `t,x,y,z,yaw,pitch,fov` with or without `ease`; no row; a row that
    /// is not a valid camera; times that do not increase, except for jumps; a mixture of both kinds of z.
    pub fn read(path: &Path) -> Result<Self, PathError> {
        Self::parse(path, Self::read_text(path)?.as_bytes())
    }

    /// Parses a path like [`CameraPath::read`], from text. `name` is the file name for messages.
    ///
    /// # Errors
    /// The same as [`CameraPath::read`].
    pub fn parse(name: &Path, text: impl Read) -> Result<Self, PathError> {
        let rows = rows(name, text)?;
        if let Some(odd) = rows.iter().find(|row| row.camera.height_above_ground != rows[0].camera.height_above_ground)
        {
            let cause =
                "z is above the ground (+h) in some rows and absolute in others; use one kind in all rows".to_owned();
            return Err(PathError::Line { path: name.to_owned(), line: odd.line, cause });
        }
        Ok(Self::through(&rows))
    }

    /// Reads a path whose z values may be of both kinds: rows above the ground are converted with the ground height at
    /// their position, so the path is in the world's frame. `ground_m(x, y)` is the height of the ground in metres.
    ///
    /// # Errors
    /// The same as [`CameraPath::read`], except that z of both kinds is allowed.
    pub fn read_on_ground(path: &Path, ground_m: impl Fn(f64, f64) -> f64) -> Result<Self, PathError> {
        Self::parse_on_ground(path, Self::read_text(path)?.as_bytes(), ground_m)
    }

    /// Parses a path like [`CameraPath::read_on_ground`], from text. `name` is the file name for messages.
    ///
    /// # Errors
    /// The same as [`CameraPath::read_on_ground`].
    pub(crate) fn parse_on_ground(
        name: &Path,
        text: impl Read,
        ground_m: impl Fn(f64, f64) -> f64,
    ) -> Result<Self, PathError> {
        let mut rows = rows(name, text)?;
        for row in &mut rows {
            row.camera = row.camera.on_ground(&ground_m);
        }
        Ok(Self::through(&rows))
    }

    /// A camera at the origin, in place of the cameras of a path that are not known yet.
    pub(crate) const ORIGIN: Camera =
        Camera { position_m: DVec3::ZERO, height_above_ground: false, yaw_deg: 0.0, pitch_deg: 0.0, fov_deg: 50.0 };

    /// Returns all rows as they are written.
    ///
    /// # Errors
    /// The same as [`CameraPath::read_on_ground`].
    pub(crate) fn keys(name: &Path, text: impl Read) -> Result<Vec<Key>, PathError> {
        let key = |Row { line, time_s, camera, ease }| Key { line, time_s, camera, ease };
        Ok(rows(name, text)?.into_iter().map(key).collect())
    }

    /// Returns the text of a file, or of a built-in path, for callers that parse it twice: a pipe can be read only
    /// once.
    ///
    /// # Errors
    /// A file that cannot be read, is too long, or is not text.
    pub(crate) fn read_text(path: &Path) -> Result<String, PathError> {
        if let Some(text) = embedded::path(path) {
            return Ok(text.to_owned());
        }
        read_text(path, LARGEST_PATH_BYTES).map_err(|cause| {
            // A bare name may be meant as that of a built-in path.
            let is_bare = !path.to_string_lossy().contains(['.', '/', '\\']);
            let cause = match cause.kind() {
                ErrorKind::NotFound if is_bare => {
                    let meant = did_you_mean(&path.to_string_lossy(), embedded::PATHS.map(|(name, _)| name));
                    let names = embedded::path_names();
                    io::Error::new(cause.kind(), format!("{cause}; the built-in paths are {names}{meant}"))
                }
                _ => cause,
            };
            PathError::Open { path: path.to_owned(), cause }
        })
    }

    /// Returns the path of a camera that does not move.
    pub fn still(camera: Camera) -> Self {
        Self::through(&[Row { line: 1, time_s: 0.0, camera, ease: 0.0 }])
    }

    fn through(rows: &[Row]) -> Self {
        let times_s: Vec<f64> = rows.iter().map(|row| row.time_s).collect();
        let mut values: Vec<Values> = Vec::with_capacity(rows.len());
        for Row { camera, .. } in rows {
            let DVec3 { x, y, z } = camera.position_m;
            let mut yaw_deg = camera.yaw_deg;
            if let Some(previous) = values.last() {
                // The shorter way round from the previous row: a step within −180 to 180.
                yaw_deg = previous[3] + (yaw_deg - previous[3] + 180.0).rem_euclid(360.0) - 180.0;
            }
            values.push([x, y, z, yaw_deg, camera.pitch_deg, camera.fov_deg]);
        }
        let mut tangents = tangents(&times_s, &values);
        for (tangent, row) in tangents.iter_mut().zip(rows) {
            tangent.iter_mut().for_each(|slope| *slope *= 1.0 - row.ease);
        }
        Self { times_s, values, tangents, height_above_ground: rows[0].camera.height_above_ground }
    }

    /// Returns the times of the rows in seconds, at least one. They increase, except at jumps, whose time occurs twice.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Returns the time from the first row to the last, in seconds; 0 for one row.
    pub fn duration_s(&self) -> f64 {
        self.times_s[self.times_s.len() - 1] - self.times_s[0]
    }

    /// Returns the camera at `time_s` on the file's own clock; before the first row the first camera, after the last
    /// row the last. The yaw continues beyond 360 instead of jumping.
    pub fn sample(&self, time_s: f64) -> Camera {
        let last = self.times_s.len() - 1;
        if last == 0 || time_s.is_nan() || time_s <= self.times_s[0] {
            return self.camera(self.values[0]);
        }
        if time_s >= self.times_s[last] {
            return self.camera(self.values[last]);
        }
        let next = self.times_s.partition_point(|&row_s| row_s <= time_s);
        let row = next - 1;
        let step_s = self.times_s[next] - self.times_s[row];
        let u = (time_s - self.times_s[row]) / step_s;
        // Cubic Hermite basis.
        let start = (1.0 + 2.0 * u) * (1.0 - u) * (1.0 - u);
        let start_slope = u * (1.0 - u) * (1.0 - u) * step_s;
        let end_slope = u * u * (u - 1.0) * step_s;
        let values = std::array::from_fn(|k| {
            start * self.values[row][k]
                + (1.0 - start) * self.values[next][k]
                + start_slope * self.tangents[row][k]
                + end_slope * self.tangents[next][k]
        });
        self.camera(values)
    }

    fn camera(&self, [x, y, z, yaw_deg, pitch_deg, fov_deg]: Values) -> Camera {
        Camera {
            position_m: DVec3::new(x, y, z),
            height_above_ground: self.height_above_ground,
            yaw_deg,
            // The spline may overshoot rows at the limits.
            pitch_deg: pitch_deg.clamp(-90.0, 90.0),
            fov_deg: fov_deg.clamp(FOV_RANGE_DEG[0], FOV_RANGE_DEG[1]),
        }
    }

    /// Returns the number of frames of [`CameraPath::frames`], at least one. `fps` must be positive and finite.
    pub fn frame_count(&self, fps: f64) -> usize {
        // The last row is a frame as well, and rounding must not drop it: 0.1 s at 30 fps is 3 steps, not 2.99….
        (self.duration_s() * fps + 1e-6).floor() as usize + 1
    }

    /// Returns the cameras of a film at `fps` frames per second, starting at the first row.
    pub fn frames(&self, fps: f64) -> impl ExactSizeIterator<Item = Camera> + '_ {
        (0..self.frame_count(fps)).map(move |frame| self.sample(self.times_s[0] + frame as f64 / fps))
    }

    /// Returns `count` cameras, evenly spaced in time from the first row to the last, both included.
    pub fn spread(&self, count: usize) -> impl ExactSizeIterator<Item = Camera> + '_ {
        self.spread_s(count).map(|time_s| self.sample(time_s))
    }

    /// Returns the times of the cameras of [`CameraPath::spread`], in seconds.
    pub(crate) fn spread_s(&self, count: usize) -> impl ExactSizeIterator<Item = f64> + use<> {
        let (start_s, step_s) = (self.times_s[0], self.duration_s() / count.saturating_sub(1).max(1) as f64);
        (0..count).map(move |camera| start_s + camera as f64 * step_s)
    }
}

/// Parses the rows of a path and checks the header, that there is at least one row, and that times increase.
fn rows(name: &Path, text: impl Read) -> Result<Vec<Row>, PathError> {
    let wrong = |line: u64, cause: String| PathError::Line { path: name.to_owned(), line, cause };
    let csv_error = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        match error.kind() {
            csv::ErrorKind::Utf8 { .. } => wrong(line, "it is not valid UTF-8".to_owned()),
            _ => wrong(line, printable(&error.to_string(), 120)),
        }
    };
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(true)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text);
    let header = reader.headers().map_err(csv_error)?;
    let names: Vec<&str> = header.iter().map(|name| name.trim_start_matches('\u{feff}')).collect();
    if names.iter().all(|name| name.is_empty()) {
        return Err(wrong(1, format!("the header is missing; the first line must be `{}`", HEADER.join(","))));
    }
    let has_ease = names.split_last() == Some((&EASE, &HEADER[..]));
    if names != HEADER && !has_ease {
        return Err(wrong(
            1,
            format!(
                "the header is `{}`; it must be `{}`, and `,{EASE}` may follow",
                shown(&names.join(",")),
                HEADER.join(",")
            ),
        ));
    }
    let wanted = names.len();
    let mut rows: Vec<Row> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(csv_error)?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut fields: Vec<&str> = record.iter().collect();
        if fields.len() != wanted {
            return Err(wrong(line, format!("found {} fields; there must be {wanted}", fields.len())));
        }
        let ease = if has_ease { fields.pop().unwrap_or_default() } else { "" };
        let [time, camera @ ..] = <[&str; 7]>::try_from(fields)
            .map_err(|fields| wrong(line, format!("found {} fields; there must be {wanted}", fields.len())))?;
        let ease = match ease {
            "" => 0.0,
            text => text
                .parse()
                .ok()
                .filter(|ease| (0.0..=1.0).contains(ease))
                .ok_or_else(|| wrong(line, format!("{EASE} is `{}`; it must be between 0 and 1", shown(text))))?,
        };
        let time_s: f64 = time.parse().map_err(|_| wrong(line, format!("t is `{}`: not a number", shown(time))))?;
        if time_s.is_nan() || time_s.abs() > LATEST_S {
            return Err(wrong(line, format!("t is `{}`; it must be in seconds, at most a year from 0", shown(time))));
        }
        if let Some(previous) = rows.last()
            && time_s - previous.time_s < SHORTEST_STEP_S
            && !is_jump(&rows, time_s)
        {
            let before = previous.time_s;
            let cause = match time_s == before {
                true => format!("t is {time_s} again; a jump is two rows with equal t, and not the first two"),
                false => format!("t is {time_s} after {before}; times must increase by at least 1 µs"),
            };
            return Err(wrong(line, cause));
        }
        let camera = Camera::from_fields(camera).map_err(|error| wrong(line, error.to_string()))?;
        rows.push(Row { line, time_s, camera, ease });
    }
    if rows.is_empty() {
        return Err(wrong(2, "a camera path needs at least one row".to_owned()));
    }
    Ok(rows)
}

/// Whether a row at `time_s` after these is a valid jump: the second row of that time, and not at the very start.
fn is_jump(rows: &[Row], time_s: f64) -> bool {
    matches!(rows, [.., before, last] if time_s == last.time_s && before.time_s < last.time_s)
}

fn tangents(times_s: &[f64], values: &[Values]) -> Vec<Values> {
    let last = times_s.len() - 1;
    let slope = |row: usize, k: usize| (values[row + 1][k] - values[row][k]) / (times_s[row + 1] - times_s[row]);
    // There is no slope across a jump.
    let step_s = |row: usize| Some(times_s.get(row + 1)? - times_s[row]).filter(|&step_s| step_s > 0.0);
    let tangent = |row: usize, k: usize| match (row.checked_sub(1).and_then(step_s), step_s(row)) {
        (None, None) => 0.0,
        (None, Some(_)) => slope(row, k),
        (Some(_), None) => slope(row - 1, k),
        (Some(before_s), Some(after_s)) => {
            (slope(row - 1, k) * after_s + slope(row, k) * before_s) / (before_s + after_s)
        }
    };
    (0..=last).map(|row| std::array::from_fn(|k| tangent(row, k))).collect()
}
