//! Labels of summits appear over the picture of a window, and a key hides them.

use std::time::Duration;

use crate::display::{Display, can_run, open_with, until};

/// Returns what the display shows when it no longer changes and messages have gone.
fn at_rest(display: &Display) -> Vec<u8> {
    let look = || display.pixels([0, 0], [480, 300]);
    std::thread::sleep(Duration::from_secs(3));
    let mut last = look();
    until("rest", || {
        std::thread::sleep(Duration::from_secs(1));
        let before = std::mem::replace(&mut last, look());
        (before == last).then_some(())
    });
    last
}

/// Returns the rows of pixels that differ, above those of messages.
fn differing_rows(a: &[u8], b: &[u8]) -> Vec<usize> {
    let pixels = a.chunks_exact(4).zip(b.chunks_exact(4)).enumerate();
    let mut rows: Vec<usize> = pixels.filter(|(_, (a, b))| a != b).map(|(i, _)| i / 480).collect();
    rows.dedup();
    rows.retain(|row| *row < 240);
    rows
}

#[test]
fn labels_are_over_the_picture_until_a_key_hides_them() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let display = Display::of_size("480x300x24").expect("Xvfb must start");
    let camera = "--camera=0,-1500,+300,0,-2,60";
    let arguments = ["--size", "480x300", "--style", "lsa", "--peaks", "5", camera];
    let (_program, _window) = open_with(&display, folder.path(), &[], &arguments);
    // Without the panel, all of the window is free.
    display.key(&["key", "H"]);
    let (shown, hidden) = until("labels", || {
        let shown = at_rest(&display);
        display.key(&["key", "U"]);
        let hidden = at_rest(&display);
        display.key(&["key", "U"]);
        (differing_rows(&shown, &hidden).len() > 5).then_some((shown, hidden))
    });
    // Letters and leaders are in the sky, above the cone: in the upper half.
    let rows = differing_rows(&shown, &hidden);
    assert!(rows.iter().all(|row| *row < 200) && rows[0] < 150, "{rows:?}");
    // The labels come back where they were; without the key nothing changes.
    let again = at_rest(&display);
    assert_eq!(differing_rows(&shown, &again), Vec::<usize>::new());
    assert_eq!(differing_rows(&again, &at_rest(&display)), Vec::<usize>::new());
}
