//! Inputs of several files: scenes with forests, masks and materials, and the imprints of pictures.

use std::path::Path;

use geotiff_writer::{Compression, GeoTiffBuilder, PhotometricInterpretation};
use hachure::file::imprint::Notes;
use hachure::file::png::{PngPixels, PngWriter, write_rgba8};
use hachure::internals::{Imprint, check_like, obj, read_scene_files};
use hachure::scene::reach::Reach;
use hachure::scene::{ImageFile, Scene};
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::{GeoKeys, Silent};
use hachure::style::preset_text;
use ndarray::{Array2, Array3};

use super::kinds::{one, text};
use super::seeds::Seed;

/// Samples of the land along each side.
const SIDE: u32 = 513;

/// Returns the place of land in UTM, 30 m from sample to sample.
pub(crate) fn place() -> Georeference {
    let crs = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32632".to_owned() };
    let crs_from_grid = [500_000.0, 30.0, 0.0, 5_215_000.0, 0.0, -30.0];
    Georeference { crs_from_grid, crs, geokeys: GeoKeys::default() }
}

/// Reads a scene with all files that it names, except its DEM.
pub(crate) fn read_scene(path: &Path) -> anyhow::Result<()> {
    let scene = Scene::read(path)?;
    scene.check_reach(path, Reach::SceneFolder)?;
    Ok(read_scene_files(&scene, &place(), [SIDE; 2])?)
}

/// Reads an image as `--drape` does, for land in UTM.
pub(crate) fn read_image(path: &Path) -> anyhow::Result<()> {
    let mut scene = Scene::default();
    scene.images.push(ImageFile { path: path.to_owned() });
    Ok(read_scene_files(&scene, &place(), [SIDE; 2])?)
}

/// Reads a model with its materials.
pub(crate) fn read_materials(path: &Path) -> anyhow::Result<()> {
    Ok(obj::read_with(path, &Silent, &mut |_| ()).map(drop)?)
}

pub(crate) fn read_imprint(path: &Path) -> anyhow::Result<()> {
    check_like(path)
}

const TREE: &str = "mtllib tree.mtl\no tree\nv -1 0 0\nv 1 0 0\nv 0 0 6\nv 0 -1 0\nv 0 1 0\nusemtl bark\nf 1 2 3\nusemtl \
                    leaf\nf 4 5 3\n";
const MATERIALS: &str = "# two\nnewmtl bark\nKa 0 0 0\nKd 0.4 0.3 0.2\nd 1.0\nillum 2\n\nnewmtl leaf\nKd 0.2 0.5 0.1\n\
                         map_Kd -s 1 1 1 leaf.png\nTr 0.0\n";

/// Writes a raster of whole numbers over the land.
fn raster(path: &Path, value: impl Fn(usize, usize) -> u8) {
    let samples = Array2::from_shape_fn((40, 40), |(row, column)| value(column, row));
    let builder = GeoTiffBuilder::new(40, 40).pixel_scale(400.0, 400.0).origin(5.0e5, 5_215_000.0).epsg(32_632);
    builder.compression(Compression::None).write_2d(path, samples.view()).unwrap();
}

fn leaf(path: &Path) {
    let rgba: Vec<u8> = (0..16 * 16 * 4).map(|index| (index * 7 % 251) as u8).collect();
    write_rgba8(path, 16, 16, &rgba).unwrap();
}

/// Returns scenes with forests, rasters of land cover, models with materials, and water.
pub(crate) fn scenes(home: &Path) -> Vec<Seed> {
    let forest = "[world]\ndem = \"land.tif\"\n[sun]\nazimuth_deg = 315\nelevation_deg = 12\n[wind]\nspeed_m_s = 8\n\
                  from_deg = 270\n[forest]\ntrees_per_ha = 300\ntree_line_m = 1900\nraggedness_m = 80\nsteepest_deg = 42\n\
                  seed = 3\nmask = \"mask.tif\"\n[[forest.species]]\nform = \"conifer\"\nheight_m = 22\nshare = 2\n\
                  low_m = 0\nhigh_m = 1900\naspect_deg = 45\nby_aspect = 0.5\n[[forest.species]]\nfile = \"tree.obj\"\nup = \"z\"\nheight_m = 14.5\n\
                  color = \"#506030\"\n";
    let cover = "[world]\ndem = \"land.tif\"\n[forest]\ntrees_per_ha = 500\nland_cover = \"classes.tif\"\n\
                 canopy_height = \"mask.tif\"\n[[forest.species]]\nform = \"birch\"\n[[forest.classes]]\nclass = 3\n\
                 density = 0.5\nspecies = [1]\n[[forest.classes]]\nclass = 5\n[water]\nmask = \"mask.tif\"\n";
    let props = "[world]\ndem = \"land.tif\"\n[water]\npolygons = \"lake.geojson\"\nonly_given = true\n[[meshes]]\n\
                 file = \"tree.obj\"\nup = \"z\"\ninstances = \"huts.csv\"\nscale = 2.5\n[[meshes]]\nfile = \"./tree.obj\"\n\
                 at = [20, -30, \"+1\"]\nyaw_deg = 30\n";
    let lake = "{\"type\":\"FeatureCollection\",\"crs\":{\"properties\":{\"name\":\"EPSG:32632\"}},\"features\":[{\"type\":\
                \"Feature\",\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[[504000,5204000],[509000,5204000],\
                [507000,5210000.5],[504000,5204000]]]}}]}";
    let write = |path: &Path, scene: &str| {
        let file = |name: &str| path.with_file_name(name);
        std::fs::write(path, scene).unwrap();
        let files =
            [("tree.obj", TREE), ("tree.mtl", MATERIALS), ("lake.geojson", lake), ("huts.csv", "x,y\n1,2\n30,-4\n")];
        for (name, text) in files.into_iter().filter(|(name, _)| scene.contains(name) || name.contains(".mtl")) {
            std::fs::write(file(name), text).unwrap();
        }
        if scene.contains("tree.obj") {
            leaf(&file("leaf.png"));
        }
        for (name, step) in [("mask.tif", 7), ("classes.tif", 3)] {
            if scene.contains(name) {
                raster(&file(name), |column, row| if (column / step + row / step) % 2 == 0 { 5 } else { 3 });
            }
        }
    };
    let of = |name: &str, scene: &str| one(home, name, |path| write(path, scene));
    [of("forest.toml", forest), of("cover.toml", cover), of("props.toml", props)].into_iter().flatten().collect()
}

