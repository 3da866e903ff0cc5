//! A flight in a headset: what is done in each frame.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::{DQuat, DVec2, DVec3};
use openxr as xr;

use super::error::{During, HeadsetError};
use super::hands::Hands;
use super::hidden;
use super::mirror::Mirror;
use super::session::{Headset, SessionPhase, VIEWS};
use super::show::ShowPass;
use super::stage::{Eye, Stage};
use super::travel::{HandInput, Traveller};
use super::{HeadsetOptions, HeadsetWorld};
use crate::composite::PICTURE;
use crate::file::{interrupt, standard};
use crate::frame::Renderer;
use crate::gpu::Gpu;
use crate::gpu::pipelines::Builds;
use crate::measure::statistics::Percentiles;
use crate::scene::view::{Clock, Lens, Rig};
use crate::style::{self, Style};

/// Interval at which events are polled while nothing is drawn.
const REST: Duration = Duration::from_millis(20);
/// Longest time that the runtime may take to end a session on request.
const LONGEST_END: Duration = Duration::from_secs(10);
/// Typical height of a person's eyes above the floor.
const EYES_ABOVE_FLOOR_M: f64 = 1.6;
/// Duration of a frame, if the runtime does not give it.
const STEP_S: f64 = 1.0 / 90.0;

/// State of a flight. Fields that draw on the headset's GPU are dropped before the headset.
pub(super) struct Flight {
    renderer: Renderer,
    show: ShowPass,
    mirror: Option<Mirror>,
    world: HeadsetWorld,
    hands: Hands,
    headset: Headset,
    traveller: Traveller,
    styles: Vec<Style>,
    style: usize,
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
    /// Creates a flight of a headset over a world.
    ///
    /// # Errors
    /// Fails if the style is invalid or if the runtime reports an error.
    pub(super) fn new(headset: Headset, world: HeadsetWorld, options: &HeadsetOptions) -> Result<Self, HeadsetError> {
        let (styles, style) = styles(&options.style)?;
        let hands = Hands::new(headset.instance(), &headset.session)?;
        let gpu = &headset.gpu;
        let mut renderer = Renderer::new(gpu)?;
        // A headset must not wait for a compiler, and each frame is one submit.
        renderer.set_builds(Builds::InBackground);
        renderer.set_antialias(options.antialias);
        let start = start(&world, &headset);
        let end = Arc::new(AtomicBool::new(false));
        let hand_input = Arc::clone(&end);
        // The session of the headset is ended before the program.
        interrupt::on_first_request(move || hand_input.store(true, Ordering::Relaxed));
        Ok(Self {
            renderer,
            show: ShowPass::new(gpu),
            mirror: Mirror::open(gpu, headset.sizes_px()[0]),
            world,
            hands,
            headset,
            traveller: Traveller::new(start),
            styles,
            style,
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
        let display_time = state.predicted_display_time;
        let views = if state.should_render { self.draw(&state)? } else { None };
        if views.is_none() {
            // The next visible frame has no predecessor.
            (self.before, self.shown, self.began) = (None, None, None);
        }
        self.end_frame(display_time, views)?;
        self.headset.gpu.check()?;
        Ok(())
    }

    fn end_frame(&mut self, display_time: xr::Time, views: Option<[xr::View; 2]>) -> Result<(), HeadsetError> {
        let Headset { stream, eyes, space, blend, .. } = &mut self.headset;
        let Some(views) = views else {
            return stream.end(display_time, *blend, &[]).during("xrEndFrame");
        };
        let projections = [0, 1].map(|eye: usize| {
            let extent = eyes[eye].size_px().map(|side| side as i32);
            let rect = xr::Rect2Di {
                offset: xr::Offset2Di { x: 0, y: 0 },
                extent: xr::Extent2Di { width: extent[0], height: extent[1] },
            };
            let image =
                xr::SwapchainSubImage::new().swapchain(&eyes[eye].swapchain).image_array_index(0).image_rect(rect);
            xr::CompositionLayerProjectionView::new().pose(views[eye].pose).fov(views[eye].fov).sub_image(image)
        });
        let layer = xr::CompositionLayerProjection::new().space(space).views(&projections);
        stream.end(display_time, *blend, &[&layer]).during("xrEndFrame")
    }

    /// Draws both eyes and hands over their images. Returns `None` if there is nothing to show: the head's pose is
    /// unknown, or the first style is still being built.
    fn draw(&mut self, state: &xr::FrameState) -> Result<Option<[xr::View; 2]>, HeadsetError> {
        let now = Instant::now();
        let headset = &self.headset;
        let hand_input = if headset.is_focused() { self.hands.read(&headset.session)? } else { HandInput::default() };
        let time = state.predicted_display_time;
        let (flags, views) = headset.session.locate_views(VIEWS, time, &headset.space).during("xrLocateViews")?;
        let known = xr::ViewStateFlags::ORIENTATION_VALID | xr::ViewStateFlags::POSITION_VALID;
        let (true, &[left, right]) = (flags.contains(known), views.as_slice()) else {
            return Ok(None);
        };
        let views = [left, right];
        let [left, right] = [eye(&left, headset.floor_m)?, eye(&right, headset.floor_m)?];
        let (Some(left), Some(right)) = (left, right) else { return Ok(None) };
        let eyes = [left, right];

        let since_s = self.shown_at.replace(time).map(|before| (time.as_nanos() - before.as_nanos()) as f64 * 1e-9);
        let step_s = since_s.filter(|step_s| *step_s > 0.0).unwrap_or(STEP_S);
        let terrain = &self.world.surfaces.terrain;
        let lowest_m = f64::from(terrain.range_m()[0]);
        self.traveller.advance(&hand_input, &eyes, step_s, |at| terrain.height_at_hand_m(at).unwrap_or(lowest_m));
        if hand_input.next_style {
            self.style = (self.style + 1) % self.styles.len();
            tracing::info!("style: {}", self.styles[self.style].name);
        }
        let now_s = (time.as_nanos() - self.first_at.get_or_insert(time).as_nanos()) as f64 * 1e-9;
        let before_s = self.before.as_ref().map_or(now_s, |before| before.clock().now_s);
        let rig = self.traveller.stage().rig(&eyes, headset.sizes_px(), self.before.as_ref());
        let rig = rig.at(Clock { now_s, before_s });
        self.renderer.set_hidden(hidden::areas(&headset.hidden, &eyes, headset.sizes_px()));
        self.renderer.set_step_s(step_s);
        let style = &self.styles[self.style];
        self.renderer.render_eyes(&headset.gpu, &mut self.world.surfaces, &rig, style, &self.world.light)?;
        // Poll without waiting for the GPU.
        if let Err(error) = headset.gpu.device.poll(wgpu::PollType::Poll) {
            tracing::debug!("{error}");
        }
        // Discard the GPU's times, which would otherwise accumulate.
        while self.renderer.take_times().is_some() {}
        if !self.renderer.drew() {
            // The images still show the previous pictures, with their views: the runtime reprojects them to the present
            // pose of the head.
            return Ok(self.shown);
        }
        self.before = Some(rig);
        if !self.show(&eyes)? {
            return Ok(None);
        }
        self.shown = Some(views);
        if self.renderer.shows(&self.styles[self.style]) {
            self.drawn += 1;
            if let Some(before) = self.began.filter(|_| self.frames.is_some()) {
                self.times_ms.push((now - before).as_secs_f64() * 1000.0);
            }
        }
        self.began = Some(now);
        Ok(self.shown)
    }

    /// Copies the pictures of the eyes to the runtime's images. Returns `false` if there are no pictures.
    fn show(&mut self, eyes: &[Eye; 2]) -> Result<bool, HeadsetError> {
        let pictures = [0, 1].map(|eye| self.renderer.eye_target(eye, &PICTURE));
        let [Some(left), Some(right)] = pictures else { return Ok(false) };
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
            self.show.run(gpu, &mut encoder, picture, on, &eyes[eye].lens, self.traveller.vignette());
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
        let text = format!(
            "{width}x{height} and {right_width}x{right_height} {}: {} frames, frame p50 {p50_ms:.2} ms, p95 \
             {p95_ms:.2} ms, {:.1} frames per second",
            self.styles[self.style].name,
            self.drawn,
            1000.0 / p50_ms
        );
        Ok(standard::print(&text)?)
    }
}

/// Loads the presets and the style `hand_input`; also returns its index in the list.
fn styles(hand_input: &str) -> Result<(Vec<Style>, usize), HeadsetError> {
    let names = style::names();
    let mut list = names.iter().map(|name| Style::load(name)).collect::<Result<Vec<_>, _>>()?;
    let place = names.iter().position(|name| *name == hand_input);
    let place = match place {
        Some(place) => place,
        None => {
            list.push(Style::load(hand_input)?);
            list.len() - 1
        }
    };
    Ok((list, place))
}

/// Returns the initial stage: the camera is at eye height above the floor, and the floor is not below the ground.
fn start(world: &HeadsetWorld, headset: &Headset) -> Stage {
    let camera = &world.start;
    let mut floor_m = camera.position_m - DVec3::Z * EYES_ABOVE_FLOOR_M;
    let at: DVec2 = floor_m.truncate();
    let terrain = &world.surfaces.terrain;
    floor_m.z = floor_m.z.max(terrain.height_m(at).unwrap_or(f64::NEG_INFINITY));
    tracing::debug!("GPU: {}", headset.gpu.description());
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

/// Opens the world and flies.
///
/// # Errors
/// Fails as [`Flight::run`] does, and if the world cannot be opened.
pub(super) fn fly(
    headset: Headset,
    options: &HeadsetOptions,
    open: impl FnOnce(&Gpu) -> anyhow::Result<HeadsetWorld>,
) -> Result<(), HeadsetError> {
    let world = open(&headset.gpu).map_err(HeadsetError::World)?;
    Flight::new(headset, world, options)?.run()
}
