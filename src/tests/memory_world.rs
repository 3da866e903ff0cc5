//! Worlds in memory have the same tiles, errors and pictures as the same heights in a file; impossible heights are
//! refused in one line.

use std::sync::Arc;

use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::pyramid::bake::{BakeWork, bake_reader};
use hachure::pyramid::store::MemoryStore;
use hachure::pyramid::surface::statistics::PatchStatistics;
use hachure::pyramid::{BakeOptions, LoadedTile, Pyramid, PyramidError, TileAddress, TileStore};
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::reader::GridReader;
use hachure::source::{HeightGrid, HeightReader, Silent, SourceError, Window, voids};
use hachure::style::Style;
use hachure::tiles::terrain::TerrainOptions;
use hachure::world::{OpenWorld, WorldError};

use super::common::draw::{draw, north_west, still};
use super::common::hill::Hill;
use super::common::{World, baked, gpu, grid_of, in_memory, rough_height_m};
use super::helpers::styles::of_outlines;

const SIZE_PX: [u32; 2] = [320, 180];

/// Returns the bits of all numbers of patches.
fn patch_bits(patches: &[PatchStatistics]) -> Vec<u32> {
    let bits = |patch: &PatchStatistics| {
        let numbers = [patch.min_m, patch.max_m, patch.mesh_error_m].map(f32::to_bits);
        numbers.into_iter().chain([patch.voids as u32])
    };
    patches.iter().flat_map(bits).collect()
}

/// Returns what differs between two tiles.
fn tile_differences(a: &LoadedTile, b: &LoadedTile) -> Vec<&'static str> {
    let bits = |heights_m: &[f32]| heights_m.iter().map(|height| height.to_bits()).collect::<Vec<_>>();
    let errors = |tile: &LoadedTile| {
        let statistics = &tile.statistics;
        (statistics.error_m.to_bits(), statistics.corner_errors_m.map(f32::to_bits))
    };
    let range = |tile: &LoadedTile| {
        let statistics = &tile.statistics;
        (statistics.min_m.to_bits(), statistics.max_m.to_bits(), statistics.voids)
    };
    let mut differences = Vec::new();
    let mut compare = |what, is_equal: bool| {
        if !is_equal {
            differences.push(what);
        }
    };
    compare("heights", bits(&a.tile.samples) == bits(&b.tile.samples));
    compare("errors", errors(a) == errors(b));
    compare("range", range(a) == range(b));
    compare("patches", patch_bits(a.patches.patches()) == patch_bits(b.patches.patches()));
    compare("occluders", format!("{:?}", a.occluder_minima) == format!("{:?}", b.occluder_minima));
    differences
}

/// Returns the differences between two stores, bit for bit: the kind of each, and its level.
fn differences(a: &Arc<dyn TileStore>, b: &Arc<dyn TileStore>) -> Vec<(&'static str, u32)> {
    assert_eq!((a.levels(), a.is_measured()), (b.levels(), b.is_measured()));
    assert_eq!(a.georeference(), b.georeference());
    let mut found = Vec::new();
    if a.range_m().map(f32::to_bits) != b.range_m().map(f32::to_bits) {
        found.push(("range of all", 0));
    }
    let coarse = |store: &Arc<dyn TileStore>| {
        store.coarse_patches().iter().map(|patches| patch_bits(patches)).collect::<Vec<_>>()
    };
    if coarse(a) != coarse(b) {
        found.push(("coarse patches", 0));
    }
    for (level, size) in (0..).zip(a.levels()) {
        for (y, x) in (0..size.tiles_y()).flat_map(|y| (0..size.tiles_x()).map(move |x| (y, x))) {
            let address = TileAddress { level, x, y };
            let tiles = [a, b].map(|store| Arc::clone(store).load(address).unwrap());
            found.extend(tile_differences(&tiles[0], &tiles[1]).into_iter().map(|what| (what, level)));
        }
    }
    found
}

fn stored(grid: &HeightGrid) -> Result<MemoryStore, PyramidError> {
    MemoryStore::new(grid.clone(), "heights in memory", &Silent)
}

