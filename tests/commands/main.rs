//! The program as scripts use it: exit statuses, one-line errors, and what the commands print and write.

#![allow(clippy::unwrap_used, reason = "a panic fails the test, in helpers too")]

mod bench;
mod dem;
mod describe;
mod embedded;
mod eyes;
mod features;
mod films;
mod in_view;
mod land;
mod lone_models;
mod models;
mod names;
mod places;
mod quality;
mod quiet;
mod shells;
mod show;
mod styles;
mod suites;
mod svg;
mod sweeps;
mod tour;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hachure::file::atomic;
use serde_json::Value;

/// A temporary folder and the cache of the runs in it.
pub struct Place {
    folder: tempfile::TempDir,
    /// The cache, which need not exist.
    pub cache: PathBuf,
}

impl Place {
    /// Creates an empty folder with its own cache.
    pub fn empty() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let cache = folder.path().join("cache");
        Self { folder, cache }
    }

    /// Creates an empty folder whose cache has the land of the built-in scenes. Other tests and other test programs
    /// share that cache, since generating the land takes longer than most tests.
    pub fn with_built_in_land() -> Self {
        Self { cache: Path::new(env!("CARGO_TARGET_TMPDIR")).join("built-in-land"), ..Self::empty() }
    }

    /// Returns the path of a file in the folder, which need not exist.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a text file and returns its path.
    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        atomic::write(&path, text.as_bytes()).unwrap();
        path
    }

    /// Runs the program in the folder.
    pub fn hachure(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_hachure"))
            .args(arguments)
            .current_dir(self.folder.path())
            .env("HACHURE_CACHE", &self.cache)
            // As without a desktop, so that Mesa prints no warning.
            .env_remove("XDG_RUNTIME_DIR")
            .env_remove("RUST_LOG")
            .output()
            .unwrap()
    }

    /// Runs the program, which must succeed; returns its standard output.
    pub fn text(&self, arguments: &[&str]) -> String {
        let output = self.hachure(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs the program, which must succeed; parses its standard output as JSON.
    pub fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.text(arguments)).unwrap()
    }

    /// Runs the program, which must fail (exit status 1); returns its one-line error.
    pub fn error(&self, arguments: &[&str]) -> String {
        self.line(arguments, 1)
    }

    /// Runs the program, which must refuse its arguments (exit status 2); returns its one-line error.
    pub fn misuse(&self, arguments: &[&str]) -> String {
        self.line(arguments, 2)
    }

    fn line(&self, arguments: &[&str], status: i32) -> String {
        let output = self.hachure(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty(), "{arguments:?} printed {}", String::from_utf8_lossy(&output.stdout));
        let line = error.trim_end().strip_prefix("hachure: ").unwrap_or_else(|| panic!("{arguments:?}: {error}"));
        assert_eq!(line.lines().count(), 1, "{arguments:?}: {error}");
        line.to_owned()
    }

    /// Returns the names in the folder, without the cache.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).filter(|it| it != "cache").collect();
        names.sort();
        names
    }
}

/// Returns whether the long tier of the tests is wanted (`./check --full`).
pub fn full() -> bool {
    std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full")
}

fn checked_in(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).to_str().unwrap().to_owned()
}

