//! Height files as they are downloaded: compressed, in archives, as netCDF, as EXR, as text of other countries.

use std::path::Path;

use hachure::file::exr::{Channel, Samples, write_exr};
use hachure::source::{self, HeightUnit, OpenOptions, Silent, open, open_reader_with};
use netcdf_writer::{NcAttrValue, NcFileBuilder, NcWriteFormat, NcWriteOptions};

use crate::compare::{check, compare};
use crate::dem::Dem;
use crate::write::{self, NORTH, SPACING, WEST, gzip, netcdf, tar, zip};

#[test]
fn downloads_are_read_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let dem = Dem::new(40, 30, 3);
    let place = write::ascii(&at("dem.asc"), &dem, false);
    let asc = std::fs::read(at("dem.asc")).unwrap();
    write::ehdr(&at("grid.bil"), &dem, "I");
    let [bil, hdr, prj] = ["grid.bil", "grid.hdr", "grid.prj"].map(|name| std::fs::read(at(name)).unwrap());
    gzip(&at("a.asc.gz"), &asc);
    check(&at("a.asc.gz"), &dem, place);
    let with_prj: [(&str, &[u8]); 4] =
        [("readme.txt", b"words"), ("d/grid.bil", &bil), ("d/grid.hdr", &hdr), ("d/grid.prj", &prj)];
    zip(&at("b.zip"), &with_prj);
    assert_eq!(check(&at("b.zip"), &dem, place).georeference.geokeys.epsg, Some(32610));
    std::fs::write(at("c.tar"), tar(&with_prj)).unwrap();
    assert_eq!(check(&at("c.tar"), &dem, place).georeference.geokeys.epsg, Some(32610));
    gzip(&at("d.tgz"), &tar(&with_prj));
    assert_eq!(check(&at("d.tgz"), &dem, place).georeference.geokeys.epsg, Some(32610));
    let tile = Dem::new(1201, 1201, 0);
    gzip(&at("N46E008.hgt.gz"), &write::hgt_bytes(&tile));
    let grid = open(&at("N46E008.hgt.gz"), &Silent).unwrap();
    compare(&grid, &tile, [8.0, 1.0 / 1200.0, 0.0, 47.0, 0.0, -1.0 / 1200.0]).unwrap();

    // A folder has them as members; its archives of something else are not.
    gzip(&at("notes.txt.gz"), b"words");
    zip(&at("e.zip"), &[("grass.jpg", b"\xff\xd8\xff")]);
    ["dem.asc", "grid.bil", "grid.hdr", "grid.prj"].iter().for_each(|name| std::fs::remove_file(at(name)).unwrap());
    let members = hachure::internals::members(folder.path()).unwrap();
    let names: Vec<_> = members.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["N46E008.hgt.gz", "a.asc.gz", "b.zip", "c.tar", "d.tgz"]);
    // Another archive under the same name is another DEM.
    let identity = || source::open_reader(&at("b.zip")).unwrap().identity();
    let before = identity();
    assert_eq!(identity(), before);
    zip(&at("b.zip"), &with_prj[1..]);
    assert_ne!(identity(), before);
}

#[test]
fn archives_that_hold_no_single_dem_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.zip");
    let error = || {
        let text = open(&path, &Silent).unwrap_err().to_string();
        assert!(text.contains("a.zip: ") && !text.contains('\n') && text.len() < 400, "{text}");
        text
    };
    zip(&path, &[("a.asc", b"1"), ("b/b.TIF", b"2"), ("c.hgt", b"3")]);
    assert!(error().contains("holds 3 height files (a.asc, b.TIF, c.hgt); unpack it"));
    zip(&path, &[("grass.jpg", b"\xff\xd8\xff")]);
    assert!(error().contains("is an archive without a height file"));
    // What is wrong with the file inside is said with both names, and without that of the temporary folder.
    zip(&path, &[("a.tif", b"II*\0garbage")]);
    let text = error();
    assert!(text.contains("a.zip: a.tif: is damaged") && !text.contains("hachure-"), "{text}");
    std::fs::write(&path, &std::fs::read(&path).unwrap()[..40]).unwrap();
    assert!(error().contains("is damaged"));
}

