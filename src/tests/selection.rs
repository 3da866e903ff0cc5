//! Tests the selection of patches: they cover visible land once, their edges agree, and their error is within the
//! bound.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::collections::{BTreeSet, HashMap};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use common::{baked, grid_of, random, rough_height_m};
use glam::{DVec2, DVec3};
use hachure::pyramid::surface::occluder_minima::OccluderMinima;
use hachure::pyramid::surface::statistics::TileStatistics;
use hachure::pyramid::tile::PATCH_QUADS;
use hachure::pyramid::{LevelSize, LoadedTile, Pyramid, TileAddress, TileStore};
use hachure::scene::camera::Camera;
use hachure::scene::view::{Pose, View};
use hachure::source::{HeightGrid, WorldMapping};
use hachure::tiles::grid_projection::GridProjection;
use hachure::tiles::patches::{AllPatches, Arrival, PatchState, Patches};
use hachure::tiles::select::select;
use hachure::tiles::selection::{PatchInstance, PatchKey, Selection, Viewpoint, units_log2};
use proptest::prelude::*;

const SIZE_PX: [u32; 2] = [640, 360];
const SPACING_M: f64 = 15.0;
/// Steps per grid unit, at which vertices are compared.
const STEPS: i64 = 4096;

struct Land {
    grid: HeightGrid,
    pyramid: Arc<Pyramid>,
    patches: AllPatches,
    grid_projection: GridProjection,
    _folder: tempfile::TempDir,
}

fn land() -> &'static Land {
    static LAND: OnceLock<Land> = OnceLock::new();
    LAND.get_or_init(|| {
        let grid = grid_of(523, 401, SPACING_M, rough_height_m);
        let (folder, pyramid) = baked(&grid);
        let mapping = WorldMapping::new(&grid.georeference, grid.width, grid.height).unwrap();
        let grid_projection = GridProjection::fit(&mapping, grid.width, grid.height);
        let pyramid = Arc::new(pyramid);
        let store: Arc<dyn TileStore> = pyramid.clone();
        let patches = AllPatches::read(&store).unwrap();
        Land { grid, pyramid, patches, grid_projection, _folder: folder }
    })
}

impl Land {
    fn sample_m(&self, column: i64, row: i64) -> DVec3 {
        let place = self.grid_projection.world_from_grid(DVec2::new(column as f64, row as f64));
        place.extend(f64::from(self.grid.heights_m[row as usize * self.grid.width as usize + column as usize]))
    }

    fn last(&self) -> [i64; 2] {
        [i64::from(self.grid.width) - 1, i64::from(self.grid.height) - 1]
    }
}

/// A view and the selection for it.
struct Chosen {
    view: View,
    viewpoint: Viewpoint,
    anchor: DVec2,
    selection: Selection,
}

impl std::fmt::Debug for Chosen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (pose, leaves) = (&self.view.pose, self.selection.leaves.len());
        write!(f, "{leaves} leaves for {} px from {pose:?}", self.viewpoint.error_px)
    }
}

fn choose(east: f64, north: f64, above_m: f64, yaw_deg: f64, pitch_deg: f64, fov_deg: f64, error_px: f64) -> Chosen {
    let land = land();
    let half_m = land.grid_projection.world_from_grid(DVec2::new(land.last()[0] as f64, 0.0));
    let place_m = DVec2::new(east * half_m.x, north * half_m.y);
    let grid = land.grid_projection.grid_from_world(place_m);
    let ground_m = land.pyramid.height_m(grid.x, grid.y);
    let camera = Camera {
        position_m: place_m.extend(ground_m.unwrap_or(f64::from(land.pyramid.max_m())) + above_m),
        height_above_ground: false,
        yaw_deg,
        pitch_deg,
        fov_deg,
    };
    let pose = Pose {
        position_m: camera.position_m,
        forward: camera.forward(),
        right: camera.right(),
        up: camera.up(),
        fov_rad: fov_deg.to_radians(),
    };
    let view = View::whole(pose, pose, SIZE_PX);
    let viewpoint = Viewpoint {
        camera_m: camera.position_m,
        frusta: vec![view.frustum()],
        focal_px: view.focal_px(),
        error_px,
        earth_curvature: Default::default(),
        is_above_ground: camera.position_m.z > ground_m.unwrap_or(f64::from(land.pyramid.max_m())),
        nearest_m: (0.5 * ground_m.map_or(0.0, |_| above_m)).max(0.02),
    };
    let anchor = land.grid_projection.anchor(place_m);
    let selection = select(&land.patches, &land.grid_projection, anchor, &viewpoint);
    Chosen { view, viewpoint, anchor, selection }
}

