//! Successful commands print nothing to standard error.

use std::process::Command;

use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::dem::dem;
use crate::{Place, full};

#[test]
fn a_drawing_without_a_desktop_is_silent() {
    if std::env::var_os("HACHURE_REQUIRE_GPU").is_none() && Gpu::open(&AdapterWish::Best).is_err() {
        println!("skipped: no GPU");
        return;
    }
    let place = Place::empty();
    dem(&place);
    let style = if full() { "ink" } else { "lsa" };
    let view = ["--camera=-900,-900,+150,40,-12,60", "--size", "96x54", "--style", style];
    let arguments = [&["render", "dem.tif", "-o", "out.png"][..], &view].concat();
    // The first run bakes, and reports it.
    place.text(&arguments);
    let output = place.hachure(&arguments);
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    // Planted error: a runtime folder that libwayland does not accept, where Mesa was built with it.
    let mut program = Command::new(env!("CARGO_BIN_EXE_hachure"));
    program.args(&arguments).current_dir(place.path("")).env("HACHURE_CACHE", place.path("cache"));
    let output = program.env("XDG_RUNTIME_DIR", "no/whole/path").env_remove("RUST_LOG").output().unwrap();
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    match printed.contains("XDG_RUNTIME_DIR") {
        true => println!("Mesa printed its warning: {printed}"),
        false => println!("this driver prints no warning about XDG_RUNTIME_DIR"),
    }
}
