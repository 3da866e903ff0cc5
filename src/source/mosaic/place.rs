//! Combines the grids of several DEMs: the common lattice, its extent, and the transformation from it to each member's
//! own grid.

use super::super::georeference::{Crs, Georeference};
use super::super::{Window, WorldMapping};
use super::sample_transform::{ALIGNED_SAMPLES, GridCrs, NO_CRS, SampleTransform, has_unknown_datum, middle_x, same};
use super::turns::turned;

/// Spacing of the exact nodes of a reprojection in samples; between them it is interpolated bilinearly.
const NODES_APART: u32 = 16;

pub(super) const TOO_FAR: &str = "is too far from the other files to form one grid with them";

/// Largest number of samples on a side of a mosaic.
const LARGEST_SIDE: f64 = (1 << 24) as f64;

/// Share of a grid below which a warning says that its members cover little of it.
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
    /// Sample spacing in metres.
    pub spacing_m: f64,
    /// West, north, east and south of the member's outermost samples, in samples of the grid.
    pub extent: [f64; 4],
    way: SampleTransform,
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
            GridCrs::new(members[first].0).map_err(of(first))?;
            GridCrs::new(place).map_err(of(other))?;
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
        let mut extents = Vec::with_capacity(members.len());
        for (member, ((place, size), turned)) in members.iter().zip(&turned).enumerate() {
            let back = SampleTransform::between(place, lattice, Some(turned.middle)).map_err(of(member))?;
            let steps = 16;
            let mut extent = NOWHERE;
            for i in 0..=steps {
                let at = |count: u32| f64::from(count - 1) * f64::from(i) / f64::from(steps);
                let (x, y, right, bottom) = (at(size[0]), at(size[1]), f64::from(size[0] - 1), f64::from(size[1] - 1));
                for (column, row) in [(x, 0.0), (x, bottom), (0.0, y), (right, y)] {
                    let [x, y] = back.map(column, row);
                    if !(x.abs() < LARGEST_SIDE && y.abs() < LARGEST_SIDE) {
                        return Err(of(member)(TOO_FAR.into()));
                    }
                    extent = union(extent, [x, y, x, y]);
                }
            }
            bounds = union(bounds, extent);
            extents.push(extent);
        }
        let first = [bounds[0], bounds[1]].map(|c| (c + ALIGNED_SAMPLES).floor());
        let last = [bounds[2], bounds[3]].map(|c| (c - ALIGNED_SAMPLES).ceil());
        let [x0, a, b, y0, c, d] = lattice.crs_from_grid;
        let crs_from_grid = [x0 + a * first[0] + b * first[1], a, b, y0 + c * first[0] + d * first[1], c, d];
        let georeference = Georeference { crs_from_grid, ..lattice.clone() };
        let size = [0, 1].map(|axis| (last[axis] - first[axis]) as u32 + 1);
        let placed = members.iter().zip(spacings_m).zip(extents).enumerate();
        let placed = placed.map(|(member, (((place, size), spacing_m), [west, north, east, south]))| {
            let way =
                SampleTransform::between(&georeference, place, Some(middle_x(place, *size))).map_err(of(member))?;
            let extent = [west - first[0], north - first[1], east - first[0], south - first[1]];
            Ok(Placed { size: *size, ratio: (spacing_m / finest_m).max(1.0), spacing_m, extent, way })
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

impl Placed {
    /// Returns the position of the member's sample (0, 0) in the grid, if its samples coincide with the grid's.
    pub(crate) fn shift(&self) -> Option<[i64; 2]> {
        match self.way {
            SampleTransform::Shift(shift) => Some(shift),
            _ => None,
        }
    }

    /// Returns (column, row) in the member for `columns` × `rows` points of the grid, row by row. The first point is at
    /// `first`, and they are `step` apart, in samples of the grid. Points that a projection cannot represent are NaN.
    pub(crate) fn coordinates(&self, first: [f64; 2], step: [f64; 2], [columns, rows]: [u32; 2]) -> Vec<[f64; 2]> {
        let at = |column: u32, row: u32| {
            self.way.map(first[0] + step[0] * f64::from(column), first[1] + step[1] * f64::from(row))
        };
        if !matches!(self.way, SampleTransform::Projected { .. }) {
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
                // Part of the window is beyond the projection; these places do not show what the rest of it covers.
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

/// An extent without a place.
const NOWHERE: [f64; 4] = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

/// Returns the extent that has both others.
fn union(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
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
