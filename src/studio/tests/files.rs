//! Tests what happens to the files of documents.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{open, presets};
use crate::file::atomic;
use crate::studio::document::{Reloaded, StyleDocument};
use crate::studio::unsaved::Unsaved;
use crate::studio::watch::FileWatch;
use crate::style::{Style, preset_text};

/// Longest time until a change of a file is reported.
const SOON: Duration = Duration::from_millis(300);

fn write(path: &Path, text: &str) {
    atomic::write(path, text.as_bytes()).unwrap();
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// Writes a preset into a folder, and opens it as a style of the user.
fn own(folder: &Path, preset: &str) -> (StyleDocument, PathBuf) {
    let path = folder.join(format!("{preset}.toml"));
    write(&path, preset_text(preset).unwrap());
    (open(path.to_str().unwrap()), path)
}

#[test]
fn saving_and_reading_again_keeps_every_byte() {
    let folder = tempfile::tempdir().unwrap();
    for name in presets() {
        let (mut document, path) = own(folder.path(), name);
        document.save().unwrap();
        assert_eq!(read(&path), preset_text(name).unwrap(), "{name}");
        // There and back is nothing.
        document.set("description", "other").unwrap();
        document.save().unwrap();
        assert_ne!(read(&path), preset_text(name).unwrap());
        let mut document = open(path.to_str().unwrap());
        let description = Style::load(name).unwrap().description;
        document.set("description", description).unwrap();
        document.save().unwrap();
        assert_eq!(read(&path), preset_text(name).unwrap(), "{name}");
        assert!(!document.is_edited());
    }
}

#[test]
fn files_of_others_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (mut document, path) = own(folder.path(), "ink");
    document.set("paper.grain", 0.5).unwrap();
    let error = open("ink").save().unwrap_err().to_string();
    assert!(error.contains("ink is built in"), "{error}");
    // Another program has changed the file.
    let other = preset_text("ink").unwrap().replace("grain = ", "grain = 0.0 # ");
    write(&path, &format!("# other\n{other}"));
    let error = document.save().unwrap_err().to_string();
    assert!(error.contains("changed by another program"), "{error}");
    assert!(read(&path).starts_with("# other\n"));
    // If the file is gone, it is written again.
    std::fs::remove_file(&path).unwrap();
    document.save().unwrap();
    assert_eq!(read(&path), document.text());
    // A new file must not exist, not even as a link that leads nowhere.
    write(Path::new(&at("notes.toml")), "mine");
    for name in ["notes.toml", "notes", "ink.toml"] {
        let error = document.save_as(&at(name), None).unwrap_err().to_string();
        assert!(error.contains("exists") && !error.contains('\n'), "{error}");
    }
    assert_eq!(read(Path::new(&at("notes.toml"))), "mine");
    for name in ["", "  ", "folder/"] {
        assert!(document.save_as(name, None).is_err());
    }
    let error = document.save_as(&at("missing/a.toml"), None).unwrap_err().to_string();
    assert!(error.starts_with("cannot write") && !error.contains('\n'), "{error}");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path().join("nothing"), at("link.toml")).unwrap();
        assert!(document.save_as(&at("link"), None).is_err());
        // A style that was opened by a link is written to where the link leads.
        std::os::unix::fs::symlink(&path, at("to-ink.toml")).unwrap();
        let mut linked = open(&at("to-ink.toml"));
        linked.set("paper.grain", 0.25).unwrap();
        linked.save().unwrap();
        assert!(read(&path).contains("grain = 0.25"));
        assert!(Path::new(&at("to-ink.toml")).symlink_metadata().unwrap().is_symlink());
    }
}

#[test]
fn a_preset_gets_the_name_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let saved = open("ink").save_as(folder.path().join("fog").to_str().unwrap(), None).unwrap();
    assert_eq!(saved.path(), Some(folder.path().join("fog.toml").as_path()));
    assert_eq!(saved.style().name, "fog");
    assert_eq!(saved.text(), preset_text("ink").unwrap().replacen("\"ink\"", "\"fog\"", 1));
    // A style with a name of its own keeps it.
    let again = saved.save_as(folder.path().join("mist.toml").to_str().unwrap(), None).unwrap();
    assert_eq!(again.style().name, "fog");
}

#[test]
fn unsaved_edits_survive() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let (mut document, path) = own(folder.path(), "ink");
    let other = own(folder.path(), "pen").0;
    let unsaved = Unsaved::within(Some(cache.clone()));
    (0..50).for_each(|number| {
        document.set("paper.grain", f64::from(number) / 100.0).unwrap();
        unsaved.keep(&document);
    });
    drop(unsaved);
    // The next start of the same style finds them, and that of another style does not.
    let unsaved = Unsaved::within(Some(cache.clone()));
    let again = open(path.to_str().unwrap());
    assert_eq!(unsaved.find(&again).as_deref(), Some(document.text()));
    assert_eq!((unsaved.find(&other), unsaved.find(&document)), (None, None));
    assert_eq!(unsaved.find(&open("ink")), None, "a preset is another style than the file with its name");
    // They are gone when they are saved.
    document.save().unwrap();
    unsaved.keep(&document);
    drop(unsaved);
    assert_eq!(std::fs::read_dir(&cache).unwrap().count(), 0);
    // Without a cache, no edits are kept, and nothing fails.
    let nowhere = Unsaved::within(None);
    nowhere.keep(&document);
    assert_eq!(nowhere.find(&document), None);
}

