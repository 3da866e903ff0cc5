//! A flight: its state between two frames, and how a frame is drawn.
//!
//! The picture is rendered only if it would change; the panel alone is painted over the last picture. When neither
//! changes, nothing runs until the next event.
//!
//! Why: `docs/decisions/window-frames.md`.

mod compare;
mod controls;
mod edits;
mod exports;
mod gallery;
mod land;
mod layer_picking;
mod navigate;
mod paths;
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
use super::browse::Browser;
use super::cost::{self, CostStats, Traffic};
use super::dock::{Dock, Pane};
use super::export::run::Run;
use super::export::{self, ExportDialog};
use super::fly_camera::{FlyCamera, FlyInput};
use super::gallery::Gallery;
use super::gallery::thumbnails::Thumbnails;
use super::input::Input;
use super::inspector::{Inspector, Shown as InspectorShown};
use super::land_panel::LandPanel;
use super::light::LightPanel;
use super::open_dialog::OpenDialog;
use super::opening::{self, Parts};
use super::other_world::OtherWorld;
use super::overlay::{Overlay, Painted};
use super::panel::{self, PanelStats};
use super::path_flight::Reading;
use super::picture_viewer::PictureViewer;
use super::pictures::Pictures;
use super::places::Places;
use super::questions::Questions;
use super::remembered::Remembered;
use super::reopening::Reopening;
use super::screen::{Acquired, Screen};
use super::settings::{Settings, Styles};
use super::statistics::{FrameTimes, PassTimes};
use super::status;
use super::toasts::{self, About, Toasts};
use super::welcome;
use super::{FlightOptions, FlightWorld, WindowError, works};
use crate::composite::PICTURE;
use crate::composite::present::Shown;
use crate::file::{FileError, standard};
use crate::frame::{Light, Renderer};
use crate::gpu::Gpu;
use crate::gpu::device::AdapterWish;
use crate::gpu::pipelines::Builds;
use crate::gpu::recorder::Submits;
use crate::lines::strokes::AsyncStrokeNumbers;
use crate::scene::SceneFocus;
use crate::scene::anaglyph::Glasses;
use crate::scene::reach::Reach;
use crate::scene::stereo::{Eyes, Pair};
use crate::scene::view::{Clock, Pose, View};
use crate::source::EarthPlace;
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
    // Fields are dropped in this order: what was created by the GPU is dropped before it.
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
    navigation: Navigation,
    layer_picking: LayerPicking,
    light_panel: LightPanel,
    land_panel: LandPanel,
    /// The land with another exaggeration or other trees, while it is being read.
    land_being_read: Option<Reopening>,
    /// The camera path that is being read.
    path_being_read: Option<Reading>,
    paths: Paths,
    /// The camera path that is read when the world that is being opened is there.
    path_of_opening: Option<String>,
    open_dialog: OpenDialog,
    export_dialog: ExportDialog,
    /// The exports that run.
    exports: Vec<Run>,
    /// The messages of exports that have ended, until the user dismisses them.
    ended: works::EndedWorks,
    /// The edited values of a style, by the style and its revision.
    set_values: Option<exports::KnownValues>,
    /// The GPU that was asked for.
    adapter_choice: AdapterWish,
    browser: Browser,
    recent: Recent,
    /// Keys that were pressed after a click that the panels have not seen yet, and what came after them.
    delayed: Vec<WindowEvent>,
    /// Files that were dropped since the last frame.
    dropped: Vec<PathBuf>,
    /// Which files a scene may name.
    reach: Reach,
    /// Wakes the event loop from other threads.
    proxy: EventLoopProxy<()>,
    settings: Settings,
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
    /// The style that was chosen before the present one.
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
    /// How many styles of the list have had their pipelines requested before anybody chose them.
    prewarmed_styles: usize,
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
}

