//! Flights over a bad network: every tile that arrives is right, and the cache on disk contains no wrong bytes.
#![allow(clippy::disallowed_methods, reason = "the test writes damaged files")]
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

#[path = "../src/tests/common/faulty_server.rs"]
mod faulty_server;
#[path = "faults/flight.rs"]
mod flight;
#[path = "faults/world.rs"]
mod world;

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use faulty_server::{Faults, Rates, Server, next};
use flight::{Flight, System};
use hachure::internals::{RemoteFile, inspect};
use hachure::pyramid::{self, PyramidError, TileStore};
use hachure::remote::{RemoteError, Settings};

/// Returns whether the long tier of the tests is wanted (`./check --full`).
fn full() -> bool {
    std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full")
}

/// Returns a rate of 2 % for each of the five faults.
fn bad() -> Faults {
    Faults { rates: Rates::all(0.02), hang: Duration::from_millis(700) }
}

/// Room for six of nine decoded tiles: many tiles are decoded repeatedly, and the test remains fast.
const DECODED_BYTES: usize = 6 << 18;

/// Settings as in flight, with short timeouts.
fn hasty(cache: Option<&Path>) -> Settings {
    Settings {
        cache: cache.map(Path::to_owned),
        memory_bytes: 1 << 16,
        connect_timeout: Duration::from_millis(500),
        request_timeout: Duration::from_millis(500),
        first_pause: Duration::from_millis(2),
        longest_pause: Duration::from_millis(50),
        ..Settings::default()
    }
}

/// Opens a remote file, with several attempts, since opening may fail on a bad network.
fn opened(url: &str, settings: &Settings) -> Arc<dyn TileStore> {
    for _ in 0..20 {
        match pyramid::store::open_remote_with(url, settings.clone(), DECODED_BYTES) {
            Ok(store) => return store,
            Err(error) => println!("  opening: {error}"),
        }
    }
    panic!("{url} cannot be opened");
}

#[test]
fn an_hour_of_requests() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(20_260_101);
    let world = world::World::make(folder.path());
    world.serve(&server);
    // Threads and connections that live as long as the program are created before the count.
    drop(opened(&server.url("deflate.tif"), &hasty(None)));
    let before = System::now();
    let start = Instant::now();

    server.set_faults(bad());
    // The fast tier has twelve minutes of requests.
    let part = if full() { 1 } else { 5 };
    let (mut requested, mut wrong, mut retried) = (0, 0, 0);
    for (name, tries, cached, requests) in [
        ("deflate.tif", 6, false, 3000),
        ("lerc.tif", 2, false, 2000),
        ("voids.tif", 6, true, 1500),
        ("baked/lerc.tif", 6, false, 2000),
        ("baked/voids.tif", 2, true, 1500),
    ] {
        let cache = folder.path().join("cache");
        // The cache is smaller than the file, so it is written, trimmed and read continuously.
        let settings = Settings { tries, cache_bytes: 300_000, ..hasty(cached.then_some(cache.as_path())) };
        let store = opened(&server.url(name), &settings);
        let truth = match name.strip_prefix("baked/") {
            Some(name) => world.baked_truth(name),
            None => world.truth(name),
        };
        assert_eq!(store.is_measured(), name.starts_with("baked/"));
        let outcome = Flight { requests: requests / part, threads: 4, seed: 7, tries: 5 }.fly(&store, &truth);
        println!("{name}: {outcome:?}");
        requested += outcome.requested();
        wrong += outcome.wrong;
        retried += outcome.retried;
        assert_eq!(outcome.panicked, 0);
        assert!(outcome.right > outcome.requested() / 2);
        // After retries hardly any tile is missing, in which case its parent would be drawn.
        assert!(outcome.failed * 50 < outcome.requested(), "{outcome:?}");
    }
    println!("{}", server.summary());
    println!("{requested} tiles requested in {:.1} s", start.elapsed().as_secs_f64());
    assert!(requested >= 10_000 / part);
    assert_eq!(wrong, 0);
    assert!(retried > 0, "no tile came at a second try");
    for share in [&server.counts().dropped, &server.counts().truncated, &server.counts().flipped] {
        assert!(share.load(Ordering::Relaxed) > 20 / part, "the server made too few faults");
    }

    drop(server);
    std::thread::sleep(Duration::from_millis(300));
    let after = System::now();
    println!("before {before:?}\nafter  {after:?}");
    assert!(after.threads <= before.threads + 8 && after.files <= before.files + 16);
    assert!(after.resident_bytes < before.resident_bytes + (96 << 20));
}

