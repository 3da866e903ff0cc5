//! Damaged caches: the program rebuilds what is damaged, prints one line, and draws the same picture, bit for bit.
//!
//! Damages 6 caches by default, and 12 with `HACHURE_TESTS=full`; `HACHURE_DAMAGED_CACHES=100` damages 100.
#![allow(clippy::disallowed_methods, reason = "the test writes damaged files")]
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::internals::{own_cache_folder, sidecar_path};
use hachure::pyramid::store::{Cancel, open_or_bake_store, open_or_grow_store};
use hachure::pyramid::{self, PyramidError, TileAddress, TileStore};
use hachure::source::{OpenOptions, Progress, Silent};

const UTM: &str = concat!(
    r#"PROJCS["WGS 84 / UTM zone 10N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],"#,
    r#"PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],"#,
    r#"PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",-123],PARAMETER["scale_factor",0.9996],"#,
    r#"PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1]]"#
);

/// Advances a SplitMix64 generator and returns its next number.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

fn has_gpu() -> bool {
    let opened = Gpu::open(&AdapterWish::Best);
    let required = std::env::var_os("HACHURE_REQUIRE_GPU").is_some_and(|value| value == "1");
    if let Err(error) = &opened {
        assert!(!required, "{error}");
        println!("skipped: {error}");
    }
    opened.is_ok()
}

/// Writes a DEM as an ASCII grid, which must be baked.
fn dem(folder: &Path, name: &str, height_m: f64) -> PathBuf {
    let mut text = "ncols 500\nnrows 300\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\n".to_owned();
    let mut chance = 5;
    for y in 0..300 {
        for x in 0..500 {
            let noise = (next(&mut chance) >> 40) as f64 / 16_777_216.0;
            let (x, y) = (f64::from(x), f64::from(y));
            let height = height_m + 0.3 * height_m * (x * 0.02).sin() * (y * 0.03).cos() + 5.0 * noise;
            text += &format!("{height:.3} ");
        }
        text.push('\n');
    }
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    fs::write(path.with_extension("prj"), UTM).unwrap();
    path
}

