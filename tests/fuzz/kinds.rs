//! The kinds of input: valid files of each, and how the program reads them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::ensure;
use hachure::file::exr::{Channel, Samples, read_exr, write_exr};
use hachure::file::png::{read_rgba8, write_rgba8};
use hachure::internals::GivenWater;
use hachure::internals::{obj, read_mesh_list, statistics};
use hachure::pyramid::store::open_local_cog;
use hachure::pyramid::{Pyramid, TileAddress, TileStore};
use hachure::scene::path::CameraPath;
use hachure::scene::{Scene, WaterFiles};
use hachure::source::{self, Silent, Window};
use hachure::style::{self, Style};
use netcdf_writer::NcWriteFormat;

use super::dem::Dem;
use super::dem_seeds::{cogs, colours, geotiffs, pyramids, real_geotiffs, small, tile_folders, with_side_file};
use super::seeds::Seed;
use super::{scenes, write};

/// A kind of input file.
pub(crate) struct Kind {
    pub name: &'static str,
    pub open: fn(&Path) -> anyhow::Result<()>,
    /// Writes valid files below a folder.
    pub seeds: fn(&Path) -> Vec<Seed>,
    /// The arguments of the program for such a file; the file comes last.
    pub arguments: Option<&'static [&'static str]>,
}

const INFO: Option<&[&str]> = Some(&["info"]);

const fn heights(name: &'static str, seeds: fn(&Path) -> Vec<Seed>) -> Kind {
    Kind { name, open: read_heights, seeds, arguments: INFO }
}

