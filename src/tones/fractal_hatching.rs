//! Hatching by the fractal rule: coming nearer only ever adds marks. See `shaders/tones/fractal_hatching.wgsl`.
//!
//! Why: `docs/decisions/fractal-hatching.md`.

use super::hatching::uniform::HatchUniform;
use super::hatching::{AXES, Inputs, axes};
use crate::gpu::buffer::BufferKind;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Cx;
use crate::style::marks::Kind;

/// Where the camera is on each axis, by octave.
const CELLS: BufferKind = BufferKind::storage("cells");

/// Hatches what the inputs show.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let hatching = inputs.hatching;
    let ladder = (axes::FIRST_OCTAVE, axes::OCTAVES);
    let uniform = HatchUniform { drawn: inputs.drawn(), ..HatchUniform::new(hatching, ladder, 1) };
    let directions = axes::axes(&hatching.layers);
    let mut resources = vec![
        ("hatch", cx.uniform("hatch", &uniform)),
        ("axes", cx.upload(&AXES, &axes::directions(&directions)).binding()),
        ("cells", cx.upload(&CELLS, &axes::cells(&directions, inputs.origin_m)).binding()),
    ];
    resources.extend(inputs.resources());
    let any = |is: fn(Kind) -> bool| {
        hatching.layers.iter().any(|layer| layer.recipe.as_ref().is_none_or(|recipe| is(recipe.kind)))
    };
    let definitions: &[&str] = match [any(|kind| kind != Kind::Line), any(|kind| kind == Kind::Dots)] {
        [_, true] => &["ENDED", "DOTS"],
        [true, _] => &["ENDED"],
        _ => &[],
    };
    cx.pixels(Compute { name: "tones/fractal_hatching", definitions }, inputs.cover.size_px(), &resources);
}
