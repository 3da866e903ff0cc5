//! Tests the five controls of documents: positions, history, and what happens to values that the user has set.

use super::{open, presets};
use crate::style::controls::{Control, END};
use crate::tests::common::full;

#[test]
fn a_position_is_found_again_in_the_text() {
    for name in presets() {
        for control in Control::ALL {
            let mut document = open(name);
            assert_eq!(document.control(control), 0);
            if control.without_effect(document.style()).is_some() {
                continue;
            }
            for wanted in [-END, -37, 12, 55, END].into_iter().step_by(if full() { 1 } else { 2 }) {
                document.set_control(control, wanted).unwrap();
                document.release();
                assert_eq!(document.control(control), wanted, "{name} {control:?}");
                // A document that is opened with the same text knows nothing but the text.
                let mut again = open(name);
                again.replace(document.text().to_owned(), "the same").unwrap();
                let off = i16::from(again.control(control)) - i16::from(wanted);
                assert!(off.abs() <= 6, "{name} {control:?}: {wanted} became {}", again.control(control));
                // Other controls stay where they are.
                let others = Control::ALL.into_iter().filter(|other| *other != control);
                let moved: Vec<_> = others.filter(|other| again.control(*other) != 0).collect();
                assert!(moved.is_empty(), "{name} {control:?} moved {moved:?}");
            }
            document.set_control(control, 0).unwrap();
            document.release();
            assert_eq!(document.text(), open(name).text(), "{name} {control:?}");
        }
    }
}

#[test]
fn a_drag_of_a_control_is_one_step() {
    let mut document = open("pen");
    let before = document.text().to_owned();
    for position in [10, 45, 100, 20, -100, 35] {
        document.set_control(Control::Weight, position).unwrap();
    }
    let at_35 = document.style().clone();
    document.release();
    assert_eq!(document.step_names()[0], Some("Weight: +35"));
    document.undo().unwrap();
    assert_eq!((document.text(), document.control(Control::Weight)), (before.as_str(), 0));
    document.redo().unwrap();
    assert_eq!((document.style(), document.control(Control::Weight)), (&at_35, 35));
    // Two controls that drive the same parameter are independent.
    document.set_control(Control::Density, 60).unwrap();
    document.release();
    assert_eq!((document.control(Control::Weight), document.control(Control::Density)), (35, 60));
    document.set_control(Control::Weight, 0).unwrap();
    document.release();
    assert_eq!((document.control(Control::Weight), document.control(Control::Density)), (0, 60));
    // A drag back to its start is not a step, although values are clamped on the way.
    let (text, step) = (document.text().to_owned(), document.step_names()[0].unwrap().to_owned());
    for position in [50, 100, -100, 0] {
        document.set_control(Control::Weight, position).unwrap();
    }
    document.release();
    assert_eq!((document.text(), document.step_names()[0]), (text.as_str(), Some(step.as_str())));
}

#[test]
fn values_of_the_user_move_with_the_others() {
    let mut document = open("pen");
    let width_px = |document: &super::StyleDocument| document.style().strokes().unwrap().width_px;
    document.set("strokes.width_px", 5.0).unwrap();
    document.release();
    document.set_control(Control::Weight, 50).unwrap();
    document.release();
    assert!((width_px(&document) / 5.0 - 1.8_f32.sqrt()).abs() < 0.01, "{}", width_px(&document));
    let shore_px = document.style().water().unwrap().shore_px;
    assert!((shore_px / 1.3 - 1.6_f32.sqrt()).abs() < 0.01, "{shore_px}");
    document.set_control(Control::Weight, 0).unwrap();
    document.release();
    assert!((width_px(&document) - 5.0).abs() < 0.01 && document.style().water().unwrap().shore_px == 1.3);
    // The saved style is the new middle.
    let folder = tempfile::tempdir().unwrap();
    document.set_control(Control::Warmth, 40).unwrap();
    let saved = document.save_as(folder.path().join("warm").to_str().unwrap(), None).unwrap();
    assert_eq!((document.control(Control::Warmth), saved.control(Control::Warmth)), (40, 0));
}