pub(crate) const KINDS: &[Kind] = &[
    heights("geotiff", geotiffs),
    heights("real-geotiff", real_geotiffs),
    Kind { name: "cog", open: fly_over, seeds: cogs, arguments: INFO },
    heights("hgt", |home| one(home, "N46E008.hgt", |path| write::hgt(path, &Dem::new(1201, 1201, 1)))),
    heights("hgt-zip", |home| one(home, "h.zip", |path| write::hgt_zip(path, "N46E008.hgt", &Dem::new(1201, 1201, 1)))),
    heights("dted", |home| {
        let whole = one(home, "whole.dt0", |path| _ = write::dted(path, &small(), 50));
        whole.into_iter().chain(one(home, "short.dt0", |path| _ = write::dted(path, &small(), 47))).collect()
    }),
    heights("ehdr", |home| {
        let bil = one(home, "d.bil", |path| _ = write::ehdr(path, &small(), "M"));
        bil.into_iter().chain(one(home, "e.flt", |path| _ = write::grid_float(path, &small()))).collect()
    }),
    heights("envi", |home| {
        let of = |name: &str, interleave: &'static str| {
            one(home, name, move |path| _ = write::envi(path, &small(), interleave))
        };
        [of("a.img", "bip"), of("b.img", "bil"), of("c.img", "bsq")].into_iter().flatten().collect()
    }),
    heights("ascii", |home| {
        let esri = |path: &Path| {
            write::ascii(path, &small(), false);
            std::fs::write(path.with_extension("prj"), write::UTM_PRJ).unwrap();
        };
        one(home, "a.asc", esri)
            .into_iter()
            .chain(one(home, "b.txt", |path| _ = write::grass(path, &small())))
            .collect()
    }),
    heights("usgs-dem", |home| {
        let plain = one(home, "a.dem", |path| _ = write::usgs_dem(path, &small(), false));
        plain.into_iter().chain(one(home, "b.dem", |path| _ = write::usgs_dem(path, &small(), true))).collect()
    }),
    heights("xyz", |home| {
        one(home, "p.xyz", |path| {
            write::xyz(path, &small());
            std::fs::write(path.with_extension("prj"), write::UTM_PRJ).unwrap();
        })
    }),
    heights("png16", |home| {
        let alone = one(home, "a.png", |path| write::png16(path, &small()));
        alone.into_iter().chain(one(home, "b.png", |path| with_side_file(path, write::png16))).collect()
    }),
    heights("raw", |home| one(home, "r.r16", |path| with_side_file(path, |path, dem| write::raw(path, dem, false)))),
    heights("terrain-rgb", |home| {
        let of = |name: &str, is_mapbox| {
            let encoding = if is_mapbox { "mapbox" } else { "terrarium" };
            one(home, name, move |path| {
                write::terrain_rgb(path, &small(), is_mapbox);
                let side = format!("encoding = \"{encoding}\"\nspacing_m = 10.0\n");
                std::fs::write(path.with_file_name(format!("{}.toml", file_name(path))), side).unwrap();
            })
        };
        of("m.png", true).into_iter().chain(of("t.png", false)).collect()
    }),
    heights("tile-folder", tile_folders),
    heights("gsi", |home| one(home, "g.png", |path| colours(path, write::Colours::Png))),
    heights("webp", |home| one(home, "w.webp", |path| colours(path, write::Colours::WebP))),
    heights("pmtiles", |home| {
        one(home, "a.pmtiles", |path| {
            let tiles = path.with_file_name("12");
            std::fs::create_dir_all(tiles.join("2138")).unwrap();
            colours(&tiles.join("2138/1447.webp"), write::Colours::WebP);
            std::fs::remove_file(tiles.join("2138/1447.webp.toml")).unwrap();
            write::pmtiles(path, path.parent().unwrap(), 12, 4, "{\"encoding\": \"gsi\"}");
            std::fs::remove_dir_all(tiles).unwrap();
        })
    }),
    heights("netcdf", |home| {
        let classic = one(home, "c.nc", |path| write::netcdf(path, &small(), NcWriteFormat::Classic, false));
        let of_hdf5 = |path: &Path| write::netcdf(path, &small(), NcWriteFormat::Nc4, true);
        classic.into_iter().chain(one(home, "h.nc", of_hdf5)).collect()
    }),
    heights("archive", |home| {
        let of = |name: &str, pack: fn(&Path, &[u8])| {
            one(home, name, move |path| {
                let inside = path.with_file_name("a.asc");
                write::ascii(&inside, &small(), false);
                pack(path, &std::fs::read(&inside).unwrap());
                std::fs::remove_file(inside).unwrap();
            })
        };
        let zipped = of("z.zip", |path, bytes| write::zip(path, &[("a.asc", bytes)]));
        let packed = of("t.tgz", |path, bytes| write::gzip(path, &write::tar(&[("a.asc", bytes)])));
        zipped.into_iter().chain(packed).chain(of("a.asc.gz", write::gzip)).collect()
    }),
    heights("exr-heights", |home| {
        one(home, "e.exr", |path| {
            let channel = Channel { name: "Y".to_owned(), samples: Samples::F32(small().expected()) };
            write_exr(path, 50, 50, &[channel], &[]).unwrap();
        })
    }),
    Kind { name: "pyramid", open: read_pyramid, seeds: pyramids, arguments: INFO },
    Kind { name: "obj", open: |path| Ok(obj::read(path).map(drop)?), seeds: objs, arguments: None },
    Kind { name: "scene", open: |path| Ok(Scene::read(path).map(drop)?), seeds: plain_scenes, arguments: INFO },
    Kind { name: "instances", open: |path| Ok(read_mesh_list(path).map(drop)?), seeds: lists, arguments: None },
    Kind { name: "style", open: read_style, seeds: styles, arguments: Some(&["styles", "check"]) },
    Kind { name: "marks", open: read_marks, seeds: |home| recipes(home, "marks"), arguments: None },
    Kind { name: "strokes", open: read_strokes, seeds: |home| recipes(home, "strokes"), arguments: None },
    Kind { name: "water", open: read_water, seeds: waters, arguments: None },
    Kind { name: "water-mask", open: read_water, seeds: scenes::masks, arguments: None },
    Kind { name: "image", open: scenes::read_image, seeds: scenes::images, arguments: None },
    Kind { name: "forest-scene", open: scenes::read_scene, seeds: scenes::scenes, arguments: None },
    Kind { name: "materials", open: scenes::read_materials, seeds: scenes::materials, arguments: None },
    Kind { name: "imprint", open: scenes::read_imprint, seeds: scenes::imprints, arguments: None },
    Kind { name: "camera-path", open: read_path, seeds: paths, arguments: INFO },
    Kind { name: "png", open: |path| Ok(read_rgba8(path).map(drop)?), seeds: pictures, arguments: None },
    Kind { name: "exr", open: |path| Ok(read_exr(path).map(drop)?), seeds: exrs, arguments: None },
];

pub(crate) fn file_name(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).unwrap()
}

/// Creates a seed in its own folder, with all files that `write` writes there.
pub(crate) fn one(home: &Path, name: &str, write: impl FnOnce(&Path)) -> Vec<Seed> {
    let folder = home.join(name.replace('.', "_"));
    std::fs::create_dir_all(&folder).unwrap();
    write(&folder.join(name));
    vec![Seed::of(&folder, name)]
}

// Readers.

/// Reads heights as `info` does, and some windows as a bake does.
pub(crate) fn read_heights(path: &Path) -> anyhow::Result<()> {
    let reader = source::open_reader(path)?;
    let found = statistics(&*reader, path, &Silent)?;
    ensure!(found.min_m <= found.max_m && found.min_m.abs().max(found.max_m.abs()) <= 1e6, "absurd: {found:?}");
    let [width, height] = reader.size();
    let side = |size: u32| size.min(9);
    for [x, y] in [[width - side(width), height - side(height)], [0, 0], [width / 2, 0]] {
        let window = Window { x, y, width: side(width - x), height: side(height - y) };
        let heights_m = reader.read(window)?;
        ensure!(heights_m.len() == window.samples(), "{} heights of {window:?}", heights_m.len());
        let inside = heights_m.iter().all(|height| height.is_nan() || (found.min_m..=found.max_m).contains(height));
        ensure!(inside, "a window has heights outside the range of the whole");
    }
    ensure!(
        reader.georeference().crs_from_grid.iter().all(|number| number.is_finite()),
        "the georeference is not finite"
    );
    Ok(())
}

