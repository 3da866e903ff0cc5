//! A flight: its state between two frames, and how a frame is drawn.
//!
//! The picture is rendered only if it would change; the panel alone is painted over the last picture. When neither
//! changes, nothing runs until the next event.
//!
//! Why: `docs/decisions/window-frames.md`.

mod begin;
mod compare;
mod controls;
mod edits;
mod exports;
mod gallery;
mod history;
mod labels;
mod land;
mod layer_picking;
mod navigate;
mod panels;
mod paths;
mod picture;
mod spares;
mod viewer;
mod worlds;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::event::WindowEvent;
use winit::event_loop::EventLoopProxy;
use winit::window::Window;

use self::compare::Compared;
use self::controls::TOAST;
use self::layer_picking::LayerPicking;
use self::navigate::Navigation;
use self::paths::Paths;
use self::spares::Spares;
use super::browse::Browser;
use super::camera_history::CameraHistory;
use super::cost::Traffic;
use super::dock::Dock;
use super::export::ExportDialog;
use super::export::run::Run;
use super::fly_camera::FlyCamera;
use super::gallery::Gallery;
use super::gallery::thumbnails::Thumbnails;
use super::help::KeysWindow;
use super::input::Input;
use super::inspector::Inspector;
use super::labels::Labels;
use super::land_panel::LandPanel;
use super::light::LightPanel;
use super::open_dialog::OpenDialog;
use super::other_world::OtherWorld;
use super::overlay::Overlay;
use super::path_flight::Reading;
use super::picture_viewer::PictureViewer;
use super::pictures::Pictures;
use super::questions::Questions;
use super::remembered::Remembered;
use super::reopening::Reopening;
use super::scene_history::SceneHistory;
use super::screen::{Acquired, Screen};
use super::settings::{Settings, Styles};
use super::statistics::{FrameTimes, PassTimes};
use super::toasts::Toasts;
use super::{FlightWorld, WindowError, works};
use crate::file::{FileError, standard};
use crate::frame::{Light, Renderer};
use crate::gpu::Gpu;
use crate::gpu::device::AdapterWish;
use crate::gpu::timer::FRAME;
use crate::ladder::Ladder;
use crate::lines::strokes::AsyncStrokeNumbers;
use crate::scene::SceneFocus;
use crate::scene::reach::Reach;
use crate::scene::stereo::Pair;
use crate::scene::view::Pose;
use crate::studio::favourites::Favourites;
use crate::studio::folder::StyleSearch;
use crate::studio::recent::Recent;
use crate::studio::unsaved::Unsaved;
use crate::studio::watch::FileWatch;
use crate::style::Style;
use crate::tiles::terrain::Prepared;

/// Duration of the first step after a rest.
const FIRST_STEP_S: f64 = 1.0 / 60.0;
/// Delay after the last picture until the panel is painted once more: GPU times arrive late.
const PANEL_REPAINT: Duration = Duration::from_millis(150);

/// The next step of the program after an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Draw a frame.
    Frame,
    /// Wait for the next event.
    Sleep,
    /// End the program.
    Quit,
}

