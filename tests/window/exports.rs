//! Every kind of export: a person fills in the dialog, and what the window writes is what the shown command line writes.

use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::display::{Display, Running, can_run, hachure, is_full, open_with, until};
use crate::drawn::{self, Check, SIZE_PX};
use crate::person::Person;

/// A camera path of one second.
pub(crate) const PATH: &str = "t,x,y,z,yaw,pitch,fov\n0,0,-3000,+700,0,-12,45\n1,200,-2600,+650,10,-14,50\n";

/// An export: what the person does in the dialog, and what is written.
struct Case {
    /// The button of the kind.
    kind: &'static str,
    /// The folder of the files.
    folder: &'static str,
    /// The ending that the kind begins with.
    ending: &'static str,
    /// Options that the person changes. The name of the output is there already.
    fill: fn(&Person<'_>),
    /// Arguments that the command line then has.
    option: &'static str,
    /// The output in the end.
    output: &'static str,
    check: Check,
}

/// The exports of the fast tier, and then those that only `HACHURE_TESTS=full` makes.
const CASES: ([Case; 3], [Case; 9]) = (
    [
        Case {
            kind: "Picture",
            folder: "picture",
            ending: "png",
            fill: |person| person.fill("SpinButton", "Samples per pixel", "4"),
            option: "--samples=4",
            output: "a.png",
            check: drawn::picture,
        },
        Case {
            kind: "Lines (SVG, PDF)",
            folder: "svg",
            ending: "svg",
            fill: |person| person.click("Button", "2 pens"),
            option: "--pens=2",
            output: "a.svg",
            check: drawn::svg,
        },
        Case {
            kind: "Film",
            folder: "frames",
            ending: "mp4",
            fill: |person| {
                person.fill("TextInput", "Camera path of the film", "path.csv");
                person.fill("SpinButton", "Frames per second", "4");
                person.click("Button", "frames");
            },
            option: "--fps=4",
            output: "a/%05d.png",
            check: drawn::frames,
        },
    ],
    [
        Case {
            kind: "Film",
            folder: "gif",
            ending: "mp4",
            fill: |person| person.click("Button", ".gif"),
            option: "--path=path.csv",
            output: "a.gif",
            check: drawn::gif,
        },
        Case {
            kind: "EXR channels",
            folder: "exr",
            ending: "exr",
            fill: |person| person.click("CheckBox", "position"),
            option: "--aov=depth,position,normal",
            output: "a.exr",
            check: drawn::exr,
        },
        Case {
            kind: "Map",
            folder: "tif",
            ending: "tif",
            fill: |_| {},
            option: "--map=whole",
            output: "a.tif",
            check: drawn::geotiff,
        },
        Case {
            kind: "Map",
            folder: "map",
            ending: "tif",
            fill: |person| person.click("Button", ".png"),
            option: "--map=whole",
            output: "a.png",
            check: drawn::map_png,
        },
        Case {
            kind: "Map",
            folder: "geojson",
            ending: "tif",
            fill: |person| {
                person.click("Button", ".geojson");
                person.click("CheckBox", "Longitudes and latitudes (WGS 84)");
            },
            option: "--wgs84",
            output: "a.geojson",
            check: drawn::geojson,
        },
        Case {
            kind: "Stereo",
            folder: "stereo",
            ending: "png",
            fill: |_| {},
            option: "--eyes=side-by-side",
            output: "a.png",
            check: drawn::pair,
        },
        Case {
            kind: "Lines (SVG, PDF)",
            folder: "pdf",
            ending: "svg",
            fill: |person| {
                person.click("Button", ".pdf");
                person.click("Button", "paper");
                person.fill("TextInput", "Paper", "a6");
            },
            option: "--paper=a6",
            output: "a.pdf",
            check: drawn::pdf,
        },
        Case {
            kind: "Poster sheets",
            folder: "sheets",
            ending: "png",
            fill: |person| {
                person.fill("TextInput", "Paper", "120x90");
                person.fill("SpinButton", "Dots per inch", "40");
                person.fill("TextInput", "Paper of the sheets", "80x80");
            },
            option: "--sheets=80x80",
            output: "a.png",
            check: drawn::sheets,
        },
        Case {
            kind: "Picture",
            folder: "jpg",
            ending: "png",
            fill: |person| {
                person.click("Button", ".jpg");
                person.fill("TextInput", "Paper", "60x60");
                person.fill("SpinButton", "Dots per inch", "100");
                person.fill("TextInput", "Title below the picture", "My hill");
            },
            option: "'--title=My hill'",
            output: "a.jpg",
            check: drawn::titled_jpg,
        },
    ],
);

/// A person with the export dialog in front of them.
pub(crate) struct Exporter<'a> {
    pub(crate) person: Person<'a>,
    pub(crate) folder: &'a Path,
}

