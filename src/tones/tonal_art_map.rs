//! Stand-in.
use crate::style::StyleError;
use crate::style::marks::Recipe;
/// Stand-in.
pub struct TonalArtMap {
    pub side_px: u32,
    pub thresholds: Vec<u8>,
}
impl TonalArtMap {
    /// Stand-in.
    pub fn cached(_: &Recipe) -> Result<Self, StyleError> {
        let thresholds = (0..512u32 * 512)
            .map(|i| {
                let (x, y) = (i % 512, i / 512);
                let row = y / 8;
                let across = ((y % 8) as f32 - 3.5).abs() / 4.0;
                let rank = (row.reverse_bits() >> 26) as f32 / 64.0;
                let along = (((x + row * 131) % 512) as f32 / 512.0 * std::f32::consts::TAU * 4.0).sin() * 0.06;
                ((0.72 * across + 0.22 * rank + 0.06 * (along + 0.06) * 8.0).clamp(0.0, 0.999) * 256.0) as u8
            })
            .collect();
        Ok(Self { side_px: 512, thresholds })
    }
}
