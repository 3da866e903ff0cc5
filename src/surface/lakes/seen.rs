//! Finds by the water maps whether a view has any water. See `shaders/surface/lakes/seen.wgsl`.

use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::{Recorder, WORKGROUP_PX};
use crate::gpu::wgsl::surface::lakes::seen::Seen;

/// Workgroup counts, of which the first is 0 if the view has no water: those of `surface/water`, and of `surface/dry`.
pub(crate) const ARGUMENTS: BufferKind = BufferKind::indirect("water arguments");
/// Offset of the counts of `surface/dry`, in bytes.
pub(crate) const DRY: u64 = 12;

/// Returns the workgroup counts for a picture of `size_px` of `surface/water`, which looks for water in it, and of
/// `surface/dry`, which writes that there is none. One of the two is zero.
pub(crate) fn run(recorder: &mut Recorder<'_>, water_maps: &[Named], size_px: [u32; 2]) -> Buffer {
    let arguments = recorder.buffer(&ARGUMENTS, 6 * 4);
    let seen = Seen { groups: size_px.map(|side| side.div_ceil(WORKGROUP_PX)), pad_a: 0, pad_b: 0 };
    let mut resources = vec![("picture", recorder.uniform("seen water", &seen)), ("arguments", arguments.binding())];
    resources.extend(water_maps.iter().cloned());
    recorder.groups("surface/lakes/seen", [1, 1], &resources);
    arguments
}
