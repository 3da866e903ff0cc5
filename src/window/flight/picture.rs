//! The picture of a frame: it is rendered and brought to the screen.

use std::time::{Duration, Instant};

use super::Flight;
use crate::composite::PICTURE;
use crate::composite::present::Shown;
use crate::frame::Renderer;
use crate::gpu::pipelines::Builds;
use crate::gpu::recorder::Submits;
use crate::ladder::Quality;
use crate::scene::anaglyph::Glasses;
use crate::scene::stereo::Eyes;
use crate::scene::view::{Clock, View};
use crate::window::WindowError;
use crate::window::dock::Pane;
use crate::window::overlay::Painted;

/// Time without a change after which the style is drawn as it is, however long a frame takes.
const REST: Duration = Duration::from_millis(500);
/// Allowed error of the land of a flight for which none is given, in pixels.
const DEFAULT_LOD_ERROR_PX: f64 = 1.0;

impl Flight {
    /// Renders the picture of the current view and settings.
    ///
    /// # Errors
    /// Fails if the GPU fails.
    pub(super) fn render_picture(&mut self, step_s: f64) -> Result<(), WindowError> {
        let window_px = self.screen.size_px();
        let chosen = self.compared.as_ref().unwrap_or(&self.styles.list()[self.settings.style]);
        self.ladder.follow(&chosen.name, self.settings.quality);
        let (now, pose) = (Instant::now(), self.camera.pose());
        let is_as_before = self.frames_left.is_none()
            && self.last.pose == pose
            && self.last.seen.as_ref().is_some_and(|(style, settings)| style == chosen && *settings == self.settings);
        self.still_since = is_as_before.then(|| self.still_since.unwrap_or(now));
        self.ladder.rest(self.still_since.is_some_and(|since| now - since >= REST));
        self.last.seen = self.ladder.is_governed().then(|| (chosen.clone(), self.settings.clone()));
        let setting = self.ladder.setting().cloned().unwrap_or_default();
        let scale = self.settings.scale().min(setting.scale.unwrap_or(1.0));
        let picture_px = self.settings.scaled_px(window_px, scale);
        let antialias = self.settings.antialias;
        let light = self.light();
        // An estimate without readback: `Surfaces::nearest_m` is at most half the height above the ground.
        let nearest_m = 2.0 * self.world.surfaces.nearest_m(pose.position_m);
        self.eyes_move = self.settings.follow_land(nearest_m, step_s);
        let (is_governed, tag) = (self.ladder.is_governed(), self.ladder.tag());
        let style = &*self.ladder.applied(chosen, scale);
        self.last.style = (style != chosen).then(|| (chosen.clone(), style.clone()));
        let renderer = Renderer::or_new(&mut self.renderer, &self.gpu)?;
        let clock = Clock { now_s: self.begun.elapsed().as_secs_f64(), before_s: self.last.time_s };
        let rig = self.settings.rig(&View::whole(self.last.pose, pose, picture_px).at(clock), &self.last.pair);
        let lod_error_px = match (setting.lod_error_px, self.settings.quality) {
            // Another error than the default one was set by the user.
            (Some(level_px), Quality::Level(_)) if self.settings.lod_error_px == DEFAULT_LOD_ERROR_PX => level_px,
            (given_up_px, _) => given_up_px.unwrap_or(0.0).max(self.settings.lod_error_px),
        };
        self.world.surfaces.terrain.set_lod_error_px(lod_error_px);
        self.world.surfaces.set_tree_detail(setting.tree_detail.unwrap_or(1.0));
        renderer.set_step_s(step_s);
        renderer.set_antialias(antialias);
        // The governor changes the size of pictures from frame to frame.
        let room_px = is_governed.then(|| self.settings.picture_px(window_px));
        renderer.set_room(room_px);
        renderer.set_frame_tag(tag);
        // A window never waits for a compiler.
        renderer.set_builds(Builds::InBackground);
        let measures = self.dock.is_shown(Pane::Flight) || self.dock.is_shown(Pane::Cost);
        renderer.set_submits(match (measures, is_governed) {
            (true, _) => Submits::Timed,
            (false, true) => Submits::Framed,
            (false, false) => Submits::Whole,
        });
        let traces = self.dock.is_shown(Pane::Cost) && self.traffic.is_due(&style.name, now);
        renderer.set_traces(traces);
        let prepared = renderer.render_eyes(&self.gpu, &mut self.world.surfaces, &rig, style, &light)?;
        if traces {
            self.traffic.count(renderer.trace(), &style.name, now);
        }
        self.render_left(&rig, &light, step_s, (antialias, scale, room_px))?;
        self.navigation.drew(&rig.eyes);
        if let Some(renderer) = &self.renderer {
            self.stroke_numbers.request(&self.gpu, renderer.strokes());
        }
        self.last.tiles_loaded += prepared.tiles.loaded;
        self.last.pose = pose;
        self.last.picture_px = picture_px;
        self.last.time_s = clock.now_s;
        self.last.pair = self.settings.pair;
        self.last.prepared = prepared;
        Ok(())
    }

    /// Shows the picture and the panels on the screen.
    pub(super) fn present(&mut self, surface: wgpu::SurfaceTexture, painted: Painted) {
        let target = surface.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let size_px = self.screen.size_px();
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("window") });
        if self.shows_chosen_style() {
            self.previous_renderer = None;
        }
        let shown = self.previous_renderer.as_ref().or(self.renderer.as_ref());
        let eye = |eye: usize| shown.and_then(|renderer| renderer.eye_target(eye, &PICTURE));
        let left = self.divided.as_ref().and_then(|divided| Some((divided, divided.drawn()?.eye_target(0, &PICTURE)?)));
        let shown = match (self.settings.eyes, eye(0), eye(1)) {
            (Eyes::Mono, Some(right), _) if let Some((divided, left)) = left => {
                Some(Shown::Divided { left, right, at: divided.divider.at })
            }
            (Eyes::Right, _, Some(right)) => Some(Shown::One(right)),
            (Eyes::Mono | Eyes::Left, Some(left), _) | (_, Some(left), None) => Some(Shown::One(left)),
            (eyes, Some(left), Some(right)) => Some(Shown::Pair { left, right, glasses: Glasses::of(eyes) }),
            (_, None, _) => None,
        };
        if let Some(shown) = shown {
            self.screen.present().run(&self.gpu, &mut encoder, shown, &target, size_px);
        }
        self.overlay.paint(&self.gpu, &mut encoder, &target, size_px, painted);
        self.gpu.queue.submit([encoder.finish()]);
        self.window.pre_present_notify();
        self.gpu.queue.present(surface);
    }
}
