//! The views of a world that the user has named, in the settings file: `[[views]]` with `world`, `name` and `camera`.
//!
//! Heights of cameras are those without exaggeration, so that a view shows the same land with any.

use std::path::PathBuf;

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, value};

use super::{recent, settings_file};
use crate::scene::camera::Camera;

/// Largest number of views of a world.
pub(crate) const COUNT: usize = 100;
/// Longest name in characters.
pub(crate) const LONGEST: usize = 80;
/// The key of the list in the settings file.
const KEY: &str = "views";

/// A view with a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NamedView {
    pub name: String,
    /// The camera, in the world's frame without exaggeration.
    pub camera: Camera,
}

/// The named views of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Views {
    /// The settings file; `None` if the views are forgotten at the end.
    path: Option<PathBuf>,
    world: String,
    list: Vec<NamedView>,
    /// Whether a name has changed that is not written.
    is_renamed: bool,
}

impl Views {
    /// Reads the views of a world, `None` is the built-in world, with the seed that replaces its own.
    pub(crate) fn open(world: Option<&str>, seed: Option<u32>) -> Self {
        Self::of_file(settings_file::path(), world, seed)
    }

    fn of_file(path: Option<PathBuf>, world: Option<&str>, seed: Option<u32>) -> Self {
        let world = recent::with_seed(world.map(recent::lasting).unwrap_or_default(), seed);
        // What is behind a question mark or before an at sign may be a password.
        let path = path.filter(|_| !(world.contains("://") && world.contains(['?', '@'])));
        let settings = path.as_deref().and_then(settings_file::document).unwrap_or_default();
        let tables = settings.get(KEY).and_then(Item::as_array_of_tables).into_iter().flatten();
        let views = tables.filter(|table| text(table, "world") == Some(&world)).filter_map(view);
        Self { list: views.take(COUNT).collect(), path, world, is_renamed: false }
    }

    /// Returns the views in the order in which they were added.
    pub(crate) fn list(&self) -> &[NamedView] {
        &self.list
    }

    /// Adds a view with a name that no other has.
    ///
    /// # Errors
    /// One line: there are too many, or the settings file cannot be written.
    pub(crate) fn add(&mut self, camera: Camera) -> Result<(), String> {
        if self.list.len() >= COUNT {
            return Err(format!("There are {COUNT} views of this world; delete one first"));
        }
        let is_taken = |name: &str| self.list.iter().any(|view| view.name == name);
        let mut names = (self.list.len() + 1..).map(|number| format!("View {number}"));
        let name = names.find(|name| !is_taken(name)).unwrap_or_default();
        self.list.push(NamedView { name, camera });
        self.keep()
    }

    /// Names a view; [`Views::keep_names`] writes it.
    pub(crate) fn rename(&mut self, index: usize, name: &str) {
        if let Some(view) = self.list.get_mut(index) {
            self.is_renamed = true;
            view.name = name.chars().filter(|sign| !sign.is_control()).take(LONGEST).collect();
        }
    }

    /// Removes a view.
    ///
    /// # Errors
    /// One line, if the settings file cannot be written.
    pub(crate) fn remove(&mut self, index: usize) -> Result<(), String> {
        if index < self.list.len() {
            self.list.remove(index);
        }
        self.keep()
    }

    /// Writes the views of this world. Those of other worlds, and everything else in the file, stay.
    ///
    /// # Errors
    /// One line with the file and the cause, if it cannot be written.
    fn keep(&mut self) -> Result<(), String> {
        self.is_renamed = false;
        let Some(path) = &self.path else { return Ok(()) };
        settings_file::change(path, |settings| self.write(settings))
    }

    /// Writes names that have changed.
    ///
    /// # Errors
    /// One line with the file and the cause, if the settings file cannot be written.
    pub(crate) fn keep_names(&mut self) -> Result<(), String> {
        if self.is_renamed { self.keep() } else { Ok(()) }
    }

    fn write(&self, settings: &mut DocumentMut) {
        let list = settings.entry(KEY).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
        if !list.is_array_of_tables() {
            *list = Item::ArrayOfTables(ArrayOfTables::new());
        }
        let Some(list) = list.as_array_of_tables_mut() else { return };
        list.retain(|table| text(table, "world") != Some(&self.world));
        for NamedView { name, camera } in &self.list {
            let mut table = Table::new();
            table.insert("world", value(&self.world));
            table.insert("name", value(name));
            table.insert("camera", value(camera.to_string()));
            list.push(table);
        }
        if list.is_empty() {
            settings.remove(KEY);
        }
    }
}

