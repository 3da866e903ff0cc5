//! Tests that several DEMs make one world, by comparison with the single DEMs.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;
use crate::tests::helpers::styles::of_outlines;

use std::sync::Arc;

use common::field::Field;
use common::shot::{ink, shoot_style};
use common::{World, full, quantile};
use glam::DVec2;
use hachure::picture::PartRule;
use hachure::pyramid::store::{Cancel, Decode, MosaicStore, coarse_patches, derive};
use hachure::pyramid::surface::statistics::PatchStatistics;
use hachure::pyramid::tile::is_void;
use hachure::pyramid::{BakeOptions, LevelSize, Pyramid, PyramidError, TileAddress, TileStore, bake};
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::mosaic::MosaicReader;
use hachure::source::{HeightGrid, HeightReader, Silent, SourceError, Window, WorldMapping, open};

struct Grid(HeightGrid);

impl HeightReader for Grid {
    fn size(&self) -> [u32; 2] {
        [self.0.width, self.0.height]
    }

    fn georeference(&self) -> &Georeference {
        &self.0.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let line = |row: u32| {
            let start = (row * self.0.width + window.x) as usize;
            self.0.heights_m[start..start + window.width as usize].iter().copied()
        };
        Ok((window.y..window.y + window.height).flat_map(line).collect())
    }

    fn block(&self) -> [u32; 2] {
        [256, 256]
    }

    fn identity(&self) -> String {
        "grid in memory".into()
    }
}

fn reader(grids: &[&HeightGrid]) -> MosaicReader {
    MosaicReader::new(grids.iter().map(|&grid| Box::new(Grid(grid.clone())) as Box<dyn HeightReader>).collect())
        .unwrap()
}

fn whole(reader: &MosaicReader) -> Vec<f32> {
    let [width, height] = reader.size();
    reader.read(Window { x: 0, y: 0, width, height }).unwrap()
}

fn store(grids: &[&HeightGrid]) -> (tempfile::TempDir, Arc<MosaicStore>) {
    let folder = tempfile::tempdir().unwrap();
    let members = grids.iter().enumerate().map(|(i, &grid)| {
        let out = folder.path().join(format!("{i}.tif"));
        bake(grid, &out, &BakeOptions::default(), &Silent).unwrap();
        Arc::new(Pyramid::open(&out).unwrap()) as Arc<dyn TileStore>
    });
    let store = MosaicStore::new(members.collect()).unwrap();
    (folder, Arc::new(store))
}

/// Returns the width and the heights of a level; a height is NaN where the store has no tile or no height.
fn level(store: &Arc<MosaicStore>, level: u32) -> (usize, Vec<f32>) {
    let size = store.levels()[level as usize];
    let mut heights_m = vec![f32::NAN; size.samples()];
    for y in 0..size.tiles_y() {
        for x in 0..size.tiles_x() {
            let address = TileAddress { level, x, y };
            if !store.has_tile(address) {
                continue;
            }
            let tile = store.clone().load(address).unwrap().tile;
            let region = size.tile_region(x, y, 0);
            for row in 0..region.height {
                for column in 0..region.width {
                    let sample = tile.samples[((row + 2) * 260 + column + 2) as usize];
                    let at = (region.y + row) as usize * size.width as usize + (region.x + column) as usize;
                    heights_m[at] = if is_void(sample) { f32::NAN } else { sample };
                }
            }
        }
    }
    (size.width as usize, heights_m)
}

/// Returns the share of samples of `part`, placed at (`x`, `y`), that differ by more than `bound_m`.
fn unlike(mosaic: &[f32], width: usize, part: &HeightGrid, x: usize, y: usize, bound_m: f32) -> f64 {
    let differs = part.heights_m.iter().enumerate().filter(|(i, height)| {
        let (column, row) = (i % part.width as usize, i / part.width as usize);
        let there = mosaic[(y + row) * width + x + column];
        if height.is_nan() { false } else { there.is_nan() || (there - *height).abs() > bound_m }
    });
    differs.count() as f64 / part.heights_m.len() as f64
}

