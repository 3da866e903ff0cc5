//! Runs `hachure render` as a process, in a temporary folder.

use std::path::Path;
use std::process::{Command, Output};

/// Returns whether the long tier of the tests is wanted (`./check --full`).
#[allow(dead_code, reason = "not every test that shares this file needs it")]
pub(crate) fn full() -> bool {
    std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full")
}

/// Runs the program in `folder`, which also holds its cache, with arguments separated by spaces.
pub(crate) fn run(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hachure"))
        .arg("render")
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .env("HACHURE_CACHE", folder.join("cache"))
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("RUST_LOG")
        .output()
        .unwrap()
}

/// Runs the program, which must succeed.
pub(crate) fn draw(folder: &Path, arguments: &str) {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
}
