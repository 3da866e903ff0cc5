//! Hatching: tones made of marks from tonal art maps. See `shaders/tones/hatching.wgsl`.
//!
//! Why: `docs/decisions/hatching.md`.

pub(crate) mod axes;
pub(crate) mod maps;
pub(crate) mod uniform;

use glam::DVec3;

use self::maps::MadeMaps;
use self::uniform::HatchUniform;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::style::hatching::Hatching;

/// Directions of the charts.
pub(super) const AXES: BufferKind = BufferKind::storage("axes");
/// Phase of each axis, by level.
const PHASES: BufferKind = BufferKind::storage("phases");

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The style's hatching.
    pub hatching: &'a Hatching,
    /// The rig's origin in the world, to which positions are relative.
    pub origin_m: DVec3,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// The normal at the scale of marks.
    pub mark_normal: &'a Target,
    /// [`BEND_AXIS`](crate::surface::bend_axis::BEND_AXIS) if marks follow curvature; otherwise an empty target.
    pub bend_axis: &'a Target,
    /// A target whose alpha is the requested tone.
    pub tone: &'a Target,
    /// Index of the only set of marks that is drawn; `None` draws all sets.
    pub set: Option<usize>,
    /// The output: ink of the marks and its derivative by darkness.
    pub cover: &'a Target,
}

impl Inputs<'_> {
    /// Returns a bit mask of the sets that are drawn.
    pub(super) fn drawn(&self) -> u32 {
        self.set.map_or(u32::MAX, |set| 1 << set)
    }

    /// Returns the bindings that both kinds of hatching have.
    pub(super) fn resources(&self) -> [Named; 7] {
        [
            ("view", self.view.clone()),
            ("distance_m", self.distance.into()),
            ("normal", self.normal.into()),
            ("mark_normal", self.mark_normal.into()),
            ("bend_axis", self.bend_axis.into()),
            ("tone", self.tone.into()),
            ("cover", self.cover.into()),
        ]
    }
}

/// Hatches the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let hatching = inputs.hatching;
    let made_of = hatching.clone();
    let find = |maps: &MadeMaps| maps.are_of(hatching);
    let made = recorder.cached_in_background(find, move |gpu| MadeMaps::new(gpu, &made_of));
    let swells = hatching.sets.iter().filter_map(|set| set.recipe.as_ref()).any(uniform::swells);
    let shader = Compute { name: "tones/hatching", definitions: if swells { &["SWELLING"] } else { &[] } };
    let Some(maps) = made.as_deref().and_then(MadeMaps::maps) else {
        // The pipeline can be compiled while maps are made.
        if recorder.prewarms() {
            recorder.pixels(shader, inputs.cover.size_px(), &[]);
        }
        return;
    };
    let ladder = (axes::FIRST_LEVEL, axes::LEVELS);
    let uniform = HatchUniform { drawn: inputs.drawn(), ..HatchUniform::new(hatching, ladder, maps.side_px) };
    let directions = axes::axes(&hatching.sets);
    let phases = axes::phases(&directions, inputs.origin_m, f64::from(maps.side_px));
    let mut resources = vec![
        ("maps", maps.binding()),
        ("hatch", recorder.uniform("hatch", &uniform)),
        ("axes", recorder.upload(&AXES, &axes::directions(&directions)).binding()),
        ("phases", recorder.upload(&PHASES, &phases).binding()),
    ];
    resources.extend(inputs.resources());
    recorder.pixels(shader, inputs.cover.size_px(), &resources);
}
