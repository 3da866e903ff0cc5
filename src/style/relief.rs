//! How a style brings out relief by its light.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::StyleError;
use super::parameters::{Range, choices, parameters};
use crate::file::hdr::SkyPicture;

choices! {
    /// How relief is brought out.
    pub enum ReliefKind {
        /// Light of the surroundings, gathered and spread by curvature (Vergne and others 2009, light warping).
        Warp,
        /// The light of the style, scaled by curvature (Vergne and others 2010, radiance scaling).
        Scaling,
        /// The sun alone, as it grazes the land's form at several scales at once (Rusinkiewicz and others 2006).
        Exaggerated,
    }
}

parameters! {
    /// Light that brings out relief, for tones of the kind `toon`.
    pub struct Relief {
        /// How relief is brought out.
        kind: ReliefKind = ReliefKind::Warp;
        /// What curvature is multiplied by (α of the warp): a bulge of that radius is warped by half of what is possible; 0 is none.
        alpha_px: f32 = 30.0 => Range::Within(-1000.0, 1000.0);
        /// Contrast by curvature (γ of the warp): light is multiplied by (λu λv)^γ.
        gamma: f32 = 0.0 => Range::Within(-1.0, 1.0);
        /// Size of features that count: the standard deviation of the blur of depth's gradient, which stops at silhouettes.
        scale_px: f32 = 2.0 => Range::Within(0.0, 12.0);
        /// How many times as much is added to that in full haze.
        coarser_far: f32 = 0.0 => Range::Within(0.0, 4.0);
        /// The same far from the focus.
        coarser_aside: f32 = 0.0 => Range::Within(0.0, 4.0);
        /// The same on level land.
        coarser_level: f32 = 0.0 => Range::Within(0.0, 4.0);
        /// Neighbours whose normals differ by more have a crease between them, where nothing is warped.
        crease_deg: f32 = 60.0 => Range::Within(1.0, 180.0);
        /// How much of the curvature of land that is seen along itself counts; 1 is the paper's.
        foreshortening: f32 = 0.5 => Range::Within(0.0, 1.0);
        /// Number of parts into which the surroundings are taken apart.
        lights: u32 = 54 => Range::Within(1.0, 256.0);
        /// The surroundings, as a Radiance picture (`.hdr`) of the whole sphere; without it a clear sky over bright ground.
        environment: Option<PathBuf>;
        /// How far such a picture is turned, clockwise; its middle is north.
        turn_deg: f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// The sun's part of the light on land that faces it; surroundings of a picture have their own sun.
        sun: f32 = 0.6 => Range::Within(0.0, 1.0);
        /// How glossy the surface is.
        gloss: f32 = 0.0 => Range::Within(0.0, 4.0);
        /// Exponent of gloss.
        shininess: f32 = 12.0 => Range::Within(1.0, 256.0);
        /// How much tones have of the light's colour.
        color: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Strength of radiance scaling (its γ).
        scaling: f32 = 1.5 => Range::Within(0.0, 8.0);
        /// Tone that radiance scaling leaves as it is (its α).
        invariant: f32 = 0.4 => Range::Within(0.01, 0.99);
        /// Number of scales of exaggerated relief; each is twice as coarse as the one before.
        scales: u32 = 5 => Range::Within(1.0, 8.0);
        /// Size of a sample of the finest of them.
        finest_px: f32 = 4.0 => Range::Within(1.0, 64.0);
        /// How much exaggerated relief is exaggerated.
        exaggeration: f32 = 2.0 => Range::Within(0.1, 50.0);
        /// How many times as much each coarser scale counts.
        coarser: f32 = 1.2 => Range::Within(0.1, 4.0);
    } beside {
        /// What `environment` means.
        sky: Option<Arc<SkyPicture>>;
    }
}

impl Relief {
    /// Loads the surroundings; a file lies in `folder`, and is named by the path from which it was read afterwards.
    pub(super) fn complete(&mut self, folder: &Path) -> Result<(), StyleError> {
        self.environment = self.environment.take().map(|name| folder.join(name));
        self.sky = self.environment.as_ref().map(|path| SkyPicture::load(path).map(Arc::new)).transpose()?;
        Ok(())
    }

    /// Whether light is warped or scaled by curvature.
    pub fn asks_for_curvature(&self) -> bool {
        self.kind != ReliefKind::Exaggerated && self.alpha_px != 0.0
    }
}
