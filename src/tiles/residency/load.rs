//! Requests tiles from the loader, most urgent first, and uploads those that have arrived.
//!
//! Why: `docs/decisions/tile-streaming.md`.

use std::sync::Arc;

use glam::DVec2;
use rustc_hash::FxHashSet;

use super::{Failure, MAX_TRIES, Movement, Residency};
use crate::gpu::Gpu;
use crate::pyramid::{LoadedTile, PyramidError, TileAddress};
use crate::tiles::atlas::{Protected, Upload};
use crate::tiles::needed::Needed;
use crate::tiles::queues::{in_order, most_urgent};

/// The pause after a failure, in seconds; it doubles with each failure, up to the longest pause.
const FIRST_PAUSE_S: f64 = 0.2;
const LONGEST_PAUSE_S: f64 = 30.0;
/// The largest number of tiles that a frame uploads because they will be needed soon: 4 MiB.
const MAX_SOON_UPLOADS: usize = 16;

impl Residency {
    /// Returns the missing tiles that this view needs, the most urgent first, where there are slots for all needed ones.
    /// `room` is the number of slots left for those that only the mesh requests.
    pub(super) fn missing(&mut self, movement: &Movement, room: usize, frame: u64) -> Vec<Needed> {
        let atlas = &self.atlas;
        self.missing.retain(|tile| atlas.want(tile.address, frame).is_none());
        let mut missing = self.missing.clone();
        let of_mesh = |(address, urgency): (&TileAddress, &f64)| {
            let tile = Needed::requested(*address, *urgency as f32);
            (!self.needed_set.contains(address)).then_some(tile)
        };
        let mut requested = in_order(movement.requested.iter().filter_map(of_mesh).collect());
        requested.truncate(room);
        requested.retain(|tile| atlas.want(tile.address, frame).is_none());
        if !requested.is_empty() {
            missing.append(&mut requested);
            missing = in_order(missing);
        }
        missing
    }

    /// Returns the tiles that this view needs, as many as there are slots, the most urgent first, and the number of those
    /// without a slot.
    pub(super) fn most_urgent(&self, movement: &Movement) -> (Vec<Needed>, u64) {
        let mut urgent = self.needed.clone();
        let of_mesh = movement.requested.iter().map(|(address, urgency)| Needed::requested(*address, *urgency as f32));
        urgent.extend(of_mesh);
        most_urgent(urgent, self.atlas.slots() as usize)
    }

    pub(super) fn protected(&self, frame: u64) -> Protected {
        let needed_since = self.found.as_ref().map_or(frame, |found| found.frame);
        Protected { needed_since, soon_since: self.soon_since }
    }

    /// Returns the tiles under the camera that are on the GPU but not in memory: the height of the ground is computed
    /// from them. Those in memory stay there.
    pub(super) fn ground_to_load(&mut self, camera: DVec2) -> Vec<TileAddress> {
        let under: Vec<TileAddress> = self.under(camera).collect();
        let is_on_gpu_only = |tile: &TileAddress| {
            let is_in_memory = self.cache.get(*tile).is_some();
            !is_in_memory && self.atlas.get(*tile).is_some()
        };
        under.into_iter().filter(is_on_gpu_only).collect()
    }

    pub(super) fn can_be_read(&self, tile: TileAddress) -> bool {
        self.failures.get(&tile).is_none_or(|failure| failure.tries < MAX_TRIES)
    }

    pub(super) fn take_finished(&mut self, now_s: f64, streams: bool) {
        self.cache.begin_pass();
        for (address, tile) in self.loader.take() {
            match tile {
                Ok(tile) => {
                    self.hits.read += 1;
                    self.failures.remove(&address);
                    self.cache.insert(address, tile);
                }
                Err(PyramidError::Cancelled) => {}
                Err(error) => self.fail(address, error, now_s, streams),
            }
        }
    }

