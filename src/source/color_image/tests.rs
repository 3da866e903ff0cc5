//! Tests that an image is the same in all formats, and that overviews, no-data and opacity are used.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]
#![allow(clippy::disallowed_methods, reason = "files go to temporary folders")]

use std::path::Path;

use geotiff_writer::{
    CogBuilder, ColorMap, Compression, ExtraSample, GeoTiffBuilder, ModelType, PhotometricInterpretation,
    PlanarConfiguration,
};
use ndarray::{Array2, Array3};

use super::{ColorImage, Rgba};
use crate::source::Window;

const SIZE: [usize; 2] = [70, 48];

fn shades(x: usize, y: usize) -> [u8; 3] {
    [(3 * x) as u8, (5 * y) as u8, 255 - (2 * x + y) as u8]
}

fn placed() -> GeoTiffBuilder {
    GeoTiffBuilder::new(SIZE[0] as u32, SIZE[1] as u32)
        .model_type(ModelType::Projected)
        .epsg(32632)
        .pixel_scale(2.0, 2.0)
        .origin(500_000.0, 5_200_000.0)
}

fn rgb() -> GeoTiffBuilder {
    placed().bands(3).photometric(PhotometricInterpretation::Rgb)
}

fn bands<T>(count: usize, value: impl Fn([u8; 3], usize) -> T) -> Array3<T> {
    Array3::from_shape_fn((SIZE[1], SIZE[0], count), |(y, x, band)| value(shades(x, y), band))
}

/// Returns the largest difference of a channel from the expected one.
fn worst(path: &Path, expected: impl Fn([u8; 3]) -> Rgba) -> u8 {
    let image = ColorImage::open(path).unwrap();
    assert_eq!(image.size(), SIZE.map(|side| side as u32), "{}", path.display());
    // A window that begins and ends within blocks.
    let window = Window { x: 3, y: 5, width: 61, height: 40 };
    let pixels = image.read(0, window).unwrap();
    let differences = pixels.iter().enumerate().map(|(index, pixel)| {
        let (x, y) = (index % 61 + 3, index / 61 + 5);
        let expected = expected(shades(x, y));
        (0..4).map(|channel| pixel[channel].abs_diff(expected[channel])).max().unwrap()
    });
    differences.max().unwrap()
}

