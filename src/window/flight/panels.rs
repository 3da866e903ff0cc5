//! The panels of a frame: they are laid out, and the user's requests in them are carried out.

use super::controls::TOAST;
use super::{Flight, ground_m};
use crate::composite::PICTURE;
use crate::frame::Renderer;
use crate::studio::document::StyleDocument;
use crate::window::cost::{self, CostStats};
use crate::window::dock::Pane;
use crate::window::fly_camera::{FlyCamera, FlyInput};
use crate::window::gallery::Choice;
use crate::window::inspector::Edit;
use crate::window::overlay::Painted;
use crate::window::panel::{self, PanelRequests, PanelStats};
use crate::window::questions::Question;
use crate::window::scene_history::next_names;
use crate::window::settings::Settings;
use crate::window::toasts::{self, About};
use crate::window::{WindowError, export, open_dialog, opening, path_panel, status, welcome, works};

/// Requests of the user in the panels of one frame.
#[derive(Default)]
struct Requests {
    /// Requests in the panel of the flight.
    panel: PanelRequests,
    /// Edits of the style.
    edits: Vec<Edit>,
    /// An answered question, and whether the user took what it offers.
    answer: Option<(Question, bool)>,
    /// A place that was typed.
    typed: Option<String>,
    /// Coordinates that were copied.
    copied_place: Option<String>,
    /// Choices in the gallery.
    choices: Vec<Choice>,
    /// A request in the dialog that opens files.
    opens: Option<open_dialog::OpenRequest>,
    /// A request about a work in the background.
    work: Option<works::TaskRequest>,
    /// A request in the dialog of exports.
    exported: Option<export::ExportRequest>,
    /// Requests in the panel of camera paths.
    path: Vec<path_panel::PathRequest>,
    /// Whether the sentences of the first start were closed.
    closes_welcome: bool,
}