fn command(folder: &Path, cache: &Path, world: &Path, out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hachure"));
    command
        .args(["render", "--size", "64x36", "--camera", "0,-1400,+150,0,-10,60", "--style", "plain", "-o"])
        .args([out, world])
        .env("HACHURE_CACHE", cache)
        .env("XDG_RUNTIME_DIR", folder)
        .env_remove("RUST_LOG")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn render(folder: &Path, cache: &Path, world: &Path) -> (Output, Option<Vec<u8>>) {
    let out = folder.join("out.png");
    let _ = fs::remove_file(&out);
    let output = command(folder, cache, world, &out).output().unwrap();
    (output, fs::read(out).ok())
}

/// Returns the .tif and .tiles files of the cache entry whose name begins with `name`.
fn entry(cache: &Path, name: &str) -> [PathBuf; 2] {
    let found =
        fs::read_dir(own_cache_folder(cache).unwrap()).unwrap().flatten().map(|entry| entry.path()).find(|path| {
            let file = path.file_name().unwrap().to_string_lossy().into_owned();
            file.starts_with(name) && file.ends_with(".tif")
        });
    let tif = found.unwrap();
    [tif.clone(), sidecar_path(&tif)]
}

/// Damages one of the files, or both, in one of several ways; describes the damage.
fn damage(files: &[PathBuf; 2], others: &[PathBuf; 2], chance: &mut u64) -> String {
    let which = next(chance) % 3;
    let chosen: Vec<usize> = (0..2).filter(|&i| which == 2 || which as usize == i).collect();
    let way = next(chance) % 7;
    let mut description = String::new();
    for i in chosen {
        let file = &files[i];
        let mut bytes = fs::read(file).unwrap();
        let at = next(chance) as usize % bytes.len();
        let length = (1 + next(chance) as usize % 5000).min(bytes.len() - at);
        match way {
            0 => (0..20).for_each(|_| {
                let at = next(chance) as usize % bytes.len();
                bytes[at] ^= 1 << (next(chance) % 8);
            }),
            1 => bytes.truncate(at),
            2 => bytes[at..at + length].fill(0),
            3 => {
                let other = next(chance) as usize % (bytes.len() - length + 1);
                let moved = bytes[other..other + length].to_vec();
                bytes[at..at + length].copy_from_slice(&moved);
            }
            4 => bytes = fs::read(&others[i]).unwrap(),
            5 => bytes.extend_from_within(..length),
            _ => {
                fs::remove_file(file).unwrap();
                description += &format!("{} removed; ", ["tif", "tiles"][i]);
                continue;
            }
        }
        fs::write(file, bytes).unwrap();
        let how = ["bits flipped", "truncated", "zeros", "bytes moved", "of another DEM", "longer"][way as usize];
        description += &format!("{} {how} at {at}; ", ["tif", "tiles"][i]);
    }
    description
}

#[test]
fn damaged_caches_heal() {
    if !has_gpu() {
        return;
    }
    let default = if std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full") { 12 } else { 6 };
    let count = std::env::var("HACHURE_DAMAGED_CACHES").map_or(default, |count| count.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let (world, other) = (dem(folder.path(), "world.asc", 500.0), dem(folder.path(), "other.asc", 600.0));
    let (_, wrong) = render(folder.path(), &cache, &other);
    let (output, truth) = render(folder.path(), &cache, &world);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    // Planted error: the picture of another DEM of the same extent.
    assert!(wrong.is_some() && wrong != truth, "the pictures of two DEMs are equal");
    let (files, others) = (entry(&cache, "world."), entry(&cache, "other."));
    let whole = files.clone().map(|file| fs::read(file).unwrap());
    let (mut chance, mut warned) = (2026, 0);
    for number in 0..count {
        let how = damage(&files, &others, &mut chance);
        let (output, picture) = render(folder.path(), &cache, &world);
        let said = String::from_utf8_lossy(&output.stderr);
        println!("{number}: {how}{}", said.trim_end());
        assert!(output.status.success(), "{how}{said}");
        assert!(said.lines().count() <= 1 && (said.is_empty() || said.contains("is baked again")), "{how}{said}");
        assert!(picture == truth, "{how}the picture differs; {said}");
        warned += said.lines().count();
        // Damage that was found is repaired. Other damage (between tiles, or in tiles out of view) may remain until it
        // is found.
        if !said.is_empty() {
            assert!(
                files.iter().zip(&whole).all(|(file, whole)| fs::read(file).unwrap() == *whole),
                "{how}the rebuilt cache differs"
            );
        }
        for (file, whole) in files.iter().zip(&whole) {
            fs::write(file, whole).unwrap();
        }
    }
    println!("{count} damaged caches, {warned} rebuilt with a warning");
    assert!(warned > count / 3, "only {warned} of {count} damaged caches gave a warning");
}

#[test]
fn two_processes_heal_at_once() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let world = dem(folder.path(), "world.asc", 500.0);
    let (_, truth) = render(folder.path(), &cache, &world);
    let files = entry(&cache, "world.");
    let whole = files.clone().map(|file| fs::read(file).unwrap());
    // Damage that is found when the file is opened, and damage that is found only when a tile is read.
    for at in [70, 100_000] {
        let mut bytes = whole[0].clone();
        bytes[at..at + 3000].fill(0);
        fs::write(&files[0], bytes).unwrap();
        let start = |name: &str| command(folder.path(), &cache, &world, &folder.path().join(name)).spawn().unwrap();
        let both: [(Child, &str); 2] = ["a.png", "b.png"].map(|name| (start(name), name));
        for (child, name) in both {
            let output = child.wait_with_output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && said.lines().count() <= 1, "{said}");
            assert!(fs::read(folder.path().join(name)).ok() == truth, "{said}");
        }
        assert!(files.iter().zip(&whole).all(|(file, whole)| fs::read(file).unwrap() == *whole));
        let left = fs::read_dir(files[0].parent().unwrap()).unwrap().flatten();
        assert_eq!(left.filter(|it| it.path().to_string_lossy().contains(".part")).count(), 0);
    }
}

#[test]
fn an_unwritable_cache_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let world = dem(folder.path(), "world.asc", 500.0);
    let in_the_way = folder.path().join("file");
    fs::write(&in_the_way, b"").unwrap();
    let (output, picture) = render(folder.path(), &in_the_way, &world);
    let said = String::from_utf8_lossy(&output.stderr);
    println!("{}", said.trim_end());
    assert_eq!((output.status.code(), picture, said.lines().count()), (Some(1), None, 1), "{said}");
    assert!(said.contains("cache") && said.contains("HACHURE_CACHE"), "{said}");
    if !has_gpu() {
        return;
    }
    // With an unwritable cache, a COG is read directly.
    let cog = folder.path().join("cog.tif");
    let grid = hachure::source::open(&world, &Silent).unwrap();
    pyramid::bake(&grid, &cog, &Default::default(), &Silent).unwrap();
    fs::remove_file(sidecar_path(&cog)).unwrap();
    let (output, picture) = render(folder.path(), &in_the_way, &cog);
    let said = String::from_utf8_lossy(&output.stderr);
    println!("{}", said.trim_end());
    assert!(output.status.success() && picture.is_some() && said.lines().count() == 1, "{said}");
    assert!(said.contains("without baking"), "{said}");
}

