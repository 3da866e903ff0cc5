//! Reads files of features onto the land of a world.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use glam::DVec2;

use super::areas::{AreaRings, AreaTree, MOST_EDGES, MOST_OF_CELL};
use super::graticule::{self, GridLine};
use super::tree::LineTree;
use super::{Draped, Part, PartKind, Source};
use crate::features::{
    self, Area, Attributes, Choice, Feature, FeatureError, Geometry, OnLand, OnLandError, Position, Summary, Value,
};
use crate::file::message::named;
use crate::scene::{FeatureFile, Graticule};
use crate::source::georeference::Georeference;
use crate::style::layers::GRATICULE;

/// Largest number of positions on the land, and of lines and points, of all files.
const MAX_POSITIONS: usize = 1 << 25;
const MAX_PARTS: usize = 1 << 22;
/// Largest memory of the attributes of all features.
const MAX_ATTRIBUTE_BYTES: usize = 1 << 30;

/// Why files of features cannot be drawn. One line that names the file.
#[derive(Debug, thiserror::Error)]
pub enum DrapedError {
    /// The file cannot be read.
    #[error(transparent)]
    Feature(#[from] FeatureError),
    /// Its positions cannot be placed on the land.
    #[error(transparent)]
    OnLand(#[from] OnLandError),
    /// The land has no such graticule.
    #[error("--graticule {graticule}: {cause}")]
    Graticule {
        /// The distance of its lines.
        graticule: Graticule,
        /// The reason, as a clause.
        cause: String,
    },
    /// The file exceeds a limit of positions, lines and points, or attributes.
    #[error(
        "{}: has more than {MAX_POSITIONS} positions, {MAX_PARTS} lines and points or 1 GiB of attributes on the land, with \
         the files before it; clip or simplify it, for example with ogr2ogr -clipdst, -simplify or -select",
        named(path)
    )]
    TooMany {
        /// Path of the file.
        path: PathBuf,
    },
}

/// The parts that have been read.
#[derive(Default)]
struct Found {
    lines: Vec<(u32, Vec<DVec2>)>,
    areas: Vec<AreaRings>,
    /// Number of places of `areas`.
    area_places: usize,
    /// South-west and north-east corner of a rectangle around the land, in metres of the world, once a file has been read.
    around_m: Option<[DVec2; 2]>,
    parts: Vec<Part>,
    sources: Vec<Source>,
    positions: usize,
    attribute_bytes: usize,
}

impl Draped {
    /// Reads files for land with the georeference `place` and `samples` columns and rows. What cannot be drawn is
    /// reported in the log.
    ///
    /// # Errors
    /// The first file that cannot be read, or that cannot be placed on the land.
    pub(crate) fn read(
        files: &[FeatureFile],
        graticule: Option<Graticule>,
        place: &Georeference,
        samples: [u32; 2],
    ) -> Result<Self, DrapedError> {
        let mut found = Found::default();
        for file in files {
            let path = &file.path;
            let before = found.parts.len();
            let layers = match &file.layer {
                Some(layer) => vec![Some(layer.clone())],
                None => all_layers(path)?,
            };
            for layer in layers {
                found.read(path, &Choice { layer }, place, samples)?;
            }
            if found.parts.len() == before {
                tracing::warn!(
                    "{}: none of its features are on the land; hachure info prints where they are, and where the land is",
                    named(path)
                );
            }
        }
        if let Some(graticule) = graticule {
            found.rule(graticule, place, samples).map_err(|cause| DrapedError::Graticule { graticule, cause })?;
        }
        let Found { lines, areas, area_places, around_m, parts, sources, .. } = found;
        let areas = if area_places > MOST_EDGES {
            tracing::warn!(
                "features: areas are not filled, only outlined: their outlines have {area_places} points on the land, and \
                 hachure can fill at most {MOST_EDGES}; simplify them, for example with ogr2ogr -simplify"
            );
            None
        } else {
            around_m.and_then(|around_m| AreaTree::new(&areas, around_m))
        };
        let is_crowded = areas.as_ref().is_some_and(|areas| areas.most_edges > MOST_OF_CELL);
        if is_crowded {
            tracing::warn!(
                "features: areas are not filled, only outlined: more than {MOST_OF_CELL} outlines run through one place; draw \
                 fewer, for example with ogr2ogr -where"
            );
        }
        let areas = areas.filter(|_| !is_crowded);
        Ok(Self { tree: LineTree::new(lines), areas, parts, sources, rules: Mutex::default() })
    }
}

/// Returns the layers that are read from a file: all of them, where a format has several.
fn all_layers(path: &Path) -> Result<Vec<Option<String>>, DrapedError> {
    // A caller that takes no feature learns whether a layer has to be chosen.
    match features::read(path, &Choice::default(), &mut |_| ControlFlow::Break(())) {
        Ok(_) => Ok(vec![None]),
        Err(error) if !error.layers().is_empty() => Ok(error.layers().iter().cloned().map(Some).collect()),
        Err(error) => Err(error.into()),
    }
}