fn real(name: &str) -> Option<HeightGrid> {
    Some(open(&common::real_data(&format!("dem/geotiff/{name}.tif"))?, &Silent).unwrap())
}

fn local(width: u32, height: u32, spacing_m: f64, [west, north]: [f64; 2], of: impl Fn(f64, f64) -> f64) -> HeightGrid {
    let at = |i: u32| (west + spacing_m * f64::from(i % width), north - spacing_m * f64::from(i / width));
    let heights_m = (0..width * height).map(at).map(|(x, y)| of(x, y) as f32).collect();
    let crs_from_grid = [west, spacing_m, 0.0, north, 0.0, -spacing_m];
    let georeference = Georeference { crs_from_grid, crs: Crs::Local, geokeys: Default::default() };
    HeightGrid { width, height, heights_m, georeference }
}

fn hills(x: f64, y: f64) -> f64 {
    900.0 + 200.0 * (x / 900.0).sin() * (y / 1100.0).cos() + 0.05 * x
}

#[test]
fn two_degrees_that_share_a_column_are_one() {
    let (Some(west), Some(east)) = (real("N49W124"), real("N49W123")) else { return };
    let reader = reader(&[&west, &east]);
    assert_eq!(reader.size(), [2401, 1201]);
    let heights_m = whole(&reader);
    assert_eq!(unlike(&heights_m, 2401, &west, 0, 0, 0.0), 0.0);
    assert_eq!(unlike(&heights_m, 2401, &east, 1200, 0, 0.0), 0.0);
    // Planted: a member that is one sample off.
    assert!(unlike(&heights_m, 2401, &east, 1199, 0, 0.0) > 0.5);

    let (_folder, store) = store(&[&west, &east]);
    let (width, heights_m) = level(&store, 0);
    assert_eq!(width, 2401);
    // The lowest bit of a sample marks no-data, so heights are compared within 1 mm.
    assert_eq!(unlike(&heights_m, width, &west, 0, 0, 1e-3), 0.0);
    assert_eq!(unlike(&heights_m, width, &east, 1200, 0, 1e-3), 0.0);
    // There is no seam on a coarser level: the mean step across it is like those nearby.
    let (width, heights_m) = level(&store, 2);
    let step = |column: usize| {
        let rows = heights_m.chunks_exact(width).map(|row| (row[column + 1] - row[column]).abs());
        let steps: Vec<f32> = rows.filter(|step| !step.is_nan()).collect();
        steps.iter().sum::<f32>() / steps.len() as f32
    };
    let nearby = (280..320).filter(|column| !(297..303).contains(column)).map(step).fold(0.0, f32::max);
    for column in 297..303 {
        assert!(step(column) < 1.3 * nearby, "{column}: mean step {}, nearby {nearby}", step(column));
    }
}

#[test]
fn four_tiles_of_a_city_are_one() {
    let tiles: Option<Vec<HeightGrid>> = (0..4).map(|i| real(&format!("ds_los_angeles_tile_{i}"))).collect();
    let Some(tiles) = tiles else { return };
    let reader = reader(&tiles.iter().collect::<Vec<_>>());
    let heights_m = whole(&reader);
    let [width, height] = reader.size();
    println!("{width} × {height}");
    let [x0, step, _, y0, _, down] = reader.georeference().crs_from_grid;
    for tile in &tiles {
        let place = tile.georeference.crs_from_grid;
        let (x, y) = (((place[0] - x0) / step).round() as usize, ((place[3] - y0) / down).round() as usize);
        // Where tiles overlap, the first one counts.
        assert!(unlike(&heights_m, width as usize, tile, x, y, 0.5) < 0.05, "{x} {y}");
        let shifted_x = if x > 0 { x - 1 } else { 1 };
        assert!(
            unlike(&heights_m, width as usize, tile, shifted_x, y, 0.0) > 0.3,
            "a tile one sample off was not detected"
        );
    }
    let voids = heights_m.iter().filter(|height| height.is_nan()).count();
    let own: usize = tiles.iter().map(|tile| tile.heights_m.iter().filter(|height| height.is_nan()).count()).sum();
    assert!(voids <= own, "gap between tiles: {voids} no-data samples, {own} in the tiles themselves");
}