impl Flight {
    /// Lays out the panels and carries out what the user requests in them.
    ///
    /// # Errors
    /// Fails if the GPU fails.
    pub(super) fn lay_panels_out(&mut self) -> Result<Painted, WindowError> {
        let has_picture = self.previous_renderer.is_some()
            || self.renderer.as_ref().is_some_and(|renderer| renderer.target(&PICTURE).is_some());
        let view = self.export_dialog.is_open().then(|| self.shown_view());
        let panels = [Pane::Style, Pane::Inside, Pane::Cost, Pane::Path].map(|pane| (pane, self.dock.is_shown(pane)));
        let labels = if has_picture { self.label_shapes() } else { Vec::new() };
        let prepared = &self.last.prepared;
        let terrain = &self.world.surfaces.terrain;
        let position_m = self.camera.position_m;
        let quality = self.ladder.words(self.settings.scale(), self.settings.lod_error_px);
        let stats = PanelStats {
            adapter: &self.adapter,
            picture_px: self.last.picture_px,
            quality: quality.as_deref(),
            has_levels: self.ladder.has_levels(),
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
            has_labels: self.labels.is_on(),
            views: self.has_views(),
        };
        let renderer = self.renderer.as_ref();
        let cost = CostStats {
            traffic: &self.traffic,
            picture_bytes: renderer.map_or(0, Renderer::target_bytes),
            cpu_ms: [prepared.prepare_ms, renderer.map_or(0.0, Renderer::record_ms)],
        };
        let entries = if self.dock.is_shown(Pane::Inside) { self.viewer_entries() } else { Vec::new() };
        let (settings_before, camera_before) = (self.settings.clone(), self.camera.clone());
        let mut requests = Requests::default();
        let (words, projection) = self.navigation.words(self.world.surfaces.exaggeration());
        let projection = projection.map(str::to_owned);
        let exports = self.exports.iter().map(|run| &*run.work);
        let works: Vec<&works::BackgroundTask> =
            self.world_being_opened.iter().map(|opening| &*opening.work).chain(exports).collect();
        let window_px = self.settings.eye_px(self.screen.size_px());
        let mut divided = self.divided.as_ref().map(|divided| (divided.divider, divided.is_ready()));
        let of_style = self.styles.document(self.settings.style).map_or([None, None], StyleDocument::steps);
        let steps = next_names(self.scene_history.steps(), of_style);
        let painted = self.overlay.run(&self.window, |ui| {
            let context = &ui.ctx().clone();
            if !has_picture {
                opening::sign(context, "Preparing the first picture…");
            }
            context.layer_painter(egui::LayerId::background()).extend(labels.iter().cloned());
            self.viewer.paint(context);
            self.dock.show(ui, &mut |ui, pane| match pane {
                Pane::View => {}
                Pane::Flight => {
                    let (settings, camera) = (&mut self.settings, &mut self.camera);
                    let light_and_land = (&mut self.light_panel, &mut self.land_panel);
                    requests.panel = panel::show(ui, &stats, &self.styles, settings, camera, light_and_land);
                }
                Pane::Style => {
                    if let Some(document) = self.styles.document(settings_before.style) {
                        requests.edits = self.inspector.show(ui, document, steps).edits;
                    }
                }
                Pane::Inside => self.viewer.show(ui, &entries),
                Pane::Cost => cost::show(ui, &stats, &cost),
                Pane::Path => {
                    let (shown, panel) = self.paths.shown();
                    requests.path.extend(panel.show(ui, &shown));
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
                requests.choices =
                    self.gallery.show(context, styles, &self.favourites, thumbnails, settings_before.style);
            }
            requests.opens = self.open_dialog.show(context).or(requests.opens.take());
            if let Some((view, refusal)) = &view {
                let shown = export::WindowView { view, refusal: *refusal, window_px };
                requests.exported = self.export_dialog.show(context, &shown).or(requests.exported.take());
            }
            requests.work = works::show(context, works.iter().copied(), &self.ended).or(requests.work);
            requests.answer = self.questions.show(context).or(requests.answer.take());
            let go_to = &mut self.navigation.go_to;
            let typed = status::show(context, free, &words, projection.as_deref(), go_to);
            requests.typed = typed.or(requests.typed.take());
            requests.copied_place = status::copy(context, &words).or(requests.copied_place.take());
            let left = egui::Rect::from_min_max(window.min, egui::pos2(free.left(), window.bottom()));
            let right = egui::Rect::from_min_max(egui::pos2(free.right(), window.top()), window.max);
            let covers = |side: &egui::Rect| side.width() > 0.0;
            toasts::show(context, &self.toasts, Some(left).filter(covers), Some(right).filter(covers), free.bottom());
            self.keys_window.show(context);
            requests.closes_welcome |= self.welcomes && welcome::show(context);
        });
        self.overlay.set_docked(self.dock.rects());
        self.follow_divider(divided.map(|(divider, _)| divider));
        self.carry_out(requests, &settings_before, &camera_before);
        Ok(painted)
    }

    fn carry_out(&mut self, requests: Requests, settings_before: &Settings, camera_before: &FlyCamera) {
        if let Some(place) = &requests.copied_place {
            self.say(About::Edit, format!("Copied {place}"), TOAST / 2);
            self.needs_relayout = true;
        }
        let Requests {
            panel: requests,
            edits,
            answer,
            typed,
            copied_place: _,
            choices,
            opens,
            work,
            exported,
            path,
            closes_welcome,
        } = requests;
        if closes_welcome {
            self.end_welcome();
        }
        self.apply(edits, settings_before.style);
        if let Some((question, is_taken)) = answer {
            self.answer(question, is_taken);
        }
        self.choose(choices);
        match work {
            Some(works::TaskRequest::Cancel(row)) => self.on_cancel(row),
            Some(works::TaskRequest::Dismiss(row)) => {
                self.ended.dismiss(row);
                self.needs_relayout = true;
            }
            Some(works::TaskRequest::Copied) => self.say(About::Edit, "Copied the path".to_owned(), TOAST / 2),
            None => {}
        }
        if let Some(request) = exported {
            self.on_export_request(request);
        }
        if let Some(request) = opens {
            self.on_open_request(request);
        }
        self.on_path_requests(path);
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
        if requests.labels {
            self.toggle_labels();
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
        self.stale |= self.settings != *settings_before || self.camera != *camera_before;
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
        if let Some(step) = requests.to_view {
            self.go_to_remembered(step);
        }
        if requests.screenshot {
            self.take_screenshot();
        }
    }
}
