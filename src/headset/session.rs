//! An OpenXR session: from loading the loader to an open session, and the session's states.

use openxr as xr;

use super::binding::{self, Binding};
use super::error::{During, HeadsetError, of_start};
use super::hidden;
use super::swapchains::SwapchainImages;
use crate::governor::Pressure;
use crate::gpu::Gpu;

/// The view configuration: two eyes.
pub const VIEWS: xr::ViewConfigurationType = xr::ViewConfigurationType::PRIMARY_STEREO;

/// A runtime that has a headset. No session is open yet.
pub struct Runtime {
    instance: xr::Instance,
    system: xr::SystemId,
    name: String,
    /// Whether the runtime reports which parts of the pictures the lenses hide.
    has_masks: bool,
}

impl Runtime {
    /// Finds the loader, the runtime and the headset.
    ///
    /// # Errors
    /// Returns a [`HeadsetError`] that says which of them is missing.
    pub fn connect() -> Result<Self, HeadsetError> {
        let entry = binding::load()?;
        // The loader answers this call from the library of the active runtime, if there is one. Only later calls need
        // the runtime's service.
        let offered = entry.enumerate_extensions().map_err(|cause| match cause {
            xr::sys::Result::ERROR_RUNTIME_FAILURE | xr::sys::Result::ERROR_INSTANCE_LOST => {
                of_start("xrEnumerateInstanceExtensionProperties", cause)
            }
            cause => HeadsetError::NoRuntime { cause },
        })?;
        if !offered.khr_vulkan_enable2 {
            let runtime = "the OpenXR runtime".to_owned();
            return Err(HeadsetError::Lacks { runtime, what: "XR_KHR_vulkan_enable2" });
        }
        let mut wanted = xr::ExtensionSet::default();
        wanted.khr_vulkan_enable2 = true;
        wanted.khr_visibility_mask = offered.khr_visibility_mask;
        wanted.ext_performance_settings = offered.ext_performance_settings;
        let application = xr::ApplicationInfo {
            application_name: "hachure",
            application_version: 1,
            engine_name: "hachure",
            engine_version: 1,
            // Loaders of Linux distributions refuse 1.1, and hachure needs nothing of it.
            api_version: xr::Version::new(1, 0, 0),
        };
        let instance = entry.create_instance(&application, &wanted, &[], &());
        let instance = instance.map_err(|code| of_start("xrCreateInstance", code))?;
        let name = instance.properties().during("xrGetInstanceProperties")?.runtime_name;
        let system = match instance.system(xr::FormFactor::HEAD_MOUNTED_DISPLAY) {
            Ok(system) => system,
            Err(xr::sys::Result::ERROR_FORM_FACTOR_UNAVAILABLE | xr::sys::Result::ERROR_FORM_FACTOR_UNSUPPORTED) => {
                return Err(HeadsetError::NoHeadset { runtime: name });
            }
            Err(code) => return Err(of_start("xrGetSystem", code)),
        };
        tracing::info!("OpenXR runtime: {name}");
        Ok(Self { instance, system, name, has_masks: offered.khr_visibility_mask })
    }

    /// Returns the name of the runtime.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// The work that the session's state allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionPhase {
    /// Nothing: the session has not begun, or has ended for now.
    Idle,
    /// Frames: they must be waited for, begun and ended, visible or not.
    Running,
    /// Nothing any more: the session is over.
    Ended,
}

/// An open session with its GPU. Fields are dropped in this order: textures of a swapchain before the swapchain, the
/// session before its device, the device before the runtime.
pub struct Headset {
    /// Images of both eyes.
    pub eyes: [SwapchainImages; 2],
    /// The stream to which finished frames are submitted.
    pub stream: xr::FrameStream<xr::Vulkan>,
    /// Blocks until the runtime wants the next frame.
    pub waiter: xr::FrameWaiter,
    /// Reference space of all poses.
    pub space: xr::Space,
    /// The session, for its states and actions.
    pub session: xr::Session<xr::Vulkan>,
    /// The device that the runtime created.
    pub gpu: Gpu,
    /// How pictures are blended with the environment.
    pub blend: xr::EnvironmentBlendMode,
    /// Height of the floor in [`Headset::space`].
    pub floor_m: f64,
    /// Triangles that the lenses hide, for each eye's picture.
    pub hidden: hidden::Triangles,
    runtime: Runtime,
    phase: SessionPhase,
    state: xr::SessionState,
    /// The last notice about the GPU from each of the runtime's sources.
    notices: Vec<(xr::PerfSettingsSubDomainEXT, Pressure)>,
    /// Number of notices that the GPU is, or soon will be, too slow.
    slow_notices: u64,
}

