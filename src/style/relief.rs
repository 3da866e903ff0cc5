//! The `[relief]` section of a style: light that emphasises relief.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::StyleError;
use super::parameters::{Range, choices, parameters};
use crate::file::hdr::SkyPicture;

choices! {
    /// Method that emphasises relief.
    pub enum ReliefKind {
        /// Light warping: environment light, gathered or spread by curvature (Vergne and others 2009).
        Warp,
        /// Radiance scaling: the light of the style, scaled by curvature (Vergne and others 2010).
        Scaling,
        /// Exaggerated shading: sunlight that grazes the land at several scales at once (Rusinkiewicz and others 2006).
        Exaggerated,
    }
}

parameters! {
    /// Light that emphasises relief, for tones of the kind `toon`.
    pub struct Relief {
        /// Method that emphasises relief.
        kind called "Relief method": ReliefKind = ReliefKind::Warp;
        /// Factor of curvature (α of the warp): a bulge of this radius gets half of the largest possible warp; 0 is
        /// none.
        alpha_px called "Warp by curvature": f32 = 30.0 => Range::Within(-1000.0, 1000.0), zero "none";
        /// Contrast by curvature (γ of the warp): the light is multiplied by (λu λv)^γ.
        gamma called "Contrast by curvature": f32 = 0.0 => Range::Within(-1.0, 1.0);
        /// Smallest feature that counts: standard deviation of the blur of the depth gradient, which stops at
        /// silhouettes.
        scale_px called "Smallest feature": f32 = 2.0 => Range::Within(0.0, 12.0);
        /// Increase of `scale_px` in full haze, as a multiple of it.
        coarser_far called "Coarser in haze": f32 = 0.0 => Range::Within(0.0, 4.0);
        /// Increase of `scale_px` far from the focus, as a multiple of it.
        coarser_aside called "Coarser off focus": f32 = 0.0 => Range::Within(0.0, 4.0);
        /// Increase of `scale_px` on flat land, as a multiple of it.
        coarser_level called "Coarser on flats": f32 = 0.0 => Range::Within(0.0, 4.0);
        /// Neighbouring pixels whose normals differ by more are separated by a crease, across which nothing is blurred.
        crease_deg called "Crease angle": f32 = 60.0 => Range::Within(1.0, 180.0);
        /// How much the curvature of land seen at a grazing angle counts; 1 is the value of the paper.
        foreshortening called "Curvature when grazing": f32 = 0.5 => Range::Within(0.0, 1.0);
        /// Number of directional lights that approximate the environment.
        lights called "Number of lights": u32 = 54 => Range::Within(1.0, 256.0);
        /// Environment map of the whole sphere (Radiance `.hdr`); the default is a clear sky over bright ground.
        environment called "Environment map": Option<PathBuf>;
        /// Clockwise rotation of the environment map; at 0 its middle is north.
        turn_deg called "Map rotation": f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Fraction of the light that the sun gives on land facing it; an environment map has its own sun.
        sun called "Share of sunlight": f32 = 0.6 => Range::Within(0.0, 1.0);
        /// Strength of the glossy reflection.
        gloss called "Glossy reflection": f32 = 0.0 => Range::Within(0.0, 4.0);
        /// Exponent of the glossy reflection; larger values give smaller highlights.
        shininess: f32 = 12.0 => Range::Within(1.0, 256.0);
        /// How strongly the colour of the light tints the tones.
        color called "Tint by light": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Strength of radiance scaling (its γ).
        scaling called "Scaling strength": f32 = 1.5 => Range::Within(0.0, 8.0);
        /// Tone that radiance scaling does not change (its α).
        invariant called "Unchanged tone": f32 = 0.4 => Range::Within(0.01, 0.99);
        /// Number of scales of exaggerated shading; each is twice as coarse as the one before.
        scales called "Number of scales": u32 = 5 => Range::Within(1.0, 8.0);
        /// Sample size of the finest scale of exaggerated shading.
        finest_px called "Finest scale": f32 = 4.0 => Range::Within(1.0, 64.0);
        /// Strength of exaggerated shading.
        exaggeration: f32 = 2.0 => Range::Within(0.1, 50.0);
        /// Weight of each scale of exaggerated shading relative to the next finer one.
        coarser called "Weight per scale": f32 = 1.2 => Range::Within(0.1, 4.0);
    } loaded {
        /// The loaded image of `environment`.
        sky: Option<Arc<SkyPicture>>;
    }
}

impl Relief {
    /// Loads the environment map; `folder` is the base of a relative path. Afterwards `environment` is the path that
    /// was read.
    pub(super) fn complete(&mut self, folder: &Path) -> Result<(), StyleError> {
        self.environment = self.environment.take().map(|name| folder.join(name));
        self.sky = self.environment.as_ref().map(|path| SkyPicture::load(path).map(Arc::new)).transpose()?;
        Ok(())
    }

    /// Returns whether light is warped or scaled by curvature.
    pub(crate) fn needs_curvature(&self) -> bool {
        self.kind != ReliefKind::Exaggerated && self.alpha_px != 0.0
    }
}
