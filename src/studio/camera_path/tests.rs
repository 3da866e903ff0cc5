//! Tests a camera path that is being edited: its lines, its history, its files, and that it is the path of a film.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use std::path::Path;

use crate::file::atomic;
use crate::scene::camera::Camera;
use crate::scene::path::CameraPath;
use crate::studio::camera_path::PathDocument;
use crate::studio::unsaved::Unsaved;

/// A path with comments, a jump, both kinds of z, spaces and Windows' ends of lines.
const TEXT: &str = "# a tour\r\nt, x,y,z,yaw,pitch,fov\r\n0,0,0,+50,0,-10,50\r\n# over the ridge\r\n\r\n\
                    4,100, 0,500,350,-10.50,50\r\n6,200,0,+60,10,0,50\r\n6,900,900,800,90,0,60\r\n10,950,900,800,90,0,60";

fn ground_m(x: f64, _: f64) -> f64 {
    100.0 + x
}

fn document() -> PathDocument {
    PathDocument::of_text("tour of mine", None, TEXT, ground_m).unwrap()
}

fn camera(text: &str) -> Camera {
    text.parse().unwrap()
}

/// Asserts that the document flies what a film of its text does.
fn assert_is_film(document: &PathDocument) {
    let film = CameraPath::parse_on_ground(Path::new("film.csv"), document.text().as_bytes(), ground_m).unwrap();
    assert_eq!(document.curve(), Some(&film));
    assert_eq!(document.span_s(), [film.times_s()[0], film.times_s()[0] + film.duration_s()]);
}

