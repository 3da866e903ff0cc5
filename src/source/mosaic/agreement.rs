//! Decides whether two height files show the same land where they overlap, and which of two that do not is the DEM.
//!
//! Folders of DEMs also hold rasters that were derived from them: hillshades, slopes, aspects, roughness, classes of
//! land cover, error estimates. Their values are not heights, but nothing in the files says so. Two surveys of the same
//! land agree: their values rise and fall together, and differ by less than the relief. A derived raster does neither.
//! It is also rougher than its DEM: a derivative amplifies small features. So of two rasters that disagree, the one
//! whose neighbouring samples differ less, relative to all of its values, is the DEM.

use super::sample_transform::{SampleTransform, middle_x};
use crate::source::SourceError;
use crate::source::reader::{HeightReader, Window};

/// Smallest overlap that is compared, in samples of the coarser file. Tiles share a few rows and columns at most.
const MIN_SAMPLES: f64 = 8.0;
/// Columns and rows of windows in the overlap at most, and the number of samples along the side of one.
const WINDOWS: u32 = 5;
const WINDOW_SAMPLES: u32 = 40;
/// Largest side of the window of the finer file that is read for one of the coarser, in samples.
const MAX_FINER_SAMPLES: f64 = 1024.0;
/// Number of samples with a height in both files that suffices: half of the windows. Those of fewer may correlate by
/// chance.
const ENOUGH_PAIRS: usize = 20_000;
/// Number of samples below which nothing is decided.
const MIN_PAIRS: usize = 32;

/// Largest median difference of two DEMs of the same land, in metres. Heights above an ellipsoid and above the sea
/// differ by up to 110 m.
const MAX_OFFSET_M: f64 = 150.0;
/// Correlation from which on two rasters rise and fall together: on different lattices, on one lattice, and if the name
/// of one of them says that it was derived.
const MIN_CORRELATION: [f64; 3] = [0.8, 0.9, 0.98];
/// Largest ratio between the reliefs of two surveys of the same land.
const MAX_RELIEF_RATIO: f64 = 3.0;
/// Relief in metres above which two surveys of one land have similar reliefs; below it, noise is as large as the relief.
const MIN_RELIEF_M: f64 = 4.0;
/// Roughness ([`Roughness::share`]) above which a raster is noise, and below which it is land.
const NOISE: f64 = 0.8;
const LAND: f64 = 0.3;
/// Number of different values up to which a raster holds classes, not heights.
const MAX_CLASSES: usize = 3;
/// Correlation from which on a factor between two rasters is a unit.
const MIN_UNIT_CORRELATION: f64 = 0.99;

/// Words in the names of files that hold no heights.
const DERIVED_WORDS: [&str; 40] = [
    "hillshade",
    "hillshades",
    "shade",
    "shaded",
    "shading",
    "hs",
    "slope",
    "slopes",
    "aspect",
    "roughness",
    "tri",
    "tpi",
    "twi",
    "svf",
    "curvature",
    "openness",
    "landcover",
    "cover",
    "mask",
    "msk",
    "wbm",
    "edm",
    "flm",
    "hem",
    "num",
    "stk",
    "count",
    "error",
    "uncertainty",
    "stdev",
    "ndvi",
    "ortho",
    "color",
    "colour",
    "relief",
    "flow",
    "accumulation",
    "direction",
    "geoid",
    "quality",
];
/// Words in the names of files that hold heights.
const HEIGHT_WORDS: [&str; 9] = ["dem", "dtm", "dsm", "dhm", "height", "heights", "elevation", "elev", "terrain"];

/// The content of a file according to its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Claim {
    Heights,
    Nothing,
    Derived,
}

impl Claim {
    /// Returns the content that the words of a file's name indicate. `dem_slope.tif` is a slope.
    pub(super) fn of(stem: &str) -> Self {
        let stem = stem.to_ascii_lowercase();
        let has = |known: &[&str]| stem.split(|c: char| !c.is_alphabetic()).any(|word| known.contains(&word));
        match () {
            () if has(&DERIVED_WORDS) => Self::Derived,
            () if has(&HEIGHT_WORDS) => Self::Heights,
            () => Self::Nothing,
        }
    }
}

