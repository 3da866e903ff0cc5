//! The Pareto front of measured settings: a setting is on it unless another one is better in some respect and at least
//! as good in all others.

/// A measured value counts as better than another one only if it is smaller by more than this share.
pub(crate) const NOISE: f64 = 0.01;

/// Returns for each point whether it is on the front. The values of a point are costs and errors, of which less is
/// better; each point has as many values as `least`, the smallest differences that count. A point with a value that was
/// not measured is not on the front.
pub(crate) fn on_front(points: &[Vec<Option<f64>>], least: &[f64]) -> Vec<bool> {
    let known: Vec<Option<Vec<f64>>> = points.iter().map(|point| point.iter().copied().collect()).collect();
    let is_best = |point: &Vec<f64>| !known.iter().flatten().any(|other| dominates(other, point, least));
    known.iter().map(|point| point.as_ref().is_some_and(is_best)).collect()
}

/// Returns whether a point is better than another one in some respect, and not worse in any.
fn dominates(point: &[f64], other: &[f64], least: &[f64]) -> bool {
    let signs = || {
        point.iter().zip(other).zip(least).map(|((a, b), least)| {
            let needed = (NOISE * a.abs().max(b.abs())).max(*least);
            i32::from(a - b > needed) - i32::from(b - a > needed)
        })
    };
    signs().all(|sign| sign <= 0) && signs().any(|sign| sign < 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn front(points: &[[f64; 2]]) -> Vec<bool> {
        on_front(&points.iter().map(|point| point.map(Some).to_vec()).collect::<Vec<_>>(), &[0.0, 0.5])
    }

    #[test]
    fn a_dominated_point_is_not_on_the_front() {
        // Cheap and coarse, between, dear and exact; and a planted one that costs more than the second for a larger error.
        let points = [[1.0, 9.0], [4.0, 3.0], [16.0, 1.0], [5.0, 4.0]];
        assert_eq!(front(&points), [true, true, true, false]);
        // As exact as the first, but dearer.
        assert_eq!(front(&[[1.0, 9.0], [2.0, 9.0]]), [true, false]);
        // Two that differ by noise are both on it.
        assert_eq!(front(&[[1.0, 9.0], [1.005, 9.0]]), [true, true]);
        // An improvement of an error by less than what counts does not justify twice the cost.
        assert_eq!(front(&[[1.0, 9.0], [2.0, 8.6]]), [true, false]);
        assert_eq!(front(&[]), Vec::<bool>::new());
    }

    #[test]
    fn what_was_not_measured_is_not_on_the_front() {
        let points = [vec![Some(1.0), None], vec![Some(2.0), Some(1.0)]];
        assert_eq!(on_front(&points, &[0.0, 0.0]), [false, true]);
    }
}