#[test]
fn an_image_is_the_same_in_all_formats() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let opaque = |[red, green, blue]: [u8; 3]| [red, green, blue, 255];
    let eight = bands(3, |shades, band| shades[band]);
    for (name, builder) in [
        ("strips.tif", rgb()),
        ("tiles.tif", rgb().tile_size(16, 16).compression(Compression::Deflate)),
        ("planar.tif", rgb().planar_configuration(PlanarConfiguration::Planar).compression(Compression::Lzw)),
    ] {
        builder.write_3d(file(name), eight.view()).unwrap();
        assert_eq!(worst(&file(name), opaque), 0, "{name}");
    }
    let image = ColorImage::open(&file("tiles.tif")).unwrap();
    assert!(image.is_located && image.georeference().crs_from_grid[0] == 500_001.0);
    let sixteen = bands(3, |shades, band| u16::from(shades[band]) * 257);
    rgb().write_3d(file("sixteen.tif"), sixteen.view()).unwrap();
    assert_eq!(worst(&file("sixteen.tif"), opaque), 0);

    let alpha = bands(4, |shades, band| if band < 3 { shades[band] } else { shades[0] });
    let rgba = placed().bands(4).photometric(PhotometricInterpretation::Rgb);
    let rgba = rgba.extra_samples(vec![ExtraSample::UnassociatedAlpha]);
    rgba.write_3d(file("alpha.tif"), alpha.view()).unwrap();
    let translucent = |[red, green, blue]: [u8; 3]| if red == 0 { [0; 4] } else { [red, green, blue, red] };
    assert_eq!(worst(&file("alpha.tif"), translucent), 0);

    // A pixel is no-data if all of its channels are.
    rgb().nodata("30").write_3d(file("no_data.tif"), bands(3, |[red, ..], _| red).view()).unwrap();
    assert_eq!(worst(&file("no_data.tif"), |[red, ..]| if red == 30 { [0; 4] } else { [red, red, red, 255] }), 0);

    let grey = Array2::from_shape_fn((SIZE[1], SIZE[0]), |(y, x)| shades(x, y)[1]);
    placed().write_2d(file("grey.tif"), grey.view()).unwrap();
    assert_eq!(worst(&file("grey.tif"), |[_, green, _]| [green, green, green, 255]), 0);
    let jpeg = placed().tile_size(16, 16).compression(Compression::Jpeg);
    jpeg.write_2d(file("jpeg.tif"), grey.view()).unwrap();
    assert!(worst(&file("jpeg.tif"), |[_, green, _]| [green, green, green, 255]) < 40);
    placed().photometric(PhotometricInterpretation::MinIsWhite).write_2d(file("white.tif"), grey.view()).unwrap();
    assert_eq!(worst(&file("white.tif"), |[_, green, _]| [255 - green, 255 - green, 255 - green, 255]), 0);
    // Values of another range are stretched: 0 to 235 here.
    placed().write_2d(file("float.tif"), grey.mapv(|shade| f32::from(shade) / 100.0).view()).unwrap();
    let stretched = |[_, green, _]: [u8; 3]| {
        let shade = (f32::from(green) / 235.0 * 255.0).round() as u8;
        [shade, shade, shade, 255]
    };
    assert!(worst(&file("float.tif"), stretched) <= 1);
    let map = |step: usize| (0..256).map(|index| ((index * step) % 256 * 257) as u16).collect::<Vec<u16>>();
    let map = ColorMap::new(map(1), map(3), map(7)).unwrap();
    let palette = placed().photometric(PhotometricInterpretation::Palette).color_map(map);
    palette.write_2d(file("palette.tif"), grey.view()).unwrap();
    let of_palette = |[_, green, _]: [u8; 3]| [green, green.wrapping_mul(3), green.wrapping_mul(7), 255];
    assert_eq!(worst(&file("palette.tif"), of_palette), 0);

    let flat: Vec<u8> = eight.iter().copied().collect();
    let mut encoder = png::Encoder::new(std::fs::File::create(file("a.png")).unwrap(), SIZE[0] as u32, SIZE[1] as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&flat).unwrap();
    assert_eq!(worst(&file("a.png"), opaque), 0);
    let encoder = jpeg_encoder::Encoder::new_file(file("a.jpg"), 100).unwrap();
    encoder.encode(&flat, SIZE[0] as u16, SIZE[1] as u16, jpeg_encoder::ColorType::Rgb).unwrap();
    assert!(worst(&file("a.jpg"), opaque) < 40);
    // A world file gives the position of a picture.
    assert!(!ColorImage::open(&file("a.jpg")).unwrap().is_located);
    std::fs::write(file("a.jgw"), "2\n0\n0\n-2\n500001\n5199999\n").unwrap();
    let image = ColorImage::open(&file("a.jpg")).unwrap();
    assert!(image.is_located && image.georeference().crs_from_grid[3] == 5_199_999.0);
    // Planted: another image is noticed.
    assert!(worst(&file("a.png"), |[red, green, blue]| [green, red, blue, 255]) > 100);
}

#[test]
fn overviews_are_levels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cog.tif");
    let side = 700;
    let builder =
        GeoTiffBuilder::new(side, side).tile_size(64, 64).bands(3).photometric(PhotometricInterpretation::Rgb);
    let white = Array3::from_elem((side as usize, side as usize, 3), 200_u8);
    CogBuilder::new(builder.clone()).overview_levels(vec![2, 4]).write_3d(&path, white.view()).unwrap();
    let image = ColorImage::open(&path).unwrap();
    let sizes: Vec<_> = (0..image.levels()).map(|level| image.level_size(level)).collect();
    assert_eq!(sizes, [[700, 700], [350, 350], [175, 175]]);
    let pixel = |image: &ColorImage, level| image.read(level, Window { x: 9, y: 9, width: 1, height: 1 }).unwrap()[0];
    assert_eq!([0, 1, 2].map(|level| pixel(&image, level)), [[200, 200, 200, 255]; 3]);
    // Without overviews, they are computed.
    let path = folder.path().join("plain.tif");
    builder.write_3d(&path, white.view()).unwrap();
    let image = ColorImage::open(&path).unwrap();
    assert_eq!((image.levels(), image.level_size(2)), (3, [175, 175]));
    assert_eq!([0, 1, 2].map(|level| pixel(&image, level)), [[200, 200, 200, 255]; 3]);
    // A window outside of a level is an error.
    assert!(image.read(2, Window { x: 170, y: 0, width: 6, height: 1 }).is_err());
}