fn any_view() -> impl Strategy<Value = Chosen> {
    let heights = prop_oneof![Just(2.0), 5.0..100.0, 100.0..3000.0];
    (-1.2..1.2, -1.2..1.2, heights, 0.0..360.0, -90.0..20.0, 5.0..100.0, prop_oneof![0.25..4.0, 4.0..40.0])
        .prop_map(|(x, y, z, yaw, pitch, fov, error)| choose(x, y, z, yaw, pitch, fov, error))
}

/// Returns the first and last sample of a patch.
fn area(key: &PatchKey) -> [DVec2; 2] {
    let side = f64::from(PATCH_QUADS) * f64::from(key.level).exp2();
    let first = DVec2::new(key.x as f64, key.y as f64) * side;
    [first, first + side]
}

/// Counts the leaves that contain a point of the grid; the point must not be on a border of patches.
fn covers(leaves: &[PatchKey], place: DVec2) -> usize {
    leaves.iter().filter(|key| area(key)[0].cmplt(place).all() && place.cmplt(area(key)[1]).all()).count()
}

fn is_seen(view: &View, place_m: DVec3) -> bool {
    let way = place_m - view.pose.position_m;
    let ahead = way.dot(view.pose.forward);
    let tan = (0.5 * view.pose.fov_rad).tan();
    let wide = tan * f64::from(SIZE_PX[0]) / f64::from(SIZE_PX[1]);
    ahead > 0.0 && way.dot(view.pose.right).abs() < wide * ahead && way.dot(view.pose.up).abs() < tan * ahead
}

/// Returns whether land is between the camera and a point.
fn is_hidden(view: &View, place_m: DVec3) -> bool {
    let land = land();
    (1..400).any(|step| {
        let on_ray = view.pose.position_m.lerp(place_m, f64::from(step) / 400.0);
        let grid = land.grid_projection.grid_from_world(on_ray.truncate());
        land.pyramid.height_m(grid.x, grid.y).is_some_and(|ground_m| ground_m > on_ray.z)
    })
}

/// Returns samples of the land in view, slightly moved off the borders of patches.
fn seen_places(chosen: &Chosen) -> Vec<DVec2> {
    let land = land();
    let [columns, rows] = land.last();
    (0..3000)
        .map(|i| [(random(i, 5) * columns as f64) as i64, (random(i, 6) * rows as f64) as i64])
        .filter(|[column, row]| is_seen(&chosen.view, land.sample_m(*column, *row)))
        .map(|[column, row]| DVec2::new(column as f64 + 1e-7, row as f64 + 1e-7))
        .collect()
}

/// Returns how many points in view are omitted behind nearer land, and the points that are omitted although visible, of
/// which there must be none.
fn left_out(chosen: &Chosen) -> (usize, Vec<DVec2>) {
    let places = seen_places(chosen);
    let left_out = places.into_iter().filter(|place| covers(&chosen.selection.leaves, *place) == 0);
    let (hidden, gaps): (Vec<_>, Vec<_>) =
        left_out.partition(|place| is_hidden(&chosen.view, land().sample_m(place.x as i64, place.y as i64)));
    (hidden.len(), gaps)
}

/// The land's patches with a planted error: the land occludes as if it were higher.
struct Raised {
    occluder_minima: HashMap<TileAddress, OccluderMinima>,
}

