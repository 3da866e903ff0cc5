//! Pseudo-random numbers that are the same on every machine: SplitMix64 (Steele, Lea, Flood 2014).

use std::f64::consts::TAU;

use glam::DVec3;

/// State of a sequence.
pub(super) struct Random(u64);

impl Random {
    /// Starts a sequence; each seed has its own.
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns a number from 0, inclusive, to 1, exclusive.
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number from `lower`, inclusive, to `upper`, exclusive.
    pub(super) fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }

    /// Returns a uniformly distributed unit vector.
    pub(super) fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = (self.unit() * TAU).sin_cos();
        let level = (1.0 - z * z).sqrt();
        DVec3::new(level * cos, level * sin, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_is_even_and_its_seeds_differ() {
        let mean = |mut of: Box<dyn FnMut() -> f64>| (0..4096).map(|_| of()).sum::<f64>() / 4096.0;
        let (mut a, mut b) = (Random::new(1), Random::new(1));
        assert!((mean(Box::new(move || a.between(2.0, 4.0))) - 3.0).abs() < 0.05);
        // Planted: another range.
        assert!((mean(Box::new(move || b.between(2.0, 4.2))) - 3.0).abs() > 0.05);
        assert_eq!(Random::new(7).unit(), Random::new(7).unit());
        assert!(Random::new(7).unit() != Random::new(8).unit());
        assert!((Random::new(3).direction().length() - 1.0).abs() < 1e-12);
    }
}