#[test]
fn a_changed_file_is_taken_unless_there_are_edits() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = own(folder.path(), "ink");
    let text = document.text().to_owned();
    let other = format!("# other\n{text}");
    assert_eq!(document.reload(Some(text.clone())).unwrap(), Reloaded::Unchanged);
    assert_eq!(document.reload(Some(other.clone())).unwrap(), Reloaded::Changed);
    assert!(document.text() == other && !document.is_edited());
    // An invalid text changes nothing, and the error says where it is.
    let error = document.reload(Some(other.replace("kind = \"strokes\"", "kind = \"stroces\""))).unwrap_err();
    let error = error.to_string();
    assert!(error.contains("ink.toml:") && error.contains("stroces"), "{error}");
    assert_eq!(document.text(), other);
    // With edits the user decides.
    document.set("paper.grain", 0.5).unwrap();
    let edited = document.text().to_owned();
    assert_eq!(document.reload(Some(text.clone())).unwrap(), Reloaded::Conflict(text.clone()));
    assert_eq!(document.text(), edited);
    document.load(&text).unwrap();
    assert!(document.text() == text && !document.is_edited());
    // The edits are one step away.
    assert_eq!(document.undo().unwrap(), "Change of the file");
    assert_eq!(document.text(), edited);
    document.keep_edits_over(other);
    assert!(document.is_edited());
}

#[test]
fn a_changed_recipe_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let recipe = folder.path().join("tool.toml");
    let pencil = include_str!("../../../textures/strokes/pencil.toml");
    write(&recipe, pencil);
    let path = folder.path().join("own.toml");
    write(&path, &preset_text("crosshatch").unwrap().replace("texture = \"pen\"", "texture = \"tool.toml\""));
    let mut document = open(path.to_str().unwrap());
    assert!(document.style().files.contains(&recipe));
    document.set("paper.grain", 0.5).unwrap();
    let text = document.text().to_owned();
    write(&recipe, &pencil.replacen("seed = ", "seed = 1", 1));
    // Edits that are not saved stay.
    assert_eq!(document.reload(Some(read(&path))).unwrap(), Reloaded::Changed);
    assert!(document.text() == text && document.is_edited());
    write(&recipe, "seed = [");
    assert!(document.reload(Some(read(&path))).is_err());
}

#[test]
fn an_environment_map_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("sky.hdr");
    atomic::write(&map, include_bytes!("../../tests/style_parameters/white.hdr")).unwrap();
    let path = folder.path().join("own.toml");
    write(&path, &preset_text("relief").unwrap().replacen("[relief]", "[relief]\nenvironment = \"sky.hdr\"", 1));
    let mut document = open(path.to_str().unwrap());
    document.set("light.wrap", 0.75).unwrap();
    document.save().unwrap();
    assert_eq!(*document.style(), Style::read(&path).unwrap());
    // An edit does not need the file, until it names another one.
    std::fs::remove_file(&map).unwrap();
    document.set("light.wrap", 0.5).unwrap();
    assert!(document.style().relief.as_ref().unwrap().sky.is_some());
    assert!(document.set("relief.environment", "other.hdr").is_err());
    assert!(document.reload(Some(read(&path))).is_err(), "a changed file is read again");
    document.restore("relief.environment").unwrap();
    assert!(document.style().relief.as_ref().unwrap().sky.is_none());
}

#[test]
fn every_way_to_write_a_file_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    let (other, recipe) = (folder.path().join("b.toml"), folder.path().join("more/tool.toml"));
    std::fs::create_dir(folder.path().join("more")).unwrap();
    [&path, &other, &recipe].into_iter().for_each(|path| write(path, "first"));
    let watch = FileWatch::start(|| ()).expect("this system can watch files");
    watch.follow(&[path.clone(), recipe.clone()]);
    // The watch begins in another thread.
    std::thread::sleep(Duration::from_millis(100));
    // Reading a file, and writing another one in the folder, does not count as a change.
    let _ = read(&path);
    write(&other, "second");
    assert!(!watch.wait(SOON), "nothing has changed");
    let truncate_and_write = |path: &Path| {
        let mut file = std::fs::File::options().write(true).truncate(true).open(path).unwrap();
        std::thread::sleep(Duration::from_millis(5));
        std::io::Write::write_all(&mut file, b"longer than before").unwrap();
    };
    let rename_over = |path: &Path| write(path, "renamed");
    let move_away = |path: &Path| {
        std::fs::rename(path, path.with_extension("bak")).unwrap();
        write(path, "new");
    };
    let ways: [&dyn Fn(&Path); 3] = [&truncate_and_write, &rename_over, &move_away];
    for (name, act) in ["truncate", "rename", "backup"].into_iter().zip(ways) {
        for path in [&path, &recipe] {
            let begun = Instant::now();
            act(path);
            assert!(watch.wait(SOON), "{name} of {} was not seen", path.display());
            assert!(begun.elapsed() < SOON, "{name}: {:?}", begun.elapsed());
            // It is one change.
            assert!(!watch.wait(SOON), "{name} of {} was seen twice", path.display());
        }
    }
    // Changes of files that are no longer watched are not reported.
    watch.follow(&[recipe]);
    std::thread::sleep(Duration::from_millis(100));
    rename_over(&path);
    assert!(!watch.wait(SOON));
}