#[test]
fn members_that_abut_have_no_gap() {
    // Pixels are areas: the second DEM begins one spacing after the last sample of the first, in the second case half a
    // sample off.
    for shift in [0.0, 5.0] {
        let a = local(300, 200, 10.0, [0.0, 0.0], hills);
        let b = local(300, 200, 10.0, [3000.0, shift], hills);
        let read = reader(&[&a, &b]);
        let inner = Window { x: 5, y: 5, width: 590, height: 190 };
        assert!(read.read(inner).unwrap().iter().all(|height| !height.is_nan()));
        let (_folder, store) = store(&[&a, &b]);
        for at in 0..2 {
            let (width, heights_m) = level(&store, at);
            let scale = 1 << at;
            for row in 4..90 / scale {
                for column in 280 / scale..320 / scale {
                    let first = f64::from(scale as u32 - 1) * 0.5;
                    let [x0, step, _, y0, _, down] = store.georeference().crs_from_grid;
                    let x = x0 + step * ((column * scale) as f64 + first);
                    let y = y0 + down * ((row * scale) as f64 + first);
                    let there = f64::from(heights_m[row * width + column]);
                    assert!(
                        (there - hills(x, y)).abs() < 0.3,
                        "{at} {column} {row}: {there}, expected {}",
                        hills(x, y)
                    );
                }
            }
        }
    }
}

#[test]
fn members_continue_beyond_their_border() {
    // Three of four quadrants, with a pit far away that is the lowest height.
    let land = |x: f64, y: f64| hills(x, y) - if x < 30.0 && y > -30.0 { 800.0 } else { 0.0 };
    let part = |column: f64, row: f64| local(100, 100, 10.0, [1000.0 * column, -1000.0 * row], land);
    let (_folder, store) = store(&[&part(0.0, 0.0), &part(1.0, 0.0), &part(0.0, 1.0)]);
    let tile = store.load(TileAddress { level: 0, x: 0, y: 0 }).unwrap().tile;
    let at = |column: i32, row: i32| tile.samples[((row + 2) * 260 + column + 2) as usize];
    let mut worst_m: f32 = 0.0;
    for i in 50..99 {
        // The border of the world, and that of the missing quadrant.
        for [own, beyond] in
            [[[0, i], [-1, i]], [[i, 0], [i, -1]], [[100 + i, 99], [100 + i, 100]], [[99, 100 + i], [100, 100 + i]]]
        {
            let [own_m, beyond_m] = [own, beyond].map(|[column, row]| at(column, row));
            assert!(is_void(beyond_m) && !is_void(own_m), "{beyond:?}");
            worst_m = worst_m.max((own_m - beyond_m).abs());
        }
    }
    assert!(worst_m < 5.0, "{worst_m} m: the surface must not bend toward the lowest height of the world");
}

