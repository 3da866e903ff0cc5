//! Files that lack information: sidecar files and options supply it.

use hachure::source::georeference::Crs;
use hachure::source::{OpenOptions, Silent, open, open_reader_with, read_all};

use crate::compare::{check, compare};
use crate::dem::Dem;
use crate::write;

#[test]
fn a_side_file_says_what_raw_samples_mean() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Dem::new(50, 40, 3).above_sea();
    let path = folder.path().join("heights.r16");
    write::raw(&path, &dem, true);
    let error = open(&path, &Silent).unwrap_err().to_string();
    assert!(error.contains("its size is unknown") && error.contains("heights.r16.toml"), "{error}");
    let side = folder.path().join("heights.r16.toml");
    let text = "width = 50\nheight = 40\nspacing_m = 30\nheight_scale_m = 1\nendian = \"big\"\nno_data = 0\n\
                crs = \"EPSG:32610\"\norigin = [594000.0, 5195010.0]\n";
    std::fs::write(&side, text).unwrap();
    assert_eq!(check(&path, &dem, write::PLACE).georeference.geokeys.epsg, Some(32610));
    // With a CRS in feet, spacing_m is still in metres.
    std::fs::write(&side, text.replace("32610", "2853")).unwrap();
    let grid = open(&path, &Silent).unwrap();
    let Crs::Projected { metres_per_unit, .. } = grid.georeference.crs else { panic!("{:?}", grid.georeference.crs) };
    assert!((grid.georeference.crs_from_grid[1] * metres_per_unit - 30.0).abs() < 1e-9);
    // Options take precedence over the sidecar file.
    let options = OpenOptions { height_scale_m: Some(0.5), height_offset_m: Some(-7.0), ..OpenOptions::default() };
    let reader = open_reader_with(&path, &options).unwrap();
    let grid = read_all(&*reader, &path, &Silent).unwrap();
    for (ours, expected) in grid.heights_m.iter().zip(dem.expected()) {
        assert!(ours.is_nan() && expected.is_nan() || *ours == expected * 0.5 - 7.0);
    }
    for (wrong, word) in [
        ("width = 50\nheight = 41", "50×41 samples need 4100 bytes, but the file has 4000; check width and height in"),
        ("widht = 50", "did you mean \"width\""),
        ("spacing_m = 0", "spacing must be a number above 0"),
        ("width = 50\nheight = 40\ncrs = \"EPSG:1\"\norigin = [0, 0]", "unknown"),
        ("width = 50\nheight = 40\ncrs = \"EPSG:4326\"\norigin = [0, 0]", "spacing_degrees"),
        ("width = 4000000000\nheight = 4000000000", "check width and height in"),
    ] {
        std::fs::write(&side, wrong).unwrap();
        let error = open(&path, &Silent).unwrap_err().to_string();
        assert!(error.contains(word) && error.contains("heights.r16") && !error.contains('\n'), "{error}");
    }
}

#[test]
fn options_say_it_without_a_side_file() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Dem::new(50, 40, 0).above_sea();
    let path = folder.path().join("heights.data");
    write::raw(&path, &dem, true);
    assert!(open(&path, &Silent).is_err());
    let options =
        OpenOptions { size: Some([50, 40]), spacing_m: Some(2.5), big_endian: Some(true), ..OpenOptions::default() };
    let reader = open_reader_with(&path, &options).unwrap();
    let grid = read_all(&*reader, &path, &Silent).unwrap();
    compare(&grid, &dem, [0.0, 2.5, 0.0, 0.0, 0.0, -2.5]).unwrap();
    let error = open_reader_with(&path, &OpenOptions { size: Some([50, 41]), ..options }).err().unwrap().to_string();
    assert!(
        error.contains("heights.data: 50×41 samples need 4100 bytes") && error.ends_with("check --raw-size"),
        "{error}"
    );
    let other = open_reader_with(&path, &OpenOptions { spacing_m: Some(3.0), ..options }).unwrap();
    assert_ne!(reader.identity(), other.identity());
}

#[test]
fn pictures_of_something_else_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    let refusal = |color, depth, bytes: &[u8]| {
        write::png(&path, [16, 16], color, depth, bytes);
        let error = open(&path, &Silent).unwrap_err().to_string();
        assert!(error.contains("picture.png: holds") && error.contains("not heights"), "{error}");
    };
    let noise: Vec<u8> = (0..16 * 16 * 6).map(|index| (index * 7919 % 251) as u8).collect();
    refusal(png::ColorType::Grayscale, png::BitDepth::Eight, &noise[..256]);
    refusal(png::ColorType::Rgb, png::BitDepth::Eight, &noise[..768]);
    refusal(png::ColorType::Rgb, png::BitDepth::Sixteen, &noise);
    let grey: Vec<u8> = (0..256).flat_map(|index| [100 + (index % 16) as u8; 3]).collect();
    refusal(png::ColorType::Rgb, png::BitDepth::Eight, &grey);
    // An encoding in a sidecar file is not questioned.
    std::fs::write(folder.path().join("picture.png.toml"), "encoding = \"terrarium\"\nspacing_m = 10").unwrap();
    assert_eq!(open(&path, &Silent).unwrap().heights_m[0], 100.0 * 256.0 + 100.0 + 100.0 / 256.0 - 32_768.0);
}

