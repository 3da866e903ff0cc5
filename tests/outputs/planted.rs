//! Tests that files of a user in every folder that hachure writes to stay as they are: cache, outputs, sheets, frames,
//! bakes, reports.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use hachure::internals::own_cache_folder;

use crate::place::{PATH, Place, has_gpu};

/// The bytes, the mode and the time of change of each file.
type Seen = BTreeMap<PathBuf, (Vec<u8>, u64, u32, SystemTime)>;

/// Files of a user, by the name of the output that they are in the way of: one each, since the first one is refused.
const IN_THE_WAY: [(&str, &str); 9] = [
    ("parcels.png", "out/parcels.pgw"),
    ("fields.png", "out/fields.png.aux.xml"),
    ("po.png", "out/po-B2.png"),
    ("po.svg", "out/po-A1.svg"),
    ("f%d.png", "out/f1.png"),
    ("y.tif", "out/y.tif.tiles"),
    ("z.tif", "out/.z.tif.tiles.next"),
    ("parts.tif", "out/parts.tif.parts/ubuntu.iso.part"),
    ("bench", "out/bench/frames.csv"),
];

/// Files of a user that are in nobody's way, though hachure has similar names.
const ASIDE: [&str; 15] = [
    "out/parcels.prj",
    "out/a.pgw",
    "out/a-A1.png",
    "out/.a.png.4711.part",
    "out/.a.png.abcdefABCDEF.part",
    "out/notes.part",
    "out/a.tif.tiles",
    "out/.b.tif.lock",
    "cache/my_country_dem.tif",
    "cache/my_country_dem.tif.tiles",
    "cache/ubuntu.iso.part",
    "own/my_dem.tif",
    "own/my.0123456789abcdef.tif",
    "own/notes.part",
    "own/marks/mine.tam",
];

fn at(place: &Place, name: &str) -> PathBuf {
    match name.strip_prefix("own/") {
        Some(name) => own_cache_folder(&place.path("cache")).unwrap().join(name),
        None => place.path(name),
    }
}

/// Writes the files of a user, all long unused, and one so large that a cache would have to be trimmed.
fn plant(place: &Place, names: impl Iterator<Item = &'static str>) -> Vec<PathBuf> {
    let used = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
    let plant = |name: &str| {
        let path = at(place, name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        hachure::file::atomic::write(&path, format!("{name} of the user").as_bytes()).unwrap();
        let file = fs::File::options().append(true).open(&path).unwrap();
        if name == "cache/my_country_dem.tif" {
            file.set_len(9 << 30).unwrap();
        }
        #[cfg(unix)]
        fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o640)).unwrap();
        file.set_modified(used).unwrap();
        path
    };
    names.map(plant).collect()
}

fn seen(paths: &[PathBuf]) -> Seen {
    let see = |path: &PathBuf| {
        let (file, metadata) = (fs::File::open(path).ok()?, path.symlink_metadata().ok()?);
        let mut bytes = Vec::new();
        file.take(4096).read_to_end(&mut bytes).unwrap();
        #[cfg(unix)]
        let mode = std::os::unix::fs::MetadataExt::mode(&metadata);
        #[cfg(not(unix))]
        let mode = u32::from(metadata.permissions().readonly());
        Some((path.clone(), (bytes, metadata.len(), mode, metadata.modified().unwrap())))
    };
    paths.iter().filter_map(see).collect()
}

fn changed(before: &Seen, after: &Seen) -> Vec<PathBuf> {
    before.iter().filter(|(path, state)| after.get(*path) != Some(state)).map(|(path, _)| path.clone()).collect()
}