#[test]
fn an_inset_fades_into_its_base() {
    let base = local(400, 400, 20.0, [0.0, 0.0], hills);
    // The inset is finer, and 6 m higher, which would make a step without fading.
    let inset = local(400, 300, 10.0, [2000.0, -2000.0], |x, y| hills(x, y) + 6.0);
    let (_folder, store) = store(&[&base, &inset]);
    assert_eq!(store.levels()[0].width, 799);
    let [fine, coarse] = [0, 1].map(|at| level(&store, at));
    // The store is sparse: level 0 exists only on the inset and one tile around it.
    assert!(store.has_tile(TileAddress { level: 0, x: 1, y: 1 }));
    assert!(store.has_tile(TileAddress { level: 0, x: 3, y: 2 }));
    assert!(!store.has_tile(TileAddress { level: 0, x: 3, y: 3 }));
    assert!(store.has_tile(TileAddress { level: 1, x: 1, y: 1 }));
    let excess = |column: usize, row: usize| {
        f64::from(fine.1[row * fine.0 + column]) - hills(10.0 * column as f64, -10.0 * row as f64)
    };
    assert!(unlike(&fine.1, fine.0, &inset, 200, 200, 1e-3) < 0.1, "the middle must equal the inset");
    assert!((excess(400, 350) - 6.0).abs() < 1e-3);
    assert!(excess(150, 350).abs() < 0.2);
    let mut planted_errors_found = 0;
    for column in 190..215 {
        let step = (excess(column + 1, 350) - excess(column, 350)).abs();
        assert!(step < 1.2, "{column}: a step of {step}");
        planted_errors_found += i32::from(step > 0.4);
    }
    assert!(planted_errors_found > 2, "the heights must fade over several samples");
    // The coarser level agrees with the finer one, including the fade.
    for (column, row) in [(75, 175), (200, 175), (103, 160), (99, 150)] {
        let mean = [0, 1, 2, 3].map(|k| excess(2 * column + k % 2, 2 * row + k / 2)).iter().sum::<f64>() / 4.0;
        let (x, y) = (20.0 * column as f64 + 5.0, -20.0 * row as f64 - 5.0);
        let there = f64::from(coarse.1[row * coarse.0 + column]) - hills(x, y);
        assert!((there - mean).abs() < 1.0, "{column} {row}: {there}, expected {mean}");
    }
    // The reader returns the finer member bit for bit, and the base around it.
    let read = reader(&[&base, &inset]);
    let heights_m = whole(&read);
    assert_eq!(unlike(&heights_m, 799, &inset, 200, 200, 0.0), 0.0);
    assert!((f64::from(heights_m[100 * 799 + 100]) - hills(1000.0, -1000.0)).abs() < 1e-3);
    assert!((f64::from(heights_m[101 * 799 + 101]) - hills(1010.0, -1010.0)).abs() < 0.05);
}

/// First and last sample of the inset in the mosaic, in samples of level 0 on both axes.
const INSET: [u32; 2] = [800, 1824];
/// The base is 2⁴ times as coarse as the inset, which is this level.
const BASE_LEVEL: u32 = 4;

/// The error that is planted in a mosaic.
#[derive(Clone, Copy)]
enum Planted {
    /// Fine tiles end at the border of the inset.
    NothingAround,
    /// Coarse tiles do not know of members that are smaller than the space between samples.
    UnawareOfSmall,
}

/// A mosaic with a planted error.
struct Faulty {
    store: Arc<MosaicStore>,
    planted: Planted,
    coarse_patches: Vec<Vec<PatchStatistics>>,
}

impl Faulty {
    fn of(store: &Arc<MosaicStore>, planted: Planted) -> Arc<dyn TileStore> {
        let top = TileAddress { level: store.levels().len() as u32 - 1, x: 0, y: 0 };
        let coarse_patches = match planted {
            Planted::NothingAround => store.coarse_patches().to_vec(),
            Planted::UnawareOfSmall => {
                let tile = store.clone().load(top).unwrap().tile;
                coarse_patches(store.levels(), &derive(store.levels(), top, tile))
            }
        };
        Arc::new(Self { store: store.clone(), planted, coarse_patches })
    }
}

impl TileStore for Faulty {
    fn name(&self) -> String {
        self.store.name()
    }

    fn levels(&self) -> &[LevelSize] {
        self.store.levels()
    }

    fn georeference(&self) -> &Georeference {
        self.store.georeference()
    }

    fn range_m(&self) -> [f32; 2] {
        self.store.range_m()
    }

    fn is_measured(&self) -> bool {
        self.store.is_measured()
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        &self.coarse_patches
    }

