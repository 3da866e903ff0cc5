//! A window while its world is being opened in the background: it says so, and keeps what is typed for the flight.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Align2, Color32, RichText};
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::keyboard::{Key, NamedKey};
use winit::window::Window;

use super::background::{Background, NoResult};
use super::overlay::Overlay;
use super::screen::{Acquired, Screen};
use super::{FlightOptions, FlightWorld, OpenWorldFn, WindowError};
use crate::gpu::Gpu;
use crate::gpu::device::instance_descriptor;

/// Interval at which the sign counts seconds.
const SECOND: Duration = Duration::from_secs(1);
/// Largest number of events that are kept for the flight.
const MAX_EVENTS: usize = 1000;
/// Colour of the window behind the sign.
const BACKGROUND: Color32 = Color32::from_gray(38);

/// The parts of a window.
pub(super) struct Parts {
    pub overlay: Overlay,
    pub screen: Screen,
    pub gpu: Gpu,
    pub window: Arc<Window>,
}

/// A window whose world is being opened.
pub(super) struct Opening {
    parts: Parts,
    /// The name of the world for people.
    name: String,
    world: Background<anyhow::Result<FlightWorld>>,
    begun: Instant,
    next_sign: Instant,
    /// Events that the flight handles when it begins.
    events: Vec<WindowEvent>,
}

impl Opening {
    /// Opens window and GPU, shows the window, and begins to open the world on another thread.
    ///
    /// # Errors
    /// Returns a [`WindowError`] if the window or the GPU cannot be opened.
    pub(super) fn start(
        events: &ActiveEventLoop,
        options: &FlightOptions,
        open: OpenWorldFn,
        proxy: &EventLoopProxy<()>,
    ) -> Result<Self, WindowError> {
        let attributes = Window::default_attributes()
            .with_title("hachure")
            .with_inner_size(PhysicalSize::<u32>::from(options.size_px))
            .with_visible(false);
        let window = Arc::new(events.create_window(attributes)?);
        let display = Box::new(events.owned_display_handle());
        let instance = wgpu::Instance::new(instance_descriptor().with_display_handle(display));
        let surface = instance.create_surface(Arc::clone(&window))?;
        let gpu = Gpu::open_with(instance, &options.adapter, Some(&surface))?;
        crate::world::store_pipelines(&gpu);
        let screen = Screen::new(&gpu, Arc::clone(&window), surface)?;
        // An event loop that has ended needs no waking.
        let [of_readers, of_world] = [proxy.clone(), proxy.clone()];
        let wake = move || _ = of_readers.send_event(());
        let overlay = Overlay::new(&gpu, events, &window, screen.format(), wake);
        window.set_title(&format!("{} — hachure", options.name));
        window.set_visible(true);
        window.request_redraw();
        let on_gpu = gpu.clone();
        let world = Background::start("world", move || open(&on_gpu), move || _ = of_world.send_event(()));
        let (name, now) = (options.name.clone(), Instant::now());
        let parts = Parts { overlay, screen, gpu, window };
        Ok(Self { parts, name, world, begun: now, next_sign: now, events: Vec::new() })
    }

    /// Returns the world, or why it cannot be opened, if it is known.
    pub(super) fn take(&self) -> Option<Result<FlightWorld, WindowError>> {
        let world = self.world.take()?;
        let world =
            world.unwrap_or_else(|NoResult| Err(anyhow::anyhow!("the world cannot be opened, for an unknown reason")));
        Some(world.map_err(WindowError::World))
    }

    /// Returns the parts of the window, and the events that have been kept.
    pub(super) fn into_parts(self) -> (Parts, Vec<WindowEvent>) {
        (self.parts, self.events)
    }

    /// Returns when the sign is to be drawn again.
    pub(super) fn wake_at(&self) -> Instant {
        self.next_sign
    }

    /// Requests that the sign is drawn again.
    pub(super) fn request_redraw(&self) {
        self.parts.window.request_redraw();
    }

    /// Handles an event. Returns whether the user wants to leave.
    pub(super) fn on_event(&mut self, event: &WindowEvent) -> bool {
        match event {
            WindowEvent::CloseRequested => return true,
            WindowEvent::KeyboardInput { event: key, .. }
                if key.logical_key == Key::Named(NamedKey::Escape) && key.state == ElementState::Pressed =>
            {
                return true;
            }
            WindowEvent::Resized(size) => {
                self.parts.screen.resize(&self.parts.gpu, [size.width, size.height]);
                self.parts.window.request_redraw();
            }
            WindowEvent::KeyboardInput { .. }
            | WindowEvent::ModifiersChanged(_)
            | WindowEvent::MouseInput { .. }
            | WindowEvent::MouseWheel { .. }
            | WindowEvent::CursorMoved { .. }
                if self.events.len() < MAX_EVENTS =>
            {
                self.events.push(event.clone());
            }
            _ => {}
        }
        false
    }

    /// Draws the sign.
    ///
    /// # Errors
    /// Fails if the GPU fails.
    pub(super) fn draw(&mut self) -> Result<(), WindowError> {
        self.next_sign = Instant::now() + SECOND;
        let Parts { overlay, screen, gpu, window } = &mut self.parts;
        let surface = match screen.acquire(gpu)? {
            Acquired::Frame(surface) => surface,
            Acquired::Soon => {
                window.request_redraw();
                return Ok(());
            }
            Acquired::Hidden => return Ok(()),
        };
        let seconds = self.begun.elapsed().as_secs();
        let text = if seconds > 0 {
            format!("Opening {}… {seconds} s", self.name)
        } else {
            format!("Opening {}…", self.name)
        };
        let painted = overlay.run(window, |ui| sign(ui.ctx(), &text));
        let target = surface.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("sign") });
        overlay.paint(gpu, &mut encoder, &target, screen.size_px(), painted);
        gpu.queue.submit([encoder.finish()]);
        window.pre_present_notify();
        gpu.queue.present(surface);
        gpu.check()?;
        Ok(())
    }
}

/// Fills the window behind the panels, and writes a text in its middle.
pub(super) fn sign(context: &egui::Context, text: &str) {
    let painter = context.layer_painter(egui::LayerId::background());
    painter.rect_filled(context.viewport_rect(), 0.0, BACKGROUND);
    let area = egui::Area::new(egui::Id::unique("sign")).order(egui::Order::Middle).interactable(false);
    area.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        ui.label(RichText::new(text).heading());
    });
}
