//! A flight in a headset: the work of each frame.

mod with_panel;

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::{DQuat, DVec2, DVec3};
use openxr as xr;

use super::error::{During, HeadsetError};
use super::hands::Hands;
use super::hidden;
use super::menu::Menu;
use super::mirror::Mirror;
use super::opening::Opening;
use super::quad::Quad;
use super::session::{Headset, SessionPhase, VIEWS};
use super::show::ShowPass;
use super::stage::{Eye, Stage};
use super::styles::Styles;
use super::travel::{HandInput, Traveller};
use super::{HeadsetOptions, HeadsetWorld, OpenFn};
use crate::composite::PICTURE;
use crate::file::{interrupt, standard};
use crate::frame::{Prepared, Renderer};
use crate::gpu::pipelines::Builds;
use crate::gpu::recorder::Submits;
use crate::gpu::timer::FRAME;
use crate::ladder::{Ladder, Quality};
use crate::measure::statistics::Percentiles;
use crate::scene::view::{Clock, Lens, Rig};

/// Interval at which events are polled while nothing is drawn.
const REST: Duration = Duration::from_millis(20);
/// Longest time that the runtime may take to end a session on request.
const LONGEST_END: Duration = Duration::from_secs(10);
/// Typical height of a person's eyes above the floor.
const EYES_ABOVE_FLOOR_M: f64 = 1.6;
/// Shortest time between two rebuilds of the strokes while the head turns, in seconds: every second frame at 90 frames
/// per second. Land that comes into view has no strokes for a frame longer, at the border of the lens.
const STROKE_PAUSE_S: f64 = 2.0 / 90.0;
/// Duration of a frame, if the runtime does not give it.
const STEP_S: f64 = 1.0 / 90.0;

/// The views of both eyes as the runtime has located them, and the same eyes in the room.
type Located = ([xr::View; 2], [Eye; 2]);

/// The world, and where the room is in it.
struct Land {
    world: HeadsetWorld,
    traveller: Traveller,
}

/// State of a flight. Fields that draw on the headset's GPU are dropped before the headset.
pub(super) struct Flight {
    renderer: Renderer,
    show: ShowPass,
    mirror: Option<Mirror>,
    /// The world, until it is open.
    opening: Option<Opening>,
    land: Option<Land>,
    quad: Quad,
    hands: Hands,
    headset: Headset,
    /// The name of the world.
    name: String,
    menu: Menu,
    styles: Styles,
    quality: Quality,
    /// Allowed error of the land, in pixels, unless a measured setting has a larger one.
    lod_error_px: f64,
    ladder: Ladder,
    /// Sizes of the pictures that the runtime's images show, in pixels.
    shown_px: [[u32; 2]; 2],
    /// Number of pipelines that the first picture still needs at most, for the progress on the panel.
    most_built: usize,
    /// Tiles that the last frame lacks, and all of its tiles.
    tiles: [u64; 2],
    /// The message on the panel about an action that failed, and the time at which it disappears.
    notice: Option<(String, Instant)>,
    notice_is_new: bool,
    /// Rig of the last frame that was drawn, while frames follow each other.
    before: Option<Rig>,
    /// Views from which the pictures in the runtime's images were drawn.
    shown: Option<[xr::View; 2]>,
    shown_at: Option<xr::Time>,
    /// Display time of the first frame, the zero of time for wind.
    first_at: Option<xr::Time>,
    frames: Option<u64>,
    drawn: u64,
    began: Option<Instant>,
    times_ms: Vec<f64>,
    end: Arc<AtomicBool>,
    end_by: Option<Instant>,
}

