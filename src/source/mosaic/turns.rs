//! Whole turns of longitude between the members of a mosaic: two neighbours at 180° are neighbours.

use super::super::earth_projection;
use super::super::georeference::Georeference;
use super::place::{Misfit, TOO_FAR};
use super::sample_transform::{SampleTransform, middle_x, same};

/// A member whose longitudes, or eastings of a cylindrical projection, are shifted by whole turns.
pub(super) struct ShiftedMember {
    pub place: Georeference,
    /// The middle of its extent, as coordinate x of the lattice's CRS.
    pub middle: f64,
}

/// Shifts members by whole turns of longitude so that the world is cut where the widest gap between them is: two
/// neighbours at 180° are neighbours. The member `first`, whose lattice is that of the world, is not shifted.
///
/// # Errors
/// The same as [`SampleTransform::between`].
pub(super) fn turned(members: &[(&Georeference, [u32; 2])], first: usize) -> Result<Vec<ShiftedMember>, Misfit> {
    let lattice = members[first].0;
    let unmoved = |(place, size): &(&Georeference, [u32; 2])| ShiftedMember {
        place: (*place).clone(),
        middle: middle_x(place, *size),
    };
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
        ShiftedMember { place, middle: 0.5 * (low + high) + shift }
    });
    Ok(turned.collect())
}

/// Returns the smallest and the largest coordinate x of a member in the CRS of the lattice.
fn range_x(place: &Georeference, size: [u32; 2], lattice: &Georeference, turn: f64) -> Result<[f64; 2], String> {
    let unit = Georeference { crs_from_grid: [0.0, 1.0, 0.0, 0.0, 0.0, 1.0], ..lattice.clone() };
    let middle = size.map(|count| f64::from(count - 1) / 2.0);
    let centre = SampleTransform::between(place, &unit, None)?.map(middle[0], middle[1])[0];
    // Every part of a member is within half a turn of its middle.
    let way = SampleTransform::between(place, &unit, Some(centre))?;
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
