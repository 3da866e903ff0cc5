//! Combines the grids of several DEMs: the common lattice, its extent, and the transformation from it to each member's
//! own grid.

use proj4rs::Proj;
use proj4rs::transform::transform;

use super::super::datum::{DatumShift, datum_shift, parameter};
use super::super::georeference::{Crs, Georeference};
use super::super::{GeoKey, GeoKeyValue};
use super::super::{Window, WorldMapping, earth_projection};

/// Offsets from a whole number of samples below this count as zero.
const ALIGNED_SAMPLES: f64 = 1e-3;

/// Spacing of the exact nodes of a reprojection in samples; between them it is interpolated bilinearly.
const NODES_APART: u32 = 16;

/// The reason why a file without a reference system does not fit one that has one.
const NO_CRS: &str = "has no coordinate reference system, but other files of the same world have one; assign it (as \
                      gdal_edit.py -a_srs EPSG:CODE does) or leave the file out";

const TOO_FAR: &str = "is too far from the other files to form one grid with them";

/// Largest number of samples on a side of a mosaic.
const LARGEST_SIDE: f64 = (1 << 24) as f64;

/// Share of a grid that its members must cover for no warning.
const SPARSE_SHARE: f64 = 0.1;

/// Why several DEMs have no common grid.
#[derive(Debug)]
pub(crate) struct Misfit {
    /// Number of the member that is the reason.
    pub member: usize,
    /// The reason, as a sentence about this member.
    pub cause: String,
}

/// The grid of a mosaic: the lattice of its finest member (the first of them), extended to all.
#[derive(Debug)]
pub(crate) struct MosaicGrid {
    pub georeference: Georeference,
    /// Columns and rows.
    pub size: [u32; 2],
    /// The members in the given order.
    pub members: Vec<Placed>,
    /// Whether members are combined whose datums are not related to each other.
    has_unrelated_datums: bool,
}

/// The position of a member in the grid.
#[derive(Debug)]
pub(crate) struct Placed {
    /// Columns and rows of the member's own grid.
    pub size: [u32; 2],
    /// Sample spacing as a multiple of the mosaic's, 1 or more.
    pub ratio: f64,
    way: Way,
}

/// The transformation from the samples of one grid to those of another.
#[derive(Debug)]
pub(crate) enum Way {
    /// Sample (0, 0) of the target coincides with this sample of the grid.
    Whole([i64; 2]),
    /// Affine coefficients `[x0, dx/dcolumn, dx/drow, y0, dy/dcolumn, dy/drow]`: target coordinates from grid
    /// coordinates.
    Affine([f64; 6]),
    /// A transformation through both reference systems. Coordinates x of the target repeat themselves after `turn`; they
    /// are taken as close as possible to the second number.
    Projected { from: Box<Side>, to: Box<Side>, turn: Option<[f64; 2]> },
}

/// A grid with its reference system.
#[derive(Debug)]
pub(crate) struct Side {
    crs_from_grid: [f64; 6],
    proj: Proj,
    /// Factor from a unit of the CRS to the unit of `proj`, radians or metres.
    per_unit: f64,
}

