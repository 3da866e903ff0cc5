//! The true occluding contour of the hill in a picture: where neighbouring rays meet surfaces that do not join.

use glam::DVec2;
use rayon::prelude::*;

use super::hill::Hill;
use super::shot::Shot;

/// Which pixels lie at the true contour.
pub struct Silhouette {
    /// The surface ends here, or jumps: by a part of its distance, several pixels' size, and more than four times what
    /// the surface behind goes away per pixel anyway. The pixel is the nearer of the two.
    pub is_contour: Vec<bool>,
    /// The same with every jump, however small, on both sides: interior pixels stay away from these.
    pub may_be_contour: Vec<bool>,
    /// Pixels that are sky in one and surface in the other.
    pub sky_differs: usize,
}

/// A jump that a person would draw: this part of the distance, and this many pixels' size.
const JUMP_PART: f64 = 0.02;
const JUMP_PX: f64 = 8.0;
/// And this many times the way that the surface behind it goes away in a pixel: a contour that begins there has
/// nothing yet to tell it from the surface's own slant.
const JUMP_FLOW: f64 = 4.0;

impl Silhouette {
    /// By rays against the analytic surface; between pixels whose depths are apart, rays are cast in ever narrower
    /// halves: what is joined comes together, what is hidden stays apart.
    pub fn of(hill: &Hill, shot: &Shot, half_m: DVec2) -> Self {
        let from_m = shot.view.pose.position_m;
        let [width, height] = shot.size_px.map(|side| side as usize);
        let at = |place: DVec2| hill.hit(from_m, shot.ray_at(place.x, place.y), half_m);
        let middle = |pixel: usize| DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
        let depth: Vec<Option<f64>> = (0..width * height).into_par_iter().map(|pixel| at(middle(pixel))).collect();
        // The jump between two pixels; infinite towards the sky, 0 where the surface is joined.
        let jump = |a: usize, b: usize| -> f64 {
            let (mut low, mut high) = ((middle(a), depth[a]), (middle(b), depth[b]));
            let apart = |a: Option<f64>, b: Option<f64>| match (a, b) {
                (Some(a), Some(b)) => (a - b).abs(),
                (None, None) => 0.0,
                _ => f64::INFINITY,
            };
            let first = apart(low.1, high.1);
            if first.is_infinite() || first < 0.002 * depth[a].unwrap_or(0.0) {
                return if first.is_infinite() { first } else { 0.0 };
            }
            for _ in 0..20 {
                let place = 0.5 * (low.0 + high.0);
                let depth = at(place);
                if apart(low.1, depth) > apart(depth, high.1) { high = (place, depth) } else { low = (place, depth) }
            }
            let left = apart(low.1, high.1);
            if left > 0.2 * first { left } else { 0.0 }
        };
        let jumps: Vec<[f64; 2]> = (0..width * height)
            .into_par_iter()
            .map(|pixel| {
                let right = if pixel % width + 1 < width { jump(pixel, pixel + 1) } else { 0.0 };
                let below = if pixel / width + 1 < height { jump(pixel, pixel + width) } else { 0.0 };
                [right, below]
            })
            .collect();
        let mut found = Self {
            is_contour: vec![false; width * height],
            may_be_contour: vec![false; width * height],
            sky_differs: 0,
        };
        for pixel in 0..width * height {
            found.sky_differs += usize::from(shot.is_sky(pixel) != depth[pixel].is_none());
            for (jump, other) in jumps[pixel].into_iter().zip([pixel + 1, pixel + width]) {
                if jump > 0.0 {
                    found.may_be_contour[pixel] = true;
                    found.may_be_contour[other] = true;
                    let far = |pixel: usize| depth[pixel].unwrap_or(f64::INFINITY);
                    let nearer = if far(pixel) < far(other) { pixel } else { other };
                    let distance = far(nearer);
                    let behind = if nearer == pixel { other } else { pixel };
                    let beyond =
                        (2 * behind).checked_sub(nearer).and_then(|beyond| depth.get(beyond).copied().flatten());
                    let flows = beyond.map_or(0.0, |beyond| (beyond - far(behind)).abs());
                    let least = (JUMP_PART * distance).max(JUMP_PX * distance / shot.focal_px());
                    if jump > least.max(JUMP_FLOW * flows) {
                        found.is_contour[nearer] = true;
                    }
                }
            }
        }
        found
    }
}
