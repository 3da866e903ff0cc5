//! The walk of `docs/guide/walk.md`: a newcomer, who starts `./demo` and has read nothing, changes a style, saves it, and
//! prints a poster of it.
//!
//! With `HACHURE_REWRITE=1` the test also draws the pictures and the film of the guide.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use hachure::file::frame_rate::FrameRate;
use hachure::file::gif::GifWriter;
use hachure::file::imprint::Notes;
use hachure::file::png::{Picture, PngPixels, PngWriter, read_rgba8};

use crate::display::{Display, Running, can_run, is_full, until};
use crate::person::Person;

/// Size of the window.
const SIZE_PX: [u32; 2] = [960, 600];
/// Longest time in which the poster is drawn without a GPU.
const POSTER: Duration = Duration::from_secs(600);
/// The part of the window that is filmed: its left top corner and its size.
const FILM: ([i16; 2], [u16; 2]) = ([290, 0], [670, 420]);
/// Frames per second of the film.
const FPS: f64 = 6.0;
/// Frames for which the film rests on what is read.
const REST: usize = 8;

/// The pictures that the walk takes of the window.
struct Camera<'a> {
    display: &'a Display,
    /// Where pictures of the guide are written, if they are.
    folder: Option<PathBuf>,
    film: Vec<Vec<u8>>,
}

impl Camera<'_> {
    fn window(&self) -> Vec<u8> {
        let [width, height] = SIZE_PX.map(|side| side as u16);
        self.display.pixels([0, 0], [width, height])
    }

    /// Waits until the window has not changed for some seconds, or for two minutes.
    fn settle(&self, seconds: u64) {
        let begun = Instant::now();
        let mut before = self.window();
        while begun.elapsed() < Duration::from_secs(120) {
            std::thread::sleep(Duration::from_secs(seconds));
            let now = self.window();
            if now == before {
                return;
            }
            before = now;
        }
    }

    /// Writes a picture of the guide.
    fn take(&self, name: &str) {
        let Some(folder) = &self.folder else { return };
        let path = folder.join(format!("walk-{name}.png"));
        let [width, height] = SIZE_PX;
        let mut writer = PngWriter::create_noted(&path, width, height, PngPixels::Rgba8, &Notes::default()).unwrap();
        writer.write_rows(&self.window()).unwrap();
        writer.finish().unwrap();
    }

    /// Adds frames of what is shown to the film: the inspector, and as much of the picture beside it.
    fn film(&mut self, frames: usize) {
        let frame = self.display.pixels(FILM.0, FILM.1);
        self.film.extend(std::iter::repeat_n(frame, frames));
    }

    fn write_film(&self, name: &str) {
        let Some(folder) = &self.folder else { return };
        let path = folder.join(format!("{name}.gif"));
        let mut writer =
            GifWriter::create(&path, FILM.1.map(u32::from), FrameRate::Number(FPS), &Notes::default()).unwrap();
        self.film.iter().for_each(|frame| writer.write_frame(frame).unwrap());
        writer.finish().unwrap();
    }
}

/// Starts the program as `./demo` does, for a person whose home is `home`.
fn start(display: &Display, home: &Path, widgets: &Path) -> (Running, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hachure"));
    command.arg("fly").arg("--size").arg(format!("{}x{}", SIZE_PX[0], SIZE_PX[1]));
    command.current_dir(home).env("HOME", home).env("DISPLAY", &display.name).env("HACHURE_WIDGETS", widgets);
    command.env("HACHURE_CACHE", home.join(".cache")).env("HACHURE_CONFIG", home.join(".config"));
    command.env("XDG_RUNTIME_DIR", home).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command.env_remove("RUST_LOG").stderr(std::fs::File::create(home.join(".stderr")).unwrap());
    let mut program = Running(command.spawn().unwrap());
    let window = until("a window", || {
        assert!(program.0.try_wait().unwrap().is_none(), "{}", printed(home));
        display.xdotool(&["search", "--onlyvisible", "--name", "hachure"]).filter(|id| !id.is_empty())
    });
    display.key(&["windowfocus", &window]);
    (program, window)
}

fn printed(home: &Path) -> String {
    std::fs::read_to_string(home.join(".stderr")).unwrap_or_default()
}

