//! Thumbnails of styles: small pictures of the current view, drawn one at a time while the camera is at rest.
//!
//! They have a renderer of their own, which shares pipelines with that of the window and never waits for one. The next
//! thumbnail is begun when the GPU has finished the last one, and after as much time again, so that a slow GPU is at
//! most half busy with them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::composite::PICTURE;
use crate::composite::present::{PresentPass, Shown};
use crate::frame::{Antialias, Light, Renderer};
use crate::gpu::pipelines::Builds;
use crate::gpu::{Gpu, GpuError};
use crate::scene::view::{Clock, Pose, View};
use crate::style::Style;
use crate::world::Surfaces;

/// Format of thumbnails, that of the textures of egui.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Thumbnails are drawn this many times larger than they are shown, because lines have the widths of a large picture.
const LARGER: f32 = 2.0;
/// Shortest time between two attempts.
const PAUSE: Duration = Duration::from_millis(25);
/// Time between two attempts while pipelines are being built.
const BUILDING_PAUSE: Duration = Duration::from_millis(100);
/// Attempts after which a thumbnail is shown although tiles or hachures are missing, and after which one is given up whose pipelines
/// are not built.
const MAX_ATTEMPTS: u32 = 40;

/// The textures of the panel.
pub(in crate::window) trait Textures {
    /// Makes a picture available to the panel.
    fn register(&mut self, gpu: &Gpu, picture: &wgpu::TextureView) -> egui::TextureId;

    /// Releases a picture that was made available.
    fn unregister(&mut self, id: egui::TextureId);
}

/// The contents of a thumbnail; thumbnails of equal subjects are equal.
#[derive(Clone, Debug, PartialEq)]
struct Subject {
    style: Style,
    pose: Pose,
    light: Light,
    size_px: [u32; 2],
    land: Land,
}

/// The values of the land that a window changes: the height of the sea in metres, and the seed of the forest.
type Land = (Option<f64>, Option<u32>);

/// A thumbnail on the GPU.
struct Thumbnail {
    #[cfg_attr(not(test), expect(dead_code, reason = "only tests read the picture back"))]
    texture: wgpu::Texture,
    id: egui::TextureId,
    subject: Subject,
}

/// The view that thumbnails show.
#[derive(Clone, Copy, Debug)]
pub(in crate::window) struct Scene {
    pub pose: Pose,
    pub light: Light,
    /// Size at which thumbnails are shown, in pixels of the window.
    pub shown_px: [f32; 2],
}

/// The thumbnails of all styles.
#[derive(Default)]
pub(in crate::window) struct Thumbnails {
    renderer: Option<Renderer>,
    present: Option<PresentPass>,
    thumbnails: BTreeMap<usize, Thumbnail>,
    /// The style that is being drawn, and the number of attempts.
    current: Option<(usize, u32)>,
    /// Styles whose pipelines took too long; the others come first.
    put_off: BTreeSet<usize>,
    /// Whether the GPU is still drawing, and since when.
    busy: Option<(Arc<AtomicBool>, Instant)>,
    next_at: Option<Instant>,
}

impl Thumbnails {
    /// Returns the thumbnail of a style, which may be of an earlier view.
    pub(super) fn get(&self, style: usize) -> Option<egui::TextureId> {
        self.thumbnails.get(&style).map(|thumbnail| thumbnail.id)
    }

    /// Returns the picture of a style on the GPU.
    #[cfg(test)]
    pub(super) fn texture(&self, style: usize) -> Option<&wgpu::Texture> {
        self.thumbnails.get(&style).map(|thumbnail| &thumbnail.texture)
    }

    /// Returns when the next attempt is due; `None` if all thumbnails are drawn.
    pub(in crate::window) fn next_at(&self) -> Option<Instant> {
        self.next_at
    }

    /// Begins to draw again, because something may have changed.
    pub(in crate::window) fn wake(&mut self, now: Instant) {
        self.next_at.get_or_insert(now);
    }

    /// Stops drawing, because the gallery is not shown.
    pub(in crate::window) fn sleep(&mut self) {
        self.next_at = None;
        self.current = None;
        self.renderer = None;
    }

