//! Divides the events of one frame where egui would lose some of them.
//!
//! egui sees the mouse once in a frame. If a button is pressed, moved and released between two frames, nothing is
//! dragged; and of two clicks on two widgets, one is lost. So the events that follow are kept for the next frame, which
//! comes at once.

use egui::{Event, PointerButton, Pos2};

/// Distance within which a press and its release are a click, and two clicks are a double click, in points. It is that of
/// egui.
const CLICK: f32 = 6.0;

/// Returns how many of the events of a frame egui can be given at once.
pub(super) fn first_part(events: &[Event]) -> usize {
    let mut pressed: Option<(PointerButton, Pos2)> = None;
    let mut released: Option<Pos2> = None;
    for (index, event) in events.iter().enumerate() {
        match event {
            Event::PointerButton { pos, button, pressed: true, .. } => {
                // Where the last click was, this is the second one of a double click.
                if released.is_some_and(|released| released.distance(*pos) > CLICK) {
                    return index;
                }
                pressed = Some((*button, *pos));
            }
            Event::PointerButton { pos, button, pressed: false, .. } => {
                if pressed.is_some_and(|(known, from)| known == *button && from.distance(*pos) > CLICK) {
                    return index;
                }
                released = pressed.take().map(|(_, from)| from);
            }
            _ => {}
        }
    }
    events.len()
}

#[cfg(test)]
mod tests {
    use egui::{Modifiers, pos2};

    use super::*;

    fn button(x: f32, pressed: bool) -> Event {
        Event::PointerButton { pos: pos2(x, 5.0), button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    fn moved(x: f32) -> Event {
        Event::PointerMoved(pos2(x, 5.0))
    }

    #[test]
    fn a_drag_ends_in_the_next_frame_and_two_clicks_have_two_frames() {
        assert_eq!(first_part(&[]), 0);
        // A click, and a double click.
        let [press, release] = [true, false].map(|pressed| button(10.0, pressed));
        assert_eq!(first_part(&[moved(10.0), press.clone(), release.clone()]), 3);
        assert_eq!(first_part(&[press.clone(), release.clone(), press.clone(), release.clone()]), 4);
        // A drag is held when the frame ends.
        assert_eq!(first_part(&[press.clone(), moved(40.0), moved(60.0), button(60.0, false), moved(5.0)]), 3);
        // The release of a drag that began in an earlier frame, and a click elsewhere.
        assert_eq!(first_part(&[button(60.0, false), moved(10.0), press.clone(), release.clone()]), 4);
        let elsewhere = [press, release, moved(80.0), button(80.0, true), button(80.0, false)];
        assert_eq!(first_part(&elsewhere), 3);
        assert_eq!(first_part(&elsewhere[3..]), 2);
    }
}
