//! Views without water: once the GPU has found that no tile of a view has water, later frames of the same tiles omit
//! the passes of water. Their pictures are bit-identical, because those passes would copy tones and draw no ink.

use std::collections::VecDeque;

use crate::gpu::Gpu;
use crate::gpu::async_readback::AsyncReadback;
use crate::gpu::buffer::Buffer;

/// Knowledge of whether the last views have water. A view is known by the version of its water maps
/// ([`SlotMaps::version`](crate::tiles::slot_maps::SlotMaps::version)).
pub(super) struct DryViews {
    readback: AsyncReadback,
    /// The versions of the requests in flight, oldest first.
    requested: VecDeque<u64>,
    /// The last version that the GPU has answered for, and whether it is without water.
    answer: Option<(u64, bool)>,
}

impl Default for DryViews {
    fn default() -> Self {
        Self { readback: AsyncReadback::new(4), requested: VecDeque::new(), answer: None }
    }
}

impl DryViews {
    /// Takes the answers that have arrived, and returns whether the view of a version is known to be without water.
    pub(super) fn is_dry(&mut self, version: Option<u64>) -> bool {
        while let Some(bytes) = self.readback.take() {
            let groups: u32 = bytemuck::pod_read_unaligned(&bytes);
            self.answer = self.requested.pop_front().map(|version| (version, groups == 0));
        }
        version.is_some_and(|version| self.answer == Some((version, true)))
    }

    /// Reads back, asynchronously, whether the view that was just drawn has water, unless that is known. `arguments` are
    /// those that `surface/lakes/seen` wrote: their first word is the number of workgroups of `surface/water`, 0 if the
    /// view has none.
    pub(super) fn request(&mut self, gpu: &Gpu, version: Option<u64>, arguments: Option<&Buffer>) {
        let (Some(version), Some(arguments)) = (version, arguments) else { return };
        let is_known = self.answer.is_some_and(|(known, _)| known == version) || self.requested.contains(&version);
        if !is_known && self.readback.request(gpu, &[(&arguments.raw, 4)]) {
            self.requested.push_back(version);
        }
    }
}