fn text<'a>(table: &'a Table, key: &str) -> Option<&'a str> {
    table.get(key).and_then(Item::as_str)
}

fn view(table: &Table) -> Option<NamedView> {
    let name = text(table, "name")?.chars().take(LONGEST).collect();
    let camera: Camera = text(table, "camera")?.parse().ok()?;
    // Without the ground, the height above it is unknown.
    (!camera.height_above_ground).then_some(NamedView { name, camera })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;

    fn camera(text: &str) -> Camera {
        text.parse().unwrap()
    }

    fn names(views: &Views) -> Vec<&str> {
        views.list().iter().map(|view| view.name.as_str()).collect()
    }

    #[test]
    fn each_world_has_its_views_over_a_restart() {
        let folder = tempfile::tempdir().unwrap();
        let settings = folder.path().join("settings.toml");
        atomic::write(&settings, b"# mine\nfavourites = [\"pen\"]\n").unwrap();
        let open = |world: Option<&str>| Views::of_file(Some(settings.clone()), world, None);
        let mut alps = open(Some("/data/alps.tif"));
        assert!(alps.list().is_empty());
        alps.add(camera("1,2,300,4,-5,60")).unwrap();
        alps.add(camera("1,2,300.5,4,-5,60")).unwrap();
        let mut own = open(None);
        own.add(camera("9,9,9,9,9,9")).unwrap();
        alps.rename(0, "North\nface \"A\"");
        assert_eq!(names(&open(Some("/data/alps.tif")))[0], "View 1", "not while it is typed");
        alps.keep_names().unwrap();
        let again = open(Some("/data/alps.tif"));
        assert_eq!(names(&again), ["Northface \"A\"", "View 2"]);
        assert_eq!(again.list()[1].camera, camera("1,2,300.5,4,-5,60"));
        assert_eq!(names(&open(None)), ["View 1"]);
        let of_seed = |seed| Views::of_file(Some(settings.clone()), None, seed);
        assert!(of_seed(Some(2)).list().is_empty(), "the land of another seed has its own");
        // A number that is gone is given again, and never twice.
        alps.remove(0).unwrap();
        alps.add(camera("0,0,0,0,0,50")).unwrap();
        assert_eq!(names(&open(Some("/data/alps.tif"))), ["View 2", "View 3"]);
        own.remove(0).unwrap();
        assert!(open(None).list().is_empty() && open(Some("/data/alps.tif")).list().len() == 2);
        let text = std::fs::read_to_string(&settings).unwrap();
        assert!(text.starts_with("# mine\nfavourites = [\"pen\"]\n"), "{text}");
    }

    #[test]
    fn views_that_make_no_sense_are_left_out_and_passwords_are_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let settings = folder.path().join("settings.toml");
        let text = "[[views]]\nworld = \"\"\nname = \"a\"\ncamera = \"1,2\"\n[[views]]\nworld = \"\"\nname = \"b\"\n\
                    camera = \"0,0,+5,0,0,50\"\n[[views]]\nworld = 3\n[[views]]\nworld = \"\"\nname = \"c\"\n\
                    camera = \"0,0,5,0,0,50\"\n";
        for (text, wanted) in [(text, vec!["c"]), ("views = 3\n", vec![]), ("[", vec![])] {
            atomic::write(&settings, text.as_bytes()).unwrap();
            assert_eq!(names(&Views::of_file(Some(settings.clone()), None, None)), wanted, "{text}");
        }
        std::fs::remove_file(&settings).unwrap();
        let mut secret = Views::of_file(Some(settings.clone()), Some("https://host/a.tif?signature=abc"), None);
        secret.add(camera("0,0,5,0,0,50")).unwrap();
        assert!(secret.list().len() == 1 && !settings.exists());
        let mut many = Views::of_file(None, None, None);
        (0..COUNT).for_each(|_| many.add(camera("0,0,5,0,0,50")).unwrap());
        assert!(many.add(camera("0,0,5,0,0,50")).unwrap_err().contains("100 views"));
    }
}