#[test]
fn misuse_exits_with_2() {
    let place = Place::empty();
    for arguments in [
        &["info"][..],
        &["paint", "mountain.tif"],
        &["bake", "a.tif"],
        &["bake", "-o", "b.tif"],
        &["bake", "a.tif", "-o", "b.tif", "--max-error", "-1"],
        &["bake", "a.tif", "-o", "b.tif", "--max-error", "NaN"],
        &["bake", "a.tif", "-o", "b.tif", "--shard", "0/2"],
        &["bake", "a.tif", "-o", "b.tif", "--shard", "3/2"],
        &["bench", "-o", "out"],
        &["bench", "--path", "p.csv", "-o", "out", "--frames", "0"],
        &["bench", "--path", "p.csv", "-o", "out", "--size", "10"],
        &["bench", "--path", "p.csv", "-o", "out", "--eyes", "three"],
        &["bench", "--path", "p.csv", "-o", "out", "--ipd", "0.1"],
        &["bench", "--path", "p.csv", "-o", "out", "--sweep", "size"],
        &["styles", "paint"],
    ] {
        let output = place.hachure(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
    assert!(place.names().is_empty(), "{:?}", place.names());
}

#[test]
fn failures_are_one_line_that_names_the_file() {
    let place = Place::empty();
    place.file("notes.md", "# heights\n");
    place.file("empty.tif", "");
    place.file("broken.toml", "name = \"x\"\n[lines\n");
    place.file("other.toml", "[package]\nname = \"x\"\n");
    place.file("scene.toml", "[world]\ndem = \"a.tif\"\n[sun]\nelevation_deg = 99\n");
    place.file("path.csv", "t,x,y,z,yaw,pitch,fov\n0,0,0,+10,0,0,50\n1,0,0,here,0,0,50\n");
    place.file("twice.csv", "t,x,y,z,yaw,pitch,fov\n0,0,0,+10,0,0,50\n0,0,0,+10,0,0,50\n");
    place.file("good.csv", "t,x,y,z,yaw,pitch,fov\n0,0,0,+10,0,0,50\n");
    for (arguments, name, cause) in [
        (&["info", "nowhere.tif"][..], "nowhere.tif", "cannot be opened: there is no such file"),
        (&["info", "none"], "none", "there is no such file"),
        (&["info", "notes.md"], "notes.md", "text file"),
        (&["info", "empty.tif"], "empty.tif", "empty"),
        (&["info", "broken.toml"], "broken.toml:2", ""),
        (&["info", "other.toml"], "other.toml", "neither a scene"),
        (&["info", "scene.toml"], "scene.toml", "sun.elevation_deg"),
        (&["info", "path.csv"], "path.csv:3", "here"),
        (&["bake", "nowhere.tif", "-o", "out.tif"], "nowhere.tif", "cannot be opened: there is no such file"),
        (&["bake", "notes.md", "-o", "out.tif"], "notes.md", "text file"),
        (&["bake", "empty.tif", "-o", "nowhere/out.tif"], "out.tif", "no folder"),
        (&["bake", "empty.tif", "notes.md", "-o", "out.tif"], "empty.tif", "empty"),
        (&["bake", "empty.tif", "-o", "out.tif", "--shard", "1/2"], "empty.tif", "empty"),
        (&["bench", "--path", "nowhere.csv", "-o", "out"], "nowhere.csv", "there is no such file"),
        (&["bench", "--path", "path.csv", "-o", "out"], "path.csv:3", "here"),
        (&["bench", "--path", "good.csv", "-o", "notes.md"], "notes.md", "is a file, and bench writes"),
        (&["info", "twice.csv"], "twice.csv:3", "t is 0 again; a jump is two rows with equal t, and not the first two"),
        (&["styles", "check", "nowhere.toml"], "nowhere.toml", "cannot read the style: there is no such file"),
        (&["styles", "check", "broken.toml"], "broken.toml:2:", ""),
    ] {
        let line = place.error(arguments);
        assert!(line.contains(name) && line.contains(cause), "{arguments:?}: {line}");
    }
    for (arguments, name, cause) in [
        (&["bake", "empty.tif", "-o", "out.png"][..], "out.png", "must end with .tif"),
        (&["bench", "--path", "good.csv", "-o", "out", "--styles", "ink,oil"], "oil", "no such style"),
        (&["bench", "--path", "good.csv", "-o", "out", "--lod-error", "0"], "--lod-error", "above 0"),
        (&["styles", "show", "oil"], "oil", "no such style"),
    ] {
        let line = place.misuse(arguments);
        assert!(line.contains(name) && line.contains(cause), "{arguments:?}: {line}");
    }
    assert!(place.names().iter().all(|name| !name.starts_with("out")), "{:?}", place.names());
}

#[test]
fn styles_are_listed_shown_and_checked() {
    let place = Place::with_built_in_land();
    let listed = place.json(&["styles", "--json"]);
    assert_eq!(listed, place.json(&["styles", "list", "--json"]));
    let listed = listed.as_array().unwrap();
    assert!(listed.iter().any(|style| style["name"] == "ink"));
    let text = place.text(&["styles"]);
    let step = if full() { 1 } else { 6 };
    for style in listed.iter().step_by(step) {
        let [name, description] = ["name", "description"].map(|key| style[key].as_str().unwrap());
        assert!(text.lines().any(|line| line.starts_with(name) && line.ends_with(description)), "{text}");
        // The printed style is valid as a file of any name.
        let shown = place.text(&["styles", "show", name]);
        let file = place.file(&format!("{name}.mine"), &shown);
        assert!(place.text(&["styles", "check", file.to_str().unwrap()]).trim_end().ends_with(": valid"));
        let info = place.json(&["info", file.to_str().unwrap(), "--json"]);
        assert_eq!((&info["kind"], &info["name"]), (&"style".into(), &name.into()));
        let draws: Vec<_> = info["draws"].as_array().unwrap().iter().map(|part| part.as_str().unwrap()).collect();
        assert_eq!(draws.contains(&"lines by lsa"), shown.contains("detector = \"lsa\""), "{name}: {draws:?}");
        assert!(draws.iter().any(|part| part.ends_with(" shading")), "{name}: {draws:?}");
    }
    // The styles of the benchmarks are valid too.
    for file in fs::read_dir(checked_in("benches/styles")).unwrap().step_by(step) {
        let file = file.unwrap().path();
        assert!(place.text(&["styles", "check", file.to_str().unwrap()]).trim_end().ends_with(": valid"));
    }
    let wrong = place.text(&["styles", "show", "lsa"]).replace("ramp", "slope");
    assert!(place.error(&["styles", "check", place.file("wrong.toml", &wrong).to_str().unwrap()]).contains("slope"));

    // Unknown marks are reported before anything is drawn.
    let hatched = place.text(&["styles", "show", "stipple"]);
    let unknown = place.file("unknown.toml", &hatched.replace("\"dots\"\nsize", "\"spots\"\nsize"));
    assert!(place.error(&["styles", "check", unknown.to_str().unwrap()]).contains("spots"));
    place.file("stack.toml", "description = \"\"\nkind = \"stack\"\nimages = [\"light.png\"]\n");
    let stack = place.file("mine.toml", &hatched.replace("\"dots\"\nsize", "\"stack.toml\"\nsize"));
    let out = place.path("x.png");
    let render = ["render", "-o", out.to_str().unwrap(), "--style", stack.to_str().unwrap()];
    for arguments in [&["styles", "check", stack.to_str().unwrap()][..], &render[..]] {
        assert!(place.error(arguments).contains("light.png"));
    }
    assert!(!out.exists());
}

#[test]
fn info_describes_scenes_and_paths() {
    let place = Place::empty();
    place.file("scene", "[world]\nprocedural = { seed = 4 }\n[sun]\nazimuth_deg = 100\n");
    let scene = place.json(&["info", "scene", "--json"]);
    assert_eq!(scene["kind"], "scene");
    assert_eq!((&scene["procedural_seed"], &scene["dem"]), (&4.into(), &Value::Null));
    assert_eq!((&scene["sun_azimuth_deg"], &scene["haze_distance_m"]), (&100.0.into(), &Value::Null));
    place.file("path", "# a flight\nt,x,y,z,yaw,pitch,fov\n1,0,0,+10,0,0,50\n3,300,400,90,0,0,50\n");
    let path = place.json(&["info", "path", "--json"]);
    assert_eq!(path["kind"], "camera-path");
    assert_eq!((&path["rows"], &path["duration_s"], &path["frames_at_30_fps"]), (&2.into(), &2.0.into(), &61.into()));
    assert!((path["ground_length_m"].as_f64().unwrap() - 500.0).abs() < 1e-6);
    assert!(place.text(&["info", "path"]).starts_with("path: a camera path\n"));
}
