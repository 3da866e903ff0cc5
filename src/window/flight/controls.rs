//! Events that act on a flight, and the times at which it wakes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::event::WindowEvent;
use winit::window::Fullscreen;

use super::compare::Compared;
use super::{Flight, Next};
use crate::frame::Renderer;
use crate::picture::imprint::Imprint;
use crate::scene::overrides::SeaLevel;
use crate::scene::stereo::Eyes;
use crate::scene::{Scene, SceneFocus};
use crate::tiles::terrain::TerrainOptions;
use crate::window::WindowError;
use crate::window::input::Reaction;
use crate::window::inspector::Edit;
use crate::window::keys::Action;
use crate::window::path_panel;
use crate::window::screenshot::Shot;
use crate::window::settings::Settings;
use crate::window::toasts::{self, About};

/// Interval at which gamepads are polled while nothing moves.
const GAMEPAD_REST: Duration = Duration::from_millis(40);
/// Interval at which the program checks for new gamepads.
const GAMEPAD_SEARCH: Duration = Duration::from_secs(1);
/// Interval at which pipelines built in the background are collected while nothing moves.
const BUILT_LOOK: Duration = Duration::from_millis(10);
/// Interval at which shader files are checked for changes, if they are watched.
const SHADER_LOOK: Duration = Duration::from_millis(250);
/// Time for which a message is shown.
pub(super) const TOAST: Duration = Duration::from_secs(5);
/// A second Esc within this time quits.
const ESCAPE: Duration = Duration::from_secs(3);

impl Flight {
    /// Handles a motion of the mouse, in pixels.
    pub(crate) fn on_mouse_motion(&mut self, by_px: (f64, f64)) -> Next {
        if self.input.on_mouse_motion(by_px) { Next::Frame } else { Next::Sleep }
    }

    /// Handles an event of the window.
    ///
    /// # Errors
    /// Fails if the GPU fails.
    pub(crate) fn on_event(&mut self, event: &WindowEvent) -> Result<Next, WindowError> {
        match event {
            WindowEvent::CloseRequested => {
                return Ok(if self.may_leave("close the window again") { Next::Quit } else { Next::Frame });
            }
            WindowEvent::Resized(size) => {
                self.screen.resize(&self.gpu, [size.width, size.height]);
                self.hidden = size.width == 0 || size.height == 0;
                self.stale = true;
            }
            WindowEvent::Occluded(hidden) => self.hidden = *hidden,
            WindowEvent::Focused(false) => self.input.lose_focus(&self.window),
            _ => {}
        }
        if self.on_dropped(event) {
            return Ok(Next::Frame);
        }
        let waits = is_key(event) && self.overlay.awaits_frame();
        // A click must not overtake a key that waits.
        if waits || !self.delayed.is_empty() && (is_key(event) || is_mouse(event)) {
            self.delayed.push(event.clone());
            return Ok(Next::Frame);
        }
        self.on_input(event)
    }

    /// Handles the keys that were pressed after a click, and the events after them, now that the panels have seen the
    /// click. Keys after another click wait again.
    ///
    /// # Errors
    /// Fails if the GPU fails.
    pub(super) fn act_on_delayed(&mut self) -> Result<Next, WindowError> {
        let mut next = Next::Sleep;
        let mut events = std::mem::take(&mut self.delayed).into_iter().peekable();
        while let Some(event) = events.next_if(|event| !is_key(event) || !self.overlay.awaits_frame()) {
            match self.on_input(&event)? {
                Next::Quit => return Ok(Next::Quit),
                Next::Frame => next = Next::Frame,
                Next::Sleep => {}
            }
        }
        self.delayed = events.collect();
        self.needs_relayout |= next == Next::Frame;
        Ok(next)
    }

    /// Handles an event of the mouse or of the keyboard.
    fn on_input(&mut self, event: &WindowEvent) -> Result<Next, WindowError> {
        match self.input.on_event(&self.window, &mut self.overlay, event) {
            Reaction::Nothing => Ok(Next::Sleep),
            Reaction::Panel | Reaction::Fly => Ok(Next::Frame),
            Reaction::Speed(notches) => {
                self.camera.change_speed(notches);
                Ok(Next::Frame)
            }
            Reaction::Zoom(notches) => {
                self.zoom(notches);
                Ok(Next::Frame)
            }
            Reaction::Click(cursor_px) => {
                self.click(cursor_px);
                Ok(Next::Frame)
            }
            Reaction::LookAt(cursor_px) => {
                self.look_at(cursor_px);
                Ok(Next::Frame)
            }
            Reaction::Do(action) => self.act(action),
        }
    }

