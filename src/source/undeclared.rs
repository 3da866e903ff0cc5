//! Warns about probable no-data values that a file does not declare.
//!
//! Some numbers are no-data values in so many files that a sample with one of them, far outside all other heights, is
//! most likely no-data: -9999 m where the land is above the sea. Only the owner of the file knows for certain. So such
//! samples are left unchanged, and one warning gives their share of all samples; `OpenOptions::no_data` makes them
//! no-data.
//!
//! Heights are examined as a reader returns them, in metres, or in the unit that the caller gives for a file without
//! one, which is applied here. -32768 and -32767 of 16-bit files are no-data already, and
//! so are values beyond ±1000 km (`samples`).

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::georeference::Georeference;
use super::place::unclear;
use super::reader::{HeightReader, Window};
use super::{Encoding, HeightUnit, OpenOptions, SourceError};

/// Common no-data values, in the unit of the file.
const MARKS_M: [f32; 6] = [-9999.0, -99_999.0, -999_999.0, 999_999.0, -32_767.0, -32_768.0];
/// Smallest distance of a suspicious value from the other heights, in metres…
const MIN_GAP_M: f32 = 500.0;
/// … and as a fraction of their range.
const GAP_OF_RANGE: f32 = 0.5;

/// A reader that treats one height as no-data, in metres or in the unit that the caller gives, warns about probable no-data values among the others, and converts the
/// rest to metres.
struct Watched {
    inner: Box<dyn HeightReader>,
    path: PathBuf,
    /// The height that is no-data, in `unit`.
    void: Option<f32>,
    unit: HeightUnit,
    /// Whether a sample was `void`.
    is_matched: AtomicBool,
    found: Mutex<Found>,
}

/// Counts of the samples that were read so far.
#[derive(Clone, Copy, Debug)]
struct Found {
    samples: u64,
    marks: [u64; MARKS_M.len()],
    /// Lowest and highest of the other heights, in metres.
    range_m: [f32; 2],
    has_warned: bool,
}

impl Found {
    const NONE: Self =
        Self { samples: 0, marks: [0; MARKS_M.len()], range_m: [f32::INFINITY, f32::NEG_INFINITY], has_warned: false };

    fn add(&mut self, heights_m: &[f32]) {
        heights_m.iter().for_each(|height_m| self.add_equal(*height_m, 1));
    }

    /// Adds `samples` samples of one height.
    fn add_equal(&mut self, height_m: f32, samples: u64) {
        self.samples += samples;
        match MARKS_M.iter().position(|mark| *mark == height_m) {
            Some(mark) => self.marks[mark] += samples,
            // `min` and `max` ignore NaN.
            None => self.range_m = [self.range_m[0].min(height_m), self.range_m[1].max(height_m)],
        }
    }

    fn join(&mut self, other: &Self) {
        self.samples += other.samples;
        self.marks.iter_mut().zip(other.marks).for_each(|(count, other)| *count += other);
        self.range_m = [self.range_m[0].min(other.range_m[0]), self.range_m[1].max(other.range_m[1])];
    }

    /// Returns the end of a line for each suspicious value that is far outside the other heights. `samples` is the number of
    /// samples in the grid, since some may have been read twice.
    fn lines(&self, samples: u64, unit: HeightUnit) -> Vec<String> {
        let [low_m, high_m] = self.range_m;
        let gap_m = MIN_GAP_M.max(GAP_OF_RANGE * (high_m - low_m));
        let is_outside = |mark: f32| low_m <= high_m && (mark <= low_m - gap_m || mark >= high_m + gap_m);
        let marks = MARKS_M.iter().zip(self.marks).filter(|(mark, count)| *count > 0 && is_outside(**mark));
        let line = |(mark, count): (&f32, u64)| {
            let share = count as f64 / self.samples as f64;
            let count = (share * samples as f64).round();
            let (are, makes) = if count == 1.0 {
                ("sample is", "treats it as no-data")
            } else {
                ("samples are", "treats them as no-data")
            };
            let percent = share * 100.0;
            let percent = if percent < 0.1 { "less than 0.1 %".to_owned() } else { format!("{percent:.1} %") };
            let unit = unit.name();
            format!("{count} {are} {mark} {unit} ({percent}), which usually means no-data; --nodata {mark} {makes}")
        };
        marks.map(line).collect()
    }
}

/// Wraps a reader of `path` so that it watches for undeclared no-data values.
///
/// # Errors
/// Fails if a unit is given, but the file declares another one than metres itself.
pub(super) fn watch(
    inner: Box<dyn HeightReader>,
    path: &Path,
    options: &OpenOptions,
) -> Result<Box<dyn HeightReader>, SourceError> {
    let void = options.no_data.map(|no_data| no_data as f32);
    let unit = options.height_unit.unwrap_or(HeightUnit::M);
    match inner.declared_unit_m().filter(|_| options.height_unit.is_some()) {
        None => {}
        Some(1.0) if unit == HeightUnit::M => {}
        Some(1.0) => tracing::warn!(
            "{}: declares heights in metres; --height-unit {} converts them all the same",
            path.display(),
            unit.name()
        ),
        Some(unit_m) => {
            let feet = [HeightUnit::Ft, HeightUnit::UsFt].iter().any(|feet| (feet.metres() - unit_m).abs() < 1e-9);
            let size = if feet { format!("feet ({unit_m} m)") } else { format!("units of {unit_m} m") };
            return Err(unclear(
                path,
                format!("declares heights in {size}, which are converted; leave out --height-unit"),
            ));
        }
    }
    Ok(Box::new(Watched {
        inner,
        path: path.into(),
        void,
        unit,
        is_matched: AtomicBool::new(false),
        found: Mutex::new(Found::NONE),
    }))
}

