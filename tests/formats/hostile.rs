//! Headers that claim more than their files contain are refused before memory is allocated.

use std::path::Path;
use std::time::{Duration, Instant};

use hachure::source::{self, Silent};

fn refused(path: &Path, word: &str) {
    let start = Instant::now();
    let error = source::open(path, &Silent).unwrap_err().to_string();
    assert!(error.contains(word) && !error.contains('\n'), "{error}");
    assert!(start.elapsed() < Duration::from_secs(30), "{error}");
}

#[test]
fn sizes_are_held_against_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    };
    let huge = "ncols 4000000000\nnrows 4000000000\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n";
    refused(&at("huge.asc", huge.as_bytes()), "do not fit in");
    refused(&at("fraction.asc", huge.replace("ncols 4000000000", "ncols 2.5").as_bytes()), "ncols is 2.5");
    refused(&at("word.asc", huge.replace("cellsize", "cells").as_bytes()), "unknown keyword");
    refused(&at("long.asc", format!("ncols {}", "9".repeat(100_000)).as_bytes()), "longer than any number");
    refused(&at("short.asc", b"ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n"), "truncated");

    at("huge.bil", &[0; 100]);
    at("huge.hdr", b"NROWS 4000000000\nNCOLS 4000000000\nNBITS 16\nBYTEORDER I\n");
    refused(&folder.path().join("huge.bil"), "truncated");
    // Rows that all start at one place would be any number of samples in a few bytes.
    at("flat.bil", &[0; 100]);
    at("flat.hdr", b"NROWS 40000\nNCOLS 40\nNBITS 16\nBYTEORDER I\nTOTALROWBYTES 0\n");
    refused(&folder.path().join("flat.bil"), "rows are longer");
    at("many.img", &[0; 100]);
    let many = "ENVI\nsamples = 9\nlines = 9\nbands = 18446744073709551615\ndata type = 2\ninterleave = bip\n";
    at("many.hdr", many.as_bytes());
    refused(&folder.path().join("many.img"), "too many bands");
    refused(&at("alone.hdr", b"NROWS 2\nNCOLS 2\n"), "its data file is missing");
    for name in ["bare.bil", "bare.FLT"] {
        refused(&at(name, &[0; 100]), "its header bare.hdr is missing");
    }

    // The header of a picture without the data.
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 16_000, 16_000);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[0x78, 0x9c, 3, 0, 0, 0, 0, 1]).unwrap();
    refused(&at("huge.png", &png), "do not fit in");
    refused(&at("N46E008.hgt", &[0; 999]), "1201×1201");
    refused(&at("tile.hgt", &vec![0; 1201 * 1201 * 2]), "N46E008.hgt");
    refused(&at("empty.zip", b"PK\x03\x04 and no more"), "damaged");
}
