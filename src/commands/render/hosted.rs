//! `render` inside another program, such as Python: the program gives the GPU, the heights and the style, and takes the
//! pictures instead of files.

use std::sync::Arc;

use super::job::Job;
use super::{RenderArgs, look};
use crate::commands::misuse::Misuse;
use crate::file::exr::{SampleKind, Samples};
use crate::gpu::Gpu;
use crate::picture::eyes::joined;
use crate::picture::{self, PictureReport};
use crate::pyramid::TileStore;
use crate::scene::camera::Camera;
use crate::scene::view::Pose;
use crate::scene::{Scene, World};
use crate::source::georeference::Georeference;
use crate::style::Style;
use crate::tiles::terrain::TerrainOptions;
use crate::world::{self, OpenWorld};

/// Largest number of start views that are remembered.
const MOST_STARTS: usize = 64;

/// Takes a picture; an error ends the drawing.
pub(crate) type Take<'a> = Box<dyn FnMut(DrawnPicture) -> anyhow::Result<()> + 'a>;

/// A picture in memory.
#[derive(Debug)]
pub struct DrawnPicture {
    /// Width and height in pixels; two eyes side by side are twice as wide.
    pub size_px: [u32; 2],
    /// Width × height × 4 bytes: sRGB red, green, blue, and an alpha of 255, row by row from the top.
    pub rgba: Vec<u8>,
    /// The channels of `--aov`, with their names in an EXR and width × height samples of one eye.
    pub channels: Vec<(String, Samples)>,
    /// The camera, as `--camera` takes it.
    pub camera: String,
    /// Position on the earth of the pixels of a map, for pixel centres; `None` for a picture in perspective.
    pub georeference: Option<Georeference>,
    /// The description of the picture that hachure stores in files.
    pub imprint: String,
    /// Resolution on paper in dots per inch, if it was given.
    pub dpi: Option<f64>,
    /// Statistics of the drawing.
    pub report: PictureReport,
}

/// Resources of a program that embeds hachure, for `render`. The program `hachure` has none.
#[derive(Default)]
pub(crate) struct Host<'a> {
    /// The GPU, whose pipelines are already stored.
    pub(crate) gpu: Option<Gpu>,
    /// Heights that are open, and the scene for which they were opened.
    pub(crate) heights: Option<(&'a Scene, Arc<dyn TileStore>)>,
    /// The style, instead of that of `--style`.
    pub(crate) style: Option<Style>,
    /// The world of the last picture.
    pub(crate) opened: Option<&'a mut Option<Opened>>,
    /// Takes the pictures; without it, they are written to the output.
    pub(crate) take: Option<Take<'a>>,
    /// The start views of the open world that are known.
    pub(crate) starts: Vec<StartView>,
}

/// The start view of a world for one aspect: it takes longer to find than a small picture to draw.
#[derive(Clone, Copy)]
pub(crate) struct StartView {
    aspect: f64,
    camera: Camera,
}

/// A world on the GPU, and what it was opened with.
pub(crate) struct Opened {
    scene: Scene,
    options: TerrainOptions,
    world: OpenWorld,
    starts: Vec<StartView>,
}