    pub(super) fn fail(&mut self, address: TileAddress, error: PyramidError, now_s: f64, streams: bool) {
        let failure = self.failures.entry(address).or_insert(Failure { tries: 0, next_s: 0.0 });
        let counted = failure.tries >= MAX_TRIES;
        // The network code has already retried a request that is finally refused.
        failure.tries = (failure.tries + 1).max(if error.is_final() { MAX_TRIES } else { 0 });
        let pause_s = FIRST_PAUSE_S * f64::from(failure.tries.min(16) - 1).exp2();
        failure.next_s = now_s + pause_s.min(LONGEST_PAUSE_S);
        let text = error.message();
        if counted || failure.tries < MAX_TRIES {
            tracing::debug!("{text}");
            return;
        }
        // Rendering to a file returns the first failure as an error; in a window each is logged once.
        let is_known = self.failure.as_ref().is_some_and(|known| known.message() == text);
        if streams && !is_known {
            tracing::warn!("{text}");
        } else {
            tracing::debug!("{text}");
        }
        if self.failure.is_none() || streams {
            self.failure = Some(Arc::new(error));
        }
    }

    /// Returns the tiles to request, the needed ones to upload to the GPU, and those to upload because they are needed
    /// soon. Urgent tiles beyond the slots that they may take are left out: if they were read, they would evict each
    /// other from the memory for decoded tiles, and would be read again and again.
    pub(super) fn sort_out(
        &mut self,
        ground: &[TileAddress],
        urgent: &[Needed],
        frame: u64,
        now_s: f64,
        protected: Protected,
    ) -> [Vec<TileAddress>; 3] {
        let [mut request, mut offer, mut offer_soon] = [const { Vec::new() }; 3];
        let Self { atlas, cache, failures, .. } = self;
        let may_request = |tile: &TileAddress| failures.get(tile).is_none_or(|failure| failure.next_s <= now_s);
        request.extend(ground.iter().copied().filter(may_request));
        let is_missing = |tile: &TileAddress| atlas.want(*tile, frame).is_none();
        let missing: Vec<TileAddress> = urgent.iter().map(|tile| tile.address).filter(is_missing).collect();
        let room = if missing.is_empty() { 0 } else { atlas.replaceable(protected) };
        for tile in missing.into_iter().take(room) {
            if cache.get(tile).is_some() {
                offer.push(tile);
            } else if may_request(&tile) {
                request.push(tile);
            }
        }
        // Tiles that are needed by now are in both lists.
        let met: FxHashSet<TileAddress> = urgent.iter().map(|tile| tile.address).collect();
        self.missing_near.retain(|tile| atlas.want(*tile, frame).is_none());
        for tile in self.missing_near.iter().copied().filter(|tile| !met.contains(tile)) {
            if cache.get(tile).is_some() {
                offer.push(tile);
            } else if may_request(&tile) {
                request.push(tile);
            }
        }
        let is_not_read = |tile: &TileAddress| atlas.get(*tile).is_none() && cache.peek(*tile).is_none();
        request.extend(self.uncertain.iter().copied().filter(|tile| is_not_read(tile) && may_request(tile)));
        self.missing_soon.retain(|tile| atlas.get(*tile).is_none());
        for tile in self.missing_soon.iter().copied().filter(|tile| !met.contains(tile)) {
            if cache.get(tile).is_some() {
                if offer_soon.len() < MAX_SOON_UPLOADS {
                    offer_soon.push(tile);
                }
            } else if may_request(&tile) {
                request.push(tile);
            }
        }
        [request, offer, offer_soon]
    }

    pub(super) fn send(
        &mut self,
        gpu: &Gpu,
        [needed, soon]: [&[TileAddress]; 2],
        protected: Protected,
        upload: Upload,
    ) -> Vec<TileAddress> {
        let in_cache = |address: &TileAddress| Some((*address, Arc::clone(self.cache.peek(*address)?)));
        let tiles: Vec<(TileAddress, Arc<LoadedTile>)> = needed.iter().chain(soon).filter_map(in_cache).collect();
        let tiles: Vec<(TileAddress, &LoadedTile)> = tiles.iter().map(|(address, tile)| (*address, &**tile)).collect();
        self.atlas.insert(gpu, &tiles, needed.len(), protected, upload)
    }
}