/// Reads a file as heights, and as a COG that is drawn without a bake.
fn fly_over(path: &Path) -> anyhow::Result<()> {
    if let Some(store) = open_local_cog(path)? {
        let levels = store.levels().len() as u32;
        for level in (0..levels).rev().take(4) {
            let size = store.levels()[level as usize];
            for [x, y] in [[0, 0], [size.tiles_x() - 1, size.tiles_y() - 1]] {
                store.clone().load(TileAddress { level, x, y })?;
            }
        }
    }
    read_heights(path)
}

fn read_pyramid(path: &Path) -> anyhow::Result<()> {
    let pyramid = Arc::new(Pyramid::open(path)?);
    for (level, size) in (0..).zip(pyramid.levels()) {
        for y in 0..size.tiles_y().min(3) {
            for x in 0..size.tiles_x().min(3) {
                pyramid.clone().load(TileAddress { level, x, y })?;
            }
        }
    }
    Ok(())
}

fn read_style(path: &Path) -> anyhow::Result<()> {
    Ok(Style::load(path.to_str().unwrap()).map(drop)?)
}

fn read_marks(path: &Path) -> anyhow::Result<()> {
    Ok(style::marks::Recipe::load(file_name(path), path.parent().unwrap()).map(drop)?)
}

fn read_strokes(path: &Path) -> anyhow::Result<()> {
    Ok(style::texture::Recipe::load(file_name(path), path.parent().unwrap()).map(drop)?)
}

fn read_path(path: &Path) -> anyhow::Result<()> {
    let found = CameraPath::read_on_ground(path, |_, _| 0.0)?;
    ensure!(found.frame_count(30.0) > 0, "has no frame");
    ensure!(found.spread(100).all(|camera| camera.position_m.is_finite()), "has a position that is not finite");
    Ok(())
}

/// Reads water as `--water` does, for land in UTM.
fn read_water(path: &Path) -> anyhow::Result<()> {
    Ok(GivenWater::load(&WaterFiles::default().with(path), &scenes::place(), [513, 513]).map(drop)?)
}

// Writers.

pub(crate) fn text(home: &Path, name: &str, text: &str) -> Vec<Seed> {
    one(home, name, |path| std::fs::write(path, text).unwrap())
}

fn objs(home: &Path) -> Vec<Seed> {
    let cube = "# a cube\nmtllib none.mtl\no cube\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                vn 0 0 1\nvt 0.5 0.5\nusemtl grey\ns off\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2/1/1 3/1/1 7/1/1 6/1/1\n\
                f 3//1 4//1 8//1 7//1\nf -8 -4 -1 -5\n";
    let mut field = String::from("g field\n");
    for row in 0..12 {
        for column in 0..12 {
            field += &format!("v {column}.25 {row}.5 {}e-1\n", row * column);
        }
    }
    for (row, column) in (0..11).flat_map(|row| (0..11).map(move |column| (row, column))) {
        let first = row * 12 + column + 1;
        field += &format!("f {first} {} {} {}\n", first + 1, first + 13, first + 12);
    }
    text(home, "cube.obj", cube).into_iter().chain(text(home, "field.obj", &field)).collect()
}

fn plain_scenes(home: &Path) -> Vec<Seed> {
    let one_file = "vertical_exaggeration = 1.5\n[world]\ndem = \"mountain.tif\"\n[sun]\nazimuth_deg = 315\n\
                    elevation_deg = 35.5\n[haze]\ndistance_m = 20000\ncolor = \"#c8d0d8\"\n[earth]\ncurvature = true\n\
                    refraction = 0.13\n[camera]\nstart = \"0,-1500,+200,10,-5,60\"\n";
    let several = "[world]\ndem = [\"a.tif\", \"b.tif\"]\n[earth]\ncurvature = false\n";
    let made = "[world]\nprocedural = { seed = 7 }\n[camera]\nstart = \"0,0,2000,0,-10,50\"\n";
    let land = "[world]\ncontinent = { seed = 3 }\n";
    let props = "[world]\nprocedural = { seed = 1 }\n[[meshes]]\nfile = \"a.obj\"\ninstances = \"a.csv\"\n[[meshes]]\n\
                 file = \"b.obj\"\nscatter = { per_ha = 2.5, within = [-900, -900, 900, 900], heights_m = [0, 2000], \
                 steepest_deg = 30, seed = 3, scale = [0.5, 2], turn_deg = [0, 90], up_m = -0.5 }\n";
    let all = [
        ("one.toml", one_file),
        ("several.toml", several),
        ("made.toml", made),
        ("land.toml", land),
        ("props.toml", props),
    ];
    all.into_iter().flat_map(|(name, scene)| text(home, name, scene)).collect()
}