    fn act(&mut self, action: Action) -> Result<Next, WindowError> {
        let before = self.settings.clone();
        match action {
            Action::StepStyle(step) => self.settings.step_style(step, self.styles.list().len()),
            Action::Favourite(digit) => self.digit(digit),
            Action::ToggleGallery => self.toggle_gallery(),
            Action::ToggleDivider => self.toggle_divider(),
            Action::ToggleLabels => self.toggle_labels(),
            Action::StepScale(step) => self.settings.step_scale(step),
            Action::Screenshot => self.take_screenshot(),
            Action::Toggle(pane) => self.dock.toggle(pane),
            Action::Undo if self.is_over_path_panel() => self.edit_path(path_panel::PathEdit::Undo),
            Action::Redo if self.is_over_path_panel() => self.edit_path(path_panel::PathEdit::Redo),
            Action::Save if self.is_over_path_panel() => self.save_path(),
            Action::SaveAs if self.is_over_path_panel() => self.ask_for_path_name(),
            Action::Undo => self.apply(vec![Edit::Undo], before.style),
            Action::Redo => self.apply(vec![Edit::Redo], before.style),
            Action::Save => self.save_or_ask(),
            Action::SaveAs => self.ask_for_name(),
            Action::AddKey => self.edit_path(path_panel::PathEdit::Add),
            Action::AddView => self.add_view(),
            Action::Play => self.toggle_play(),
            Action::Restart => self.restart(),
            Action::View(step) => self.go_to_remembered(step),
            Action::TopView => self.top_view(),
            Action::FrameAll => self.frame_all(),
            Action::GoTo => self.navigation.go_to.open(),
            Action::Open => self.toggle_open_dialog(),
            Action::Export => self.toggle_export(),
            Action::ToggleKeys => self.keys_window.toggle(),
            Action::FullScreen => {
                let full = self.window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                self.window.set_fullscreen(full);
            }
            Action::Zoom(factor) => {
                self.camera.zoom(factor);
                self.stale = true;
            }
            Action::Escape if self.welcomes => self.end_welcome(),
            Action::Escape if self.keys_window.is_open() => self.keys_window.toggle(),
            Action::Escape if self.open_dialog.is_open() => self.open_dialog.close(),
            Action::Escape if self.export_dialog.is_open() => self.export_dialog.close(),
            Action::Escape if self.gallery.is_open => self.toggle_gallery(),
            Action::Escape if self.pause_path() => {
                self.say(About::Edit, "The camera path is paused".to_owned(), TOAST / 2);
            }
            Action::Escape if self.dismiss_ended() => {}
            Action::Escape => {
                let released = self.input.release_mouse(&self.window);
                if !released && self.escape_until.is_some_and(|until| Instant::now() < until) {
                    return Ok(if self.may_leave("press Esc again") { Next::Quit } else { Next::Frame });
                }
                self.escape_until = Some(Instant::now() + ESCAPE);
                self.say(About::Quitting, "Press Esc again to quit".to_owned(), ESCAPE);
            }
        }
        if self.settings.style != before.style {
            self.style_changed(before.style);
            self.open_document();
            let style = self.style();
            let text = format!("{}: {}", style.name, style.description);
            self.say(About::Style, text, TOAST / 2);
        }
        self.stale |= self.settings != before;
        Ok(Next::Frame)
    }

    /// Returns when something is due without an event.
    pub(crate) fn wake_at(&self) -> Option<Instant> {
        if self.hidden {
            return None;
        }
        let gamepads = self.input.gamepads().may_come().then_some(self.next_gamepads);
        let renderer = self.renderer.as_ref();
        let builds = |renderer: &Renderer| renderer.is_building(&self.gpu) || renderer.has_spares(&self.gpu);
        let builds = renderer.is_some_and(builds) || self.wants_spares();
        let built = builds.then_some(self.next_built);
        let shaders = self.gpu.pipelines().watches().then_some(self.next_shaders);
        let toast = self.toasts.next_end();
        let place = self.navigation.due_at();
        let labels = self.labels.due_at(self.navigation.picture());
        let gallery = self.thumbnails.next_at().filter(|_| self.gallery.is_open);
        let readbacks = [self.layer_picking.due_at(), self.viewer.is_waiting().then_some(self.viewer.next_check)];
        let readback = readbacks.into_iter().flatten().min();
        let due = [
            self.overlay.repaint_at(),
            self.panel_repaint_at,
            toast,
            gamepads,
            built,
            shaders,
            place,
            labels,
            gallery,
            readback,
        ];
        due.into_iter().flatten().min()
    }

