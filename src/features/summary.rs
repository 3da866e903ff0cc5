//! The summary of a file: what was read, and what was left out.

use std::sync::Arc;

/// What a file contains, as far as it was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Summary {
    /// The format of the file, for messages.
    pub format: &'static str,
    /// The reference system of the coordinates; `None` if nothing gives it.
    pub crs: Option<Crs>,
    /// The layers that were read.
    pub layers: Vec<Layer>,
    /// Extent of all features that were passed on.
    pub bounds: Option<Bounds>,
    /// The attributes, in the order in which they were found.
    pub attributes: Vec<Attribute>,
    /// Number of values whose attribute is not in `attributes`, because a file has too many different names.
    pub unlisted_values: u64,
    /// What was left out, and why.
    pub skipped: Vec<Skipped>,
    /// What [`Feature::record`](super::Feature::record) counts: "line", "feature", "row" or "element".
    pub record_noun: &'static str,
    /// Whether the file was read to its end; `false` if the caller ended it.
    pub is_complete: bool,
}

impl Summary {
    /// Adds what another layer of the same file has. Extents in different reference systems are not comparable: the
    /// extent is that of the layers with the reference system of the first one.
    pub(crate) fn merge(&mut self, other: Self) {
        if self.format.is_empty() {
            *self = other;
            return;
        }
        if self.crs == other.crs {
            let bounds = other.bounds.map(|own| Bounds::with(own.max, Some(Bounds::with(own.min, self.bounds))));
            self.bounds = bounds.or(self.bounds);
        }
        for attribute in other.attributes {
            match self.attributes.iter_mut().find(|own| own.name == attribute.name) {
                Some(own) => {
                    own.texts += attribute.texts;
                    own.numbers += attribute.numbers;
                    own.bools += attribute.bools;
                    own.binaries += attribute.binaries;
                }
                None => self.attributes.push(attribute),
            }
        }
        self.layers.extend(other.layers);
        self.unlisted_values += other.unlisted_values;
        self.skipped.extend(other.skipped);
    }
}

/// A layer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layer {
    pub name: String,
    /// Number of features that were passed on. A collection of several kinds of geometry counts once per kind.
    pub features: u64,
}

/// A reference system.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Crs {
    /// `EPSG:n`, or Well-Known Text.
    pub text: String,
    pub origin: CrsOrigin,
}

/// Where a reference system is known from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CrsOrigin {
    /// The file names it.
    File,
    /// The format prescribes it: longitude and latitude on WGS 84 in GPX, and in GeoJSON without `crs`.
    Format,
    /// The columns are called longitude and latitude; the file does not name a reference system.
    Assumed,
}

impl Crs {
    pub(super) fn epsg(code: u32, origin: CrsOrigin) -> Self {
        Self { text: format!("EPSG:{code}"), origin }
    }
}

/// The smallest and largest x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

impl Bounds {
    pub(super) fn with([x, y]: [f64; 2], bounds: Option<Self>) -> Self {
        let Some(Self { min, max }) = bounds else { return Self { min: [x, y], max: [x, y] } };
        Self { min: [min[0].min(x), min[1].min(y)], max: [max[0].max(x), max[1].max(y)] }
    }
}

/// An attribute, and how many features have a value of each kind.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Attribute {
    pub name: Arc<str>,
    pub texts: u64,
    pub numbers: u64,
    pub bools: u64,
    /// Number of values that were left out, because they are binary data.
    pub binaries: u64,
}

/// Features, or parts of them, that were left out for one reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Skipped {
    pub reason: Reason,
    /// Number of features of which nothing was left.
    pub features: u64,
    /// Number of parts (points, lines, rings, polygons) that were left out of features that have others.
    pub parts: u64,
    /// The record of the first of them.
    pub first: u64,
}

impl Skipped {
    /// Returns the number, the reason and the first record, as a clause that follows the name of the file.
    pub(crate) fn clause(&self, record_noun: &str) -> String {
        let count = self.features + self.parts;
        let noun = if count == 1 { "feature" } else { "features" };
        format!("left out {count} {noun} with {} (first: {record_noun} {})", self.reason, self.first)
    }
}

/// The reason why a feature or a part of it was left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Reason {
    #[error("no geometry")]
    NoGeometry,
    #[error("an empty geometry")]
    Empty,
    #[error("a coordinate that is missing or is not a finite number")]
    NotFinite,
    #[error("a line of fewer than two points")]
    ShortLine,
    #[error("a ring of fewer than three points")]
    ShortRing,
    #[error("a curved geometry ({0}); convert it to straight lines")]
    Curve(&'static str),
    #[error("a geometry of an unknown type")]
    UnknownType,
    #[error("a damaged geometry ({0})")]
    Damaged(&'static str),
    #[error("a row with fewer or more fields than the header")]
    Fields,
}
