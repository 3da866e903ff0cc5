//! Views without water: once the GPU has found that none of the water maps of a view has any, frames omit the passes of
//! water. Their pictures are bit-identical, because those passes would copy tones and draw no ink.
//!
//! The findings are kept for each map, so a view that moves is known as soon as its new maps are.

use std::collections::VecDeque;

use rustc_hash::FxHashMap;

use crate::gpu::Gpu;
use crate::gpu::async_readback::AsyncReadback;
use crate::gpu::buffer::Buffer;
use crate::gpu::pools::KEEP_FRAMES;
use crate::gpu::wgsl::surface::lakes::seen::FIRST_FLAG;
use crate::tiles::slot_maps::MapInView;

/// Knowledge of which water maps have water.
#[derive(Default)]
pub(super) struct DryViews {
    /// The readback of the flags of all slots, and its size in bytes.
    readback: Option<(AsyncReadback, u64)>,
    /// The maps of the requests in flight, oldest first.
    requested: VecDeque<Vec<MapInView>>,
    /// For each slot, the content of its map when it was last examined, and whether it had water.
    known: FxHashMap<u32, (u64, bool)>,
    /// Number of successive frames, up to the last, whose style has no water.
    frames_without_water: u64,
    /// A planted error: every view counts as dry.
    #[cfg(test)]
    pub(super) assumed: bool,
}

impl DryViews {
    /// Notes a frame whose style has no water. After some of them, releases the buffers of the readback.
    pub(super) fn skip(&mut self) {
        self.frames_without_water += 1;
        if self.frames_without_water > KEEP_FRAMES {
            self.readback = None;
            self.requested.clear();
        }
    }

    /// Returns whether all maps of a view are known to have no water.
    pub(super) fn is_dry(&mut self, maps: &[MapInView]) -> bool {
        self.frames_without_water = 0;
        while let Some(bytes) = self.readback.as_mut().and_then(|(readback, _)| readback.take()) {
            let words: Vec<u32> = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
            self.learn(&words);
        }
        #[cfg(test)]
        if self.assumed {
            return true;
        }
        maps.iter().all(|map| self.known.get(&map.slot) == Some(&(map.content, false)))
    }

    /// Takes the answer to the oldest request.
    fn learn(&mut self, words: &[u32]) {
        for map in self.requested.pop_front().unwrap_or_default() {
            if let Some(flag) = words.get((FIRST_FLAG + map.slot) as usize) {
                self.known.insert(map.slot, (map.content, *flag != 0));
            }
        }
    }

    /// Requests which maps of the view that was just drawn have water, unless that is known. `arguments` is the output
    /// of [`seen`](crate::surface::lakes::seen).
    pub(super) fn request(&mut self, gpu: &Gpu, maps: Vec<MapInView>, arguments: Option<&Buffer>) {
        let Some(arguments) = arguments else { return };
        let is_known = |map: &MapInView| self.known.get(&map.slot).is_some_and(|(content, _)| *content == map.content);
        if maps.iter().all(is_known) || self.requested.back() == Some(&maps) {
            return;
        }
        let bytes = arguments.raw.size();
        if self.readback.as_ref().is_none_or(|(_, size)| *size != bytes) {
            // Another world has another number of slots.
            self.readback = Some((AsyncReadback::new(bytes), bytes));
            self.requested.clear();
        }
        if let Some((readback, _)) = &mut self.readback
            && readback.request(gpu, &[(&arguments.raw, bytes)])
        {
            self.requested.push_back(maps);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_is_dry_once_all_its_maps_are_known_to_be() {
        let map = |slot, content| MapInView { slot, content };
        let words = |wet: &[u32]| -> Vec<u32> {
            let flag = |word: u32| u32::from(word >= FIRST_FLAG && wet.contains(&(word - FIRST_FLAG)));
            (0..FIRST_FLAG + 8).map(flag).collect()
        };
        let mut views = DryViews::default();
        assert!(!views.is_dry(&[map(1, 10)]));
        views.requested.push_back(vec![map(1, 10), map(4, 40), map(5, 50)]);
        views.learn(&words(&[5]));
        assert!(views.is_dry(&[map(1, 10), map(4, 40)]) && views.is_dry(&[map(4, 40)]));
        // A map with water, one that has been recomputed, and one that is not known.
        for other in [map(5, 50), map(1, 11), map(2, 10)] {
            assert!(!views.is_dry(&[map(4, 40), other]), "{other:?}");
        }
        // The answers arrive in the order of the requests.
        views.requested.extend([vec![map(1, 11)], vec![map(2, 20)]]);
        views.learn(&words(&[1]));
        views.learn(&words(&[]));
        assert!(!views.is_dry(&[map(1, 11)]) && views.is_dry(&[map(2, 20)]));
        // An answer without a request, and one that is too short, change nothing.
        views.learn(&words(&[]));
        views.requested.push_back(vec![map(7, 70)]);
        views.learn(&words(&[])[..3]);
        assert!(!views.is_dry(&[map(7, 70)]));
    }
}
