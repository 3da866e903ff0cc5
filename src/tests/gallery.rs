//! The gallery shows every preset, and the pictures of the documentation are small.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::path::{Path, PathBuf};

use hachure::style::{self, Style};

const MAX_BYTES: u64 = 400_000;

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

/// Returns whether this is an unpacked crate, from which the pictures of the documentation are left out.
fn has_no_pictures() -> bool {
    let is_packed = docs().join("../.cargo_vcs_info.json").exists();
    if is_packed {
        println!("skipped: a packed crate has no pictures of the documentation");
    }
    is_packed
}

/// Returns what the page lacks of a preset.
fn lacks(page: &str, name: &str) -> Option<String> {
    let style = Style::load(name).unwrap();
    let start = page.find(&format!("\n## {name}\n"))?;
    let section = &page[start + 1..];
    let section = section.find("\n## ").map_or(section, |end| &section[..end]);
    if !section.contains(&style.description) {
        return Some(format!("{name} has another description"));
    }
    let missing = ["near", "wide", "map"].into_iter().find(|place| {
        let picture = format!("{name}-{place}.png");
        !section.contains(&format!("({picture})")) || !docs().join("gallery").join(picture).exists()
    });
    missing.map(|place| format!("{name} has no picture {place}"))
}

#[test]
fn the_gallery_shows_every_preset() {
    if has_no_pictures() {
        return;
    }
    let page = fs::read_to_string(docs().join("gallery/README.md")).unwrap();
    for name in style::names() {
        assert!(page.contains(&format!("\n## {name}\n")), "{name} is not in the gallery: {REDRAW}");
        assert_eq!(lacks(&page, name), None, "{REDRAW}");
    }
    // Planted errors: a missing picture, and the description of something else.
    let planted = page.replace("(pencil-wide.png)", "(pen-wide.png)");
    assert_eq!(lacks(&planted, "pencil").unwrap(), "pencil has no picture wide");
    let planted = page.replace(&Style::load("wash").unwrap().description, "Oil");
    assert!(lacks(&planted, "wash").unwrap().contains("description"));
}

const REDRAW: &str = "cargo run --release --example gallery -- FOLDER redraws it";

#[test]
fn pictures_of_documents_are_small() {
    if has_no_pictures() {
        return;
    }
    let mut count = 0;
    for folder in ["pictures", "gallery"] {
        for entry in fs::read_dir(docs().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "png") {
                let bytes = fs::metadata(&path).unwrap().len();
                assert!(bytes <= MAX_BYTES, "{} has {bytes} bytes", path.display());
                count += 1;
            }
        }
    }
    assert!(count >= 3 * style::names().len(), "only {count} pictures");
}