impl Raised {
    fn by(raised_m: f32) -> Self {
        let land = land();
        let levels = land.pyramid.levels().iter().zip(0..);
        let tiles = levels.flat_map(|(size, level)| {
            let columns = size.tiles_x();
            (0..columns * size.tiles_y()).map(move |i| TileAddress { level, x: i % columns, y: i / columns })
        });
        let occluder_minima = tiles.map(|address| {
            let store: Arc<dyn TileStore> = land.pyramid.clone();
            let LoadedTile { tile, statistics, .. } = store.load(address).unwrap();
            // A block is as low as its samples, minus the error.
            (
                address,
                OccluderMinima::of(&tile, &TileStatistics { error_m: statistics.error_m - raised_m, ..statistics }),
            )
        });
        Self { occluder_minima: occluder_minima.collect() }
    }
}

impl Patches for Raised {
    fn size(&self) -> LevelSize {
        land().patches.size()
    }

    fn strides(&self) -> u32 {
        land().patches.strides()
    }

    fn patch(&self, j: u32, x: u32, y: u32) -> PatchState {
        land().patches.patch(j, x, y)
    }

    fn is_current(&self, _: &Arrival) -> bool {
        true
    }

    fn coarser_by(&self, _: &Arrival) -> f64 {
        0.0
    }

    fn occluder_minima(&self, tile: TileAddress) -> Option<&OccluderMinima> {
        self.occluder_minima.get(&tile)
    }

    fn request(&self, _: u32, _: u32, _: u32, _: f64) {}
}

/// Returns the distinct vertices of an edge along it, in steps, placed like the vertex shader does.
fn edge_units(patch: &PatchInstance, edge: usize) -> BTreeSet<i64> {
    let quads = PATCH_QUADS as i64;
    let along = if edge < 2 { 1 } else { 0 };
    let relative = f64::from(patch.edge_levels[edge]);
    let (whole, morph) = (relative.floor() as u32, relative.fract());
    let place = |i: i64| i64::from(patch.origin_units[along]) + (i << patch.stride_exponent);
    (0..=quads)
        .map(|i| {
            let on_level = i >> whole;
            let (from, to) = (place(on_level << whole), place((on_level & -2) << whole));
            // Both patches must have bit-identical vertices; steps of a level are exact in f32.
            from * STEPS + ((to - from) as f64 * morph * STEPS as f64) as i64
        })
        .collect()
}

/// Returns the patches in the order of the leaves.
fn instances(selection: &Selection) -> Vec<&PatchInstance> {
    selection.solid.iter().chain(&selection.with_holes).collect()
}

/// Returns the first and last step of a patch along an axis.
fn span(patch: &PatchInstance, axis: usize) -> [i64; 2] {
    let first = i64::from(patch.origin_units[axis]);
    [first * STEPS, (first + ((PATCH_QUADS as i64) << patch.stride_exponent)) * STEPS]
}

/// Counts shared edges that do not agree (another continuous level, or other vertices on the part that both have), and
/// all shared edges.
fn torn_edges(patches: &[&PatchInstance]) -> (usize, usize) {
    let (mut torn, mut shared) = (0, 0);
    for a in patches {
        for b in patches {
            for axis in 0..2 {
                let across = 1 - axis;
                if span(a, axis)[1] != span(b, axis)[0] {
                    continue;
                }
                let low = span(a, across)[0].max(span(b, across)[0]);
                let high = span(a, across)[1].min(span(b, across)[1]);
                if low >= high {
                    continue;
                }
                shared += 1;
                // The last column or row of `a` meets the first of `b`.
                let (edge_a, edge_b) = (2 * axis + 1, 2 * axis);
                let level = |patch: &PatchInstance, edge: usize| patch.stride_exponent as f32 + patch.edge_levels[edge];
                let vertices = |patch, edge| -> Vec<i64> {
                    edge_units(patch, edge).into_iter().filter(|at| (low..=high).contains(at)).collect()
                };
                let same_level = level(a, edge_a) == level(b, edge_b);
                torn += usize::from(!same_level || vertices(a, edge_a) != vertices(b, edge_b));
            }
        }
    }
    (torn, shared)
}