impl MosaicGrid {
    /// Builds the grid of members with these georeferences and sizes.
    ///
    /// # Errors
    /// Fails, with one line, if there is no member, if no transformation between the reference systems is known, or if
    /// the extent is not a valid grid.
    pub(crate) fn new(members: &[(&Georeference, [u32; 2])]) -> Result<Self, Misfit> {
        let of = |member: usize| move |cause: String| Misfit { member, cause };
        let is_local = |(place, _): &(&Georeference, _)| matches!(place.crs, Crs::Local);
        if let (Some(member), false) = (members.iter().position(is_local), members.iter().all(is_local)) {
            return Err(of(member)(NO_CRS.into()));
        }
        let spacings_m: Vec<f64> = (0..)
            .zip(members)
            .map(|(member, (place, size))| spacing_m(place, *size).map_err(of(member)))
            .collect::<Result<_, _>>()?;
        let finest_m = spacings_m.iter().copied().fold(f64::INFINITY, f64::min);
        // Spacings within one per cent are tiles of the same product at two latitudes, not two products.
        let first = spacings_m.iter().position(|&spacing_m| spacing_m < finest_m * 1.01);
        let first = first.ok_or_else(|| of(0)("there are no height files".into()))?;
        if let Some((other, (place, _))) =
            members.iter().enumerate().find(|(_, (place, _))| !same(place, members[first].0))
        {
            // The lattice takes part in each transformation, so its own reference system is set up first.
            Side::new(members[first].0).map_err(of(first))?;
            Side::new(place).map_err(of(other))?;
        }
        let lattice = members[first].0;
        let is_unrelated =
            |place: &Georeference| !same(place, lattice) && has_unknown_datum(place) != has_unknown_datum(lattice);
        let has_unrelated_datums = members.iter().any(|(place, _)| is_unrelated(place));
        let turned = turned(members, first)?;
        let members: Vec<(&Georeference, [u32; 2])> =
            turned.iter().zip(members).map(|(turned, (_, size))| (&turned.place, *size)).collect();
        let (lattice, lattice_size) = members[first];
        let mut bounds = [0.0, 0.0, f64::from(lattice_size[0] - 1), f64::from(lattice_size[1] - 1)];
        for (member, ((place, size), turned)) in members.iter().zip(&turned).enumerate() {
            let back = Way::between(place, lattice, Some(turned.middle)).map_err(of(member))?;
            let steps = 16;
            for i in 0..=steps {
                let at = |count: u32| f64::from(count - 1) * f64::from(i) / f64::from(steps);
                let (x, y, right, bottom) = (at(size[0]), at(size[1]), f64::from(size[0] - 1), f64::from(size[1] - 1));
                for (column, row) in [(x, 0.0), (x, bottom), (0.0, y), (right, y)] {
                    let [x, y] = back.map(column, row);
                    if !(x.abs() < LARGEST_SIDE && y.abs() < LARGEST_SIDE) {
                        return Err(of(member)(TOO_FAR.into()));
                    }
                    bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x), bounds[3].max(y)];
                }
            }
        }
        let first = [bounds[0], bounds[1]].map(|c| (c + ALIGNED_SAMPLES).floor());
        let last = [bounds[2], bounds[3]].map(|c| (c - ALIGNED_SAMPLES).ceil());
        let [x0, a, b, y0, c, d] = lattice.crs_from_grid;
        let crs_from_grid = [x0 + a * first[0] + b * first[1], a, b, y0 + c * first[0] + d * first[1], c, d];
        let georeference = Georeference { crs_from_grid, ..lattice.clone() };
        let size = [0, 1].map(|axis| (last[axis] - first[axis]) as u32 + 1);
        let placed = members.iter().zip(spacings_m).enumerate().map(|(member, ((place, size), spacing_m))| {
            let way = Way::between(&georeference, place, Some(middle_x(place, *size))).map_err(of(member))?;
            Ok(Placed { size: *size, ratio: (spacing_m / finest_m).max(1.0), way })
        });
        let members = placed.collect::<Result<_, Misfit>>()?;
        Ok(Self { georeference, size, members, has_unrelated_datums })
    }

    /// Warns if most of the grid is beyond all members, because they may be of two places, and if members may be
    /// displaced.
    pub(crate) fn warn(&self) {
        if self.has_unrelated_datums {
            tracing::warn!(
                "the {} files have different reference systems, and the datum of some of them is unknown: files may be \
                 displaced against others by 100 m or more",
                self.members.len()
            );
        }
        let share = self.covered_share();
        if share < SPARSE_SHARE {
            let ([width, height], count) = (self.size, self.members.len());
            tracing::warn!(
                "the {count} files cover {:.2} % of the {width} × {height} samples that reach from one to the other; \
                 the rest is no-data. If they do not belong together, open them one by one",
                100.0 * share
            );
        }
    }

    /// Returns the share of the grid that its members would cover if none overlapped another, at most 1.
    fn covered_share(&self) -> f64 {
        let area = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
        let members: f64 = self.members.iter().map(|member| area(member.size) * member.ratio * member.ratio).sum();
        (members / area(self.size)).min(1.0)
    }
}

/// A member whose longitudes, or eastings of a cylindrical projection, are shifted by whole turns.
struct Turned {
    place: Georeference,
    /// The middle of its extent, as coordinate x of the lattice's CRS.
    middle: f64,
}

