//! Finds the tiles that a view needs, and for how long the list may be used.
//!
//! While a camera flies, the list is found with a margin: for a wider view from anywhere near the camera. It is found
//! again when the camera leaves the margin, when tiles of the list have arrived, and at least ten times a second. A camera at rest
//! gets the exact list, so that its picture equals that of a file.
//!
//! Why: `docs/decisions/tile-streaming.md`.

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::{Movement, Residency};
use crate::pyramid::TileAddress;
use crate::scene::frustum::Frustum;
use crate::tiles::earth_curvature::EarthCurvature;
use crate::tiles::grid_projection::GridProjection;
use crate::tiles::map_neighbours::map_neighbours;
use crate::tiles::needed::{Land, LevelRule, Needed, is_needed, needed};
use crate::tiles::prefetch::{ComingView, Outlook, Prefetcher};
use crate::tiles::queues::in_order;

/// Times ahead for which tiles are requested, in seconds. The first is the near future, whose tiles get slots like
/// those that are needed; of the others, the nearer future has the higher priority.
const AHEAD_S: [f64; 4] = [0.35, 0.8, 1.5, 3.0];
/// Slope (height per distance) by which the camera may see farther over a crest than foreseen, for each second ahead,
/// because no camera keeps its velocity.
const SLACK_PER_S: f64 = 0.06;
/// Angle by which the views ahead are wider than the view, in radians, because no camera keeps its velocity.
const AHEAD_RAD: f64 = 0.05;
/// Angle outside of the view within which tiles are requested, in radians.
const ASIDE_RAD: f64 = 0.35;
/// The time for which a list should last at the camera's velocity, in seconds.
const MARGIN_S: f64 = 0.1;
/// The margin is at most this fraction of the height above ground, because it makes near land finer.
const MARGIN_HEIGHT: f64 = 0.2;
/// Angle by which the view may turn before the list is found again, in radians.
const MARGIN_RAD: f64 = 0.03;
/// The longest time for which a list is used, in seconds.
const MAX_AGE_S: f64 = 0.1;
/// The shortest time for which a list is used although tiles have arrived, in seconds.
const MIN_AGE_S: f64 = 0.03;
/// The shortest time between two looks ahead, in seconds.
const LOOK_S: f64 = 0.1;
/// The fraction of the slots left over into which foreseen tiles are loaded. Foreseen tiles that are on the GPU may
/// stay in all of those slots: a tile whose rank varies a little is not loaded and evicted in turn.
const LOADED_SOON: f64 = 0.85;
/// The fraction of the slots that tiles for maps may take from those of the surface, and that they get while the camera
/// moves: if they got more, the tiles of the near future would have no slots.
const MAX_OF_MAPS: f64 = 0.125;

/// The view for which a list was found.
pub(super) struct Found {
    /// The rule, with its margin and the widened view frusta.
    rule: LevelRule,
    /// The camera and frusta of the last frame that used the list.
    camera_m: DVec3,
    frusta: Vec<Frustum>,
    /// Whether that frame had the camera and frusta of the one before.
    is_at_rest: bool,
    /// Whether there is no margin.
    pub is_exact: bool,
    at_s: f64,
    /// The frame in which it was found.
    pub frame: u64,
    pub arrivals: u64,
    needs_map_neighbours: bool,
}

impl Found {
    /// Returns whether the list has all tiles of a view.
    fn covers(&self, rule: &LevelRule) -> bool {
        let fits = |(wide, view): (&Frustum, &Frustum)| wide.contains(view);
        let found = &self.rule;
        found.focal_px == rule.focal_px
            && found.error_px == rule.error_px
            && found.earth_curvature.inverse_radius == rule.earth_curvature.inverse_radius
            && found.camera_m.distance(rule.camera_m) <= found.margin_m
            && found.frusta.len() == rule.frusta.len()
            && found.frusta.iter().zip(&rule.frusta).all(fits)
    }
}