/// Returns the commands that write to the outputs of [`IN_THE_WAY`], each with its output.
fn commands() -> [(&'static str, &'static str); 9] {
    [
        ("fields.png", "render dem.tif --size 64x36 --style plain --map -o out/fields.png"),
        ("parcels.png", "render dem.tif --size 64x36 --style plain --map -o out/parcels.png"),
        ("po.png", "render dem.tif --style plain --paper a6 --dpi 96 --sheets 105x74 --sheets-overlap 2 -o out/po.png"),
        (
            "po.svg",
            "render dem.tif --style strokes --paper a6 --dpi 96 --sheets 105x74 --sheets-overlap 2 -o out/po.svg",
        ),
        ("f%d.png", "render dem.tif --size 32x18 --style plain --path path.csv --fps 2 -o out/f%d.png"),
        ("y.tif", "bake dem.tif -o out/y.tif"),
        ("z.tif", "bake dem.tif -o out/z.tif"),
        ("parts.tif", "bake dem.tif --shard 1/1 -o out/parts.tif"),
        ("bench", "bench dem.tif --path path.csv --size 32x18 --styles plain --frames 2 --temporal 0 -o out/bench"),
    ]
}

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

#[test]
fn files_of_a_user_stay_as_they_are() {
    if !has_gpu() {
        return;
    }
    let place = Place::empty();
    place.geotiff("dem.tif", 0);
    place.heightmap("heights.png");
    place.file("path.csv", PATH);
    let aside = plant(&place, ASIDE.into_iter());
    let in_the_way = plant(&place, IN_THE_WAY.iter().map(|(_, name)| *name));
    let all: Vec<PathBuf> = aside.iter().chain(&in_the_way).cloned().collect();
    let before = seen(&all);
    assert_eq!(before.len(), all.len());
    let unchanged = |line: &str| assert_eq!(changed(&before, &seen(&all)), [] as [&Path; 0], "{line}");
    // Commands whose outputs are free succeed, and bake into the cache.
    for line in [
        "render heights.png --size 32x18 --style ink -o out/a.png",
        "bake dem.tif -o out/b.tif",
        "info out/b.tif",
        "styles check out/none.toml",
    ] {
        let output = place.run(&words(line));
        assert!(output.status.success() != line.contains("none"), "{line}: {output:?}");
        unchanged(line);
    }
    let mut cached = fs::read_dir(at(&place, "own/")).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(cached.any(|name| name.to_string_lossy().starts_with("heights.")), "nothing was cached");
    // Others are refused, and name the file.
    for (output, line) in commands() {
        let refused = place.run(&words(line));
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!((refused.status.code(), said.matches("hachure: ").count()), (Some(1), 1), "{line}: {said}");
        let named = IN_THE_WAY.iter().filter(|(of, _)| *of == output).any(|(_, name)| {
            said.contains(name)
                || said.contains(Path::new(name).parent().unwrap().to_str().unwrap()) && output == "parts.tif"
        });
        assert!(named, "{line}: {said}");
        unchanged(line);
    }
    // Planted: with --overwrite, files are replaced, which the same comparison finds.
    for (output, line) in
        commands().into_iter().filter(|(output, _)| ["parcels.png", "f%d.png", "y.tif"].contains(output))
    {
        place.text(&words(&format!("{line} --overwrite")));
        let mine: Vec<PathBuf> =
            IN_THE_WAY.iter().filter(|(of, _)| *of == output).map(|(_, name)| place.path(name)).collect();
        let found = changed(&before, &seen(&all));
        assert!(!mine.is_empty() && mine.iter().all(|path| found.contains(path)), "{line}: {found:?}");
        // What hachure wrote, it may replace.
        place.text(&words(line));
    }
}