/// Shifts members by whole turns of longitude so that the world is cut where the widest gap between them is: two
/// neighbours at 180° are neighbours. The member `first`, whose lattice is that of the world, is not shifted.
///
/// # Errors
/// The same as [`Way::between`].
fn turned(members: &[(&Georeference, [u32; 2])], first: usize) -> Result<Vec<Turned>, Misfit> {
    let lattice = members[first].0;
    let unmoved =
        |(place, size): &(&Georeference, [u32; 2])| Turned { place: (*place).clone(), middle: middle_x(place, *size) };
    let Some(turn) = earth_projection::turn_in_crs(lattice).filter(|_| members.len() > 1) else {
        return Ok(members.iter().map(unmoved).collect());
    };
    let range = |(member, (place, size)): (usize, &(&Georeference, [u32; 2]))| {
        range_x(place, *size, lattice, turn).map_err(|cause| Misfit { member, cause })
    };
    let ranges = members.iter().enumerate().map(range).collect::<Result<Vec<_>, _>>()?;
    let shifts = shifts(&ranges, turn, first);
    let turned = members.iter().zip(ranges).zip(shifts).map(|(((place, _), [low, high]), shift)| {
        let mut place = (*place).clone();
        // Members in another CRS are shifted by their transformation, which is taken close to the middle.
        if same(&place, lattice) {
            place.crs_from_grid[0] += shift;
        }
        Turned { place, middle: 0.5 * (low + high) + shift }
    });
    Ok(turned.collect())
}

/// Returns the coordinate x of the middle of a grid in its CRS.
pub(super) fn middle_x(place: &Georeference, size: [u32; 2]) -> f64 {
    let [column, row] = size.map(|count| f64::from(count - 1) / 2.0);
    apply(place.crs_from_grid, column, row)[0]
}

/// Returns the smallest and the largest coordinate x of a member in the CRS of the lattice.
fn range_x(place: &Georeference, size: [u32; 2], lattice: &Georeference, turn: f64) -> Result<[f64; 2], String> {
    let unit = Georeference { crs_from_grid: [0.0, 1.0, 0.0, 0.0, 0.0, 1.0], ..lattice.clone() };
    let middle = size.map(|count| f64::from(count - 1) / 2.0);
    let centre = Way::between(place, &unit, None)?.map(middle[0], middle[1])[0];
    // Every part of a member is within half a turn of its middle.
    let way = Way::between(place, &unit, Some(centre))?;
    let steps = [0.0, 0.25, 0.5, 0.75, 1.0];
    let places = steps.into_iter().flat_map(|i| steps.map(|k| way.map(2.0 * i * middle[0], 2.0 * k * middle[1])[0]));
    let range = places.fold([centre, centre], |[low, high], x| [low.min(x), high.max(x)]);
    let is_valid = range.iter().all(|x| x.is_finite()) && range[1] - range[0] < 2.0 * turn;
    if is_valid { Ok(range) } else { Err(TOO_FAR.into()) }
}

/// Returns whole multiples of `turn` to be added to each range, so that all of them together are shortest; that of
/// `first` is 0.
fn shifts(ranges: &[[f64; 2]], turn: f64, first: usize) -> Vec<f64> {
    let begin = |range: &[f64; 2]| range[0].rem_euclid(turn);
    let mut order: Vec<usize> = (0..ranges.len()).collect();
    order.sort_by(|&a, &b| begin(&ranges[a]).total_cmp(&begin(&ranges[b])));
    // The widest gap is after the range that ends before the one that begins next.
    let (mut widest, mut cut, mut end) = (f64::NEG_INFINITY, 0.0, f64::NEG_INFINITY);
    for round in 0..2 {
        for &index in &order {
            let start = begin(&ranges[index]) + turn * f64::from(round);
            if start - end > widest * (1.0 + 1e-9) + 1e-9 && end.is_finite() {
                (widest, cut) = (start - end, start.rem_euclid(turn));
            }
            end = end.max(start + ranges[index][1] - ranges[index][0]);
        }
    }
    let shift = |range: &[f64; 2]| {
        let place = (begin(range) - cut + 1e-9 * turn).rem_euclid(turn) - 1e-9 * turn + cut;
        ((place - range[0]) / turn).round()
    };
    let turns: Vec<f64> = ranges.iter().map(shift).collect();
    let length = |turns: &[f64]| {
        let ends = ranges.iter().zip(turns).map(|(range, turns)| range.map(|x| x + turns * turn));
        let [low, high] =
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)]);
        high - low
    };
    // A whole earth stays as it is.
    let unmoved = vec![0.0; ranges.len()];
    if length(&unmoved) <= length(&turns) * (1.0 + 1e-9) {
        return unmoved;
    }
    turns.iter().map(|own| (own - turns[first]) * turn).collect()
}

