//! The lines of a camera path's text: which is the header, and which are rows. All others stay as they are.

use crate::scene::path::{EASE, HEADER, Key};

/// The lines of a text, with their ends.
pub(super) struct Lines {
    lines: Vec<String>,
    header: usize,
    /// Index of the line of each row.
    rows: Vec<usize>,
    end: &'static str,
}

impl Lines {
    /// Returns the lines of a text; `None` if they are not those of its rows, or there is no header.
    pub(super) fn of(text: &str) -> Option<Self> {
        let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
        if text.contains('"') || text.replace("\r\n", "").contains('\r') {
            return None;
        }
        let lines: Vec<String> = text.split_inclusive('\n').map(str::to_owned).collect();
        let is_content = |line: &str| !line.starts_with('#') && !line.trim_end_matches(['\r', '\n']).is_empty();
        let mut content = (0..lines.len()).filter(|index| is_content(&lines[*index]));
        let header = content.next()?;
        let rows = content.collect();
        Some(Self { lines, header, rows, end })
    }

    /// Returns the lines of keys.
    pub(super) fn of_keys(keys: &[Key]) -> Self {
        let has_ease = keys.iter().any(|key| key.ease != 0.0);
        let mut header = HEADER.join(",");
        if has_ease {
            header = format!("{header},{EASE}");
        }
        let rows = keys.iter().map(|key| format!("{}\n", row(key, has_ease)));
        let lines = std::iter::once(format!("{header}\n")).chain(rows).collect();
        Self { lines, header: 0, rows: (1..=keys.len()).collect(), end: "\n" }
    }

    /// Returns the number of rows.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn text(&self) -> String {
        self.lines.concat()
    }

    /// Returns whether the header is that of a camera path.
    pub(super) fn has_header(&self) -> bool {
        let names = self.lines[self.header].trim_start_matches('\u{feff}').split(',').map(str::trim);
        names.eq(HEADER) || self.has_ease() && self.lines[self.header].split(',').count() == HEADER.len() + 1
    }

    pub(super) fn has_ease(&self) -> bool {
        self.lines[self.header].trim_end().rsplit(',').next().is_some_and(|name| name.trim() == EASE)
    }

    /// Inserts a row before the row `index`, behind the row before it.
    pub(super) fn insert(&mut self, index: usize, key: &Key) {
        let line = index.checked_sub(1).map_or(self.header, |before| self.rows[before]) + 1;
        if let Some(last) = self.lines.last_mut().filter(|last| !last.ends_with('\n')) {
            last.push_str(self.end);
        }
        self.lines.insert(line, format!("{}{}", row(key, self.has_ease()), self.end));
        self.rows.iter_mut().filter(|row| **row >= line).for_each(|row| *row += 1);
        self.rows.insert(index, line);
    }

    pub(super) fn remove(&mut self, index: usize) {
        let line = self.rows.remove(index);
        self.lines.remove(line);
        self.rows.iter_mut().filter(|row| **row > line).for_each(|row| *row -= 1);
    }

    pub(super) fn replace(&mut self, index: usize, key: &Key) {
        let text = row(key, self.has_ease());
        self.with_content(self.rows[index], |_| text);
    }

    /// Changes the time of a row, and nothing else of it.
    pub(super) fn set_time(&mut self, index: usize, time_s: f64) {
        self.with_content(self.rows[index], |content| {
            format!("{time_s},{}", content.split_once(',').map_or("", |(_, rest)| rest))
        });
    }

    /// Changes the ease of a row, and nothing else of it. Without the column, it is added to all rows.
    pub(super) fn set_ease(&mut self, index: usize, ease: f64) {
        if !self.has_ease() {
            self.with_content(self.header, |content| format!("{content},{EASE}"));
            for line in self.rows.clone() {
                self.with_content(line, |content| format!("{content},0"));
            }
        }
        self.with_content(self.rows[index], |content| {
            format!("{},{ease}", content.rsplit_once(',').map_or("", |(rest, _)| rest))
        });
    }

    /// Removes the column of ease.
    pub(super) fn drop_ease(&mut self) {
        if !self.has_ease() {
            return;
        }
        for line in self.rows.iter().copied().chain([self.header]).collect::<Vec<_>>() {
            self.with_content(line, |content| content.rsplit_once(',').map_or("", |(rest, _)| rest).to_owned());
        }
    }

    /// Changes a line without its end.
    fn with_content(&mut self, line: usize, change: impl FnOnce(&str) -> String) {
        let line = &mut self.lines[line];
        let content = line.trim_end_matches(['\r', '\n']);
        *line = format!("{}{}", change(content), &line[content.len()..]);
    }
}

/// Returns a row without the end of its line.
fn row(key: &Key, has_ease: bool) -> String {
    let row = format!("{},{}", key.time_s, key.camera);
    if has_ease { format!("{row},{}", key.ease) } else { row }
}
