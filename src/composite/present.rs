//! Draws the picture, or those of two eyes, into a window. See `shaders/composite/present.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::full_screen::FullScreen;
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::composite::present::Present as PresentUniform;
use crate::scene::anaglyph::{Glasses, Mix};

/// The pictures that a window shows.
#[derive(Clone, Copy)]
pub(crate) enum Shown<'a> {
    /// The picture of one eye.
    One(&'a Target),
    /// The pictures of two eyes.
    Pair {
        left: &'a Target,
        right: &'a Target,
        /// The anaglyph glasses for which both pictures are mixed in the same pixels; `None` shows them side by side.
        glasses: Option<Glasses>,
    },
    /// Two pictures of the same view, each on its side of a divider.
    Divided {
        left: &'a Target,
        right: &'a Target,
        /// The divider, as a part of the window's width.
        at: f32,
    },
}

/// The pass that presents to a window.
pub(crate) struct PresentPass {
    full_screen: FullScreen,
    /// The window's format. The pass encodes to sRGB if the format does not.
    format: wgpu::TextureFormat,
}

impl PresentPass {
    /// Creates the pass for a window's format.
    pub(crate) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        Self { full_screen: FullScreen::new(gpu), format }
    }

    /// Draws `shown` over all of `window`, whose size is `window_px`, with `encoder`, which the caller submits next.
    pub(crate) fn run(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        shown: Shown<'_>,
        window: &wgpu::TextureView,
        window_px: [u32; 2],
    ) {
        let window_px = window_px.map(|side| side as f32);
        let mixed = |mix: &Mix| mix.map(|[red, green, blue]| [red, green, blue, 0.0]);
        let (side_by_side, [left_mix, right_mix]) = match shown {
            Shown::Pair { glasses: Some(glasses), .. } => (0, glasses.mixes().map(mixed)),
            Shown::Pair { glasses: None, .. } | Shown::One(_) | Shown::Divided { .. } => (1, Default::default()),
        };
        let divider = if let Shown::Divided { at, .. } = shown { at } else { 0.0 };
        let encode = u32::from(!self.format.is_srgb());
        let (picture, right) = match shown {
            Shown::One(picture) => (picture, picture),
            Shown::Pair { left, right, .. } | Shown::Divided { left, right, .. } => (left, right),
        };
        let uniform = PresentUniform {
            encode,
            side_by_side,
            window_px,
            left_mix,
            right_mix,
            picture_px: picture.size_px(),
            right_px: right.size_px(),
            divider,
            pad_0: Default::default(),
        };
        let mut resources = vec![("present", self.full_screen.uniform(gpu, "present", &uniform))];
        let fragment = match shown {
            Shown::One(picture) => {
                resources.push(("picture", picture.into()));
                "fragment"
            }
            Shown::Pair { left, right, .. } => {
                resources.extend([("picture", left.into()), ("right_picture", right.into())]);
                "pair"
            }
            Shown::Divided { left, right, .. } => {
                resources.extend([("picture", left.into()), ("right_picture", right.into())]);
                "divided"
            }
        };
        let pass = ("composite/present", fragment);
        self.full_screen.draw(gpu, encoder, pass, &resources, (window, self.format));
        self.full_screen.flush(gpu);
    }
}
