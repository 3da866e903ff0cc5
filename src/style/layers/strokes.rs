//! Pen strokes along contours. Their passes are in `src/lines/strokes`.

use std::path::PathBuf;

use super::{Channels, Fading, Ink, LayerBehaviour, Margins, RecipeSource, Trace};
use crate::style::parameters::{Range, parameters};
use crate::style::{Color, StyleError, texture};

/// Least margin of a part of a large picture, in pixels, within which strokes are also found.
const MARGIN_PX: u32 = 256;
/// Longest taper as a multiple of `taper_px`, as in `shaders/lines/strokes/samples.wgsl`.
const LONG_TAPER: f32 = 4.0;

parameters! {
    /// Pen strokes along contours, ridges and valleys.
    pub struct Strokes {
        /// Colour of the strokes.
        ink called "Ink colour": Color = Color::default();
        /// Width of a stroke.
        width_px: f32 => Range::Within(0.5, 64.0);
        /// Stroke texture: a built-in name, a recipe (`.toml`) or a picture of a stroke (`.png`); without it strokes are
        /// solid.
        texture_name as "texture": Option<String>;
        /// Strokes taper over this length at both ends; those that hide little land over up to four times as much.
        taper_px called "Taper length": f32 = 0.0 => Range::Within(0.0, 1000.0);
        /// How much wider strokes are at bends; 1 is twice the width at a right angle, negative values make them
        /// thinner.
        curve_width called "Width at bends": f32 = 0.0 => Range::Within(-1.0, 1.0);
        /// How far a stroke strays from its line, as if drawn by hand; the wobble is fixed to the world.
        wobble_px: f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Shorter strokes are left out, except pieces of the skyline between other lines.
        shortest_px called "Shortest stroke": f32 = 4.0 => Range::Within(0.0, 1000.0);
        /// Shorter strokes within a slope, with land behind them less than 15 % farther away, are left out.
        shortest_interior_px called "Shortest within slopes": f32 = 0.0 => Range::Within(0.0, 1000.0);
        /// How strongly width depends on distance; 0 is not at all; larger values make near lines that hide land wider, far
        /// ones thinner.
        depth_width called "Width by distance": f32 = 0.0 => Range::Within(0.0, 1.0), zero "none";
        /// Width of outlines with land at least 24 % farther away behind them, as a fraction of that of skylines.
        occluding_width called "Width before land": f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Width of strokes within a slope, with nothing hidden behind them, as a fraction of that of skylines.
        interior_width called "Width within slopes": f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Strokes shorter than about this many widths become thinner, less so if another line continues them; 0 is no limit.
        slender called "Least length to width": f32 = 0.0 => Range::Within(0.0, 200.0), zero "no limit";
        /// Largest fraction of the area that strokes may cover; above it the weakest are removed first; 1 is no limit.
        crowd called "Largest covered area": f32 = 1.0 => Range::Within(0.005, 1.0);
        /// Side of the square window in which the covered area is measured for `crowd`.
        crowd_px called "Cover window": f32 = 32.0 => Range::Within(8.0, 512.0);
        /// Resolution of the image in which visible edges are found, relative to the picture.
        resolution called "Edge resolution": f32 = 1.0 => Range::Within(0.25, 1.0);
        /// Ends of strokes that are closer than this may be joined.
        join_px called "Largest joined gap": f32 = 4.0 => Range::Within(1.0, 16.0);
        /// Largest turn of the line where two ends are joined.
        join_deg called "Largest joined turn": f32 = 60.0 => Range::Within(0.0, 90.0);
        /// Edges that run the same way closer than this are drawn as one line: a skyline, or else the nearer or the outer one.
        merge_px called "Merging distance": f32 = 1.5 => Range::Within(0.0, 8.0);
        /// Edges whose two normals differ by more than this are also drawn; without it only contours are.
        crease_deg called "Crease angle": Option<f32> => Range::Within(0.0, 180.0);
        /// Draws suggestive contours of features larger than this; without it none are drawn.
        suggestive_px called "Suggestive contour size": Option<f32> => Range::Within(1.0, 256.0);
        /// Least increase of curvature toward the eye at a suggestive contour: turn of the normal over a feature, per
        /// feature.
        suggestive_rise called "Suggestive threshold": f32 = 0.02 => Range::Within(0.0, 10.0);
        /// Suggestive contours are drawn only where the normal points away from the eye by more than this angle.
        suggestive_deg called "Suggestive angle": f32 = 30.0 => Range::Within(0.0, 90.0);
        /// Width of suggestive contours, as a fraction of the width of contours.
        suggestive_width called "Suggestive width": f32 = 0.6 => Range::Within(0.0, 1.0);
        /// Draws ridges and valleys of features larger than this; without it none are drawn.
        ridge_px called "Ridge size": Option<f32> => Range::Within(1.0, 256.0);
        /// Whether ridges and valleys are those of view-dependent curvature: apparent ridges (Judd and others 2007).
        ridge_apparent called "Apparent ridges": bool = false;
        /// Least curvature across a ridge or valley, as the turn of the normal over a feature.
        ridge_bend called "Ridge threshold": f32 = 0.2 => Range::Within(0.0, 10.0);
        /// Width of ridges, as a fraction of the width of contours; 0 draws none.
        ridge_width: f32 = 0.6 => Range::Within(0.0, 1.0), zero "none";
        /// Width of valleys, as a fraction of the width of contours; 0 draws none.
        valley_width: f32 = 0.0 => Range::Within(0.0, 1.0), zero "none";
        /// Whether the outer border of the terrain is drawn.
        borders called "Border of terrain": bool = true;
        /// Strokes are rebuilt every this many frames, and move with the world in between.
        update_every in "frames" called "Rebuilding interval": u32 = 10 => Range::Within(1.0, 1000.0);
        /// While the camera moves, strokes are not rebuilt sooner than this after the last time; 0 waits for nothing.
        rebuild_ms called "Shortest time between rebuilds": f32 = 0.0 => Range::Within(0.0, 1000.0), zero "no wait";
        /// Whether strokes inherit identity, texture, pressure and part of their position from those of the previous
        /// frame.
        carry called "Carry strokes over": bool = true;
        /// Time over which strokes fade in and out when `carry` is on; no stroke takes longer than twice this.
        fade_s called "Fade time": f32 = 0.8 => Range::Within(0.0, 60.0);
        /// How strongly a rebuilt stroke is held at its previous position; 0 moves it at once.
        hold called "Hold in place": f32 = 0.7 => Range::Within(0.0, 1.0);
        /// Largest total length of all strokes; the shortest are left out first.
        budget_px in "px in total" called "Largest total length": f32 = 400_000.0 => Range::Within(100.0, 500_000.0);
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Strokes fade in haze this many times farther away than tones.
        reach called "Reach in haze": f32 = 1.0 => Range::Within(1e-3, 1e6), soft 8.0;
    } loaded {
        /// The loaded recipe of `texture_name`.
        texture: Option<texture::Recipe>;
    }
}

