//! The styles that a flight in a headset may choose from, and the edits of each.

use std::collections::{BTreeMap, BTreeSet};

use super::menu::Push;
use super::panel::Column;
use crate::studio::document::StyleDocument;
use crate::studio::favourites::{self, Favourites};
use crate::studio::unsaved::Unsaved;
use crate::style::controls::Control;
use crate::style::families::Family;
use crate::style::{self, Style, StyleError};

/// The styles, and the one that is drawn.
pub(super) struct Styles {
    /// Names of favourites, and of all presets: the columns of the list.
    columns: [Vec<String>; 2],
    /// The styles that were drawn, with their edits, by their names.
    documents: BTreeMap<String, StyleDocument>,
    now: StyleDocument,
    /// The style that was named when the flight began, if it is a file.
    own: Option<String>,
    unsaved: Unsaved,
    /// Names of styles with edits of an earlier run, for which the window has not asked yet. They are not replaced.
    edited_before: BTreeSet<String>,
}

impl Styles {
    /// Opens the style with a name, a preset or a file.
    ///
    /// # Errors
    /// [`StyleError`] if the style is invalid.
    pub(super) fn open(name: &str) -> Result<Self, StyleError> {
        Self::of(name, &Favourites::open(), Unsaved::open())
    }

    /// Opens a style with the favourites of a user who has set none.
    #[cfg(test)]
    pub(super) fn of_nobody(name: &str) -> Result<Self, StyleError> {
        Self::of(name, &Favourites::of_nobody(), Unsaved::within(None))
    }

    fn of(name: &str, of_user: &Favourites, unsaved: Unsaved) -> Result<Self, StyleError> {
        let now = StyleDocument::open(name)?;
        let favourites = (0..favourites::COUNT).filter_map(|digit| of_user.get(digit)).map(str::to_owned).collect();
        let mut presets: Vec<String> = style::names().into_iter().map(str::to_owned).collect();
        presets.sort_by_key(|name| (Family::of(name), Family::of(name).place(name)));
        let own = now.path().is_some().then(|| name.to_owned());
        presets.splice(0..0, own.clone());
        let edited_before = unsaved.find(&now).map(|_| name.to_owned()).into_iter().collect();
        Ok(Self { columns: [favourites, presets], documents: BTreeMap::new(), now, own, unsaved, edited_before })
    }

    /// Returns the style that is drawn.
    pub(super) fn style(&self) -> &Style {
        self.now.style()
    }

    /// Returns the name of the style for people.
    pub(super) fn title(&self) -> String {
        short(self.now.name())
    }

    /// Returns the position of a control of the style.
    pub(super) fn position(&self, control: Control) -> i8 {
        self.now.control(control)
    }

    /// Draws in another style. Edits of the current one stay until the program ends, and are kept for the window.
    ///
    /// # Errors
    /// [`StyleError`] if the style is invalid; then the current one stays.
    pub(super) fn choose(&mut self, name: &str) -> Result<(), StyleError> {
        if name == self.now.name() {
            return Ok(());
        }
        let known = self.documents.remove(name);
        let is_new = known.is_none();
        let next = known.map_or_else(|| StyleDocument::open(name), Ok)?;
        if is_new && self.unsaved.find(&next).is_some() {
            self.edited_before.insert(name.to_owned());
        }
        let before = std::mem::replace(&mut self.now, next);
        self.documents.insert(before.name().to_owned(), before);
        tracing::info!("style: {}", self.now.name());
        Ok(())
    }

    /// Draws in the next style: presets in their order, and then the own style.
    ///
    /// # Errors
    /// The errors of [`Styles::choose`].
    pub(super) fn choose_next(&mut self) -> Result<(), StyleError> {
        let mut names: Vec<&str> = style::names();
        names.extend(self.own.as_deref());
        let place = names.iter().position(|name| *name == self.now.name());
        let next = names[place.map_or(0, |place| (place + 1) % names.len())].to_owned();
        self.choose(&next)
    }

    /// Moves a control of the style, as the inspector of the window does.
    ///
    /// # Errors
    /// [`StyleError`] if the style would be invalid; then it stays.
    pub(super) fn set_control(&mut self, control: Control, to: i8) -> Result<(), StyleError> {
        if control.without_effect(self.style()).is_some() {
            return Ok(());
        }
        self.now.set_control(control, to)
    }

    /// Ends a step of editing, and keeps the edits for the window, which offers them when it opens the style.
    pub(super) fn release(&mut self) {
        self.now.release();
        if !self.edited_before.contains(self.now.name()) {
            self.unsaved.keep(&self.now);
        }
    }

    /// Returns the columns of the list, with nothing selected.
    pub(super) fn columns(&self) -> [Column; 2] {
        let choice = |name: &String| (short(name), name == self.now.name());
        let headings = ["Favourites", "All styles"];
        [0, 1].map(|i| Column {
            heading: headings[i].to_owned(),
            choices: self.columns[i].iter().map(choice).collect(),
            selected: None,
        })
    }

    /// Returns the name of the style at a place of the list.
    pub(super) fn at(&self, column: usize, row: usize) -> Option<&str> {
        self.columns.get(column)?.get(row).map(String::as_str)
    }

    /// Returns the place of the current style in the list: column and row.
    pub(super) fn place(&self) -> (usize, usize) {
        let place = |column: usize| self.columns[column].iter().position(|name| name == self.now.name());
        place(0).map(|row| (0, row)).or_else(|| place(1).map(|row| (1, row))).unwrap_or((1, 0))
    }

    /// Returns the place after a push of the stick. Below the last favourite are the presets.
    pub(super) fn moved(&self, (column, row): (usize, usize), push: Push) -> (usize, usize) {
        let [favourites, presets] = [self.columns[0].len(), self.columns[1].len()];
        let count = [favourites, presets][column];
        let within = |column: usize, row: usize| match [favourites, presets][column] {
            0 => (1 - column, 0),
            count => (column, row.min(count - 1)),
        };
        match push {
            Push::Up if row > 0 => (column, row - 1),
            Push::Up if column == 1 && favourites > 0 => (0, favourites - 1),
            Push::Down | Push::Next if row + 1 < count => (column, row + 1),
            Push::Down if column == 0 => (1, 0),
            Push::Next => within(1 - column, 0),
            Push::Left => within(0, row),
            Push::Right => within(1, row),
            Push::Around => within(1 - column, row),
            Push::Up | Push::Down => (column, row),
        }
    }
}

/// Returns the name of a preset, or that of a file without its folder and extension.
fn short(name: &str) -> String {
    std::path::Path::new(name).file_stem().map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned())
}
