//! What a refusal looks like: one line under 200 characters that names the file.

use std::path::Path;

use super::seeds::Seed;

const MAX_CHARS: usize = 200;

/// Refusals that are known to break the rule, by kind (or `*`) and a part of them, with the reason why that is so. Each
/// is to be mended; none may be added without a reason.
const KNOWN: &[(&str, &str, &str)] = &[
    ("*", "unknown field `", "the parser of TOML lists all keys that there are, and echoes the wrong one whole"),
    ("*", "unknown variant `", "the same for words"),
    ("*", "invalid type: ", "the parser of TOML echoes a value whole"),
    ("scene", ".toml:", "the parser of TOML echoes a key whole, with its control characters"),
    ("scene", "the camera's ", "a value is echoed whole"),
    ("camera-path", "the header is `", "a header is echoed whole"),
    ("camera-path", "the camera's ", "a value is echoed whole"),
    ("camera-path", "t is `", "a value is echoed whole"),
    ("*", "the crs \"", "a value is echoed whole"),
    ("style", "no such stroke texture", "the style that asks for it is not named"),
    ("style", "no such marks", "the style that asks for them is not named"),
];

/// What is wrong with a refusal of these files. The folder that they are in does not count: its name is as long as it
/// is.
pub fn fault(kind: &str, seed: &Seed, message: &str) -> Option<String> {
    let folder = if seed.entry.is_empty() { seed.folder.parent() } else { Some(seed.folder.as_path()) };
    let folder = format!("{}/", folder.unwrap_or(Path::new("")).display());
    let shown = message.replace(&folder, "");
    let is_named = seed.names().any(|name| shown.contains(name));
    let wrong = if shown.chars().any(char::is_control) {
        "has more than one line, or control characters"
    } else if shown.chars().count() >= MAX_CHARS {
        "is longer than 199 characters"
    } else if !is_named {
        "does not name the file"
    } else {
        return None;
    };
    let is_known = KNOWN.iter().any(|(of, part, _)| (*of == "*" || *of == kind) && shown.contains(part));
    (!is_known).then(|| format!("a refusal that {wrong}: {shown:?}"))
}