/// Returns the largest ratio of the error of a leaf's triangles at its samples to the error allowed at its nearest
/// sample. Only leaves count whose quads are wider than half the allowed error.
fn worst_ratio(chosen: &Chosen) -> f64 {
    let land = land();
    let [last_column, last_row] = land.last();
    let mut worst = 0.0_f64;
    for key in chosen.selection.leaves.iter().filter(|key| key.level > 0) {
        let stride = 1_i64 << key.level;
        let [first, end] = area(key).map(|at| [at.x as i64, at.y as i64]);
        let (mut error_m, mut nearest_m) = (0.0_f64, f64::INFINITY);
        for row in first[1]..=end[1].min(last_row) {
            for column in first[0]..=end[0].min(last_column) {
                let here = land.sample_m(column, row);
                nearest_m = nearest_m.min((here - chosen.viewpoint.camera_m).length());
                let corner =
                    [first[0] + (column - first[0]) / stride * stride, first[1] + (row - first[1]) / stride * stride];
                let far = [(corner[0] + stride).min(last_column), (corner[1] + stride).min(last_row)];
                if far[0] == corner[0] || far[1] == corner[1] {
                    continue;
                }
                let u = (column - corner[0]) as f64 / (far[0] - corner[0]) as f64;
                let v = (row - corner[1]) as f64 / (far[1] - corner[1]) as f64;
                let z = |c: i64, r: i64| land.sample_m(c, r).z;
                let (a, d) = (z(corner[0], corner[1]), z(far[0], far[1]));
                // A quad has two triangles; barycentric weights use its corner on the point's side of the diagonal.
                let flat = if u >= v {
                    a * (1.0 - u) + z(far[0], corner[1]) * (u - v) + d * v
                } else {
                    a * (1.0 - v) + z(corner[0], far[1]) * (v - u) + d * u
                };
                error_m = error_m.max((here.z - flat).abs());
            }
        }
        let allowed_m = chosen.viewpoint.error_px * nearest_m / chosen.viewpoint.focal_px;
        // On land so steep that the error exceeds the width of its quads, only half of the bound sideways is
        // guaranteed.
        if SPACING_M * stride as f64 > 0.5 * allowed_m {
            worst = worst.max(error_m / allowed_m);
        }
    }
    worst
}

/// Numbers of points, edges and leaves in all cases of the properties, since views of nothing would pass any test.
static PLACES: AtomicUsize = AtomicUsize::new(0);
static EDGES: AtomicUsize = AtomicUsize::new(0);
static LEAVES: AtomicUsize = AtomicUsize::new(0);
static HIDDEN: AtomicUsize = AtomicUsize::new(0);

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    fn every_seen_place_is_covered_once(chosen in any_view()) {
        let leaves = &chosen.selection.leaves;
        let places = seen_places(&chosen);
        PLACES.fetch_add(places.len(), Ordering::Relaxed);
        let (hidden, gaps) = left_out(&chosen);
        HIDDEN.fetch_add(hidden, Ordering::Relaxed);
        prop_assert_eq!(&gaps, &[], "in {} leaves", leaves.len());
        // No leaves overlap anywhere, visible or not.
        let [columns, rows] = land().last();
        for i in 0..500 {
            let place = DVec2::new(random(i, 7) * columns as f64, random(i, 8) * rows as f64);
            prop_assert!(covers(leaves, place) <= 1, "{place}");
        }
        // Planted: without the leaf of a point there is a gap, and with the leaf twice an overlap.
        if let Some(place) = places.iter().find(|place| covers(leaves, **place) == 1) {
            let other: Vec<_> = leaves.iter().copied().filter(|key| covers(&[*key], *place) == 0).collect();
            prop_assert_eq!(covers(&other, *place), 0);
            prop_assert_eq!(covers(&[leaves.as_slice(), leaves].concat(), *place), 2);
        }
    }

    fn edges_agree(chosen in any_view()) {
        let patches = instances(&chosen.selection);
        let (torn, shared) = torn_edges(&patches);
        EDGES.fetch_add(shared, Ordering::Relaxed);
        prop_assert_eq!(torn, 0, "of {} shared edges", shared);
        // Planted: the edges of patches with neighbours get another level.
        if shared > 0 {
            let mut moved: Vec<PatchInstance> = patches.iter().map(|patch| **patch).collect();
            moved.iter_mut().for_each(|patch| patch.edge_levels[0] += 0.3);
            let horizontally = torn_edges(&moved.iter().collect::<Vec<_>>()).0;
            moved.iter_mut().for_each(|patch| patch.edge_levels[2] += 0.3);
            prop_assert!(horizontally + torn_edges(&moved.iter().collect::<Vec<_>>()).0 > 0);
        }
    }

    fn errors_are_within_what_is_allowed(chosen in any_view()) {
        LEAVES.fetch_add(chosen.selection.leaves.iter().filter(|key| key.level > 0).count(), Ordering::Relaxed);
        let ratio = worst_ratio(&chosen);
        prop_assert!(ratio <= 1.0 + 1e-4, "the error is {ratio} times the allowed one");
    }
}