impl Placed {
    /// Returns the position of the member's sample (0, 0) in the grid, if its samples coincide with the grid's.
    pub(crate) fn shift(&self) -> Option<[i64; 2]> {
        match self.way {
            Way::Whole(shift) => Some(shift),
            _ => None,
        }
    }

    /// Returns (column, row) in the member for `columns` × `rows` points of the grid, row by row. The first point is at
    /// `first`, and they are `step` apart, in samples of the grid. Points that a projection cannot represent are NaN.
    pub(crate) fn coordinates(&self, first: [f64; 2], step: [f64; 2], [columns, rows]: [u32; 2]) -> Vec<[f64; 2]> {
        let at = |column: u32, row: u32| {
            self.way.map(first[0] + step[0] * f64::from(column), first[1] + step[1] * f64::from(row))
        };
        if !matches!(self.way, Way::Projected { .. }) {
            return (0..columns * rows).map(|i| at(i % columns, i / columns)).collect();
        }
        let nodes = columns / NODES_APART + 2;
        let node_rows = rows / NODES_APART + 2;
        let exact: Vec<[f64; 2]> =
            (0..nodes * node_rows).map(|i| at(i % nodes * NODES_APART, i / nodes * NODES_APART)).collect();
        let part = |c: u32| f64::from(c % NODES_APART) / f64::from(NODES_APART);
        (0..columns * rows)
            .map(|i| {
                let (column, row) = (i % columns, i / columns);
                let corner = (row / NODES_APART * nodes + column / NODES_APART) as usize;
                let (u, v) = (part(column), part(row));
                let nodes = [corner, corner + 1, corner + nodes as usize, corner + nodes as usize + 1];
                if !nodes.iter().all(|&node| exact[node].iter().all(|c| c.is_finite())) {
                    return at(column, row);
                }
                [0, 1].map(|axis| {
                    let across = |corner: usize| exact[corner][axis] * (1.0 - u) + exact[corner + 1][axis] * u;
                    across(nodes[0]) * (1.0 - v) + across(nodes[2]) * v
                })
            })
            .collect()
    }

    /// Returns whether a position of the grid is in the member or within half a sample of it.
    pub(crate) fn holds(&self, place: [f64; 2]) -> bool {
        let place = self.way.map(place[0], place[1]);
        (0..2).all(|axis| (-0.5..=f64::from(self.size[axis]) - 0.5).contains(&place[axis]))
    }

    /// Returns whether a window of the grid may overlap the member.
    pub(crate) fn meets(&self, window: Window) -> bool {
        let at = |first: u32, count: u32, step: u32| f64::from(first) - 0.5 + f64::from(count * step) / 8.0;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (i, k) in (0..=8).flat_map(|k| (0..=8).map(move |i| (i, k))) {
            let place = self.way.map(at(window.x, window.width, i), at(window.y, window.height, k));
            if !place.iter().all(|c| c.is_finite()) {
                // Part of the window is beyond the projection; what the rest of it meets is not known by these places.
                return true;
            }
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        (0..2).all(|axis| high[axis] > -0.5 && low[axis] < f64::from(self.size[axis]) - 0.5)
    }
}

impl Way {
    /// Returns the transformation from the grid at `from` to that at `to`. If the reference systems differ and longitudes
    /// or eastings of `to` repeat themselves, they are taken as close as possible to `middle`, in units of its CRS.
    ///
    /// # Errors
    /// Fails, with one line, if one of them has no reference system, or if no transformation between them is known.
    pub(crate) fn between(from: &Georeference, to: &Georeference, middle: Option<f64>) -> Result<Self, String> {
        if !same(from, to) {
            return Self::projected(
                from,
                to,
                middle.and_then(|middle| Some([earth_projection::turn_in_crs(to)?, middle])),
            );
        }
        let back = inverse(to.crs_from_grid);
        let ([fx, a, b, fy, c, d], [bx, e, f, by, g, h]) = (from.crs_from_grid, back);
        let ways =
            [bx + e * fx + f * fy, e * a + f * c, e * b + f * d, by + g * fx + h * fy, g * a + h * c, g * b + h * d];
        // Over 10⁵ samples the error must not add up to a visible fraction of a sample.
        let unit = [1.0, 0.0, 0.0, 1.0];
        let is_unit =
            [ways[1], ways[2], ways[4], ways[5]].iter().zip(unit).all(|(way, unit)| (way - unit).abs() < 1e-8);
        let shift = [-ways[0], -ways[3]];
        if is_unit && shift.iter().all(|c| (c - c.round()).abs() < ALIGNED_SAMPLES) {
            return Ok(Self::Whole(shift.map(|c| c.round() as i64)));
        }
        Ok(Self::Affine(ways))
    }