    fn has_tile(&self, address: TileAddress) -> bool {
        let side = 256 << address.level;
        let meets = |tile: u32| tile * side < INSET[1] && (tile + 1) * side > INSET[0];
        let is_cut = matches!(self.planted, Planted::NothingAround) && address.level < BASE_LEVEL;
        self.store.has_tile(address) && (!is_cut || meets(address.x) && meets(address.y))
    }

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        let decode = Arc::clone(&self.store).fetch(address, cancel)?;
        match self.planted {
            Planted::NothingAround => Ok(decode),
            Planted::UnawareOfSmall => Ok(Box::new(move || Ok(derive(self.store.levels(), address, decode()?.tile)))),
        }
    }
}

/// Draws the inset from points above it. Returns for each view the 99.9th percentile of height errors against the
/// inset's own surface, in pixels. Only pixels farther inside than the fade count. `shift` is the inset's first sample.
fn inset_errors_px(world: &mut World, shift: DVec2, views: &[(f64, f64, &str)]) -> Vec<f64> {
    let inset_mapping = WorldMapping::new(&world.grid.georeference, world.grid.width, world.grid.height).unwrap();
    let (mut renderer, style) = (None, of_outlines(ink("footprint")));
    let errors = views.iter().map(|(x, y, view)| {
        let at_m = world.mapping.world_from_grid(x + shift.x, y + shift.y);
        let pose = world.pose(&format!("{},{},{view}", at_m.x, at_m.y));
        let shot = shoot_style(world, &mut renderer, pose, pose, [160, 160], &style, &PartRule::default());
        let field = Field { grid: &world.grid, mapping: &inset_mapping };
        let errors = (0..shot.depth_m.len()).filter(|&pixel| !shot.is_sky(pixel)).filter_map(|pixel| {
            let place_m = shot.world_m(pixel);
            let on_inset = world.mapping.grid_from_world(place_m.truncate()) - shift;
            let depth = on_inset.min(f64::from(world.grid.width - 1) - on_inset).min_element();
            let height_m = field.height_m(inset_mapping.world_from_grid(on_inset.x, on_inset.y))?;
            let px_per_m = shot.focal_px() / shot.position_m[pixel].length();
            (depth > 9.0).then_some((place_m.z - height_m).abs() * px_per_m)
        });
        let mut errors: Vec<f64> = errors.collect();
        assert!(errors.len() > 5000, "{x} {y}: {} pixels on the inset", errors.len());
        quantile(&mut errors, 0.999)
    });
    errors.collect()
}

#[test]
fn an_inset_is_drawn_in_full_up_to_its_edge() {
    let of = common::rough_height_m;
    let base = local(300, 300, 160.0, [0.0, 0.0], of);
    let inset = local(1024, 1024, 10.0, [8000.0, -8000.0], of);
    let (folder, store) = store(&[&base, &inset]);
    assert_eq!((store.levels()[0].width, store.levels().len()), (4785, 6));
    // Far from the inset the store is sparse, but tiles just outside the inset can be loaded.
    assert!(
        !store.has_tile(TileAddress { level: 0, x: 9, y: 5 }) && store.has_tile(TileAddress { level: 0, x: 8, y: 8 })
    );
    let beyond = store.clone().load(TileAddress { level: 0, x: 8, y: 8 }).unwrap();
    assert!(beyond.tile.samples.iter().all(|&height| height.is_finite() && !is_void(height)));
    let bare = Faulty::of(&store, Planted::NothingAround);

    const ALLOWED_PX: f64 = 0.25;
    let [near, middle, far] = [40.0, 512.0, 983.0];
    // Cameras that look straight down, and beyond the edge, where tiles far from the inset are needed as well.
    let (down, out) = ("+900,0,-90,40", "+300,90,-15,40");
    let views = [
        (middle, middle, down),
        (far, middle, down),
        (900.0, middle, out),
        // These are drawn in the long tier.
        (near, middle, down),
        (middle, near, down),
        (middle, far, down),
        (far, far, down),
    ];
    let views = &views[..if full() { 7 } else { 3 }];
    let shift = DVec2::splat(f64::from(INSET[0]));
    let Some(mut world) = World::of_store(inset.clone(), folder, store, ALLOWED_PX) else { return };
    let errors_px = inset_errors_px(&mut world, shift, views);
    println!("99.9 % of the errors are within {errors_px:.4?} px; the first view is the middle");
    let mut planted = World::of_store(inset, tempfile::tempdir().unwrap(), bare, ALLOWED_PX).unwrap();
    let planted_px = inset_errors_px(&mut planted, shift, views);
    println!("without tiles beyond the inset {planted_px:.4?} px");
    assert!(errors_px.iter().all(|&error_px| error_px <= ALLOWED_PX), "{errors_px:?}");
    assert!(planted_px[1..].iter().all(|&error_px| error_px > ALLOWED_PX), "{planted_px:?}");
}

