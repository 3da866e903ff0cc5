//! Pen strokes of a style.

use std::path::{Path, PathBuf};

use super::parameters::{Range, parameters};
use super::{Color, StyleError, texture};

parameters! {
    /// Strokes of a style.
    pub struct Strokes {
        /// Colour of the strokes.
        ink: Color = Color::default();
        /// Width of a stroke.
        width_px: f32 => Range::Within(0.5, 64.0);
        /// What strokes are drawn with: a texture of the program, or a recipe beside the style (`.toml`); without it
        /// they are solid.
        texture_name as "texture": Option<String>;
        /// Over this length strokes thin out at their ends.
        taper_px: f32 = 0.0 => Range::Within(0.0, 1000.0);
        /// How much wider strokes are at bends; 1 is twice the width at a right angle, and below 0 they are thinner.
        curve_width: f32 = 0.0 => Range::Within(-1.0, 1.0);
        /// How far the hand strays from the line, at each place of the world in its own way.
        wobble_px: f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Shorter strokes are left out, because they look like specks.
        shortest_px: f32 = 4.0 => Range::Within(0.0, 1000.0);
        /// How much wider near strokes are than far ones.
        depth_width: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much thinner strokes are where the land behind them is hardly farther away than they are.
        step_width: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How many times as long as wide a stroke is at least, about: shorter ones are thinner; 0 is no bound.
        slender: f32 = 0.0 => Range::Within(0.0, 200.0);
        /// The part of the paper that strokes may cover about a place; beyond it the least ones go first, and 1 is no cap.
        crowd: f32 = 1.0 => Range::Within(0.005, 1.0);
        /// Side of the window in which that is counted.
        crowd_px: f32 = 32.0 => Range::Within(8.0, 512.0);
        /// Pixels of the image in which visible edges are found, per pixel of the picture.
        resolution: f32 = 1.0 => Range::Within(0.25, 1.0);
        /// Ends that are this near to each other may be joined.
        join_px: f32 = 4.0 => Range::Within(1.0, 16.0);
        /// Ends may be joined if the line turns by no more than this.
        join_deg: f32 = 60.0 => Range::Within(0.0, 90.0);
        /// Edges that run side by side within this are drawn as one line.
        merge_px: f32 = 1.5 => Range::Within(0.0, 8.0);
        /// Edges whose normals differ by more than this are drawn too; without it only contours are.
        crease_deg: Option<f32> => Range::Within(0.0, 180.0);
        /// Suggestive contours of features larger than this, where land would be a contour from nearby; else none.
        suggestive_px: Option<f32> => Range::Within(1.0, 256.0);
        /// How fast curvature rises toward the eye at a suggestive contour, at least: by turns of the normal, over a feature.
        suggestive_rise: f32 = 0.02 => Range::Within(0.0, 10.0);
        /// Land that faces the eye by less than this from face on has no suggestive contours.
        suggestive_deg: f32 = 30.0 => Range::Within(0.0, 90.0);
        /// Width of suggestive contours, as a part of that of contours.
        suggestive_width: f32 = 0.6 => Range::Within(0.0, 1.0);
        /// Ridges and valleys of features larger than this; without it none are drawn.
        ridge_px: Option<f32> => Range::Within(1.0, 256.0);
        /// Whether ridges and valleys are of curvature as the picture foreshortens it (Judd, Durand and Adelson 2007).
        ridge_apparent: bool = false;
        /// How much the land bends across a ridge or a valley, at least: in turns of the normal over a feature.
        ridge_bend: f32 = 0.2 => Range::Within(0.0, 10.0);
        /// Width of ridges, as a part of that of contours; 0 draws none.
        ridge_width: f32 = 0.6 => Range::Within(0.0, 1.0);
        /// Width of valleys, as a part of that of contours; 0 draws none.
        valley_width: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Whether the border of the land is drawn.
        borders: bool = true;
        /// Strokes are made anew in every frame of this number, and move with the world in between.
        update_every in "frames": u32 = 10 => Range::Within(1.0, 1000.0);
        /// Whether strokes take over identity, texture, pressure and part of their place from those of the frame
        /// before.
        carry: bool = true;
        /// How fast carried strokes come and go: none takes longer than twice this.
        fade_s: f32 = 0.8 => Range::Within(0.0, 60.0);
        /// How far the line of the frame before holds the new one in its place.
        hold: f32 = 0.7 => Range::Within(0.0, 1.0);
        /// Length of all strokes together, at most; the shortest are left out first.
        budget_px: f32 = 400_000.0 => Range::Within(100.0, 500_000.0);
        /// What is left of a stroke in full haze.
        faintest: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How many times farther than tones strokes reach into the haze.
        reach: f32 = 1.0 => Range::Within(1e-3, 1e6);
    } beside {
        /// What `texture_name` means.
        texture: Option<texture::Recipe>;
    }
}

impl Strokes {
    /// Loads the texture; a file lies in `folder`.
    pub(super) fn complete(&mut self, folder: &Path) -> Result<(), StyleError> {
        self.texture = texture::named(self.texture_name.as_deref(), folder)?;
        Ok(())
    }

    /// The file that the texture is read from, if the style's lies in `folder`.
    pub(super) fn files(&self, folder: &Path) -> Option<PathBuf> {
        self.texture_name.as_ref().and_then(|name| texture::file(name, folder))
    }
}