    /// Returns the transformation from coordinates or samples at `from` to the grid of `size` at `to`. Longitudes that
    /// differ from those of the grid by a whole turn are on it: −179° is on a grid from 170° to 190°.
    ///
    /// # Errors
    /// The same as [`Self::between`].
    pub(crate) fn to_grid(from: &Georeference, to: &Georeference, size: [u32; 2]) -> Result<Self, String> {
        let middle = middle_x(to, size);
        let beyond = |turn: &f64| {
            let [column, row] = size.map(|count| f64::from(count - 1));
            let ends = [[0.0, 0.0], [column, 0.0], [0.0, row], [column, row]];
            ends.into_iter().any(|[x, y]| apply(to.crs_from_grid, x, y)[0].abs() > 0.5 * turn * (1.0 + 1e-6))
        };
        match earth_projection::turn_in_crs(to).filter(beyond) {
            Some(turn) => Self::projected(from, to, Some([turn, middle])),
            None => Self::between(from, to, Some(middle)),
        }
    }

    fn projected(from: &Georeference, to: &Georeference, turn: Option<[f64; 2]>) -> Result<Self, String> {
        let back = inverse(to.crs_from_grid);
        let (from, to) = (Side::new(from)?, Side::new(to)?);
        Ok(Self::Projected { from: Box::new(from), to: Box::new(Side { crs_from_grid: back, ..to }), turn })
    }

