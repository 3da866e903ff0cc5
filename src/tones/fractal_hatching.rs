//! Hatching by the fractal rule: approaching only ever adds marks. See `shaders/tones/fractal_hatching.wgsl`.
//!
//! Why: `docs/decisions/fractal-hatching.md`.

use super::hatching::uniform::HatchUniform;
use super::hatching::{AXES, Inputs, axes};
use crate::gpu::buffer::BufferKind;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::style::marks::Kind;

/// Position of the camera on each axis, by octave.
const CELLS: BufferKind = BufferKind::storage("cells");

/// Hatches the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let hatching = inputs.hatching;
    let ladder = (axes::FIRST_OCTAVE, axes::OCTAVES);
    let uniform = HatchUniform { drawn: inputs.drawn(), ..HatchUniform::new(hatching, ladder, 1) };
    let directions = axes::axes(&hatching.sets);
    let mut resources = vec![
        ("hatch", recorder.uniform("hatch", &uniform)),
        ("axes", recorder.upload(&AXES, &axes::directions(&directions)).binding()),
        ("cells", recorder.upload(&CELLS, &axes::cells(&directions, inputs.origin_m)).binding()),
    ];
    resources.extend(inputs.resources());
    let any =
        |is: fn(Kind) -> bool| hatching.sets.iter().any(|set| set.recipe.as_ref().is_none_or(|recipe| is(recipe.kind)));
    let definitions: &[&str] = match [any(|kind| kind != Kind::Line), any(|kind| kind == Kind::Dots)] {
        [_, true] => &["ENDED", "DOTS"],
        [true, _] => &["ENDED"],
        _ => &[],
    };
    recorder.pixels(Compute { name: "tones/fractal_hatching", definitions }, inputs.cover.size_px(), &resources);
}
