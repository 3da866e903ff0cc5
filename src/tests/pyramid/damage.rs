//! Tests interrupted bakes, stale and damaged files, and the cache.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;

use hachure::file::cache_folder;
use hachure::pyramid::format::sidecar_path;
use hachure::pyramid::store::{open_or_bake, open_or_bake_key, trim, write_manifest};
use hachure::pyramid::{BakeOptions, Pyramid, PyramidError, TileAddress, TileStore, bake};
use hachure::source::{Progress, Silent};

use crate::tests::pyramid::{baked, tiles, world};

/// Stops the bake by a panic when `what` is reported.
struct StopAt(&'static str);

impl Progress for StopAt {
    fn report(&self, what: &str, _done: f32) {
        assert_ne!(what, self.0, "stopped");
    }
}

#[test]
fn an_interrupted_bake_leaves_nothing() {
    let grid = world::grid();
    for stage in ["baking", "levels", "encoding", "tile errors", "mesh errors", "writing", "statistics"] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("world.tif");
        let stopped =
            catch_unwind(AssertUnwindSafe(|| bake(&grid, &out, &BakeOptions::default(), &StopAt(stage)).is_ok()));
        assert!(stopped.is_err(), "{stage} was never reported");
        let left: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
        assert!(left.is_empty(), "{stage}: {left:?}");
    }
}

#[test]
fn a_failed_bake_keeps_the_old_pyramid() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("world.tif");
    drop(baked(&world::grid(), &out, 0.0));
    let mut void = world::grid();
    void.heights_m.fill(f32::NAN);
    let failed = bake(&void, &out, &BakeOptions::default(), &Silent);
    assert!(matches!(failed, Err(PyramidError::NoHeights { .. })));
    Pyramid::open(&out).unwrap();
}

#[test]
fn nonsense_grids_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("world.tif");
    let mut short = world::grid();
    short.heights_m.pop();
    assert!(matches!(bake(&short, &out, &BakeOptions::default(), &Silent), Err(PyramidError::BadGrid { .. })));
    for max_error_m in [f64::NAN, -1.0, f64::INFINITY] {
        let options = BakeOptions { max_error_m };
        assert!(matches!(bake(&world::grid(), &out, &options, &Silent), Err(PyramidError::BadGrid { .. })));
    }
    let mut infinite = world::grid();
    infinite.heights_m[100_000] = f32::INFINITY;
    let report = bake(&infinite, &out, &BakeOptions { max_error_m: 0.1 }, &Silent).unwrap();
    assert!(report.max_m.is_finite());
}

#[test]
fn missing_and_stale_sidecars_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.tif"), folder.path().join("b.tif"));
    drop(baked(&world::grid(), &a, 0.0));
    drop(baked(&world::rough(601, 487, false), &b, 0.0));
    fs::copy(sidecar_path(&b), sidecar_path(&a)).unwrap();
    assert!(matches!(Pyramid::open(&a), Err(PyramidError::StaleSidecar { .. })));
    fs::remove_file(sidecar_path(&a)).unwrap();
    assert!(matches!(Pyramid::open(&a), Err(PyramidError::NoSidecar { .. })));
    fs::remove_file(&b).unwrap();
    assert!(matches!(Pyramid::open(&b), Err(PyramidError::Io { .. })));
}

#[test]
fn damaged_sidecars_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("world.tif");
    drop(baked(&world::rough(300, 40, true), &out, 0.0));
    let whole = fs::read(sidecar_path(&out)).unwrap();
    for length in (0..whole.len()).step_by(7) {
        fs::write(sidecar_path(&out), &whole[..length]).unwrap();
        assert!(Pyramid::open(&out).is_err_and(|error| error.wants_bake()), "cut to {length}");
    }
    for at in (0..whole.len()).step_by(5) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x41;
        fs::write(sidecar_path(&out), &damaged).unwrap();
        // The header is checked on opening, a record when its tile is read.
        let found = Pyramid::open(&out).and_then(|pyramid| {
            let pyramid = Arc::new(pyramid);
            tiles(&pyramid).into_iter().try_for_each(|tile| pyramid.clone().load(tile).map(drop))
        });
        assert!(found.is_err_and(|error| error.wants_bake()), "damaged at {at}");
    }
    let longer = [whole.as_slice(), b"more"].concat();
    fs::write(sidecar_path(&out), longer).unwrap();
    assert!(Pyramid::open(&out).is_err());
}