/// Height of the head above the floor, if the runtime does not know the floor.
const EYES_ABOVE_FLOOR_M: f64 = 1.6;

impl Headset {
    /// Opens the GPU and a session of a runtime.
    ///
    /// # Errors
    /// Returns a [`HeadsetError`] if one of them cannot be opened.
    pub fn open(runtime: Runtime) -> Result<Self, HeadsetError> {
        let Runtime { instance, system, .. } = &runtime;
        let views =
            instance.enumerate_view_configuration_views(*system, VIEWS).during("xrEnumerateViewConfigurationViews")?;
        let &[left, right] = views.as_slice() else {
            return Err(HeadsetError::Lacks { runtime: runtime.name, what: "a view for each eye" });
        };
        let blends =
            instance.enumerate_environment_blend_modes(*system, VIEWS).during("xrEnumerateEnvironmentBlendModes")?;
        // The runtime lists its preferred modes first. An opaque mode is chosen if there is one, because a drawing
        // covers its background.
        let opaque = blends.iter().copied().find(|blend| *blend == xr::EnvironmentBlendMode::OPAQUE);
        let blend = opaque.or(blends.first().copied()).unwrap_or(xr::EnvironmentBlendMode::OPAQUE);
        let most = instance.system_properties(*system).during("xrGetSystemProperties")?.graphics_properties;

        let (gpu, binding) = binding::open_gpu(instance, *system)?;
        let (session, waiter, stream) = open_session(&runtime, &gpu, binding)?;
        let (space, floor_m) = open_space(&session)?;
        let hidden = if runtime.has_masks { hidden::query(&session)? } else { hidden::Triangles::default() };
        let sizes_px = [left, right].map(|view| {
            // The recommended size is limited to the largest size that the runtime accepts.
            let fit = |wish: u32, most: [u32; 2]| most.into_iter().filter(|most| *most > 0).fold(wish, u32::min).max(1);
            [
                fit(view.recommended_image_rect_width, [view.max_image_rect_width, most.max_swapchain_image_width]),
                fit(view.recommended_image_rect_height, [view.max_image_rect_height, most.max_swapchain_image_height]),
            ]
        });
        let [left, right] = sizes_px.map(|size_px| SwapchainImages::new(&gpu, &session, size_px));
        Ok(Self {
            eyes: [left?, right?],
            stream,
            waiter,
            space,
            session,
            gpu,
            blend,
            floor_m,
            hidden,
            runtime,
            phase: SessionPhase::Idle,
            state: xr::SessionState::IDLE,
            notices: Vec::new(),
            slow_notices: 0,
        })
    }

    /// Returns the sizes of the eyes' pictures.
    pub fn sizes_px(&self) -> [[u32; 2]; 2] {
        [self.eyes[0].size_px(), self.eyes[1].size_px()]
    }

    /// Returns the phase of the session, which limits what the program may do.
    pub fn phase(&self) -> SessionPhase {
        self.phase
    }

    /// Returns whether the session receives input: another program may be in front.
    pub fn is_focused(&self) -> bool {
        self.state == xr::SessionState::FOCUSED
    }

    /// Returns the runtime's request to use less of the GPU (`XR_EXT_performance_settings`): the worst of its last
    /// notices.
    pub(crate) fn pressure(&self) -> Pressure {
        self.notices.iter().map(|(_, pressure)| *pressure).max().unwrap_or_default()
    }

    /// Returns the number of notices that the GPU is, or soon will be, too slow.
    pub fn slow_notices(&self) -> u64 {
        self.slow_notices
    }