#[test]
fn netcdf_is_read_by_windows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nc");
    let dem = Dem::new(50, 40, 3);
    let from_south = Dem { heights: dem.rows().rev().flatten().copied().collect(), ..dem.clone() };
    for (format, is_packed) in
        [(NcWriteFormat::Classic, false), (NcWriteFormat::Nc4, false), (NcWriteFormat::Nc4, true)]
    {
        netcdf(&path, &dem, format, is_packed);
        let grid = check(&path, &from_south, [8.0, 1.0 / 240.0, 0.0, 46.0, 0.0, 1.0 / 240.0]);
        assert_eq!(grid.georeference.geokeys.epsg, Some(4326), "{format:?}");
        let reader = source::open_reader(&path).unwrap();
        let window = source::Window { x: 7, y: 20, width: 20, height: 11 };
        let part = reader.read(window).unwrap();
        let expected = |index: usize| grid.heights_m[(20 + index / 20) * 50 + 7 + index % 20];
        assert!(part.iter().enumerate().all(|(i, it)| it.to_bits() == expected(i).to_bits()), "{format:?}");
    }
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let text = open(&path, &Silent).unwrap_err().to_string();
    assert!(text.contains("a.nc: is damaged") && !text.contains('\n'), "{text}");
}

/// Attributes of a variable: names and texts.
type Attributes<'a> = &'a [(&'a str, &'a str)];

/// Writes the heights 0 to 5 over two dimensions with coordinates, the first of 2 entries and the second of 3; the
/// variable `crs` is the grid mapping.
fn small_netcdf(path: &Path, dimensions: [(&str, Attributes); 2], heights: (&str, Attributes), mapping: Attributes) {
    let mut builder = NcFileBuilder::new();
    let add = |builder: &mut NcFileBuilder, variable, attributes: Attributes| {
        for (name, text) in attributes {
            builder.add_variable_attribute(variable, *name, NcAttrValue::Chars((*text).to_owned())).unwrap();
        }
    };
    let counts = [2, 3];
    let ids = [0, 1].map(|i| builder.add_dimension(dimensions[i].0, counts[i]).unwrap());
    for (i, (name, attributes)) in dimensions.into_iter().enumerate() {
        let variable = builder.add_variable::<f64>(name, &[ids[i]]).unwrap();
        add(&mut builder, variable, attributes);
        let values: Vec<f64> = (0..counts[i]).map(|it| 40.0 + 0.5 * it as f64).collect();
        builder.write_variable(variable, &values).unwrap();
    }
    if !mapping.is_empty() {
        let crs = builder.add_variable::<i32>("crs", &[]).unwrap();
        builder.write_variable(crs, &[0]).unwrap();
        add(&mut builder, crs, mapping);
    }
    let variable = builder.add_variable::<f32>(heights.0, &ids).unwrap();
    add(&mut builder, variable, heights.1);
    if !mapping.is_empty() {
        add(&mut builder, variable, &[("grid_mapping", "crs")]);
    }
    builder.write_variable(variable, &[0.0_f32, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
    std::fs::write(path, builder.to_vec(NcWriteOptions::classic()).unwrap().1).unwrap();
}

const LAT: (&str, Attributes) = ("lat", &[("units", "degrees_north")]);
const LON: (&str, Attributes) = ("lon", &[("units", "degrees_east")]);

#[test]
fn netcdf_depths_are_below_the_sea() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nc");
    let depth = ("standard_name", "sea_floor_depth_below_geoid");
    let cases: [(&str, Attributes, f32); 5] = [
        ("z", &[], 1.0),
        ("z", &[depth], -1.0),
        ("depths", &[depth], -1.0),
        ("elevation", &[("positive", "down")], -1.0),
        ("z", &[depth, ("positive", "up")], 1.0),
    ];
    for (name, attributes, sign) in cases {
        small_netcdf(&path, [LAT, LON], (name, attributes), &[]);
        let grid = open(&path, &Silent).unwrap();
        assert_eq!(grid.heights_m, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|it| sign * it), "{name} {attributes:?}");
    }
}