/// A DEM that is smaller than the space between samples of the coarsest level is drawn in full: on a wide plain, and with
/// nothing but another DEM far away.
#[test]
fn a_small_member_is_drawn_in_a_wide_world() {
    const ALLOWED_PX: f64 = 0.25;
    let spacing_m = 30.0;
    let at = [40_000.0, -25_000.0].map(|samples| spacing_m * samples);
    let inset = local(257, 257, spacing_m, at, |x, y| common::rough_height_m(x - at[0], y - at[1]));
    let plain = local(65, 65, 1024.0 * spacing_m, [0.0, 0.0], |_, _| 400.0);
    let island = local(257, 257, spacing_m, [0.0, 0.0], common::rough_height_m);
    let views = [(128.0, 128.0, "+900,0,-90,40"), (128.0, 40.0, "+300,180,-15,40")];
    for other in [plain, island].into_iter().take(if full() { 2 } else { 1 }) {
        let (folder, store) = store(&[&inset, &other]);
        let coarsest = f64::from(store.levels().len() as u32 - 1).exp2();
        assert!(coarsest > 64.0, "the coarsest samples are {coarsest} apart");
        let shift = DVec2::new(40_000.0, 25_000.0);
        let unaware = Faulty::of(&store, Planted::UnawareOfSmall);
        let Some(mut world) = World::of_store(inset.clone(), folder, store, ALLOWED_PX) else { return };
        let errors_px = inset_errors_px(&mut world, shift, &views);
        println!("99.9 % of the errors are within {errors_px:.4?} px");
        assert!(errors_px.iter().all(|&error_px| error_px <= ALLOWED_PX), "{errors_px:?}");
        let mut planted = World::of_store(inset.clone(), tempfile::tempdir().unwrap(), unaware, ALLOWED_PX).unwrap();
        let pose = planted.pose(&format!("{},{},4000,0,-90,40", at[0], at[1]));
        let style = of_outlines(ink("footprint"));
        let shot = shoot_style(&mut planted, &mut None, pose, pose, [160, 160], &style, &PartRule::default());
        let drawn = (0..shot.depth_m.len()).filter(|&pixel| !shot.is_sky(pixel) && shot.world_m(pixel).z > 700.0);
        assert_eq!(drawn.count(), 0, "the planted error draws the mountains");
    }
}