impl Host<'_> {
    /// Returns whether a program gives anything, so that nothing is printed.
    pub(super) fn is_given(&self) -> bool {
        self.gpu.is_some()
    }

    /// Returns whether the heights have no file.
    pub(super) fn has_heights_in_memory(&self) -> bool {
        self.heights.as_ref().is_some_and(|(scene, _)| scene.world == World::Memory)
    }

    /// Returns the open heights, if they are those of a scene.
    ///
    /// # Errors
    /// Holes of heights in memory were filled, and the scene has them open, or the other way round.
    pub(super) fn store(&self, scene: &Scene) -> Result<Option<Arc<dyn TileStore>>, Misuse> {
        let Some((opened, store)) = &self.heights else { return Ok(None) };
        if opened.world == World::Memory {
            if opened.heights.voids != scene.heights.voids {
                return Err(Misuse(
                    "--voids: the holes of heights in memory are filled when they are opened".to_owned(),
                ));
            }
            // Heights in memory are true to scale.
            return Ok(Some(world::exaggerated(Arc::clone(store), scene.vertical_exaggeration)));
        }
        let is_same = opened.world == scene.world
            && opened.heights == scene.heights
            && opened.vertical_exaggeration == scene.vertical_exaggeration;
        Ok(is_same.then(|| Arc::clone(store)))
    }

    /// Takes the world of the last picture, if it was opened for the same scene with the same options.
    pub(super) fn opened(&mut self, scene: &Scene, options: &TerrainOptions) -> Option<OpenWorld> {
        let slot = self.opened.as_mut()?;
        // Another world is dropped before the next is opened: both may not fit on the GPU.
        let opened = slot.take()?;
        if opened.scene != *scene || !is_same(&opened.options, options) {
            return None;
        }
        self.starts = opened.starts;
        Some(opened.world)
    }

    /// Returns the camera of a picture in perspective; a start view is looked up, or found and remembered.
    pub(super) fn start_camera(&mut self, args: &RenderArgs, world: &OpenWorld) -> Camera {
        if !self.is_given() || args.camera.is_some() || args.path.is_some() {
            return look::start_camera(args, world);
        }
        let aspect = look::aspect(args);
        if let Some(known) = self.starts.iter().find(|known| known.aspect == aspect) {
            return known.camera;
        }
        let camera = look::start_camera(args, world);
        if self.starts.len() < MOST_STARTS {
            self.starts.push(StartView { aspect, camera });
        }
        camera
    }

    /// Retains the world for the next picture.
    pub(super) fn keep(&mut self, scene: Scene, options: TerrainOptions, world: OpenWorld) {
        if let Some(slot) = &mut self.opened {
            **slot = Some(Opened { scene, options, world, starts: std::mem::take(&mut self.starts) });
        }
    }
}

fn is_same(a: &TerrainOptions, b: &TerrainOptions) -> bool {
    a.lod_error_px == b.lod_error_px && a.tile_memory_bytes == b.tile_memory_bytes
}

impl Job<'_> {
    /// Draws a picture, and passes it to the program in which hachure is embedded.
    pub(super) fn in_memory(&mut self, pose: Pose, previous: Pose) -> anyhow::Result<PictureReport> {
        let size_px = self.args.size_of_all();
        let planes = self.planes.len();
        let named = self.exr_channels();
        // The first four channels of each eye are its colour.
        let named = named.chunks(planes + 4).flat_map(|eye| eye.iter().skip(4));
        let empty = |(name, kind): &(String, SampleKind)| match kind {
            SampleKind::F32 => (name.clone(), Samples::F32(Vec::new())),
            SampleKind::U32 => (name.clone(), Samples::U32(Vec::new())),
        };
        let mut channels: Vec<(String, Samples)> = named.map(empty).collect();
        let mut rgba = Vec::new();
        let report = self.render(pose, previous, |bands| {
            let samples = bands.iter().flat_map(|band| band.planes.iter().take(planes));
            for ((_, all), samples) in channels.iter_mut().zip(samples) {
                match (all, samples) {
                    (Samples::F32(all), Samples::F32(samples)) => all.extend_from_slice(samples),
                    (Samples::U32(all), Samples::U32(samples)) => all.extend_from_slice(samples),
                    (Samples::F32(_), Samples::U32(_)) | (Samples::U32(_), Samples::F32(_)) => {}
                }
            }
            rgba.extend(picture::srgb8(&joined(size_px[0], bands)));
            Ok(())
        })?;
        let drawn = DrawnPicture {
            size_px,
            rgba,
            channels,
            camera: self.camera_text(pose),
            georeference: self.map.as_ref().map(|map| map.georeference.clone()),
            imprint: self.imprint_text(),
            dpi: self.args.dpi,
            report: report.clone(),
        };
        if let Some(take) = &mut self.take {
            take(drawn)?;
        }
        Ok(report)
    }
}
