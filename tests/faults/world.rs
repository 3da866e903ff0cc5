//! The files of these tests, and the tiles expected from them.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use geotiff_writer::{CogBuilder, Compression, GeoTiffBuilder};
use hachure::internals::{BLOCK_BYTES, inspect};
use hachure::pyramid::{self, BakeOptions, Pyramid, TileAddress, TileStore};
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::{HeightGrid, Silent};
use ndarray::Array2;

use crate::faulty_server::{Server, next};
use crate::flight::{Truth, fingerprint};

const WIDTH: u32 = 601;
const HEIGHT: u32 = 487;

/// A folder with the test files.
pub(crate) struct World {
    folder: PathBuf,
}

/// The content of a cache.
#[derive(Debug, Default)]
pub(crate) struct Found {
    pub blocks: u64,
    /// Files that a reader would discard.
    pub damaged: u64,
    /// Bytes that affect a height and differ from the file.
    pub wrong_bytes: u64,
    /// Other bytes that differ: in the frames around tiles, which no decoder reads.
    pub harmless_bytes: u64,
}

fn grid(voids: bool) -> HeightGrid {
    let mut chance = 17;
    let height = |(x, y): (u32, u32), noise: f32| {
        let (x, y) = (x as f32, y as f32);
        2500.0 + 300.0 * (x * 0.021).sin() * (y * 0.017).cos() + 6.0 * noise
    };
    let heights_m = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))).map(|(x, y)| {
        let noise = (next(&mut chance) >> 40) as f32 / 16_777_216.0;
        let lake = x > 350 && y > 250 || x + y < 60;
        if voids && lake { f32::NAN } else { height((x, y), noise) }
    });
    let crs = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32610".into() };
    let crs_from_grid = [590_005.0, 10.0, 0.0, 5_199_995.0, 0.0, -10.0];
    let georeference = Georeference { crs_from_grid, crs, geokeys: Default::default() };
    HeightGrid { width: WIDTH, height: HEIGHT, heights_m: heights_m.collect(), georeference }
}

/// The baked pyramids, which are also served without their sidecars, as COGs of other programs.
const BAKED: [&str; 3] = ["deflate.tif", "lerc.tif", "voids.tif"];

pub(crate) fn all(store: Arc<dyn TileStore>) -> Truth {
    let mut truth = Vec::new();
    for (level, size) in (0..).zip(store.levels()) {
        for y in 0..size.tiles_y() {
            for x in 0..size.tiles_x() {
                let address = TileAddress { level, x, y };
                truth.push((address, fingerprint(&store.clone().load(address).unwrap())));
            }
        }
    }
    truth
}

impl World {
    /// Writes all files into `folder`.
    pub(crate) fn make(folder: &Path) -> Self {
        for (name, voids, max_error_m) in
            [("deflate.tif", false, 0.0), ("lerc.tif", false, 0.01), ("voids.tif", true, 0.0)]
        {
            pyramid::bake(&grid(voids), &folder.join(name), &BakeOptions { max_error_m }, &Silent).unwrap();
        }
        let heights_m = Array2::from_shape_vec((HEIGHT as usize, WIDTH as usize), grid(false).heights_m).unwrap();
        let builder = || {
            let builder = GeoTiffBuilder::new(WIDTH, HEIGHT).epsg(32610).pixel_scale(10.0, 10.0);
            builder.origin(590_000.0, 5_200_000.0).tile_size(256, 256)
        };
        let plain = CogBuilder::new(builder().compression(Compression::None)).overview_levels(vec![2, 4]);
        plain.write_2d(folder.join("plain.tif"), heights_m.view()).unwrap();
        let step = CogBuilder::new(builder().compression(Compression::Deflate)).overview_levels(vec![2]);
        step.write_2d(folder.join("step.tif"), heights_m.view()).unwrap();
        let bare = CogBuilder::new(builder().compression(Compression::Deflate)).no_overviews();
        bare.write_2d(folder.join("bare.tif"), heights_m.view()).unwrap();
        let builder = GeoTiffBuilder::new(9000, 40).epsg(32610).pixel_scale(1.0, 1.0).origin(0.0, 0.0);
        let large = builder.compression(Compression::Deflate);
        large.write_2d(folder.join("large.tif"), Array2::<f32>::zeros((40, 9000)).view()).unwrap();
        Self { folder: folder.to_owned() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.folder.join(name)).unwrap()
    }

    /// Serves all files; the baked ones both with and without their sidecars.
    pub(crate) fn serve(&self, server: &Server) {
        for name in ["deflate.tif", "lerc.tif", "voids.tif", "plain.tif", "large.tif"] {
            server.put(name, self.bytes(name));
        }
        for name in BAKED {
            server.put(&format!("baked/{name}"), self.bytes(name));
            server.put(&format!("baked/{name}.tiles"), self.bytes(&format!("{name}.tiles")));
        }
    }

    /// Returns all tiles of a baked pyramid, as `Pyramid` reads them.
    pub(crate) fn baked_truth(&self, name: &str) -> Truth {
        all(Arc::new(Pyramid::open(&self.folder.join(name)).unwrap()))
    }

    /// Returns all tiles as they are read from the file as a COG.
    pub(crate) fn truth(&self, name: &str) -> Truth {
        all(pyramid::store::open_local_cog(&self.folder.join(name)).unwrap().unwrap())
    }

    /// Compares every block in the cache with the file.
    pub(crate) fn compare(&self, name: &str, cache: &Path) -> Found {
        let truth = self.bytes(name);
        let frames = self.frames(name);
        let mut found = Found::default();
        for cached in inspect(cache) {
            let Some((index, bytes)) = cached.block else {
                found.damaged += 1;
                continue;
            };
            found.blocks += 1;
            let start = (index * BLOCK_BYTES) as usize;
            let expected = &truth[start..(start + BLOCK_BYTES as usize).min(truth.len())];
            assert_eq!(expected.len(), bytes.len());
            for (at, _) in bytes.iter().zip(expected).enumerate().filter(|(_, (a, b))| a != b) {
                let in_frame = frames.iter().any(|frame| frame.contains(&((start + at) as u64)));
                *(if in_frame { &mut found.harmless_bytes } else { &mut found.wrong_bytes }) += 1;
            }
        }
        found
    }

    /// Returns the ranges of bytes around tiles: four with the size before each, and its last four repeated after it.
    fn frames(&self, name: &str) -> Vec<Range<u64>> {
        let file = tiff_reader::TiffFile::open(self.folder.join(name)).unwrap();
        let tiles = file.ifds().iter().flat_map(|ifd| {
            ifd.tile_offsets().unwrap_or_default().into_iter().zip(ifd.tile_byte_counts().unwrap_or_default())
        });
        tiles.flat_map(|(offset, count)| [offset - 4..offset, offset + count..offset + count + 4]).collect()
    }
}