/// Returns rough land with a large hole, in which a single sample is known: the surface of a level there depends on
/// fillings that only coarser levels have.
fn land_with_a_hole() -> HeightGrid {
    let mut grid = grid_of(523, 401, 15.0, rough_height_m);
    for row in 60..360 {
        for column in 150..420 {
            grid.heights_m[row * 523 + column] = f32::NAN;
        }
    }
    grid.heights_m[205 * 523 + 285] = 777.0;
    grid.heights_m[3 * 523 + 4] = f32::NAN;
    grid.heights_m[3 * 523 + 8] = f32::INFINITY;
    grid.georeference.crs = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32610".into() };
    grid
}

/// Returns grids of several shapes, each with the sample that the planted error changes.
fn grids() -> Vec<(&'static str, HeightGrid, usize)> {
    vec![
        ("a smooth hill", Hill::square(321, 10.0).1, 160 * 321 + 100),
        ("rough land with a hole", land_with_a_hole(), 20 * 523 + 500),
        ("more than a row of tiles", grid_of(1300, 530, 20.0, rough_height_m), 400 * 1300 + 1299),
        // More than a chunk of the baker: its coarsest level is made in a second round.
        ("a strip of two chunks", grid_of(4200, 21, 30.0, rough_height_m), 10 * 4200 + 4150),
        ("less than a tile", grid_of(2, 3, 5.0, rough_height_m), 5),
    ]
}

#[test]
fn a_world_in_memory_is_the_world_of_a_file() {
    for (name, grid, planted) in grids() {
        let (_folder, pyramid) = baked(&grid);
        let store = stored(&grid).unwrap();
        assert_eq!(store.void_samples(), pyramid.void_samples());
        assert_eq!(store.void_samples() > 0, name == "rough land with a hole");
        let (store, pyramid): (Arc<dyn TileStore>, Arc<dyn TileStore>) = (Arc::new(store), Arc::new(pyramid));
        assert_eq!(differences(&store, &pyramid), [], "{name}");

        // Planted: one sample is higher by 2 cm, and then higher than all others.
        let mut changed = grid;
        for raised_m in [0.02, 9000.0] {
            changed.heights_m[planted] += raised_m;
            let found = differences(&(Arc::new(stored(&changed).unwrap()) as _), &pyramid);
            println!("{name}: {} differences with a sample {raised_m} m higher", found.len());
            let finds = |what: &str| found.iter().any(|(part, _)| *part == what);
            assert!(finds("heights"), "{name}: {found:?}");
            if raised_m > 1.0 {
                assert!(finds("range of all") && finds("range") && finds("occluders"), "{name}: {found:?}");
                assert!(
                    finds("patches") && finds("coarse patches") != (name == "less than a tile"),
                    "{name}: {found:?}"
                );
                assert!(finds("errors") != (pyramid.levels().len() == 1), "{name}: {found:?}");
            }
        }
        let address = TileAddress { level: 0, x: 0, y: changed.height.div_ceil(256) };
        assert!(matches!(pyramid.load(address), Err(PyramidError::NoSuchTile { .. })));
        let message = Arc::new(stored(&changed).unwrap()).load(address).unwrap_err().to_string();
        assert!(message.starts_with("heights in memory: no tile 0 0"), "{message}");
    }
}

#[test]
fn any_reader_becomes_a_world_in_memory() {
    // Small holes are filled by the reader, in windows for a file and at once in memory.
    let mut grid = land_with_a_hole();
    for i in (7..grid.heights_m.len()).step_by(1009) {
        grid.heights_m[i] = f32::NAN;
    }
    grid.heights_m.iter_mut().filter(|height| height.is_infinite()).for_each(|height| *height = 500.0);
    let reader = voids::filled(Box::new(GridReader::new(grid.clone(), "land".into())));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("land.tif");
    bake_reader(&*reader, &path, &BakeOptions::default(), &BakeWork::default(), &Silent).unwrap();
    let pyramid: Arc<dyn TileStore> = Arc::new(Pyramid::open(&path).unwrap());
    let store = MemoryStore::of_reader(&*reader, "land", &Silent).unwrap();
    assert_eq!(differences(&(Arc::new(store) as _), &pyramid), []);
    // Planted: the holes stay open.
    let open = MemoryStore::of_reader(&GridReader::new(grid, "land".into()), "land", &Silent).unwrap();
    assert!(!differences(&(Arc::new(open) as _), &pyramid).is_empty());
}

