//! The suites of benchmarks that are compiled into the program: `benches/suites`.

/// A built-in suite: its name, and its files with their texts.
pub(super) struct BuiltIn {
    pub name: &'static str,
    pub files: &'static [(&'static str, &'static str)],
}

/// Name of the file that lists the tables.
pub(super) const SUITE_FILE: &str = "suite.toml";

/// Lists the files of a folder of `benches/suites`.
macro_rules! suite {
    ($name:literal, $($file:literal),+) => {
        BuiltIn {
            name: $name,
            files: &[$(($file, include_str!(concat!("../../../benches/suites/", $name, "/", $file)))),+],
        }
    };
}

pub(super) static SUITES: [BuiltIn; 8] = [
    suite!("pietrok", "suite.toml", "hills.toml", "mountain.toml", "wide.csv", "low.csv", "mountain.csv"),
    suite!("lsa", "suite.toml"),
    suite!("stereo", "suite.toml", "near.csv"),
    suite!("tone-lines", "suite.toml", "small.toml", "large.toml", "turn.csv"),
    suite!("relief", "suite.toml"),
    suite!("hatching", "suite.toml", "none.toml", "as-is.toml", "blend.toml", "three.toml", "add.toml"),
    suite!("forest", "suite.toml", "1e3.toml", "1e4.toml", "1e5.toml", "1e6.toml", "1e7.toml", "1e8.toml", "over.csv"),
    suite!("world", "suite.toml", "1e6.toml", "1e7.toml", "1e8.toml", "1e9.toml", "1e10.toml", "1e11.toml", "low.csv"),
];