/// A file and the bounds of its samples on the lattice of the first file: first column and row, last column and row.
pub(super) struct PlacedReader<'a> {
    pub reader: &'a dyn HeightReader,
    pub box_samples: [f64; 4],
    pub claim: Claim,
}

/// The difference between two files on the same land.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Difference {
    /// The values of the first are those of the second times this factor: another unit.
    Factor(f64),
    /// Nothing common; half of all differences are larger than this, in metres.
    Other { median_m: f64 },
}

/// The values of two files at the same places, and how rough each of them is.
#[derive(Default)]
struct Common {
    pairs: Vec<[f64; 2]>,
    roughness: [Roughness; 2],
}

/// The squared differences of neighbouring samples, compared with the variance of all.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Roughness {
    steps: f64,
    squared_steps: f64,
    count: f64,
    sum: f64,
    sum_of_squares: f64,
    /// The first different values.
    values: [Option<f64>; MAX_CLASSES + 1],
}

impl Roughness {
    fn add(&mut self, window: Window, values: &[f32]) {
        let width = window.width as usize;
        for (i, &value) in values.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
            let value = f64::from(value);
            self.see(value);
            self.count += 1.0;
            self.sum += value;
            self.sum_of_squares += value * value;
            let right = values.get(i + 1).filter(|_| (i + 1) % width != 0);
            for next in right.into_iter().chain(values.get(i + width)).filter(|next| !next.is_nan()) {
                self.steps += 1.0;
                self.squared_steps += (f64::from(*next) - value).powi(2);
            }
        }
    }

    /// Notes a value, unless enough different ones are known.
    fn see(&mut self, value: f64) {
        if let Some(place) = self.values.iter_mut().find(|known| known.is_none_or(|known| known == value)) {
            *place = Some(value);
        }
    }

    /// Adds the findings from elsewhere in the same file.
    pub(super) fn join(&mut self, other: Self) {
        other.values.into_iter().flatten().for_each(|value| self.see(value));
        self.steps += other.steps;
        self.squared_steps += other.squared_steps;
        self.count += other.count;
        self.sum += other.sum;
        self.sum_of_squares += other.sum_of_squares;
    }

    /// Returns the mean squared step relative to that of unordered values: 0 is smooth, 1 is noise. A raster of a few
    /// classes counts as noise (1): however large their areas are, they are no heights.
    pub(super) fn share(self) -> f64 {
        let mean = self.sum / self.count;
        let variance = self.sum_of_squares / self.count - mean * mean;
        let share = self.squared_steps / self.steps / (2.0 * variance);
        let has_classes = self.values.iter().any(Option::is_none);
        if share.is_finite() && variance > 1e-9 * mean * mean && !has_classes { share } else { 1.0 }
    }
}

/// The difference of two files, `None` if they agree, and the roughness of both.
pub(super) type Compared = (Option<Difference>, [Roughness; 2]);

/// Compares two files where they overlap. Returns `None` if they do not, or if too little of it has heights; otherwise
/// their difference, `None` if they agree, and the roughness of both.
///
/// # Errors
/// Fails if a file cannot be read.
pub(super) fn compare([a, b]: [&PlacedReader<'_>; 2]) -> Result<Option<Compared>, SourceError> {
    let overlap = [0, 1].map(|axis| {
        let (a, b) = (a.box_samples, b.box_samples);
        a[axis + 2].min(b[axis + 2]) - a[axis].max(b[axis])
    });
    if overlap.iter().any(|&side| side.is_nan() || side <= 0.0) {
        return Ok(None);
    }
    let spacing = |it: &PlacedReader<'_>| {
        let [width, height] = it.reader.size().map(|count| f64::from(count - 1));
        ((it.box_samples[2] - it.box_samples[0]) / width * (it.box_samples[3] - it.box_samples[1]) / height).sqrt()
    };
    let (spacing_a, spacing_b) = (spacing(a), spacing(b));
    if overlap.iter().any(|&side| side < MIN_SAMPLES * spacing_a.max(spacing_b)) {
        return Ok(None);
    }
    let is_swapped = spacing_b > spacing_a * 1.001;
    let (coarse, fine) = if is_swapped { (b, a) } else { (a, b) };
    let mut found = Common::default();
    let Ok(way) = way_between(coarse.reader, fine.reader) else { return Ok(None) };
    let is_aligned = matches!(way, SampleTransform::Shift(_));
    let ratio = (spacing(coarse) / spacing(fine)).max(1.0);
    sample(coarse.reader, fine.reader, &way, ratio, &mut found)?;
    if is_swapped {
        found.pairs.iter_mut().for_each(|pair| pair.reverse());
        found.roughness.reverse();
    }
    // A zero stands for the sea, or for no-data that is not declared, in one of two files. A file that is zero almost
    // everywhere is a mask, or another raster that is not of heights.
    let is_lone_zero = |[a, b]: &[f64; 2]| (*a == 0.0) != (*b == 0.0);
    if 2 * found.pairs.iter().filter(|pair| is_lone_zero(pair)).count() < found.pairs.len() {
        found.pairs.retain(|pair| !is_lone_zero(pair));
    }
    if found.pairs.len() < MIN_PAIRS {
        return Ok(None);
    }
    let is_derived = [a, b].iter().any(|it| it.claim == Claim::Derived);
    let shares = found.roughness.map(Roughness::share);
    let is_noise = shares[0].max(shares[1]) > NOISE && shares[0].min(shares[1]) < LAND;
    let kinship = Kinship { is_aligned, is_derived, is_noise };
    Ok(Some((difference(&found.pairs, kinship), found.roughness)))
}

