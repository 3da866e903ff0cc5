//! Files written in each format are read with the same heights, bit for bit.

use hachure::source::georeference::Crs;

use crate::compare::check;
use crate::dem::Dem;
use crate::write::{self, NOWHERE};

fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn srtm_tiles() {
    let folder = scratch();
    let dem = Dem::new(1201, 1201, 2);
    let step = 1.0 / 1200.0;
    let path = folder.path().join("N46E008.hgt");
    write::hgt(&path, &dem);
    let grid = check(&path, &dem, [8.0, step, 0.0, 47.0, 0.0, -step]);
    assert_eq!(grid.georeference.geokeys.epsg, Some(4326));
    let path = folder.path().join("s33W071.SRTMGL3.hgt");
    write::hgt(&path, &dem);
    check(&path, &dem, [-71.0, step, 0.0, -32.0, 0.0, -step]);
    // In an archive, the position is in the name of the member.
    let path = folder.path().join("tile.zip");
    write::hgt_zip(&path, "folder/N46E008.hgt", &dem);
    check(&path, &dem, [8.0, step, 0.0, 47.0, 0.0, -step]);
    let narrow = Dem::new(1801, 3601, 0);
    let path = folder.path().join("N61E010.hgt");
    write::hgt(&path, &narrow);
    check(&path, &narrow, [10.0, 1.0 / 1800.0, 0.0, 62.0, 0.0, -1.0 / 3600.0]);
}

#[test]
fn ascii_grids() {
    let folder = scratch();
    let dem = Dem::new(37, 29, 10);
    for (name, is_centre) in [("corner.asc", false), ("centre.grd", true)] {
        let path = folder.path().join(name);
        let place = write::ascii(&path, &dem, is_centre);
        let grid = check(&path, &dem, place);
        assert_eq!(grid.georeference.crs, Crs::Local);
        std::fs::write(path.with_extension("prj"), write::UTM_PRJ).unwrap();
        assert_eq!(check(&path, &dem, place).georeference.geokeys.epsg, Some(32610));
    }
    let path = folder.path().join("grass.txt");
    let place = write::grass(&path, &dem);
    check(&path, &dem, place);
    // Cells that are not square, decimal commas, words for no-data, and a header in any order.
    let path = folder.path().join("odd.asc");
    std::fs::write(&path, "dx 2,5\ndy 5\nnrows 2 ncols 2\nyllcorner 10 xllcorner 0\nnan 1,5\n-1.#IND 2E1").unwrap();
    let grid = hachure::source::open(&path, &hachure::source::Silent).unwrap();
    assert_eq!(grid.georeference.crs_from_grid, [1.25, 2.5, 0.0, 17.5, 0.0, -5.0]);
    assert!(grid.heights_m[0].is_nan() && grid.heights_m[2].is_nan());
    assert_eq!((grid.heights_m[1], grid.heights_m[3]), (1.5, 20.0));
}

#[test]
fn xyz_grids() {
    let folder = scratch();
    let dem = Dem::new(23, 31, 0);
    let path = folder.path().join("grid.xyz");
    let place = write::xyz(&path, &dem);
    check(&path, &dem, place);
    let text = std::fs::read_to_string(&path).unwrap();
    let gap: String =
        text.lines().enumerate().filter(|(line, _)| *line != 40).map(|(_, it)| format!("{it}\n")).collect();
    std::fs::write(&path, gap).unwrap();
    let error = hachure::source::open(&path, &hachure::source::Silent).unwrap_err().to_string();
    assert!(error.contains("not a complete regular grid"), "{error}");
}

#[test]
fn rasters_with_a_header() {
    let folder = scratch();
    let dem = Dem::new(41, 33, 5);
    for order in ["I", "M"] {
        let path = folder.path().join("dem.bil");
        let place = write::ehdr(&path, &dem, order);
        assert_eq!(check(&path, &dem, place).georeference.geokeys.epsg, Some(32610));
        check(&path.with_extension("hdr"), &dem, place);
    }
    let path = folder.path().join("float.flt");
    let place = write::grid_float(&path, &dem);
    assert_eq!(check(&path, &dem, place).georeference.geokeys.epsg, Some(26910));
    for interleave in ["bip", "bil", "bsq"] {
        let path = folder.path().join("envi.img");
        let place = write::envi(&path, &dem, interleave);
        assert_eq!(check(&path, &dem, place).georeference.geokeys.epsg, Some(32610));
        check(&path.with_extension("hdr"), &dem, place);
    }
}

#[test]
fn dted() {
    let folder = scratch();
    let dem = Dem::new(61, 121, 5);
    let path = folder.path().join("n46.dt0");
    let place = write::dted(&path, &dem, 61);
    assert_eq!(check(&path, &dem, place).georeference.geokeys.epsg, Some(4326));
    // A wrong checksum gives a warning, and the file is read.
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    check(&path, &dem, place);
    // Missing columns are no-data.
    write::dted(&path, &dem, 50);
    let mut partial = dem.clone();
    partial.heights.chunks_mut(61).for_each(|row| row[50..].fill(i16::MIN));
    check(&path, &partial, place);
}

#[test]
fn usgs_dem() {
    let folder = scratch();
    // Profiles of one record and of several.
    for (height, line_breaks) in [(100, false), (400, false), (400, true)] {
        let mut dem = Dem::new(9, height, 4);
        for column in 0..9 {
            (height - 3 - column..height).for_each(|row| dem.heights[row * 9 + column] = i16::MIN);
        }
        let path = folder.path().join("quadrangle.dem");
        let place = write::usgs_dem(&path, &dem, line_breaks);
        assert_eq!(check(&path, &dem, place).georeference.geokeys.epsg, Some(26710));
    }
}

#[test]
fn pictures_and_raw_files() {
    let folder = scratch();
    let dem = Dem::new(50, 50, 0).above_sea();
    let path = folder.path().join("heights.png");
    write::png16(&path, &dem);
    check(&path, &dem, NOWHERE);
    let path = folder.path().join("heights.r16");
    write::raw(&path, &dem, false);
    check(&path, &dem, NOWHERE);
    let dem = Dem::new(50, 40, 3);
    for is_mapbox in [false, true] {
        let path = folder.path().join("colours.png");
        write::terrain_rgb(&path, &dem, is_mapbox);
        // Slopes of a hundred metres per pixel prove the encoding `terrarium`, whose bytes carry at 256 m, but not
        // `mapbox`.
        if is_mapbox {
            let error = hachure::source::open(&path, &hachure::source::Silent).unwrap_err().to_string();
            assert!(error.contains("--encoding mapbox"), "{error}");
            std::fs::write(folder.path().join("colours.png.toml"), "encoding = \"mapbox\"").unwrap();
        }
        check(&path, &dem, NOWHERE);
    }
}
