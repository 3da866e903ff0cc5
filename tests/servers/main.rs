//! Tests more than eighty kinds of server, most of them faulty: the picture of a file on one is bit-identical to that
//! of the local file, or there is an error of one line that says what the server did, in bounded time.
//!
//! `HACHURE_SERVERS=all` has the program itself render from every kind with its own timeouts, which takes minutes, and
//! prints how long each takes; `HACHURE_SERVERS=silence` does this only for the kinds with the word in their name.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../src/tests/common/mod.rs"]
mod common;
mod kinds;
mod odd;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use common::{grid_of, random};
use hachure::gpu::Gpu;
use hachure::picture::{self, PictureRequest};
use hachure::pyramid::{self, BakeOptions, TileStore};
use hachure::remote::Settings;
use hachure::scene::reach::Reach;
use hachure::source::Silent;
use hachure::style::Style;
use hachure::world::TerrainOptions;
use hachure::world::{OpenWorld, scene_of};
use kinds::{Expected, KINDS};
use odd::Server;

const SIZE_PX: [u32; 2] = [64, 36];

/// Durations that replace a second: a short one while a server stalls, and a longer one where slowness must not matter.
const HURRY: Duration = Duration::from_millis(20);
const LEISURE: Duration = Duration::from_millis(150);

/// Returns the default deadlines, with another duration for a second.
fn settings(second: Duration) -> Settings {
    let default = Settings::default();
    let scaled = |time: Duration| second.mul_f64(time.as_secs_f64());
    Settings {
        // The loopback is fast, but a loaded machine may not be.
        connect_timeout: Duration::from_secs(5),
        idle_timeout: scaled(default.idle_timeout),
        request_timeout: scaled(default.request_timeout),
        patience: scaled(default.patience),
        first_pause: Duration::from_millis(2),
        longest_pause: Duration::from_millis(20),
        ..default
    }
}

/// Bakes a COG of several tiles, `height_m` above the sea.
fn file(folder: &Path, name: &str, height_m: f64) -> PathBuf {
    let height = |x: f64, y: f64| {
        let rough = random((x / 10.0).round() as i64, (y / 10.0).round() as i64);
        height_m + 200.0 * (x * 0.002).sin() * (y * 0.0017).cos() + 4.0 * rough
    };
    let path = folder.join(name);
    pyramid::bake(&grid_of(600, 500, 10.0, height), &path, &BakeOptions::default(), &Silent).unwrap();
    path
}

type Picture = Vec<[f32; 4]>;

/// Draws like `render`: returns the picture, or the error in one line.
fn picture_of(gpu: &Gpu, store: Result<Arc<dyn TileStore>, String>) -> Result<Picture, String> {
    let style = Style::load("plain").unwrap();
    let mut world =
        OpenWorld::on_gpu(gpu, scene_of(None, Reach::SceneFolder).unwrap(), store?, TerrainOptions::default()).unwrap();
    let pose = world.pose(&"0,-2500,+300,0,-10,60".parse().unwrap());
    let request = PictureRequest::still(pose, SIZE_PX, &style, world.light());
    let mut picture = Vec::new();
    let take = |band: picture::Band| {
        picture.extend(band.picture);
        Ok::<_, std::convert::Infallible>(())
    };
    let report = picture::render(gpu, &mut None, &mut world.surfaces, &request, take).unwrap();
    match world.surfaces.terrain.failure() {
        Some(failure) => Err(chain(&*failure)),
        None if report.tiles_failed > 0 => Err("tiles failed without an error".into()),
        None => Ok(picture),
    }
}

fn remote(url: &str, settings: Settings) -> Result<Arc<dyn TileStore>, String> {
    pyramid::store::open_remote_with(url, settings, 1 << 20).map(|store| store as _).map_err(|error| chain(&error))
}

fn chain(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(Some(error), |error| error.source());
    causes.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

/// Returns the fault of an outcome, or `None` if it is as expected.
fn fault(expected: Expected, outcome: &Result<Picture, String>, truth: &Picture) -> Option<String> {
    match (expected, outcome) {
        (Expected::Right | Expected::Either, Ok(picture)) if picture == truth => None,
        (_, Ok(picture)) if picture != truth => Some("the picture is wrong".into()),
        (Expected::Error(_), Ok(_)) => Some("it should have failed".into()),
        (Expected::Right, Err(error)) => Some(format!("failed: {error}")),
        (_, Err(error)) if error.contains('\n') => Some(format!("more than one line: {error}")),
        (_, Err(error)) if !error.contains("world.tif") => Some(format!("does not name the file: {error}")),
        (_, Err(error)) if error.contains("file is damaged") => Some(format!("blames the file: {error}")),
        (_, Err(error)) if error.chars().count() > 300 => Some(format!("is long: {error}")),
        (Expected::Error(words), Err(error)) if !error.contains(words) => Some(format!("not {words:?}: {error}")),
        _ => None,
    }
}

/// Calls `work` for all kinds, on several threads.
fn for_all(kinds: &[(&'static str, Expected)], threads: usize, work: impl Fn(&'static str, Expected) + Sync) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((kind, expected)) = kinds.get(next.fetch_add(1, Ordering::Relaxed)) {
                    work(kind, *expected);
                }
            });
        }
    });
}

