//! The form of a refusal: one line under 200 characters that names the file.

use std::path::Path;

use super::seeds::Seed;

const MAX_CHARS: usize = 200;

const CONTROL: &str = "has more than one line, or control characters";
const LONG: &str = "is longer than 199 characters";
const NAMELESS: &str = "does not name the file";

/// Returns what is wrong with a refusal of these files. The path of their folder does not count, since its length
/// varies.
pub(crate) fn fault(seed: &Seed, message: &str) -> Option<String> {
    let folder = if seed.entry.is_empty() { seed.folder.parent() } else { Some(seed.folder.as_path()) };
    let folder = format!("{}/", folder.unwrap_or(Path::new("")).display());
    let shown = message.replace(&folder, "");
    let is_named = seed.names().any(|name| shown.contains(name));
    let wrong = if shown.chars().any(char::is_control) {
        CONTROL
    } else if shown.chars().count() >= MAX_CHARS {
        LONG
    } else if !is_named {
        NAMELESS
    } else {
        return None;
    };
    Some(format!("a refusal that {wrong}: {shown:?}"))
}
