//! What a refusal looks like: one line under 200 characters that names the file.

use std::path::Path;

use super::seeds::Seed;

const MAX_CHARS: usize = 200;

/// Refusals that are known to break the rule: the kind, how they break it, a part of the refusal, and the reason. Each is
/// to be mended; none may be added without a reason.
const KNOWN: &[(&str, &str, &str, &str)] = &[
    ("style", NAMELESS, ": no such stroke texture", "the style that asks for it is not named"),
    ("style", NAMELESS, ": no such marks", "the style that asks for them is not named"),
];

const CONTROL: &str = "has more than one line, or control characters";
const LONG: &str = "is longer than 199 characters";
const NAMELESS: &str = "does not name the file";

/// What is wrong with a refusal of these files. The folder that they are in does not count: its name is as long as it
/// is.
pub fn fault(kind: &str, seed: &Seed, message: &str) -> Option<String> {
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
    let is_known = KNOWN.iter().any(|(of, how, part, _)| *of == kind && *how == wrong && shown.contains(part));
    (!is_known).then(|| format!("a refusal that {wrong}: {shown:?}"))
}