#[test]
fn reference_systems_meet() {
    let proj = |text: &str| proj4rs::Proj::from_proj_string(text).unwrap();
    let utm = proj("+proj=utm +zone=10 +datum=WGS84 +units=m");
    let geographic = proj("+proj=longlat +a=6378137 +rf=298.257223563");
    let of = |longitude: f64, latitude: f64| 500.0 + 300.0 * (80.0 * longitude).sin() * (90.0 * latitude).cos();
    let epsg = |name: &str, metres_per_unit| Crs::Projected { metres_per_unit, name: name.into() };
    let mut fine = local(300, 300, 30.0, [550_000.0, 5_200_000.0], |x, y| {
        let mut point = (x, y, 0.0);
        proj4rs::transform::transform(&utm, &geographic, &mut point).unwrap();
        of(point.0.to_degrees(), point.1.to_degrees())
    });
    fine.georeference.crs = epsg("EPSG:32610", 1.0);
    let mut wide = local(400, 400, 0.001, [-122.5, 47.05], of);
    wide.georeference.crs = Crs::Geographic {
        radians_per_unit: 1f64.to_radians(),
        semi_major_axis_m: 6_378_137.0,
        inverse_flattening: 298.257_223_563,
        name: "EPSG:4326".into(),
    };
    let read = reader(&[&wide, &fine]);
    let [width, height] = read.size();
    let heights_m = whole(&read);
    let [x0, step, _, y0, _, down] = read.georeference().crs_from_grid;
    assert_eq!((step, down), (30.0, -30.0));
    let (mut compared, mut near) = (0, 0);
    for i in (0..heights_m.len()).step_by(97) {
        let (column, row) = (i as u32 % width, i as u32 / width);
        let mut point = (x0 + step * f64::from(column), y0 + down * f64::from(row), 0.0);
        proj4rs::transform::transform(&utm, &geographic, &mut point).unwrap();
        let expected = of(point.0.to_degrees(), point.1.to_degrees());
        if !heights_m[i].is_nan() {
            compared += 1;
            let error_m = (f64::from(heights_m[i]) - expected).abs();
            // Within half a sample of a member's border the surface is extrapolated by its outermost polynomial.
            assert!(error_m < 8.0, "{column} {row}: {}, expected {expected}", heights_m[i]);
            near += u32::from(error_m < 0.3);
        }
    }
    assert!(compared * 97 > width * height / 2 && near * 100 > compared * 98, "{near} of {compared}");
    fine.georeference.crs = epsg("a plane of my own", 1.0);
    let members: Vec<Box<dyn HeightReader>> = vec![Box::new(Grid(fine)), Box::new(Grid(wide))];
    let message = MosaicReader::new(members).err().unwrap().to_string();
    assert!(message.contains("a plane of my own") && !message.contains('\n'), "{message}");
}

/// Returns a grid of `side` × `side` samples whose first is at (west, north), in degrees or in another CRS.
fn placed(crs: &Crs, west: f64, north: f64, step: f64, side: u32) -> HeightGrid {
    let heights_m = (0..side * side).map(|i| (west + f64::from(i)) as f32).collect();
    let crs_from_grid = [west, step, 0.0, north, 0.0, -step];
    let georeference = Georeference { crs_from_grid, crs: crs.clone(), geokeys: Default::default() };
    HeightGrid { width: side, height: side, heights_m, georeference }
}

fn degrees() -> Crs {
    Crs::Geographic {
        radians_per_unit: 1f64.to_radians(),
        semi_major_axis_m: 6_378_137.0,
        inverse_flattening: 298.257_223_563,
        name: "EPSG:4326".into(),
    }
}

#[test]
fn neighbours_at_the_antimeridian_are_neighbours() {
    let mercator = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:3857".into() };
    let half_m = 20_037_508.342_789_244;
    let step = 1.0 / 24.0;
    // Members with samples in the middle of their cells, and members that share a column, as those of SRTM do.
    for (crs, east, west, step, side, columns) in [
        (degrees(), 180.0 - 23.5 * step, -180.0 + 0.5 * step, step, 24, 48),
        (degrees(), 179.0, -180.0, step, 25, 49),
        (degrees(), 179.0, 180.0, step, 25, 49),
        (mercator, half_m - 23.5 * 100.0, -half_m + 50.0, 100.0, 24, 48),
    ] {
        let (left, right) = (placed(&crs, east, -16.0, step, side), placed(&crs, west, -16.0, step, side));
        for order in [[&left, &right], [&right, &left]] {
            let mosaic = reader(&order);
            assert_eq!(mosaic.size(), [columns, side], "{crs:?}");
            let heights_m = whole(&mosaic);
            let [at, last] = [&left, &right].map(|grid| grid.heights_m[side as usize + 1]);
            let row = columns as usize;
            assert_eq!(heights_m[row + 1], at);
            assert_eq!(heights_m[row + row - side as usize + 1], last);
            assert!(heights_m.iter().all(|height_m| height_m.is_finite()), "no gap");
            let mapping = WorldMapping::new(mosaic.georeference(), columns, side).unwrap();
            let width_m =
                mapping.world_from_grid(f64::from(columns - 1), 12.0).x - mapping.world_from_grid(0.0, 12.0).x;
            let degree_m = if step < 1.0 { 107_000.0 } else { 1.0 / 1.000_1 };
            let expected_m = f64::from(columns - 1) * step * degree_m;
            assert!((width_m / expected_m - 1.0).abs() < 0.01, "{crs:?}: {width_m} m wide, not {expected_m}");
        }
    }
    // A member in another reference system: UTM zone 1, which begins at 180°, and longitudes to the west.
    let utm = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32701".into() };
    let (left, right) = (placed(&degrees(), 179.5, -16.0, 0.01, 50), placed(&utm, 180_000.0, 8_225_000.0, 1000.0, 48));
    let [width, height] = reader(&[&left, &right]).size();
    assert!(width < 120 && height < 60, "{width} × {height} samples, not around the earth");
}

