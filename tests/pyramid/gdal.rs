//! What others make of the GeoTIFF: GDAL's own reader, where it is installed.

use std::process::Command;

use crate::{baked, world};

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
