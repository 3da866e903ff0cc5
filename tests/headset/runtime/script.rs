//! The script of the runtime, from environment variables. Frames count from 0, as `xrEndFrame` ends them, from the
//! first one that shows something.

use std::path::PathBuf;

use openxr_sys as xr;

/// All settings of the runtime.
pub(crate) struct Script {
    /// `HACHURE_XR_LOG`: file to which violations are appended, one per line.
    pub log: Option<PathBuf>,
    /// `HACHURE_XR_HEADSET=none`: no headset is connected.
    pub has_headset: bool,
    /// `HACHURE_XR_SERVICE=-2`: the service is not running, so no instance can be created; the number is the error.
    pub without_service: Option<xr::Result>,
    /// `HACHURE_XR_SYSTEM=-2`: the service is not running, which shows when the headset is looked for.
    pub without_system: Option<xr::Result>,
    /// `HACHURE_XR_VULKAN=none`: the runtime has no extension for Vulkan.
    pub has_vulkan: bool,
    /// `HACHURE_XR_STAGE=none`: no stage was set up.
    pub has_stage: bool,
    /// `HACHURE_XR_LOSE_SESSION=N`: the runtime announces the loss of the session after frame N.
    pub lose_session: Option<u64>,
    /// `HACHURE_XR_BREAK_SESSION=N`: the session is lost without an event.
    pub break_session: Option<u64>,
    /// `HACHURE_XR_LOSE_INSTANCE=N`: the runtime announces the loss of the instance.
    pub lose_instance: Option<u64>,
    /// `HACHURE_XR_BREAK_INSTANCE=N`: the instance is lost without an event.
    pub break_instance: Option<u64>,
    /// `HACHURE_XR_STOP=N`: the user ends the program.
    pub stop: Option<u64>,
    /// `HACHURE_XR_PAUSE=N`: the session ends and may begin again.
    pub pause: Option<u64>,
    /// `HACHURE_XR_OFF=A-B`: the headset is off from frame A to frame B.
    pub off: Option<[u64; 2]>,
    /// `HACHURE_XR_SIZES=96x80,96x80`: sizes of the eyes' images, in pixels.
    pub sizes_px: [[u32; 2]; 2],
    /// `HACHURE_XR_FORMATS=43,97`: offered formats, by Vulkan's numbers.
    pub formats: Vec<i64>,
    /// `HACHURE_XR_IPD=0.063`: distance between the eyes.
    pub ipd_m: f32,
    /// `HACHURE_XR_MOTION=none`: the head does not move.
    pub moves: bool,
    /// `HACHURE_XR_TRACKING=A-B`: the head is not tracked from frame A to frame B.
    pub untracked: Option<[u64; 2]>,
    /// `HACHURE_XR_PROFILE`: the interaction profile of the controllers.
    pub profile: String,
    /// `HACHURE_XR_PUSHES=A-B:/user/hand/left/input/thumbstick:X:Y,…`: a control that is held from frame A to before
    /// frame B. Without X and Y a button is pressed.
    pub pushes: Vec<Push>,
    /// `HACHURE_XR_MASK=corners | N`: a mask of hidden areas, which changes after frame N.
    pub has_mask: bool,
    pub change_mask: Option<u64>,
    /// `HACHURE_XR_HOT=A-B`: the GPU is too slow for the runtime from frame A to frame B, of which it gives notice.
    pub hot: Option<[u64; 2]>,
    /// `HACHURE_XR_DUMP=folder`: folder for every submitted image, and a table of poses.
    pub dump: Option<PathBuf>,
}

/// A control that is held down.
pub(crate) struct Push {
    pub frames: [u64; 2],
    pub path: String,
    pub value: [f32; 2],
}

fn variable(name: &str) -> Option<String> {
    std::env::var(format!("HACHURE_XR_{name}")).ok()
}

fn frame(name: &str) -> Option<u64> {
    variable(name).map(|text| text.parse().unwrap())
}

fn error(name: &str) -> Option<xr::Result> {
    variable(name).map(|text| xr::Result::from_raw(text.parse().unwrap()))
}

fn range(text: &str) -> [u64; 2] {
    let (from, to) = text.split_once('-').unwrap();
    [from.parse().unwrap(), to.parse().unwrap()]
}

impl Script {
    pub(crate) fn read() -> Self {
        let is_there = |name: &str| variable(name).is_none_or(|text| text != "none");
        let size = |text: &str| {
            let (width, height) = text.split_once('x').unwrap();
            [width.parse().unwrap(), height.parse().unwrap()]
        };
        let sizes = variable("SIZES").unwrap_or_else(|| "96x80,96x80".to_owned());
        let (left, right) = sizes.split_once(',').unwrap();
        let formats = variable("FORMATS").unwrap_or_else(|| "43,50,97".to_owned());
        let pushes = variable("PUSHES").unwrap_or_default();
        Self {
            log: variable("LOG").map(PathBuf::from),
            has_headset: is_there("HEADSET"),
            without_service: error("SERVICE"),
            without_system: error("SYSTEM"),
            has_vulkan: is_there("VULKAN"),
            has_stage: is_there("STAGE"),
            lose_session: frame("LOSE_SESSION"),
            break_session: frame("BREAK_SESSION"),
            lose_instance: frame("LOSE_INSTANCE"),
            break_instance: frame("BREAK_INSTANCE"),
            stop: frame("STOP"),
            pause: frame("PAUSE"),
            off: variable("OFF").map(|text| range(&text)),
            sizes_px: [size(left), size(right)],
            formats: formats.split(',').map(|text| text.parse().unwrap()).collect(),
            ipd_m: variable("IPD").map_or(0.063, |text| text.parse().unwrap()),
            moves: is_there("MOTION"),
            untracked: variable("TRACKING").map(|text| range(&text)),
            profile: variable("PROFILE").unwrap_or_else(|| "/interaction_profiles/oculus/touch_controller".to_owned()),
            pushes: pushes.split(',').filter(|text| !text.is_empty()).map(Push::read).collect(),
            has_mask: variable("MASK").is_some(),
            change_mask: variable("MASK").and_then(|text| text.parse().ok()),
            hot: variable("HOT").map(|text| range(&text)),
            dump: variable("DUMP").map(PathBuf::from),
        }
    }
}

impl Push {
    fn read(text: &str) -> Self {
        let mut parts = text.split(':');
        let frames = range(parts.next().unwrap());
        let path = parts.next().unwrap().to_owned();
        let mut number = || parts.next().map_or(1.0, |text| text.parse().unwrap());
        Self { frames, path, value: [number(), number()] }
    }
}