impl Flight {
    /// Creates a flight of a headset, and begins to open its world.
    ///
    /// # Errors
    /// Fails if the style is invalid or if the runtime reports an error.
    pub(super) fn new(headset: Headset, options: HeadsetOptions, open: OpenFn) -> Result<Self, HeadsetError> {
        let styles = Styles::open(&options.style)?;
        let hands = Hands::new(headset.instance(), &headset.session)?;
        let gpu = &headset.gpu;
        tracing::debug!("GPU: {}", gpu.description());
        let mut renderer = Renderer::new(gpu)?;
        // A headset must not wait for a compiler, and each frame is one submit.
        renderer.set_builds(Builds::InBackground);
        renderer.set_antialias(options.antialias);
        renderer.set_stroke_pause_s(STROKE_PAUSE_S);
        let end = Arc::new(AtomicBool::new(false));
        let hand_input = Arc::clone(&end);
        // The session of the headset is ended before the program.
        interrupt::on_first_request(move || hand_input.store(true, Ordering::Relaxed));
        Ok(Self {
            renderer,
            show: ShowPass::new(gpu),
            mirror: Mirror::open(gpu, headset.sizes_px()[0]),
            opening: Some(Opening::start(gpu, open)?),
            land: None,
            quad: Quad::new(gpu, &headset.session)?,
            hands,
            shown_px: headset.sizes_px(),
            headset,
            name: options.name,
            menu: Menu::new(),
            styles,
            quality: options.quality,
            lod_error_px: options.lod_error_px,
            ladder: Ladder::with_fronts(options.fronts),
            most_built: 0,
            tiles: [0; 2],
            notice: None,
            notice_is_new: false,
            before: None,
            shown: None,
            shown_at: None,
            first_at: None,
            frames: options.frames,
            drawn: 0,
            began: None,
            times_ms: Vec::new(),
            end,
            end_by: None,
        })
    }

    /// Flies until the runtime or the user ends the flight, or until `--frames` frames are drawn.
    ///
    /// # Errors
    /// Fails if the session is lost, if the runtime reports an error, or if the GPU fails.
    pub(super) fn run(mut self) -> Result<(), HeadsetError> {
        loop {
            match self.headset.follow_events()? {
                SessionPhase::Ended => break,
                SessionPhase::Idle => std::thread::sleep(REST),
                SessionPhase::Running => self.frame()?,
            }
            self.end_if_due()?;
            if self.end_by.is_some_and(|by| Instant::now() > by) {
                tracing::warn!("the OpenXR runtime does not end the session");
                break;
            }
        }
        if self.frames.is_some() { self.report() } else { Ok(()) }
    }

    fn end_if_due(&mut self) -> Result<(), HeadsetError> {
        let is_done = self.frames.is_some_and(|frames| self.drawn >= frames);
        let is_closed = self.mirror.as_mut().is_some_and(Mirror::is_closed);
        if (is_done || is_closed || self.end.load(Ordering::Relaxed)) && self.end_by.is_none() {
            self.end_by = Some(Instant::now() + LONGEST_END);
            self.headset.request_end()?;
        }
        Ok(())
    }

    /// Waits for a frame, and draws it if it will be visible.
    fn frame(&mut self) -> Result<(), HeadsetError> {
        let state = self.headset.waiter.wait().during("xrWaitFrame")?;
        self.headset.stream.begin().during("xrBeginFrame")?;
        if let Some(world) = self.opening.as_mut().map(Opening::take).transpose()?.flatten() {
            self.opening = None;
            self.land = Some(Land { traveller: Traveller::new(start(&world)), world });
        }
        let display_time = state.predicted_display_time;
        let eyes = if state.should_render { self.locate(display_time)? } else { None };
        let views = match &eyes {
            Some((views, eyes)) => self.draw(display_time, *views, eyes)?,
            None => None,
        };
        if views.is_none() {
            // The next visible frame has no predecessor.
            (self.before, self.shown, self.began) = (None, None, None);
        }
        self.end_frame(display_time, views, eyes.is_some())?;
        self.headset.gpu.check()?;
        Ok(())
    }

