//! A camera path that is being edited: its text, its key frames, its history, and its file.
//!
//! The text is that of a CSV file ([`CameraPath`]), and is all that there is: keys and curve follow from it, so that the
//! window flies what `render` films. An edit changes only the lines that it concerns. Comments and other lines stay.
//!
//! A document without a key is allowed, as a beginning; it cannot be saved or flown.

mod lines;
mod saving;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use self::lines::Lines;
use super::history::History;
use crate::scene::camera::Camera;
use crate::scene::path::{CameraPath, EASE, HEADER, Key, LATEST_S, PathError};

/// Time between a new last key and the one before, in seconds.
const NEW_STEP_S: f64 = 4.0;
/// Least time between two keys that an edit leaves, in seconds.
const LEAST_STEP_S: f64 = 0.01;

/// A camera path that is being edited.
#[derive(Debug)]
pub(crate) struct PathDocument {
    /// Name for people and errors: the path of the file, the name of a built-in path, or empty.
    name: String,
    path: Option<PathBuf>,
    text: String,
    keys: Vec<Key>,
    /// The curve in the world's frame; `None` without keys.
    curve: Option<CameraPath>,
    /// The text that is saved.
    saved: String,
    /// The text of the file, which differs from what is saved if its lines could not be kept.
    file_text: String,
    history: History,
    /// Heights of the ground below cameras that are given above it, by the bits of x and y.
    grounds: FxHashMap<[u64; 2], f64>,
}

impl PathDocument {
    /// Returns a document without keys.
    pub(crate) fn empty() -> Self {
        let text = format!("{}\n", HEADER.join(","));
        Self {
            name: String::new(),
            path: None,
            keys: Vec::new(),
            curve: None,
            saved: text.clone(),
            file_text: text.clone(),
            text,
            history: History::default(),
            grounds: FxHashMap::default(),
        }
    }

    /// Returns the document of a file or of a built-in path, which has no `path`. `ground_m(x, y)` is the height of the
    /// ground in metres.
    ///
    /// # Errors
    /// The errors of [`CameraPath::read_on_ground`].
    pub(crate) fn of_text(
        name: &str,
        path: Option<PathBuf>,
        text: &str,
        ground_m: impl Fn(f64, f64) -> f64,
    ) -> Result<Self, PathError> {
        let keys = CameraPath::keys(Path::new(name), text.as_bytes())?;
        // Quotes, for example, may contain ends of lines.
        let lines = Lines::of(text).filter(|lines| lines.len() == keys.len()).unwrap_or_else(|| Lines::of_keys(&keys));
        let mut document = Self { name: name.to_owned(), path, ..Self::empty() };
        for Key { camera, .. } in keys.iter().filter(|key| key.camera.height_above_ground) {
            let [x, y] = [camera.position_m.x, camera.position_m.y];
            document.grounds.insert([x, y].map(f64::to_bits), ground_m(x, y));
        }
        document.show(lines.text())?;
        document.saved.clone_from(&document.text);
        text.clone_into(&mut document.file_text);
        Ok(document)
    }

    /// Returns the path of the file, the name of a built-in path, or nothing.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the file of the path.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Returns the keys in the order of their times.
    pub(crate) fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// Returns the curve in the world's frame; `None` without keys.
    pub(crate) fn curve(&self) -> Option<&CameraPath> {
        self.curve.as_ref()
    }

    /// Returns the first and the last time; both are 0 without keys.
    pub(crate) fn span_s(&self) -> [f64; 2] {
        match self.keys.as_slice() {
            [] => [0.0; 2],
            [first, .., last] => [first.time_s, last.time_s],
            [only] => [only.time_s; 2],
        }
    }

    /// Returns whether the text differs from what is saved.
    pub(crate) fn is_edited(&self) -> bool {
        self.text != self.saved
    }

    /// Returns the names of the steps that can be undone and repeated.
    pub(crate) fn step_names(&self) -> [Option<&str>; 2] {
        self.history.names()
    }

    /// Returns the number of steps that can be undone.
    #[cfg(test)]
    pub(crate) fn undo_count(&self) -> usize {
        self.history.len()
    }

    /// Takes the heights of the ground again, because it has changed. `ground_m(x, y)` is the height in metres, if it is
    /// known.
    pub(crate) fn set_ground(&mut self, ground_m: impl Fn(f64, f64) -> Option<f64>) {
        for [x, y] in self.ground_places() {
            if let Some(height_m) = ground_m(x, y) {
                self.grounds.insert([x, y].map(f64::to_bits), height_m);
            }
        }
        let text = std::mem::take(&mut self.text);
        // The same text is as valid as before.
        let _ = self.show(text);
    }