impl Residency {
    /// Returns whether the list of needed tiles has to be found again.
    pub(super) fn must_find(&mut self, movement: &Movement, now_s: f64, streams: bool) -> bool {
        let rule = &movement.rule;
        let Some(found) = self.found.as_mut().filter(|_| streams && !movement.has_jumped) else { return true };
        let is_at_rest = found.camera_m == rule.camera_m && found.frusta == rule.frusta;
        found.is_at_rest = is_at_rest;
        (found.camera_m, found.frusta) = (rule.camera_m, rule.frusta.clone());
        let age_s = now_s - found.at_s;
        let has_changed = found.arrivals != self.arrivals;
        if is_at_rest {
            return !found.is_exact || has_changed || age_s > MAX_AGE_S && self.memory_factor.value() > 1.0;
        }
        found.needs_map_neighbours != movement.needs_map_neighbours
            || age_s > MAX_AGE_S
            || has_changed && age_s > MIN_AGE_S
            || !found.covers(rule)
    }

    /// Finds the tiles that a view needs and those that its maps depend on, marks them as needed, and hands the coming
    /// views to the prefetcher.
    pub(super) fn find(
        &mut self,
        grid_projection: &GridProjection,
        movement: &Movement,
        frame: u64,
        now_s: f64,
        streams: bool,
    ) {
        let before = self.found.take().filter(|_| streams && !movement.has_jumped);
        let view = &movement.rule;
        let is_at_rest = before.as_ref().is_some_and(|found| found.is_at_rest);
        let is_exact = !streams || is_at_rest || movement.has_jumped;
        let step_s = before.as_ref().map(|found| now_s - found.at_s);
        let rule = if is_exact { view.clone() } else { self.with_margin(grid_projection, movement) };
        let all = self.needed_within_memory(grid_projection, &rule, streams, step_s);
        let is_same = all.len() == self.needed.len()
            && all.iter().zip(&self.needed).all(|(tile, before)| tile.address == before.address);
        self.needed = all;
        let before_set = (before.is_some() && !is_same).then(|| self.needed_set.clone());
        let is_like =
            |found: &Found| found.needs_map_neighbours == movement.needs_map_neighbours && found.is_exact == is_exact;
        let is_same = is_same && before.as_ref().is_some_and(is_like);
        if !is_same {
            self.needed_set = self.needed.iter().map(|tile| tile.address).collect();
        }
        // At rest, the tiles for maps get all slots that are left over: those that the mesh does not keep.
        let of_mesh = (is_exact && !self.fits_all).then(|| match streams {
            true => self.kept_by_mesh(frame.saturating_sub(1)),
            false => self.kept_by_mesh(movement.needed_since) + self.missing_of_mesh(movement),
        });
        let finds_neighbours = !is_same || of_mesh.is_some() && movement.needs_map_neighbours;
        let has_changed =
            finds_neighbours && self.find_map_neighbours(movement.needs_map_neighbours, is_exact, of_mesh.unwrap_or(0));
        if has_changed || !is_same {
            self.absent = if self.store.is_sparse() { self.absent_neighbours() } else { Vec::new() };
            self.version += 1;
        }
        if streams {
            self.mark_needed(before_set.as_ref(), frame);
            self.look_ahead(grid_projection, movement, is_exact, frame, now_s);
        } else {
            let missing = self.map_neighbours.iter().filter(|tile| !self.atlas.want_soon(**tile, frame));
            self.missing_soon = missing.copied().collect();
        }
        self.found = Some(Found {
            rule,
            camera_m: view.camera_m,
            frusta: view.frusta.clone(),
            is_at_rest,
            is_exact,
            at_s: now_s,
            frame,
            arrivals: self.arrivals,
            needs_map_neighbours: movement.needs_map_neighbours,
        });
    }

