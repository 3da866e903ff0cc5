//! `hachure render` as a program, in a folder of its own.

use std::path::Path;
use std::process::{Command, Output};

/// Runs it in `folder`, where its cache is too, with arguments that blanks part.
pub fn run(folder: &Path, arguments: &str) -> Output {
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

/// The same, which must succeed.
pub fn draw(folder: &Path, arguments: &str) {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
}