    /// Ends a frame with the pictures of the eyes, if there are some, and with the panel, if something may be shown.
    fn end_frame(
        &mut self,
        display_time: xr::Time,
        views: Option<[xr::View; 2]>,
        is_seen: bool,
    ) -> Result<(), HeadsetError> {
        let Headset { stream, eyes, space, blend, .. } = &mut self.headset;
        let projections = views.map(|views| {
            [0, 1].map(|eye: usize| {
                // The runtime enlarges a picture of a lower resolution.
                let extent = self.shown_px[eye].map(|side| side as i32);
                let rect = xr::Rect2Di {
                    offset: xr::Offset2Di { x: 0, y: 0 },
                    extent: xr::Extent2Di { width: extent[0], height: extent[1] },
                };
                let image =
                    xr::SwapchainSubImage::new().swapchain(&eyes[eye].swapchain).image_array_index(0).image_rect(rect);
                xr::CompositionLayerProjectionView::new().pose(views[eye].pose).fov(views[eye].fov).sub_image(image)
            })
        });
        let eyes = projections.as_ref().map(|views| xr::CompositionLayerProjection::new().space(space).views(views));
        let is_seen = is_seen && (self.menu.is_open() || self.notice.is_some());
        let panel = if is_seen { self.quad.layer(space) } else { None };
        let mut layers: Vec<&xr::CompositionLayerBase<'_, xr::Vulkan>> = Vec::with_capacity(2);
        if let Some(eyes) = &eyes {
            layers.push(eyes);
        }
        // Layers that come later are in front.
        if let Some(panel) = &panel {
            layers.push(panel);
        }
        stream.end(display_time, *blend, &layers).during("xrEndFrame")
    }

    /// Returns where the eyes are when a frame is displayed, if that is known.
    fn locate(&self, time: xr::Time) -> Result<Option<Located>, HeadsetError> {
        let headset = &self.headset;
        let (flags, views) = headset.session.locate_views(VIEWS, time, &headset.space).during("xrLocateViews")?;
        let known = xr::ViewStateFlags::ORIENTATION_VALID | xr::ViewStateFlags::POSITION_VALID;
        let (true, &[left, right]) = (flags.contains(known), views.as_slice()) else {
            return Ok(None);
        };
        let (Some(left_eye), Some(right_eye)) = (eye(&left, headset.floor_m)?, eye(&right, headset.floor_m)?) else {
            return Ok(None);
        };
        Ok(Some(([left, right], [left_eye, right_eye])))
    }

    /// Draws both eyes and the panel, and hands over their images. Returns the views of the pictures, or `None` if there
    /// are none: the world is not open, or the first style is still being built.
    fn draw(
        &mut self,
        time: xr::Time,
        views: [xr::View; 2],
        eyes: &[Eye; 2],
    ) -> Result<Option<[xr::View; 2]>, HeadsetError> {
        let now = Instant::now();
        let since_s = self.shown_at.replace(time).map(|before| (time.as_nanos() - before.as_nanos()) as f64 * 1e-9);
        let step_s = since_s.filter(|step_s| *step_s > 0.0).unwrap_or(STEP_S);
        let hand_input = self.follow_hands(eyes, step_s)?;
        let views = self.draw_land(now, (time, step_s), views, eyes, &hand_input)?;
        self.draw_panel(eyes)?;
        Ok(views)
    }

