//! Places positions of a file on the land of a world.

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::model::Position;
use super::summary::Crs as FileCrs;
use crate::file::message::{named, printable};
use crate::source::earth_projection;
use crate::source::georeference::{Crs, Georeference};
use crate::source::mosaic::SampleTransform;
use crate::source::{GeoreferenceError, WorldMapping};

/// Why the positions of a file cannot be placed on the land. One line that names the file.
#[derive(Debug, thiserror::Error)]
pub enum OnLandError {
    /// The reference system is unknown.
    #[error(
        "{}: its reference system is not one that hachure knows; if it is wrong, assign the right one, for example with \
         ogr2ogr -a_srs EPSG:CODE OUT.gpkg IN ({cause})",
        named(path)
    )]
    Crs {
        path: PathBuf,
        /// The defect of the reference system.
        cause: GeoreferenceError,
    },
    /// There is no way from its coordinates to those of the land.
    #[error("{}: its positions cannot be placed on the land: {cause}", named(path))]
    NoWay {
        path: PathBuf,
        /// The reason, as a clause.
        cause: String,
    },
}

/// Checks that the land has a reference system, to which other coordinates can be converted.
fn check_crs(place: &Georeference) -> Result<(), String> {
    match place.crs {
        Crs::Local => {
            Err("the heights have no coordinate reference system; assign one, for example with gdal_edit -a_srs \
                           EPSG:CODE"
                .to_owned())
        }
        _ => Ok(()),
    }
}

/// The way from the coordinates of a file to the land.
pub(crate) struct OnLand {
    way: SampleTransform,
    mapping: WorldMapping,
    /// Column and row of the last sample.
    last: DVec2,
    /// Where the land is in the coordinates of the file; `None` if they have the reference system of the land.
    around: Option<Around>,
}

/// A rectangle around the land, in the coordinates of a file. Areas end there before their positions are converted: a
/// projection puts what is far away in wrong places.
struct Around {
    corners: [DVec2; 2],
    /// A whole turn, if the first coordinate is a longitude or one that repeats like it.
    turn: Option<f64>,
}

/// Places along each side of the land whose coordinates in the file are looked at.
const AROUND_PLACES: u32 = 16;

impl Around {
    fn new(own: &Georeference, place: &Georeference, last: DVec2) -> Option<Self> {
        let way = SampleTransform::between(place, own, None).ok()?;
        if !matches!(way, SampleTransform::Projected { .. }) {
            return None;
        }
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for place in 0..(AROUND_PLACES + 1).pow(2) {
            let part = DVec2::new(f64::from(place % (AROUND_PLACES + 1)), f64::from(place / (AROUND_PLACES + 1)));
            let on_grid = last * part / f64::from(AROUND_PLACES);
            let at = DVec2::from_array(way.map(on_grid.x, on_grid.y));
            // A part of the land that the file's reference system does not have may be anywhere.
            if !at.is_finite() {
                return None;
            }
            (low, high) = (low.min(at), high.max(at));
        }
        let margin = 0.5 * (high - low) + 1e-6 * low.abs().max(high.abs());
        Some(Self { corners: [low - margin, high + margin], turn: earth_projection::turn_in_crs(own) })
    }

    fn clipped(&self, ring: Vec<DVec2>) -> Vec<DVec2> {
        let middle_of = |[low, high]: [f64; 2]| 0.5 * (low + high);
        let range = |values: &dyn Fn(f64, f64) -> f64, start: f64| ring.iter().map(|at| at.x).fold(start, values);
        let of_ring = middle_of([range(&f64::min, f64::INFINITY), range(&f64::max, f64::NEG_INFINITY)]);
        let of_land = middle_of(self.corners.map(|corner| corner.x));
        let shift = self.turn.map_or(0.0, |turn| turn * ((of_ring - of_land) / turn).round());
        let shift = if shift.is_finite() { shift } else { 0.0 };
        clipped_ring(ring, self.corners.map(|corner| corner + DVec2::new(shift, 0.0)))
    }
}

/// Returns the part of a ring in a rectangle (Sutherland and Hodgman 1974, "Reentrant Polygon Clipping").
fn clipped_ring(mut ring: Vec<DVec2>, [low, high]: [DVec2; 2]) -> Vec<DVec2> {
    let limits = [(DVec2::X, low.x), (DVec2::NEG_X, -high.x), (DVec2::Y, low.y), (DVec2::NEG_Y, -high.y)];
    for (inward, least) in limits {
        let room = |at: DVec2| at.dot(inward) - least;
        let mut kept = Vec::with_capacity(ring.len());
        let Some(mut before) = ring.last().copied() else { break };
        for at in ring {
            let [from, to] = [room(before), room(at)];
            if (from < 0.0) != (to < 0.0) {
                kept.push(before + (at - before) * (from / (from - to)));
            }
            if to >= 0.0 {
                kept.push(at);
            }
            before = at;
        }
        ring = kept;
    }
    ring
}

impl OnLand {
    /// Finds the way from coordinates in the reference system `crs` to land with the georeference `place` and `samples`
    /// columns and rows. Coordinates without a reference system are those of the land, even if that has none.
    ///
    /// # Errors
    /// The reference system is unknown, or only the land has none.
    pub(crate) fn new(
        path: &Path,
        crs: Option<&FileCrs>,
        place: &Georeference,
        samples: [u32; 2],
    ) -> Result<Self, OnLandError> {
        let own = match crs {
            Some(crs) => Georeference::of_text(&crs.text, &named(path)),
            None => Ok(Georeference { crs_from_grid: [0.0, 1.0, 0.0, 0.0, 0.0, 1.0], ..place.clone() }),
        };
        let own = own.map_err(|cause| OnLandError::Crs { path: path.to_owned(), cause })?;
        let no_way = |cause: String| OnLandError::NoWay { path: path.to_owned(), cause: printable(&cause, 120) };
        if crs.is_some() {
            check_crs(place).map_err(no_way)?;
        }
        Self::between(&own, place, samples).map_err(no_way)
    }