    /// Returns the rule of a view for a camera that moves on.
    fn with_margin(&self, grid_projection: &GridProjection, movement: &Movement) -> LevelRule {
        let rule = &movement.rule;
        let ground = self.ground(grid_projection.grid_from_world(rule.camera_m.truncate()));
        let clearance_m = ground.map_or(0.0, |ground| (rule.camera_m.z - ground.height_m).abs());
        let margin_m = (movement.velocity_m_s.length() * MARGIN_S).min(MARGIN_HEIGHT * clearance_m);
        // Widening turns the sides of the frustum about the camera, which widens its corners less.
        let frusta = rule.frusta.iter().map(|view| view.widened(2.0 * MARGIN_RAD)).collect();
        LevelRule { frusta, margin_m, ..rule.clone() }
    }

    /// Returns the tiles that `rule` needs, coarse levels first; for a frame that streams, with pixels that are as wide
    /// as memory requires.
    fn needed_within_memory(
        &mut self,
        grid_projection: &GridProjection,
        rule: &LevelRule,
        streams: bool,
        step_s: Option<f64>,
    ) -> Vec<Needed> {
        let least = if streams { self.memory_factor.least(step_s) } else { 1.0 };
        let rule = LevelRule { focal_px: rule.focal_px / least, ..rule.clone() };
        let land = Land { store: &*self.store, grid_projection };
        let known = |address| self.atlas.get(address).map(|resident| resident.statistics());
        let mut all = needed(&land, &mut self.tile_bounds, known, &rule, 0.0);
        if !streams && !self.fits_all {
            // The order in which tiles come must not decide whether they fit into memory.
            let has_plenty = 2 * all.len() <= self.atlas.slots() as usize;
            let uncertain = all.iter().filter(|tile| has_plenty && !tile.is_certain).map(|tile| tile.address);
            self.uncertain = uncertain.collect();
            all.retain(|tile| tile.is_certain);
        }
        if streams && !self.fits_all {
            all.iter_mut().for_each(|tile| tile.factor = (f64::from(tile.factor) * least).min(1e30) as f32);
            let slots = self.atlas.slots() as usize;
            let of_maps = self.map_neighbours.len().min((slots as f64 * MAX_OF_MAPS) as usize);
            let room = slots - of_maps;
            self.fit_into(&mut all, room, step_s);
        }
        all
    }

    /// Chooses the factor by which the surface is coarser, for `all` tiles that are needed at the smallest that may be
    /// chosen, and removes those that are not needed at the chosen one. The tiles of the near future count, too. The
    /// factor shrinks only to what is on the GPU.
    fn fit_into(&mut self, all: &mut Vec<Needed>, room: usize, step_s: Option<f64>) {
        let now: FxHashSet<TileAddress> = all.iter().map(|tile| tile.address).collect();
        let near = self.foreseen.near.iter().filter(|tile| step_s.is_some() && !now.contains(&tile.address));
        let factors = all.iter().chain(near).map(|tile| tile.factor).collect();
        let (before, atlas) = (self.memory_factor.value(), &self.atlas);
        let finer = |tile: &&Needed| f64::from(tile.factor) <= before;
        let missing = || all.iter().filter(finer).filter(|tile| atlas.get(tile.address).is_none());
        let has_room = self.memory_factor.advance(factors, room, step_s, || missing().next().is_none());
        self.missing_finer = if has_room { missing().map(|tile| tile.address).collect() } else { Vec::new() };
        let factor = self.memory_factor.value();
        all.retain(|tile| f64::from(tile.factor) > factor);
    }

    /// Returns whether the view of this frame itself needs a tile: the list of needed tiles has a margin. A tile whose
    /// parent is missing counts as needed.
    pub(super) fn is_needed_now(
        &mut self,
        grid_projection: &GridProjection,
        rule: &LevelRule,
        tile: TileAddress,
    ) -> bool {
        let land = Land { store: &*self.store, grid_projection };
        let parent = TileAddress { level: tile.level + 1, x: tile.x / 2, y: tile.y / 2 };
        let Some(of_parent) = self.atlas.get(parent).map(|resident| resident.statistics()) else { return true };
        let rule = LevelRule { margin_m: 0.0, ..rule.clone() };
        let factor = self.memory_factor.value();
        is_needed(&land, &mut self.tile_bounds, &rule, (parent, of_parent), factor)
    }