/// Returns a grid in longitudes and latitudes of a code.
fn of_datum(epsg: u16) -> Crs {
    let definition = crs_definitions::from_code(epsg).unwrap().proj4;
    let axis_m = if definition.contains("NAD27") { 6_378_206.4 } else { 6_378_137.0 };
    Crs::Geographic {
        radians_per_unit: 1f64.to_radians(),
        semi_major_axis_m: axis_m,
        inverse_flattening: 298.257_223_563,
        name: format!("EPSG:{epsg}"),
    }
}

#[test]
fn members_on_two_datums_are_shifted() {
    // Two tiles of 1" side by side; the same place on NAD27 is about 4" further east in the west of America.
    let step = 1.0 / 3600.0;
    let corner = |west: f64, epsg: u16| placed(&of_datum(epsg), west, 47.0, step, 50);
    let columns = |east: u16| reader(&[&corner(-122.0, 4269), &corner(-122.0 + 50.0 * step, east)]).size()[0];
    assert_eq!((columns(4269), columns(4326)), (100, 100), "NAD83 and WGS 84 are the same within 2 m");
    let shifted = columns(4267);
    assert!((94..100).contains(&shifted), "{shifted} columns: NAD27 is shifted by about 95 m");
}

#[test]
fn projections_of_one_name_and_other_parameters_are_two() {
    let lambert = |longitude: f64, name: &str| {
        let text = crs_definitions::from_code(2154).unwrap().wkt.replace("AUTHORITY[\"EPSG\"", "AUTHORITY[\"mine\"");
        let text = text.replace("\"central_meridian\",3", &format!("\"central_meridian\",{longitude}"));
        let geokeys = hachure::source::wkt::keys(&text).unwrap();
        let crs = Crs::Projected { metres_per_unit: 1.0, name: name.into() };
        let grid = placed(&crs, 700_000.0, 6_600_000.0, 100.0, 50);
        HeightGrid { georeference: Georeference { geokeys, ..grid.georeference }, ..grid }
    };
    let width = |a: &HeightGrid, b: &HeightGrid| reader(&[a, b]).size()[0];
    assert_eq!(width(&lambert(3.0, "unknown"), &lambert(3.0, "unknown")), 50);
    // One degree at 46.5° N is 76 km.
    let apart = width(&lambert(3.0, "unknown"), &lambert(4.0, "unknown"));
    assert!((750..850).contains(&apart), "{apart} columns");
}

#[test]
fn members_on_two_continents_are_a_warning() {
    let warned = |west: f64| {
        let (a, b) = (placed(&degrees(), 7.0, 46.0, 0.01, 100), placed(&degrees(), west, 46.0, 0.01, 100));
        common::log::with_warnings(|| drop(reader(&[&a, &b]))).1
    };
    let said = warned(-112.0);
    assert!(said.contains("the 2 files cover 1.67 % of the 12000 × 100 samples"), "{said}");
    assert_eq!(warned(8.5), "", "a gap of half a tile is none");
}