/// Reads windows of the coarser file that are spread over the overlap, and the finer file at the same places.
fn sample(
    coarse: &dyn HeightReader,
    fine: &dyn HeightReader,
    way: &SampleTransform,
    ratio: f64,
    found: &mut Common,
) -> Result<(), SourceError> {
    let Some([x, y, width, height]) = overlap_of(coarse, fine) else { return Ok(()) };
    let side = (MAX_FINER_SAMPLES / ratio).clamp(4.0, f64::from(WINDOW_SAMPLES)) as u32;
    for number in spread(WINDOWS * WINDOWS) {
        let (across, down) = (number % WINDOWS, number / WINDOWS);
        let first = |at: u32, first: u32, count: u32| {
            first + (f64::from(count.saturating_sub(side)) * (f64::from(at) + 0.5) / f64::from(WINDOWS)) as u32
        };
        let window = Window {
            x: first(across, x, width),
            y: first(down, y, height),
            width: side.min(width),
            height: side.min(height),
        };
        let own = coarse.read(window)?;
        found.roughness[0].add(window, &own);
        let places: Vec<[f64; 2]> = (0..window.width * window.height)
            .map(|i| way.map(f64::from(window.x + i % window.width), f64::from(window.y + i / window.width)))
            .collect();
        let Some(there) = covering(&places, fine.size(), ratio) else { continue };
        let other = fine.read(there)?;
        found.roughness[1].add(there, &other);
        for (own, place) in own.iter().zip(&places) {
            let [column, row] = place.map(|c| c.round());
            let is_inside = column >= f64::from(there.x)
                && row >= f64::from(there.y)
                && column < f64::from(there.x + there.width)
                && row < f64::from(there.y + there.height);
            if !is_inside || own.is_nan() {
                continue;
            }
            let at = (row as u32 - there.y) * there.width + column as u32 - there.x;
            let other = other[at as usize];
            if !other.is_nan() {
                found.pairs.push([f64::from(*own), f64::from(other)]);
            }
        }
        if found.pairs.len() >= ENOUGH_PAIRS {
            break;
        }
    }
    Ok(())
}

/// Returns the numbers below `count`, each once, so that the first few are far apart.
fn spread(count: u32) -> impl Iterator<Item = u32> {
    // 12 and 25 have no common divisor.
    (0..count).map(move |i| (i * (count / 2) + count / 2) % count)
}

/// Returns the part of a file that overlaps another grid: first column and row, columns, rows.
fn overlap_of(file: &dyn HeightReader, other: &dyn HeightReader) -> Option<[u32; 4]> {
    let bounds = bounds(&way_between(other, file).ok()?, other.size())?;
    let own = file.size();
    let first = [0, 1].map(|axis| bounds[axis].max(0.0).ceil() as u32);
    let last = [0, 1].map(|axis| bounds[axis + 2].min(f64::from(own[axis] - 1)).floor());
    if (0..2).any(|axis| last[axis] - f64::from(first[axis]) + 1.0 < MIN_SAMPLES) {
        return None;
    }
    Some([first[0], first[1], last[0] as u32 - first[0] + 1, last[1] as u32 - first[1] + 1])
}