/// Returns a model with a library and a texture.
pub(crate) fn materials(home: &Path) -> Vec<Seed> {
    one(home, "tree.obj", |path| {
        std::fs::write(path, TREE).unwrap();
        std::fs::write(path.with_file_name("tree.mtl"), MATERIALS).unwrap();
        leaf(&path.with_file_name("leaf.png"));
    })
}

/// Returns pictures with imprints: three of them as SVG, whose text can be damaged without a checksum that tells.
pub(crate) fn imprints(home: &Path) -> Vec<Seed> {
    let imprint = |style: &str, size: &str, more: &str| {
        let text = format!(
            "version = 4\nhachure = \"0.1.0\"\ncamera = \"0,-2000,+300,0,-10,50\"\nsun = \"315,40\"\nsize = {size}\nstyle = \
             '''\n{}'''\n[more]\n{more}",
            preset_text(style).unwrap()
        );
        // A seed that is refused would test nothing.
        Imprint::parse("seed", &text).unwrap();
        text
    };
    let picture = imprint(
        "plain",
        "[640, 360]",
        "time_s = 2.5\nsamples = 4\nlod_error = 0.5\nnodata = -9999.0\nencoding = \"mapbox\"\nvoids = \"holes\"\n\
         tile_memory = 64\neyes = \"anaglyph\"\nipd = \"0.065\"\nconvergence = 30.0\nfocus = \"1,2,300,0.5\"\n",
    );
    let drawing = imprint(
        "strokes",
        "[640, 480]",
        "title = \"A title\"\npaper = \"a5\"\nmargin = 5.0\ntolerance_px = 0.25\npens = 2\nmap = \"0,0,3000\"\n",
    );
    let film = imprint("ink", "[64, 36]", "path = \"tour\"\nfps = 25.0\nantialias = \"temporal\"\n");
    let svg = |name: &str, imprint: &str| {
        let imprint = imprint.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        text(
            home,
            name,
            &format!("<svg xmlns=\"http://www.w3.org/2000/svg\"><metadata id=\"hachure\">{imprint}</metadata></svg>\n"),
        )
    };
    let notes = Notes { imprint: Some(&picture), ..Notes::default() };
    let png = one(home, "picture.png", |path| {
        let mut writer = PngWriter::create_noted(path, 1, 1, PngPixels::Rgba8, &notes).unwrap();
        writer.write_rows(&[0; 4]).unwrap();
        writer.finish().unwrap();
    });
    let svgs = [svg("picture.svg", &picture), svg("drawing.svg", &drawing), svg("film.svg", &film)];
    svgs.into_iter().flatten().chain(png).collect()
}

/// Returns masks of water.
pub(crate) fn masks(home: &Path) -> Vec<Seed> {
    one(home, "mask.tif", |path| raster(path, |column, row| u8::from((column / 7 + row / 9) % 3 == 0)))
}

/// Returns images: GeoTIFFs with colours, with and without compression, a PNG and a JPEG.
pub(crate) fn images(home: &Path) -> Vec<Seed> {
    let colours = |path: &Path, compression: Compression| {
        let samples = Array3::from_shape_fn((300, 300, 3), |(y, x, band)| (x * (band + 1) + y) as u8);
        let builder = GeoTiffBuilder::new(300, 300).pixel_scale(40.0, 40.0).origin(5.0e5, 5_215_000.0).epsg(32_632);
        let builder = builder.tile_size(64, 64).bands(3).photometric(PhotometricInterpretation::Rgb);
        builder.compression(compression).write_3d(path, samples.view()).unwrap();
    };
    let grey = |path: &Path| {
        let samples = Array2::from_shape_fn((300, 300), |(y, x)| (x + 2 * y) as u8);
        let builder = GeoTiffBuilder::new(300, 300).pixel_scale(40.0, 40.0).origin(5.0e5, 5_215_000.0).epsg(32_632);
        builder.tile_size(64, 64).compression(Compression::Jpeg).write_2d(path, samples.view()).unwrap();
    };
    let jpeg = |path: &Path| {
        let rgb: Vec<u8> = (0..64 * 64 * 3).map(|index| (index * 7 % 251) as u8).collect();
        let encoder = jpeg_encoder::Encoder::new_file(path, 90).unwrap();
        encoder.encode(&rgb, 64, 64, jpeg_encoder::ColorType::Rgb).unwrap();
    };
    let whole = one(home, "plain.tif", |path| colours(path, Compression::None));
    whole
        .into_iter()
        .chain(one(home, "deflate.tif", |path| colours(path, Compression::Deflate)))
        .chain(one(home, "jpeg.tif", grey))
        .chain(one(home, "leaf.png", leaf))
        .chain(one(home, "photo.jpg", jpeg))
        .collect()
}
