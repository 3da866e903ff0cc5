//! A scene opens with the rasters of its forest, or an error says what is wrong with them.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use common::draw::{NOON, draw, still};
use geotiff_writer::{ColorMap, GeoTiffBuilder, ModelType, PhotometricInterpretation};
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::gpu::readback::read;
use hachure::scene::reach::Reach;
use hachure::source::{Holds, open_values};
use hachure::style::Style;
use hachure::surface::{SURFACE_ID, id};
use hachure::tiles::terrain::TerrainOptions;
use hachure::world::{OpenWorld, inputs_of, scene_of};
use ndarray::Array2;

const SIDE: usize = 32;

/// Returns a builder of a file with 32 × 32 samples, 30 m apart.
fn placed() -> GeoTiffBuilder {
    let builder = GeoTiffBuilder::new(SIDE as u32, SIDE as u32).model_type(ModelType::Projected).epsg(32610);
    builder.pixel_scale(30.0, 30.0).origin(600_000.0, 5_200_000.0)
}

#[test]
fn a_scene_opens_with_its_rasters_or_says_what_is_wrong() {
    let Some(gpu) = common::gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let heights = Array2::from_shape_fn((SIDE, SIDE), |(row, column)| (100 + row + column) as f32);
    placed().write_2d(file("land.tif"), heights.view()).unwrap();
    let west = Array2::from_shape_fn((SIDE, SIDE), |(_, column)| if column < 16 { 41_u8 } else { 11 });
    placed().write_2d(file("cover.tif"), west.view()).unwrap();
    let scene = file("scene.toml");
    let open = |keys: &str| {
        std::fs::write(&scene, format!("[world]\ndem = \"land.tif\"\n[forest]\n{keys}")).unwrap();
        OpenWorld::open(&gpu, scene.to_str(), TerrainOptions::default()).map_err(|error| error.to_string())
    };
    let land = |name: &str| format!("land_cover = \"{name}\"\n[[forest.classes]]\nclass = 41\ndensity = 0.6\n");

    let world = open(&land("cover.tif")).unwrap();
    let cover = world.surfaces.forest_cover().unwrap();
    assert_eq!(cover.size, [SIDE as u32; 2]);
    let across = [-400.0, -20.0, 20.0, 400.0].map(|x| cover.at([x, 0.0]));
    assert_eq!(across, [[153, 1, 0, 255], [153, 1, 0, 255], [0, 0, 0, 255], [0, 0, 0, 255]].map(Some));
    // A raster is an input, which no output may overwrite.
    let inputs = inputs_of(scene.to_str(), &scene_of(scene.to_str(), Reach::SceneFolder).unwrap());
    assert!(inputs.check(&file("cover.tif")).is_err() && inputs.check(&file("other.tif")).is_ok());
    assert!(open("seed = 3\n").unwrap().surfaces.forest_cover().is_none());

    let whole = std::fs::read(file("cover.tif")).unwrap();
    std::fs::write(file("broken.tif"), &whole[..whole.len() / 2]).unwrap();
    for (keys, cause) in [
        (land("broken.tif"), "broken.tif: is damaged"),
        (land("none.tif"), "none.tif: cannot be opened"),
        (land("../cover.tif"), "forest.land_cover: "),
        ("mask = \"scene.toml\"\n".to_owned(), "scene.toml: "),
    ] {
        let error = open(&keys).map(|_| ()).unwrap_err();
        assert!(error.contains("scene.toml") && error.contains(cause) && !error.contains('\n'), "{error}");
    }
}

/// Draws trees by rules, by rasters and in wind, with strokes, shadows and colours, on a device with the limits that
/// every WebGPU device has.
#[test]
fn forests_draw_within_the_default_limits() {
    let gpu = Gpu::open_within(&AdapterWish::Best, wgpu::Limits::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(gpu.device.limits().max_storage_buffers_per_shader_stage, 8);
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let heights = Array2::from_shape_fn((SIDE, SIDE), |(row, column)| (100 + row + column) as f32);
    placed().write_2d(file("land.tif"), heights.view()).unwrap();
    let west = Array2::from_shape_fn((SIDE, SIDE), |(_, column)| if column < 16 { 41_u8 } else { 11 });
    placed().write_2d(file("cover.tif"), west.view()).unwrap();
    // In the fast tier one species and one style: strokes, marks and shadows of trees are in a test of colours.
    let (species, styles) = if common::full() {
        ("", &["crosshatch", "wash"][..])
    } else {
        ("[[forest.species]]\nform = \"conifer\"\n", &["plain"][..])
    };
    let drawn = |keys: &str| {
        let text = format!("[world]\ndem = \"land.tif\"\n[wind]\nspeed_m_s = 5\n[forest]\n{keys}");
        std::fs::write(file("scene.toml"), text).unwrap();
        let scene = file("scene.toml");
        let mut world = OpenWorld::open(&gpu, scene.to_str(), TerrainOptions::default()).unwrap();
        let pose = common::pose_of(&"-200,-300,190,20,-12,60".parse().unwrap());
        let mut renderer = Renderer::new(&gpu).unwrap();
        for style in styles {
            let style = Style::load(style).unwrap();
            for _ in 0..2 {
                draw(&gpu, &mut world.surfaces, &mut renderer, &still(pose, [96, 54]), &style, &NOON);
            }
        }
        let target = renderer.target(&SURFACE_ID).unwrap();
        let ids = read(&gpu, target, [0, 0], target.size_px()).unwrap();
        ids.chunks_exact(4).filter(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]]) >= id::FIRST_TREE).count()
    };
    let by_rules = drawn(&format!("trees_per_ha = 300\n{species}"));
    let by_rasters = drawn(
        "trees_per_ha = 300\nland_cover = \"cover.tif\"\n[[forest.classes]]\nclass = 41\ndensity = 0.6\n\
         [[forest.species]]\nform = \"conifer\"\n",
    );
    let nowhere = drawn(&format!(
        "trees_per_ha = 300\nland_cover = \"cover.tif\"\n[[forest.classes]]\nclass = 99\ndensity = 1\n{species}"
    ));
    assert!(
        by_rules > by_rasters && by_rasters > 100 && nowhere == 0,
        "pixels of trees by rules {by_rules}, by rasters {by_rasters}, where no class grows {nowhere}"
    );
}

#[test]
fn classes_may_have_a_palette() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cover.tif");
    let classes = Array2::from_shape_fn((SIDE, SIDE), |(row, column)| (row + column) as u8);
    let colours = ColorMap::new(vec![0; 256], vec![9; 256], vec![0; 256]).unwrap();
    let builder = placed().photometric(PhotometricInterpretation::Palette).color_map(colours);
    builder.write_2d(&path, classes.view()).unwrap();
    let values = open_values(&path, Holds::Classes).unwrap();
    let window = hachure::source::Window { x: 3, y: 2, width: 2, height: 1 };
    assert_eq!((values.reader.read(window).unwrap(), values.is_located), (vec![5.0, 6.0], true));
    for (holds, words) in [(Holds::Heights, "not heights"), (Holds::Shades, "not shades of grey")] {
        let error = open_values(&path, holds).map(|_| ()).unwrap_err().to_string();
        assert!(error.ends_with(&format!("cover.tif: holds a palette picture, {words}")), "{error}");
    }
}