#[test]
fn netcdf_dimensions_have_any_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nc");
    let projected: [(&str, Attributes); 2] =
        [("a", &[("standard_name", "projection_x_coordinate")]), ("b", &[("axis", "Y")])];
    let unnamed: [(&str, Attributes); 2] = [("x", &[]), ("y", &[])];
    for dimensions in [[LON, LAT], unnamed, projected] {
        small_netcdf(&path, dimensions, ("z", &[]), &[]);
        let grid = open(&path, &Silent).unwrap();
        assert_eq!((grid.width, grid.height), (2, 3), "{dimensions:?}");
        assert_eq!(grid.heights_m, [0.0, 3.0, 1.0, 4.0, 2.0, 5.0], "{dimensions:?}");
        let part = source::open_reader(&path).unwrap().read(source::Window { x: 1, y: 1, width: 1, height: 2 });
        assert_eq!(part.unwrap(), [4.0, 5.0]);
    }
    small_netcdf(&path, [LAT, LON], ("z", &[]), &[]);
    assert_eq!(open(&path, &Silent).unwrap().heights_m, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    small_netcdf(&path, [("lat", &[("axis", "X")]), LON], ("z", &[]), &[]);
    let text = open(&path, &Silent).unwrap_err().to_string();
    assert!(text.contains("both dimensions of \"z\" run east"), "{text}");
}

#[test]
fn netcdf_grids_are_placed_only_where_their_mapping_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nc");
    let error = || open(&path, &Silent).unwrap_err().to_string();
    let named = |name: &'static str| [("grid_mapping_name", name)];
    small_netcdf(&path, [LAT, LON], ("z", &[]), &named("latitude_longitude"));
    assert_eq!(open(&path, &Silent).unwrap().georeference.geokeys.epsg, Some(4326));
    for name in ["rotated_latitude_longitude", "lambert_conformal_conic"] {
        small_netcdf(&path, [LAT, LON], ("z", &[]), &named(name));
        assert!(error().contains(&format!("its grid mapping is \"{name}\"")), "{}", error());
    }
    // Well-Known Text of a rotated pole describes the globe before it was rotated.
    let wkt = "GEOGCS[\"a\",UNIT[\"degree\",0.0174532925199433],AUTHORITY[\"EPSG\",\"4326\"]]";
    let mut with_wkt = vec![("crs_wkt", wkt), ("grid_mapping_name", "lambert_conformal_conic")];
    small_netcdf(&path, [LAT, LON], ("z", &[]), &with_wkt);
    assert_eq!(open(&path, &Silent).unwrap().georeference.geokeys.epsg, Some(4326));
    with_wkt[1].1 = "rotated_latitude_longitude";
    small_netcdf(&path, [LAT, LON], ("z", &[]), &with_wkt);
    assert!(error().contains("rotated_latitude_longitude"), "{}", error());
    let rotated = [("units", "degrees"), ("standard_name", "grid_longitude")];
    small_netcdf(&path, [LAT, ("rlon", &rotated)], ("z", &[]), &[]);
    assert!(error().contains("rotated_latitude_longitude"), "{}", error());
    // Kilometres of a projection.
    let km: [(&str, Attributes); 2] = [("y", &[("units", "km")]), ("x", &[("units", "kilometers")])];
    small_netcdf(&path, km, ("z", &[]), &named("lambert_conformal_conic"));
    let georeference = open(&path, &Silent).unwrap().georeference;
    assert_eq!(georeference.crs_from_grid, [40_000.0, 500.0, 0.0, 40_000.0, 0.0, 500.0]);
    assert_eq!(georeference.geokeys.epsg, None);
    // The .prj gives the system, also when it changes.
    let prj = |code: u32| {
        let text = format!("PROJCS[\"a\",UNIT[\"metre\",1],AUTHORITY[\"EPSG\",\"{code}\"]]");
        std::fs::write(folder.path().join("a.prj"), text + &" ".repeat(code as usize % 10)).unwrap();
        let reader = source::open_reader(&path).unwrap();
        (reader.georeference().geokeys.epsg, reader.georeference().crs_from_grid[1], reader.identity())
    };
    let (first, second) = (prj(32610), prj(32611));
    assert_eq!((first.0, first.1, second.0), (Some(32610), 500.0, Some(32611)));
    assert_ne!(first.2, second.2);
}

#[test]
fn points_may_have_decimal_commas() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.xyz");
    let dem = Dem::new(40, 30, 0);
    for (separator, header) in [(";", ""), ("; ", "X;Y;Z\n"), (" ", ""), ("\t", "\u{feff}")] {
        let mut text = header.to_owned();
        for (index, height) in dem.heights.iter().enumerate() {
            let (x, y) = (WEST + (index % 40) as f64 * SPACING, NORTH - (index / 40) as f64 * SPACING);
            text += &format!("{x:.2}{separator}{y:.2}{separator}{height}.00\n").replace('.', ",");
        }
        std::fs::write(&path, &text).unwrap();
        check(&path, &dem, write::PLACE);
    }
}