impl Flight {
    /// Begins a flight over a world in a window.
    ///
    /// # Errors
    /// Returns a [`WindowError`] if the style is invalid.
    pub(super) fn new(
        parts: Parts,
        world: FlightWorld,
        options: &FlightOptions,
        proxy: EventLoopProxy<()>,
    ) -> Result<Self, WindowError> {
        let Parts { overlay, screen, gpu, window } = parts;
        let (styles, style) = Styles::with(&options.style)?;
        let start = FlyCamera::new(&world.start, |at| ground_m(&world, at), world.surfaces.terrain.extent_m());
        let settings = Settings {
            style,
            scale: 0,
            antialias: options.antialias,
            lod_error_px: world.surfaces.terrain.options().lod_error_px,
            sun: world.sun,
            haze_m: world.light.haze_m,
            exaggeration: world.surfaces.exaggeration(),
            sea_level_m: world.scene.sea_level_m,
            tree_seed: world.tree_seed(),
            world_seed: world.scene.world.seed(),
            focus: world.scene.focus,
            eyes: options.eyes,
            pair: options.pair,
            follows_land: options.follows_land,
        };
        let store = world.surfaces.terrain.store();
        let size = store.levels()[0];
        let earth = EarthPlace::of_grid(store.georeference(), size.width, size.height);
        let (pose, pair, prepared) = (start.pose(), options.pair, Prepared::default());
        let last = LastPicture { pose, time_s: 0.0, pair, prepared, tiles_loaded: 0 };
        window.set_title(&format!("{} — hachure", world.name));
        // An event loop that has ended needs no waking.
        let [of_pictures, of_files] = [proxy.clone(), proxy.clone()];
        let watch = FileWatch::start(move || _ = of_files.send_event(()));
        let mut flight = Self {
            pictures: Pictures::start(move || _ = of_pictures.send_event(())),
            thumbnails: Thumbnails::default(),
            overlay,
            screen,
            renderer: None,
            previous_renderer: None,
            world_being_opened: None,
            path_being_read: None,
            paths: Paths::of_world(&world),
            path_of_opening: None,
            open_dialog: OpenDialog::default(),
            export_dialog: ExportDialog::default(),
            exports: Vec::new(),
            ended: works::EndedWorks::default(),
            set_values: None,
            adapter_choice: options.adapter.clone(),
            browser: Browser::default(),
            recent: Recent::open(),
            delayed: Vec::new(),
            dropped: Vec::new(),
            reach: options.reach,
            adapter: gpu.description(),
            input: Input::new(),
            camera: start.clone(),
            start,
            light_panel: LightPanel::new(earth),
            land_panel: world.land_panel(),
            land_being_read: None,
            proxy: proxy.clone(),
            navigation: Navigation::new(Places::of(&world.surfaces.terrain)),
            layer_picking: LayerPicking::new(),
            settings,
            styles,
            frame_times: FrameTimes::default(),
            pass_times: PassTimes::default(),
            stroke_numbers: AsyncStrokeNumbers::default(),
            last,
            eyes_move: false,
            dock: options.remembered.panels.as_deref().and_then(Dock::of_text).unwrap_or_default(),
            inspector: Inspector::default(),
            viewer: PictureViewer::new(),
            traffic: Traffic::default(),
            welcomes: !options.remembered.is_welcomed && options.frames.is_none(),
            remembered: options.remembered.clone(),
            gallery: Gallery::default(),
            favourites: Favourites::open(),
            style_search: None,
            previous_style: style,
            compared: None,
            divided: None,
            questions: Questions::default(),
            unsaved: Unsaved::open(),
            watch,
            watched: Vec::new(),
            file_errors: BTreeMap::new(),
            unsaved_offered: BTreeSet::new(),
            needs_relayout: false,
            has_warned_of_leaving: false,
            toasts: Toasts::default(),
            escape_until: None,
            hidden: false,
            stale: true,
            animating_since: None,
            panel_repaint_at: None,
            next_gamepads: Instant::now(),
            next_built: Instant::now(),
            next_shaders: Instant::now(),
            prewarmed_styles: 0,
            frames_left: options.frames,
            begun: Instant::now(),
            world,
            gpu,
            window,
        };
        flight.open_document();
        flight.find_kept_path();
        if let Some(name) = flight.world.world.clone().filter(|_| options.frames.is_none()) {
            flight.note_opened(&name);
        }
        if let Some(path) = &options.path {
            flight.open_path(path);
        }
        Ok(flight)
    }

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
        let painted = self.lay_panel_out()?;
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
            && (self.last.prepared.tiles.loaded > 0 || self.last.prepared.tiles.late || is_settling || self.eyes_move);
        let is_still = input.is_still()
            && !self.input.flies()
            && self.camera.is_still()
            && !self.paths.player.is_playing()
            && self.frames_left.is_none();
        let flows = !is_still || self.stale;
        self.panel_repaint_at = (rendered && !flows).then_some(now + PANEL_REPAINT);
        if !flows {
            self.animating_since = None;
        }
        let repaint = self.overlay.repaint_at().is_some_and(|at| at <= Instant::now())
            || std::mem::take(&mut self.needs_relayout);
        // A shader may fail when it is first used.
        let has_news = self.update_lasting_messages() | self.fill_gallery(is_still)?;
        Ok(if flows || repaint || has_news { Next::Frame } else { Next::Sleep })
    }

    /// Returns whether the picture shows the chosen style: the previous picture stays until everything for the new one
    /// is built.
    fn shows_chosen_style(&self) -> bool {
        self.renderer.as_ref().is_some_and(|renderer| renderer.shows(self.style()))
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
        self.take_picked_layer(now);
        self.take_viewed_picture();
        while let Some(times) = self.renderer.as_mut().and_then(Renderer::take_times) {
            self.pass_times.add(times);
        }
    }

    /// Lays out the panel and carries out what its buttons request.
    fn lay_panel_out(&mut self) -> Result<Painted, WindowError> {
        let has_picture = self.previous_renderer.is_some()
            || self.renderer.as_ref().is_some_and(|renderer| renderer.target(&PICTURE).is_some());
        let view = self.export_dialog.is_open().then(|| self.shown_view());
        let panels = [Pane::Style, Pane::Inside, Pane::Cost, Pane::Path].map(|pane| (pane, self.dock.is_shown(pane)));
        let prepared = &self.last.prepared;
        let terrain = &self.world.surfaces.terrain;
        let position_m = self.camera.position_m;
        let stats = PanelStats {
            adapter: &self.adapter,
            picture_px: self.settings.picture_px(self.screen.size_px()),
            frame_times: &self.frame_times,
            pass_times: &self.pass_times,
            triangles: prepared.selection.triangles(),
            patches: prepared.selection.leaves.len() as u64,
            strokes: self.stroke_numbers.last(),
            tiles_on_gpu: terrain.tile_counts().on_gpu,
            tiles_loaded: self.last.tiles_loaded,
            tiles_missing: prepared.tiles.pending + prepared.tiles.without_room + prepared.tiles.failed,
            over_memory_px: (prepared.detail.memory_factor > 1.0)
                .then_some(self.settings.lod_error_px * prepared.detail.memory_factor),
            over_budget_px: prepared.detail.is_over_budget.then_some(prepared.detail.error_px),
            gpu_bytes: self.gpu.memory_bytes(),
            height_above_ground_m: position_m.z - ground_m(&self.world, position_m.truncate()),
            is_preparing: has_picture && !self.shows_chosen_style(),
            panels: &panels,
        };
        let renderer = self.renderer.as_ref();
        let cost = CostStats {
            traffic: &self.traffic,
            picture_bytes: renderer.map_or(0, Renderer::target_bytes),
            cpu_ms: [prepared.prepare_ms, renderer.map_or(0.0, Renderer::record_ms)],
        };
        let entries = if self.dock.is_shown(Pane::Inside) { self.viewer_entries() } else { Vec::new() };
        let (settings_before, camera_before) = (self.settings.clone(), self.camera.clone());
        let mut requests = panel::PanelRequests::default();
        let mut inspected = InspectorShown::default();
        let mut answer = None;
        let mut typed = None;
        let (words, projection) = self.navigation.words(self.world.surfaces.exaggeration());
        let (words, projection) =
            (if self.dock.is_shown(Pane::Flight) { words } else { Vec::new() }, projection.map(str::to_owned));
        let mut choices = Vec::new();
        let (mut opens, mut cancelled) = (None, None);
        let exports = self.exports.iter().map(|run| &*run.work);
        let works: Vec<&works::Work> =
            self.world_being_opened.iter().map(|opening| &*opening.work).chain(exports).collect();
        let window_px = self.settings.eye_px(self.screen.size_px());
        let mut divided = self.divided.as_ref().map(|divided| (divided.divider, divided.is_ready()));
        let mut exported = None;
        let mut path_requests = Vec::new();
        let mut is_welcomed = false;
        let painted = self.overlay.run(&self.window, |ui| {
            let context = &ui.ctx().clone();
            if !has_picture {
                opening::sign(context, "Preparing the first picture…");
            }
            self.viewer.paint(context);
            self.dock.show(ui, &mut |ui, pane| match pane {
                Pane::View => {}
                Pane::Flight => {
                    let (settings, camera) = (&mut self.settings, &mut self.camera);
                    let light_and_land = (&mut self.light_panel, &mut self.land_panel);
                    requests = panel::show(ui, &stats, &self.styles, settings, camera, light_and_land);
                }
                Pane::Style => {
                    if let Some(document) = self.styles.document(settings_before.style) {
                        inspected = self.inspector.show(ui, document);
                    }
                }
                Pane::Inside => self.viewer.show(ui, &entries),
                Pane::Cost => cost::show(ui, &stats, &cost),
                Pane::Path => {
                    let (shown, panel) = self.paths.shown();
                    path_requests.extend(panel.show(ui, &shown));
                }
            });
            let window = context.content_rect();
            let free = self.dock.free(window);
            if let Some((divider, is_ready)) = &mut divided
                && !divider.show(context, free, &self.styles, settings_before.style, *is_ready)
            {
                divided = None;
            }
            if self.gallery.is_open {
                self.gallery.inspector_width = window.right() - free.right();
                let (styles, thumbnails) = (&self.styles, &self.thumbnails);
                choices = self.gallery.show(context, styles, &self.favourites, thumbnails, settings_before.style);
            }
            opens = self.open_dialog.show(context).or(opens.take());
            if let Some((view, refusal)) = &view {
                let shown = export::Shown { view, refusal: *refusal, window_px };
                exported = self.export_dialog.show(context, &shown).or(exported.take());
            }
            cancelled = works::show(context, works.iter().copied(), &self.ended).or(cancelled);
            answer = self.questions.show(context).or(answer.take());
            let go_to = &mut self.navigation.go_to;
            typed = status::show(context, free, &words, projection.as_deref(), go_to).or(typed.take());
            let left = egui::Rect::from_min_max(window.min, egui::pos2(free.left(), window.bottom()));
            let right = egui::Rect::from_min_max(egui::pos2(free.right(), window.top()), window.max);
            let covers = |side: &egui::Rect| side.width() > 0.0;
            toasts::show(context, &self.toasts, Some(left).filter(covers), Some(right).filter(covers), free.bottom());
            is_welcomed |= self.welcomes && welcome::show(context);
        });
        self.overlay.set_docked(self.dock.rects());
        if is_welcomed {
            self.end_welcome();
        }
        self.follow_divider(divided.map(|(divider, _)| divider));
        self.apply(inspected.edits, settings_before.style);
        if let Some((question, is_taken)) = answer {
            self.answer(question, is_taken);
        }
        self.choose(choices);
        match cancelled {
            Some(works::Request::Cancel(row)) => self.on_cancel(row),
            Some(works::Request::Dismiss(row)) => {
                self.ended.dismiss(row);
                self.needs_relayout = true;
            }
            Some(works::Request::Copied) => self.say(About::Edit, "Copied the path".to_owned(), TOAST / 2),
            None => {}
        }
        if let Some(request) = exported {
            self.on_export_request(request);
        }
        if let Some(request) = opens {
            self.on_open_request(request);
        }
        self.on_path_requests(path_requests);
        if self.settings.style != settings_before.style {
            self.style_changed(settings_before.style);
            self.open_document();
        }
        if let Some(pane) = requests.toggled {
            self.dock.toggle(pane);
            self.needs_relayout = true;
        }
        if requests.gallery {
            self.toggle_gallery();
            self.needs_relayout = true;
        }
        if requests.divider {
            self.toggle_divider();
        }
        if requests.copied {
            self.say(About::Edit, "Copied the value for --camera".to_owned(), TOAST / 2);
        }
        if requests.export {
            self.toggle_export();
        }
        if requests.open {
            self.toggle_open_dialog();
        }
        // A higher clearance lifts the camera; a lower one does not lower it.
        self.camera.advance(&FlyInput::default(), 0.0, |at| ground_m(&self.world, at));
        self.stale |= self.settings != settings_before || self.camera != camera_before;
        if let Some(text) = typed {
            self.go_to(&text);
        }
        if requests.light.place_focus {
            self.place_focus();
        }
        self.follow_land();
        self.follow_seed();
        if requests.restart {
            self.restart();
        }
        if requests.screenshot {
            self.take_screenshot();
        }
        Ok(painted)
    }

    fn render_picture(&mut self, step_s: f64) -> Result<(), WindowError> {
        let picture_px = self.settings.picture_px(self.screen.size_px());
        let light = self.light();
        let pose = self.camera.pose();
        // An estimate without readback: `Surfaces::nearest_m` is at most half the height above the ground.
        let nearest_m = 2.0 * self.world.surfaces.nearest_m(pose.position_m);
        self.eyes_move = self.settings.follow_land(nearest_m, step_s);
        let style = self.compared.as_ref().unwrap_or(&self.styles.list()[self.settings.style]);
        let renderer = Renderer::or_new(&mut self.renderer, &self.gpu)?;
        let clock = Clock { now_s: self.begun.elapsed().as_secs_f64(), before_s: self.last.time_s };
        let rig = self.settings.rig(&View::whole(self.last.pose, pose, picture_px).at(clock), &self.last.pair);
        self.world.surfaces.terrain.set_lod_error_px(self.settings.lod_error_px);
        renderer.set_step_s(step_s);
        renderer.set_antialias(self.settings.antialias);
        // A window never waits for a compiler.
        renderer.set_builds(Builds::InBackground);
        let measures = self.dock.is_shown(Pane::Flight) || self.dock.is_shown(Pane::Cost);
        renderer.set_submits(if measures { Submits::Timed } else { Submits::Whole });
        let now = Instant::now();
        let traces = self.dock.is_shown(Pane::Cost) && self.traffic.is_due(&style.name, now);
        renderer.set_traces(traces);
        let prepared = renderer.render_eyes(&self.gpu, &mut self.world.surfaces, &rig, style, &light)?;
        if traces {
            self.traffic.count(renderer.trace(), &style.name, now);
        }
        self.render_left(&rig, &light, step_s, self.settings.antialias)?;
        self.navigation.drew(&rig.eyes);
        if let Some(renderer) = &self.renderer {
            self.stroke_numbers.request(&self.gpu, renderer.strokes());
        }
        self.last.tiles_loaded += prepared.tiles.loaded;
        self.last.pose = pose;
        self.last.time_s = clock.now_s;
        self.last.pair = self.settings.pair;
        self.last.prepared = prepared;
        Ok(())
    }

    fn present(&mut self, surface: wgpu::SurfaceTexture, painted: Painted) {
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

    /// Prints the frame times, for `--frames`.
    fn report(&self) -> Result<(), FileError> {
        let [p50_ms, p95_ms] = [0.5, 0.95].map(|part| self.frame_times.quantile_ms(part).unwrap_or(f64::NAN));
        let [width, height] = self.settings.picture_px(self.screen.size_px());
        let mut text = format!(
            "{width}x{height} {}: frame p50 {p50_ms:.2} ms, p95 {p95_ms:.2} ms, {:.1} frames per second",
            self.style().name,
            1000.0 / p50_ms
        );
        for pass in self.pass_times.passes() {
            text += &format!("\n  {}: {:.3} ms", pass.name, pass.gpu_ms);
        }
        standard::print(&text)
    }
}

/// Returns the height of the ground in metres from tiles in memory, since a frame must not wait for a file. In holes
/// and outside of the land, it is the lowest height.
fn ground_m(world: &FlightWorld, at: glam::DVec2) -> f64 {
    world.surfaces.terrain.height_at_hand_m(at).unwrap_or_else(|| f64::from(world.surfaces.terrain.range_m()[0]))
}
