//! A window that mirrors the left eye for spectators.
//!
//! The mirror is optional: the flight does not wait for it, and continues without it if there is no display or if the
//! headset's GPU cannot present to it. Closing the window ends the flight.

use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::platform::pump_events::{EventLoopExtPumpEvents, PumpStatus};
use winit::window::{Window, WindowId};

use crate::composite::present::{PresentPass, Shown};
use crate::gpu::Gpu;
use crate::gpu::target::Target;
use crate::window::Windowing;

/// Longest side of the window.
const LARGEST_PX: f64 = 800.0;
/// Interval at which the mirror is updated: it shares the GPU with the headset.
const STEP: Duration = Duration::from_millis(33);

/// The mirror's window with its event loop.
pub(super) struct Mirror {
    glass: Glass,
    events: EventLoop<()>,
    shown_at: Option<Instant>,
}

/// Handler of the window's events.
struct Glass {
    pane: Option<Pane>,
    gpu: Gpu,
    size_px: [u32; 2],
    is_over: bool,
}

/// Fields are dropped in order: the surface before its window.
struct Pane {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    present: PresentPass,
    window: Arc<Window>,
}

impl Mirror {
    /// Opens a window with the aspect ratio of an eye's picture. Returns `None`, and logs why, if there is no display.
    pub(super) fn open(gpu: &Gpu, eye_px: [u32; 2]) -> Option<Self> {
        let windowing = Windowing::new().inspect_err(|error| tracing::info!("no mirror: {error}")).ok()?;
        let longer_px = f64::from(eye_px[0].max(eye_px[1]).max(1));
        let size_px = eye_px.map(|side| ((f64::from(side) * LARGEST_PX / longer_px).round() as u32).max(1));
        let glass = Glass { pane: None, gpu: gpu.clone(), size_px, is_over: false };
        Some(Self { glass, events: windowing.into_events(), shown_at: None })
    }

    /// Handles pending events; returns whether the window was closed.
    pub(super) fn is_closed(&mut self) -> bool {
        let status = self.events.pump_app_events(Some(Duration::ZERO), &mut self.glass);
        self.glass.is_over || matches!(status, PumpStatus::Exit(_))
    }

    /// Shows a picture, unless the previous one was shown just before.
    pub(super) fn show(&mut self, picture: &Target) {
        let now = Instant::now();
        if self.shown_at.is_some_and(|at| now - at < STEP) {
            return;
        }
        let Some(pane) = &mut self.glass.pane else { return };
        self.shown_at = Some(now);
        pane.show(&self.glass.gpu, picture);
    }
}

impl Pane {
    fn open(events: &ActiveEventLoop, gpu: &Gpu, size_px: [u32; 2]) -> Result<Self, String> {
        let attributes = Window::default_attributes()
            .with_title("hachure: left eye")
            .with_inner_size(PhysicalSize::<u32>::from(size_px))
            .with_resizable(false);
        let window = Arc::new(events.create_window(attributes).map_err(|error| error.to_string())?);
        let surface = gpu.instance.create_surface(Arc::clone(&window)).map_err(|error| error.to_string())?;
        let [width, height] = size_px;
        let mut config = surface
            .get_default_config(&gpu.adapter, width, height)
            .ok_or("the headset's GPU cannot draw on this display")?;
        // The headset sets the pace, so a present mode that waits for the display cannot be used.
        let modes = surface.get_capabilities(&gpu.adapter).present_modes;
        let free = [wgpu::PresentMode::Mailbox, wgpu::PresentMode::Immediate];
        let mode = free.into_iter().find(|mode| modes.contains(mode));
        config.present_mode = mode.ok_or("this display has no present mode that does not wait")?;
        surface.configure(&gpu.device, &config);
        let present = PresentPass::new(gpu, config.format);
        Ok(Self { surface, config, present, window })
    }

    fn show(&mut self, gpu: &Gpu, picture: &Target) {
        use wgpu::CurrentSurfaceTexture as Current;
        let frame = match self.surface.get_current_texture() {
            Current::Success(frame) => frame,
            // A lost or outdated surface is available again for the next picture.
            Current::Suboptimal(_) | Current::Outdated | Current::Lost => {
                self.surface.configure(&gpu.device, &self.config);
                return;
            }
            Current::Timeout | Current::Occluded | Current::Validation => return,
        };
        let target = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let descriptor = wgpu::CommandEncoderDescriptor { label: Some("mirror") };
        let mut encoder = gpu.device.create_command_encoder(&descriptor);
        let size_px = [self.config.width, self.config.height];
        self.present.run(gpu, &mut encoder, Shown::One(picture), &target, size_px);
        gpu.queue.submit([encoder.finish()]);
        self.window.pre_present_notify();
        gpu.queue.present(frame);
    }

    fn resize(&mut self, gpu: &Gpu, size_px: [u32; 2]) {
        if size_px.contains(&0) || size_px == [self.config.width, self.config.height] {
            return;
        }
        let limit = gpu.device.limits().max_texture_dimension_2d;
        [self.config.width, self.config.height] = size_px.map(|side| side.min(limit));
        self.surface.configure(&gpu.device, &self.config);
    }
}

impl ApplicationHandler for Glass {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.pane.is_none() {
            match Pane::open(events, &self.gpu, self.size_px) {
                Ok(pane) => self.pane = Some(pane),
                Err(error) => tracing::warn!("no mirror: {error}"),
            }
        }
    }

    fn window_event(&mut self, _events: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => self.is_over = true,
            WindowEvent::Resized(size) => {
                if let Some(pane) = &mut self.pane {
                    pane.resize(&self.gpu, [size.width, size.height]);
                }
            }
            _ => {}
        }
    }
}
