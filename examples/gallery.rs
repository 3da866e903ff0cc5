//! Draws the gallery: every preset in a near view, a wide view and as a map, and the page that shows them.
//!
//! `cargo run --release --example gallery -- FOLDER [PRESET...]` draws the views of `docs/gallery/places.toml`, whose
//! worlds are in FOLDER, in all presets or in the named ones, with the program that `cargo build --release` built. It
//! writes `docs/gallery/*.png` and `docs/gallery/README.md`. Pictures with few colours get a palette, which keeps the
//! files small.

#[path = "shared/small_png.rs"]
mod small_png;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail, ensure};
use hachure::file::atomic;
use hachure::style::{self, Style};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Places {
    size: String,
    place: Vec<Place>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    /// Last part of the names of the picture files.
    name: String,
    /// Caption on the page.
    title: String,
    world: PathBuf,
    camera: Option<String>,
    map: Option<String>,
}

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().map(PathBuf::from).context("name the folder of the worlds")?;
    let named: Vec<String> = arguments.collect();
    if let Some(unknown) = named.iter().find(|name| style::preset_text(name).is_none()) {
        bail!("{unknown}: no such preset");
    }
    let gallery = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/gallery");
    let path = gallery.join("places.toml");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let places: Places = toml::from_str(&text).with_context(|| path.display().to_string())?;
    let program = std::env::current_exe()?.with_file_name("").join("../hachure");
    ensure!(program.exists(), "there is no {}: cargo build --release makes it", program.display());

    let is_wanted = |name: &&str| named.is_empty() || named.iter().any(|wanted| wanted == name);
    for name in style::names().into_iter().filter(is_wanted) {
        for place in &places.place {
            let picture = gallery.join(format!("{name}-{}.png", place.name));
            draw(&program, &folder, place, name, &places.size, &picture)?;
            small_png::shrink(&picture).with_context(|| picture.display().to_string())?;
            println!("{}", picture.display());
        }
    }
    atomic::write(&gallery.join("README.md"), page(&places)?.as_bytes()).context("docs/gallery/README.md")
}

fn draw(program: &Path, folder: &Path, place: &Place, style: &str, size: &str, picture: &Path) -> anyhow::Result<()> {
    let view = match (&place.camera, &place.map) {
        (Some(camera), None) => format!("--camera={camera}"),
        (None, Some(map)) => format!("--map={map}"),
        _ => bail!("{}: a place has a camera or a map", place.name),
    };
    let mut command = Command::new(program);
    command.arg("render").arg(folder.join(&place.world)).args(["--style", style, "--size", size, &view]);
    let status = command.args(["--samples", "4", "-o"]).arg(picture).status()?;
    ensure!(status.success(), "{style} of {} was not drawn", place.name);
    if place.map.is_some() {
        // The page needs no georeference.
        for side in ["pgw", "png.aux.xml"] {
            std::fs::remove_file(picture.with_extension(side))?;
        }
    }
    Ok(())
}

fn page(places: &Places) -> anyhow::Result<String> {
    let mut page = String::from(
        "# Gallery\n\nEvery preset: a near view, a wide view and a map. `cargo run --release --example gallery -- \
         FOLDER` redraws the gallery from the SRTM tiles in FOLDER that [places.toml](places.toml) names.\n",
    );
    for name in style::names() {
        let style = Style::load(name)?;
        writeln!(page, "\n## {name}\n\n{}.\n", style.description)?;
        let titles: Vec<&str> = places.place.iter().map(|place| place.title.as_str()).collect();
        writeln!(page, "| {} |\n|{}", titles.join(" | "), " --- |".repeat(titles.len()))?;
        let picture = |place: &Place| format!("![{}]({name}-{}.png)", place.title, place.name);
        let pictures: Vec<String> = places.place.iter().map(picture).collect();
        writeln!(page, "| {} |", pictures.join(" | "))?;
    }
    Ok(page)
}
