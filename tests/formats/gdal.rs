//! Files written by GDAL are read with the heights that GDAL was given. Skipped where `gdal_translate` is not
//! installed.

use std::path::Path;
use std::process::Command;

use hachure::source::georeference::Crs;
use hachure::source::{self, HeightGrid, Silent};

use crate::dem::Dem;

/// Converts a file; returns `false` and prints why if GDAL is not installed.
fn translate(from: &Path, to: &Path, arguments: &[&str]) -> bool {
    let output = Command::new("gdal_translate").args(["-q", "-of"]).args(arguments).arg(from).arg(to).output();
    match output {
        Ok(output) if output.status.success() => true,
        Ok(output) => panic!("{}: {}", to.display(), String::from_utf8_lossy(&output.stderr)),
        Err(_) => {
            println!("skipped: gdal_translate is not installed");
            false
        }
    }
}

/// Writes a file of 16-bit heights whose first sample is centred at `first`, and opens it.
fn tiff(path: &Path, dem: &Dem, epsg: u16, first: [f64; 2], step: f64) -> HeightGrid {
    let samples = ndarray::Array2::from_shape_fn((dem.height, dem.width), |(row, column)| dem.at(column, row));
    let model = match epsg {
        4326 => geotiff_writer::ModelType::Geographic,
        _ => geotiff_writer::ModelType::Projected,
    };
    geotiff_writer::GeoTiffBuilder::new(dem.width as u32, dem.height as u32)
        .model_type(model)
        .epsg(epsg)
        .nodata("-32768")
        .pixel_scale(step, step)
        .origin(first[0] - step / 2.0, first[1] + step / 2.0)
        .write_2d(path, samples.view())
        .unwrap();
    source::open(path, &Silent).unwrap()
}

fn check(path: &Path, original: &HeightGrid, with_place: bool) {
    let grid = source::open(path, &Silent).unwrap_or_else(|error| panic!("{error}"));
    let name = path.display();
    assert_eq!([grid.width, grid.height], [original.width, original.height], "{name}");
    let same = |(ours, theirs): (&f32, &f32)| ours.is_nan() && theirs.is_nan() || ours == theirs;
    assert!(grid.heights_m.iter().zip(&original.heights_m).all(same), "{name}: the heights differ");
    if with_place {
        let both = grid.georeference.crs_from_grid.iter().zip(original.georeference.crs_from_grid);
        for (ours, theirs) in both {
            assert!(
                (ours - theirs).abs() <= 1e-11 * theirs.abs().max(1.0),
                "{name}: georeference {ours}, expected {theirs}"
            );
        }
    }
}

#[test]
fn projected_grids_of_gdal() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let original = tiff(&at("dem.tif"), &Dem::new(120, 90, 4), 32610, [594_000.0, 5_195_010.0], 30.0);
    let utm = Some(32610);
    for (name, arguments, epsg) in [
        ("a.asc", &["AAIGrid"][..], utm),
        ("b.bil", &["EHdr"], utm),
        ("c.flt", &["EHdr", "-ot", "Float32"], utm),
        ("d.img", &["ENVI"], utm),
        ("e.bin", &["ENVI", "-ot", "Float64", "-co", "INTERLEAVE=BIL"], utm),
        ("f.xyz", &["XYZ"], None),
        (
            "g.tif",
            &["GTiff", "-co", "COMPRESS=LZW", "-co", "TILED=YES", "-co", "BLOCKXSIZE=64", "-co", "BLOCKYSIZE=32"],
            utm,
        ),
        ("h.tif", &["COG"], utm),
    ] {
        if !translate(&at("dem.tif"), &at(name), arguments) {
            return;
        }
        // XYZ cannot represent no-data.
        if name != "f.xyz" {
            check(&at(name), &original, true);
        }
        let grid = source::open(&at(name), &Silent).unwrap();
        match epsg {
            Some(_) => assert_eq!(grid.georeference.geokeys.epsg, epsg, "{name}: {:?}", grid.georeference.crs),
            None => assert_eq!(grid.georeference.crs, Crs::Local, "{name}"),
        }
    }
}