#[test]
fn world_files_give_the_place_of_any_raster() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let dem = Dem::new(50, 40, 0).above_sea();
    let world = "30\n0.0\n0,0\n-30\n594000\n5195010\n";
    let quiet = OpenOptions { size: Some([50, 40]), big_endian: Some(false), ..OpenOptions::default() };
    let read = |name: &str, options: &OpenOptions| {
        let reader = open_reader_with(&at(name), options).unwrap_or_else(|error| panic!("{error}"));
        (read_all(&*reader, &at(name), &Silent).unwrap(), reader.identity())
    };
    write::png16(&at("a.png"), &dem);
    write::raw(&at("b.raw"), &dem, false);
    write::raw(&at("c.r16"), &dem, false);
    let channel = hachure::file::exr::Samples::F32(dem.expected());
    let channel = hachure::file::exr::Channel { name: "Y".to_owned(), samples: channel };
    hachure::file::exr::write_exr(&at("d.exr"), 50, 40, &[channel], &[]).unwrap();
    for (name, worlds) in [
        ("a.png", &["a.pgw", "a.pngw", "a.PGW", "a.wld", "a.png.wld"][..]),
        ("b.raw", &["b.rww", "b.raww", "b.wld"]),
        ("c.r16", &["c.r6w", "c.wld"]),
        ("d.exr", &["d.exrw", "d.wld"]),
    ] {
        let (alone, bare) = read(name, &quiet);
        assert!(compare(&alone, &dem, write::PLACE).is_err());
        for file in worlds {
            std::fs::write(at(file), world).unwrap();
            let (grid, identity) = read(name, &quiet);
            compare(&grid, &dem, write::PLACE).unwrap_or_else(|error| panic!("{file}: {error}"));
            assert_ne!(identity, bare, "{file}");
            // A .prj beside it gives the reference system.
            let prj = at(name).with_extension("prj");
            std::fs::write(&prj, write::UTM_PRJ).unwrap();
            assert_eq!(read(name, &quiet).0.georeference.geokeys.epsg, Some(32610), "{file}");
            std::fs::remove_file(&prj).unwrap();
            // A spacing that is given replaces that of the file, but not the place.
            let place = [write::WEST, 10.0, 0.0, write::NORTH, 0.0, -10.0];
            let options = OpenOptions { spacing_m: Some(10.0), ..quiet };
            compare(&read(name, &options).0, &dem, place).unwrap();
            std::fs::write(at(file), "no numbers").unwrap();
            assert_eq!(read(name, &quiet).0.georeference, alone.georeference);
            std::fs::remove_file(at(file)).unwrap();
        }
    }
    // GDAL's own file takes precedence, and also gives the system and no-data.
    let aux = "<PAMDataset><SRS>EPSG:32610</SRS><GeoTransform> 593985, 30, 0, 5195025, 0, -30</GeoTransform>\
               <PAMRasterBand band=\"1\"><NoDataValue>1</NoDataValue><Scale>1</Scale></PAMRasterBand></PAMDataset>";
    let wkt = write::UTM_PRJ.replace('"', "&quot;");
    std::fs::write(at("a.png.aux.xml"), aux.replace("EPSG:32610", &wkt)).unwrap();
    std::fs::write(at("a.pgw"), world.replace("30", "40")).unwrap();
    let (grid, _) = read("a.png", &quiet);
    assert_eq!(grid.georeference.crs_from_grid, write::PLACE);
    assert_eq!(grid.georeference.geokeys.epsg, Some(32610));
    let agrees = |(read, height): (&f32, &i16)| if *height == 1 { read.is_nan() } else { *read == f32::from(*height) };
    assert!(grid.heights_m.iter().zip(&dem.heights).all(agrees) && dem.heights.contains(&1));
}

#[test]
fn a_header_without_a_place_takes_it_from_a_world_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bil");
    let dem = Dem::new(50, 40, 3);
    write::ehdr(&path, &dem, "I");
    let header = std::fs::read_to_string(path.with_extension("hdr")).unwrap();
    let without = header.lines().filter(|line| !line.contains("MAP")).collect::<Vec<_>>().join("\n");
    std::fs::write(path.with_extension("hdr"), without).unwrap();
    std::fs::write(path.with_extension("blw"), "30\n0\n0\n-30\n594000\n5195010\n").unwrap();
    check(&path, &dem, write::PLACE);
}
