//! Tones, lines, paper and haze → the picture. See `shaders/composite/composite.wgsl`.

pub mod present;
pub mod sky;
pub mod temporal_aa;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
pub(crate) use crate::gpu::wgsl::composite::composite::Composite as CompositeUniform;
use crate::scene::Light;
use crate::scene::focus::FocusUniform;
use crate::style::color::linear_from_srgb;
use crate::style::{Lines, Style};

/// The picture: linear colour, opaque.
pub const PICTURE: TargetKind = TargetKind::storage("picture", wgpu::TextureFormat::Rgba16Float);
/// A target of one pixel, for layers that a style lacks: reading outside of it gives 0.
pub const NOTHING: TargetKind = TargetKind::storage("no line", wgpu::TextureFormat::R32Float);

/// Inputs and output of the pass.
pub struct Inputs<'a> {
    pub view: &'a Resource,
    /// The style, for paper, inks and sky.
    pub style: &'a Style,
    /// The lines of the style, or those of trees.
    pub lines: Option<&'a Lines>,
    /// The light of the scene, for haze and focus.
    pub light: &'a Light,
    /// Position of the surface, for haze and focus.
    pub position: &'a Target,
    /// Colour and tone.
    pub tone: &'a Target,
    /// [`sky::SKY`], of a style whose sky is more than a gradient.
    pub sky: Option<&'a Target>,
    /// The ink layers that are drawn over the tones.
    pub inks: Inks<'a>,
    /// Whether the picture is a sample of a mean ([`temporal_aa`]): then it has no grain, and its fourth channel is the
    /// ink of lines.
    pub is_sample: bool,
    pub picture: &'a Target,
}

/// The ink layers on the paper; a layer that a style lacks is [`NOTHING`].
#[derive(Clone, Copy)]
pub struct Inks<'a> {
    pub line: &'a Target,
    pub strokes: &'a Target,
    /// Ink of hatching marks.
    pub marks: &'a Target,
    /// Rows of hachures.
    pub rows: &'a Target,
    /// Cut lines, one family of planes per channel.
    pub cuts: &'a Target,
    /// Shorelines and water lines.
    pub water: &'a Target,
    /// Contour lines of height.
    pub heights: &'a Target,
    /// Rims of holes, in the first channel.
    pub rims: &'a Target,
    /// Lines from shading: dark lines in the first channel, highlight lines in the second.
    pub tone_lines: &'a Target,
}

/// Composites the layers into the picture.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let &Inputs { style, lines, light, .. } = inputs;
    let uniform = CompositeUniform {
        paper: style.paper.color.linear(),
        haze_m: light.haze_m as f32,
        ink: lines.map_or([0.0; 3], |lines| lines.ink.linear()),
        grain: if inputs.is_sample { 0.0 } else { style.paper.grain },
        sky_zenith: style.sky.zenith.linear(),
        faintest_line: lines.map_or(0.0, |lines| lines.faintest),
        sky_horizon: style.sky.horizon.linear(),
        line_strength: f32::from(u8::from(lines.is_some())),
        haze: light.haze_srgb.map_or(style.haze.color.linear(), |color| color.map(linear_from_srgb)),
        faintest_tone: style.haze.faintest_tone,
        line_reach: lines.map_or(1.0, |lines| lines.reach),
        stroke_ink: style.strokes.as_ref().map_or([0.0; 3], |strokes| strokes.ink.linear()),
        mark_ink: style.hatching.as_ref().map_or([0.0; 3], |hatching| hatching.ink.linear()),
        faintest_mark: style.hatching.as_ref().map_or(1.0, |hatching| hatching.faintest),
        is_sample: u32::from(inputs.is_sample),
        water_ink: style.water.as_ref().map_or([0.0; 3], |water| water.ink.linear()),
        faintest_water: style.water.as_ref().map_or(1.0, |water| water.faintest),
        sky_ink: style.sky.ink.linear(),
        border: style.paper.border.linear(),
        is_bordered: u32::from(style.paper.is_bordered() && !inputs.is_sample),
        border_px: [style.paper.margin_px, style.paper.border_px],
        horizon: style.panorama.horizon(),
        height_ink_color: style.height_lines.as_ref().map_or([0.0; 3], |lines| lines.ink.linear()),
        faintest_height: style.height_lines.as_ref().map_or(1.0, |lines| lines.faintest),
        foot_px: style.paper.foot_px,
        unfocused: style.unfocused(),
        faintest_rim: style.rims.faintest,
        rim_ink: style.rim_ink().linear(),
        faintest_tone_line: style.tone_lines.as_ref().map_or(1.0, |lines| lines.faintest),
        tone_line_ink: style.tone_lines.as_ref().map_or([0.0; 3], |lines| lines.ink.linear()),
        tone_line_reach: style.tone_lines.as_ref().map_or(1.0, |lines| lines.reach),
        highlight_ink: style.tone_lines.as_ref().map_or([0.0; 3], |lines| lines.highlight_ink.linear()),
        faintest_row: style.rows.as_ref().map_or(1.0, |rows| rows.faintest),
        row_ink: style.rows.as_ref().map_or([0.0; 3], |rows| rows.ink.linear()),
        faintest_cut: style.cuts.as_ref().map_or(1.0, |cuts| cuts.faintest),
        cut_ink: style.cuts.as_ref().map_or([0.0; 3], |cuts| cuts.ink.linear()),
        ..CompositeUniform::default()
    };
    let mut resources: Vec<Named> = vec![
        ("view", inputs.view.clone()),
        ("composite", recorder.uniform("composite", &uniform)),
        ("focus", FocusUniform::on_gpu(recorder, light.focus.as_ref())),
        ("position", inputs.position.into()),
        ("tone", inputs.tone.into()),
        ("line", inputs.inks.line.into()),
        ("ink", inputs.inks.strokes.into()),
        ("marks", inputs.inks.marks.into()),
        ("rows", inputs.inks.rows.into()),
        ("cuts", inputs.inks.cuts.into()),
        ("water_ink", inputs.inks.water.into()),
        ("height_ink", inputs.inks.heights.into()),
        ("rims", inputs.inks.rims.into()),
        ("tone_lines", inputs.inks.tone_lines.into()),
        ("picture", inputs.picture.into()),
    ];
    resources.extend(inputs.sky.map(|sky| ("sky", sky.into())));
    let definitions: &[&str] = if inputs.sky.is_some() { &["SKY"] } else { &[] };
    recorder.pixels(Compute { name: "composite/composite", definitions }, inputs.picture.size_px(), &resources);
}
