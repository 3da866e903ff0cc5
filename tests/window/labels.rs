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
    // Letters and leaders are in the sky, above the cone: in the upper half. They come back where they were, and without the
    // key nothing changes. While the land still loads all of the picture changes, so this is tried again.
    until("labels that a key hides and shows", || {
        let shown = at_rest(&display);
        display.key(&["key", "U"]);
        let hidden = at_rest(&display);
        display.key(&["key", "U"]);
        let again = at_rest(&display);
        let rows = differing_rows(&shown, &hidden);
        let are_in_the_sky = rows.len() > 5 && rows[0] < 150 && rows.iter().all(|row| *row < 200);
        let are_back = differing_rows(&shown, &again).is_empty();
        let is_still = differing_rows(&again, &at_rest(&display)).is_empty();
        (are_in_the_sky && are_back && is_still).then_some(())
    });
}
