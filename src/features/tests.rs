//! Tests of all formats together.

mod damage;
mod files;
mod geopackages;
mod round_trip;
mod writers;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use super::{Area, Attributes, Choice, Feature, FeatureError, Geometry, Position, Summary, read};

/// A small generator of random numbers (xorshift).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(super) fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

/// A folder for files of a test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    #[allow(clippy::disallowed_methods, reason = "thousands of files of which no other program reads one")]
    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        // A new file is faster: some file systems flush a file that replaces its content.
        let _ = std::fs::remove_file(self.path(name));
        std::fs::write(self.path(name), bytes).unwrap();
        self.path(name)
    }

    /// Returns the names of all files, sorted.
    fn names(&self) -> Vec<String> {
        let names = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = names.map(|it| it.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

/// Reads all features of a file.
fn read_all(path: &Path, layer: Option<&str>) -> Result<(Vec<Feature>, Summary), FeatureError> {
    let mut features = Vec::new();
    let choice = Choice { layer: layer.map(str::to_owned) };
    let summary = read(path, &choice, &mut |feature| {
        features.push(feature);
        ControlFlow::Continue(())
    })?;
    Ok((features, summary))
}

/// Reads all features of a text under a name.
fn read_text(name: &str, text: impl AsRef<[u8]>) -> Result<(Vec<Feature>, Summary), FeatureError> {
    let folder = Folder::new();
    read_all(&folder.write(name, text), None)
}

/// Returns the error of a text, without the folder.
fn error_of(name: &str, text: impl AsRef<[u8]>) -> String {
    let folder = Folder::new();
    let error = read_all(&folder.write(name, text), None).unwrap_err().to_string();
    let prefix = format!("{}/", folder.0.path().display());
    error.strip_prefix(&prefix).unwrap_or_else(|| panic!("{error} does not begin with {prefix}")).to_owned()
}

/// Returns the differences of two lists of features: geometries bit for bit, with NaN equal to NaN, and attributes
/// without regard to their order.
fn differences(left: &[Feature], right: &[Feature]) -> Vec<String> {
    let mut found = Vec::new();
    if left.len() != right.len() {
        found.push(format!("{} and {} features", left.len(), right.len()));
    }
    for (index, (left, right)) in left.iter().zip(right).enumerate() {
        if bits(&left.geometry) != bits(&right.geometry) {
            found.push(format!("feature {index}: {:?} and {:?}", left.geometry, right.geometry));
        }
        if sorted(&left.attributes) != sorted(&right.attributes) {
            found.push(format!("feature {index}: {:?} and {:?}", left.attributes, right.attributes));
        }
    }
    found
}

/// Returns a geometry as nested lists of the bits of its numbers.
fn bits(geometry: &Geometry) -> Vec<Vec<Vec<[u64; 3]>>> {
    let bits = |number: f64| if number.is_nan() { u64::MAX } else { number.to_bits() };
    let line = |line: &Vec<Position>| line.iter().map(|position| position.map(bits)).collect::<Vec<_>>();
    match geometry {
        Geometry::Points(points) => vec![vec![], vec![line(points)]],
        Geometry::Lines(lines) => vec![vec![], vec![], lines.iter().map(line).collect()],
        Geometry::Areas(areas) => {
            areas.iter().map(|it| [line(&it.outer)].into_iter().chain(it.holes.iter().map(line)).collect()).collect()
        }
    }
}

fn sorted(attributes: &Attributes) -> Vec<String> {
    let mut all: Vec<String> = attributes.iter().map(|(name, value)| format!("{name} = {value:?}")).collect();
    all.sort();
    all
}

/// Returns features of every kind, with attributes of every kind; with heights or without.
fn samples(has_z: bool) -> Vec<Feature> {
    use super::Value::{Bool, Number, Text};
    // Heights are round, because serde_json may miss the last bit of a number of 17 digits.
    let position = |x: f64, y: f64| [x, y, if has_z { (x * 10.0 - y).round() } else { f64::NAN }];
    let ring = |x: f64, y: f64, size: f64| vec![position(x, y), position(x + size, y), position(x + size, y + size)];
    let text = |text: &str| Text(text.to_owned());
    let geometries = [
        Geometry::Points(vec![position(7.65, 45.976_6)]),
        Geometry::Points(vec![position(1.0, 2.0), position(-3.5, 4.0e-7)]),
        Geometry::Lines(vec![vec![position(0.0, 0.0), position(0.1, 0.2), position(1.0 / 3.0, 5.0)]]),
        Geometry::Lines(vec![
            vec![position(0.0, 1.0), position(2.0, 3.0)],
            vec![position(4.0, 5.0), position(6.0, 7.0)],
        ]),
        Geometry::Areas(vec![Area {
            outer: ring(0.0, 0.0, 10.0),
            holes: vec![ring(5.0, 1.0, 1.0), ring(7.0, 2.0, 1.0)],
        }]),
        Geometry::Areas(vec![
            Area { outer: ring(0.0, 0.0, 1.0), holes: vec![] },
            Area { outer: ring(20.0, 20.0, 9.0), holes: vec![ring(25.0, 21.0, 1.0)] },
        ]),
    ];
    let attributes = [
        vec![("name", text("Matterhorn")), ("ele", Number(4478.0)), ("climbed", Bool(true))],
        vec![("name", text("a; \"b\", 'c'\tä 山"))],
        vec![("ele", Number(-0.125)), ("climbed", Bool(false))],
        vec![("name", text("Weg")), ("class", text("track"))],
        vec![("class", text("forest")), ("ele", Number(1e-7))],
        vec![("name", text("01234")), ("climbed", Bool(true))],
    ];
    let feature = |(index, (geometry, entries))| {
        let entries: Vec<(&str, super::Value)> = entries;
        let mut attributes = Attributes::default();
        entries.into_iter().for_each(|(name, value)| attributes.push(name.into(), value));
        Feature { geometry, attributes, layer: 0, record: index as u64 + 1 }
    };
    geometries.into_iter().zip(attributes).enumerate().map(feature).collect()
}
