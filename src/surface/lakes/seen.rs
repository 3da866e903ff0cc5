//! Finds by the water maps whether a view has any water. See `shaders/surface/lakes/seen.wgsl`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::{Recorder, WORKGROUP_PX};
use crate::gpu::wgsl::surface::lakes::seen::{FIRST_FLAG, Seen};

/// Workgroup counts, of which the first is 0 if the view has no water: those of `surface/water`, and of `surface/dry`.
/// After them, for the slot of each map in view, whether it has water.
pub(crate) const ARGUMENTS: BufferKind = BufferKind::indirect("water arguments");
/// Offset of the counts of `surface/dry`, in bytes.
pub(crate) const DRY: u64 = 12;

/// Returns the workgroup counts for a picture of `size_px` of `surface/water`, which looks for water in it, and of
/// `surface/dry`, which writes that there is none. One of the two is zero.
pub(crate) fn run(recorder: &mut Recorder<'_>, water_maps: &[Named], size_px: [u32; 2]) -> Buffer {
    let slots = water_maps.iter().find_map(|(name, resource)| match resource {
        Resource::Texture(_, maps) if *name == "water_maps" => Some(maps.texture().depth_or_array_layers()),
        _ => None,
    });
    let arguments = recorder.buffer(&ARGUMENTS, 4 * u64::from(FIRST_FLAG + slots.unwrap_or_default()));
    let seen = Seen { groups: size_px.map(|side| side.div_ceil(WORKGROUP_PX)), pad_a: 0, pad_b: 0 };
    let mut resources = vec![("picture", recorder.uniform("seen water", &seen)), ("arguments", arguments.binding())];
    resources.extend(water_maps.iter().cloned());
    recorder.groups("surface/lakes/seen", [1, 1], &resources);
    arguments
}