/// Returns the transformation from the samples of one file to those of another.
pub(super) fn way_between(from: &dyn HeightReader, to: &dyn HeightReader) -> Result<SampleTransform, String> {
    SampleTransform::between(from.georeference(), to.georeference(), Some(middle_x(to.georeference(), to.size())))
}

/// Returns the bounds of a grid on another lattice: lowest column and row, highest column and row.
pub(super) fn bounds(way: &SampleTransform, size: [u32; 2]) -> Option<[f64; 4]> {
    let steps = 8;
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for i in 0..=steps {
        let at = |count: u32| f64::from(count - 1) * f64::from(i) / f64::from(steps);
        let (x, y, right, bottom) = (at(size[0]), at(size[1]), f64::from(size[0] - 1), f64::from(size[1] - 1));
        for (column, row) in [(x, 0.0), (x, bottom), (0.0, y), (right, y)] {
            let [x, y] = way.map(column, row);
            if !(x.is_finite() && y.is_finite()) {
                return None;
            }
            bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x), bounds[3].max(y)];
        }
    }
    Some(bounds)
}

/// Returns the window that contains the places, if any is inside the grid and the window is not too large.
fn covering(places: &[[f64; 2]], size: [u32; 2], ratio: f64) -> Option<Window> {
    let (mut low, mut high) = ([u32::MAX; 2], [0_u32; 2]);
    let inside =
        |place: &&[f64; 2]| (0..2).all(|axis| (0.0..f64::from(size[axis]) - 0.5).contains(&place[axis].round()));
    for place in places.iter().filter(inside) {
        for axis in 0..2 {
            let sample = place[axis].round() as u32;
            (low[axis], high[axis]) = (low[axis].min(sample), high[axis].max(sample));
        }
    }
    if low[0] > high[0] || low[1] > high[1] {
        return None;
    }
    let window = Window { x: low[0], y: low[1], width: high[0] - low[0] + 1, height: high[1] - low[1] + 1 };
    // A lattice that is strongly rotated or stretched has no small window.
    let most = 4.0 * MAX_FINER_SAMPLES.max(f64::from(WINDOW_SAMPLES) * ratio);
    (f64::from(window.width) <= most && f64::from(window.height) <= most).then_some(window)
}

/// The relation of two files, besides their values.
#[derive(Clone, Copy, Debug, Default)]
struct Kinship {
    /// Their samples coincide, as those of a derived raster and its DEM do.
    is_aligned: bool,
    /// The name of one of them says that it holds no heights.
    is_derived: bool,
    /// One of them is noise, and the other is not.
    is_noise: bool,
}