#[test]
fn whatever_a_server_does() {
    let Some(gpu) = common::gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), "world.tif", 1000.0);
    let bytes = std::fs::read(&path).unwrap();
    let truth = picture_of(&gpu, Ok(pyramid::store::open_local_cog(&path).unwrap().unwrap())).unwrap();
    assert!(KINDS.len() >= 46 && bytes.len() > 400_000, "{} kinds, {} bytes", KINDS.len(), bytes.len());
    let faults = Mutex::new(Vec::new());
    // In the fast tier some of each group: neighbours in the list do similar things.
    let kinds: Vec<_> = KINDS.iter().copied().step_by(if common::full() { 1 } else { 3 }).collect();
    for_all(&kinds, 4, |kind, expected| {
        let second = if matches!(expected, Expected::Error(_)) { HURRY } else { LEISURE };
        let server = Server::start(kind, bytes.clone(), second);
        let start = Instant::now();
        let outcome = picture_of(&gpu, remote(&server.url(), settings(second)));
        let seconds = start.elapsed().as_secs_f64();
        let result = outcome.as_ref().err().map_or("the right picture", String::as_str);
        println!("{seconds:5.1} s, {kind}: {result}");
        faults.lock().unwrap().extend(fault(expected, &outcome, &truth).map(|fault| format!("{kind}: {fault}")));
        if seconds > 30.0 {
            faults.lock().unwrap().push(format!("{kind}: {seconds} s"));
        }
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));

    // Planted: a server that serves another file.
    let other = std::fs::read(file(folder.path(), "other.tif", 1010.0)).unwrap();
    let server = Server::start("as it should be", other, LEISURE);
    let outcome = picture_of(&gpu, remote(&server.url(), settings(LEISURE)));
    assert_eq!(fault(Expected::Either, &outcome, &truth).as_deref(), Some("the picture is wrong"));
}

/// Tests the program itself with its own deadlines.
#[test]
fn the_program_gives_up_in_time() {
    let Ok(chosen) = std::env::var("HACHURE_SERVERS") else {
        println!("skipped: HACHURE_SERVERS=all tries every kind of server with the deadlines of the program");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), "world.tif", 1000.0);
    let bytes = std::fs::read(&path).unwrap();
    let render = |number: usize, world: &str| {
        let out = folder.path().join(format!("{number}.png"));
        let cache = folder.path().join(format!("cache{number}"));
        let output = Command::new(env!("CARGO_BIN_EXE_hachure"))
            .args(["render", world, "--size", "64x36", "--camera", "0,-2500,+300,0,-10,60", "-o"])
            .arg(&out)
            .env("HACHURE_CACHE", cache)
            .env("XDG_RUNTIME_DIR", folder.path())
            .env_remove("RUST_LOG")
            .output()
            .unwrap();
        // The warning that the file has no coordinate reference system is expected.
        let stderr = String::from_utf8_lossy(&output.stderr);
        let said: Vec<_> = stderr.lines().filter(|line| !line.contains("coordinate reference system")).collect();
        (output.status.code(), std::fs::read(out).ok(), said.join("\n"))
    };
    let healthy = Server::start("as it should be", bytes.clone(), Duration::from_secs(1));
    let (code, truth, said) = render(1000, &healthy.url());
    assert_eq!(code, Some(0), "{said}");
    let kinds: Vec<_> = KINDS.iter().copied().filter(|(kind, _)| chosen == "all" || kind.contains(&chosen)).collect();
    let (faults, slowest, number) = (Mutex::new(Vec::new()), Mutex::new(0.0_f64), AtomicUsize::new(0));
    for_all(&kinds, 10, |kind, expected| {
        let server = Server::start(kind, bytes.clone(), Duration::from_secs(1));
        let start = Instant::now();
        let (code, picture, said) = render(number.fetch_add(1, Ordering::Relaxed), &server.url());
        let seconds = start.elapsed().as_secs_f64();
        println!("{seconds:5.1} s, {kind}: {}", if code == Some(0) { "the picture" } else { said.trim_end() });
        let is_right = code == Some(0) && picture == truth && said.is_empty();
        let is_told = code == Some(1) && picture.is_none() && said.lines().count() == 1;
        let is_expected = match expected {
            Expected::Right => is_right,
            Expected::Error(words) => is_told && said.contains(words),
            Expected::Either => is_right || is_told,
        };
        if !is_expected || seconds > 90.0 {
            faults.lock().unwrap().push(format!("{kind}, {seconds:.1} s, status {code:?}: {said}"));
        }
        let mut slowest = slowest.lock().unwrap();
        *slowest = slowest.max(seconds);
    });
    println!("{} kinds, the slowest {:.1} s", kinds.len(), slowest.into_inner().unwrap());
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// Tests that an address is described without drawing or baking.
#[test]
fn the_program_describes_an_address() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), "world.tif", 1000.0);
    let server = Server::start("as it should be", std::fs::read(&path).unwrap(), Duration::from_secs(1));
    let info = |address: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_hachure"))
            .args(["info", address])
            .env("HACHURE_CACHE", folder.path().join("cache"))
            .env_remove("RUST_LOG")
            .output()
            .unwrap();
        let [out, error] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.code(), out, error)
    };
    let (status, text, said) = info(&format!("{}?key=secret", server.url()));
    assert_eq!(status, Some(0), "{said}");
    let line = |text: &str, first: &str| text.lines().find(|line| line.starts_with(first)).map(str::to_owned);
    assert!(text.contains("a DEM on a server") && !text.contains("secret"), "{text}");
    // The same as of the file.
    let (_, of_file, _) = info(&path.to_string_lossy());
    assert!(line(&text, "extent").is_some() && line(&text, "extent") == line(&of_file, "extent"), "{text}{of_file}");
    let (status, _, said) = info(&server.url().replace("http://", "http://127.0.0.1:1/?"));
    assert!(status == Some(1) && said.trim_end().lines().count() == 1, "{said}");
}
