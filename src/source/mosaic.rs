//! Combines several DEMs into one grid, for baking them into one pyramid.
//!
//! The lattice is that of the finest member, extended to the union of all. Members whose samples are on that lattice
//! are copied bit for bit. Other members are resampled: bicubic in general, bilinear next to no-data samples, and NaN
//! where even that would need a no-data sample. Resampling extends half a sample spacing beyond the outermost samples,
//! which closes the seam between adjacent members. Where members overlap, the finer one takes precedence, then the one
//! named first; a no-data sample shows the next member.

mod agreement;
mod choice;
mod members;
mod place;
mod turns;
mod sample_transform;

pub(crate) use choice::Choice;
pub(crate) use members::member_options;
pub(crate) use place::{Misfit, MosaicGrid, Placed};
pub(crate) use sample_transform::SampleTransform;

use std::path::Path;

use super::georeference::Georeference;
use super::{HeightReader, SourceError, Window, memory};

/// Several readers combined into one.
pub(crate) struct MosaicReader {
    grid: MosaicGrid,
    members: Vec<Box<dyn HeightReader>>,
    /// Indices of the members, highest precedence first.
    precedence: Vec<usize>,
}

impl MosaicReader {
    /// Combines `members`; an error names the member that does not fit.
    ///
    /// # Errors
    /// Returns [`SourceError::Mosaic`] if there is no member, if no transformation between the reference systems is
    /// known, or if the extent is not a valid grid.
    pub(crate) fn new(members: Vec<Box<dyn HeightReader>>) -> Result<Self, SourceError> {
        let places: Vec<_> = members.iter().map(|member| (member.georeference(), member.size())).collect();
        let grid = MosaicGrid::new(&places).map_err(|Misfit { member, cause }| {
            let identity = members.get(member).map_or(String::new(), |member| member.identity());
            SourceError::Mosaic { path: name_of(&identity).into(), cause }
        })?;
        grid.warn();
        let precedence = precedence(&grid);
        Ok(Self { grid, members, precedence })
    }
}

/// Returns the members' indices, finest first, then in the given order.
pub(crate) fn precedence(grid: &MosaicGrid) -> Vec<usize> {
    by_fineness(&grid.members.iter().map(|member| member.ratio).collect::<Vec<_>>())
}

/// Returns the indices of spacings from the finest on. Those within one per cent of the finest of a group count as equal
/// and keep their order, because tiles of the same product at two latitudes differ by so much.
fn by_fineness(spacings: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..spacings.len()).collect();
    order.sort_by(|&a, &b| spacings[a].total_cmp(&spacings[b]));
    let mut first = 0;
    while first < order.len() {
        let limit = spacings[order[first]] * 1.01;
        let count = order[first..].iter().take_while(|&&index| spacings[index] <= limit).count().max(1);
        order[first..first + count].sort_unstable();
        first += count;
    }
    order
}

impl HeightReader for MosaicReader {
    fn size(&self) -> [u32; 2] {
        self.grid.size
    }

