//! Tests the place of a height file's samples: the GeoTIFF keys, and the mapping to the world's metres.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]

use geotiff_writer::{
    Compression, GeoKeyValue, GeoTiffBuilder, ModelType, NumericSample, PhotometricInterpretation, RasterType,
};
use glam::DVec2;
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::{self, GeoKeys, GeoreferenceError, HeightGrid, Silent, SourceError, WorldMapping};
use ndarray::{Array2, Array3};

/// Writes a file and opens it.
fn open<T: NumericSample>(builder: &GeoTiffBuilder, samples: &Array2<T>) -> Result<HeightGrid, SourceError> {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("made.tif");
    builder.write_2d(&path, samples.view()).unwrap();
    let result = source::open(&path, &Silent);
    if let Err(error) = &result {
        assert!(error.to_string().contains("made.tif"), "{error}");
    }
    result
}

/// Returns six samples, 1 to 6, in three columns and two rows.
fn samples() -> Array2<f32> {
    Array2::from_shape_fn((2, 3), |(row, column)| (row * 3 + column + 1) as f32)
}

fn utm() -> GeoTiffBuilder {
    GeoTiffBuilder::new(3, 2)
        .model_type(ModelType::Projected)
        .epsg(32610)
        .pixel_scale(10.0, 20.0)
        .origin(500_000.0, 4_000_000.0)
}

fn place(grid: &HeightGrid) -> [f64; 6] {
    grid.georeference.crs_from_grid
}