impl Found {
    fn read(
        &mut self,
        path: &Path,
        choice: &Choice,
        place: &Georeference,
        samples: [u32; 2],
    ) -> Result<(), DrapedError> {
        let summary = features::survey(path, choice)?;
        let land = OnLand::new(path, summary.crs.as_ref(), place, samples)?;
        self.around_m = Some(land.around_m());
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase()).unwrap_or_default();
        let first_source = self.sources.len() as u32;
        let attributes: Vec<String> = summary.attributes.iter().map(|attribute| attribute.name.to_string()).collect();
        self.sources.extend(summary.layers.iter().map(|layer| Source {
            file: stem.clone(),
            layer: layer.name.to_lowercase(),
            attributes: attributes.clone(),
            is_graticule: false,
        }));
        let summary = features::read(path, choice, &mut |feature| {
            self.add(feature, first_source, &land);
            if self.is_full() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        if self.is_full() {
            return Err(DrapedError::TooMany { path: path.to_owned() });
        }
        report(path, &summary);
        Ok(())
    }

    fn is_full(&self) -> bool {
        self.positions > MAX_POSITIONS || self.parts.len() > MAX_PARTS || self.attribute_bytes > MAX_ATTRIBUTE_BYTES
    }

    /// Adds the lines of a graticule.
    fn rule(&mut self, graticule: Graticule, place: &Georeference, samples: [u32; 2]) -> Result<(), String> {
        let ruled = graticule::lines(graticule, place, samples)?;
        let land = OnLand::of_land(place, samples)?;
        let source = self.sources.len() as u32;
        let names: [Arc<str>; 2] = ["kind".into(), "value".into()];
        self.sources.push(Source {
            file: GRATICULE.to_owned(),
            layer: GRATICULE.to_owned(),
            attributes: names.iter().map(|name| name.to_string()).collect(),
            is_graticule: true,
        });
        for GridLine { kind, value, line } in ruled {
            let mut attributes = Attributes::default();
            attributes.push(Arc::clone(&names[0]), Value::Text(kind.to_owned()));
            attributes.push(Arc::clone(&names[1]), Value::Number(value));
            let attributes = Arc::new(attributes);
            for part in land.clipped(line) {
                self.lines.push((self.parts.len() as u32, part.into_iter().map(|grid| land.world_m(grid)).collect()));
                self.parts.push(Part { kind: PartKind::Line, source, attributes: Arc::clone(&attributes) });
            }
        }
        Ok(())
    }

    fn add(&mut self, feature: Feature, first_source: u32, land: &OnLand) {
        let source = first_source + feature.layer as u32;
        let attributes = Arc::new(feature.attributes);
        let before = self.parts.len();
        let mut add = |kind: PartKind, line: Vec<DVec2>| {
            self.positions += line.len();
            self.lines.push((self.parts.len() as u32, line));
            self.parts.push(Part { kind, source, attributes: Arc::clone(&attributes) });
        };
        let in_world = |part: Vec<DVec2>| part.into_iter().map(|grid| land.world_m(grid)).collect();
        match &feature.geometry {
            Geometry::Points(points) => {
                for grid in points.iter().map(|at| land.grid(at)).filter(|grid| land.holds(*grid)) {
                    add(PartKind::Point, vec![land.world_m(grid)]);
                }
            }
            Geometry::Lines(lines) => {
                for part in lines.iter().flat_map(|line| land.clipped(line.iter().map(|at| land.grid(at)))) {
                    add(PartKind::Line, in_world(part));
                }
            }
            Geometry::Areas(areas) => {
                let rings = areas.iter().flat_map(|area| std::iter::once(&area.outer).chain(&area.holes));
                for ring in rings {
                    // As for the fill, so that both have one border.
                    let near = land.near(ring);
                    let closed = near.iter().chain(near.first());
                    for part in land.clipped(closed.map(|at| land.grid(&[at.x, at.y, f64::NAN]))) {
                        add(PartKind::Ring, in_world(part));
                    }
                }
                let rings: Vec<Vec<DVec2>> = areas.iter().flat_map(|area| rings_of(area, land)).collect();
                if !rings.is_empty() {
                    self.area_places += rings.iter().map(Vec::len).sum::<usize>();
                    self.areas.push(AreaRings { area: self.parts.len() as u32, rings });
                    self.parts.push(Part { kind: PartKind::Area, source, attributes: Arc::clone(&attributes) });
                }
            }
        }
        if self.parts.len() > before {
            self.attribute_bytes += attributes.bytes();
        }
    }
}

/// Returns the rings of an area that enclose land, in metres of the world: the outer one counter-clockwise and holes
/// clockwise, whatever their direction in the file.
fn rings_of(area: &Area, land: &OnLand) -> Vec<Vec<DVec2>> {
    let ring = |positions: &[Position], is_hole: bool| {
        let grid = land.clipped_area(positions);
        let mut ring: Vec<DVec2> = grid.into_iter().map(|grid| land.world_m(grid)).collect();
        let next = ring.iter().cycle().skip(1);
        // Relative to one of them, so that little is lost to rounding.
        let first_m = ring.first().copied().unwrap_or_default();
        let doubled_m2: f64 = ring.iter().zip(next).map(|(a, b)| (*a - first_m).perp_dot(*b - first_m)).sum();
        if (doubled_m2 < 0.0) != is_hole {
            ring.reverse();
        }
        (doubled_m2 != 0.0).then_some(ring)
    };
    let holes = area.holes.iter().filter_map(|hole| ring(hole, true));
    ring(&area.outer, false).into_iter().chain(holes).collect()
}

/// Reports what a file has that could not be read.
fn report(path: &Path, summary: &Summary) {
    for skipped in &summary.skipped {
        tracing::warn!("{}: {}", named(path), skipped.clause(summary.record_noun));
    }
}
