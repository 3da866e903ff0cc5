//! The tests of the Python package (`python/tests`), with the extension that cargo has built as an example.
//!
//! They need Python with numpy: `HACHURE_PYTHON` names another interpreter than `python3`. Without xarray, rasterio or
//! matplotlib, what needs them is left out.

#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use std::path::{Path, PathBuf};
use std::process::Command;

const PROGRAM: &str = env!("CARGO_BIN_EXE_hachure");

/// Returns the interpreter, if there is one with numpy.
fn python() -> Option<String> {
    let python = std::env::var("HACHURE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Command::new(&python).args(["-c", "import sys, numpy; sys.exit(sys.version_info < (3, 10))"]).output();
    match found {
        Ok(output) if output.status.success() => Some(python),
        _ => {
            println!("skipped: {python} is not Python 3.10 or later with numpy");
            None
        }
    }
}

/// Returns the extension that cargo has built, if it has.
fn extension() -> Option<PathBuf> {
    let examples = Path::new(PROGRAM).with_file_name("examples");
    let (prefix, ending) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let extension = examples.join(format!("{prefix}hachure_python{ending}"));
    if extension.is_file() {
        return Some(extension);
    }
    println!("skipped: no {}; build it with --example hachure_python", extension.display());
    None
}

/// Makes the package in a folder: its files in Python, and the extension.
fn package(folder: &Path, extension: &Path) {
    let package = folder.join("hachure");
    std::fs::create_dir(&package).unwrap();
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("python/hachure")).unwrap() {
        let entry = entry.unwrap();
        if entry.file_type().unwrap().is_file() {
            std::fs::copy(entry.path(), package.join(entry.file_name())).unwrap();
        }
    }
    let name = if cfg!(windows) { "_hachure.pyd" } else { "_hachure.abi3.so" };
    std::fs::copy(extension, package.join(name)).unwrap();
}

/// Runs one file of tests; its output is printed.
fn run(file: &str) {
    let (Some(python), Some(extension)) = (python(), extension()) else { return };
    let folder = tempfile::tempdir().unwrap();
    package(folder.path(), &extension);
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/tests");
    let output = Command::new(python)
        .arg(tests.join(file))
        .arg("-v")
        .env("PYTHONPATH", folder.path())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("HACHURE_PROGRAM", PROGRAM)
        .output()
        .unwrap();
    println!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{file}: {}", output.status);
}

#[test]
fn pictures_are_those_of_the_program() {
    run("test_pictures.py");
}

#[test]
fn errors_are_exceptions() {
    run("test_errors.py");
}

#[test]
fn styles_channels_films_and_threads() {
    run("test_rest.py");
}

#[test]
fn notebooks_run() {
    run("test_notebooks.py");
}
