//! Handler of winit's events: opens the flight, passes events to it, and says when to sleep.

use std::time::Instant;

use winit::application::ApplicationHandler;
use winit::event::{DeviceEvent, DeviceId, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::WindowId;

use super::flight::{Flight, Next};
use super::opening::Opening;
use super::{FlightOptions, OpenWorldFn, WindowError};

struct App {
    options: FlightOptions,
    open: Option<OpenWorldFn>,
    /// The window before its flight.
    opening: Option<Opening>,
    flight: Option<Flight>,
    outcome: Result<(), WindowError>,
    /// Wakes the event loop from other threads.
    proxy: EventLoopProxy<()>,
}

/// Connects to the window system; the error is one line on why there is none.
pub(super) fn event_loop() -> Result<EventLoop<()>, String> {
    // winit panics if a library of the display is missing. That also means that there is no display.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let made = std::panic::catch_unwind(EventLoop::new);
    std::panic::set_hook(hook);
    let cause = match made {
        Ok(Ok(events)) => return Ok(events),
        Ok(Err(winit::error::EventLoopError::Os(error))) => {
            // Remove the position in winit's source from the error.
            let text = error.to_string();
            text.split_once(": ")
                .filter(|(place, _)| place.starts_with("os error at"))
                .map_or(text.clone(), |(_, cause)| cause.to_owned())
        }
        Ok(Err(error)) => error.to_string(),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
            text.unwrap_or("the libraries of the window system cannot be loaded").to_owned()
        }
    };
    Err(cause.split_whitespace().collect::<Vec<_>>().join(" ").trim_end_matches('.').to_owned())
}

pub(super) fn run(events: EventLoop<()>, options: FlightOptions, open: OpenWorldFn) -> Result<(), WindowError> {
    let proxy = events.create_proxy();
    let mut app = App { options, open: Some(open), opening: None, flight: None, outcome: Ok(()), proxy };
    events.run_app(&mut app)?;
    app.outcome
}

impl App {
    /// Ends the program with an error.
    fn fail(&mut self, events: &ActiveEventLoop, error: WindowError) {
        self.outcome = Err(error);
        events.exit();
    }

    /// Begins the flight if its world is open.
    fn begin(&mut self, events: &ActiveEventLoop) {
        let Some(world) = self.opening.as_ref().and_then(Opening::take) else { return };
        let Some(opening) = self.opening.take() else { return };
        let (parts, kept) = opening.into_parts();
        let flight = world.and_then(|world| Flight::new(parts, world, &self.options, self.proxy.clone()));
        match flight {
            Ok(flight) => {
                flight.request_redraw();
                self.flight = Some(flight);
            }
            Err(error) => return self.fail(events, error),
        }
        for event in kept {
            self.with_flight(events, |flight| flight.on_event(&event));
        }
    }

    /// Calls `act` on the flight; an error, or the end of the flight, ends the program.
    fn with_flight(&mut self, events: &ActiveEventLoop, act: impl FnOnce(&mut Flight) -> Result<Next, WindowError>) {
        let Some(flight) = &mut self.flight else { return };
        match act(flight) {
            Ok(Next::Frame) => flight.request_redraw(),
            Ok(Next::Sleep) => {}
            Ok(Next::Quit) => {
                flight.remember();
                events.exit();
            }
            Err(error) => {
                self.outcome = Err(error);
                events.exit();
            }
        }
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some(open) = self.open.take() else { return };
        match Opening::start(events, &self.options, open, &self.proxy) {
            Ok(opening) => self.opening = Some(opening),
            Err(error) => self.fail(events, error),
        }
    }

    fn new_events(&mut self, events: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            if let Some(opening) = &self.opening {
                opening.request_redraw();
            }
            self.with_flight(events, |flight| Ok(flight.wake(Instant::now())));
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, (): ()) {
        self.begin(events);
        self.with_flight(events, |flight| Ok(flight.on_woken()));
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        if let Some(opening) = &mut self.opening {
            match event {
                WindowEvent::RedrawRequested => {
                    if let Err(error) = opening.draw() {
                        self.fail(events, error);
                    }
                }
                event if opening.on_event(&event) => events.exit(),
                _ => {}
            }
            return;
        }
        self.with_flight(events, |flight| match event {
            WindowEvent::RedrawRequested => flight.draw(),
            event => flight.on_event(&event),
        });
    }

    fn device_event(&mut self, events: &ActiveEventLoop, _device: DeviceId, event: DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta } = event {
            self.with_flight(events, |flight| Ok(flight.on_mouse_motion(delta)));
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let of_opening = self.opening.as_ref().map(Opening::wake_at);
        let wake_at = of_opening.or_else(|| self.flight.as_ref().and_then(Flight::wake_at));
        events.set_control_flow(wake_at.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