type Edit = (&'static str, fn(&mut PathDocument) -> Result<(), String>);

/// Edits, with the names of their steps.
const EDITS: [Edit; 9] = [
    ("add the key at 2 s", |it| it.add(2.0, &camera("5,6,700.12345,8,9,50")).map(|_| ())),
    ("add the key at 14 s", |it| it.add(it.time_for_new(10.0), &camera("1,2,800,0,0,45")).map(|_| ())),
    ("replace the key at 4 s", |it| it.replace(1, &camera("7,7,777,0,0,50"))),
    ("move the key to 3.5 s", |it| it.move_to(1, 3.5)),
    ("move the key to 8 s", |it| it.move_to(3, 8.0)),
    ("ease the key at 6 s", |it| it.set_ease(2, 1.0)),
    ("a duration of 20 s", |it| it.set_duration(20.0)),
    ("delete the key at 4 s", |it| it.remove(1)),
    ("delete the key at 0 s", |it| it.remove(0)),
];

#[test]
fn each_edit_is_undone_to_the_same_text_and_is_what_a_film_shows() {
    for (name, edit) in EDITS {
        let mut document = document();
        assert_is_film(&document);
        assert!(!document.is_edited());
        edit(&mut document).unwrap();
        let edited = document.text().to_owned();
        assert!(document.is_edited() && edited != TEXT, "{name}");
        assert_is_film(&document);
        assert_eq!(document.step_names(), [Some(name), None]);
        assert_eq!(document.undo().as_deref(), Some(name));
        assert_eq!(document.text(), TEXT, "{name}");
        assert!(!document.is_edited());
        assert_eq!(document.redo().as_deref(), Some(name));
        assert_eq!(document.text(), edited);
        assert_is_film(&document);
        // Lines that the edit does not concern stay as they are, comments included.
        for line in ["# a tour\r\n", "# over the ridge\r\n"] {
            assert!(edited.contains(line), "{name}: {edited}");
        }
    }
}

#[test]
fn many_edits_are_undone_one_by_one() {
    let mut document = document();
    let mut texts = vec![document.text().to_owned()];
    for step in 0..100 {
        document.add(20.0 + f64::from(step), &camera("0,0,900,0,0,50")).unwrap();
        texts.push(document.text().to_owned());
    }
    assert_eq!(document.keys().len(), 105);
    while let Some(text) = texts.pop() {
        assert_eq!(document.text(), text);
        document.undo();
    }
    assert!(!document.is_edited());
}

#[test]
fn an_edit_changes_only_its_lines() {
    let mut document = document();
    document.move_to(1, 3.25).unwrap();
    assert_eq!(document.text(), TEXT.replace("4,100, 0", "3.25,100, 0"));
    document.release();
    document.undo();
    document.add(12.0, &camera("1,2,3,4,5,60")).unwrap();
    assert_eq!(document.text(), format!("{TEXT}\r\n12,1,2,3,4,5,60\r\n"));
    document.undo();
    // Both rows of a jump move, and neither passes its neighbours.
    document.move_to(2, 7.0).unwrap();
    assert_eq!(document.text(), TEXT.replace("\r\n6,", "\r\n7,"));
    document.release();
    document.move_to(2, 1e9).unwrap();
    document.release();
    assert_eq!(document.keys()[3].time_s, 9.99);
    document.move_to(2, -1e9).unwrap();
    assert_eq!(document.keys()[2].time_s, 4.01);
}

#[test]
fn a_drag_is_one_step() {
    let mut document = document();
    for time_s in [4.1, 4.2, 4.4] {
        document.move_to(1, time_s).unwrap();
    }
    document.release();
    for duration_s in [11.0, 13.0] {
        document.set_duration(duration_s).unwrap();
    }
    document.release();
    assert_eq!(document.keys()[1].time_s, 5.72);
    assert_eq!(document.undo().as_deref(), Some("a duration of 13 s"));
    assert_eq!(document.undo().as_deref(), Some("move the key to 4.4 s"));
    assert_eq!(document.undo(), None);
    assert_eq!(document.text(), TEXT);
    // A drag back to its start is not a step.
    document.set_ease(1, 0.5).unwrap();
    document.set_ease(1, 0.0).unwrap();
    document.release();
    assert_eq!((document.text(), document.step_names()[0]), (TEXT, None));
}

#[test]
fn ease_is_a_column_that_older_files_lack() {
    let mut document = document();
    document.set_ease(1, 0.254).unwrap();
    document.release();
    let text = document.text().to_owned();
    assert!(text.contains("t, x,y,z,yaw,pitch,fov,ease\r\n0,0,0,+50,0,-10,50,0\r\n"), "{text}");
    assert!(text.contains("4,100, 0,500,350,-10.50,50,0.25\r\n"), "{text}");
    document.add(2.0, &camera("1,2,800,0,0,45")).unwrap();
    assert!(document.text().contains("2,1,2,800,0,0,45,0\r\n"));
    document.set_ease(2, 0.0).unwrap();
    assert!(!document.text().contains("ease"), "without ease, every version reads the file");
    // A file that has the column keeps it.
    let with = "t,x,y,z,yaw,pitch,fov,ease\n0,0,0,900,0,0,50,\n1,9,0,900,0,0,50,1\n";
    let mut document = PathDocument::of_text("a", None, with, ground_m).unwrap();
    assert_eq!((document.text(), document.keys()[1].ease), (with, 1.0));
    document.set_ease(1, 0.0).unwrap();
    assert_eq!(document.text(), with.replace("50,1\n", "50,0\n"));
}

#[test]
fn a_path_begins_with_nothing_and_may_lose_all_its_keys() {
    let mut document = PathDocument::empty();
    assert_eq!((document.keys().len(), document.curve(), document.is_edited()), (0, None, false));
    assert_eq!(
        document.save_as("/nowhere/a.csv").unwrap_err().to_string(),
        "a camera path needs at least one key frame"
    );
    for _ in 0..3 {
        let time_s = document.time_for_new(document.span_s()[1]);
        document.add(time_s, &camera("1,2,800.00049,0,0,45")).unwrap();
    }
    assert_eq!(document.keys().iter().map(|key| key.time_s).collect::<Vec<_>>(), [0.0, 4.0, 8.0]);
    assert_eq!(document.keys()[0].camera.position_m.z, 800.0, "to a millimetre");
    assert_is_film(&document);
    // Between keys: at the playhead, or in the middle of the segment that begins at a key.
    assert_eq!([0.0, 1.5, 4.0, 8.0, 9.0].map(|at_s| document.time_for_new(at_s)), [2.0, 1.5, 6.0, 12.0, 9.0]);
    assert!(document.add(4.0, &camera("1,2,3,4,5,60")).unwrap_err().contains("at 4 s already"));
    (0..3).for_each(|_| document.remove(0).unwrap());
    assert_eq!((document.keys().len(), document.curve(), document.is_edited()), (0, None, false));
    document.undo();
    assert_eq!(document.keys().len(), 1);
}

#[test]
fn deleting_before_a_jump_deletes_its_first_row_too() {
    let text = "t,x,y,z,yaw,pitch,fov\n0,0,0,9,0,0,50\n1,1,0,9,0,0,50\n1,5,0,9,0,0,50\n2,6,0,9,0,0,50\n";
    let mut document = PathDocument::of_text("a", None, text, ground_m).unwrap();
    document.remove(0).unwrap();
    assert_eq!(document.text(), "t,x,y,z,yaw,pitch,fov\n1,5,0,9,0,0,50\n2,6,0,9,0,0,50\n");
    assert_is_film(&document);
    document.undo();
    document.remove(1).unwrap();
    assert_eq!(document.keys().len(), 3, "another row of a jump goes alone");
}

#[test]
fn save_load_save_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    for (number, (name, edit)) in EDITS.into_iter().enumerate() {
        let mut document = document();
        edit(&mut document).unwrap();
        let first = at(&format!("{number}"));
        document.save_as(&first).unwrap();
        assert!(!document.is_edited() && document.name().ends_with(".csv"), "{name}");
        let text = std::fs::read_to_string(document.name()).unwrap();
        let mut again = PathDocument::of_text(document.name(), Some(document.name().into()), &text, ground_m).unwrap();
        assert_eq!((again.text(), again.curve()), (document.text(), document.curve()), "{name}");
        again.save().unwrap();
        again.save_as(&at(&format!("{number} again"))).unwrap();
        assert_eq!(std::fs::read_to_string(again.name()).unwrap(), text, "{name}");
    }
    // Quotes are read, and their rows are written without.
    let quoted = "\"t\",x,y,z,yaw,pitch,fov\n0,\"1\n\",0,9,0,0,50\n2,6,0,9,0,0,50\n";
    let document = PathDocument::of_text("q", None, quoted, ground_m).unwrap();
    assert_eq!(document.text(), "t,x,y,z,yaw,pitch,fov\n0,1,0,9,0,0,50\n2,6,0,9,0,0,50\n");
    assert!(!document.is_edited());
}