impl<'a> Exporter<'a> {
    /// Opens a window on the DEM `cone.tif`.
    pub(crate) fn open(display: &'a Display, folder: &'a Path) -> (Running, Self) {
        // The window writes it all the time: it must not be among the files of an export.
        std::fs::create_dir(folder.join("probe")).unwrap();
        let widgets = folder.join("probe/widgets");
        let environment = [("HACHURE_WIDGETS", &*widgets)];
        let arguments = ["--style", "strokes", "--size", "900x640"];
        std::fs::write(folder.join("path.csv"), PATH).unwrap();
        let (program, window) = open_with(display, folder, &environment, &arguments);
        let person = Person { display, window, widgets, frame: Duration::from_millis(50) };
        person.find("ComboBox", "Drawn style");
        // A coarser picture of the window leaves more time for the exports.
        person.keys(&["minus", "minus", "minus"]);
        (program, Self { person, folder })
    }

    /// Returns the command line that the dialog shows, when it writes this output and has this option.
    pub(crate) fn line(&self, output: &str, option: &str) -> String {
        let [output, option] = [format!(" --output={output} "), format!(" {option} ")];
        until(&format!("a command line with{option}and{output}"), || {
            let all = self.person.all();
            let mut lines =
                all.into_iter().map(|widget| widget.value).filter(|line| line.starts_with("hachure render"));
            lines.find(|line| [&output, &option].iter().all(|words| format!("{line} ").contains(*words)))
        })
    }

    /// Waits for the message that an output is written, and dismisses it.
    pub(crate) fn wait_for(&self, output: &str) {
        let wanted = format!("Dismiss: Wrote {}", self.folder.join(output).display());
        let message = until(&wanted, || {
            let found = self.person.beginning("Button", "Dismiss: ")?;
            assert!(found.name.starts_with(&wanted), "{}, not {wanted}", found.name);
            Some(found)
        });
        self.person.click("Button", &message.name);
        until("the dismissed message", || self.person.beginning("Button", "Dismiss: ").is_none().then_some(()));
    }
}

/// Runs a command line for a shell in a folder.
pub(crate) fn run_line(line: &str, folder: &Path, environment: &Path) {
    let programs = environment.join("programs");
    if !programs.exists() {
        std::fs::create_dir(&programs).unwrap();
        std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_hachure"), programs.join("hachure")).unwrap();
    }
    let like = hachure(environment);
    let mut command = Command::new("sh");
    command.args(["-c", line]).current_dir(folder).env("XDG_RUNTIME_DIR", environment);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::env::join_paths(std::iter::once(programs).chain(std::env::split_paths(&path))).unwrap();
    for (name, value) in like.get_envs() {
        value.map(|value| command.env(name, value));
    }
    let output = command.env("PATH", paths).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Returns the files in a folder and below it, with their bytes.
pub(crate) fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        match path.is_dir() {
            true => found.extend(files(&path).into_iter().map(|(inner, bytes)| (name.join(inner), bytes))),
            false => _ = found.insert(name, std::fs::read(&path).unwrap()),
        }
    }
    found
}

/// Says which file of one folder differs from that of another.
pub(crate) fn unlike(a: &BTreeMap<PathBuf, Vec<u8>>, b: &BTreeMap<PathBuf, Vec<u8>>) -> Option<PathBuf> {
    let all: Vec<&PathBuf> = a.keys().chain(b.keys()).collect();
    all.into_iter().find(|path| a.get(*path) != b.get(*path)).cloned()
}