    /// Returns the target's (column, row) of a position; NaN where a projection cannot represent it.
    pub(crate) fn map(&self, column: f64, row: f64) -> [f64; 2] {
        match self {
            Self::Whole([x, y]) => [column - *x as f64, row - *y as f64],
            Self::Affine(by) => apply(*by, column, row),
            Self::Projected { from, to, turn } => {
                let [x, y] = apply(from.crs_from_grid, column, row).map(|c| c * from.per_unit);
                let mut point = (x, y, 0.0);
                match transform(&from.proj, &to.proj, &mut point) {
                    Ok(()) => {
                        let x = point.0 / to.per_unit;
                        let x = turn.map_or(x, |[turn, middle]| x - turn * ((x - middle) / turn).round());
                        apply(to.crs_from_grid, x, point.1 / to.per_unit)
                    }
                    Err(_) => [f64::NAN; 2],
                }
            }
        }
    }
}

impl Side {
    fn new(place: &Georeference) -> Result<Self, String> {
        let (text, per_unit) = match earth_projection::text(place) {
            Err(_) if place.crs == Crs::Local => return Err(NO_CRS.into()),
            found => found?,
        };
        let proj =
            Proj::from_proj_string(&text).map_err(|error| format!("its reference system cannot be set up: {error}"))?;
        Ok(Self { crs_from_grid: place.crs_from_grid, proj, per_unit })
    }
}

/// Returns whether coordinates in one CRS are valid in the other, within about 2 m.
fn same(a: &Georeference, b: &Georeference) -> bool {
    match (&a.crs, &b.crs) {
        (
            Crs::Geographic { radians_per_unit: unit_a, semi_major_axis_m: axis_a, name: name_a, .. },
            Crs::Geographic { radians_per_unit: unit_b, semi_major_axis_m: axis_b, name: name_b, .. },
        ) => {
            let code = earth_projection::code;
            let is_one_datum = code(name_a).is_some() && code(name_a) == code(name_b);
            let parts = |place: &Georeference| {
                let (text, _) = earth_projection::text(place).ok()?;
                Some((datum_shift(&text), parameter(&text, "pm").unwrap_or("0").to_owned()))
            };
            let is_alike = || match (parts(a), parts(b)) {
                // A datum is not known by its ellipsoid; but that of two files of one product is the same.
                (Some((shift_a, from_a)), Some((shift_b, from_b))) => {
                    let is_shift = shift_a == shift_b && shift_a != DatumShift::Known;
                    is_shift && from_a == from_b && (axis_a - axis_b).abs() < 1.0
                }
                _ => name_a == name_b,
            };
            unit_a == unit_b && (is_one_datum || is_alike())
        }
        (Crs::Projected { name, .. }, Crs::Projected { .. }) => {
            // Files without a code may all be called "unknown".
            let has_parameters = |key: &&GeoKey| (2048..=2061).contains(&key.id) || (3074..=3095).contains(&key.id);
            let count = |place: &Georeference| place.geokeys.keys.iter().filter(has_parameters).count();
            let are_parameters_alike = || {
                let own = a.geokeys.keys.iter().filter(has_parameters);
                count(a) == count(b) && own.into_iter().all(|key| b.geokeys.keys.iter().any(|other| alike(key, other)))
            };
            a.crs == b.crs && (earth_projection::code(name).is_some() || are_parameters_alike())
        }
        (a, b) => a == b,
    }
}

fn has_unknown_datum(place: &Georeference) -> bool {
    earth_projection::text(place).is_ok_and(|(text, _)| datum_shift(&text) == DatumShift::Unknown)
}

/// Returns whether two keys are the same, except for rounding.
fn alike(a: &GeoKey, b: &GeoKey) -> bool {
    match (&a.value, &b.value) {
        (GeoKeyValue::Double(own), GeoKeyValue::Double(other)) => {
            let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * a.abs().max(1.0);
            a.id == b.id && own.len() == other.len() && own.iter().zip(other).all(is_near)
        }
        _ => a == b,
    }
}

/// Returns the geometric mean of the sample spacing along columns and rows in the middle of a grid, in metres.
fn spacing_m(place: &Georeference, size: [u32; 2]) -> Result<f64, String> {
    let mapping = WorldMapping::new(place, size[0], size[1]).map_err(|error| error.to_string())?;
    let middle = size.map(|count| f64::from(count - 1) / 2.0);
    let at = |x: f64, y: f64| mapping.world_from_grid(middle[0] + x, middle[1] + y);
    let spacing_m = (at(0.5, 0.0).distance(at(-0.5, 0.0)) * at(0.0, 0.5).distance(at(0.0, -0.5))).sqrt();
    if spacing_m > 0.0 && spacing_m.is_finite() {
        Ok(spacing_m)
    } else {
        Err("its sample spacing is zero or not finite".into())
    }
}

fn apply([x0, a, b, y0, c, d]: [f64; 6], x: f64, y: f64) -> [f64; 2] {
    [x0 + a * x + b * y, y0 + c * x + d * y]
}

/// Inverts the transform of a georeference, which always has an inverse.
fn inverse([x0, a, b, y0, c, d]: [f64; 6]) -> [f64; 6] {
    let determinant = a * d - b * c;
    let [e, f, g, h] = [d, -b, -c, a].map(|part| part / determinant);
    [-(e * x0 + f * y0), e, f, -(g * x0 + h * y0), g, h]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_shifted_to_their_neighbours_over_the_cut() {
        let ranges = |begins: &[f64]| begins.iter().map(|begin| [*begin, begin + 1.0]).collect::<Vec<_>>();
        assert_eq!(shifts(&ranges(&[179.0, -180.0]), 360.0, 0), [0.0, 360.0]);
        assert_eq!(shifts(&ranges(&[179.0, -180.0]), 360.0, 1), [-360.0, 0.0]);
        assert_eq!(shifts(&ranges(&[8.0, 9.0, 11.0]), 360.0, 0), [0.0; 3], "no shift is needed");
        assert_eq!(shifts(&ranges(&[359.0, 0.0, -2.0]), 360.0, 0), [0.0, 360.0, 360.0], "longitudes from 0 to 360");
        let all: Vec<f64> = (-180..180).map(f64::from).collect();
        assert_eq!(shifts(&ranges(&all), 360.0, 7), [0.0; 360], "a whole earth stays as it is");
        let both = shifts(&ranges(&[-70.0, 100.0, 175.0, -178.0]), 360.0, 1);
        assert_eq!(both, [360.0, 0.0, 0.0, 360.0], "the Atlantic is the widest gap: from -69 to 100");
    }
}
