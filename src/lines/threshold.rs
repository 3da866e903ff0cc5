//! Errors → lines: the line-density filter and the ramp. See `shaders/lines/threshold.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::threshold::Threshold as ThresholdUniform;
use crate::style::Lines;
use crate::style::layers::Measure;

/// Line strength: 0 no line, 1 full.
pub(crate) const LINE: TargetKind = TargetKind::storage(
    "line",
    wgpu::TextureFormat::R32Float,
    Group::Lines.shows("Detected lines before they are smoothed"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The output of the style's detector.
    pub errors: &'a Target,
    /// The errors of eight directions, if the density filter does not merge opposite ones.
    pub directions: Option<&'a Target>,
    pub line: &'a Target,
}

/// Turns errors into lines.
pub(crate) fn run(recorder: &mut Recorder<'_>, lines: &Lines, inputs: &Inputs<'_>) {
    let scalar = u32::from(lines.detector.measure() != Measure::AxisErrors);
    let uniform = ThresholdUniform { ramp: lines.ramp, density: lines.density, scalar };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("threshold", recorder.uniform("threshold", &uniform)),
        ("errors", inputs.errors.into()),
        ("line", inputs.line.into()),
    ];
    resources.extend(inputs.directions.map(|directions| ("directions", directions.into())));
    let definitions: &[&str] = if inputs.directions.is_some() { &["EIGHT"] } else { &[] };
    recorder.pixels(Compute { name: "lines/threshold", definitions }, inputs.line.size_px(), &resources);
}