/// A flight over a world in a window.
pub(super) struct Flight {
    // Fields are dropped in this order: objects that the GPU created are dropped before it.
    pictures: Pictures,
    thumbnails: Thumbnails,
    overlay: Overlay,
    screen: Screen,
    renderer: Option<Renderer>,
    /// The renderer of another land, whose picture is shown until the first one of this land is drawn.
    previous_renderer: Option<Renderer>,
    world: FlightWorld,
    /// The world that is being opened.
    world_being_opened: Option<OtherWorld>,
    gpu: Gpu,
    window: Arc<Window>,
    adapter: String,
    input: Input,
    camera: FlyCamera,
    start: FlyCamera,
    camera_history: CameraHistory,
    navigation: Navigation,
    layer_picking: LayerPicking,
    labels: Labels,
    light_panel: LightPanel,
    land_panel: LandPanel,
    /// The land with another exaggeration or other trees, while it is being read.
    land_being_read: Option<Reopening>,
    /// The camera path that is being read.
    path_being_read: Option<Reading>,
    paths: Paths,
    /// The camera path that is read when the world has been opened.
    path_of_opening: Option<String>,
    open_dialog: OpenDialog,
    export_dialog: ExportDialog,
    keys_window: KeysWindow,
    /// The exports that run.
    exports: Vec<Run>,
    /// The messages of exports that have ended, until the user dismisses them.
    ended: works::EndedWorks,
    /// The edited values of a style, by the style and its revision.
    set_values: Option<exports::KnownValues>,
    /// The requested GPU.
    adapter_choice: AdapterWish,
    browser: Browser,
    recent: Recent,
    /// Keys that were pressed after a click that the panels have not seen yet, and the events after them.
    delayed: Vec<WindowEvent>,
    /// Files that were dropped since the last frame.
    dropped: Vec<PathBuf>,
    /// The files that a scene may name.
    reach: Reach,
    /// Wakes the event loop from other threads.
    proxy: EventLoopProxy<()>,
    settings: Settings,
    /// The settings between which the quality chooses.
    ladder: Ladder,
    /// Since when pictures are of the same view, style and settings, while a budget is held.
    still_since: Option<Instant>,
    scene_history: SceneHistory,
    styles: Styles,
    frame_times: FrameTimes,
    pass_times: PassTimes,
    stroke_numbers: AsyncStrokeNumbers,
    last: LastPicture,
    /// Whether the distance between the eyes is still adapting to the nearest land.
    eyes_move: bool,
    dock: Dock,
    inspector: Inspector,
    viewer: PictureViewer,
    /// The memory traffic of the passes of the last frame, while it is shown.
    traffic: Traffic,
    remembered: Remembered,
    /// Whether the sentences of the first start are shown.
    welcomes: bool,
    gallery: Gallery,
    favourites: Favourites,
    /// The search for the style files of a folder, while the gallery is open.
    style_search: Option<StyleSearch>,
    /// The style that was chosen before the current one.
    previous_style: usize,
    /// The style that is drawn instead of the chosen one, while a key is held.
    compared: Option<Style>,
    /// The divider between two styles, and the left one.
    divided: Option<Compared>,
    questions: Questions,
    unsaved: Unsaved,
    watch: Option<FileWatch>,
    /// The files that are watched.
    watched: Vec<PathBuf>,
    /// Errors in files of styles that have changed, by the index of the style.
    file_errors: BTreeMap<usize, String>,
    /// The styles whose edits of an earlier run have been looked for.
    unsaved_offered: BTreeSet<usize>,
    /// Whether the panels must be laid out again in another frame: something has changed since this frame laid them out.
    needs_relayout: bool,
    /// Whether the user has been warned of edits that are not saved, and wants to leave.
    has_warned_of_leaving: bool,
    toasts: Toasts,
    escape_until: Option<Instant>,
    hidden: bool,
    /// Whether the picture on the screen is out of date.
    stale: bool,
    /// Start of the previous frame, while frames follow each other.
    animating_since: Option<Instant>,
    panel_repaint_at: Option<Instant>,
    next_gamepads: Instant,
    next_built: Instant,
    next_shaders: Instant,
    spares: Spares,
    frames_left: Option<u64>,
    /// Start of the flight, the zero of time for wind.
    begun: Instant,
}

/// Facts about the picture on the screen.
struct LastPicture {
    pose: Pose,
    /// Time since the flight began.
    time_s: f64,
    /// The stereo pair.
    pair: Pair,
    prepared: Prepared,
    tiles_loaded: u64,
    /// The chosen style, and the variant of it that the quality requires; `None` if that is the same.
    style: Option<(Style, Style)>,
    /// The chosen style and the settings, while a budget is held.
    seen: Option<(Style, Settings)>,
    /// Size of the picture of an eye, in pixels.
    picture_px: [u32; 2],
}