#[test]
fn no_file_of_somebody_else_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    let name = path.display().to_string();
    let mut document = document();
    assert_eq!(document.save().unwrap_err().to_string(), "the camera path has no file; save it under a name");
    atomic::write(&path, b"mine").unwrap();
    for given in [name.clone(), name.trim_end_matches(".csv").to_owned()] {
        let error = document.save_as(&given).unwrap_err().to_string();
        assert!(error.contains("a.csv: exists and is not the camera path") && !error.contains('\n'), "{error}");
    }
    assert_eq!(std::fs::read(&path).unwrap(), b"mine");
    std::fs::remove_file(&path).unwrap();
    document.save_as(&name).unwrap();
    document.remove(1).unwrap();
    document.save().unwrap();
    // Another program changes the file.
    let theirs = document.text().replace("950", "951");
    atomic::write(&path, theirs.as_bytes()).unwrap();
    document.remove(0).unwrap();
    let error = document.save().unwrap_err().to_string();
    assert!(error.contains("changed by another program"), "{error}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), theirs);
    // A file that is gone is written again.
    std::fs::remove_file(&path).unwrap();
    document.save().unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), document.text());
    assert!(document.save_as(" ").is_err() && document.save_as("/nowhere/").is_err());
    let error = document.save_as("/no/such/folder/a").unwrap_err().to_string();
    assert!(error.contains("/no/such/folder/a.csv") && !error.contains('\n'), "{error}");
}

#[test]
fn a_film_of_what_is_not_saved_is_drawn_from_a_copy() {
    let cache = tempfile::tempdir().unwrap();
    let mut document = PathDocument::of_text("tour", None, TEXT, ground_m).unwrap();
    assert_eq!(document.for_film_within(Some(cache.path())).unwrap(), ("tour".to_owned(), false));
    document.remove(1).unwrap();
    let (copy, is_copy) = document.for_film_within(Some(cache.path())).unwrap();
    assert!(is_copy && copy.starts_with(&cache.path().display().to_string()), "{copy}");
    assert_eq!(std::fs::read_to_string(&copy).unwrap(), document.text());
    // Another text has another copy: the first film may still be read.
    document.remove(1).unwrap();
    assert_ne!(document.for_film_within(Some(cache.path())).unwrap().0, copy);
    assert!(document.for_film_within(None).unwrap_err().to_string().contains("save it under a name"));
    assert!(PathDocument::empty().for_film_within(Some(cache.path())).is_err());
}

#[test]
fn edits_outlive_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let kept = |document: &PathDocument, world: &str| {
        document.find_kept(&Unsaved::within(Some(folder.path().to_owned())), world)
    };
    let keep = |document: &PathDocument, world: &str| {
        document.keep(&Unsaved::within(Some(folder.path().to_owned())), world);
    };
    let mut document = PathDocument::empty();
    document.add(0.0, &camera("1,2,800,0,0,45")).unwrap();
    keep(&document, "alps.tif");
    let text = kept(&PathDocument::empty(), "alps.tif").unwrap();
    assert_eq!(text, document.text());
    assert_eq!(kept(&PathDocument::empty(), "andes.tif"), None, "the path of another world");
    assert_eq!(kept(&self::document(), "alps.tif"), None, "another path");
    let mut restored = PathDocument::empty();
    restored.replace_text(text, "Edits that were not saved").unwrap();
    assert_eq!(restored.keys(), document.keys());
    assert_eq!(kept(&restored, "alps.tif"), None, "they are there already");
    restored.undo();
    keep(&restored, "alps.tif");
    assert_eq!(kept(&document, "alps.tif"), None, "what is undone is not kept");
    assert!(restored.replace_text("t,x\n".to_owned(), "no path").unwrap_err().contains("the header is"));
}

#[test]
fn another_ground_moves_cameras_above_it() {
    let mut document = document();
    document.remove(2).unwrap();
    document.set_ground(|x, y| Some(2.0 * ground_m(x, y)));
    document.undo();
    let film = CameraPath::parse_on_ground(Path::new("a"), TEXT.as_bytes(), |x, y| 2.0 * ground_m(x, y)).unwrap();
    assert_eq!(document.curve(), Some(&film), "the one that came back, too");
    document.set_ground(|_, _| None);
    assert_eq!(document.curve(), Some(&film), "heights that cannot be read stay");
}