    fn georeference(&self) -> &Georeference {
        &self.grid.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut heights_m = memory::window_room(Path::new("a mosaic"), window)?;
        heights_m.resize(window.samples(), f32::NAN);
        for &index in &self.precedence {
            let placed = &self.grid.members[index];
            if placed.meets(window) && heights_m.iter().any(|height| height.is_nan()) {
                match placed.shift() {
                    Some(shift) => copy(&*self.members[index], shift, window, &mut heights_m)?,
                    None => resample(&*self.members[index], placed, window, &mut heights_m)?,
                }
            }
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        let first = self.precedence.first().map_or([256, 256], |&index| self.members[index].block());
        first.map(|side| side.clamp(16, 4096))
    }

    fn warnings(&self) -> Vec<String> {
        let of = |member: &dyn HeightReader| {
            let identity = member.identity();
            let name = name_of(&identity).to_owned();
            member.warnings().into_iter().map(move |warning| format!("{name}: {warning}"))
        };
        self.members.iter().flat_map(|member| of(&**member)).collect()
    }

    fn identity(&self) -> String {
        let names: Vec<String> = self.members.iter().map(|member| member.identity()).collect();
        format!("mosaic\n{}", names.join("\n"))
    }
}

/// Returns the name of a file from its reader's identity, which begins with it; its size and time follow after tabs.
fn name_of(identity: &str) -> &str {
    identity.split(['\t', '\n']).next().unwrap_or_default()
}

/// Copies the samples of a member on the lattice to all places that have no height yet.
fn copy(member: &dyn HeightReader, shift: [i64; 2], window: Window, heights_m: &mut [f32]) -> Result<(), SourceError> {
    let size = member.size();
    let (x, y) = (i64::from(window.x) - shift[0], i64::from(window.y) - shift[1]);
    let (left, right) = (x.max(0), (x + i64::from(window.width)).min(size[0].into()));
    let (top, bottom) = (y.max(0), (y + i64::from(window.height)).min(size[1].into()));
    if left >= right || top >= bottom {
        return Ok(());
    }
    let part = Window { x: left as u32, y: top as u32, width: (right - left) as u32, height: (bottom - top) as u32 };
    let read_m = member.read(part)?;
    for (row, read_m) in read_m.chunks_exact(part.width as usize).enumerate() {
        let start = (top - y) as usize + row;
        let start = start * window.width as usize + (left - x) as usize;
        for (height, &read) in heights_m[start..start + read_m.len()].iter_mut().zip(read_m) {
            if height.is_nan() {
                *height = read;
            }
        }
    }
    Ok(())
}

/// Resamples a member with another lattice at all places that have no height yet.
fn resample(
    member: &dyn HeightReader,
    placed: &Placed,
    window: Window,
    heights_m: &mut [f32],
) -> Result<(), SourceError> {
    let first = [window.x, window.y].map(f64::from);
    let places = placed.coordinates(first, [1.0, 1.0], [window.width, window.height]);
    let size = member.size();
    let inside = |place: &[f64; 2]| (0..2).all(|axis| (-0.5..f64::from(size[axis]) - 0.5).contains(&place[axis]));
    let wanted = || places.iter().zip(&*heights_m).filter(|(place, height)| height.is_nan() && inside(place));
    let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
    for (place, _) in wanted() {
        for axis in 0..2 {
            let cell = (place[axis].floor().max(0.0) as u32).min(size[axis] - 2);
            low[axis] = low[axis].min(cell.saturating_sub(1));
            high[axis] = high[axis].max((cell + 3).min(size[axis]));
        }
    }
    if low[0] >= high[0] || low[1] >= high[1] {
        return Ok(());
    }
    let part = Window { x: low[0], y: low[1], width: high[0] - low[0], height: high[1] - low[1] };
    let read_m = member.read(part)?;
    for (height, place) in heights_m.iter_mut().zip(&places) {
        if height.is_nan() && inside(place) {
            *height = between(&read_m, part, size, *place);
        }
    }
    Ok(())
}

/// Returns the height at a position between samples, or NaN.
fn between(read_m: &[f32], part: Window, size: [u32; 2], [x, y]: [f64; 2]) -> f32 {
    // Catmull-Rom weights, the same as in `pyramid::surface::bicubic`.
    let weights = |t: f64| {
        [
            ((-0.5 * t + 1.0) * t - 0.5) * t,
            (1.5 * t - 2.5) * t * t + 1.0,
            ((-1.5 * t + 2.0) * t + 0.5) * t,
            (0.5 * t - 0.5) * t * t,
        ]
    };
    let cell = |c: f64, count: u32| (c.floor().max(0.0) as u32).min(count - 2);
    let (column, row) = (cell(x, size[0]), cell(y, size[1]));
    let (u, v) = (x - f64::from(column), y - f64::from(row));
    let at = |column: u32, row: u32| f64::from(read_m[((row - part.y) * part.width + column - part.x) as usize]);
    // Beyond the outermost samples the height is extrapolated linearly.
    let four_of = |first: u32, count: u32, of: &dyn Fn(u32) -> f64| {
        let (near, far) = (of(first), of(first + 1));
        let before = if first > 0 { of(first - 1) } else { 2.0 * near - far };
        let after = if first + 2 < count { of(first + 2) } else { 2.0 * far - near };
        [before, near, far, after]
    };
    let line = |row: u32| four_of(column, size[0], &|column| at(column, row));
    let mut four = [[0.0; 4]; 4];
    for i in 0..4 {
        let down = four_of(row, size[1], &|row| line(row)[i]);
        for (line, height) in four.iter_mut().zip(down) {
            line[i] = height;
        }
    }
    let lines = four.iter().zip(weights(v)).map(|(line, weight)| {
        weight * line.iter().zip(weights(u)).map(|(height, weight)| height * weight).sum::<f64>()
    });
    let cubic: f64 = lines.sum();
    if !cubic.is_nan() {
        return cubic as f32;
    }
    let across = |line: &[f64; 4]| line[1] * (1.0 - u) + line[2] * u;
    (across(&four[1]) * (1.0 - v) + across(&four[2]) * v) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::georeference::Crs;
    use crate::source::{GeoKeys, GridReader, HeightGrid};

    #[test]
    fn spacings_within_one_per_cent_are_equal() {
        assert_eq!(by_fineness(&[1.0, 0.995, 1.004, 2.0, 0.5]), [4, 0, 1, 2, 3]);
        // On both sides of a border between rounded logarithms.
        assert_eq!(by_fineness(&[1.0051, 1.0049]), [0, 1]);
        assert_eq!(by_fineness(&[1.0149, 1.0051]), [0, 1]);
        assert_eq!(by_fineness(&[1.011, 1.0]), [1, 0]);
        assert_eq!(by_fineness(&[f64::NAN, 1.0]), [1, 0]);
        assert_eq!(by_fineness(&[]), [0_usize; 0]);
    }

    /// A grid that warns.
    struct Warning(GridReader<HeightGrid>);

    impl HeightReader for Warning {
        fn size(&self) -> [u32; 2] {
            self.0.size()
        }

        fn georeference(&self) -> &Georeference {
            self.0.georeference()
        }

        fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
            self.0.read(window)
        }

        fn block(&self) -> [u32; 2] {
            self.0.block()
        }

        fn warnings(&self) -> Vec<String> {
            vec!["is odd".to_owned(), "is old".to_owned()]
        }

        fn identity(&self) -> String {
            self.0.identity()
        }
    }

    #[test]
    fn warnings_of_members_have_their_names() {
        let member = |name: &str| {
            let crs_from_grid = [0.0, 30.0, 0.0, 0.0, 0.0, -30.0];
            let georeference = Georeference { crs_from_grid, crs: Crs::Local, geokeys: GeoKeys::default() };
            let grid = HeightGrid { width: 4, height: 4, heights_m: vec![1.0; 16], georeference };
            Box::new(Warning(GridReader::new(grid, format!("{name}\t12\t34\n")))) as Box<dyn HeightReader>
        };
        let mosaic = MosaicReader::new(vec![member("d/a.bil"), member("b.bil")]).unwrap();
        let expected = ["d/a.bil: is odd", "d/a.bil: is old", "b.bil: is odd", "b.bil: is old"];
        assert_eq!(mosaic.warnings(), expected);
    }
}