#[test]
fn geographic_grids_of_gdal() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let original = tiff(&at("dem.tif"), &Dem::new(1201, 1201, 1), 4326, [8.0, 47.0], 1.0 / 1200.0);
    for (name, arguments) in [
        ("N46E008.hgt", &["SRTMHGT"][..]),
        ("n46.dt1", &["DTED", "-a_nodata", "-32767"]),
        ("a.asc", &["AAIGrid", "-co", "DECIMAL_PRECISION=17"]),
        ("b.bil", &["EHdr"]),
        ("c.img", &["ENVI"]),
    ] {
        if !translate(&at("dem.tif"), &at(name), arguments) {
            return;
        }
        if !name.ends_with("dt1") {
            check(&at(name), &original, true);
        }
        let crs = source::open(&at(name), &Silent).unwrap().georeference.crs;
        assert!(matches!(crs, Crs::Geographic { .. }), "{name}: {crs:?}");
    }
    // DTED has another no-data value, which gdal_translate does not substitute for the old one.
    let whole = tiff(&at("whole.tif"), &Dem::new(1201, 1201, 0), 4326, [8.0, 47.0], 1.0 / 1200.0);
    assert!(translate(&at("whole.tif"), &at("whole.dt1"), &["DTED"]));
    check(&at("whole.dt1"), &whole, true);
}

#[test]
fn pictures_of_gdal() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let original = tiff(&at("dem.tif"), &Dem::new(80, 80, 0).above_sea(), 32610, [594_000.0, 5_195_010.0], 30.0);
    if translate(&at("dem.tif"), &at("a.png"), &["PNG", "-ot", "UInt16"]) {
        check(&at("a.png"), &original, false);
        let raw = ["ENVI", "-ot", "UInt16"];
        assert!(translate(&at("dem.tif"), &at("b.img"), &raw));
        std::fs::rename(at("b.img"), at("b.r16")).unwrap();
        check(&at("b.r16"), &original, false);
        assert!(translate(&at("dem.tif"), &at("c.dem"), &["USGSDEM"]));
        check(&at("c.dem"), &original, true);
    }
}

#[test]
fn shapes_of_gdal() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let original = tiff(&at("dem.tif"), &Dem::new(83, 61, 4), 32610, [594_000.0, 5_195_010.0], 30.0);
    let shapes: [&[&str]; 14] = [
        &["COMPRESS=LZMA"],
        &["COMPRESS=LZMA", "TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=32"],
        &["COMPRESS=LZMA", "PREDICTOR=2", "BLOCKYSIZE=16"],
        &["COMPRESS=ZSTD", "PREDICTOR=2", "BLOCKYSIZE=16"],
        &["COMPRESS=LZW", "PREDICTOR=2", "ENDIANNESS=BIG"],
        &["COMPRESS=PACKBITS", "BLOCKYSIZE=16"],
        &["COMPRESS=DEFLATE", "BIGTIFF=YES", "ENDIANNESS=BIG", "TILED=YES"],
        &["COMPRESS=LERC"],
        &["COMPRESS=LERC_ZSTD", "TILED=YES"],
        &["COMPRESS=LERC_DEFLATE", "ENDIANNESS=BIG"],
        &["INTERLEAVE=BAND", "BLOCKYSIZE=1"],
        &["GEOTIFF_KEYS_FLAVOR=ESRI_PE"],
        &["GEOTIFF_VERSION=1.1"],
        &["PROFILE=BASELINE"],
    ];
    for options in shapes {
        let name = at(&format!("{}.tif", options.join("_").replace('=', "")));
        let mut command = Command::new("gdal_translate");
        command.args(["-q", "-of", "GTiff"]).args(options.iter().flat_map(|option| ["-co", option]));
        let Ok(output) = command.arg(at("dem.tif")).arg(&name).output() else {
            println!("skipped: gdal_translate is not installed");
            return;
        };
        let said = String::from_utf8_lossy(&output.stderr);
        if !output.status.success() && said.contains("codec") || said.contains("is an unexpected value for COMPRESS") {
            println!("skipped: {options:?}: {said}");
            continue;
        }
        assert!(output.status.success(), "{options:?}: {said}");
        // Without a GeoTIFF profile, no-data and georeference are in the .aux.xml sidecar.
        check(&name, &original, true);
        let crs = source::open(&name, &Silent).unwrap().georeference.crs;
        assert!(matches!(crs, Crs::Projected { metres_per_unit: 1.0, .. }), "{options:?}: {crs:?}");
    }
}

/// Compares about 600 rasters, which takes minutes, where `HACHURE_GDAL_SUITE` names a Python that has GDAL's bindings.
#[test]
fn the_whole_suite_of_gdal() {
    let Some(python) = std::env::var_os("HACHURE_GDAL_SUITE") else {
        println!("skipped: HACHURE_GDAL_SUITE does not name a Python with GDAL");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/gdal_compare.py");
    let run = |command: &[&str]| {
        let output = Command::new(&python).arg(&script).args(command).arg(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
        said
    };
    run(&["make"]);
    let said = run(&["compare", env!("CARGO_BIN_EXE_hachure")]);
    assert!(said.matches("same ").count() > 400, "{said}");
}