    /// Draws a thumbnail that is out of date, if one is. Returns whether a new one can be shown.
    ///
    /// # Errors
    /// Fails if the GPU fails.
    pub(in crate::window) fn work(
        &mut self,
        gpu: &Gpu,
        world: &mut Surfaces,
        panel: &mut impl Textures,
        scene: Scene,
        styles: &[Style],
        order: &[usize],
    ) -> Result<bool, GpuError> {
        let now = Instant::now();
        if self.next_at.is_none_or(|at| at > now) {
            return Ok(false);
        }
        if let Some((busy, since)) = &self.busy {
            // The work of a frame is finished when the device is polled.
            if let Err(error) = gpu.device.poll(wgpu::PollType::Poll) {
                tracing::debug!("{error}");
            }
            let took = now.saturating_duration_since(*since);
            self.next_at = Some(now + PAUSE.max(took));
            if !busy.load(Ordering::Acquire) {
                self.busy = None;
            }
            return Ok(false);
        }
        let size_px = scene.shown_px.map(|side| (LARGER * side).round().max(1.0) as u32);
        let land: Land = (world.sea_level_m(), world.forest().map(|forest| forest.seed));
        let subject = |style: usize| Subject {
            style: styles[style].clone(),
            pose: scene.pose,
            light: scene.light,
            size_px,
            land,
        };
        let is_old = |style: usize| {
            self.thumbnails.get(&style).is_none_or(|known| {
                let Subject { style: drawn, pose, light, size_px: drawn_px, land: drawn_land } = &known.subject;
                (*pose, *light, *drawn_px, *drawn_land) != (scene.pose, scene.light, size_px, land)
                    || *drawn != styles[style]
            })
        };
        let mut old = order.iter().copied().filter(|style| is_old(*style));
        let Some(style) = old.clone().find(|style| !self.put_off.contains(style)).or_else(|| old.next()) else {
            self.next_at = None;
            self.current = None;
            self.put_off.clear();
            return Ok(false);
        };
        let attempts = match self.current {
            Some((current, attempts)) if current == style => attempts + 1,
            _ => 0,
        };
        self.current = Some((style, attempts));
        self.next_at = Some(now + PAUSE);
        let subject = subject(style);
        let renderer = Renderer::or_new(&mut self.renderer, gpu)?;
        renderer.set_builds(Builds::InBackground);
        renderer.set_antialias(Antialias::None);
        renderer.forget();
        let view = View::whole(subject.pose, subject.pose, size_px).at(Clock::still(0.0));
        let prepared = renderer.render(gpu, world, &view, &subject.style, &subject.light)?;
        let is_drawn = renderer.shows(&subject.style) && renderer.drew();
        let busy = Arc::new(AtomicBool::new(true));
        let finished = Arc::clone(&busy);
        gpu.queue.on_submitted_work_done(move || finished.store(false, Ordering::Release));
        self.busy = Some((busy, now));
        if renderer.is_building(gpu) {
            self.next_at = Some(now + BUILDING_PAUSE);
        }
        let is_whole = !prepared.tiles.late && prepared.tiles.loaded == 0 && !renderer.has_late_rows();
        if attempts < MAX_ATTEMPTS && !(is_drawn && is_whole) {
            return Ok(false);
        }
        let Some(picture) = renderer.target(&PICTURE).filter(|_| is_drawn) else {
            // If all have been put off, each gets another turn.
            if !self.put_off.insert(style) {
                self.put_off.clear();
            }
            self.current = None;
            return Ok(false);
        };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("thumbnail"),
            size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("thumbnail") });
        let present = self.present.get_or_insert_with(|| PresentPass::new(gpu, FORMAT));
        present.run(gpu, &mut encoder, Shown::One(picture), &target, size_px);
        gpu.queue.submit([encoder.finish()]);
        let id = panel.register(gpu, &target);
        if let Some(old) = self.thumbnails.insert(style, Thumbnail { texture, id, subject }) {
            panel.unregister(old.id);
        }
        self.current = None;
        self.put_off.remove(&style);
        Ok(true)
    }
}