#[test]
fn a_store_takes_five_and_a_third_bytes_per_sample() {
    let grid = grid_of(1300, 530, 20.0, rough_height_m);
    let per_sample = stored(&grid).unwrap().bytes() as f64 / grid.heights_m.len() as f64;
    assert!((5.33..5.37).contains(&per_sample), "{per_sample}");
}

#[test]
fn a_picture_of_memory_is_that_of_the_file() {
    let grid = grid_of(601, 530, 20.0, rough_height_m);
    let style = of_outlines(Style::load("lsa").unwrap());
    let picture = |world: &mut World| {
        let pose = world.pose("-1500,-4200,+350,20,-8,55");
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &north_west());
        read(&world.gpu, renderer.target(&PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap()
    };
    let Some(mut memory) = World::new(grid.clone(), 1.0) else { return };
    let mut file = World::of_file(grid.clone(), 1.0).unwrap();
    let drawn = picture(&mut memory);
    assert!(drawn.chunks_exact(8).any(|pixel| pixel != &drawn[..8]), "the picture is empty");
    assert!(drawn == picture(&mut file), "the pictures differ");
    // Planted: a sample in view is higher by 300 m.
    let mut changed = grid;
    changed.heights_m[200 * 601 + 300] += 300.0;
    assert!(drawn != picture(&mut World::new(changed, 1.0).unwrap()), "a changed sample was not seen");
}

#[test]
fn an_array_becomes_a_world() {
    let Some(gpu) = gpu() else { return };
    let (width, height, spacing_m) = (300_u32, 200_u32, 25.0);
    // A ramp that rises to the north and a little to the east, with a hole.
    let mut heights_m: Vec<f32> =
        (0..width * height).map(|i| (height - i / width) as f32 * 2.0 + (i % width) as f32 * 0.5).collect();
    heights_m[0] = f32::NAN;
    heights_m[1] = 2e6;
    let options = TerrainOptions::default();
    let world = OpenWorld::from_heights(&gpu, heights_m.clone(), [width, height], spacing_m, options).unwrap();
    let extent_m = world.extent_m();
    assert!((extent_m[0] - 299.0 * 25.0).abs() < 0.01 && (extent_m[1] - 199.0 * 25.0).abs() < 0.01, "{extent_m:?}");
    let [half_x_m, half_y_m] = extent_m.map(|extent_m| 0.5 * extent_m);
    let off_m = |heights_m: &[f32]| {
        let places = [(5, 5), (150, 3), (290, 190), (12, 150)];
        let off = places.map(|(column, row): (usize, usize)| {
            let place_m = (column as f64 * spacing_m - half_x_m, half_y_m - row as f64 * spacing_m);
            let height_m = f64::from(heights_m[row * width as usize + column]);
            (world.ground_m(place_m.0, place_m.1) - height_m).abs()
        });
        off.into_iter().fold(0.0, f64::max)
    };
    assert!(off_m(&heights_m) < 1e-3, "{}", off_m(&heights_m));
    // Planted: rows from the south.
    let turned: Vec<f32> = heights_m.chunks(width as usize).rev().flatten().copied().collect();
    assert!(off_m(&turned) > 1.0);
    // The corner is a hole, and no height there counts.
    let terrain = &world.surfaces.terrain;
    assert!(terrain.height_m(glam::DVec2::new(0.1 - half_x_m, half_y_m - 0.1)).is_none());
    assert!(terrain.range_m()[1] < 1000.0);

    // The same heights on the earth: the world keeps the georeference.
    let georeference = Georeference {
        crs_from_grid: [590_005.0, 25.0, 0.0, 5_199_995.0, 0.0, -25.0],
        ..Georeference::of_coordinates(Some(32_610)).unwrap()
    };
    let grid = HeightGrid { width, height, heights_m, georeference: georeference.clone() };
    let world = OpenWorld::from_grid(&gpu, grid, options).unwrap();
    assert_eq!(world.surfaces.terrain.store().georeference(), &georeference);
}

/// A reader of a grid of any size that must not be read.
struct Unread([u32; 2], Georeference);

impl HeightReader for Unread {
    fn size(&self) -> [u32; 2] {
        self.0
    }

    fn georeference(&self) -> &Georeference {
        &self.1
    }

    fn read(&self, _: Window) -> Result<Vec<f32>, SourceError> {
        panic!("a refused grid was read");
    }

    fn block(&self) -> [u32; 2] {
        self.0
    }

    fn identity(&self) -> String {
        String::new()
    }
}

fn assert_one_line(message: &str, cause: &str) {
    println!("{message}");
    assert!(message.starts_with("heights in memory: ") && message.contains(cause), "{message}");
    assert!(!message.contains('\n') && message.chars().count() < 200, "{message}");
}

#[test]
fn impossible_heights_are_refused_in_one_line() {
    let of = |width, height, heights_m| {
        let georeference = Georeference::local(width, height, 10.0);
        HeightGrid { width, height, heights_m, georeference }
    };
    let none = [
        (of(1, 5, vec![0.0; 5]), "1 × 5 samples do not make a surface"),
        (of(0, 0, vec![]), "0 × 0 samples do not make a surface"),
        (of(3, 3, vec![0.0; 8]), "8 heights for 3 × 3 samples"),
        (of(3, 3, vec![0.0; 10]), "10 heights for 3 × 3 samples"),
        (of(100_000, 100_000, vec![]), "100000 × 100000 samples are too many"),
        (of(u32::MAX, u32::MAX, vec![]), "samples are too many"),
        (of(300, 300, vec![f32::NAN; 90_000]), "every sample is no-data"),
        (of(300, 300, vec![f32::NEG_INFINITY; 90_000]), "every sample is no-data"),
    ];
    for (grid, cause) in none {
        assert_one_line(&stored(&grid).err().unwrap().to_string(), cause);
    }
    let mut nowhere = of(3, 3, vec![0.0; 9]);
    nowhere.georeference.crs_from_grid[2] = f64::NAN;
    assert_one_line(&stored(&nowhere).err().unwrap().to_string(), "not finite");
    let large = Unread([60_000, 60_000], Georeference::local(60_000, 60_000, 1.0));
    let refused = MemoryStore::of_reader(&large, "heights in memory", &Silent);
    assert_one_line(&refused.err().unwrap().to_string(), "60000 × 60000 samples are too many");
    // A single height is enough.
    let mut single = of(300, 300, vec![f32::NAN; 90_000]);
    single.heights_m[45_000] = 12.5;
    assert_eq!(stored(&single).unwrap().range_m(), [12.5; 2]);

    let Some(gpu) = gpu() else { return };
    let open = |heights_m: Vec<f32>, spacing_m: f64| {
        OpenWorld::from_heights(&gpu, heights_m, [3, 3], spacing_m, TerrainOptions::default())
    };
    for spacing_m in [0.0, -5.0, f64::NAN, f64::INFINITY] {
        let error = open(vec![0.0; 9], spacing_m).err().unwrap();
        assert!(matches!(error, WorldError::Spacing { .. }));
        assert_one_line(&error.to_string(), "a spacing of");
    }
    assert_one_line(&open(vec![0.0; 7], 1.0).err().unwrap().to_string(), "7 heights for 3 × 3 samples");
    assert_one_line(&open(vec![-2e6; 9], 1.0).err().unwrap().to_string(), "every sample is no-data");
    assert!(open(vec![0.0; 9], 1.0).is_ok());
}

#[test]
fn tests_share_the_stores_of_equal_grids() {
    let grid = || grid_of(130, 70, 7.0, |x, y| 0.1 * x + (0.01 * y).sin());
    let first = in_memory(&grid());
    assert!(Arc::ptr_eq(&first, &in_memory(&grid())));
    let mut changed = grid();
    changed.heights_m[4000] += 0.5;
    assert!(!Arc::ptr_eq(&first, &in_memory(&changed)));
    let mut moved = grid();
    moved.georeference.crs_from_grid[0] += 1.0;
    assert!(!Arc::ptr_eq(&first, &in_memory(&moved)));
}