    fn draw_land(
        &mut self,
        now: Instant,
        (time, step_s): (xr::Time, f64),
        views: [xr::View; 2],
        eyes: &[Eye; 2],
        hand_input: &HandInput,
    ) -> Result<Option<[xr::View; 2]>, HeadsetError> {
        let headset = &self.headset;
        let Some(Land { world, traveller }) = &mut self.land else { return Ok(None) };
        let terrain = &world.surfaces.terrain;
        let lowest_m = f64::from(terrain.range_m()[0]);
        traveller.advance(hand_input, eyes, step_s, |at| terrain.height_at_hand_m(at).unwrap_or(lowest_m));
        let now_s = (time.as_nanos() - self.first_at.get_or_insert(time).as_nanos()) as f64 * 1e-9;
        let before_s = self.before.as_ref().map_or(now_s, |before| before.clock().now_s);
        let mut chosen = Cow::Borrowed(self.styles.style());
        if world.surfaces.features().is_some() {
            chosen = Cow::Owned(chosen.into_owned().with_features(world.surfaces.has_features_and_graticule()));
        }
        let chosen = &*chosen;
        self.ladder.follow(&chosen.name, self.quality);
        let setting = self.ladder.setting().cloned().unwrap_or_default();
        let scale = setting.scale.unwrap_or(1.0).min(1.0);
        let full_px = headset.sizes_px();
        let sizes_px = full_px.map(|size_px| size_px.map(|side| scaled(side, scale)));
        let rig = traveller.stage().rig(eyes, sizes_px, self.before.as_ref());
        let rig = rig.at(Clock { now_s, before_s });
        self.renderer.set_hidden(hidden::areas(&headset.hidden, eyes, sizes_px));
        self.renderer.set_step_s(step_s);
        // Another resolution from frame to frame must not make new textures.
        let is_governed = self.ladder.is_governed();
        let room_px = [0, 1].map(|side: usize| full_px[0][side].max(full_px[1][side]));
        self.renderer.set_room(is_governed.then_some(room_px));
        self.renderer.set_submits(if is_governed { Submits::Framed } else { Submits::Whole });
        self.renderer.set_frame_tag(self.ladder.tag());
        world.surfaces.terrain.set_lod_error_px(setting.lod_error_px.unwrap_or(0.0).max(self.lod_error_px));
        world.surfaces.set_tree_detail(setting.tree_detail.unwrap_or(1.0));
        let style = &*self.ladder.applied(chosen, scale);
        let prepared = self.renderer.render_eyes(&headset.gpu, &mut world.surfaces, &rig, style, &world.light)?;
        // Poll without waiting for the GPU.
        if let Err(error) = headset.gpu.device.poll(wgpu::PollType::Poll) {
            tracing::debug!("{error}");
        }
        let Prepared { tiles, prepare_ms, .. } = prepared;
        self.tiles = [tiles.wanted.saturating_sub(tiles.pending), tiles.wanted];
        if !self.renderer.drew() {
            // The images still show the previous pictures, with their views: the runtime reprojects them to the current
            // pose of the head.
            return Ok(self.shown);
        }
        self.before = Some(rig);
        let shows = self.renderer.shows(style);
        self.govern(now_s, prepare_ms);
        if !self.show(eyes)? {
            return Ok(None);
        }
        self.shown_px = sizes_px;
        self.shown = Some(views);
        if shows {
            self.drawn += 1;
            if let Some(before) = self.began.filter(|_| self.frames.is_some()) {
                self.times_ms.push((now - before).as_secs_f64() * 1000.0);
            }
        }
        self.began = Some(now);
        Ok(self.shown)
    }

    /// Takes the times that the GPU has measured, for the setting of the next frames.
    fn govern(&mut self, now_s: f64, prepare_ms: f64) {
        let cpu = self.renderer.cpu();
        // Submitting to a software driver is the work of its passes.
        let submit_ms = if self.headset.gpu.is_software() { 0.0 } else { cpu.submit_ms };
        let cpu_ms = prepare_ms + cpu.record_ms + submit_ms;
        self.ladder.set_pressure(self.headset.pressure());
        while let Some((tag, times)) = self.renderer.take_tagged_times() {
            if let Some(frame) = times.first().filter(|time| time.name == FRAME) {
                self.ladder.record(tag, now_s, frame.gpu_ms, cpu_ms);
            }
        }
    }