#[test]
fn a_newcomer_prints_a_poster_of_a_changed_style() {
    if !is_full() || !can_run() {
        return;
    }
    let home = tempfile::tempdir().unwrap();
    let home = home.path();
    let display = Display::of_size(&format!("{}x{}x24", SIZE_PX[0], SIZE_PX[1])).expect("Xvfb must start");
    let widgets = home.join(".widgets");
    let (mut program, window) = start(&display, home, &widgets);
    let person = Person { display: &display, window, widgets, frame: Duration::from_millis(500) };
    let rewrites = std::env::var("HACHURE_REWRITE").is_ok_and(|value| value == "1");
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/pictures");
    let mut camera = Camera { display: &display, folder: rewrites.then_some(guide), film: Vec::new() };
    let rest = |seconds: u64| std::thread::sleep(Duration::from_secs(seconds));

    // The window says what can be done.
    person.find("Button", "Begin");
    camera.settle(2);
    camera.take("1-welcome");
    person.keys(&["Return"]);
    until("the end of the welcome", || person.see("Button", "Begin").is_none().then_some(()));

    // All styles are seen, and one is chosen.
    person.click("Button", "Gallery");
    person.find("Button", "Style hachures");
    camera.settle(12);
    camera.take("2-gallery");
    person.click("Button", "Style pen");
    until("the style", || person.see("ComboBox", "Drawn style").filter(|list| list.value == "pen"));
    person.click("Button", "Close the gallery");
    until("the end of the gallery", || person.see("Button", "Close the gallery").is_none().then_some(()));

    // The style is changed with the sliders at the top.
    person.click("Button", "Style");
    person.find("Slider", "Density");
    person.keys(&["h"]);
    until("the hidden panel", || person.see("Button", "Export…").is_none().then_some(()));
    camera.settle(2);
    camera.film(REST);
    for (name, distance) in [("Density", 30.0), ("Weight", 22.0), ("Warmth", 34.0)] {
        let slider = person.find("Slider", name);
        let [x, y] = Person::middle(&slider);
        person.point([x, y]);
        display.key(&["mousedown", "1"]);
        for step in 1..=4 {
            person.point([x + distance * f64::from(step) / 4.0, y]);
            std::thread::sleep(Duration::from_millis(700));
            camera.film(1);
        }
        display.key(&["mouseup", "1"]);
        let value =
            until("the drag", || Some(person.find("Slider", name).value).filter(|value| *value != slider.value));
        assert!(value.parse::<f64>().unwrap() > 0.0, "{name}: {value}");
        camera.settle(2);
        camera.film(REST);
    }
    camera.write_film("inspector");
    person.keys(&["h"]);

    // It is saved under a name.
    person.click("Button", "Save as…");
    person.click("TextInput", "Name of the new style file");
    person.keys(&["ctrl+a"]);
    display.key(&["type", "--delay", "40", "my-pen.toml"]);
    until("the name", || {
        Some(person.find("TextInput", "Name of the new style file")).filter(|field| field.value == "my-pen.toml")
    });
    camera.take("3-save");
    person.keys(&["Return"]);
    until("the style file", || home.join("my-pen.toml").exists().then_some(()));

    // A poster of it is exported.
    person.click("Button", "Export…");
    person.click("Button", "paper");
    // Without a GPU, 17 million pixels of 16 samples take minutes.
    person.click("SpinButton", "Dots per inch");
    person.keys(&["ctrl+a"]);
    display.key(&["type", "--delay", "40", "100"]);
    person.keys(&["Return"]);
    person.click("TextInput", "Title below the picture");
    display.key(&["type", "--delay", "40", "My mountains"]);
    rest(1);
    camera.take("4-export");
    let poster = home.join(person.find("TextInput", "Path of the output").value);
    person.click("Button", "Export");
    rest(5);
    camera.take("5-exporting");
    let begun = Instant::now();
    while !poster.exists() {
        assert!(begun.elapsed() < POSTER, "the poster is not written: {}", printed(home));
        rest(1);
    }
    eprintln!("the poster took {:.0?}", begun.elapsed());
    let Picture { width, height, .. } = read_rgba8(&poster).unwrap();
    // A3 at 100 dots per inch.
    assert_eq!([width, height], [1654, 1169]);
    let imprint = Command::new(env!("CARGO_BIN_EXE_hachure")).args(["info", "--json"]).arg(&poster).output().unwrap();
    let imprint = String::from_utf8(imprint.stdout).unwrap();
    assert!(imprint.contains("my-pen") && imprint.contains("My mountains"), "{imprint}");

    person.keys(&["Escape"]);
    until("the closed dialog", || person.see("TextInput", "Path of the output").is_none().then_some(()));
    until("the message", || person.beginning("Button", "Dismiss: Wrote "));
    person.keys(&["Escape"]);
    until("the dismissed message", || person.beginning("Button", "Dismiss: ").is_none().then_some(()));
    person.keys(&["Escape"]);
    person.keys(&["Escape"]);
    let status = until("the end", || program.0.try_wait().unwrap());
    assert_eq!(status.code(), Some(0), "{}", printed(home));
    assert!(!printed(home).contains("ERROR") && !printed(home).contains("panicked"), "{}", printed(home));
}
