//! Pseudo-random numbers that are the same on every machine.

use crate::lines::strokes::texture::field::hash;

/// A sequence of numbers for a seed and a stream.
pub(super) struct Chance {
    stream: u32,
    drawn: u32,
}

impl Chance {
    pub(super) fn new(seed: u32, stream: u32) -> Self {
        let [x, y] = hash([seed, stream]);
        Self { stream: x ^ y.rotate_left(16), drawn: 0 }
    }

    /// Returns a number from 0 to 1, without 1.
    pub(super) fn part(&mut self) -> f32 {
        self.drawn = self.drawn.wrapping_add(1);
        let [x, y] = hash([self.drawn, self.stream]);
        ((x ^ y) >> 8) as f32 / 16_777_216.0
    }

    /// Returns a number from −1 to 1.
    pub(super) fn signed(&mut self) -> f32 {
        2.0 * self.part() - 1.0
    }

    /// Returns a number from −1 to 1 that is mostly small: the mean of three.
    pub(super) fn gentle(&mut self) -> f32 {
        (self.signed() + self.signed() + self.signed()) / 3.0
    }
}
