//! Pictures of the tones of a tonal art map.

use hachure::tones::tonal_art_map::TonalArtMap;

/// Returns which texels are ink at a darkness.
pub fn tone(map: &TonalArtMap, darkness: f32) -> Vec<bool> {
    (0..map.thresholds.len()).map(|place| map.is_ink(place, darkness)).collect()
}

/// Returns whether every picture contains all marks of the lighter ones.
pub fn are_nested(tones: &[Vec<bool>]) -> bool {
    tones.windows(2).all(|pair| pair[0].iter().zip(&pair[1]).all(|(lighter, darker)| !lighter || *darker))
}

/// Returns the largest difference between the mean of a tone and the requested darkness.
pub fn mean_error(map: &TonalArtMap) -> f64 {
    let error = |i: u32| {
        let darkness = f64::from(i) / 20.0;
        let ink = tone(map, darkness as f32).into_iter().filter(|ink| *ink).count();
        (ink as f64 / map.thresholds.len() as f64 - darkness).abs()
    };
    (1..20).map(error).fold(0.0, f64::max)
}
