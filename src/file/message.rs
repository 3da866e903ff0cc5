//! Formatting of messages: foreign text, file names, causes, and the nearest known name.
//!
//! Arguments, file contents and server answers may contain anything: megabytes, line breaks, or escape sequences that a
//! terminal executes. Such text only enters a message through [`shown`], [`quoted`] or [`named`].
//!
//! The rule for errors of this crate: `Display` gives the whole message in one line, causes included, and `source()`
//! returns the causes as values. [`chain`] is for errors that may not follow this rule; it adds the causes that the
//! message does not contain yet.

use std::error::Error;
use std::path::Path;

/// Largest number of characters of a foreign text.
const LONGEST_TEXT: usize = 80;
/// Largest number of characters of a foreign text in a message with more texts.
const BRIEF_TEXT: usize = 50;
/// Largest number of characters of a path. It is longer, because the user needs the path to find the file.
const LONGEST_NAME: usize = 120;
/// Smallest similarity (0 to 1) at which one name is suggested for another.
const SIMILAR: f64 = 0.84;

/// Formats a foreign text for a message: control characters are escaped, and a long text is shortened to its beginning
/// and end, at most 80 characters in all.
pub(crate) fn shown(text: &str) -> String {
    cut(text, LONGEST_TEXT)
}

/// Formats a text as [`shown`] does, at most 50 characters of it, for a message that also lists the known texts.
pub(crate) fn brief(text: &str) -> String {
    cut(text, BRIEF_TEXT)
}

/// Formats a text as [`shown`] does, in quotation marks.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", shown(text))
}

/// Formats a path for a message as [`shown`] does, but allows more characters and keeps its end, which is the file's
/// own name.
pub(crate) fn named(path: impl AsRef<Path>) -> String {
    cut(&path.as_ref().to_string_lossy(), LONGEST_NAME)
}

/// Formats a complete message for a terminal: one line, control characters escaped, at most `longest` characters.
pub fn printable(message: &str, longest: usize) -> String {
    cut(&one_line(message), longest)
}

/// Formats a text of several lines for a terminal: control characters other than line breaks and tabs are escaped.
pub(crate) fn harmless(text: &str) -> String {
    text.chars().map(|it| if matches!(it, '\n' | '\t') { it.to_string() } else { seen(it) }).collect()
}

/// Returns whether a character would control the terminal or the text direction instead of being visible.
fn acts(character: char) -> bool {
    let directions = matches!(character, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    character.is_control() || directions || character == '\u{feff}'
}

/// Escapes a control character; returns other characters unchanged.
fn seen(character: char) -> String {
    if acts(character) { character.escape_default().to_string() } else { character.to_string() }
}

/// Shortens a text to `most` characters by removing its middle; more of the end is kept than of the beginning.
fn cut(text: &str, most: usize) -> String {
    let within = |pieces: &mut dyn Iterator<Item = String>, most: usize| {
        let mut length = 0;
        let mut kept = Vec::new();
        for piece in pieces {
            length += piece.chars().count();
            if length > most {
                return (kept, false);
            }
            kept.push(piece);
        }
        (kept, true)
    };
    let (whole, fits) = within(&mut text.chars().map(seen), most);
    if fits {
        return whole.concat();
    }
    let (start, _) = within(&mut text.chars().map(seen), most / 3);
    let (mut end, _) = within(&mut text.chars().rev().map(seen), most - most / 3 - 1);
    end.reverse();
    format!("{}…{}", start.concat(), end.concat())
}

/// Replaces line breaks and runs of spaces by single spaces, for foreign text in error messages.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Returns a number with a noun in the singular or plural: `1 line`, `2 lines`.
pub(crate) fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Returns an error's message, followed by that of each cause that it does not contain already.
pub fn chain(error: &(dyn Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let words = error.to_string();
        if !text.contains(words.trim()) {
            text = format!("{text}: {words}");
        }
        cause = error.source();
    }
    text
}

/// Returns the known name that `name` probably stands for.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Longer names are not typing mistakes, and comparing them would be slow.
    if name.chars().count() > LONGEST_TEXT {
        return None;
    }
    let name = name.to_lowercase();
    // Keys of one table are not alike because they begin with its name.
    let table = name.rsplit_once('.').map_or(0, |(table, _)| table.len() + 1);
    let likeness = |known: &str| {
        let is_of_table = known.len() > table && known.is_char_boundary(table) && known[..table] == name[..table];
        let (name, known) = if is_of_table { (&name[table..], &known[table..]) } else { (&*name, known) };
        let is_part = name.len() >= 4 && known.len() >= 4 && (known.contains(name) || name.contains(known));
        let alike = strsim::jaro_winkler(name, known).max(strsim::normalized_damerau_levenshtein(name, known) + 0.2);
        if is_part { alike.max(SIMILAR) } else { alike }
    };
    let known = known.into_iter().map(|known| (likeness(known), known)).filter(|(alike, _)| *alike >= SIMILAR);
    known.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, known)| known)
}

/// Returns `; did you mean "ink"?` if a known name is similar, else an empty string.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(name, known).map_or(String::new(), |known| format!("; did you mean \"{known}\"?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_texts_are_short_and_harmless() {
        assert_eq!(shown("terrain/alps.tif, α and 山"), "terrain/alps.tif, α and 山");
        assert_eq!(shown("a\u{1b}[31m\nb\u{202e}\u{7f}"), "a\\u{1b}[31m\\nb\\u{202e}\\u{7f}");
        let long = shown(&format!("begin{}end", "\u{1b}".repeat(1 << 20)));
        assert!(long.chars().count() <= LONGEST_TEXT && long.starts_with("begin") && long.ends_with("end"), "{long}");
        // No escape sequence is cut in two.
        assert_eq!(long.matches('{').count(), long.matches('}').count());
        assert_eq!(shown(&"x".repeat(80)), "x".repeat(80));
        let file = format!("/{}/ridge.tif", "deep/".repeat(99));
        assert!(named(&file).ends_with("/ridge.tif") && named(&file).chars().count() <= LONGEST_NAME);
        assert_eq!(printable("two\nlines \u{1b}", 99), "two lines \\u{1b}");
    }

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let styles = ["plain", "ink", "sobel", "strokes", "pen", "brush", "pencil", "hachures"];
        for (name, expected) in [
            ("inc", Some("ink")),
            ("INK", Some("ink")),
            ("stroke", Some("strokes")),
            ("pencl", Some("pencil")),
            ("hachure", Some("hachures")),
            ("oil", None),
            ("", None),
            ("x", None),
            ("photograph", None),
        ] {
            assert_eq!(nearest(name, styles), expected, "{name}");
        }
        let keys = ["azimuth_deg", "elevation_deg", "vertical_exaggeration"];
        assert_eq!(nearest("azimut", keys), Some("azimuth_deg"));
        assert_eq!(nearest("vertical_exageration", keys), Some("vertical_exaggeration"));
        assert_eq!(nearest("exaggeration", keys), Some("vertical_exaggeration"));
        assert_eq!(did_you_mean("colour", keys), "");
    }

    #[derive(Debug, thiserror::Error)]
    #[error("{words}")]
    struct TestError {
        words: &'static str,
        source: std::io::Error,
    }

    #[test]
    fn causes_are_printed_once() {
        let error_with = |words| TestError { words, source: std::io::Error::other("disk on fire") };
        assert_eq!(chain(&error_with("a.tif: cannot be read")), "a.tif: cannot be read: disk on fire");
        assert_eq!(chain(&error_with("a.tif: disk on fire, it seems")), "a.tif: disk on fire, it seems");
    }
}