impl Flight {
    /// Requests a frame from the window system.
    pub(super) fn request_redraw(&self) {
        self.window.request_redraw();
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// Fails if the GPU fails.
    pub(super) fn draw(&mut self) -> Result<Next, WindowError> {
        let surface = match self.screen.acquire(&self.gpu)? {
            Acquired::Frame(surface) => surface,
            Acquired::Soon => return Ok(if self.hidden { Next::Sleep } else { Next::Frame }),
            Acquired::Hidden => {
                self.animating_since = None;
                return Ok(Next::Sleep);
            }
        };
        let now = Instant::now();
        let since = self.animating_since.replace(now);
        let step_s = since.map_or(FIRST_STEP_S, |since| (now - since).as_secs_f64());
        let deg_per_px = self.camera.fov_deg / f64::from(self.screen.size_px()[1]);
        let input = self.input.take(deg_per_px, now, step_s);
        self.tidy(now);
        self.open_dropped();
        let drags = self.drag();
        let moves = self.camera.advance(&input, step_s, |at| ground_m(&self.world, at));
        self.stale |= drags | moves | self.follow_path(now, drags | moves);
        self.compare(self.input.compares());
        let painted = self.lay_panels_out()?;
        self.note_scene();
        if self.act_on_delayed()? == Next::Quit {
            return Ok(Next::Quit);
        }
        let rendered = self.stale || self.frames_left.is_some();
        if rendered {
            self.render_picture(step_s)?;
            if let Some(since) = since.filter(|_| self.shows_chosen_style()) {
                self.frame_times.push((now - since).as_secs_f64() * 1000.0);
            }
        }
        self.present(surface, painted);
        self.request_place();
        self.request_labels();
        self.request_picked_layer();
        self.request_viewed_picture();
        self.gpu.check()?;
        let shows_chosen_style = self.shows_chosen_style();
        if let Some(frames) = self.frames_left.as_mut().filter(|_| shows_chosen_style) {
            *frames = frames.saturating_sub(1);
            if *frames == 0 {
                self.report()?;
                return Ok(Next::Quit);
            }
        }

        // New tiles improve the next picture, strokes fade in and out over several frames, and trees sway.
        let is_settling = self.renderer.as_ref().is_some_and(|renderer| renderer.is_settling() || renderer.may_sway())
            || self.divided.as_ref().is_some_and(Compared::is_settling);
        self.stale = rendered
            && (self.last.prepared.tiles.loaded > 0
                || self.last.prepared.tiles.late
                || is_settling
                || self.eyes_move
                || self.ladder.waits_for_rest());
        let is_still = input.is_still()
            && !self.input.flies()
            && self.camera.is_still()
            && !self.paths.player.is_playing()
            && self.frames_left.is_none();
        self.note_view(is_still);
        let flows = !is_still || self.stale;
        self.panel_repaint_at = (rendered && !flows).then_some(now + PANEL_REPAINT);
        if !flows {
            self.animating_since = None;
        }
        let repaint = self.overlay.repaint_at().is_some_and(|at| at <= Instant::now())
            || std::mem::take(&mut self.needs_relayout)
            || self.labels_settle();
        // A shader may fail when it is first used.
        let has_news = self.update_lasting_messages() | self.fill_gallery(is_still)?;
        Ok(if flows || repaint || has_news { Next::Frame } else { Next::Sleep })
    }

    /// Returns whether the picture shows the chosen style: the previous picture stays until everything for the new one
    /// is built.
    fn shows_chosen_style(&self) -> bool {
        self.renderer.as_ref().is_some_and(|renderer| match &self.last.style {
            Some((chosen, drawn)) => chosen == self.style() && renderer.shows(drawn),
            None => renderer.shows(self.style()),
        })
    }

    fn style(&self) -> &Style {
        self.compared.as_ref().unwrap_or(&self.styles.list()[self.settings.style])
    }

    fn light(&self) -> Light {
        let mut light = self.world.light;
        light.to_sun = self.settings.sun.direction();
        light.haze_m = self.settings.haze_m;
        light.focus = self.settings.focus.as_ref().map(SceneFocus::focus);
        light
    }

    /// Removes expired messages, reloads shaders, and collects the times that the GPU measured.
    fn tidy(&mut self, now: Instant) {
        self.toasts.tidy(now);
        self.look_after_shaders(now);
        // Poll without waiting for the GPU.
        if let Err(error) = self.gpu.device.poll(wgpu::PollType::Poll) {
            tracing::debug!("{error}");
        }
        self.take_place();
        self.follow_labels();
        self.take_picked_layer(now);
        self.take_viewed_picture();
        let cpu = self.renderer.as_ref().map(Renderer::cpu).unwrap_or_default();
        // Submitting to a software driver is the work of its passes.
        let submit_ms = if self.gpu.is_software() { 0.0 } else { cpu.submit_ms };
        let cpu_ms = self.last.prepared.prepare_ms + cpu.record_ms + submit_ms;
        let now_s = (now - self.begun).as_secs_f64();
        while let Some((tag, times)) = self.renderer.as_mut().and_then(Renderer::take_tagged_times) {
            if let Some(frame) = times.first().filter(|time| time.name == FRAME) {
                self.stale |= self.ladder.record(tag, now_s, frame.gpu_ms, cpu_ms);
            }
            if times.len() > 1 {
                self.pass_times.add(times);
            }
        }
    }

    /// Prints the frame times, for `--frames`.
    fn report(&self) -> Result<(), FileError> {
        let [p50_ms, p95_ms] = [0.5, 0.95].map(|part| self.frame_times.quantile_ms(part).unwrap_or(f64::NAN));
        let [width, height] = self.last.picture_px;
        let mut text = format!(
            "{width}x{height} {}: frame p50 {p50_ms:.2} ms, p95 {p95_ms:.2} ms, {:.1} frames per second",
            self.style().name,
            1000.0 / p50_ms
        );
        for pass in self.pass_times.passes() {
            text += &format!("\n  {}: {:.3} ms", pass.name, pass.gpu_ms);
        }
        if let Some(line) = self.ladder.report(self.settings.scale(), self.settings.lod_error_px) {
            text += &format!("\n  {line}");
        }
        standard::print(&text)
    }
}

/// Returns the height of the ground in metres from tiles in memory, since a frame must not wait for a file. In holes
/// and outside of the land, it is the lowest height.
fn ground_m(world: &FlightWorld, at: glam::DVec2) -> f64 {
    world.surfaces.terrain.height_at_hand_m(at).unwrap_or_else(|| f64::from(world.surfaces.terrain.range_m()[0]))
}
