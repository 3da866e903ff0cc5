//! What can be wrong with a headset, each in one line that says what to do.

use openxr as xr;

use crate::file::FileError;
use crate::gpu::GpuError;
use crate::style::StyleError;

/// Why there is no flight in a headset, or why it ended.
#[derive(Debug, thiserror::Error)]
pub enum HeadsetError {
    /// OpenXR is not installed.
    #[error(
        "--vr: there is no OpenXR loader ({cause}); install libopenxr-loader1 (Debian), openxr (Fedora, Arch), or the \
         software of the headset"
    )]
    NoLoader {
        /// What the system said.
        cause: String,
    },
    /// No runtime is active.
    #[error(
        "--vr: no OpenXR runtime is active ({cause}); start the software of the headset (SteamVR, Monado, WiVRn) and \
         make it the active runtime, or name its manifest in XR_RUNTIME_JSON"
    )]
    NoRuntime {
        /// What the loader said.
        cause: xr::sys::Result,
    },
    /// The runtime does not offer what drawing needs.
    #[error("--vr: {runtime} lacks {what}, without which hachure cannot draw for it; another runtime is needed")]
    Lacks {
        /// Its name.
        runtime: String,
        /// The extension, or another part.
        what: &'static str,
    },
    /// No headset is connected.
    #[error("--vr: {runtime} finds no headset; connect it, switch it on, and start hachure again")]
    NoHeadset {
        /// The runtime's name.
        runtime: String,
    },
    /// There is no Vulkan for the headset.
    #[error(
        "--vr: Vulkan cannot draw for the headset ({cause}); it needs a driver of the GPU that the headset hangs on"
    )]
    NoVulkan {
        /// What is wrong.
        cause: String,
    },
    /// Pictures of a size that the runtime or the GPU does not have.
    #[error("--vr: the headset wants pictures of {width}x{height} pixels, and {most} to a side is the most here")]
    Size {
        /// Of one eye.
        width: u32,
        /// The same.
        height: u32,
        /// The most.
        most: u32,
    },
    /// A lens that shows nothing.
    #[error("--vr: the headset's field of view is empty: {left} to {right} across, {down} to {up} up (radians)")]
    Lens {
        /// The runtime's angles.
        left: f32,
        /// The same.
        right: f32,
        /// The same.
        up: f32,
        /// The same.
        down: f32,
    },
    /// The session ended without being asked.
    #[error("--vr: the connection to the headset was lost ({cause}); see whether it runs, and start hachure again")]
    Lost {
        /// What was lost.
        cause: &'static str,
    },
    /// The runtime refused.
    #[error("--vr: the headset's runtime failed in {call}: {code}")]
    Runtime {
        /// The function of OpenXR.
        call: &'static str,
        /// What it returned.
        code: xr::sys::Result,
    },
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The style does not hold.
    #[error(transparent)]
    Style(#[from] StyleError),
    /// What `--frames` tells cannot be written.
    #[error(transparent)]
    Output(#[from] FileError),
    /// The world does not open.
    #[error(transparent)]
    World(anyhow::Error),
}

/// Names the call that failed.
pub trait During<T> {
    /// The value, or the error of a call.
    ///
    /// # Errors
    /// [`HeadsetError::Lost`], [`HeadsetError::Runtime`].
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
