//! The true silhouette of the hill in a picture: where neighbouring rays hit surfaces that are not connected.

use glam::DVec2;
use rayon::prelude::*;

use super::hill::Hill;
use super::shot::Shot;

/// The pixels at the true silhouette.
pub(crate) struct Silhouette {
    /// Pixels where the surface ends, or where depth jumps: by a fraction of the distance, by the size of several
    /// pixels, and by more than four times the depth step per pixel of the surface behind. The pixel is the nearer of
    /// the two.
    pub is_contour: Vec<bool>,
    /// Pixels at any jump, however small, on both sides of it; interior pixels must be away from these.
    pub may_be_contour: Vec<bool>,
    /// The number of pixels that are sky in one and surface in the other.
    pub sky_differs: usize,
}

/// The least jump that a person would draw: this fraction of the distance, and the size of this many pixels.
const JUMP_PART: f64 = 0.02;
const JUMP_PX: f64 = 8.0;
/// The least jump in multiples of the depth step per pixel of the surface behind: where a silhouette begins, it cannot
/// be distinguished yet from the surface's own slant.
const JUMP_FLOW: f64 = 4.0;

impl Silhouette {
    /// Finds the silhouette with rays against the analytic surface. Between pixels with different depths, bisection
    /// casts further rays: on connected surfaces the depths converge, at a silhouette they stay apart.
    pub(crate) fn of(hill: &Hill, shot: &Shot, half_m: DVec2) -> Self {
        let from_m = shot.view.pose.position_m;
        let [width, height] = shot.size_px.map(|side| side as usize);
        let at = |place: DVec2| hill.hit(from_m, shot.ray_at(place.x, place.y), half_m);
        let middle = |pixel: usize| DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
        let depth: Vec<Option<f64>> = (0..width * height).into_par_iter().map(|pixel| at(middle(pixel))).collect();
        // The jump between two pixels: infinite toward the sky, 0 where the surface is connected.
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