/// Makes an export and runs its command line. Returns the line.
fn export(exporter: &Exporter<'_>, again: &Path, case: &Case) -> String {
    let Case { kind, folder, ending, fill, option, output, check } = case;
    let person = &exporter.person;
    for root in [exporter.folder, again] {
        std::fs::create_dir(root.join(folder)).unwrap();
    }
    person.click("Button", kind);
    person.fill("TextInput", "Path of the output", &format!("{folder}/a.{ending}"));
    fill(person);
    let output = format!("{folder}/{output}");
    let line = exporter.line(&output, option);
    person.click("Button", "Export");
    exporter.wait_for(&output);
    let written = exporter.folder.join(folder);
    assert_eq!(check(&written, 0), Ok(()), "{line}");
    assert!(check(&written, 1).is_err(), "planted: another expectation of {line}");

    run_line(&line, again, exporter.folder);
    let [drawn, mut by_line] = [exporter.folder, again].map(|root| files(&root.join(folder)));
    assert!(!drawn.is_empty());
    assert_eq!(unlike(&drawn, &by_line), None, "{line}");
    // Planted errors: one bit of a file, and a file that is missing.
    let last = by_line.keys().next_back().unwrap().clone();
    *by_line.get_mut(&last).unwrap().last_mut().unwrap() ^= 1;
    assert_eq!(unlike(&drawn, &by_line).as_ref(), Some(&last));
    by_line.remove(&last);
    assert_eq!(unlike(&drawn, &by_line).as_ref(), Some(&last));
    line
}

#[test]
fn every_kind_is_exported_as_its_command_line_draws_it() {
    if !can_run() {
        return;
    }
    let [folder, again] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let [folder, again] = [folder.path(), again.path()];
    let display = Display::of_size("900x640x24").expect("Xvfb must start");
    let (mut program, exporter) = Exporter::open(&display, folder);
    for name in ["cone.tif", "path.csv"] {
        std::fs::copy(folder.join(name), again.join(name)).unwrap();
    }
    let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();
    let person = &exporter.person;
    person.keys(&["ctrl+e"]);
    person.fill("SpinButton", "Width in pixels", &SIZE_PX[0].to_string());
    person.fill("SpinButton", "Height in pixels", &SIZE_PX[1].to_string());
    let begun = std::time::Instant::now();
    let (few, more) = &CASES;
    for case in few.iter().chain(more.iter().filter(|_| is_full())) {
        let line = export(&exporter, again, case);
        eprintln!("{:.1} s: {line}", begun.elapsed().as_secs_f64());
        if case.folder == "picture" {
            // Planted: the line of another sun.
            let other = line.replacen("--sun=315,", "--sun=120,", 1);
            assert_ne!(other, line);
            run_line(&other, again, folder);
            let [drawn, by_line] = [folder, again].map(|root| files(&root.join(case.folder)));
            assert_eq!(unlike(&drawn, &by_line), Some(PathBuf::from("a.png")));
            replaces(&exporter);
        }
    }
    assert!(program.0.try_wait().unwrap().is_none(), "{}", printed());
    assert!(!printed().contains("ERROR") && !printed().contains("panicked"), "{}", printed());
}

/// Makes the export of the picture again: over itself, and over a file of the user.
fn replaces(exporter: &Exporter<'_>) {
    let person = &exporter.person;
    let output = "picture/a.png";
    let path = exporter.folder.join(output);
    let drawn = std::fs::read(&path).unwrap();
    // hachure's own drawing is replaced without a question. A file that is written anew is another one.
    let before = path.metadata().unwrap().ino();
    person.click("Button", "Export");
    exporter.wait_for(output);
    assert!(std::fs::read(&path).unwrap() == drawn && path.metadata().unwrap().ino() != before);
    // A file of the user stays until they say that it may go.
    std::fs::write(&path, b"mine").unwrap();
    // The next frame has no line about a drawing that is replaced, so the buttons are elsewhere.
    person.click("TextInput", "Path of the output");
    until("the other line", || {
        let line = "This replaces a picture that hachure drew.";
        person.all().into_iter().all(|widget| widget.value != line).then_some(())
    });
    person.click("Button", "Export");
    person.click("Button", "Keep it");
    until("the end of the question", || person.see("Button", "Keep it").is_none().then_some(()));
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(std::fs::read(&path).unwrap(), b"mine");
    person.click("Button", "Export");
    person.find("Button", "Replace it");
    exporter.line(output, "--overwrite");
    person.click("Button", "Replace it");
    exporter.wait_for(output);
    assert!(std::fs::read(&path).unwrap() == drawn, "the drawing is there again");
}
