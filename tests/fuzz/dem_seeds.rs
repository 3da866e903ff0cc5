//! Undamaged height files that cases of fuzzing mutate.

use std::path::{Path, PathBuf};

use geotiff_writer::{CogBuilder, Compression, GeoTiffBuilder, Predictor, TiffVariant};
use hachure::pyramid::{BakeOptions, bake};
use hachure::source::Silent;
use ndarray::Array2;

use super::dem::Dem;
use super::kinds::{file_name, one, read_heights};
use super::seeds::Seed;
use super::{sparse, world, write};

pub(crate) fn small() -> Dem {
    Dem::new(50, 50, 3).above_sea()
}

pub(crate) fn geotiffs(home: &Path) -> Vec<Seed> {
    let heights = small();
    let floats = Array2::from_shape_fn((50, 50), |(row, column)| f32::from(heights.at(column, row)));
    let wholes = Array2::from_shape_fn((50, 50), |(row, column)| heights.at(column, row));
    let new = || GeoTiffBuilder::new(50, 50).nodata("-32768").pixel_scale(3.0, 3.0).origin(5.0e5, 7.0e6).epsg(32_633);
    let float =
        |name: &str, builder: GeoTiffBuilder| one(home, name, |path| builder.write_2d(path, floats.view()).unwrap());
    let whole =
        |name: &str, builder: GeoTiffBuilder| one(home, name, |path| builder.write_2d(path, wholes.view()).unwrap());
    let seeds = [
        float("tiled.tif", new().tile_size(16, 16).compression(Compression::Deflate)),
        float("lerc.tif", new().tile_size(16, 16).compression(Compression::Lerc)),
        float("zstd.tif", new().compression(Compression::Zstd).predictor(Predictor::FloatingPoint)),
        whole("plain.tif", new().compression(Compression::None)),
        whole("lzw.tif", new().compression(Compression::Lzw).predictor(Predictor::Horizontal)),
        whole("wide.tif", new().tile_size(64, 32).compression(Compression::Lzw)),
        whole("big.tif", new().tile_size(16, 16).compression(Compression::Deflate).tiff_variant(TiffVariant::BigTiff)),
        one(home, "sparse.tif", |path| sparse::write(path, 4096)),
    ];
    seeds.into_iter().flatten().collect()
}

/// Returns real files, where the data exists: every encoding and many unusual variants that GDAL writes.
pub(crate) fn real_geotiffs(home: &Path) -> Vec<Seed> {
    let data = std::env::var_os("HACHURE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
    if !data.join("dem_odd").is_dir() {
        println!("skipped: no real data at {}", data.display());
        return Vec::new();
    }
    let mut files = Vec::new();
    let mut folders = vec![data.join("dem_odd"), data.join("dem/encodings_rainier")];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let (inner, found): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
        folders.extend(inner);
        files.extend(found);
    }
    files.sort();
    let seed = |(number, file): (usize, PathBuf)| {
        let bytes = std::fs::read(&file).unwrap();
        let is_tiff = bytes.starts_with(b"II") || bytes.starts_with(b"MM");
        // A file that is refused without damage tests nothing.
        let is_wanted = is_tiff && bytes.len() < 400_000 && read_heights(&file).is_ok();
        is_wanted.then(|| one(home, &format!("{number}.tif"), |path| std::fs::write(path, bytes).unwrap()))
    };
    files.into_iter().enumerate().filter_map(seed).flatten().collect()
}

pub(crate) fn cogs(home: &Path) -> Vec<Seed> {
    let heights = Dem::new(300, 280, 1);
    let samples = Array2::from_shape_fn((280, 300), |(row, column)| f32::from(heights.at(column, row)));
    let of = |name: &str, compression| {
        one(home, name, |path| {
            let builder = GeoTiffBuilder::new(300, 280).tile_size(64, 64).nodata("-32768").compression(compression);
            let builder = builder.pixel_scale(30.0, 30.0).origin(5.0e5, 7.0e6).epsg(32_633);
            CogBuilder::new(builder).overview_levels(vec![2, 4, 8]).write_2d(path, samples.view()).unwrap();
        })
    };
    of("deflate.tif", Compression::Deflate).into_iter().chain(of("lerc.tif", Compression::Lerc)).collect()
}

pub(crate) fn with_side_file(path: &Path, write: impl FnOnce(&Path, &Dem)) {
    write(path, &small());
    let side = "width = 50\nheight = 50\nspacing_m = 3.5\nheight_scale_m = 0.25\nheight_offset_m = -100\nendian = \"little\"\n\
                no_data = 0\ncrs = \"EPSG:32610\"\norigin = [594000.0, 5195010.0]\n";
    std::fs::write(path.with_file_name(format!("{}.toml", file_name(path))), side).unwrap();
}

/// Writes a picture of heights in GSI's encoding, with a sidecar file that says so.
pub(crate) fn colours(path: &Path, format: write::Colours) {
    let dem = Dem::new(64, 64, 2);
    let pixel = |&height: &i16| match height {
        i16::MIN => [128, 0, 0],
        height => {
            let [_, red, green, blue] = (i32::from(height) * 100).to_be_bytes();
            [red, green, blue]
        }
    };
    let pixels: Vec<[u8; 3]> = dem.heights.iter().map(pixel).collect();
    write::colours(path, [64, 64], &pixels, format);
    std::fs::write(path.with_file_name(format!("{}.toml", file_name(path))), "encoding = \"gsi\"\nspacing_m = 9\n")
        .unwrap();
}

pub(crate) fn tile_folders(home: &Path) -> Vec<Seed> {
    let folder = home.join("tiles");
    let dem = Dem::new(32, 32, 2).above_sea();
    for [x, y] in [[33, 22], [34, 22], [34, 24]] {
        let path: PathBuf = folder.join(format!("6/{x}/{y}.png"));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        write::terrain_rgb(&path, &dem, true);
    }
    std::fs::write(home.join("tiles.toml"), "encoding = \"mapbox\"\n").unwrap();
    vec![Seed::of(&folder, "")]
}

pub(crate) fn pyramids(home: &Path) -> Vec<Seed> {
    let of = |name: &str, max_error_m| {
        one(home, name, |path| {
            bake(&world::rough(300, 60, true), path, &BakeOptions { max_error_m }, &Silent).unwrap();
        })
    };
    of("lossless.tif", 0.0).into_iter().chain(of("lerc.tif", 0.1)).collect()
}