#[test]
fn the_cache_on_disk_is_right_in_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let server = Server::start(5);
    let world = world::World::make(folder.path());
    world.serve(&server);
    for name in ["deflate.tif", "voids.tif", "lerc.tif"].into_iter().take(if full() { 3 } else { 2 }) {
        let truth = world.truth(name);
        // So many bytes are changed that some remain in the cache, in parts of blocks that no tile has used yet.
        server.set_faults(Faults { rates: Rates { flip: 0.3, ..Rates::default() }, ..Faults::default() });
        let mut invalidated = 0;
        for seed in (1..7).take(if full() { 6 } else { 3 }) {
            // The cache holds half of the file, so that much of it is requested again.
            let settings = Settings { cache_bytes: 500_000, ..hasty(Some(&cache)) };
            let open = || pyramid::store::open_remote_with(&server.url(name), settings.clone(), 1 << 20);
            let Some(store) = (0..20).find_map(|_| open().ok()) else { panic!("{name} cannot be opened") };
            let traffic = store.clone();
            let outcome = Flight { requests: 40, threads: 3, seed, tries: 12 }.fly(&(store as _), &truth);
            assert_eq!((outcome.wrong, outcome.panicked), (0, 0));
            invalidated += traffic.traffic().invalidated;
        }
        server.set_faults(Faults::default());
        let store = opened(&server.url(name), &hasty(Some(&cache)));
        for (address, expected) in &truth {
            let loaded = (0..4).find_map(|_| store.clone().load(*address).ok()).unwrap();
            assert_eq!(flight::fingerprint(&loaded), *expected, "{name} {address:?}");
        }
        let found = world.compare(name, &cache);
        println!("{name}: {invalidated} blocks rejected; then {found:?}");
        assert!(invalidated > 0 && found.blocks > 0);
        assert_eq!((found.damaged, found.wrong_bytes), (0, 0));
        std::fs::remove_dir_all(&cache).unwrap();
    }
}

#[test]
fn planted_wrong_bytes_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(6);
    let world = world::World::make(folder.path());
    world.serve(&server);
    let url = server.url("plain.tif");
    let truth = world.truth("plain.tif");
    let cache = folder.path().join("cache");
    let flight = Flight { requests: 200, threads: 2, seed: 3, tries: 3 };

    // Uncompressed bytes have no checksum: changes on the way reach the samples, and this test must find them.
    let store = opened(&url, &hasty(None));
    server.set_faults(Faults { rates: Rates { flip: 0.1, ..Rates::default() }, ..Faults::default() });
    let outcome = flight.fly(&store, &truth);
    println!("uncompressed, bytes changed on the way: {outcome:?}");
    assert!(outcome.wrong > 0);
    server.set_faults(Faults::default());

    // Changes on disk are found by the cache's own checksum, unless verification is off.
    for (verify, is_wrong) in [(true, false), (false, true)] {
        drop(opened(&url, &hasty(Some(&cache))));
        let fill = opened(&url, &hasty(Some(&cache)));
        assert_eq!(flight.fly(&fill, &truth).wrong, 0);
        let mut chance = 99;
        for block in inspect(&cache) {
            let mut bytes = std::fs::read(&block.path).unwrap();
            if block.block.unwrap().0 > 3 {
                let at = 36 + next(&mut chance) as usize % (bytes.len() - 36);
                bytes[at] ^= 0x40;
                std::fs::write(&block.path, bytes).unwrap();
            }
        }
        let store = opened(&url, &Settings { verify, ..hasty(Some(&cache)) });
        let outcome = flight.fly(&store, &truth);
        println!("uncompressed, bytes changed on disk, verified {verify}: {outcome:?}");
        assert_eq!(outcome.wrong > 0, is_wrong);
        std::fs::remove_dir_all(&cache).unwrap();
    }
}

#[test]
fn a_reader_that_is_killed_leaves_a_right_cache() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let server = Server::start(8);
    let world = world::World::make(folder.path());
    world.serve(&server);
    let mut chance = 12;
    let mut blocks = 0;
    let readers = if full() { 12 } else { 6 };
    for _ in 0..readers {
        let mut reader = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "reads_until_killed", "--ignored"])
            .env("HACHURE_TEST_URL", server.url("deflate.tif"))
            .env("HACHURE_TEST_CACHE", &cache)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(60 + next(&mut chance) % 120));
        // Sends SIGKILL.
        reader.kill().unwrap();
        reader.wait().unwrap();
        let found = world.compare("deflate.tif", &cache);
        assert_eq!((found.damaged, found.wrong_bytes, found.harmless_bytes), (0, 0, 0), "{found:?}");
        blocks += found.blocks;
    }
    println!("{readers} readers killed; {blocks} blocks verified");
    assert!(blocks > 0, "no reader was killed while it wrote");
}

