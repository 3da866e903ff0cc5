//! Colours as people write them: `"#1b1a17"`, in sRGB.

use serde::{Deserialize, Deserializer, de::Error};

use crate::file::message::quoted;

/// An sRGB colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Color([u8; 3]);

impl Color {
    pub(crate) const WHITE: Self = Self([255; 3]);
    /// The colour of paths on maps, which differs from the inks of the land.
    pub(crate) const VERMILION: Self = Self([0xb8, 0x2b, 0x1e]);

    /// Returns red, green and blue in linear light, 0 to 1, as the shaders use them.
    pub(crate) fn linear(self) -> [f32; 3] {
        self.srgb().map(linear_from_srgb)
    }

    /// Builds a colour from sRGB channels, 0 to 1; values outside this range are clamped.
    pub fn from_srgb(channels: [f32; 3]) -> Self {
        Self(channels.map(|value| (255.0 * value.clamp(0.0, 1.0)).round() as u8))
    }

    /// Returns the sRGB channels, 0 to 1.
    pub fn srgb(self) -> [f32; 3] {
        self.0.map(|value| f32::from(value) / 255.0)
    }
}

/// Converts one sRGB channel, 0 to 1, to linear light.
pub(crate) fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Converts one channel in linear light to sRGB, 0 to 1; values outside this range are clamped.
pub(crate) fn srgb_from_linear(value: f32) -> f32 {
    let value = value.clamp(0.0, 1.0);
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

impl std::fmt::Display for Color {
    /// Writes `#rrggbb`, the form that [`FromStr`](std::str::FromStr) reads.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [red, green, blue] = self.0;
        write!(formatter, "#{red:02x}{green:02x}{blue:02x}")
    }
}

impl std::str::FromStr for Color {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let bad = || format!("{} is not a colour of the form \"#1b1a17\"", quoted(text));
        let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii()).ok_or_else(bad)?;
        let byte = |i: usize| u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).map_err(|_| bad());
        Ok(Self([byte(0)?, byte(1)?, byte(2)?]))
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_are_inverse() {
        for value in (0..=255).map(|byte| f32::from(byte as u8) / 255.0) {
            assert!((srgb_from_linear(linear_from_srgb(value)) - value).abs() < 1e-5, "{value}");
        }
        assert_eq!((srgb_from_linear(-1.0), srgb_from_linear(2.0)), (0.0, srgb_from_linear(1.0)));
        assert!((srgb_from_linear(0.5) - 0.735_357).abs() < 1e-5);
    }
}
