//! The version, the commit and the features that `hachure --version` prints. This file belongs to the program and not to the
//! library, because the commit changes more often than the library needs to be compiled.

use std::sync::LazyLock;

/// The commit that `packaging/release` names, such as `0123456789ab+changes 2026-11-30`.
const NAMED: Option<&str> = option_env!("HACHURE_COMMIT");

/// The commit of a packed crate, written by `build.rs`; empty in a clone.
const PACKED: &str = include_str!(concat!(env!("OUT_DIR"), "/packed_commit.txt"));

/// The optional features of the crate, and whether this program has them.
const FEATURES: [(&str, bool); 3] = [
    ("window", cfg!(feature = "window")),
    ("headset", cfg!(feature = "headset")),
    ("network", cfg!(feature = "network")),
];

/// Returns the version with the commit and the features, in one line.
pub(crate) fn line() -> &'static str {
    static LINE: LazyLock<String> = LazyLock::new(|| {
        let features: Vec<&str> = FEATURES.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect();
        let commit = NAMED.filter(|named| !named.is_empty()).unwrap_or(PACKED);
        text(env!("CARGO_PKG_VERSION"), commit, &features)
    });
    &LINE
}

fn text(version: &str, commit: &str, features: &[&str]) -> String {
    let commit = commit.split_whitespace().collect::<Vec<_>>().join(" ");
    let commit = if commit.is_empty() { "commit not recorded" } else { &commit };
    match features.is_empty() {
        true => format!("{version} ({commit}; no optional features)"),
        false => format!("{version} ({commit}; features {})", features.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_is_one_line_with_commit_and_features() {
        for (commit, features, expected) in [
            (
                "0123+changes 2026-11-30",
                &["window", "network"][..],
                "1.2.3 (0123+changes 2026-11-30; features window, network)",
            ),
            ("0123\n", &[], "1.2.3 (0123; no optional features)"),
            ("", &["headset"], "1.2.3 (commit not recorded; features headset)"),
        ] {
            assert_eq!(text("1.2.3", commit, features), expected);
        }
        assert_eq!(line().lines().count(), 1);
    }
}