/// Reads until it is killed; not a test of its own.
#[test]
#[ignore = "is run by another test"]
fn reads_until_killed() {
    let (Ok(url), Ok(cache)) = (std::env::var("HACHURE_TEST_URL"), std::env::var("HACHURE_TEST_CACHE")) else { return };
    let settings = Settings { cache_bytes: 300_000, ..hasty(Some(Path::new(&cache))) };
    let file = RemoteFile::open(&url, settings).unwrap();
    let mut chance = u64::from(std::process::id()) | 1;
    loop {
        file.forget();
        file.invalidate(0..next(&mut chance) % file.size());
        file.read(0, file.size() as usize, &|| false).unwrap();
    }
}

#[test]
fn buckets_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(9);
    let world = world::World::make(folder.path());
    server.put("bucket/some%20land/deflate.tif", world.bytes("deflate.tif"));
    server.put("bucket/land/deflate.tif", world.bytes("deflate.tif"));
    server.set_faults(bad());
    let endpoint = server.url("").trim_end_matches('/').to_owned();
    let s3 = vec![("AWS_ENDPOINT".to_owned(), endpoint), ("AWS_ALLOW_HTTP".to_owned(), "true".to_owned())];
    let settings = Settings { s3, ..hasty(None) };
    for key in ["land/deflate.tif", "some land/deflate.tif"] {
        let store = opened(&format!("s3://bucket/{key}"), &settings);
        let outcome = Flight { requests: 100, threads: 2, seed: 1, tries: 5 }.fly(&store, &world.truth("deflate.tif"));
        println!("{}: {outcome:?}", store.name());
        assert!(outcome.wrong == 0 && outcome.right > 50);
    }
    let keys = [("AWS_ACCESS_KEY_ID", "me"), ("AWS_SECRET_ACCESS_KEY", "hush")];
    let mut signed = settings.clone();
    signed.s3.extend(keys.map(|(key, value)| (key.to_owned(), value.to_owned())));
    assert!(!opened("s3://bucket/land/deflate.tif", &signed).name().contains("hush"));
    server.set_faults(Faults::default());
    let missing = pyramid::store::open_remote_with("s3://bucket/sea.tif", settings, 1 << 20).err().unwrap();
    assert!(matches!(missing, PyramidError::Remote(RemoteError::NotFound { .. })), "{missing}");
}

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(10);
    let world = world::World::make(folder.path());
    world.serve(&server);
    server.put("text.tif", b"no picture".to_vec());
    server.put("empty.tif", Vec::new());
    let quick = Settings { tries: 2, ..hasty(None) };
    let error = |url: &str| pyramid::store::open_remote_with(url, quick.clone(), 1 << 20).err().unwrap();
    let secret = |path: &str| server.url(path).replace("http://", "http://me:hush@") + "?signature=hush";
    for path in ["nothing.tif", "text.tif", "empty.tif", "large.tif"] {
        let error = error(&secret(path)).to_string();
        println!("{error}");
        assert!(error.contains(path) && !error.contains("hush") && !error.contains('\n'), "{error}");
    }
    assert!(matches!(error(&server.url("large.tif")), PyramidError::NoOverviews { .. }));
    server.set_faults(Faults { rates: Rates { refuse: 1.0, ..Rates::default() }, ..Faults::default() });
    let refused = error(&secret("deflate.tif")).to_string();
    assert!(refused.contains("after 2 tries") && !refused.contains("hush"), "{refused}");
    server.set_faults(Faults::default());

    // Another file at the same address.
    let url = server.url("deflate.tif");
    let file = RemoteFile::open(&url, hasty(None)).unwrap();
    let mut other = world.bytes("deflate.tif");
    other[300_000] ^= 1;
    server.put("deflate.tif", other);
    let changed = file.read(file.size() - 10, 10, &|| false);
    assert!(matches!(changed, Err(RemoteError::Changed { .. })), "{changed:?}");

    // The server is gone.
    let url = server.url("deflate.tif");
    drop(server);
    let gone = pyramid::store::open_remote_with(&url, quick, 1 << 20).err().unwrap();
    assert!(matches!(gone, PyramidError::Remote(RemoteError::Failed { tries: 2, .. })), "{gone}");
}