    /// Returns the east and north of all cameras that are or were given above the ground, in metres.
    pub(crate) fn ground_places(&self) -> Vec<[f64; 2]> {
        let known = self.grounds.keys().map(|place| place.map(f64::from_bits));
        let above = self.keys.iter().filter(|key| key.camera.height_above_ground);
        known.chain(above.map(|key| [key.camera.position_m.x, key.camera.position_m.y])).collect()
    }

    /// Adds a key at a time. Returns its index.
    ///
    /// # Errors
    /// One line: there is a key at that time, or the time is out of range.
    pub(crate) fn add(&mut self, time_s: f64, camera: &Camera) -> Result<usize, String> {
        let time_s = rounded(time_s);
        if self.keys.iter().any(|key| (key.time_s - time_s).abs() < LEAST_STEP_S) {
            return Err(format!("There is a key frame at {time_s} s already"));
        }
        let index = self.keys.partition_point(|key| key.time_s < time_s);
        let key = Key { line: 0, time_s, camera: written(camera), ease: 0.0 };
        self.change(format!("add the key at {time_s} s"), None, |lines| lines.insert(index, &key))?;
        Ok(index)
    }

    /// Returns a time for a new key while the playhead is at `playhead_s`: there, or behind the last key if it is at its
    /// end, or in the middle of a segment if it is at another key.
    pub(crate) fn time_for_new(&self, playhead_s: f64) -> f64 {
        let Some(last) = self.keys.last() else { return 0.0 };
        let near = |key: &Key| (key.time_s - playhead_s).abs() < 2.0 * LEAST_STEP_S;
        if playhead_s > last.time_s - 2.0 * LEAST_STEP_S {
            return if near(last) { last.time_s + NEW_STEP_S } else { playhead_s };
        }
        match self.keys.iter().rposition(near) {
            Some(index) => 0.5 * (self.keys[index].time_s + self.keys[index + 1].time_s),
            None => playhead_s,
        }
    }

    /// Moves a key in time, at most to its neighbours. Both rows of a jump move. While the mouse is held, further moves
    /// belong to the same step; [`PathDocument::release`] ends it.
    ///
    /// # Errors
    /// One line, if the time is not valid; then nothing changes.
    pub(crate) fn move_to(&mut self, index: usize, time_s: f64) -> Result<(), String> {
        let before_s = self.keys[index].time_s;
        let together: Vec<usize> = (0..self.keys.len()).filter(|other| self.keys[*other].time_s == before_s).collect();
        let [first, last] = [together[0], together[together.len() - 1]];
        let after = first.checked_sub(1).map_or(before_s.min(0.0), |other| self.keys[other].time_s + LEAST_STEP_S);
        let until = self.keys.get(last + 1).map_or(LATEST_S, |key| key.time_s - LEAST_STEP_S);
        // Neighbours that are nearer than the least step keep their distance.
        let time_s = rounded(time_s).clamp(after.min(before_s), until.max(before_s));
        if time_s == before_s {
            return Ok(());
        }
        let name = format!("move the key to {time_s} s");
        self.change(name, Some(&format!("time {first}")), |lines| {
            together.iter().for_each(|other| lines.set_time(*other, time_s));
        })
    }

    /// Replaces the camera of a key.
    ///
    /// # Errors
    /// One line, if the camera is not valid; then nothing changes.
    pub(crate) fn replace(&mut self, index: usize, camera: &Camera) -> Result<(), String> {
        let key = Key { camera: written(camera), ..self.keys[index] };
        self.change(format!("replace the key at {} s", key.time_s), None, |lines| lines.replace(index, &key))
    }

    /// Removes a key. The first row of a jump goes too if no curve leads to it any more.
    ///
    /// # Errors
    /// None in fact: the rest is valid.
    pub(crate) fn remove(&mut self, index: usize) -> Result<(), String> {
        let name = format!("delete the key at {} s", self.keys[index].time_s);
        let mut times: Vec<f64> = self.keys.iter().map(|key| key.time_s).collect();
        times.remove(index);
        let jumps_first = matches!(times.as_slice(), [a, b, ..] if a == b);
        self.change(name, None, |lines| {
            lines.remove(index);
            if jumps_first {
                lines.remove(0);
            }
        })
    }

