//! Tests standard output whose reader has gone, or that is on a full disk.

#![cfg(target_os = "linux")]

use std::fs::File;
use std::process::Stdio;

use crate::place::{Place, finished, has_gpu, one_line};

/// Runs with standard output into a pipe whose reader has gone.
fn into_closed_pipe(place: &Place, arguments: &[&str]) {
    let mut child = place.command(arguments).spawn().unwrap();
    drop(child.stdout.take());
    let output = finished(child, arguments);
    assert!(output.status.success(), "{arguments:?}: {output:?}");
}

/// Runs with standard output on a full disk.
fn onto_full_disk(place: &Place, arguments: &[&str]) {
    let full = File::options().write(true).open("/dev/full").unwrap();
    let output = finished(place.command(arguments).stdout(full).spawn().unwrap(), arguments);
    let line = one_line(&output, arguments);
    assert!(line.starts_with("cannot write standard output: "), "{arguments:?}: {line}");
}

#[test]
fn answers_that_find_no_reader_are_no_failure_and_those_without_room_are() {
    let place = Place::empty();
    place.geotiff("dem.tif", 0);
    for arguments in [
        &["info", "dem.tif"][..],
        &["info", "dem.tif", "--json"],
        &["styles"],
        &["styles", "--json"],
        &["styles", "show", "ink"],
        &["bake", "dem.tif", "-o", "baked.tif"],
        &["bake", "dem.tif", "-o", "baked.tif", "--json"],
    ] {
        into_closed_pipe(&place, arguments);
        onto_full_disk(&place, arguments);
    }
    assert!(place.path("baked.tif").exists());
}

#[test]
fn pictures_are_written_even_if_nobody_hears_of_them() {
    if !has_gpu() {
        return;
    }
    let place = Place::empty();
    place.geotiff("dem.tif", 0);
    let render = |more: &[&'static str]| [&["render", "dem.tif", "--size", "64x36"], more].concat();
    for (name, arguments) in [
        ("a.png", render(&["-o", "a.png", "--style", "plain", "--json"])),
        // A style for which nothing is left out, so that the only line is the failure.
        ("b.svg", render(&["-o", "b.svg", "--style", "engraving"])),
    ] {
        into_closed_pipe(&place, &arguments);
        assert!(place.path(name).exists());
        onto_full_disk(&place, &arguments);
    }
}

#[test]
fn a_complaint_that_cannot_be_written_is_still_a_failure() {
    let place = Place::empty();
    place.geotiff("folder/a.tif", 0);
    for (arguments, status) in [
        (&["info", "nowhere.tif"][..], 1),
        // A run that also writes a log.
        (&["bake", "nowhere.tif", "-o", "x.tif", "-vv"], 1),
        (&["styles", "list", "-vv"], 0),
    ] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let output = finished(place.command(arguments).stderr(full).spawn().unwrap(), arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}");
        let mut child = place.command(arguments).stdout(Stdio::null()).spawn().unwrap();
        drop(child.stderr.take());
        assert_eq!(finished(child, arguments).status.code(), Some(status), "{arguments:?}");
    }
}
