//! egui over the picture: passes events to egui and draws its triangles.

use std::time::{Duration, Instant};

use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::clipboard::Clipboard;
use super::event_parts::first_part;
use super::gallery::thumbnails::Textures;
use super::probe::Probe;
use super::screen_reader::ScreenReader;
use crate::gpu::Gpu;

/// egui with its renderer.
pub(super) struct Overlay {
    context: egui::Context,
    state: egui_winit::State,
    clipboard: Clipboard,
    renderer: Renderer,
    repaint_at: Option<Instant>,
    /// Where the mouse is, in points. egui knows only where it was when the panel was laid out last.
    pointer: Option<egui::Pos2>,
    /// Areas of docked panels, in points.
    docked: Vec<egui::Rect>,
    screen_reader: ScreenReader,
    probe: Probe,
    /// Events that egui gets in the next frame.
    held_back: Vec<egui::Event>,
    /// Whether a button of the mouse was pressed over a panel since the last frame.
    was_pressed: bool,
}

/// A panel that is laid out but not yet painted.
pub(super) struct Painted {
    shapes: Vec<egui::ClippedPrimitive>,
    textures: egui::TexturesDelta,
    pixels_per_point: f32,
}

impl Overlay {
    /// Creates an overlay for a window whose surface has `format`. The window must not have been shown yet; `wake` is
    /// called when a screen reader makes a request.
    pub(super) fn new(
        gpu: &Gpu,
        events: &ActiveEventLoop,
        window: &Window,
        format: wgpu::TextureFormat,
        wake: impl Fn() + Clone + Send + 'static,
    ) -> Self {
        let context = egui::Context::default();
        context.set_theme(egui::Theme::Dark);
        super::panel::set_up(&context);
        let largest = gpu.device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let mut state =
            egui_winit::State::new(context.clone(), egui::ViewportId::ROOT, window, scale, None, Some(largest));
        let (adapter, screen_reader) = ScreenReader::new(events, window, wake);
        state.accesskit = Some(adapter);
        let renderer = Renderer::new(&gpu.device, format, RendererOptions::default());
        Self {
            context,
            state,
            clipboard: Clipboard::of(window),
            renderer,
            repaint_at: None,
            pointer: None,
            docked: Vec::new(),
            screen_reader,
            probe: Probe::of_environment(),
            held_back: Vec::new(),
            was_pressed: false,
        }
    }

    /// Passes an event to the panel. Returns whether the panel needs a repaint, and whether it consumed the event.
    pub(super) fn on_event(&mut self, window: &Window, event: &WindowEvent) -> egui_winit::EventResponse {
        if let WindowEvent::CursorMoved { position, .. } = event {
            let scale = f64::from(self.context.pixels_per_point());
            self.pointer = Some(egui::pos2((position.x / scale) as f32, (position.y / scale) as f32));
        }
        self.was_pressed |= matches!(event, WindowEvent::MouseInput { .. });
        // While flying, no text is being typed.
        if !self.is_typing() {
            return self.state.on_window_event(window, event);
        }
        self.clipboard.before(event, &mut self.state);
        let response = self.state.on_window_event(window, event);
        self.clipboard.after(event, &self.context, &mut self.state);
        response
    }

    /// Carries out what a screen reader has asked for. Returns whether the panels need a repaint.
    pub(super) fn take_screen_reader(&mut self) -> bool {
        self.screen_reader.take(&self.context, &mut self.state)
    }

    /// Returns whether the meaning of a key depends on a click that egui has not seen yet: it may give a text field the
    /// focus.
    pub(super) fn awaits_frame(&self) -> bool {
        self.was_pressed || !self.held_back.is_empty()
    }

    /// Returns whether a text field has the focus.
    pub(super) fn is_typing(&self) -> bool {
        self.context.text_edit_focused()
    }

    /// Ends text input, because the mouse was clicked elsewhere.
    pub(super) fn stop_typing(&mut self) {
        self.context.memory_mut(|memory| memory.stop_text_input());
    }