#[test]
fn damaged_geotiffs_are_errors_not_panics() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("world.tif");
    for max_error_m in [0.0, 0.1] {
        drop(baked(&world::grid(), &out, max_error_m));
        let whole = fs::read(&out).unwrap();
        for length in [0, 3, 8, 200, whole.len() / 2, whole.len() - 1] {
            fs::write(&out, &whole[..length]).unwrap();
            assert!(Pyramid::open(&out).is_err(), "cut to {length}");
        }
        fs::write(&out, &whole).unwrap();
        // Damage between the ends, which the sidecar's check of the file does not cover, is detected when the tile is
        // read. It must never be read as other heights.
        let all = tiles(&Pyramid::open(&out).unwrap());
        let read_all = || {
            let pyramid = Pyramid::open(&out).unwrap();
            all.iter().map(|&tile| pyramid.read_tile(tile)).collect::<Result<Vec<_>, _>>()
        };
        let intact = read_all().unwrap();
        let mut found = 0;
        for at in (66_000..whole.len() - 66_000).step_by(9_973) {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x41;
            fs::write(&out, &damaged).unwrap();
            match read_all() {
                Ok(same) => assert!(same == intact, "damage at {at} was not detected"),
                Err(_) => found += 1,
            }
        }
        assert!(found > 0, "no damage was detected");
        fs::write(&out, &whole).unwrap();
        let pyramid = Pyramid::open(&out).unwrap();
        let nowhere = pyramid.read_tile(TileAddress { level: 0, x: 3, y: 0 });
        assert!(matches!(nowhere, Err(PyramidError::NoSuchTile { .. })));
        assert!(pyramid.read_tile(TileAddress { level: 9, x: 0, y: 0 }).is_err());
    }
}

#[test]
fn the_cache_bakes_once() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let source = folder.path().join("heights.raw");
    fs::write(&source, b"anything").unwrap();
    let loads = std::cell::Cell::new(0);
    let load = || {
        loads.set(loads.get() + 1);
        Ok::<_, std::io::Error>(world::rough(300, 200, true))
    };
    let first = open_or_bake(&source, load, Some(&cache), &Silent).unwrap();
    assert!(first.path().starts_with(&cache));
    drop(open_or_bake(&source, load, Some(&cache), &Silent).unwrap());
    assert_eq!(loads.get(), 1);
    // A file of another size counts as another file.
    fs::write(&source, b"something else").unwrap();
    drop(open_or_bake(&source, load, Some(&cache), &Silent).unwrap());
    assert_eq!(loads.get(), 2);
    // A damaged cache is rebuilt.
    let files = || {
        let entries = fs::read_dir(cache_folder::open(&cache).unwrap()).unwrap().flatten();
        entries.map(|entry| entry.path()).filter(|path| !path.ends_with("CACHEDIR.TAG"))
    };
    files().for_each(|path| fs::write(path, b"damaged").unwrap());
    drop(open_or_bake(&source, load, Some(&cache), &Silent).unwrap());
    assert_eq!(loads.get(), 3);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        assert!(files().all(|path| fs::metadata(path).unwrap().permissions().mode() & 0o777 == 0o600));
        // A pyramid whose origin is not recorded may be forged. Pipes and links in the place of files hold nothing up.
        let is_of = |path: &PathBuf, ending: &str| path.to_string_lossy().ends_with(ending);
        for (times, ending) in [(4, ".from"), (5, ".lock"), (6, ".tif"), (7, ".tiles")] {
            for path in files().filter(|path| is_of(path, ending)).collect::<Vec<_>>() {
                fs::remove_file(&path).unwrap();
                if times == 4 {
                    continue;
                }
                assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
            }
            if ending == ".lock" {
                files().filter(|path| is_of(path, ".from")).for_each(|path| fs::remove_file(path).unwrap());
            }
            drop(open_or_bake(&source, load, Some(&cache), &Silent).unwrap());
            assert_eq!(loads.get(), times, "{ending}");
        }
        let victim = folder.path().join("victim");
        fs::write(&victim, b"mine").unwrap();
        for path in files().filter(|path| is_of(path, ".tif")).collect::<Vec<_>>() {
            fs::remove_file(&path).unwrap();
            std::os::unix::fs::symlink(&victim, path).unwrap();
        }
        let changed = fs::metadata(&victim).unwrap().modified().unwrap();
        drop(open_or_bake(&source, load, Some(&cache), &Silent).unwrap());
        assert_eq!((loads.get(), fs::read(&victim).unwrap()), (8, b"mine".to_vec()));
        assert_eq!(fs::metadata(&victim).unwrap().modified().unwrap(), changed);
        loads.set(3);
    }
    // A pyramid with its sidecar file is opened directly.
    let own = folder.path().join("own.tif");
    drop(baked(&world::rough(300, 200, true), &own, 0.0));
    assert_eq!(open_or_bake(&own, load, Some(&cache), &Silent).unwrap().path(), own);
    assert_eq!(loads.get(), 3);
    let failing = || Err("no such generator");
    let failed = open_or_bake_key("seed 3", "procedural", failing, Some(&cache), &Silent);
    assert!(matches!(failed, Err(PyramidError::Load(_))));
    drop(open_or_bake_key("seed 2", "procedural", load, Some(&cache), &Silent).unwrap());
    drop(open_or_bake_key("seed 2", "procedural", load, Some(&cache), &Silent).unwrap());
    assert_eq!(loads.get(), 4);
}