    /// Returns the number of tiles that the mesh has used since a frame and that the view does not need: they keep their
    /// slots.
    fn kept_by_mesh(&self, since: u64) -> usize {
        self.atlas.needed_since(since).filter(|tile| !self.needed_set.contains(tile)).count()
    }

    /// Returns the number of tiles that only the mesh requests and that are not on the GPU.
    fn missing_of_mesh(&self, movement: &Movement) -> usize {
        let is_missing = |tile: &&TileAddress| !self.needed_set.contains(*tile) && self.atlas.get(**tile).is_none();
        movement.requested.keys().filter(is_missing).count()
    }

    /// Finds the tiles that the maps of needed tiles depend on, as far as there are slots besides those that the mesh keeps
    /// (`of_mesh`). Returns whether they are others than before.
    fn find_map_neighbours(&mut self, needs_map_neighbours: bool, is_exact: bool, of_mesh: usize) -> bool {
        let before = std::mem::take(&mut self.map_neighbours);
        if needs_map_neighbours {
            let slots = self.atlas.slots() as usize;
            let most = if is_exact || self.fits_all { slots } else { (slots as f64 * MAX_OF_MAPS) as usize };
            self.map_neighbours = map_neighbours(&*self.store, &self.needed);
            self.map_neighbours.truncate(most.min(slots.saturating_sub(self.needed.len() + of_mesh)));
        }
        self.map_neighbours != before
    }