/// Tests that a picture that is being written goes away with the program, if somebody ends it.
#[cfg(target_os = "linux")]
#[test]
fn a_run_that_is_ended_leaves_no_file() {
    use std::process::Command;
    use std::time::Instant;
    if !has_gpu() {
        return;
    }
    let place = Place::empty();
    place.geotiff("dem.tif", 0);
    place.file("out/mine.part", "mine");
    let names = || fs::read_dir(place.path("out")).unwrap().map(|it| it.unwrap().file_name()).collect::<Vec<_>>();
    // A quick machine may finish the picture before the signal arrives.
    let tries = ["INT", "TERM", "HUP"].into_iter().flat_map(|signal| (0..5).map(move |attempt| (signal, attempt)));
    let mut ended = std::collections::BTreeSet::new();
    for (signal, _) in tries {
        if ended.contains(signal) {
            continue;
        }
        let line = "render dem.tif --size 4000x3000 --style plain -o out/a.png";
        let mut child = place.command(&words(line)).spawn().unwrap();
        let start = Instant::now();
        while names().len() < 2 {
            assert!(
                start.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none(),
                "nothing is written"
            );
            std::thread::sleep(Duration::from_millis(2));
        }
        assert!(
            Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap().success()
        );
        let status = child.wait().unwrap();
        if status.success() {
            fs::remove_file(place.path("out/a.png")).unwrap();
            continue;
        }
        assert!(status.code().is_none(), "{signal}: {status:?}");
        assert_eq!(names(), ["mine.part"], "{signal}");
        ended.insert(signal);
    }
    assert_eq!(ended.len(), 3, "only these ended the program before it was done: {ended:?}");
}

/// Tests that ffmpeg ends with hachure, even if hachure is killed.
#[cfg(target_os = "linux")]
#[test]
fn ffmpeg_ends_with_hachure() {
    use std::process::Command;
    use std::time::Instant;
    if !has_gpu() {
        return;
    }
    let place = Place::empty();
    place.geotiff("dem.tif", 0);
    place.file("path.csv", PATH);
    // Another process writes the script, as in `src/tests/files.rs`.
    let script = "#!/bin/sh\necho $$ >\"$(dirname \"$0\")/pid\"\ncat >/dev/null\nsleep 1000\n";
    fs::create_dir(place.path("bin")).unwrap();
    let write = "printf '%s' \"$1\" >\"$0\" && chmod 755 \"$0\"";
    assert!(
        Command::new("sh").args(["-c", write]).arg(place.path("bin/ffmpeg")).arg(script).status().unwrap().success()
    );
    let path = format!("{}:{}", place.path("bin").display(), std::env::var("PATH").unwrap());
    let arguments = words("render dem.tif --size 32x18 --style plain --path path.csv --fps 2 -o film.mp4");
    // A process that has ended may stay as a zombie, which nobody has waited for.
    let is_alive = |pid: &str| {
        let stat = fs::read_to_string(format!("/proc/{}/stat", pid.trim())).unwrap_or_default();
        stat.rsplit_once(") ").is_some_and(|(_, rest)| !rest.starts_with('Z'))
    };
    for signal in ["-TERM", "-KILL"] {
        let mut child = place.command(&arguments).env("PATH", &path).spawn().unwrap();
        let (start, patience) = (Instant::now(), Duration::from_secs(60));
        while !fs::read_to_string(place.path("bin/pid")).is_ok_and(|pid| pid.ends_with('\n')) {
            assert!(start.elapsed() < patience && child.try_wait().unwrap().is_none(), "ffmpeg was not started");
            std::thread::sleep(Duration::from_millis(5));
        }
        let pid = fs::read_to_string(place.path("bin/pid")).unwrap();
        fs::remove_file(place.path("bin/pid")).unwrap();
        // Planted: while hachure runs, ffmpeg does too.
        assert!(is_alive(&pid));
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert!(!child.wait().unwrap().success());
        let start = Instant::now();
        while is_alive(&pid) {
            assert!(start.elapsed() < patience, "{signal}: ffmpeg is an orphan");
            std::thread::sleep(Duration::from_millis(5));
        }
        let left = || fs::read_dir(place.root()).unwrap().flatten().map(|it| it.file_name().into_string().unwrap());
        while left().any(|name| name.contains("film")) {
            assert!(start.elapsed() < patience, "{signal}: {:?}", left().collect::<Vec<_>>());
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}