#[test]
fn the_cache_stays_within_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    let grid = world::rough(64, 64, false);
    let mut paths = Vec::new();
    for i in 0..4 {
        let path = folder.path().join(format!("world.{i:016x}.tif"));
        drop(baked(&grid, &path, 0.0));
        write_manifest(&path, &format!("key {i}"));
        let used = std::time::SystemTime::now() - std::time::Duration::from_secs(1000 * (4 - i));
        fs::File::options().append(true).open(&path).unwrap().set_modified(used).unwrap();
        paths.push(path);
    }
    let bytes = fs::metadata(&paths[0]).unwrap().len() + fs::metadata(sidecar_path(&paths[0])).unwrap().len();
    // Files of a user that look more or less like those of the cache: all are old, and one is large.
    let mine = ["my_dem.tif", "my.0123456789abcdef.tif", "ubuntu.iso.part", ".my.tif.4711.part", "a.tif.from"];
    let mine = mine.map(|name| folder.path().join(name));
    let old = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1_000_000);
    for path in &mine {
        fs::write(path, b"HACHTILE").unwrap();
        fs::File::options().append(true).open(path).unwrap().set_modified(old).unwrap();
    }
    fs::File::options().append(true).open(&mine[0]).unwrap().set_len(9 << 30).unwrap();
    // A manifest next to another file than the one that it describes.
    fs::copy(format!("{}.from", paths[1].display()), format!("{}.from", mine[1].display())).unwrap();
    // Planted: an abandoned temporary file of an entry, which the same rules find.
    let abandoned = folder.path().join(format!(".world.{:016x}.tif.tiles.abcdefABCDEF.part", 7));
    fs::write(&abandoned, b"").unwrap();
    fs::File::options().append(true).open(&abandoned).unwrap().set_modified(old).unwrap();
    trim(folder.path(), &paths[0], 2 * bytes + 100);
    assert!(mine.iter().all(|path| path.exists()) && !abandoned.exists());
    let left: Vec<bool> = paths.iter().map(|path| path.exists()).collect();
    assert_eq!(left, [true, false, false, true], "the oldest must be deleted first, and the one in use kept");
    assert!(!sidecar_path(&paths[1]).exists());
}
