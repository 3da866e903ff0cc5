//! Stand-in.
use super::StyleError;
use std::path::Path;
/// Stand-in.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    pub spacing_px: f32,
    pub width_px: f32,
    pub length_px: f32,
}
impl Recipe {
    /// Stand-in.
    pub fn load(name: &str, _: &Path) -> Result<Self, StyleError> {
        Ok(Self {
            spacing_px: 8.0,
            width_px: 1.6,
            length_px: if name == "dash" {
                24.0
            } else if name == "stipple" {
                1.8
            } else {
                0.0
            },
        })
    }
}
