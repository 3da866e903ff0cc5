//! Panoramas for tests.

use super::Random;
use super::panorama::{Label, Rows};

/// Returns rows of a picture.
pub(super) fn rows(count: usize, width_px: f64) -> Rows {
    let tops_px = (0..count).map(|row| 10.0 + 20.0 * row as f64).collect();
    Rows { tops_px, width_px, margin_px: 5.0, gap_px: 6.0, leader_gap_px: 3.0, align: 0.5 }
}

/// Returns labels at random positions, with weights of similar size.
pub(super) fn scattered(count: usize, width_px: f64, seed: u64) -> Vec<Label> {
    let mut random = Random(seed);
    let mut label = |_| {
        let x_px = 10.0 + random.unit() * (width_px - 20.0);
        let width_px = 40.0 + 80.0 * random.unit();
        let weight = 1.0 + 4.0 * random.unit();
        Label { x_px: [x_px; 2], y_px: 300.0, width_px, height_px: 14.0, weight }
    };
    (0..count).map(&mut label).collect()
}

/// Returns labels as a mountain range has them: summits in groups, and weights as prominences are distributed, a few
/// large ones among many small ones.
pub(super) fn mountains(count: usize, width_px: f64, seed: u64) -> Vec<Label> {
    let mut random = Random(seed ^ 0x5eed);
    let groups: Vec<f64> = (0..count / 6 + 1).map(|_| random.unit() * width_px).collect();
    let mut label = |_| {
        let group = groups[random.below(groups.len())];
        let spread = (random.unit() + random.unit() + random.unit() - 1.5) * 0.08 * width_px;
        let x_px = (group + spread).clamp(2.0, width_px - 2.0);
        let letters = 4.0 + (random.unit() * 14.0).floor();
        let weight = 100.0 / (0.04 + random.unit()).powf(1.2);
        Label { x_px: [x_px; 2], y_px: 300.0, width_px: 7.0 * letters, height_px: 14.0, weight }
    };
    (0..count).map(&mut label).collect()
}

/// Returns the same labels for a stereo pair: summits are up to `most_px` further left in the right picture.
pub(super) fn paired(labels: &[Label], most_px: f64, seed: u64) -> Vec<Label> {
    let mut random = Random(seed);
    let mut pair = |label: &Label| {
        let half = 0.5 * most_px * random.unit();
        Label { x_px: [label.x_px[0] + half, label.x_px[0] - half], ..*label }
    };
    labels.iter().map(&mut pair).collect()
}