impl Watched {
    /// Returns a height as the file has it, or NaN for no-data.
    fn void_or(&self, height: f32) -> f32 {
        if self.void != Some(height) {
            return height;
        }
        self.is_matched.store(true, Ordering::Relaxed);
        f32::NAN
    }

    /// Converts a height from the unit that the caller gives.
    fn metres(&self, height: f32) -> f32 {
        match self.unit {
            HeightUnit::M => height,
            unit => (f64::from(height) * unit.metres()) as f32,
        }
    }

    /// Adds counts; after the whole grid has been read, prints the warnings.
    fn count(&self, here: &Found) {
        // A thread that panicked while it counted left valid numbers.
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        found.join(here);
        let [width, height] = self.size();
        let samples = u64::from(width) * u64::from(height);
        if found.samples >= samples && !found.has_warned {
            found.has_warned = true;
            let name = self.path.display();
            found.lines(samples, self.unit).iter().for_each(|line| tracing::warn!("{name}: {line}"));
        }
    }
}

impl HeightReader for Watched {
    fn size(&self) -> [u32; 2] {
        self.inner.size()
    }

    fn georeference(&self) -> &Georeference {
        self.inner.georeference()
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut heights_m = self.inner.read(window)?;
        if self.void.is_some() {
            heights_m.iter_mut().for_each(|height_m| *height_m = self.void_or(*height_m));
        }
        let mut here = Found::NONE;
        here.add(&heights_m);
        self.count(&here);
        if self.unit != HeightUnit::M {
            heights_m.iter_mut().for_each(|height_m| *height_m = self.metres(*height_m));
        }
        Ok(heights_m)
    }

    fn known_m(&self, window: Window) -> Option<f32> {
        let height_m = self.inner.known_m(window).map(|height_m| self.void_or(height_m))?;
        // A caller that gets the known height does not read the window, so it is counted here.
        let mut here = Found::NONE;
        here.add_equal(height_m, window.samples() as u64);
        self.count(&here);
        Some(self.metres(height_m))
    }

    fn is_serial(&self) -> bool {
        self.inner.is_serial()
    }

    fn block(&self) -> [u32; 2] {
        self.inner.block()
    }

    fn is_coarse(&self) -> bool {
        self.inner.is_coarse()
    }

    fn encoding(&self) -> Option<Encoding> {
        self.inner.encoding()
    }

    fn has_unmatched_no_data(&self) -> bool {
        self.void.is_some() && !self.is_matched.load(Ordering::Relaxed)
    }

    fn warnings(&self) -> Vec<String> {
        let found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let [width, height] = self.size();
        let own =
            if found.has_warned { found.lines(u64::from(width) * u64::from(height), self.unit) } else { Vec::new() };
        [self.inner.warnings(), own].concat()
    }

    fn identity(&self) -> String {
        let inner = self.inner.identity();
        let inner = self.void.map_or_else(|| inner.clone(), |void| format!("{inner}\nno data {void}"));
        match self.unit {
            HeightUnit::M => inner,
            unit => format!("{inner}\nheights in {}", unit.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(heights_m: &[f32]) -> Vec<String> {
        let mut found = Found::NONE;
        // The samples are added in two windows, as from two threads.
        let (first, last) = heights_m.split_at(heights_m.len() / 2);
        for window in [first, last] {
            let mut here = Found::NONE;
            here.add(window);
            found.join(&here);
        }
        found.lines(heights_m.len() as u64, HeightUnit::M)
    }

    #[test]
    fn marks_far_outside_of_the_heights_are_reported() {
        let land = |i: usize| 300.0 + (i % 700) as f32;
        let with = |mark: f32, every: usize| -> Vec<f32> {
            (0..10_000).map(|i| if i % every == 0 { mark } else { land(i) }).collect()
        };
        assert_eq!(
            lines(&with(-9999.0, 100)),
            ["100 samples are -9999 m (1.0 %), which usually means no-data; --nodata -9999 treats them as no-data"]
        );
        for mark in MARKS_M {
            assert_eq!(lines(&with(mark, 5000)).len(), 1, "{mark}");
        }
        assert!(lines(&with(-9999.0, 10_000))[0].contains("1 sample is -9999 m (less than 0.1 %)"));
        // Two such values in one file do not hide each other.
        let mut two = with(-9999.0, 100);
        two[1] = -99_999.0;
        assert_eq!(lines(&two).len(), 2);
    }

    #[test]
    fn reports_are_in_the_unit_that_is_given() {
        let mut found = Found::NONE;
        found.add(&[-9999.0, 300.0, 400.0, 500.0]);
        let lines = found.lines(4, HeightUnit::Ft);
        assert!(lines[0].starts_with("1 sample is -9999 ft (25.0 %)"), "{lines:?}");
    }

    #[test]
    fn heights_that_may_be_true_are_not_reported() {
        let seas: Vec<f32> = (0..10_000).map(|i| if i == 7 { -9999.0 } else { -10_900.0 + i as f32 }).collect();
        assert!(lines(&seas).is_empty(), "a trench has such depths");
        let near: Vec<f32> = (0..9_990).map(|i| -9_990.0 + i as f32).chain([-9999.0]).collect();
        assert!(lines(&near).is_empty(), "so has what leads to it");
        let other: Vec<f32> = (0..1000).map(|i| if i == 7 { -9998.0 } else { i as f32 }).collect();
        assert!(lines(&other).is_empty(), "this value does not mean no-data");
        assert!(lines(&[-9999.0; 100]).is_empty() && lines(&[f32::NAN; 4]).is_empty() && lines(&[]).is_empty());
    }
}