    /// Copies the pictures of the eyes to the runtime's images. Returns `false` if there are no pictures.
    fn show(&mut self, eyes: &[Eye; 2]) -> Result<bool, HeadsetError> {
        let pictures = [0, 1].map(|eye| self.renderer.eye_target(eye, &PICTURE));
        let [Some(left), Some(right)] = pictures else { return Ok(false) };
        let vignette = self.land.as_ref().map_or(0.0, |land| land.traveller.vignette());
        let Headset { gpu, eyes: images, .. } = &mut self.headset;
        let mut indices = [0; 2];
        for (index, images) in indices.iter_mut().zip(images.iter_mut()) {
            *index = images.acquire()?;
        }
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("headset") });
        let mut shown = Vec::with_capacity(2);
        for (eye, picture) in [left, right].into_iter().enumerate() {
            let Some((texture, view)) = images[eye].image(indices[eye]) else { continue };
            let on = (view, images[eye].format());
            self.show.run(gpu, &mut encoder, picture, on, &eyes[eye].lens, vignette);
            shown.push(texture);
        }
        // The runtime expects an image back in the layout of an attachment.
        let as_attachments = shown.into_iter().map(|texture| wgpu::TextureTransition {
            texture,
            selector: None,
            state: wgpu::TextureUses::COLOR_TARGET,
        });
        encoder.transition_resources(std::iter::empty(), as_attachments);
        self.show.flush(gpu);
        gpu.queue.submit([encoder.finish()]);
        for images in images {
            images.release()?;
        }
        if let Some(mirror) = &mut self.mirror {
            mirror.show(left);
        }
        Ok(true)
    }

    /// Prints the frame times, for `--frames`.
    fn report(&self) -> Result<(), HeadsetError> {
        let times = Percentiles::of(self.times_ms.iter().copied());
        let [p50_ms, p95_ms] = times.map_or([f64::NAN; 2], |times| [times.p50, times.p95]);
        let [[width, height], [right_width, right_height]] = self.headset.sizes_px();
        let mut text = format!(
            "{width}x{height} and {right_width}x{right_height} {}: {} frames, frame p50 {p50_ms:.2} ms, p95 \
             {p95_ms:.2} ms, {:.1} frames per second",
            self.styles.style().name,
            self.drawn,
            1000.0 / p50_ms
        );
        if let Some(line) = self.ladder.report(1.0, self.lod_error_px) {
            text += &format!("\n  {line}");
        }
        match self.headset.slow_notices() {
            0 => {}
            1 => text += "\n  1 notice of the runtime that the GPU is too slow",
            count => text += &format!("\n  {count} notices of the runtime that the GPU is too slow"),
        }
        Ok(standard::print(&text)?)
    }
}

/// Returns the side of a picture at a scale, in pixels.
fn scaled(side: u32, scale: f64) -> u32 {
    ((f64::from(side) * scale).round() as u32).max(1)
}

/// Returns the initial stage: the camera is at eye height above the floor, and the floor is not below the ground.
fn start(world: &HeadsetWorld) -> Stage {
    let camera = &world.start;
    let mut floor_m = camera.position_m - DVec3::Z * EYES_ABOVE_FLOOR_M;
    let at: DVec2 = floor_m.truncate();
    let terrain = &world.surfaces.terrain;
    floor_m.z = floor_m.z.max(terrain.height_m(at).unwrap_or(f64::NEG_INFINITY));
    Stage { floor_m, heading_rad: camera.yaw_deg.to_radians(), scale: 1.0 }
}

/// Converts a view to an eye in the room. Returns `None` if its pose is invalid.
fn eye(view: &xr::View, floor_m: f64) -> Result<Option<Eye>, HeadsetError> {
    let xr::Fovf { angle_left: left, angle_right: right, angle_up: up, angle_down: down } = view.fov;
    let tangents = [-left, right, up, -down].map(|angle| f64::from(angle).tan());
    let straight = [left, right, up, down].into_iter().all(|angle| angle.abs() < std::f32::consts::FRAC_PI_2);
    if !straight || left >= right || down >= up {
        return Err(HeadsetError::Lens { left, right, up, down });
    }
    let lens = Lens { left: tangents[0], right: tangents[1], up: tangents[2], down: tangents[3] };
    let xr::Posef { orientation: q, position: p } = view.pose;
    let room_from_eye = DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into());
    let at_m = DVec3::new(p.x.into(), f64::from(p.y) - floor_m, p.z.into());
    let is_known = at_m.is_finite() && (0.5..2.0).contains(&room_from_eye.length());
    Ok(is_known.then(|| Eye { at_m, room_from_eye: room_from_eye.normalize(), lens }))
}

/// Flies over a world, which is opened while the session already runs.
///
/// # Errors
/// Fails as [`Flight::run`] does, and if the world cannot be opened.
pub(super) fn fly(headset: Headset, options: HeadsetOptions, open: OpenFn) -> Result<(), HeadsetError> {
    Flight::new(headset, options, open)?.run()
}
