//! Pen strokes of a style.

use serde::Deserialize;

use super::{Color, one, texture, within, yes};

/// Strokes of a style.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Strokes {
    /// Their colour.
    #[serde(default)]
    pub ink: Color,
    /// Their width in pixels.
    pub width_px: f32,
    /// What they are drawn with: one of [`texture::names`], or a file beside the style's (`.toml`). None is solid.
    #[serde(rename = "texture")]
    pub texture_name: Option<String>,
    /// What `texture_name` means.
    #[serde(skip)]
    pub texture: Option<texture::Recipe>,
    /// Over so many pixels they thin out at their ends.
    #[serde(default)]
    pub taper_px: f32,
    /// How much wider strokes are at bends, -1 to 1: 1 is twice the width at a right angle, below 0 they are thinner.
    #[serde(default)]
    pub curve_width: f32,
    /// How far the hand strays from the line, in pixels. What it does at a place of the world it does again.
    #[serde(default)]
    pub wobble_px: f32,
    /// Shorter strokes are left out: specks.
    #[serde(default = "four")]
    pub shortest_px: f32,
    /// How much wider near strokes are than far ones, 0 to 1.
    #[serde(default)]
    pub depth_width: f32,
    /// Pixels of the reference image per pixel of the picture, 1/4 to 1: what is seen of an edge is found at this scale.
    #[serde(default = "one")]
    pub resolution: f32,
    /// Ends this near in pixels may be joined.
    #[serde(default = "four")]
    pub join_px: f32,
    /// And those that turn by this angle at most, in degrees.
    #[serde(default = "sixty")]
    pub join_deg: f32,
    /// Edges that are sharper than this are drawn too, in degrees between their normals; none draws contours only.
    pub crease_deg: Option<f32>,
    /// Whether the border of the land is drawn.
    #[serde(default = "yes")]
    pub borders: bool,
    /// Strokes are made anew in each Nth frame; between, they move with the world.
    #[serde(default = "ten")]
    pub update_every: u32,
    /// Whether strokes take over from those of the frame before: identity, texture, pressure, part of the place.
    #[serde(default = "yes")]
    pub carry: bool,
    /// How fast strokes come and go if they take over from the frame before: none takes longer than twice this, in
    /// seconds.
    #[serde(default = "fade_s")]
    pub fade_s: f32,
    /// How far the line of the frame before holds the new one in its place, 0 to 1.
    #[serde(default = "hold")]
    pub hold: f32,
    /// Length of all strokes together, at most, in pixels; the shortest are left out first.
    #[serde(default = "budget_px")]
    pub budget_px: f32,
    /// What is left of a stroke in full haze, 0 to 1.
    #[serde(default)]
    pub faintest: f32,
    /// How much farther than tones strokes reach into the haze.
    #[serde(default = "one")]
    pub reach: f32,
}

fn four() -> f32 {
    4.0
}

fn ten() -> u32 {
    10
}

fn fade_s() -> f32 {
    0.8
}

fn hold() -> f32 {
    0.7
}

fn budget_px() -> f32 {
    400_000.0
}

fn sixty() -> f32 {
    60.0
}

impl Strokes {
    pub(super) fn check(&self) -> Result<(), String> {
        let within = |what: &str, value, low, high| within(&format!("strokes.{what}"), value, low, high);
        within("width_px", self.width_px, 0.5, 64.0)?;
        within("taper_px", self.taper_px, 0.0, 1000.0)?;
        within("shortest_px", self.shortest_px, 0.0, 1000.0)?;
        within("curve_width", self.curve_width, -1.0, 1.0)?;
        within("wobble_px", self.wobble_px, 0.0, 16.0)?;
        within("depth_width", self.depth_width, 0.0, 1.0)?;
        within("resolution", self.resolution, 0.25, 1.0)?;
        within("join_px", self.join_px, 1.0, 16.0)?;
        within("join_deg", self.join_deg, 0.0, 90.0)?;
        within("crease_deg", self.crease_deg.unwrap_or(0.0), 0.0, 180.0)?;
        within("faintest", self.faintest, 0.0, 1.0)?;
        within("fade_s", self.fade_s, 0.0, 60.0)?;
        within("hold", self.hold, 0.0, 1.0)?;
        within("budget_px", self.budget_px, 100.0, 500_000.0)?;
        if !(1..=1000).contains(&self.update_every) {
            return Err(format!("strokes.update_every is {}, not between 1 and 1000", self.update_every));
        }
        within("reach", self.reach, 1e-3, 1e6)
    }
}
