//! The inks of a frame: runs the passes that layers describe by an [`InkPass`](crate::style::layers::InkPass), and
//! collects the pictures of all layers for the composite.

use super::{FrameInputs, line_gaps};
use crate::composite::DrawnInk;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::lines::crowd::thin;
use crate::lines::stereo::{agree, fade_out};
use crate::lines::{curvature, drainage, draped, rims, smooth, threshold};
use crate::style::layers::{Channels, Fading, HEIGHT_LINES, LandOfPass};
use crate::style::{Drainage, Features, Layer, Lines, Style, StyleInk};

/// The resources that the pass of a layer may bind.
pub(super) struct EyeInputs<'a> {
    pub(super) view: &'a Resource,
    pub(super) surface_id: &'a Target,
    pub(super) distance: &'a Target,
    pub(super) normal: &'a Target,
    /// Colour and requested tone, water included.
    pub(super) tone: &'a Target,
    /// [`WATER`](crate::surface::water::WATER), or a single texel in a style without water.
    pub(super) water: &'a Target,
}

/// Draws the ink of a layer and returns its picture. `number` is that of the layer among those of its kind, from 0.
/// Returns `None`, and draws nothing, for a layer without an ink, and for kinds that have passes of their own.
pub(super) fn draw(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    layer: &Layer,
    number: usize,
    at_eye: &EyeInputs<'_>,
    targets: &mut Targets,
) -> Option<Target> {
    let (exaggeration, sea_level_m) = (inputs.world.exaggeration(), inputs.world.sea_level_m());
    let pass = layer.behaviour().pass(LandOfPass { origin_m: inputs.rig.origin_m, exaggeration, sea_level_m })?;
    let ink = targets.numbered(recorder.gpu(), pass.ink, number);
    let mut resources: Vec<Named> = vec![
        ("view", at_eye.view.clone()),
        ("rules", recorder.uniform_bytes("ink rules", &pass.rules)),
        ("surface_id", at_eye.surface_id.into()),
        ("distance_m", at_eye.distance.into()),
        ("normal", at_eye.normal.into()),
        ("tone", at_eye.tone.into()),
        ("water", at_eye.water.into()),
        ("ink", (&ink).into()),
    ];
    if pass.shader == HEIGHT_LINES {
        resources.push(("gaps", line_gaps::upload(recorder, inputs).binding()));
    }
    resources.extend(inputs.world.terrain.resources());
    recorder.pixels(pass.shader, ink.size_px(), &resources);
    Some(ink)
}

/// Draws streams or ridge lines, and returns their picture. `number` is that of the layer among those of its kind.
/// Returns `None`, and draws nothing, in views without them.
pub(super) fn draw_drainage(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    (layer, number): (&Drainage, usize),
    at_eye: &EyeInputs<'_>,
    targets: &mut Targets,
) -> Option<Target> {
    let of = layer.drawn_lines()?;
    let ink = targets.numbered(recorder.gpu(), &drainage::DRAINAGE_INK, number);
    let drawn = drainage::Inputs {
        view: at_eye.view,
        terrain: inputs.world.terrain.uniform(),
        style: layer,
        lines: inputs.world.drainage().lines(of),
        origin_m: inputs.rig.origin_m,
        distance: at_eye.distance,
        water: at_eye.water,
        ink: &ink,
    };
    drainage::run(recorder, &drawn);
    Some(ink)
}

/// Draws features on the land, and returns their picture. `number` is that of the layer among those of its kind. Returns
/// `None`, and draws nothing, in a world without features.
pub(super) fn draw_features(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    (layer, number): (&Features, usize),
    at_eye: &EyeInputs<'_>,
    targets: &mut Targets,
) -> Option<Target> {
    let (features, terrain) = (inputs.world.features()?, &inputs.world.terrain);
    let ink = targets.numbered(recorder.gpu(), &draped::FEATURE_INK, number);
    let drawn = draped::Inputs {
        view: at_eye.view,
        terrain: &terrain.resources(),
        style: layer,
        layer: features.layer(number),
        origin_m: inputs.rig.origin_m,
        distance: at_eye.distance,
        normal: at_eye.normal,
        ink: &ink,
    };
    draped::run(recorder, &drawn);
    Some(ink)
}

/// The pictures of a frame's inks, for the composite.
pub(super) struct Pictures<'a> {
    /// The picture of each layer, by the index of the layer in the style; `None` where a layer draws nothing.
    pub(super) of_layers: &'a [Option<Target>],
    /// The detected lines: those of the style, or those of trees in a style with strokes instead.
    pub(super) line: Option<&'a Target>,
    /// A placeholder for missing pictures: a single texel that is 0.
    pub(super) nothing: &'a Target,
}

/// Returns the inks of a frame from the bottom to the top, without that of the sky. `drawn_lines` are the settings of
/// the detected lines in `pictures`. The number of inks depends only on the style and the world, and so does the
/// variant of the composite: a layer that draws nothing in this frame, such as rims where the land in view has no
/// holes, has an empty picture.
pub(super) fn drawn(style: &Style, drawn_lines: Option<&Lines>, pictures: &Pictures<'_>) -> Vec<DrawnInk> {
    // The detected lines are those of trees if the style has none itself.
    let tree_lines = drawn_lines.zip(pictures.line).filter(|_| style.lines().is_none()).map(|(lines, picture)| {
        let fading = Fading::OnNearest { faintest: lines.faintest, reach: lines.reach };
        DrawnInk { color: lines.ink, fading, channels: Channels::One(0), picture: picture.clone() }
    });
    let mut drawn = Vec::new();
    for StyleInk { layer, color, ink, .. } in style.inks() {
        let Some(index) = layer else { continue };
        if matches!(style.layers[index], Layer::Strokes(_)) {
            // The lines of trees are below the strokes.
            drawn.extend(tree_lines.clone());
        }
        let picture = pictures.of_layers.get(index).and_then(Option::as_ref).unwrap_or(pictures.nothing).clone();
        drawn.push(DrawnInk { color, fading: ink.fading, channels: ink.channels, picture });
    }
    drawn
}

/// Returns the picture of detected lines that the last composite read: the output of the final one among the passes
/// that refine them.
pub(super) fn final_line(targets: &Targets) -> Option<&Target> {
    let from_final_to_first = [
        &agree::AGREED,
        &thin::UNCROWDED,
        &smooth::SMOOTHED,
        &fade_out::FADED,
        &rims::RIMLESS,
        &curvature::CURVATURE_LINE,
        &threshold::LINE,
    ];
    from_final_to_first.into_iter().find_map(|kind| targets.get(kind))
}
