//! What the environment asks of the runtime. Frames count from 0, as `xrEndFrame` ends
//! them, from the first one that shows something.

use std::path::PathBuf;

/// All of it.
pub struct Script {
    /// `HACHURE_XR_LOG`: where violations go, a line each.
    pub log: Option<PathBuf>,
    /// `HACHURE_XR_HEADSET=none`: nothing is connected.
    pub has_headset: bool,
    /// `HACHURE_XR_VULKAN=none`: no extension for Vulkan.
    pub has_vulkan: bool,
    /// `HACHURE_XR_STAGE=none`: nobody set up a room.
    pub has_stage: bool,
    /// `HACHURE_XR_LOSE_SESSION=N`: it is told to be lost after frame N.
    pub lose_session: Option<u64>,
    /// `HACHURE_XR_BREAK_SESSION=N`: it is lost without a word.
    pub break_session: Option<u64>,
    /// `HACHURE_XR_LOSE_INSTANCE=N`: the runtime says that it goes.
    pub lose_instance: Option<u64>,
    /// `HACHURE_XR_BREAK_INSTANCE=N`: it goes without a word.
    pub break_instance: Option<u64>,
    /// `HACHURE_XR_STOP=N`: the user ends the program.
    pub stop: Option<u64>,
    /// `HACHURE_XR_PAUSE=N`: the session ends and may begin again.
    pub pause: Option<u64>,
    /// `HACHURE_XR_OFF=A-B`: the headset is off from frame A to frame B.
    pub off: Option<[u64; 2]>,
    /// `HACHURE_XR_SIZES=96x80,96x80`.
    pub sizes_px: [[u32; 2]; 2],
    /// `HACHURE_XR_FORMATS=43,97`: Vulkan's numbers.
    pub formats: Vec<i64>,
    /// `HACHURE_XR_IPD=0.063`.
    pub ipd_m: f32,
    /// `HACHURE_XR_MOTION=none`: the head rests.
    pub moves: bool,
    /// `HACHURE_XR_TRACKING=A-B`: the head is not known from frame A to B.
    pub untracked: Option<[u64; 2]>,
    /// `HACHURE_XR_PROFILE`: which controllers there are.
    pub profile: String,
    /// `HACHURE_XR_PUSHES=A-B:/user/hand/left/input/thumbstick:X:Y,…`: held from frame A to before frame B. A button is
    /// down without X and Y.
    pub pushes: Vec<Push>,
    /// `HACHURE_XR_MASK=corners | N`: a mask of hidden areas, which is another one after frame N.
    pub has_mask: bool,
    pub change_mask: Option<u64>,
    /// `HACHURE_XR_DUMP=folder`: every image that is shown, and a table of poses.
    pub dump: Option<PathBuf>,
}

/// A control that is held.
pub struct Push {
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

fn range(text: &str) -> [u64; 2] {
    let (from, to) = text.split_once('-').unwrap();
    [from.parse().unwrap(), to.parse().unwrap()]
}

impl Script {
    pub fn read() -> Self {
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