#[test]
fn a_store_heals_while_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let world = dem(folder.path(), "world.asc", 500.0);
    let grown = Arc::new(AtomicU64::new(0));
    let open = || {
        let (world, grown) = (world.clone(), grown.clone());
        let grow = move |_: &dyn Progress| {
            grown.fetch_add(1, Ordering::Relaxed);
            hachure::source::open(&world, &Silent).unwrap()
        };
        open_or_grow_store("key", "world", grow, Some(&cache), &Silent).unwrap()
    };
    let at = |level, x, y| TileAddress { level, x, y };
    let places = [at(0, 0, 0), at(0, 1, 0), at(0, 0, 1), at(0, 1, 1), at(1, 0, 0)];
    // Compared by bits, because samples of patches beyond the grid are NaN.
    let bits = |samples: &[f32]| samples.iter().map(|sample| sample.to_bits()).collect::<Vec<_>>();
    let all = |store: &Arc<dyn TileStore>| places.map(|at| bits(&store.clone().load(at).unwrap().tile.samples));
    let truth = all(&open());
    let [tif, tiles] = entry(&cache, "world.");
    let (lengths, mut times) = ([&tif, &tiles].map(|file| fs::metadata(file).unwrap().len()), 1);
    for (file, offset) in [(&tif, 100_000), (&tiles, lengths[1] - 200), (&tiles, lengths[1] - 2000)] {
        let store = open();
        // The file is overwritten in place while the store has it open, as by a disk error.
        let mut opened = fs::File::options().write(true).open(file).unwrap();
        opened.seek(SeekFrom::Start(offset)).unwrap();
        opened.write_all(&[0xa5; 150]).unwrap();
        drop(opened);
        // A cancelled fetch does not wait for the repair; other fetches return the right tile.
        let cancel = Cancel::default();
        cancel.cancel();
        for place in places {
            let unwanted = store.clone().fetch(place, &cancel).and_then(|decode| decode());
            assert!(unwanted.is_err_and(|error| matches!(error, PyramidError::Cancelled)));
        }
        assert!(all(&store) == truth);
        times += 1;
        assert_eq!(grown.load(Ordering::Relaxed), times, "the cache must be rebuilt exactly once");
        assert!(all(&open()) == truth);
        assert_eq!(grown.load(Ordering::Relaxed), times);
    }
    // An entry with the content of another one, under its own name.
    let other = dem(folder.path(), "other.asc", 600.0);
    let grow = move |_: &dyn Progress| hachure::source::open(&other, &Silent).unwrap();
    drop(open_or_grow_store("other key", "other", grow, Some(&cache), &Silent).unwrap());
    let others = entry(&cache, "other.");
    fs::copy(&others[0], &tif).unwrap();
    fs::copy(&others[1], &tiles).unwrap();
    assert!(all(&open()) == truth, "an entry of another DEM with valid checksums was accepted");
}

#[test]
fn what_somebody_baked_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own.tif");
    let grid = hachure::source::open(&dem(folder.path(), "world.asc", 500.0), &Silent).unwrap();
    pyramid::bake(&grid, &own, &Default::default(), &Silent).unwrap();
    let mut bytes = fs::read(&own).unwrap();
    bytes[100_000..103_000].fill(0);
    fs::write(&own, &bytes).unwrap();
    let sidecar = fs::read(sidecar_path(&own)).unwrap();
    let store = open_or_bake_store(&own, &OpenOptions::default(), &Silent).unwrap();
    let load = |x, y| Arc::clone(&store).load(TileAddress { level: 0, x, y });
    let damaged: Vec<_> = [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().filter_map(|(x, y)| load(x, y).err()).collect();
    assert!(!damaged.is_empty() && damaged.iter().all(PyramidError::wants_bake), "{damaged:?}");
    assert!(fs::read(&own).unwrap() == bytes && fs::read(sidecar_path(&own)).unwrap() == sidecar);
}
