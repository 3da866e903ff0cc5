//! Combines paper, sky, tones, haze, focus and inks into the picture. See `shaders/composite/composite.wgsl`.

pub(crate) mod present;
pub(crate) mod sky;
pub(crate) mod temporal_aa;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::{Compute, defined};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::composite::composite::{
    ALREADY_FADED, Composite as CompositeUniform, Ink as InkUniform, ON_NEAREST, ON_SURFACE, ON_SURFACE_WITH_TONE,
};
use crate::scene::Light;
use crate::scene::focus::FocusUniform;
use crate::style::color::linear_from_srgb;
use crate::style::layers::{Channels, Fading, MAX_INKS};
use crate::style::{Color, Style};

/// The picture: linear colour, opaque.
pub const PICTURE: TargetKind = TargetKind::storage(
    "picture",
    wgpu::TextureFormat::Rgba16Float,
    Group::Whole.shows("The picture itself, as linear colour"),
);
/// A placeholder for pictures that a style lacks: one pixel that is 0, as is the value read outside of it.
pub(crate) const NOTHING: TargetKind = TargetKind::storage(
    "no line",
    wgpu::TextureFormat::R32Float,
    Group::Lines.shows("One texel that stands for the lines of a style that has none"),
);

/// The shader's variables for the pictures of inks, from the bottom to the top.
const NAMES: [&str; MAX_INKS] = [
    "ink_0", "ink_1", "ink_2", "ink_3", "ink_4", "ink_5", "ink_6", "ink_7", "ink_8", "ink_9", "ink_10", "ink_11",
    "ink_12",
];
/// The shader's definitions for inks.
const INKS: [&str; MAX_INKS] = [
    "INK_0", "INK_1", "INK_2", "INK_3", "INK_4", "INK_5", "INK_6", "INK_7", "INK_8", "INK_9", "INK_10", "INK_11",
    "INK_12",
];

// The shader's array of inks has as many entries.
const _: fn(CompositeUniform) -> [InkUniform; MAX_INKS] = |uniform| uniform.inks;

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The style, for paper and sky.
    pub style: &'a Style,
    /// The light of the scene, for haze and focus.
    pub light: &'a Light,
    /// Position of the surface, for haze and focus.
    pub distance: &'a Target,
    /// Colour of the tones, and requested tone.
    pub tone: &'a Target,
    /// [`sky::SKY`], of a style whose sky is more than a gradient.
    pub sky: Option<&'a Target>,
    /// The inks that are drawn over the tones, from the bottom to the top; at most [`MAX_INKS`].
    pub inks: &'a [DrawnInk],
    /// Whether the picture is a sample of the temporal mean ([`temporal_aa`]), drawn with a jittered lens. Then it has
    /// no grain and no border, and its fourth channel is the ink of detected lines.
    pub is_sample: bool,
    pub picture: &'a Target,
}

/// An ink of a frame.
#[derive(Clone, Debug)]
pub(crate) struct DrawnInk {
    pub color: Color,
    pub fading: Fading,
    /// The channels of `picture` that hold the ink.
    pub channels: Channels,
    pub picture: Target,
}

impl DrawnInk {
    fn uniform(&self) -> InkUniform {
        let (fading, faintest, reach) = match self.fading {
            Fading::AlreadyFaded => (ALREADY_FADED, 1.0, 1.0),
            Fading::OnNearest { faintest, reach } => (ON_NEAREST, faintest, reach),
            Fading::OnSurface { faintest, reach, follows_tone } => {
                (if follows_tone { ON_SURFACE_WITH_TONE } else { ON_SURFACE }, faintest, reach)
            }
        };
        let channel_mask = match self.channels {
            Channels::One(index) => std::array::from_fn(|channel| if channel == index { 1.0 } else { 0.0 }),
            Channels::Crossed(_) => [0.0; 4],
        };
        InkUniform {
            color: self.color.linear(),
            faintest,
            channel_mask,
            reach,
            fading,
            is_crossed: u32::from(matches!(self.channels, Channels::Crossed(_))),
            ..InkUniform::default()
        }
    }
}

/// Draws the picture.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let &Inputs { style, light, .. } = inputs;
    debug_assert!(inputs.inks.len() <= MAX_INKS, "a style with more inks is refused");
    let inks = &inputs.inks[..inputs.inks.len().min(MAX_INKS)];
    let mut uniform = CompositeUniform {
        paper: style.paper.color.linear(),
        haze_m: light.haze_m as f32,
        sky_zenith: style.sky.zenith.linear(),
        grain: if inputs.is_sample { 0.0 } else { style.paper.grain },
        sky_horizon: style.sky.horizon.linear(),
        faintest_tone: style.haze.faintest_tone,
        haze: light.haze_srgb.map_or(style.haze.color.linear(), |color| color.map(linear_from_srgb)),
        is_sample: u32::from(inputs.is_sample),
        sky_ink: style.sky.ink.linear(),
        border: style.paper.border.linear(),
        foot_px: style.paper.foot_px,
        border_px: [style.paper.margin_px, style.paper.border_px],
        horizon: style.panorama.horizon(),
        unfocused: style.unfocused(),
        ..CompositeUniform::default()
    };
    for (uniform, ink) in uniform.inks.iter_mut().zip(inks) {
        *uniform = ink.uniform();
    }
    let mut resources: Vec<Named> = vec![
        ("view", inputs.view.clone()),
        ("composite", recorder.uniform("composite", &uniform)),
        ("focus", FocusUniform::on_gpu(recorder, light.focus.as_ref())),
        ("distance_m", inputs.distance.into()),
        ("tone", inputs.tone.into()),
        ("picture", inputs.picture.into()),
    ];
    resources.extend(NAMES.iter().zip(inks).map(|(name, ink)| (*name, (&ink.picture).into())));
    resources.extend(inputs.sky.map(|sky| ("sky", sky.into())));
    let mut symbols = [("", false); MAX_INKS + 4];
    symbols[..4].copy_from_slice(&[
        ("SKY", inputs.sky.is_some()),
        ("LINES", inks.iter().any(|ink| matches!(ink.fading, Fading::OnNearest { .. }))),
        ("GRAIN", uniform.grain > 0.0),
        ("BORDERED", style.paper.is_bordered() && !inputs.is_sample),
    ]);
    for (number, (symbol, name)) in symbols[4..].iter_mut().zip(INKS).enumerate() {
        *symbol = (name, number < inks.len());
    }
    let definitions = defined(symbols);
    recorder.pixels(Compute { name: "composite/composite", definitions }, inputs.picture.size_px(), &resources);
}
