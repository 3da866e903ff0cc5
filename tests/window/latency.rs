//! The time until an edit is on the screen.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::display::{Display, can_run, is_full, open_with, until};
use crate::person::Person;

/// A part of the picture that no panel covers: its left top corner and its size, in pixels.
const PICTURE: ([i16; 2], [u16; 2]) = ([20, 60], [220, 240]);

/// Returns the mean time of a frame during a flight: the window writes the places of its widgets once a frame.
fn frame_time(person: &Person<'_>) -> Duration {
    let written = || std::fs::metadata(&person.widgets).and_then(|file| file.modified()).ok();
    person.display.key(&["keydown", "w"]);
    std::thread::sleep(Duration::from_millis(500));
    let (begun, mut frames, mut last) = (Instant::now(), 0_u32, written());
    while begun.elapsed() < Duration::from_secs(3) {
        std::thread::sleep(Duration::from_millis(1));
        let now = written();
        frames += u32::from(now.is_some() && now != last);
        last = now.or(last);
    }
    let time = begun.elapsed() / frames.max(1);
    person.display.key(&["keyup", "w"]);
    time
}

#[test]
fn an_edit_is_on_the_screen_within_two_frames_and_100_ms() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::of_size("640x360x24").expect("Xvfb must start");
    let widgets = folder.join("widgets");
    let environment: [(&str, &Path); 1] = [("HACHURE_WIDGETS", &widgets)];
    let arguments = ["--style", "ink", "--antialias", "temporal", "--size", "640x360"];
    let (mut program, window) = open_with(&display, folder, &environment, &arguments);
    let person = Person { display: &display, window, widgets: widgets.clone(), frame: Duration::from_millis(200) };
    person.find("ComboBox", "Drawn style");
    let frame = frame_time(&person);
    person.keys(&["r"]);
    person.keys(&["h"]);
    person.keys(&["i"]);
    let [x, y] = Person::middle(&person.find("Slider", "Density"));
    let picture = || display.pixels(PICTURE.0, PICTURE.1);
    let is_at_rest = || {
        let before = picture();
        std::thread::sleep(2 * frame + Duration::from_secs(2));
        picture() == before
    };
    until("rest", || is_at_rest().then_some(()));

    // Planted: a mouse that moves beside the slider changes nothing, so the time of an edit is not that of any event.
    person.point([x, y + 100.0]);
    let before = picture();
    person.point([x + 9.0, y + 100.0]);
    std::thread::sleep(2 * frame + Duration::from_millis(300));
    assert!(picture() == before, "the picture is not at rest");

    person.point([x, y]);
    display.key(&["mousedown", "1"]);
    std::thread::sleep(Duration::from_secs(1));
    let mut times: Vec<Duration> = Vec::new();
    let edits = if is_full() { 12 } else { 5 };
    for step in 1..=edits {
        let before = picture();
        let sent = Instant::now();
        person.point([x + 4.0 * f64::from(step), y]);
        while picture() == before {
            assert!(sent.elapsed() < Duration::from_secs(60), "an edit is not shown");
            std::thread::sleep(Duration::from_millis(2));
        }
        times.push(sent.elapsed());
        // The mean of the last frames comes to rest.
        std::thread::sleep(Duration::from_millis(1500));
    }
    display.key(&["mouseup", "1"]);
    times.sort_unstable();
    let (median, longest) = (times[times.len() / 2], times[times.len() - 1]);
    eprintln!("an edit takes {median:.0?} (median), at most {longest:.0?}; a frame {frame:.0?}");
    assert!(median <= 2 * frame + Duration::from_millis(100), "{times:.0?}, a frame {frame:.0?}");
    assert!(program.0.try_wait().unwrap().is_none());
}