fn styles(home: &Path) -> Vec<Seed> {
    let of = |name: &&str| text(home, &format!("{name}.toml"), style::preset_text(name).unwrap());
    style::names().iter().flat_map(of).collect()
}

fn recipes(home: &Path, what: &str) -> Vec<Seed> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("textures").join(what);
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    files.sort();
    files.iter().flat_map(|path| text(home, file_name(path), &std::fs::read_to_string(path).unwrap())).collect()
}

fn paths(home: &Path) -> Vec<Seed> {
    let head = "t,x,y,z,yaw,pitch,fov\n";
    let flight = "# a flight\n0,0,-1500,+200,10,-5,60\n2.5,100,-1200,+180.5,20,-5,60\n4,300,-900,+150,350,-10,50\n\
                  4,0,0,+20,0,0,50\n9.75,1e3,900,+1e2,-30,5,45\n";
    let level = "0,0,0,2000,0,-10,50\n1,10,0,2000,5,-10,50\n2,20,5,1990,9,-12,50\n";
    let of = |name: &str, rows: &str| text(home, name, &format!("{head}{rows}"));
    of("flight.csv", flight).into_iter().chain(of("level.csv", level)).collect()
}

fn waters(home: &Path) -> Vec<Seed> {
    let circle = |middle: [f64; 2], radius: f64| -> Vec<[f64; 2]> {
        let at = |i: u32| {
            let (sine, cosine) = (f64::from(i % 60) / 60.0 * std::f64::consts::TAU).sin_cos();
            [middle[0] + radius * cosine, middle[1] + radius * sine]
        };
        (0..=60).map(at).collect()
    };
    let lake = vec![circle([507_000.0, 5_208_000.0], 3000.0), circle([507_500.0, 5_208_000.0], 800.0)];
    let pond = vec![circle([502_000.0, 5_202_000.0], 200.0)];
    let metres = format!(
        "{{\"type\":\"MultiPolygon\",\"crs\":{{\"type\":\"name\",\"properties\":{{\"name\":\
         \"urn:ogc:def:crs:EPSG::32632\"}}}},\"coordinates\":{:?}}}",
        [lake, pond]
    );
    let degrees = format!(
        "{{\"type\":\"FeatureCollection\",\"features\":[\n{{\"type\":\"Feature\",\"properties\":{{\"name\":\"a lake\"}},\
         \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":{:?}}}}},\n{{\"type\":\"Feature\",\"properties\":null,\
         \"geometry\":{{\"type\":\"GeometryCollection\",\"geometries\":[{{\"type\":\"Polygon\",\"coordinates\":\
         [[[9.01,46.95],[9.03,46.95],[9.02,46.97],[9.01,46.95]]]}}]}}}}]}}\n",
        [circle([9.08, 47.0], 0.03)]
    );
    let metres = text(home, "metres.geojson", &metres);
    metres.into_iter().chain(text(home, "degrees.geojson", &degrees)).collect()
}

fn lists(home: &Path) -> Vec<Seed> {
    let whole = "scale,x,y,z,yaw\n# a hut\n1.5,120,-40,+0.5,30\n,-1e3,2e2,900,\n0.8,0,0,,-720\n";
    let short = "x,y\n1,2\n3,4\n";
    text(home, "whole.csv", whole).into_iter().chain(text(home, "short.csv", short)).collect()
}

fn pictures(home: &Path) -> Vec<Seed> {
    let rgba: Vec<u8> = (0..40 * 30 * 4).map(|index| (index * 7 % 251) as u8).collect();
    let plain = one(home, "plain.png", |path| write_rgba8(path, 40, 30, &rgba).unwrap());
    let grey = one(home, "grey.png", |path| {
        write::png(path, [40, 30], png::ColorType::Grayscale, png::BitDepth::Eight, &rgba[..40 * 30]);
    });
    plain.into_iter().chain(grey).collect()
}

fn exrs(home: &Path) -> Vec<Seed> {
    one(home, "p.exr", |path| {
        let samples: Vec<f32> = (0..40 * 30).map(|index| index as f32 * 0.25).collect();
        let channels = [
            Channel { name: "depth.V".into(), samples: Samples::F32(samples.clone()) },
            Channel { name: "surface.id".into(), samples: Samples::U32((0..40 * 30).collect()) },
        ];
        write_exr(path, 40, 30, &channels, &[]).unwrap();
    })
}
