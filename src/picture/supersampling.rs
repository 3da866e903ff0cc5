//! Positions of the samples within a pixel, for pictures whose pixels are the mean of several samples.
//!
//! The points of Halton's sequence (bases 2 and 3) fill a pixel evenly for any number of samples. Each sample is a
//! complete frame whose content is moved by a fraction of a pixel. Strokes, whose coverage is exact, are not moved.

use glam::DVec2;

/// Returns the offset of the content of each of `samples` frames, in pixels, from −0.5 to 0.5 on each axis. A single
/// frame is not moved.
pub(crate) fn jitters_px(samples: u32) -> Vec<DVec2> {
    if samples <= 1 {
        return vec![DVec2::ZERO];
    }
    (1..=samples).map(jitter_px).collect()
}

/// Returns the offset of a frame, in pixels; frames are numbered from 1.
pub(crate) fn jitter_px(number: u32) -> DVec2 {
    DVec2::new(halton(number, 2), halton(number, 3)) - 0.5
}

/// Returns the offset and the weight of each frame of a picture. AOV channels are read from the first frame, which is
/// not moved if there are any.
pub(crate) fn samples(samples: u32, has_planes: bool) -> Vec<(DVec2, f32)> {
    let first = (has_planes && samples > 1).then_some((DVec2::ZERO, 0.0));
    let weight = 1.0 / samples.max(1) as f32;
    first.into_iter().chain(jitters_px(samples).into_iter().map(|jitter_px| (jitter_px, weight))).collect()
}

/// Returns an element of Halton's sequence: the digits of the number, mirrored at the radix point.
fn halton(mut number: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(number % base);
        number /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_come_from_a_frame_that_is_not_moved() {
        for (count, has_planes) in [(1, true), (1, false), (8, true), (8, false)] {
            let samples = samples(count, has_planes);
            assert!(!has_planes || samples[0].0 == DVec2::ZERO);
            assert!((samples.iter().map(|(_, weight)| weight).sum::<f32>() - 1.0).abs() < 1e-6);
            let frames = count as usize + usize::from(count > 1 && has_planes);
            assert_eq!(samples.len(), frames);
        }
    }

    #[test]
    fn samples_fill_the_pixel_evenly() {
        assert_eq!(jitters_px(1), [DVec2::ZERO]);
        assert_eq!([1, 2, 3, 4].map(|number| halton(number, 2)), [0.5, 0.25, 0.75, 0.125]);
        assert!((halton(5, 3) - 7.0 / 9.0).abs() < 1e-12);
        for samples in [8, 16, 64] {
            let jitters_px = jitters_px(samples);
            assert_eq!(jitters_px.len(), samples as usize);
            assert!(jitters_px.iter().all(|jitter| jitter.abs().max_element() <= 0.5));
            let mean = jitters_px.iter().sum::<DVec2>() / f64::from(samples);
            assert!(mean.length() < 1.0 / f64::from(samples).sqrt() / 4.0, "{samples}: {mean}");
            // A quarter of the pixel has a quarter of the samples, nearly.
            let quarter = jitters_px.iter().filter(|jitter| jitter.x < 0.0 && jitter.y < 0.0).count() as f64;
            assert!((quarter / f64::from(samples) - 0.25).abs() <= 0.13, "{samples}: {quarter}");
        }
    }
}
