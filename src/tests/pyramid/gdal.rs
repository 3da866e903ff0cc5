//! Tests that other software reads our GeoTIFF: another reader crate, and GDAL where it is installed.

use std::process::Command;

use geotiff_reader::GeoTiffFile;
use hachure::source::georeference::{Crs, Georeference};

use crate::tests::pyramid::{baked, world};

#[test]
fn gdal_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("world.tif");
    for max_error_m in [0.0, 0.05] {
        let pyramid = baked(&world::grid(), &out, max_error_m);
        let Ok(run) = Command::new("gdalinfo").args(["-stats", "-checksum"]).arg(&out).output() else {
            println!("skipped: gdalinfo is not installed");
            return;
        };
        let (said, warned) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
        assert!(run.status.success() && warned.is_empty(), "{said}\n{warned}");
        for expected in [
            "Size is 601, 487",
            "ID[\"EPSG\",32610]",
            "Origin = (590000.000000000000000,5200000.000000000000000)",
            "Pixel Size = (10.000000000000000,-10.000000000000000)",
            "LAYOUT=COG",
            "Block=256x256 Type=Float32",
            "NoData Value=nan",
            "Unit Type: m",
            "Overviews: 301x244, 151x122",
        ] {
            assert!(said.contains(expected), "{expected} is missing in\n{said}");
        }
        let line = said.lines().find_map(|line| line.trim().strip_prefix("STATISTICS_MINIMUM=")).unwrap();
        assert!((line.parse::<f64>().unwrap() - f64::from(pyramid.min_m())).abs() < 1e-2, "{said}");
    }
}

#[test]
fn every_georeference_survives() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("place.tif");
    let wgs_84 = |name: &str| Crs::Geographic {
        radians_per_unit: std::f64::consts::PI / 180.0,
        semi_major_axis_m: 6_378_137.0,
        inverse_flattening: 298.257_223_563,
        name: name.into(),
    };
    let feet = Crs::Projected { metres_per_unit: 1200.0 / 3937.0, name: "a county's own".into() };
    let arc_second = 1.0 / 3600.0;
    let north_up = [-121.0 - arc_second / 3.0, arc_second / 3.0, 0.0, 47.0 + 0.1 + 0.2, 0.0, -arc_second / 3.0];
    for (crs_from_grid, crs, wkt) in [
        (north_up, wgs_84("EPSG:4326"), "ID[\"EPSG\",4326]"),
        (north_up, wgs_84("some sphere"), "some sphere"),
        ([5.0, 30.0, 0.0, 7.0, 0.0, 30.0], feet, "a county's own"),
        ([5.0, 3.0, 4.0, 7.0, 4.0, -3.0], Crs::Local, ""),
    ] {
        let mut grid = world::rough(40, 30, false);
        grid.georeference = Georeference { crs_from_grid, crs, geokeys: Default::default() };
        let pyramid = baked(&grid, &out, 0.0);
        assert_eq!(pyramid.georeference(), &grid.georeference);
        let file = GeoTiffFile::open(&out).unwrap();
        let transform = file.transform().unwrap();
        for (column, row) in [(0.0, 0.0), (39.0, 0.0), (0.0, 29.0)] {
            let [x0, x_column, x_row, y0, y_column, y_row] = crs_from_grid;
            let expected = (x0 + column * x_column + row * x_row, y0 + column * y_column + row * y_row);
            let (x, y) = transform.pixel_to_geo(column + 0.5, row + 0.5);
            assert!((x - expected.0).abs() < 1e-9 && (y - expected.1).abs() < 1e-9, "{x} {y} {expected:?}");
        }
        match Command::new("gdalinfo").arg(&out).output() {
            Ok(run) => {
                let said = String::from_utf8_lossy(&run.stdout);
                assert!(run.status.success() && run.stderr.is_empty() && said.contains(wkt), "{wkt}: {said} {run:?}");
            }
            Err(_) => println!("skipped: gdalinfo is not installed"),
        }
    }
}