#[test]
fn exr_pictures_of_heights_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let dem = Dem::new(40, 30, 0);
    let samples = Samples::F32(dem.expected());
    let channels = |names: &[&str]| -> Vec<Channel> {
        names.iter().map(|name| Channel { name: (*name).to_owned(), samples: samples.clone() }).collect()
    };
    std::fs::write(folder.path().join("a.exr.toml"), "spacing_m = 30\norigin = [594000, 5195010]\nheight_scale_m = 1")
        .unwrap();
    let other = Samples::F32(vec![0.5; 1200]);
    let beside = |name: &str, others: &[&str]| {
        let others = others.iter().map(|other_name| Channel { name: (*other_name).to_owned(), samples: other.clone() });
        others.chain(channels(&[name])).collect::<Vec<_>>()
    };
    let heights = [
        channels(&["Y"]),
        channels(&["height"]),
        channels(&["R", "G", "B"]),
        beside("Z", &["A"]),
        beside("Y", &["A"]),
        beside("height", &["B", "G", "R"]),
    ];
    for channels in heights {
        write_exr(&path, 40, 30, &channels, &[]).unwrap();
        check(&path, &dem, write::PLACE);
    }
    // The depth of a rendered picture, and the luminance of one in colours, are no heights.
    for colours in [beside("G", &["B", "R"]), beside("Z", &["B", "G", "R"]), beside("Y", &["BY", "RY"])] {
        write_exr(&path, 40, 30, &colours, &[]).unwrap();
        let text = open(&path, &Silent).unwrap_err().to_string();
        assert!(text.contains("a picture in colours, not heights"), "{text}");
    }
}

#[test]
fn heights_in_feet_are_converted_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.asc");
    let dem = Dem::new(40, 30, 3);
    write::ascii(&path, &dem, false);
    let read =
        |options: &OpenOptions| source::read_all(&*open_reader_with(&path, options).unwrap(), &path, &Silent).unwrap();
    let identity = |options: &OpenOptions| open_reader_with(&path, options).unwrap().identity();
    for (unit, metres) in [(HeightUnit::Ft, 0.3048), (HeightUnit::UsFt, 1200.0 / 3937.0)] {
        let options = OpenOptions { height_unit: Some(unit), ..OpenOptions::default() };
        let grid = read(&options);
        let agrees =
            |(read, feet): (&f32, f32)| read.is_nan() && feet.is_nan() || *read == (f64::from(feet) * metres) as f32;
        assert!(grid.heights_m.iter().zip(dem.expected()).all(agrees), "{unit:?}");
        assert!(!grid.heights_m.iter().zip(&dem.heights).all(|(read, feet)| *read == f32::from(*feet)));
        assert_ne!(identity(&options), identity(&OpenOptions::default()));
    }
    assert_eq!(
        read(&OpenOptions { height_unit: Some(HeightUnit::M), ..OpenOptions::default() }).heights_m[5],
        f32::from(dem.heights[5])
    );
    // A file that declares feet is in metres already.
    let mut builder = NcFileBuilder::new();
    let (y, x) = (builder.add_dimension("y", 2).unwrap(), builder.add_dimension("x", 2).unwrap());
    for (name, dimension) in [("y", y), ("x", x)] {
        let variable = builder.add_variable::<f64>(name, &[dimension]).unwrap();
        builder.write_variable(variable, &[1000.0, 1030.0]).unwrap();
    }
    let z = builder.add_variable::<f32>("z", &[y, x]).unwrap();
    builder.add_variable_attribute(z, "units", NcAttrValue::Chars("feet".to_owned())).unwrap();
    builder.write_variable(z, &[100.0_f32, 200.0, 300.0, 400.0]).unwrap();
    let path = folder.path().join("a.nc");
    std::fs::write(&path, builder.to_vec(NcWriteOptions::classic()).unwrap().1).unwrap();
    assert_eq!(open(&path, &Silent).unwrap().heights_m[0], 30.48);
    let options = OpenOptions { height_unit: Some(HeightUnit::Ft), ..OpenOptions::default() };
    let text = open_reader_with(&path, &options).err().unwrap().to_string();
    assert!(
        text.contains("declares heights in feet (0.3048 m), which are converted; leave out --height-unit"),
        "{text}"
    );
}