    /// Returns whether what is due requires a frame.
    pub(crate) fn wake(&mut self, now: Instant) -> Next {
        if self.next_gamepads <= now {
            let any = self.input.gamepads().any();
            self.next_gamepads = now + if any { GAMEPAD_REST } else { GAMEPAD_SEARCH };
            if !self.input.poll_gamepads().is_still() {
                return Next::Frame;
            }
        }
        self.look_after_shaders(now);
        if self.navigation.due_at().is_some_and(|at| at <= now) {
            // Poll without waiting for the GPU.
            if let Err(error) = self.gpu.device.poll(wgpu::PollType::Poll) {
                tracing::debug!("{error}");
            }
            if self.take_place() {
                return Next::Frame;
            }
        }
        if self.labels.due_at(self.navigation.picture()).is_some_and(|at| at <= now) {
            if let Err(error) = self.gpu.device.poll(wgpu::PollType::Poll) {
                tracing::debug!("{error}");
            }
            if self.follow_labels() || self.labels.is_due(self.navigation.picture(), now) {
                return Next::Frame;
            }
        }
        if self.viewer.is_waiting() && self.viewer.next_check <= now {
            if let Err(error) = self.gpu.device.poll(wgpu::PollType::Poll) {
                tracing::debug!("{error}");
            }
            self.take_viewed_picture();
        }
        if self.layer_picking.due_at().is_some_and(|at| at <= now) {
            if let Err(error) = self.gpu.device.poll(wgpu::PollType::Poll) {
                tracing::debug!("{error}");
            }
            if self.take_picked_layer(now) {
                return Next::Frame;
            }
        }
        if self.stale {
            return Next::Frame;
        }
        let gallery = self.thumbnails.next_at().filter(|_| self.gallery.is_open);
        let due = [self.overlay.repaint_at(), self.panel_repaint_at, self.toasts.next_end(), gallery]
            .into_iter()
            .flatten()
            .any(|at| at <= now);
        if due { Next::Frame } else { Next::Sleep }
    }

    pub(super) fn say(&mut self, about: About, text: String, how_long: Duration) {
        self.toasts.say(about, text, toasts::until(how_long));
    }

    /// Reloads changed shaders, collects what was built in the background, and reports errors. Marks the picture as out
    /// of date if it changes.
    pub(super) fn look_after_shaders(&mut self, now: Instant) {
        let Some(renderer) = &mut self.renderer else { return };
        if self.gpu.pipelines().watches() && self.next_shaders <= now {
            self.next_shaders = now + SHADER_LOOK;
            if renderer.reload_shaders(&self.gpu) > 0 {
                self.next_built = now + BUILT_LOOK;
                // Nothing is built in the background if the renderer waits for pipelines.
                self.stale |= !renderer.is_building(&self.gpu);
            }
        }
        let was_building = renderer.is_building(&self.gpu);
        if (was_building || renderer.has_spares(&self.gpu)) && self.next_built <= now {
            self.next_built = now + BUILT_LOOK;
            renderer.take_built(&self.gpu);
            if let Some(left) = self.divided.as_mut().and_then(Compared::renderer_mut) {
                left.take_built(&self.gpu);
            }
            self.stale |= was_building && !renderer.is_building(&self.gpu);
        }
        self.request_spares(now);
        self.update_lasting_messages();
    }

