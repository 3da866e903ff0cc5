//! Lines of progress on standard error, for a program that runs hachure.
//!
//! A program that sets `HACHURE_PROGRESS=lines` reads lines like `progress 0.4200 drawing`; all other lines are messages.

/// The environment variable that requests lines, and the value that it must have.
pub(crate) const VARIABLE: &str = "HACHURE_PROGRESS";
pub(crate) const LINES: &str = "lines";
/// The first word of a line.
const WORD: &str = "progress ";

/// Returns whether the program that runs hachure reads lines of progress.
pub(crate) fn are_read() -> bool {
    std::env::var_os(VARIABLE).is_some_and(|value| value == LINES)
}

/// Returns a line.
pub(crate) fn line(what: &str, done: f32) -> String {
    format!("{WORD}{done:.4} {what}")
}

/// Reads a line; `None` if it is a message.
#[cfg(feature = "window")]
pub(crate) fn parse(line: &str) -> Option<(&str, f32)> {
    let (done, what) = line.strip_prefix(WORD)?.split_once(' ')?;
    Some((what, done.parse().ok().filter(|done: &f32| done.is_finite())?))
}

#[cfg(all(test, feature = "window"))]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_as_they_are_written() {
        assert_eq!(parse(&line("reading heights", 0.25)), Some(("reading heights", 0.25)));
        for message in ["warning: the picture is nearly blank", "progress", "progress x y", "progress NaN a", ""] {
            assert_eq!(parse(message), None, "{message}");
        }
    }
}