    /// Sets how much the camera slows down at a key: 0 passes through, 1 comes to rest. While the mouse is held, further
    /// values belong to the same step.
    ///
    /// # Errors
    /// One line, if the value is not valid; then nothing changes.
    pub(crate) fn set_ease(&mut self, index: usize, ease: f64) -> Result<(), String> {
        let ease = (ease.clamp(0.0, 1.0) * 100.0).round() / 100.0;
        if ease == self.keys[index].ease {
            return Ok(());
        }
        let name = format!("ease the key at {} s", self.keys[index].time_s);
        let is_plain =
            self.keys.iter().enumerate().all(|(other, key)| other == index || key.ease == 0.0) && ease == 0.0;
        let had_column = Lines::of(&self.saved).is_some_and(|lines| lines.has_ease());
        self.change(name, Some(&format!("{EASE} {index}")), |lines| match is_plain && !had_column {
            // Programs that do not know the column read the file again.
            true => lines.drop_ease(),
            false => lines.set_ease(index, ease),
        })
    }

    /// Stretches or shrinks all times from the first key on, so that the path takes this long. While the mouse is held,
    /// further values belong to the same step.
    ///
    /// # Errors
    /// One line, if keys would be too near each other; then nothing changes.
    pub(crate) fn set_duration(&mut self, duration_s: f64) -> Result<(), String> {
        let [first_s, last_s] = self.span_s();
        let factor = duration_s / (last_s - first_s);
        if !factor.is_finite() || factor <= 0.0 || factor == 1.0 {
            return Ok(());
        }
        let scaled = |time_s: f64| ((first_s + (time_s - first_s) * factor) * 1e6).round() / 1e6;
        let times_s: Vec<f64> = self.keys.iter().map(|key| scaled(key.time_s)).collect();
        self.change(format!("a duration of {} s", rounded(duration_s)), Some("duration"), |lines| {
            times_s.iter().enumerate().for_each(|(index, time_s)| lines.set_time(index, *time_s));
        })
    }

    /// Replaces the text, as one step.
    ///
    /// # Errors
    /// One line, if the text is not that of a path; then nothing changes.
    pub(crate) fn replace_text(&mut self, text: String, step: &str) -> Result<(), String> {
        let before = self.text.clone();
        self.show(text).map_err(|error| error.to_string())?;
        self.history.record(step.to_owned(), None, &before);
        Ok(())
    }

    /// Ends a step, because the mouse is released.
    pub(crate) fn release(&mut self) {
        self.history.close(&self.text);
    }

    /// Undoes the last step. Returns its name.
    pub(crate) fn undo(&mut self) -> Option<String> {
        let (name, text) = self.history.undo(&self.text)?;
        // It was valid before.
        self.show(text).ok()?;
        Some(name)
    }

    /// Repeats the step that was undone last. Returns its name.
    pub(crate) fn redo(&mut self) -> Option<String> {
        let (name, text) = self.history.redo(&self.text)?;
        self.show(text).ok()?;
        Some(name)
    }

    /// Changes lines as one step. Nothing changes if the result is not valid.
    fn change(&mut self, step: String, key: Option<&str>, edit: impl FnOnce(&mut Lines)) -> Result<(), String> {
        let before = self.text.clone();
        let Some(mut lines) = Lines::of(&before) else { return Err("the text of the path has no lines".to_owned()) };
        edit(&mut lines);
        self.show(lines.text()).map_err(|error| error.to_string())?;
        if self.text != before {
            self.history.record(step, key, &before);
        }
        Ok(())
    }

    /// Takes a text with all that follows from it. Nothing changes if it is not valid.
    fn show(&mut self, text: String) -> Result<(), PathError> {
        let name = Path::new(if self.name.is_empty() { "camera path" } else { &self.name });
        let is_empty = Lines::of(&text).is_some_and(|lines| lines.len() == 0 && lines.has_header());
        let (keys, curve) = match is_empty {
            true => (Vec::new(), None),
            false => {
                let keys = CameraPath::keys(name, text.as_bytes())?;
                let ground_m = |x: f64, y: f64| self.grounds.get(&[x, y].map(f64::to_bits)).copied().unwrap_or(0.0);
                (keys, Some(CameraPath::parse_on_ground(name, text.as_bytes(), ground_m)?))
            }
        };
        (self.text, self.keys, self.curve) = (text, keys, curve);
        Ok(())
    }
}

/// Returns a time in whole milliseconds, so that it has few digits.
fn rounded(time_s: f64) -> f64 {
    (time_s * 1e3).round() / 1e3
}

/// Returns a camera as it is written: to a millimetre, and a thousandth of a degree.
fn written(camera: &Camera) -> Camera {
    let round = |value: f64| (value * 1000.0).round() / 1000.0;
    Camera {
        position_m: glam::DVec3::from_array(camera.position_m.to_array().map(round)),
        yaw_deg: round(camera.yaw_deg),
        pitch_deg: round(camera.pitch_deg),
        fov_deg: round(camera.fov_deg),
        ..*camera
    }
}