    /// Updates the messages that stay as long as their cause: errors in shaders and style files, and work that goes on.
    /// Returns whether they differ from before.
    pub(super) fn update_lasting_messages(&mut self) -> bool {
        let of_shaders = self.gpu.pipelines().shader_errors();
        let of_shaders = of_shaders.iter().map(ToString::to_string);
        let draws = (self.pictures.open() > 0).then(|| "Drawing the picture for a file…".to_owned());
        let path = self.path_being_read.is_some().then(|| "Reading the camera path…".to_owned());
        let reads = self.land_being_read.as_ref().map(|land| format!("Reading the land, heights × {}…", land.factor));
        self.toasts.set_lasting(
            of_shaders.chain(self.file_errors.values().cloned()).chain(draws).chain(reads).chain(path).collect(),
        )
    }

    pub(super) fn restart(&mut self) {
        self.paths.player.pause();
        let clearance_m = self.camera.clearance_m;
        self.camera = self.start.clone();
        self.camera.clearance_m = clearance_m;
        self.stale = true;
    }

    /// Requests a picture of what is shown, at the window's full resolution; it is drawn in the background.
    pub(super) fn take_screenshot(&mut self) {
        let shot = self.shot();
        if !self.pictures.take(shot) {
            self.say(About::File, "Several pictures are being drawn; press F12 again later".to_owned(), TOAST);
        }
        self.update_lasting_messages();
    }

    /// Reports the pictures that are finished. Returns whether there were any.
    pub(super) fn report_pictures(&mut self) -> bool {
        let mut any = false;
        while let Some(taken) = self.pictures.taken() {
            any = true;
            let text = match taken {
                Ok(path) => {
                    let path = std::path::absolute(&path).unwrap_or(path);
                    tracing::info!("wrote {}", path.display());
                    format!("Wrote {}", path.display())
                }
                // A full disk must not end the flight.
                Err(error) => error,
            };
            self.say(About::File, text, TOAST);
        }
        any
    }

    /// Returns a picture of the current view, with everything that it depends on.
    pub(super) fn shot(&self) -> Shot {
        let Settings { sun, eyes, pair, haze_m, sea_level_m, focus, .. } = self.settings;
        let terrain = &self.world.surfaces.terrain;
        let mut more = self.world.more.clone();
        more.samples = Some(self.settings.samples()).filter(|samples| *samples != 1);
        more.lod_error = Some(self.settings.lod_error_px).filter(|error_px| *error_px != 1.0);
        let sways = self.renderer.as_ref().is_some_and(Renderer::may_sway);
        more.time_s = Some(self.last.time_s).filter(|_| sways);
        if eyes != Eyes::Mono {
            more.eyes = Some(eyes.to_string());
            more.ipd = Some(pair.ipd_m.to_string());
            more.convergence = pair.convergence_m;
        }
        let mut scene = Scene { sun, sun_time: None, ..self.world.scene.clone() };
        if haze_m != self.world.light.haze_m {
            more.haze = Some(haze_m);
            scene.haze.distance_m = Some(haze_m);
        }
        if sea_level_m != scene.sea_level_m {
            more.sea_level = Some(SeaLevel::of(sea_level_m).to_string());
            scene.sea_level_m = sea_level_m;
        }
        if focus != scene.focus {
            // Without strength, the focus of the scene is gone.
            let none = scene.focus.map(|focus| SceneFocus { strength: 0.0, ..focus });
            // The option has no height.
            scene.focus = focus.or(none).map(|focus| SceneFocus { height_m: None, ..focus });
            more.focus = scene.focus.map(|focus| focus.to_string());
        }
        let imprint = Imprint {
            world: self.world.world.clone(),
            camera: self.camera.exact(),
            sun,
            style: self.style().clone(),
            size_px: self.settings.eye_px(self.screen.size_px()),
            dpi: None,
            more,
        };
        let options = TerrainOptions { lod_error_px: self.settings.lod_error_px, ..*terrain.options() };
        Shot { gpu: self.gpu.clone(), scene, store: Arc::clone(terrain.store()), options, imprint, eyes, pair }
    }
}

/// Returns whether the meaning of an event depends on which widget has the focus.
fn is_key(event: &WindowEvent) -> bool {
    matches!(event, WindowEvent::KeyboardInput { .. } | WindowEvent::ModifiersChanged(_) | WindowEvent::Ime(_))
}

fn is_mouse(event: &WindowEvent) -> bool {
    use WindowEvent as Event;
    matches!(
        event,
        Event::MouseInput { .. }
            | Event::CursorMoved { .. }
            | Event::CursorLeft { .. }
            | Event::CursorEntered { .. }
            | Event::MouseWheel { .. }
    )
}
