//! The begin of a flight: its state before the first frame.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use winit::event_loop::EventLoopProxy;

use super::layer_picking::LayerPicking;
use super::navigate::Navigation;
use super::paths::Paths;
use super::spares::Spares;
use super::{Flight, LastPicture, ground_m};
use crate::ladder::Ladder;
use crate::lines::strokes::AsyncStrokeNumbers;
use crate::source::EarthPlace;
use crate::studio::favourites::Favourites;
use crate::studio::recent::Recent;
use crate::studio::unsaved::Unsaved;
use crate::studio::watch::FileWatch;
use crate::tiles::terrain::Prepared;
use crate::window::browse::Browser;
use crate::window::camera_history::CameraHistory;
use crate::window::cost::Traffic;
use crate::window::dock::Dock;
use crate::window::export::ExportDialog;
use crate::window::fly_camera::FlyCamera;
use crate::window::gallery::Gallery;
use crate::window::gallery::thumbnails::Thumbnails;
use crate::window::help::KeysWindow;
use crate::window::input::Input;
use crate::window::inspector::Inspector;
use crate::window::labels::Labels;
use crate::window::light::LightPanel;
use crate::window::open_dialog::OpenDialog;
use crate::window::opening::Parts;
use crate::window::picture_viewer::PictureViewer;
use crate::window::pictures::Pictures;
use crate::window::places::Places;
use crate::window::questions::Questions;
use crate::window::scene_history::SceneHistory;
use crate::window::settings::{Settings, Styles};
use crate::window::statistics::{FrameTimes, PassTimes};
use crate::window::toasts::Toasts;
use crate::window::{FlightOptions, FlightWorld, WindowError, works};

impl Flight {
    /// Begins a flight over a world in a window.
    ///
    /// # Errors
    /// Returns a [`WindowError`] if the style is invalid.
    pub(in crate::window) fn new(
        parts: Parts,
        world: FlightWorld,
        options: &FlightOptions,
        proxy: EventLoopProxy<()>,
    ) -> Result<Self, WindowError> {
        let Parts { overlay, screen, gpu, window } = parts;
        let (mut styles, style) = Styles::with(&options.style)?;
        styles.set_features(world.surfaces.has_features_and_graticule());
        let start = FlyCamera::new(&world.start, |at| ground_m(&world, at), world.surfaces.terrain.extent_m());
        let settings = Settings {
            style,
            scale: 0,
            antialias: options.antialias,
            quality: options.quality,
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
        let picture_px = settings.picture_px(screen.size_px());
        let last =
            LastPicture { pose, time_s: 0.0, pair, prepared, tiles_loaded: 0, style: None, seen: None, picture_px };
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
            keys_window: KeysWindow::default(),
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
            camera_history: CameraHistory::new(start.exact(), Instant::now()),
            start,
            light_panel: LightPanel::new(earth),
            land_panel: world.land_panel(),
            land_being_read: None,
            proxy: proxy.clone(),
            navigation: Navigation::new(Places::of(&world.surfaces.terrain)),
            layer_picking: LayerPicking::new(),
            labels: Labels::new(options.labels.clone(), world.world.clone()),
            scene_history: SceneHistory::new(&settings),
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
            ladder: Ladder::with_fronts(options.fronts.clone()),
            still_since: None,
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
            spares: Spares::default(),
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
}