#[test]
fn the_selection_holds() {
    every_seen_place_is_covered_once();
    edges_agree();
    errors_are_within_what_is_allowed();
    let [places, edges, leaves] = [&PLACES, &EDGES, &LEAVES].map(|count| count.load(Ordering::Relaxed));
    println!("{places} points, {edges} shared edges, {leaves} leaves coarser than the data");
    assert!(places > 10_000 && edges > 1000 && leaves > 300);
}

#[test]
fn a_skyline_that_is_too_high_is_noticed() {
    let view = |i: i64| {
        let [east, north, above, yaw] = [0, 1, 2, 3].map(|k| random(i, 40 + k));
        (1.6 * east - 0.8, 1.6 * north - 0.8, 5.0 + 200.0 * above, 360.0 * yaw)
    };
    // Returns the number of points omitted behind land, and the number of points omitted although visible.
    let count = |raised_m: Option<f32>| {
        let raised = raised_m.map(Raised::by);
        (0..32).map(view).fold((0, 0), |(all_hidden, all_gaps), (east, north, above_m, yaw_deg)| {
            let mut chosen = choose(east, north, above_m, yaw_deg, -4.0, 60.0, 1.0);
            if let Some(raised) = &raised {
                chosen.selection = select(raised, &land().grid_projection, chosen.anchor, &chosen.viewpoint);
            }
            let (hidden, gaps) = left_out(&chosen);
            (all_hidden + hidden, all_gaps + gaps.len())
        })
    };
    let (hidden, gaps) = count(None);
    println!("{hidden} points omitted behind land, {gaps} omitted in view");
    assert!(hidden > 50 && gaps == 0, "{hidden} hidden, {gaps} gaps");
    assert_eq!(count(Some(0.0)), (hidden, gaps), "land raised by 0 m must be unchanged");
    let raises_m: &[f32] = if common::full() { &[10.0, 20.0, 40.0, 80.0, 160.0] } else { &[80.0] };
    for &raised_m in raises_m {
        let (hidden, gaps) = count(Some(raised_m));
        println!("raised by {raised_m} m: {hidden} points omitted behind land, {gaps} omitted in view");
        // The bounds are loose, so small raises lose nothing yet.
        assert!(gaps > 0 || raised_m < 40.0, "planted: raised by {raised_m} m");
    }
}

#[test]
fn coarser_leaves_than_allowed_are_noticed() {
    // Planted: leaves selected for eight times the error.
    let mut chosen = choose(0.1, -0.2, 60.0, 30.0, -8.0, 50.0, 4.0);
    println!("{} leaves, {:.3} times the allowed error", chosen.selection.leaves.len(), worst_ratio(&chosen));
    chosen.viewpoint.error_px = 0.5;
    assert!(worst_ratio(&chosen) > 1.0);
    assert_eq!(units_log2(LevelSize { width: 1 << 18, height: 2 }), 12);
    assert_eq!(units_log2(LevelSize { width: (1 << 18) + 1, height: 2 }), 11);
    assert!(chosen.anchor.is_finite());
}
