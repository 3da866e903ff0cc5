//! Any window of any format equals that part of the whole.

use std::path::{Path, PathBuf};

use hachure::source::{HeightReader, Silent, Window, open_reader, read_all};

use crate::dem::Dem;
use crate::write;

/// Writes one small file in each format.
pub(crate) fn one_of_each(folder: &Path) -> Vec<PathBuf> {
    let dem = Dem::new(50, 50, 3).above_sea();
    let at = |name: &str| folder.join(name);
    write::ascii(&at("a.asc"), &dem, false);
    write::grass(&at("b.txt"), &dem);
    write::xyz(&at("c.xyz"), &dem);
    write::ehdr(&at("d.bil"), &dem, "M");
    write::grid_float(&at("e.flt"), &dem);
    write::envi(&at("f.img"), &dem, "bip");
    write::dted(&at("g.dt0"), &dem, 48);
    write::usgs_dem(&at("h.dem"), &dem, false);
    write::png16(&at("i.png"), &dem);
    write::raw(&at("j.r16"), &dem, false);
    write::terrain_rgb(&at("k.png"), &dem, false);
    let samples = ndarray::Array2::from_shape_fn((50, 50), |(row, column)| f32::from(dem.at(column, row)));
    let tiff = geotiff_writer::GeoTiffBuilder::new(50, 50).tile_size(16, 16).nodata("-32768").pixel_scale(3.0, 3.0);
    let tiff = tiff.origin(5.0, 7.0).compression(geotiff_writer::Compression::Deflate);
    tiff.write_2d(at("l.tif"), samples.view()).unwrap();
    // One uncompressed strip, so the samples can be read in place.
    let plain = geotiff_writer::GeoTiffBuilder::new(50, 50).nodata("-32768").pixel_scale(3.0, 3.0).origin(5.0, 7.0);
    plain.compression(geotiff_writer::Compression::None).write_2d(at("n.tif"), samples.view()).unwrap();
    let mut files: Vec<PathBuf> =
        "a.asc b.txt c.xyz d.bil e.flt f.img g.dt0 h.dem i.png j.r16 k.png l.tif n.tif".split(' ').map(at).collect();
    write::hgt_zip(&at("m.zip"), "N46E008.hgt", &Dem::new(1201, 1201, 1));
    files.push(at("m.zip"));
    files
}

#[test]
fn a_window_is_a_part_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    for path in one_of_each(folder.path()) {
        let name = path.display();
        let reader = open_reader(&path).unwrap_or_else(|error| panic!("{error}"));
        let whole = read_all(&*reader, &path, &Silent).unwrap();
        let [width, height] = reader.size();
        let block = reader.block();
        assert!((1..=width).contains(&block[0]) && (1..=height).contains(&block[1]), "{name}: {block:?}");
        for window in [
            Window { x: 0, y: 0, width: 1, height: 1 },
            Window { x: width - 1, y: height - 1, width: 1, height: 1 },
            Window { x: 7, y: 15, width: 31, height: 3 },
            Window { x: 0, y: height - 20, width, height: 20 },
            Window { x: 17, y: 0, width: 2, height },
            Window { x: 3, y: 3, width: 0, height: 5 },
        ] {
            let part = reader.read(window).unwrap_or_else(|error| panic!("{error}"));
            let bits = |it: &f32| it.to_bits();
            let expected = (window.y..window.y + window.height).flat_map(|row| {
                let first = (row * width + window.x) as usize;
                whole.heights_m[first..first + window.width as usize].iter().map(bits)
            });
            assert!(part.iter().map(bits).eq(expected), "{name}: {window:?}");
        }
        for outside in [
            Window { x: width, y: 0, width: 1, height: 1 },
            Window { x: 0, y: 1, width: 1, height },
            Window { x: u32::MAX, y: 0, width: u32::MAX, height: 1 },
        ] {
            let error = reader.read(outside).unwrap_err().to_string();
            assert!(error.contains("outside") && error.contains(&*path.to_string_lossy()), "{error}");
        }
    }
}

#[test]
fn many_threads_read_one_file() {
    let folder = tempfile::tempdir().unwrap();
    for path in one_of_each(folder.path()) {
        let reader = open_reader(&path).unwrap();
        let reader: &dyn HeightReader = &*reader;
        let whole = read_all(reader, &path, &Silent).unwrap().heights_m;
        let width = reader.size()[0];
        std::thread::scope(|scope| {
            for row in 0..8 {
                let whole = &whole;
                scope.spawn(move || {
                    let part = reader.read(Window { x: 0, y: row, width, height: 1 }).unwrap();
                    let expected = &whole[(row * width) as usize..][..width as usize];
                    assert!(part.iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits()));
                });
            }
        });
    }
}

#[test]
fn a_changed_file_is_another() {
    let folder = tempfile::tempdir().unwrap();
    for path in one_of_each(folder.path()) {
        let before = open_reader(&path).unwrap().identity();
        assert_eq!(open_reader(&path).unwrap().identity(), before);
        let file = std::fs::File::options().append(true).open(&path).unwrap();
        file.set_modified(std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1)).unwrap();
        assert_ne!(open_reader(&path).unwrap().identity(), before, "{}", path.display());
    }
}