#[test]
fn a_pixel_is_an_area_or_a_point() {
    let area = open(&utm().raster_type(RasterType::PixelIsArea), &samples()).unwrap();
    assert_eq!(area.heights_m, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(place(&area), [500_005.0, 10.0, 0.0, 3_999_990.0, 0.0, -20.0]);
    assert_eq!(area.georeference.crs, Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32610".into() });
    assert_eq!(area.georeference.geokeys.epsg, Some(32610));
    assert_eq!(area.georeference.geokeys.raster_type, Some(1));

    let tie_point = [0.0, 0.0, 0.0, 500_000.0, 4_000_000.0, 0.0];
    let point = open(&utm().raster_type(RasterType::PixelIsPoint).tiepoint(tie_point), &samples()).unwrap();
    assert_eq!(place(&point), [500_000.0, 10.0, 0.0, 4_000_000.0, 0.0, -20.0]);

    // A tie point need not be at the first sample.
    let elsewhere = open(&utm().tiepoint([2.0, 1.0, 0.0, 500_000.0, 4_000_000.0, 0.0]), &samples()).unwrap();
    assert_eq!(place(&elsewhere), [499_985.0, 10.0, 0.0, 4_000_010.0, 0.0, -20.0]);
}

#[test]
fn a_matrix_may_rotate_and_turn_the_rows_north() {
    let matrix =
        |a: f64, b: f64, c: f64, d: f64| [a, b, 0.0, 1000.0, c, d, 0.0, 2000.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let builder =
        |matrix| GeoTiffBuilder::new(3, 2).model_type(ModelType::Projected).epsg(32610).transformation_matrix(matrix);
    let rotated = open(&builder(matrix(8.0, 6.0, 6.0, -8.0)), &samples()).unwrap();
    assert_eq!(place(&rotated), [1007.0, 8.0, 6.0, 1999.0, 6.0, -8.0]);
    let mapping = WorldMapping::new(&rotated.georeference, 3, 2).unwrap();
    // The next column is 10 m away, to the east-north-east; the origin is the middle of the samples.
    assert_eq!(mapping.world_from_grid(2.0, 0.5) - mapping.world_from_grid(1.0, 0.5), DVec2::new(8.0, 6.0));
    assert_eq!(mapping.world_from_grid(1.0, 0.5), DVec2::ZERO);
    let south_up = open(&builder(matrix(8.0, 0.0, 0.0, 8.0)), &samples()).unwrap();
    let mapping = WorldMapping::new(&south_up.georeference, 3, 2).unwrap();
    assert!(mapping.world_from_grid(0.0, 1.0).y > mapping.world_from_grid(0.0, 0.0).y);
    let line = Georeference { crs_from_grid: [0.0, 8.0, 4.0, 0.0, 4.0, 2.0], ..south_up.georeference };
    assert_eq!(WorldMapping::new(&line, 3, 2).unwrap_err(), GeoreferenceError::PixelSize);
}

#[test]
fn feet_become_metres() {
    let survey_foot = 1200.0 / 3937.0;
    // Keys in the file override those of the EPSG code, whose unit is metres.
    let horizontal = open(&utm().geokey(3076, GeoKeyValue::Short(9003)), &samples()).unwrap();
    assert!(
        matches!(horizontal.georeference.crs, Crs::Projected { metres_per_unit, .. } if metres_per_unit == survey_foot)
    );
    assert_eq!(horizontal.heights_m[5], 6.0);
    let by_code =
        GeoTiffBuilder::new(3, 2).model_type(ModelType::Projected).epsg(26730).pixel_scale(1.0, 1.0).origin(0.0, 0.0);
    let by_code = open(&by_code, &samples()).unwrap();
    assert!(
        matches!(by_code.georeference.crs, Crs::Projected { metres_per_unit, .. } if (metres_per_unit - survey_foot).abs() < 1e-15)
    );

    let vertical = open(&utm().vertical_epsg(6360).vertical_units(9003), &samples()).unwrap();
    assert_eq!(vertical.heights_m[5], (6.0 * survey_foot) as f32);
    // A file written from these heights, which are metres, must not say feet again.
    let keys = &vertical.georeference.geokeys;
    assert_eq!((keys.short(4096), keys.short(4099)), (None, Some(9001)));
    let by_code = open(&utm().vertical_epsg(8228), &samples()).unwrap();
    assert_eq!(by_code.heights_m[5], (6.0 * 0.3048) as f32);
}

#[test]
fn what_the_keys_leave_open_is_assumed_or_refused() {
    let bare = open(&GeoTiffBuilder::new(3, 2), &samples()).unwrap();
    assert_eq!((place(&bare), &bare.georeference.crs), ([0.0, 1.0, 0.0, 0.0, 0.0, -1.0], &Crs::Local));
    let local = open(&GeoTiffBuilder::new(3, 2).pixel_scale(5.0, 5.0).origin(10.0, 20.0), &samples()).unwrap();
    assert_eq!((place(&local)[0], &local.georeference.crs), (12.5, &Crs::Local));

    let user_defined = utm().geokey(3072, GeoKeyValue::Short(32767)).geokey(1026, GeoKeyValue::Ascii("My grid".into()));
    let user_defined = open(&user_defined, &samples()).unwrap();
    assert_eq!(user_defined.georeference.crs, Crs::Projected { metres_per_unit: 1.0, name: "My grid".into() });
    assert_eq!(user_defined.georeference.geokeys.epsg, None);

    let located = |builder: &GeoTiffBuilder| match open(builder, &samples()) {
        Err(SourceError::Georeference { source, .. }) => source,
        other => panic!("{other:?}"),
    };
    let unknown = utm().geokey(3072, GeoKeyValue::Short(1));
    assert_eq!(located(&unknown), GeoreferenceError::UnknownCrs { epsg: 1 });
    assert!(open(&unknown.geokey(3076, GeoKeyValue::Short(9001)), &samples()).is_ok());
    let geocentric = utm().model_type(ModelType::Geocentric).geokey(2048, GeoKeyValue::Short(4978));
    assert_eq!(located(&geocentric), GeoreferenceError::Geocentric);
    let geographic = |north| {
        let builder = GeoTiffBuilder::new(3, 2).model_type(ModelType::Geographic).epsg(4326);
        builder.pixel_scale(1.0, 1.0).origin(7.0, north)
    };
    assert!(matches!(located(&geographic(95.0)), GeoreferenceError::BeyondPole { .. }));
    assert!(open(&geographic(90.5), &samples()).is_ok(), "a first row on the pole must be accepted");
}

#[test]
fn voids_are_nan() {
    let with = |values: [f32; 6]| Array2::from_shape_vec((2, 3), values.to_vec()).unwrap();
    let voids = |grid: HeightGrid| grid.heights_m.iter().map(|height| height.is_nan()).collect::<Vec<_>>();
    let odd = with([f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -3.4e38, -9999.0, 5.0]);
    assert_eq!(voids(open(&utm(), &odd).unwrap()), [true, true, true, true, false, false]);
    assert_eq!(voids(open(&utm().nodata("-9999"), &odd).unwrap()), [true, true, true, true, true, false]);
    assert_eq!(voids(open(&utm().nodata("nan"), &odd).unwrap()), [true, true, true, true, false, false]);

    let untagged = Array2::from_shape_vec((2, 3), vec![-32768i16, -32767, -32766, 0, 1, 2]).unwrap();
    assert_eq!(voids(open(&utm(), &untagged).unwrap()), [true, true, false, false, false, false]);
    let nothing = open(&utm(), &with([f32::NAN; 6]));
    assert!(matches!(nothing, Err(SourceError::AllNoData { .. })));
    let column = GeoTiffBuilder::new(1, 4).pixel_scale(1.0, 1.0).origin(0.0, 0.0);
    let column = open(&column, &Array2::<f32>::zeros((4, 1))).unwrap_err().to_string();
    assert!(column.contains("1×4") && column.contains("at least 2×2"), "{column}");
}

#[test]
fn blocks_that_a_sparse_file_leaves_out_hold_no_data() {
    // Four tiles of 16 × 16 samples, of which only the first contains anything but zeros.
    let samples = Array2::from_shape_fn((32, 32), |(row, column)| if row.max(column) < 16 { 7i16 } else { 0 });
    let sparse = GeoTiffBuilder::new(32, 32).tile_size(16, 16).sparse(true);
    let zeros = open(&sparse, &samples).unwrap();
    assert_eq!((zeros.heights_m[0], zeros.heights_m[16]), (7.0, 0.0));
    let voids = open(&sparse.nodata("-9999"), &samples).unwrap();
    assert_eq!(voids.heights_m[0], 7.0);
    assert_eq!(voids.heights_m.iter().filter(|height| height.is_nan()).count(), 3 * 256);
}

#[test]
fn a_header_may_not_claim_more_than_the_file_can_hold() {
    let scratch = tempfile::tempdir().unwrap();
    for compression in [Compression::None, Compression::Deflate] {
        for size in [40_000u32, 1 << 20, u32::MAX] {
            let path = scratch.path().join("claims.tif");
            utm().compression(compression).write_2d(&path, samples().view()).unwrap();
            let mut bytes = std::fs::read(&path).unwrap();
            // The entries of ImageWidth and ImageLength: tag, type LONG, count 1, value.
            for tag in [0, 1] {
                let entry = [tag, 1, 4, 0, 1, 0, 0, 0];
                let at = bytes.windows(8).position(|window| window == entry).unwrap() + entry.len();
                bytes[at..at + 4].copy_from_slice(&size.to_le_bytes());
            }
            std::fs::write(&path, bytes).unwrap();
            let error = source::open(&path, &Silent).unwrap_err();
            assert!(!matches!(error, SourceError::Open { .. }), "{error}");
        }
    }
}

#[test]
fn the_first_of_several_bands_is_read_but_a_picture_is_refused() {
    let bands = Array3::from_shape_fn((2, 3, 2), |(row, column, band)| (row * 3 + column + 100 * band) as i16);
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("bands.tif");
    GeoTiffBuilder::new(3, 2).bands(2).write_3d(&path, bands.view()).unwrap();
    assert_eq!(source::open(&path, &Silent).unwrap().heights_m, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let picture = Array3::<u8>::zeros((2, 3, 3));
    let builder = GeoTiffBuilder::new(3, 2).bands(3).photometric(PhotometricInterpretation::Rgb);
    builder.write_3d(&path, picture.view()).unwrap();
    let error = source::open(&path, &Silent).unwrap_err().to_string();
    assert!(
        error.contains("bands.tif: holds an RGB picture, not heights; terrain-RGB is read only from PNG"),
        "{error}"
    );
}

const WGS84: [f64; 2] = [6_378_137.0, 298.257_223_563];

/// Returns the georeference of 201 × 201 samples about a point, `step` degrees apart.
fn geographic(
    longitude: f64,
    latitude: f64,
    step: f64,
    [semi_major_axis_m, inverse_flattening]: [f64; 2],
) -> Georeference {
    let radians_per_unit = 1f64.to_radians();
    Georeference {
        crs_from_grid: [longitude - 100.0 * step, step, 0.0, latitude + 100.0 * step, 0.0, -step],
        crs: Crs::Geographic { radians_per_unit, semi_major_axis_m, inverse_flattening, name: "test".into() },
        geokeys: GeoKeys::default(),
    }
}

/// Expected values are from PROJ 9 (pyproj 3.7), `+proj=tmerc +k=1` about the centre, on the given ellipsoid.
#[test]
fn geographic_grids_go_where_proj_puts_them() {
    let grs80 = [6_378_137.0, 298.257_222_101];
    let clarke = [6_378_206.4, 294.978_698_213_898_2];
    let cases = [
        (-121.75, 46.85, WGS84, 0.03, (-121.25, 47.35), (37778.91450636408, 55707.63921269029)),
        (-121.75, 46.85, WGS84, 0.03, (-122.25, 46.35), (-38486.69057391744, -55460.0073397506)),
        (-121.75, 46.85, WGS84, 0.03, (-118.75, 49.85), (215739.18706491886, 337910.2412215363)),
        (-121.75, 46.85, WGS84, 0.03, (-124.75, 43.85), (-241228.5386116738, -329038.6948381108)),
        (180.0, -17.0, WGS84, 0.03, (177.0, -19.0), (-315990.58565667423, -224056.00052049512)),
        (180.0, -17.0, WGS84, 0.03, (183.0, -15.0), (322780.07381785, 219129.0003914896)),
        (-180.0, -17.0, WGS84, 0.03, (-177.0, -15.0), (322780.07381785, 219129.0003914896)),
        (20.0, 70.0, grs80, 0.1, (-10.0, 60.0), (-1633178.7359059749, -731540.7407870914)),
        (20.0, 70.0, grs80, 0.1, (50.0, 80.0), (556984.9150529258, 1263334.2169566562)),
        (0.0, 0.0, WGS84, 0.5, (-50.0, -40.0), (-4297392.5573924, -5829574.377894898)),
        (10.0, 40.0, clarke, 0.03, (8.0, 38.0), (-175678.032124825, -220138.49743670234)),
        (10.0, 40.0, clarke, 0.03, (12.0, 42.0), (165709.6716951559, 224040.0012892345)),
        (137.0, 10.0, [3_396_190.0, 0.0], 0.03, (135.0, 8.0), (-117418.60394475957, -118264.09607680749)),
        (137.0, 10.0, [3_396_190.0, 0.0], 0.03, (139.0, 12.0), (115980.32465750548, 118970.38245990571)),
    ];
    for (longitude, latitude, ellipsoid, step, point, expected) in cases {
        let mapping = WorldMapping::new(&geographic(longitude, latitude, step, ellipsoid), 201, 201).unwrap();
        assert!(mapping.describe().starts_with("transverse Mercator"), "{}", mapping.describe());
        let (column, row) = (100.0 + (point.0 - longitude) / step, 100.0 - (point.1 - latitude) / step);
        let world_m = mapping.world_from_grid(column, row);
        let error_m = (world_m - DVec2::from(expected)).length();
        assert!(error_m < 1e-6, "{point:?} about {longitude}, {latitude}: {error_m} m from {expected:?}");
        let back = mapping.crs_from_world(world_m);
        assert!((back - DVec2::from(point)).length() < 1e-11, "{back}, expected {point:?}");
    }
}

#[test]
fn the_way_back_is_exact_and_the_origin_in_the_middle() {
    let feet = Crs::Projected { metres_per_unit: 1200.0 / 3937.0, name: "feet".into() };
    let oblique = [5e5, 0.8, 0.6, 4e6, 0.6, -0.8];
    let places = [
        Georeference { crs_from_grid: oblique, crs: feet, geokeys: GeoKeys::default() },
        geographic(-121.75, 46.85, 1.0 / 3600.0 / 9.0, WGS84),
        geographic(179.99, -45.0, 1.0 / 1200.0, WGS84),
        geographic(25.0, 79.0, 0.1, WGS84),
        geographic(0.0, 5.0, 0.8, WGS84),
        geographic(0.0, 0.0, 0.3, [1_737_400.0, 0.0]),
    ];
    for place in places {
        let mapping = WorldMapping::new(&place, 201, 201).unwrap();
        let origin = mapping.world_from_grid(100.0, 100.0);
        assert!(origin.length() < 1e-8, "{origin}: {}", mapping.describe());
        for (column, row) in [(0.0, 0.0), (200.0, 0.0), (0.0, 200.0), (200.0, 200.0), (33.3, 150.25), (99.5, 100.5)] {
            let back = mapping.grid_from_world(mapping.world_from_grid(column, row));
            let error = (back - DVec2::new(column, row)).length();
            assert!(error < 1e-6, "{error} samples at {column}, {row}: {}", mapping.describe());
        }
    }
}

#[test]
fn the_whole_earth_is_laid_out_flat() {
    let georeference =
        Georeference { crs_from_grid: [-180.0, 1.0, 0.0, 90.0, 0.0, -1.0], ..geographic(0.0, 0.0, 1.0, WGS84) };
    let mapping = WorldMapping::new(&georeference, 361, 181).unwrap();
    assert!(mapping.describe().starts_with("equidistant cylindrical"), "{}", mapping.describe());
    let corner = mapping.world_from_grid(360.0, 0.0);
    let quarter_m = WGS84[0] * std::f64::consts::FRAC_PI_2;
    assert!((corner - DVec2::new(2.0 * quarter_m, quarter_m)).length() < 1e-6, "{corner}");
    assert!((mapping.grid_from_world(corner) - DVec2::new(360.0, 0.0)).length() < 1e-9);
}

#[test]
fn keys_survive_serialisation() {
    let grid = open(&utm().geokey(1026, GeoKeyValue::Ascii("UTM 10 north".into())), &samples()).unwrap();
    let text = serde_json::to_string(&grid.georeference).unwrap();
    assert_eq!(serde_json::from_str::<Georeference>(&text).unwrap(), grid.georeference);
    let value = &grid.georeference.geokeys.keys[0].value;
    assert!(matches!(GeoKeyValue::from(value), GeoKeyValue::Short(1)), "{value:?}");
}