    fn take_notice(&mut self, notice: xr::PerfSettingsEXT<'_>) {
        if notice.domain() != xr::PerfSettingsDomainEXT::GPU {
            return;
        }
        let pressure = match notice.to_level() {
            xr::PerfSettingsNotificationLevelEXT::WARNING => Pressure::Warning,
            xr::PerfSettingsNotificationLevelEXT::IMPAIRED => Pressure::Impaired,
            _ => Pressure::Normal,
        };
        tracing::debug!("the OpenXR runtime on the GPU, {:?}: {pressure:?}", notice.sub_domain());
        self.slow_notices += u64::from(pressure != Pressure::Normal);
        self.notices.retain(|(from, _)| *from != notice.sub_domain());
        self.notices.push((notice.sub_domain(), pressure));
    }

    /// Returns the OpenXR instance.
    pub fn instance(&self) -> &xr::Instance {
        &self.runtime.instance
    }

    /// Handles the runtime's events, and begins and ends the session as they request.
    ///
    /// # Errors
    /// Returns [`HeadsetError::Lost`] if the session or the runtime is lost, or the error of a call.
    pub fn follow_events(&mut self) -> Result<SessionPhase, HeadsetError> {
        let mut storage = xr::EventDataBuffer::new();
        while let Some(event) = self.runtime.instance.poll_event(&mut storage).during("xrPollEvent")? {
            match event {
                xr::Event::SessionStateChanged(change) if change.session() == self.session.as_raw() => {
                    tracing::debug!("state of the OpenXR session: {:?}", change.state());
                    self.state = change.state();
                    match self.state {
                        xr::SessionState::READY => {
                            self.session.begin(VIEWS).during("xrBeginSession")?;
                            self.phase = SessionPhase::Running;
                        }
                        xr::SessionState::STOPPING => {
                            self.session.end().during("xrEndSession")?;
                            self.phase = SessionPhase::Idle;
                        }
                        xr::SessionState::EXITING => self.phase = SessionPhase::Ended,
                        xr::SessionState::LOSS_PENDING => return Err(HeadsetError::Lost { cause: "its session" }),
                        // Idle, synchronised, visible, focused: xrWaitFrame says whether there is something to draw.
                        _ => {}
                    }
                }
                xr::Event::InstanceLossPending(_) => return Err(HeadsetError::Lost { cause: "the runtime" }),
                // The event may arrive for each eye; both are queried.
                xr::Event::VisibilityMaskChangedKHR(_) if self.runtime.has_masks => {
                    self.hidden = hidden::query(&self.session)?;
                }
                xr::Event::PerfSettingsEXT(notice) => self.take_notice(notice),
                xr::Event::EventsLost(lost) => tracing::warn!("{} OpenXR events were lost", lost.lost_event_count()),
                _ => {}
            }
        }
        Ok(self.phase)
    }

    /// Requests the end of the session, which arrives as events.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub fn request_end(&mut self) -> Result<(), HeadsetError> {
        if self.phase == SessionPhase::Running {
            self.session.request_exit().during("xrRequestExitSession")?;
        } else {
            // A session that is not running has nothing to end.
            self.phase = SessionPhase::Ended;
        }
        Ok(())
    }
}

impl Drop for Headset {
    fn drop(&mut self) {
        // The GPU must not draw on images that are about to be dropped.
        self.gpu.wait();
    }
}

fn open_session(runtime: &Runtime, gpu: &Gpu, binding: Binding) -> Result<binding::Opened, HeadsetError> {
    binding::open_session(&runtime.instance, runtime.system, gpu, binding)
}

/// Creates the reference space of all poses, and returns the height of its floor: the stage that the user set up, if
/// there is one, else the position of the headset at the start.
fn open_space(session: &xr::Session<xr::Vulkan>) -> Result<(xr::Space, f64), HeadsetError> {
    let offered = session.enumerate_reference_spaces().during("xrEnumerateReferenceSpaces")?;
    let (kind, floor_m) = if offered.contains(&xr::ReferenceSpaceType::STAGE) {
        (xr::ReferenceSpaceType::STAGE, 0.0)
    } else {
        (xr::ReferenceSpaceType::LOCAL, -EYES_ABOVE_FLOOR_M)
    };
    let space = session.create_reference_space(kind, xr::Posef::IDENTITY).during("xrCreateReferenceSpace")?;
    Ok((space, floor_m))
}
