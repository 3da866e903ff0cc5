//! `hachure bake` as a process: killed, interrupted, resumed, and split between processes.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use geotiff_writer::GeoTiffBuilder;
use hachure::internals::sidecar_path;
use hachure::pyramid::Pyramid;
use ndarray::Array2;
use serde_json::Value;

use crate::world;

/// A folder with a DEM of many small chunks.
struct Place {
    folder: tempfile::TempDir,
    /// Number of chunks of 512 × 512 samples.
    chunks: usize,
}

impl Place {
    /// Writes a DEM of 4 × 3 chunks, in the long tier of 5 × 4.
    fn new() -> Self {
        if crate::full() { Self::of([2201, 1801]) } else { Self::of([1601, 1101]) }
    }

    fn of([width, height]: [u32; 2]) -> Self {
        let chunks = width.div_ceil(512) * height.div_ceil(512);
        let place = Self { folder: tempfile::tempdir().unwrap(), chunks: chunks as usize };
        let grid = world::rough(width, height, true);
        let heights = Array2::from_shape_vec((height as usize, width as usize), grid.heights_m).unwrap();
        let dem = GeoTiffBuilder::new(width, height).epsg(32610).pixel_scale(10.0, 10.0);
        let dem = dem.origin(590_000.0, 5_200_000.0);
        dem.write_2d(place.path("dem.tif"), heights.view()).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, out: &str, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hachure"));
        command.current_dir(self.folder.path()).args(["bake", "dem.tif", "-o", out, "--chunk-levels", "1", "--json"]);
        command.args(more).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn spawn(&self, out: &str, more: &[&str]) -> Child {
        self.command(out, more).spawn().unwrap()
    }

    fn run(&self, out: &str, more: &[&str]) -> Output {
        self.command(out, more).output().unwrap()
    }

    fn done(&self, out: &str, more: &[&str]) -> Value {
        let output = self.run(out, more);
        assert!(output.status.success(), "{output:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn failed(&self, out: &str, more: &[&str]) -> String {
        let output = self.run(out, more);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
        said
    }

    fn bytes(&self, out: &str) -> [Vec<u8>; 2] {
        [fs::read(self.path(out)).unwrap(), fs::read(sidecar_path(&self.path(out))).unwrap()]
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn parts(&self, out: &str) -> Vec<PathBuf> {
        let Ok(entries) = fs::read_dir(self.path(&format!("{out}.parts"))) else { return Vec::new() };
        let paths = entries.map(|entry| entry.unwrap().path());
        let is_part = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().starts_with("round");
        let mut paths: Vec<PathBuf> = paths.filter(is_part).collect();
        paths.sort();
        paths
    }
}

#[test]
fn killed_at_any_time_it_goes_on() {
    let place = Place::new();
    let start = Instant::now();
    let undisturbed = place.done("new.tif", &[]);
    let whole = start.elapsed();
    assert_eq!(undisturbed["resumed_chunks"], 0);
    let new = place.bytes("new.tif");
    place.done("old.tif", &["--max-error", "1"]);
    let old = place.bytes("old.tif");
    let (mut resumed, mut killed) = (0, 0);
    let runs: u32 = if crate::full() { 14 } else { 4 };
    for i in 0..runs {
        fs::copy(place.path("old.tif"), place.path("out.tif")).unwrap();
        fs::copy(sidecar_path(&place.path("old.tif")), sidecar_path(&place.path("out.tif"))).unwrap();
        let mut child = place.spawn("out.tif", &[]);
        // The delays cover the whole time of the bake, in mixed order.
        std::thread::sleep(whole.mul_f64(f64::from(i * 5 % runs) / (f64::from(runs) - 1.5)));
        killed += i32::from(child.try_wait().unwrap().is_none());
        child.kill().unwrap();
        child.wait().unwrap();
        let tif = fs::read(place.path("out.tif")).unwrap();
        assert!(tif == old[0] || tif == new[0], "the output is neither the old nor the new pyramid");
        let open = Pyramid::open(&place.path("out.tif")).unwrap();
        assert_eq!(open.max_error_m(), if tif == old[0] { 1.0 } else { 0.01 });
        drop(open);
        resumed += place.done("out.tif", &["--resume"])["resumed_chunks"].as_u64().unwrap();
        assert!(place.bytes("out.tif") == new, "a resumed bake differs");
        assert!(!place.path("out.tif.parts").exists());
    }
    let (min_killed, min_resumed) = if crate::full() { (5, 20) } else { (1, 3) };
    assert!(killed > min_killed && resumed > min_resumed, "{killed} killed, {resumed} chunks resumed");
    // Outside the work folder, a killed process leaves no partial files.
    let expected = ["dem.tif", "new.tif", "new.tif.tiles", "old.tif", "old.tif.tiles", "out.tif", "out.tif.tiles"];
    assert_eq!(place.names(), expected);
}

#[test]
fn shards_make_the_same_pyramid() {
    let place = Place::new();
    place.done("whole.tif", &[]);
    let shards: Vec<Child> =
        ["1/3", "2/3", "3/3"].iter().map(|shard| place.spawn("out.tif", &["--shard", shard])).collect();
    let mut chunks = 0;
    for shard in shards {
        let output = shard.wait_with_output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["resumed_chunks"], 0);
        chunks += report["chunks"].as_u64().unwrap();
    }
    assert_eq!(chunks, place.chunks as u64);
    assert!(!place.path("out.tif").exists());
    assert_eq!(place.parts("out.tif").len(), place.chunks);
    // One part is missing and one is damaged: both are baked again.
    let parts = place.parts("out.tif");
    fs::remove_file(&parts[3]).unwrap();
    let mut bytes = fs::read(&parts[7]).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&parts[7], bytes).unwrap();
    let report = place.done("out.tif", &["--resume"]);
    assert_eq!(report["resumed_chunks"], place.chunks - 2);
    assert!(place.bytes("out.tif") == place.bytes("whole.tif"));
    assert!(!place.path("out.tif.parts").exists());
}

#[test]
fn parts_of_another_bake_are_refused() {
    let place = Place::new();
    place.done("out.tif", &["--shard", "1/4"]);
    let said = place.failed("out.tif", &["--resume", "--max-error", "0.5"]);
    assert!(said.contains("out.tif.parts") && said.contains("another bake"), "{said}");
    assert!(place.failed("out.tif", &["--shard", "2/4", "--max-error", "0.5"]).contains("another bake"));
    let of_shard = place.chunks / 4;
    assert_eq!(place.parts("out.tif").len(), of_shard);
    // The work folder of another output, and a folder that is not a work folder.
    fs::rename(place.path("out.tif.parts"), place.path("other.tif.parts")).unwrap();
    assert!(place.failed("other.tif", &[]).contains("another pyramid"));
    fs::create_dir(place.path("mine.tif.parts")).unwrap();
    fs::write(place.path("mine.tif.parts/letter.txt"), "dear").unwrap();
    assert!(place.failed("mine.tif", &[]).contains("not a work folder"));
    assert!(place.path("mine.tif.parts/letter.txt").exists());
    // A part under the name of another part does not count.
    fs::rename(place.path("other.tif.parts"), place.path("out.tif.parts")).unwrap();
    let parts = place.parts("out.tif");
    fs::copy(&parts[0], &parts[1]).unwrap();
    assert_eq!(place.done("out.tif", &["--resume"])["resumed_chunks"], of_shard - 1);
    // Without --resume, stale parts are replaced.
    place.done("out.tif", &["--shard", "1/4"]);
    assert_eq!(place.done("out.tif", &["--max-error", "0.5"])["resumed_chunks"], 0);
    assert!(!place.path("out.tif.parts").exists());
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_with_one_line() {
    let place = Place::new();
    let child = place.spawn("out.tif", &[]);
    let begun = Instant::now();
    while place.parts("out.tif").len() < 3 && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let stopped = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert!(stopped.elapsed() < Duration::from_secs(30), "{:?}", stopped.elapsed());
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.lines().count() == 1 && said.contains("stopped") && said.contains("--resume"), "{said}");
    assert!(!place.path("out.tif").exists());
    assert!(place.done("out.tif", &["--resume"])["resumed_chunks"].as_u64().unwrap() >= 3);
}

#[test]
fn two_bakes_to_one_output_do_not_mix() {
    // The first bake must last while others are refused.
    let place = Place::of([2201, 1801]);
    let first = place.spawn("out.tif", &[]);
    let begun = Instant::now();
    while place.parts("out.tif").is_empty() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    for more in [&[][..], &["--shard", "1/2"], &["--resume"]] {
        let said = place.failed("out.tif", more);
        assert!(said.contains("out.tif: another process is baking it"), "{said}");
    }
    // Planted: the bake of another output is none of its business.
    let mut other = place.spawn("other.tif", &[]);
    while place.parts("other.tif").is_empty() && begun.elapsed() < Duration::from_secs(60) {
        assert!(other.try_wait().unwrap().is_none(), "{:?}", other.wait_with_output());
        std::thread::sleep(Duration::from_millis(5));
    }
    other.kill().unwrap();
    other.wait().unwrap();
    assert!(first.wait_with_output().unwrap().status.success());
    drop(Pyramid::open(&place.path("out.tif")).unwrap());
    assert!(!place.path("out.tif.parts").exists() && !place.path(".out.tif.lock").exists());
}
