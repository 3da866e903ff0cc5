//! Chooses the tiles of a view: a tile is needed if a pixel that may be on it is not wider than two of its texels. The
//! shader (`shaders/surface/draped_image.wgsl`) never wants a finer one, so what it wants is there.

use glam::{DVec2, DVec3};

use super::{ImageTile, Imagery};
use crate::scene::frustum::{Bounds, Frustum};
use crate::tiles::earth_curvature::EarthCurvature;
use crate::tiles::grid_projection::GridProjection;

/// Step by which a view becomes coarser if its tiles do not fit, in levels.
const BIAS_STEP: f64 = 0.5;

/// What a rig sees.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    /// Origin of the rig in the world, in metres.
    pub origin_m: DVec3,
    /// Position of each eye relative to the origin, in metres, and what it sees.
    pub eyes: Vec<(DVec3, Frustum)>,
    /// Pixels per radian.
    pub focal_px: f64,
    pub earth_curvature: EarthCurvature,
    /// Lowest and highest height of the land, in metres.
    pub range_m: [f64; 2],
    /// Distance between samples of the heights, in metres.
    pub spacing_m: f64,
}

impl PartialEq for Sight {
    fn eq(&self, other: &Self) -> bool {
        self.origin_m == other.origin_m
            && self.eyes == other.eyes
            && self.focal_px == other.focal_px
            && self.earth_curvature == other.earth_curvature
    }
}

/// The tiles of a view.
#[derive(Clone, Debug, Default)]
pub(super) struct Chosen {
    /// The tiles, each after the one above it: coarse levels first, and near tiles of a level first.
    pub tiles: Vec<ImageTile>,
    /// By how many levels the view is coarser, because its tiles would not fit.
    pub bias: f64,
}

impl Imagery {
    /// Returns the tiles that a view needs: at most `most`.
    pub(super) fn choose(&self, sight: &Sight, projection: &GridProjection, most: usize) -> Chosen {
        let mut bias = 0.0;
        loop {
            if let Some(tiles) = self.choose_with(sight, projection, bias, most) {
                return Chosen { tiles, bias };
            }
            bias += BIAS_STEP;
        }
    }

    /// Returns the tiles of a view with a bias, or `None` if they are too many. The highest levels always fit.
    fn choose_with(
        &self,
        sight: &Sight,
        projection: &GridProjection,
        bias: f64,
        most: usize,
    ) -> Option<Vec<ImageTile>> {
        let mut wave = vec![ImageTile { level: self.top, x: 0, y: 0 }];
        let mut chosen = Vec::new();
        while !wave.is_empty() {
            chosen.extend_from_slice(&wave);
            if chosen.len() > most && wave[0].level < self.top {
                return None;
            }
            if wave[0].level == 0 {
                break;
            }
            let mut next: Vec<(f64, ImageTile)> = Vec::new();
            for tile in wave {
                for corner in 0..4 {
                    let child =
                        ImageTile { level: tile.level - 1, x: 2 * tile.x + corner % 2, y: 2 * tile.y + corner / 2 };
                    let Some(away_m) = self.distance_m(sight, projection, child) else { continue };
                    let texel_m = self.texel_samples(child.level) * sight.spacing_m;
                    // Levels are continuous: a pixel needs the level of its footprint and the next coarser one.
                    let wanted = (away_m / sight.focal_px / texel_m).log2() + bias;
                    if wanted < 1.0 {
                        next.push((away_m, child));
                    }
                }
            }
            next.sort_by(|(near, a), (far, b)| near.total_cmp(far).then(a.cmp(b)));
            wave = next.into_iter().map(|(_, tile)| tile).collect();
        }
        Some(chosen)
    }

    /// Returns a lower bound of the distance of a tile that may be in view and has a part of an image, in metres.
    fn distance_m(&self, sight: &Sight, projection: &GridProjection, tile: ImageTile) -> Option<f64> {
        let [first, end] = self.rectangle(tile);
        let is_on_image = |low: DVec2, high: DVec2| first.cmplt(high).all() && end.cmpgt(low).all();
        let last = DVec2::new(f64::from(self.samples[0] - 1), f64::from(self.samples[1] - 1));
        if first.cmpgt(last).any() || !self.images.iter().any(|image| is_on_image(image.low, image.high)) {
            return None;
        }
        let (low, high) = projection.bounds(first.clamp(DVec2::ZERO, last), end.clamp(DVec2::ZERO, last));
        let [low_m, high_m] = sight.range_m;
        let slack_m = 0.1 * (high_m - low_m);
        let flat = Bounds {
            low_m: low.extend(low_m - slack_m) - sight.origin_m,
            high_m: high.extend(high_m + slack_m) - sight.origin_m,
        };
        let bounds = sight.earth_curvature.bend_bounds(&flat)?;
        let is_seen = |(eye_m, frustum): &(DVec3, Frustum)| {
            frustum.may_see(&Bounds { low_m: bounds.low_m - *eye_m, high_m: bounds.high_m - *eye_m })
        };
        sight.eyes.iter().any(is_seen).then(|| bounds.distance_m())
    }
}