/// Returns how the values of two files differ, or `None` if they agree.
fn difference(pairs: &[[f64; 2]], kinship: Kinship) -> Option<Difference> {
    let Kinship { is_aligned, is_derived, is_noise } = kinship;
    let count = pairs.len() as f64;
    let sorted = |value: &dyn Fn(&[f64; 2]) -> f64| {
        let mut values: Vec<f64> = pairs.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let quantile = |sorted: &[f64], share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
    let differences = sorted(&|[a, b]| b - a);
    let offset_m = quantile(&differences, 0.5);
    // Standard deviation of normally distributed differences; outliers do not change it.
    let spread_m = (quantile(&differences, 0.9) - quantile(&differences, 0.1)) / 2.56;
    let relief = |axis: usize| {
        let values = sorted(&|pair| pair[axis]);
        quantile(&values, 0.95) - quantile(&values, 0.05)
    };
    let (relief_m, smaller_m) = (relief(0).max(relief(1)), relief(0).min(relief(1)));

    let mean = [0, 1].map(|axis| pairs.iter().map(|pair| pair[axis]).sum::<f64>() / count);
    let product = |i: usize, j: usize| pairs.iter().map(|pair| (pair[i] - mean[i]) * (pair[j] - mean[j])).sum::<f64>();
    let (aa, ab, bb) = (product(0, 0), product(0, 1), product(1, 1));
    let correlation = if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 };
    let factor = (aa / bb).sqrt();
    if correlation > MIN_UNIT_CORRELATION && relief_m > MIN_RELIEF_M && !(0.7..1.4).contains(&factor) {
        return Some(Difference::Factor(factor));
    }
    // A raster derived from a plain differs little from it, but has another relief.
    let is_of_one_relief = relief_m <= MAX_RELIEF_RATIO * smaller_m || relief_m < MIN_RELIEF_M;
    let tolerance_m = match (is_aligned, is_derived) {
        (true, true) => 0.1 * smaller_m,
        (true, false) if is_of_one_relief && !is_noise => (0.15 * relief_m).max(2.0),
        (true, false) => 0.15 * smaller_m,
        (false, _) => (0.5 * relief_m).max(30.0),
    };
    let correlates = correlation >= MIN_CORRELATION[usize::from(is_aligned) + usize::from(is_aligned && is_derived)];
    let agrees =
        offset_m.abs() <= MAX_OFFSET_M && (correlates && (is_of_one_relief || !is_aligned) || spread_m <= tolerance_m);
    (!agrees).then(|| {
        let far = sorted(&|[a, b]| (b - a).abs());
        Difference::Other { median_m: quantile(&far, 0.5) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::georeference::{Crs, Georeference};
    use crate::source::{GeoKeys, GridReader, HeightGrid};

    const ALIGNED: Kinship = Kinship { is_aligned: true, is_derived: false, is_noise: false };

    fn height_m(x: f64, y: f64) -> f64 {
        900.0 + 150.0 * (x / 17.0).sin() * (y / 13.0).cos() + 20.0 * (x / 3.1).sin() + 2.0 * y
    }

    fn slope_deg(x: f64, y: f64) -> f64 {
        let across = (height_m(x + 1.0, y) - height_m(x - 1.0, y)) / 60.0;
        let down = (height_m(x, y + 1.0) - height_m(x, y - 1.0)) / 60.0;
        across.hypot(down).atan().to_degrees()
    }

    fn pairs(a: impl Fn(f64, f64) -> f64, b: impl Fn(f64, f64) -> f64) -> Vec<[f64; 2]> {
        (0..2500).map(|i| (f64::from(i % 50), f64::from(i / 50))).map(|(x, y)| [a(x, y), b(x, y)]).collect()
    }

    #[test]
    fn surveys_agree_and_derived_rasters_do_not() {
        let noise = |x: f64, y: f64| ((x * 12.9898 + y * 78.233).sin() * 43_758.545).fract();
        let other_survey = |x: f64, y: f64| height_m(x, y) + 48.0 + 9.0 * noise(x, y);
        assert_eq!(difference(&pairs(height_m, other_survey), ALIGNED), None);
        // Flat land under two noisy surveys.
        let flat = |x: f64, y: f64| 12.0 + 0.3 * noise(x, y);
        assert_eq!(difference(&pairs(flat, |x, y| 12.4 + 0.3 * noise(y, x)), ALIGNED), None);
        for derived in [slope_deg, |x: f64, y: f64| (x + y) * 7.0 % 360.0] {
            assert!(matches!(difference(&pairs(height_m, derived), ALIGNED), Some(Difference::Other { .. })));
        }
        // Land at the level of the sea, whose heights are as large as slopes.
        let low = |x: f64, y: f64| height_m(x, y) / 15.0 - 55.0;
        assert!(difference(&pairs(low, slope_deg), ALIGNED).is_some());
        // A plain: slopes, classes and feet are as large as its heights, or as its noise.
        let plain = |x: f64, y: f64| 9.0 + (height_m(x, y) - 900.0) / 45.0;
        let plain_slope = |x: f64, y: f64| slope_deg(x, y) / 45.0;
        let class = |x: f64, _: f64| if x < 20.0 { 0.0 } else { 1.0 };
        for derived in [&plain_slope as &dyn Fn(f64, f64) -> f64, &class, &|_, _| 0.25] {
            let found = difference(&pairs(plain, derived), ALIGNED);
            assert!(matches!(found, Some(Difference::Other { .. })), "{found:?}");
        }
        let feet = difference(&pairs(|x, y| plain(x, y) / 0.3048, plain), ALIGNED);
        assert!(matches!(feet, Some(Difference::Factor(_))), "{feet:?}");
        // An estimate of errors.
        let error = |x: f64, y: f64| 1.5 + 3.0 * noise(x, y).abs();
        let is_noise = Kinship { is_noise: true, ..ALIGNED };
        assert!(difference(&pairs(plain, error), is_noise).is_some());
        // A name decides where values alone would not.
        let damped = |x: f64, y: f64| 9.0 + 0.6 * (plain(x, y) - 9.0) + 1.2 * noise(x, y);
        assert_eq!(difference(&pairs(plain, damped), ALIGNED), None);
        assert!(difference(&pairs(plain, damped), Kinship { is_derived: true, ..ALIGNED }).is_some());
        let feet = difference(&pairs(|x, y| height_m(x, y) / 0.3048, height_m), ALIGNED);
        assert!(matches!(feet, Some(Difference::Factor(factor)) if (factor - 3.2808).abs() < 0.01), "{feet:?}");
    }

    /// Returns a file of 50 × 50 samples, 30 m apart.
    fn file(of: &dyn Fn(f64, f64) -> f64) -> GridReader<HeightGrid> {
        let heights_m = (0..2500).map(|i| of(f64::from(i % 50), f64::from(i / 50)) as f32).collect();
        let crs_from_grid = [0.0, 30.0, 0.0, 0.0, 0.0, -30.0];
        let georeference = Georeference { crs_from_grid, crs: Crs::Local, geokeys: GeoKeys::default() };
        GridReader::new(HeightGrid { width: 50, height: 50, heights_m, georeference }, String::new())
    }

    #[test]
    fn zeros_are_no_data_unless_they_are_nearly_all() {
        let compared = |a: &dyn Fn(f64, f64) -> f64, b: &dyn Fn(f64, f64) -> f64| {
            let files = [file(a), file(b)];
            let [a, b] = [0, 1].map(|i| PlacedReader {
                reader: &files[i],
                box_samples: [0.0, 0.0, 49.0, 49.0],
                claim: Claim::Nothing,
            });
            compare([&a, &b]).unwrap().map(|(difference, _)| difference)
        };
        let zero_up_to = |column: f64| move |x: f64, y: f64| if x < column { 0.0 } else { height_m(x, y) };
        // An empty mask, and a mask of few samples.
        for most in [50.0, 45.0] {
            let mask = |x: f64, _: f64| if x < most { 0.0 } else { 1.0 };
            assert!(matches!(compared(&height_m, &mask), Some(Some(Difference::Other { .. }))), "{most}");
            assert!(matches!(compared(&mask, &height_m), Some(Some(Difference::Other { .. }))), "{most}");
        }
        // The sea, and no-data, of one of two files.
        assert_eq!(compared(&height_m, &zero_up_to(20.0)), Some(None));
        assert_eq!(compared(&zero_up_to(10.0), &height_m), Some(None));
        // Zeros that both files have agree.
        assert_eq!(compared(&zero_up_to(40.0), &zero_up_to(40.0)), Some(None));
    }

    #[test]
    fn the_dem_is_smoother_than_what_is_derived_from_it() {
        let share = |of: &dyn Fn(f64, f64) -> f64| {
            let values: Vec<f32> = (0..2500).map(|i| of(f64::from(i % 50), f64::from(i / 50)) as f32).collect();
            let mut roughness = Roughness::default();
            roughness.add(Window { x: 0, y: 0, width: 50, height: 50 }, &values);
            roughness.share()
        };
        assert!(share(&height_m) < 0.5 * share(&slope_deg), "{} {}", share(&height_m), share(&slope_deg));
        assert_eq!(share(&|_, _| 7.0), 1.0);
        assert!(share(&|_, _| f64::NAN) == 1.0);
    }

    #[test]
    fn names_are_read_by_words() {
        for (stem, claim) in [
            ("alps_dem", Claim::Heights),
            ("DEM-slope", Claim::Derived),
            ("hillshade", Claim::Derived),
            ("N46E008", Claim::Nothing),
            ("slopeside", Claim::Nothing),
        ] {
            assert_eq!(Claim::of(stem), claim, "{stem}");
        }
    }

    #[test]
    fn windows_are_spread() {
        let mut all: Vec<u32> = spread(25).collect();
        assert_eq!(all[0], 12);
        all.sort_unstable();
        assert_eq!(all, (0..25).collect::<Vec<_>>());
    }
}
