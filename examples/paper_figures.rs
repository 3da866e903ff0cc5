//! Redraws figures of papers, on models and on land, and writes the page that shows them.
//!
//! `cargo run --release --example paper_figures -- LAND MODELS` draws the pictures that `docs/papers/figures.toml`
//! lists, from DEMs in the folder LAND and OBJ files in MODELS, with the program that `cargo build --release` built. It
//! writes `docs/papers/*.png` and `docs/papers/README.md`. A model is placed on level ground.

#[path = "shared/small_png.rs"]
mod small_png;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail, ensure};
use hachure::file::atomic;
use hachure::style::Style;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Figures {
    size: String,
    figure: Vec<Figure>,
}

/// A figure: pictures side by side, with a title and a text.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Figure {
    title: String,
    /// The paper, the figure, and what it shows.
    about: String,
    picture: Vec<Picture>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Picture {
    /// File name of the picture, without extension.
    name: String,
    /// A preset, or a style file in the folder of the list.
    style: String,
    /// A DEM in the folder of land.
    land: Option<PathBuf>,
    /// An OBJ file in the folder of models.
    model: Option<PathBuf>,
    /// Height of the model's origin above the ground, in metres.
    #[serde(default)]
    lift_m: f64,
    camera: Option<String>,
    map: Option<String>,
}

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let folders = [(); 2].map(|()| arguments.next());
    let [Some(land), Some(models)] = folders else { bail!("name the folders of land and of models") };
    let page_folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/papers");
    let path = page_folder.join("figures.toml");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let figures: Figures = toml::from_str(&text).with_context(|| path.display().to_string())?;
    let program = std::env::current_exe()?.with_file_name("").join("../hachure");
    ensure!(program.exists(), "there is no {}: cargo build --release makes it", program.display());
    let scratch = std::env::temp_dir().join("hachure paper figures");
    std::fs::create_dir_all(&scratch)?;
    for picture in figures.figure.iter().flat_map(|figure| &figure.picture) {
        let file = page_folder.join(format!("{}.png", picture.name));
        let world = world(picture, [&land, &models], &scratch)?;
        draw(&program, picture, &world, &page_folder, &figures.size, &file)?;
        small_png::shrink(&file).with_context(|| file.display().to_string())?;
        println!("{}", file.display());
    }
    atomic::write(&page_folder.join("README.md"), page(&figures, &page_folder)?.as_bytes())
        .context("docs/papers/README.md")
}

/// Returns the DEM, or writes and returns a scene with a model on level ground.
fn world(picture: &Picture, [land, models]: [&Path; 2], scratch: &Path) -> anyhow::Result<PathBuf> {
    let model = match (&picture.land, &picture.model) {
        (Some(file), None) => return Ok(land.join(file)),
        (None, Some(model)) => models.join(model).canonicalize().with_context(|| model.display().to_string())?,
        _ => bail!("{}: a picture has land or a model", picture.name),
    };
    const SIDE: usize = 65;
    let row = ["0"; SIDE].join(" ") + "\n";
    let ground = format!("ncols {SIDE}\nnrows {SIDE}\nxllcorner 0\nyllcorner 0\ncellsize 1\n{}", row.repeat(SIDE));
    atomic::write(&scratch.join("ground.asc"), ground.as_bytes())?;
    let scene = format!(
        "[world]\ndem = \"ground.asc\"\n[[meshes]]\nfile = {:?}\nat = [0.0, 0.0, {:.1}]\nscale = 10.0\n",
        model.display().to_string(),
        picture.lift_m
    );
    let path = scratch.join(format!("{}.toml", picture.name));
    atomic::write(&path, scene.as_bytes())?;
    Ok(path)
}

fn draw(
    program: &Path,
    picture: &Picture,
    world: &Path,
    page_folder: &Path,
    size: &str,
    file: &Path,
) -> anyhow::Result<()> {
    let view = match (&picture.camera, &picture.map) {
        (Some(camera), None) => format!("--camera={camera}"),
        (None, Some(map)) => format!("--map={map}"),
        _ => bail!("{}: a picture has a camera or a map", picture.name),
    };
    let mut command = Command::new(program);
    command.current_dir(page_folder).arg("render").arg(world);
    command.args(["--style", &picture.style, "--size", size, &view, "--samples", "4", "-o"]).arg(file);
    if picture.model.is_some() {
        command.arg("--trust-scene");
    }
    ensure!(command.status()?.success(), "{} was not drawn", picture.name);
    if picture.map.is_some() {
        for side in ["pgw", "prj"] {
            std::fs::remove_file(file.with_extension(side))?;
        }
    }
    Ok(())
}

fn page(figures: &Figures, page_folder: &Path) -> anyhow::Result<String> {
    let mut page = String::from(
        "# Figures of papers\n\nMethods of published papers, drawn by hachure on models and on land. `cargo run \
         --release --example paper_figures -- LAND MODELS` redraws them from the DEMs in LAND and the OBJ files in \
         MODELS that [figures.toml](figures.toml) names.\n",
    );
    for figure in &figures.figure {
        writeln!(page, "\n## {}\n\n{}\n", figure.title, figure.about)?;
        let mut titles = Vec::new();
        for picture in &figure.picture {
            let style = if picture.style.ends_with(".toml") {
                Style::load(&page_folder.join(&picture.style).display().to_string())?
            } else {
                Style::load(&picture.style)?
            };
            titles.push(style.description);
        }
        writeln!(page, "| {} |\n|{}", titles.join(" | "), " --- |".repeat(titles.len()))?;
        let cells: Vec<String> = (figure.picture.iter().zip(&titles))
            .map(|(picture, title)| format!("![{title}]({}.png)", picture.name))
            .collect();
        writeln!(page, "| {} |", cells.join(" | "))?;
    }
    Ok(page)
}
