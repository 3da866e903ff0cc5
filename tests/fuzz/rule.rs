//! What a refusal looks like: one line under 200 characters that names the file.

use super::seeds::Seed;

const MAX_CHARS: usize = 200;

/// Refusals that are known to break the rule, by kind (or `*`) and a part of them, with the reason why that is so. Each
/// is to be mended; none may be added without a reason.
const KNOWN: &[(&str, &str, &str)] = &[];

/// What is wrong with a refusal of these files. The folder that they are in does not count: its name is as long as it
/// is.
pub fn fault(kind: &str, seed: &Seed, message: &str) -> Option<String> {
    let folder = format!("{}/", seed.folder.display());
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