    /// Takes the areas of docked panels, which are at the level of the picture for egui.
    pub(super) fn set_docked(&mut self, docked: Vec<egui::Rect>) {
        self.docked = docked;
    }

    /// Returns whether the mouse is over a panel or another window of it.
    pub(super) fn is_over_panel(&self) -> bool {
        let Some(at) = self.pointer else { return false };
        let layer = self.context.layer_id_at(at);
        layer.is_some_and(|layer| layer.order != egui::Order::Background)
            || self.docked.iter().any(|rect| rect.contains(at))
    }

    /// Returns whether a click belongs to the panel, or closes one of its lists.
    pub(super) fn wants_click(&self) -> bool {
        self.is_over_panel() || self.is_dragging() || self.has_popup()
    }

    /// Returns whether the mouse holds something in the panel.
    pub(super) fn is_dragging(&self) -> bool {
        self.context.egui_is_using_pointer()
    }

    /// Returns whether a list, a menu or a picker of the panel is open.
    pub(super) fn has_popup(&self) -> bool {
        egui::Popup::is_any_open(&self.context)
    }

    /// Returns whether a widget has the keyboard, because Tab has moved the focus to it.
    pub(super) fn has_focus(&self) -> bool {
        self.context.egui_wants_keyboard_input()
    }

    /// Returns the text of the clipboard.
    pub(super) fn clipboard_text(&mut self) -> Option<String> {
        self.clipboard.text().or_else(|| self.state.clipboard_text())
    }

    /// Returns the context of the panel.
    pub(super) fn context(&self) -> &egui::Context {
        &self.context
    }

    /// Returns when the panel needs the next repaint.
    pub(super) fn repaint_at(&self) -> Option<Instant> {
        self.repaint_at
    }

    /// Lays out the panel. The result must be painted, because it contains texture updates.
    pub(super) fn run(&mut self, window: &Window, mut panel: impl FnMut(&mut egui::Ui)) -> Painted {
        if self.probe.wants_names() {
            self.context.enable_accesskit();
        }
        let mut input = self.state.take_egui_input(window);
        let mut events = std::mem::take(&mut self.held_back);
        events.append(&mut input.events);
        self.held_back = events.split_off(first_part(&events));
        input.events = events;
        self.was_pressed = false;
        let output = self.context.run_ui(input, |ui| panel(ui));
        self.clipboard.take(&output.platform_output.commands);
        self.probe.write(output.platform_output.accesskit_update.as_ref(), output.pixels_per_point);
        self.probe.end_frame();
        self.state.handle_platform_output(window, output.platform_output);
        let delay =
            output.viewport_output.get(&egui::ViewportId::ROOT).map_or(Duration::MAX, |root| root.repaint_delay);
        // `None` for a delay that overflows the clock: no repaint.
        self.repaint_at = Instant::now().checked_add(if self.held_back.is_empty() { delay } else { Duration::ZERO });
        let shapes = self.context.tessellate(output.shapes, output.pixels_per_point);
        Painted { shapes, textures: output.textures_delta, pixels_per_point: output.pixels_per_point }
    }

    /// Draws the panel over `target`.
    pub(super) fn paint(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        size_px: [u32; 2],
        mut painted: Painted,
    ) {
        for (id, deltas) in painted.textures.set.drain() {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, id, &delta);
            }
        }
        let screen = ScreenDescriptor { size_in_pixels: size_px, pixels_per_point: painted.pixels_per_point };
        let callbacks = self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, &painted.shapes, &screen);
        debug_assert!(callbacks.is_empty(), "the panel uses no paint callbacks");
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panel"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        self.renderer.render(&mut pass.forget_lifetime(), &painted.shapes, &screen);
        for id in painted.textures.free.drain() {
            self.renderer.free_texture(&id);
        }
    }
}

impl Textures for Overlay {
    fn register(&mut self, gpu: &Gpu, picture: &wgpu::TextureView) -> egui::TextureId {
        self.renderer.register_native_texture(&gpu.device, picture, wgpu::FilterMode::Linear)
    }

    fn unregister(&mut self, id: egui::TextureId) {
        self.renderer.free_texture(&id);
    }
}
