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
        ("width = 50\nheight = 41", "truncated"),
        ("widht = 50", "did you mean \"width\""),
        ("spacing_m = 0", "other than 0"),
        ("width = 50\nheight = 40\ncrs = \"EPSG:1\"\norigin = [0, 0]", "unknown"),
        ("width = 50\nheight = 40\ncrs = \"EPSG:4326\"\norigin = [0, 0]", "spacing_degrees"),
        ("width = 4000000000\nheight = 4000000000", "truncated"),
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
