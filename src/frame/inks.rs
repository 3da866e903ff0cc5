//! The inks of a frame: runs the passes of layers that an [`InkPass`](crate::style::layers::InkPass) describes, and
//! collects the pictures of all layers for the composite.

use super::FrameInputs;
use crate::composite::DrawnInk;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::lines::crowd::thin;
use crate::lines::stereo::{agree, fade_out};
use crate::lines::strokes::stroke::INK;
use crate::lines::tone::ink::TONE_INK;
use crate::lines::{curvature, rims, smooth, threshold};
use crate::style::layers::{Channels, Fading};
use crate::style::{Layer, Lines, Style};
use crate::surface::rims::RIM;
use crate::surface::rows::ribbons::ROW_INK;
use crate::tones::balance::MARKS;
use crate::tones::water::WATER_INK;

/// The resources that the pass of a layer may bind.
pub(super) struct AtEye<'a> {
    pub(super) view: &'a Resource,
    pub(super) surface_id: &'a Target,
    pub(super) position: &'a Target,
    pub(super) normal: &'a Target,
    /// Colour and requested tone, with those of water.
    pub(super) tone: &'a Target,
    /// [`WATER`](crate::surface::water::WATER), or a single texel in a style without water.
    pub(super) water: &'a Target,
}

/// Draws the ink of a layer and returns its picture. `number` is how many layers of the same kind are below it. Returns
/// `None`, and draws nothing, for kinds of layers that have passes of their own.
pub(super) fn draw(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    layer: &Layer,
    number: usize,
    at_eye: &AtEye<'_>,
    targets: &mut Targets,
) -> Option<Target> {
    let pass = layer.kind().pass(inputs.rig.origin_m)?;
    let ink = targets.numbered(recorder.gpu(), pass.ink, number);
    let mut resources: Vec<Named> = vec![
        ("view", at_eye.view.clone()),
        ("rules", recorder.uniform_bytes("ink rules", &pass.rules)),
        ("surface_id", at_eye.surface_id.into()),
        ("position", at_eye.position.into()),
        ("normal", at_eye.normal.into()),
        ("tone", at_eye.tone.into()),
        ("water", at_eye.water.into()),
        ("ink", (&ink).into()),
    ];
    resources.extend(inputs.world.terrain.resources());
    recorder.pixels(pass.shader, ink.size_px(), &resources);
    Some(ink)
}

/// Returns the inks of a frame from the bottom to the top. Their number depends only on the style and the world, and
/// so does the variant of the composite: a layer that draws nothing in this frame, such as outlines where the land in
/// view has no holes, has an empty picture.
pub(super) fn drawn(style: &Style, lines: Option<&Lines>, pictures: &Pictures) -> Vec<DrawnInk> {
    let mut drawn = Vec::new();
    for own in style.ink_layers() {
        let Some(index) = own.layer else { continue };
        if let (Layer::Strokes(_), None, Some(lines), Some(line)) =
            (&style.layers[index], style.lines(), lines, &pictures.line)
        {
            // In a style with strokes instead of detected lines, trees have detected lines, below the strokes.
            let fading = Fading::OnNearest { faintest: lines.faintest, reach: lines.reach };
            drawn.push(DrawnInk { color: lines.ink, fading, channels: Channels::One(0), picture: line.clone() });
        }
        let picture = match &style.layers[index] {
            Layer::Lines(_) => pictures.line.clone(),
            Layer::Strokes(_) => pictures.strokes.clone(),
            Layer::Rims(_) => pictures.rim.clone(),
            Layer::Hatching(_) => pictures.marks.clone(),
            _ => pictures.of_layers.get(index).cloned().flatten(),
        };
        let picture = picture.unwrap_or_else(|| pictures.nothing.clone());
        drawn.push(DrawnInk { color: own.color, fading: own.ink.fading, channels: own.ink.channels, picture });
    }
    drawn
}

/// The pictures of the layers' inks in this frame; `None` where a layer draws nothing.
pub(super) struct Pictures {
    /// A single texel that is 0, which stands for pictures that are not there.
    pub(super) nothing: Target,
    /// The detected lines; those of trees only in a style with strokes instead.
    pub(super) line: Option<Target>,
    pub(super) strokes: Option<Target>,
    pub(super) rim: Option<Target>,
    pub(super) marks: Option<Target>,
    /// The pictures of all other layers, by the index of the layer in the style.
    pub(super) of_layers: Vec<Option<Target>>,
}

/// Returns the picture of a layer's ink in the last frame; `index` is that of the layer in the style.
pub(super) fn last<'a>(targets: &'a Targets, style: &Style, index: usize) -> Option<&'a Target> {
    let number = style.layers.number(index);
    match &style.layers[index] {
        Layer::Lines(_) => last_line(targets),
        Layer::Strokes(_) => targets.get(&INK),
        Layer::Rims(_) => targets.get(&RIM),
        Layer::Hatching(_) => targets.get(&MARKS),
        Layer::Rows(_) => targets.get(&ROW_INK),
        Layer::Water(_) => targets.get(&WATER_INK),
        Layer::ToneLines(_) => targets.get(&TONE_INK),
        layer => targets.get_numbered(layer.kind().pass(glam::DVec3::ZERO)?.ink, number),
    }
}

/// Returns the picture of detected lines that the last composite read: the output of the last of the passes that refine
/// them.
pub(super) fn last_line(targets: &Targets) -> Option<&Target> {
    let last = [
        &agree::AGREED,
        &thin::UNCROWDED,
        &smooth::SMOOTHED,
        &fade_out::FADED,
        &rims::RIMLESS,
        &curvature::CURVATURE_LINE,
        &threshold::LINE,
    ];
    last.into_iter().find_map(|kind| targets.get(kind))
}