    /// Finds the way from columns and rows of the land itself.
    ///
    /// # Errors
    /// Returns why there is none, as a clause.
    pub(crate) fn of_land(place: &Georeference, samples: [u32; 2]) -> Result<Self, String> {
        Self::between(place, place, samples)
    }

    /// Finds the way from longitudes and latitudes in degrees on WGS 84.
    ///
    /// # Errors
    /// Returns why there is none, as a clause.
    pub(crate) fn of_degrees(place: &Georeference, samples: [u32; 2]) -> Result<Self, String> {
        check_crs(place)?;
        let own = Georeference::of_coordinates(None).map_err(|error| error.to_string())?;
        Self::between(&own, place, samples)
    }

    fn between(own: &Georeference, place: &Georeference, samples: [u32; 2]) -> Result<Self, String> {
        let mapping = WorldMapping::new(place, samples[0], samples[1]).map_err(|error| error.to_string())?;
        let way = SampleTransform::to_grid(own, place, samples)?;
        let last = DVec2::from_array(samples.map(|count| f64::from(count) - 1.0));
        Ok(Self { way, mapping, last, around: Around::new(own, place, last) })
    }

    /// Returns the column and the row of a position, which may be outside of the land.
    pub(crate) fn grid(&self, at: &Position) -> DVec2 {
        DVec2::from_array(self.way.map(at[0], at[1]))
    }

    /// Returns the place in the world of a column and a row, east and north in metres.
    pub(crate) fn world_m(&self, grid: DVec2) -> DVec2 {
        self.mapping.world_from_grid(grid.x, grid.y)
    }

    /// Returns whether a column and a row are on the land.
    pub(crate) fn holds(&self, grid: DVec2) -> bool {
        grid.cmpge(DVec2::ZERO).all() && grid.cmple(self.last).all()
    }

    /// Returns the parts of a line on the grid that are on the land.
    pub(crate) fn clipped(&self, line: impl IntoIterator<Item = DVec2>) -> Vec<Vec<DVec2>> {
        let mut parts: Vec<Vec<DVec2>> = Vec::new();
        let mut before: Option<DVec2> = None;
        let mut is_open = false;
        for at in line {
            let segment = before.replace(at).filter(|_| at.is_finite()).and_then(|from| self.inside(from, at));
            let Some([from, to]) = segment else {
                is_open = false;
                continue;
            };
            match parts.last_mut().filter(|part| is_open && part.last() == Some(&from)) {
                Some(part) => part.push(to),
                None => parts.push(vec![from, to]),
            }
            is_open = to == at;
        }
        parts
    }

    /// Returns the part of a ring of positions that is near the land, in the coordinates of the file.
    pub(crate) fn near(&self, ring: &[Position]) -> Vec<DVec2> {
        let ring: Vec<DVec2> = ring.iter().map(|at| DVec2::new(at[0], at[1])).collect();
        match &self.around {
            Some(around) => around.clipped(ring),
            None => ring,
        }
    }

    /// Returns the part of a ring of positions that is on the land, or less than a sample away from it, as one ring on the
    /// grid. Parts that were connected outside are connected along the border. The ring is empty if nothing is left.
    pub(crate) fn clipped_area(&self, ring: &[Position]) -> Vec<DVec2> {
        let on_grid = self.near(ring).into_iter().map(|at| self.grid(&[at.x, at.y, f64::NAN]));
        // Positions that the land's reference system does not have are left out.
        clipped_ring(on_grid.filter(|at| at.is_finite()).collect(), [DVec2::NEG_ONE, self.last + 1.0])
    }

    /// Returns the south-west and the north-east corner of a rectangle around the land, in metres of the world.
    pub(crate) fn around_m(&self) -> [DVec2; 2] {
        let corners = [DVec2::ZERO, DVec2::new(self.last.x, 0.0), DVec2::new(0.0, self.last.y), self.last];
        let [first_m, rest_m @ ..] = corners.map(|grid| self.world_m(grid));
        rest_m.iter().fold([first_m; 2], |[low_m, high_m], at_m| [low_m.min(*at_m), high_m.max(*at_m)])
    }

    /// Returns the part of a segment that is on the land (Liang and Barsky 1984, "A New Concept and Method for Line
    /// Clipping").
    fn inside(&self, from: DVec2, to: DVec2) -> Option<[DVec2; 2]> {
        if !from.is_finite() || !to.is_finite() {
            return None;
        }
        let way = to - from;
        let (mut begin, mut end) = (0.0_f64, 1.0_f64);
        for (step, room) in
            [(-way.x, from.x), (way.x, self.last.x - from.x), (-way.y, from.y), (way.y, self.last.y - from.y)]
        {
            if step == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if step < 0.0 {
                begin = begin.max(room / step);
            } else {
                end = end.min(room / step);
            }
        }
        let at = |part: f64| {
            if part <= 0.0 {
                from
            } else if part >= 1.0 {
                to
            } else {
                from + way * part
            }
        };
        (begin <= end).then(|| [at(begin), at(end)])
    }
}
