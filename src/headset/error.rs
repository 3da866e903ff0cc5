//! Errors of the headset, each in one line that says what to do.

use openxr as xr;

use crate::file::FileError;
use crate::gpu::GpuError;
use crate::style::StyleError;

/// Why a flight in a headset could not start, or why it ended.
#[derive(Debug, thiserror::Error)]
pub enum HeadsetError {
    /// OpenXR is not installed.
    #[error(
        "--vr: no OpenXR loader found ({cause}); install libopenxr-loader1 (Debian), openxr (Fedora, Arch), or the \
         software of the headset"
    )]
    NoLoader {
        /// Message of the system.
        cause: String,
    },
    /// No runtime is active.
    #[error(
        "--vr: no OpenXR runtime is active ({cause}); start the software of the headset (SteamVR, Monado, WiVRn) and \
         make it the active runtime, or name its manifest in XR_RUNTIME_JSON"
    )]
    NoRuntime {
        /// Error of the loader.
        cause: xr::sys::Result,
    },
    /// A runtime is active, but it has no connection to its service.
    #[error(
        "--vr: an OpenXR runtime is active, but it does not answer ({call}: {cause}): its service is not running, or the \
         headset is not connected; start the service (SteamVR, monado-service, the WiVRn server), connect the headset, \
         and start hachure again"
    )]
    NoService {
        /// Name of the OpenXR function.
        call: &'static str,
        /// Error of the runtime.
        cause: xr::sys::Result,
    },
    /// The runtime lacks something that drawing needs.
    #[error("--vr: {runtime} lacks {what}, which hachure requires; use another runtime")]
    Lacks {
        /// Name of the runtime.
        runtime: String,
        /// The missing extension or other feature.
        what: &'static str,
    },
    /// No headset is connected.
    #[error("--vr: {runtime} finds no headset; connect the headset, switch it on, and start hachure again")]
    NoHeadset {
        /// Name of the runtime.
        runtime: String,
    },
    /// Vulkan cannot be used with the headset.
    #[error(
        "--vr: Vulkan cannot draw for the headset ({cause}); install a Vulkan driver for the GPU to which it is connected"
    )]
    NoVulkan {
        /// Cause, as text.
        cause: String,
    },
    /// The pictures would be larger than the GPU allows.
    #[error(
        "--vr: the headset requests pictures of {width}x{height} pixels; this GPU allows at most {most} on each side"
    )]
    Size {
        /// Width of one eye's picture, in pixels.
        width: u32,
        /// Height of one eye's picture, in pixels.
        height: u32,
        /// Largest side that the GPU allows.
        most: u32,
    },
    /// The field of view is empty.
    #[error(
        "--vr: the headset reports an empty field of view: {left} to {right} rad across, {down} to {up} rad upwards"
    )]
    Lens {
        /// Angle to the left edge, in radians; usually negative.
        left: f32,
        /// Angle to the right edge, in radians.
        right: f32,
        /// Angle to the upper edge, in radians.
        up: f32,
        /// Angle to the lower edge, in radians; usually negative.
        down: f32,
    },
    /// The session was lost.
    #[error(
        "--vr: the connection to the headset was lost ({cause}); check that it is running, and start hachure again"
    )]
    Lost {
        /// The lost part.
        cause: &'static str,
    },
    /// A call to the runtime failed.
    #[error("--vr: the OpenXR runtime failed in {call}: {code}")]
    Runtime {
        /// Name of the OpenXR function.
        call: &'static str,
        /// Result code of the call.
        code: xr::sys::Result,
    },
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The style is invalid.
    #[error(transparent)]
    Style(#[from] StyleError),
    /// The report of `--frames` cannot be written.
    #[error(transparent)]
    Output(#[from] FileError),
    /// The world cannot be opened.
    #[error(transparent)]
    World(anyhow::Error),
}

/// Returns the error of a call that is made before the headset is known: a runtime whose service is not running fails
/// there, with one of several codes.
pub(super) fn of_start(call: &'static str, code: xr::sys::Result) -> HeadsetError {
    use xr::sys::Result as Code;
    match code {
        Code::ERROR_RUNTIME_UNAVAILABLE
        | Code::ERROR_RUNTIME_FAILURE
        | Code::ERROR_INITIALIZATION_FAILED
        | Code::ERROR_INSTANCE_LOST => HeadsetError::NoService { call, cause: code },
        code => HeadsetError::Runtime { call, code },
    }
}

/// Converts a failed call to an error that names the call.
pub(super) trait During<T> {
    /// Returns the value, or an error that names `call`.
    ///
    /// # Errors
    /// Returns [`HeadsetError::Lost`] or [`HeadsetError::Runtime`].
    fn during(self, call: &'static str) -> Result<T, HeadsetError>;
}

impl<T> During<T> for xr::Result<T> {
    fn during(self, call: &'static str) -> Result<T, HeadsetError> {
        self.map_err(|code| match code {
            xr::sys::Result::ERROR_SESSION_LOST => HeadsetError::Lost { cause: "its session" },
            xr::sys::Result::ERROR_INSTANCE_LOST => HeadsetError::Lost { cause: "the runtime" },
            code => HeadsetError::Runtime { call, code },
        })
    }
}