/// Tests COGs made by GDAL, where it is installed: blocks of 512, integers, no-data, scale and offset, all codecs.
#[test]
fn gdals_cogs_are_flown_over() {
    let folder = tempfile::tempdir().unwrap();
    let world = world::World::make(folder.path());
    if Command::new("gdal_translate").arg("--version").output().is_err() {
        println!("skipped: gdal_translate is not installed");
        return;
    }
    for (number, options) in [
        "-co COMPRESS=DEFLATE -co BLOCKSIZE=512",
        "-co COMPRESS=LERC_DEFLATE -co MAX_Z_ERROR=0.01 -co BLOCKSIZE=256",
        "-co COMPRESS=ZSTD -co PREDICTOR=YES -co BLOCKSIZE=128",
        "-ot Int16 -a_nodata -32768 -co COMPRESS=LZW -co PREDICTOR=YES -co BLOCKSIZE=256",
        "-ot Int32 -scale 0 4000 0 40000 -a_scale 0.1 -a_offset 0 -co COMPRESS=DEFLATE -co BLOCKSIZE=256",
    ]
    .into_iter()
    .enumerate()
    {
        let out = folder.path().join(format!("gdal{number}.tif"));
        // Larger, so that GDAL makes overviews, and with no-data where NaN can be written.
        let made = Command::new("gdal_translate")
            .args(["-q", "-of", "COG", "-outsize", "1501", "1203", "-r", "nearest", "-co", "RESAMPLING=AVERAGE"])
            .args(options.split(' '))
            .args([world.path(if options.contains("-ot") { "deflate.tif" } else { "voids.tif" }), out.clone()])
            .output()
            .unwrap();
        if !made.status.success() {
            println!("skipped: this GDAL does not support {options}: {}", String::from_utf8_lossy(&made.stderr));
            continue;
        }
        let grid = hachure::source::open(&out, &hachure::source::Silent).unwrap();
        let store = pyramid::store::open_local_cog(&out).unwrap().unwrap();
        let baked = folder.path().join(format!("baked{number}.tif"));
        pyramid::bake(&grid, &baked, &Default::default(), &hachure::source::Silent).unwrap();
        let baked: Arc<dyn TileStore> = Arc::new(pyramid::Pyramid::open(&baked).unwrap());
        assert_eq!(store.levels(), baked.levels());
        assert_eq!(store.georeference().crs_from_grid, baked.georeference().crs_from_grid);
        for (address, _) in world::all(baked.clone()) {
            let (ours, theirs) = (store.clone().load(address).unwrap(), baked.clone().load(address).unwrap());
            let (mut worst, mut differs) = (0.0_f32, 0);
            for (a, b) in ours.tile.samples.iter().zip(&theirs.tile.samples) {
                let voids = [a, b].map(|sample| sample.to_bits() & 1 == 1);
                // Deep in no-data, filling ends at a level that GDAL averages differently, or at another constant.
                if voids == [false; 2] {
                    worst = worst.max((a - b).abs());
                }
                differs += u32::from(voids[0] != voids[1]);
            }
            // GDAL's averages of integers are integers, and one valid sample of four is enough for a height.
            let bound_m = if address.level == 0 { 0.0 } else { 25.0 };
            assert!(worst <= bound_m, "{options} {address:?}: heights differ by {worst} m");
            assert!(differs == 0 || address.level > 0, "{options} {address:?}: {differs} samples differ in no-data");
        }
    }
}

#[test]
fn levels_that_are_missing_are_averaged() {
    let folder = tempfile::tempdir().unwrap();
    let world = world::World::make(folder.path());
    let truth = world.truth("deflate.tif");
    // Only level 1 of the levels 0, 1, 2 is stored; bare.tif has none, which is allowed for a small file.
    for name in ["step.tif", "bare.tif"] {
        let store = pyramid::store::open_local_cog(&folder.path().join(name)).unwrap().unwrap();
        assert!(!store.is_measured());
        for (address, expected) in &truth {
            let loaded = store.clone().load(*address).unwrap();
            if name == "bare.tif" || address.level == 0 {
                assert_eq!(flight::fingerprint(&loaded), *expected, "{name} {address:?}");
            }
        }
    }
    assert!(pyramid::store::open_local_cog(&folder.path().join("large.tif")).unwrap().is_none());
}