    /// Returns the tiles around needed ones that do not exist, because nothing finer is known there.
    fn absent_neighbours(&self) -> Vec<(TileAddress, bool)> {
        let mut met = self.needed_set.clone();
        let mut absent = Vec::new();
        for Needed { address: tile, .. } in &self.needed {
            let size = self.store.levels()[tile.level as usize];
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                let (Some(x), Some(y)) = (tile.x.checked_add_signed(dx), tile.y.checked_add_signed(dy)) else {
                    continue;
                };
                let neighbour = TileAddress { x, y, ..*tile };
                let is_inside = x < size.tiles_x() && y < size.tiles_y();
                if is_inside && met.insert(neighbour) && !self.store.has_tile(neighbour) {
                    absent.push((neighbour, false));
                }
            }
        }
        absent
    }

    /// Marks the tiles of this view as needed and lists those that are missing. `before` has the tiles that the view
    /// before needed, if they were others.
    fn mark_needed(&mut self, before: Option<&FxHashSet<TileAddress>>, frame: u64) {
        self.missing.clear();
        for tile in &self.needed {
            let is_there = self.atlas.want(tile.address, frame).is_some();
            if before.is_some_and(|before| !before.contains(&tile.address)) {
                *(if is_there { &mut self.hits.on_gpu } else { &mut self.hits.not_on_gpu }) += 1;
            }
            if !is_there {
                self.missing.push(*tile);
            }
        }
        self.missing = in_order(std::mem::take(&mut self.missing));
    }

    /// Hands the coming views to the prefetcher, and takes the tiles that it has found.
    fn look_ahead(
        &mut self,
        grid_projection: &GridProjection,
        movement: &Movement,
        is_exact: bool,
        frame: u64,
        now_s: f64,
    ) {
        let start = || Prefetcher::new(std::sync::Arc::clone(&self.store), grid_projection.clone());
        let prefetcher = self.prefetcher.take().unwrap_or_else(start);
        if movement.has_jumped {
            prefetcher.forget();
            self.looked_s = f64::NEG_INFINITY;
        }
        let foreseen = prefetcher.foreseen();
        if !std::sync::Arc::ptr_eq(&foreseen, &self.foreseen) {
            self.foreseen = foreseen;
            self.soon_since = frame;
        }
        let foreseen = std::sync::Arc::clone(&self.foreseen);
        let room = (self.atlas.slots() as usize).saturating_sub(self.needed.len() + self.map_neighbours.len());
        // The tiles of the near future have slots like those that are needed.
        let factor = self.memory_factor.value();
        let is_near = |tile: &&Needed| f64::from(tile.factor) > factor && !self.needed_set.contains(&tile.address);
        let near: Vec<TileAddress> = foreseen.near.iter().filter(is_near).take(room).map(|tile| tile.address).collect();
        let near_then_of_maps = near.iter().chain(&self.map_neighbours).copied();
        self.missing_near = near_then_of_maps.filter(|tile| self.atlas.want(*tile, frame).is_none()).collect();
        // The picture of a camera at rest depends on the tiles of its view only.
        let maps_ahead = movement.needs_map_neighbours && !is_exact;
        let is_there = |tile: &TileAddress| maps_ahead && self.atlas.get(*tile).is_some();
        let mapped_ahead: Vec<TileAddress> = near.iter().copied().filter(is_there).collect();
        if mapped_ahead != self.mapped_ahead {
            self.mapped_ahead = mapped_ahead;
            self.version += 1;
        }
        let room = room - near.len();
        let most_loads = (room as f64 * LOADED_SOON) as usize;
        self.missing_soon.clear();
        let others = self.missing_finer.iter().chain(&foreseen.later).filter(|tile| !self.needed_set.contains(tile));
        for (rank, tile) in others.take(room).enumerate() {
            if !self.atlas.want_soon(*tile, frame) && rank < most_loads {
                self.missing_soon.push(*tile);
            }
        }
        if !prefetcher.is_busy() && now_s - self.looked_s >= LOOK_S {
            self.looked_s = now_s;
            let views = self.coming_views(grid_projection, movement);
            let (snapshot, most) = (self.atlas.snapshot(), self.atlas.slots() as usize);
            prefetcher.look(Outlook { views, snapshot, most });
        }
        self.prefetcher = Some(prefetcher);
    }

    /// Returns the views of the near future: where the camera will be if it keeps moving, and around the current view.
    fn coming_views(&self, grid_projection: &GridProjection, movement: &Movement) -> Vec<ComingView> {
        let ground = self.ground(grid_projection.grid_from_world(movement.rule.camera_m.truncate()));
        let nearest_m = ground.map_or(0.0, |ground| 0.5 * (movement.rule.camera_m.z - ground.height_m).abs()).max(0.02);
        let factor = self.memory_factor.after(AHEAD_S[0]);
        let focal_px = movement.rule.focal_px / factor;
        let margin_m = movement.velocity_m_s.length() * MARGIN_S;
        let rule = LevelRule { focal_px, margin_m, ..movement.rule.clone() };
        let mut views = Vec::new();
        let is_moving = movement.velocity_m_s != DVec3::ZERO || self.turning.is_turning();
        for ahead_s in AHEAD_S.into_iter().filter(|_| is_moving) {
            let mut camera_m = rule.camera_m + movement.velocity_m_s * ahead_s;
            // A path that follows the land does not go into the next mountain.
            if let Some(ground) = self.ground(grid_projection.grid_from_world(camera_m.truncate())) {
                camera_m.z = camera_m.z.max(ground.height_m + nearest_m);
            }
            let earth_curvature = EarthCurvature { camera_z_m: camera_m.z, ..rule.earth_curvature };
            let turn = self.turning.after(ahead_s);
            let frusta = rule.frusta.iter().map(|view| view.turned(turn).widened(AHEAD_RAD)).collect();
            let rule = LevelRule { camera_m, frusta, earth_curvature, ..rule.clone() };
            let is_near = views.is_empty();
            views.push(ComingView { rule, nearest_m, slack: SLACK_PER_S * ahead_s, factor, is_near });
        }
        let wider = rule.frusta.iter().map(|view| view.widened(ASIDE_RAD)).collect();
        let rule = LevelRule { frusta: wider, ..rule };
        views.push(ComingView { rule, nearest_m, slack: 0.0, factor, is_near: false });
        views
    }
}