impl LayerBehaviour for Strokes {
    fn inks(&self) -> Vec<Ink> {
        vec![Ink {
            id: "strokes",
            label: "Strokes".to_owned(),
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::AlreadyFaded,
            makes_tone: false,
            is_main: true,
            trace: Trace::Strokes,
        }]
    }

    fn margins(&self) -> Margins {
        // Strokes that are scaled for a print taper over more pixels, and each part must see whether they are long enough.
        let px = (LONG_TAPER * self.taper_px).max(self.shortest_px).max(2.0 * self.shortest_interior_px);
        Margins { margin_px: MARGIN_PX.max(px.ceil() as u32), ..Margins::default() }
    }

    fn summary(&self) -> Option<String> {
        Some("strokes".to_owned())
    }

    fn missing_in_vectors(&self) -> Option<&'static str> {
        self.texture.is_some().then_some("stroke textures")
    }

    fn scale_marks(&mut self, factor: f32) {
        if let Some(texture) = &mut self.texture {
            *texture = texture.scaled(factor);
        }
    }

    fn complete(&mut self, source: RecipeSource<'_>) -> Result<Vec<PathBuf>, (String, StyleError)> {
        let texture = source.texture(self.texture_name.as_deref(), self.width_px);
        self.texture = texture.map_err(|error| ("texture".to_owned(), error))?;
        Ok(match source {
            RecipeSource::Folder(folder) => texture::files(self.texture_name.as_deref(), self.texture.as_ref(), folder),
            RecipeSource::Embedded(_) => Vec::new(),
        })
    }
}

impl Strokes {
    /// Returns whether strokes drawn with `before` may continue as strokes with these settings. They may not if the
    /// texture, the resolution of the image of edges, or `carry` differs.
    pub(crate) fn continues(&self, before: &Self) -> bool {
        let is_alike = self.texture == before.texture && self.resolution == before.resolution;
        is_alike && self.carry == before.carry
    }

    /// Returns whether strokes drawn with `before` need not be rebuilt for these settings: at most the colour differs,
    /// which the composite applies.
    pub(crate) fn draws_as(&self, before: &Self) -> bool {
        *self == Self { ink: self.ink, ..before.clone() }
    }
}
