//! The hatching of an eye, and for files of lines each of its layers by itself.

use crate::gpu::recorder::Recorder;
use crate::gpu::target::{TargetKind, Targets};
use crate::style::hatching::{MOST_LAYERS, Scale};
use crate::tones::{balance, fractal_hatching, hatching};

/// What a layer's marks ink, and would if they were darker.
const LAYER_COVER: TargetKind = TargetKind::storage("cover of a layer", wgpu::TextureFormat::Rgba16Float);
/// The ink of each layer.
pub(super) const LAYER_INKS: [TargetKind; MOST_LAYERS] = [
    TargetKind::storage("marks of layer 1", wgpu::TextureFormat::R32Float),
    TargetKind::storage("marks of layer 2", wgpu::TextureFormat::R32Float),
    TargetKind::storage("marks of layer 3", wgpu::TextureFormat::R32Float),
    TargetKind::storage("marks of layer 4", wgpu::TextureFormat::R32Float),
];

/// Marks as the style scales them.
pub(super) fn hatch(recorder: &mut Recorder<'_>, marks: &hatching::Inputs<'_>) {
    match marks.hatching.scale {
        Scale::Blend => hatching::run(recorder, marks),
        Scale::Add => fractal_hatching::run(recorder, marks),
    }
}

/// Each layer alone, as dark as it is among the others: their balance counts.
pub(super) fn draw(
    recorder: &mut Recorder<'_>,
    marks: &hatching::Inputs<'_>,
    balance: &balance::Inputs,
    targets: &mut Targets,
) {
    let cover = &targets.whole(recorder.gpu(), &LAYER_COVER);
    for (layer, kind) in LAYER_INKS.iter().enumerate().take(marks.hatching.layers.len()) {
        hatch(recorder, &hatching::Inputs { layer: Some(layer), cover, ..*marks });
        let ink = targets.whole(recorder.gpu(), kind);
        balance::draw(recorder, &balance::Inputs { cover: cover.clone(), marks: ink, ..balance.clone() }, None);
    }
}
