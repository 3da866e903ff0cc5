//! `hachure info` for a picture that hachure drew: its imprint in a readable form, and how to draw it again.

use std::path::Path;

use serde::Serialize;

use crate::file::exr;
use crate::file::imprint as stored;
use crate::file::message::{named, printable, shown};
use crate::file::toml_text;
use crate::picture::imprint::Imprint;

#[derive(Serialize)]
pub(super) struct PictureInfo {
    /// Version of the hachure that drew it.
    hachure: Option<String>,
    /// World, as it was given; `None` is the built-in world.
    world: Option<String>,
    /// Camera of a picture, or of the first frame of a film.
    camera: String,
    /// Size of the picture of one eye.
    size_px: [u32; 2],
    /// Resolution on paper.
    dpi: Option<f64>,
    sun_azimuth_deg: f64,
    sun_elevation_deg: f64,
    style: String,
    style_description: String,
    /// Further settings, by their names in the imprint.
    settings: toml::Table,
    /// Whether it is a film in one file.
    is_film: bool,
    /// Names of the channels of an EXR; empty for other formats.
    channels: Vec<String>,
    /// The command that draws it again.
    command: String,
    /// The whole style, as a style file.
    style_text: String,
}

/// Returns the description of a picture with an imprint; `None` if it has none.
///
/// # Errors
/// Fails if the file is damaged, or if its imprint is invalid or newer than this program.
pub(super) fn read(file: &Path) -> anyhow::Result<Option<PictureInfo>> {
    let Some(text) = stored::find(file)? else { return Ok(None) };
    let name = file.to_string_lossy();
    let imprint = Imprint::parse(&name, &text)?;
    let table: toml::Table = toml_text::read(&name, &text)?;
    let word = |key: &str| table.get(key).and_then(toml::Value::as_str).map(str::to_owned);
    let settings = table.get("more").and_then(toml::Value::as_table).cloned().unwrap_or_default();
    let ending = file.extension().map(|ending| format!(".{}", ending.to_string_lossy())).unwrap_or_default();
    let is_address = imprint.world.as_ref().is_some_and(|world| world.contains("://"));
    let trust = if is_address { " --trust-scene" } else { "" };
    Ok(Some(PictureInfo {
        hachure: word("hachure"),
        world: imprint.world.clone(),
        camera: imprint.camera.to_string(),
        size_px: imprint.size_px,
        dpi: imprint.dpi,
        sun_azimuth_deg: imprint.sun.azimuth_deg,
        sun_elevation_deg: imprint.sun.elevation_deg,
        style: imprint.style.name.clone(),
        style_description: imprint.style.description.clone(),
        settings,
        is_film: [".gif", ".mp4"].iter().any(|film| ending.eq_ignore_ascii_case(film)),
        channels: if ending.eq_ignore_ascii_case(".exr") { exr::channel_names(file)? } else { Vec::new() },
        command: format!("hachure render --like {}{trust} -o NEW{ending}", in_shell(&name)),
        style_text: imprint.style.text(),
    }))
}

/// Returns a camera as text with numbers rounded to hundredths.
fn rounded(camera: &str) -> String {
    let number = |field: &str| {
        let (sign, bare) = field.strip_prefix('+').map_or(("", field), |bare| ("+", bare));
        let rounded = bare.parse::<f64>().map(|number| (number * 100.0).round() / 100.0 + 0.0);
        rounded.map_or_else(|_| field.to_owned(), |rounded| format!("{sign}{rounded}"))
    };
    camera.split(',').map(number).collect::<Vec<_>>().join(",")
}

/// Returns a name as a word of a shell.
fn in_shell(name: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+=,@%:".contains(c);
    match name.chars().all(is_plain) && !name.starts_with('-') {
        true => named(name),
        false => format!("'{}'", named(name).replace('\'', "'\\''")),
    }
}

impl PictureInfo {
    pub(super) fn text(&self, file: &str) -> String {
        let [width, height] = self.size_px;
        let program =
            self.hachure.as_ref().map_or("hachure".to_owned(), |version| format!("hachure {}", shown(version)));
        let world = self.world.as_ref().map_or("the built-in world".to_owned(), named);
        let dpi = self.dpi.map_or(String::new(), |dpi| format!(", at {dpi} dots per inch"));
        let what = if self.is_film { "film" } else { "picture" };
        let channels = match self.channels.as_slice() {
            [] => String::new(),
            names => format!("channels  {}\n", names.iter().map(|name| shown(name)).collect::<Vec<_>>().join(", ")),
        };
        let lines = self.settings.iter().map(|(key, value)| {
            let value = match value.as_str() {
                Some("whole") if key == "map" => "all of the land".to_owned(),
                Some(text) => text.to_owned(),
                None => value.to_string(),
            };
            format!("{:<9} {}\n", shown(key), shown(&value))
        });
        // A map has the camera only as a substitute.
        let camera = match self.settings.contains_key("map") {
            true => String::new(),
            false => format!("camera    {}\n", rounded(&self.camera)),
        };
        format!(
            "{file}: a {what} that {program} drew\n\
             world     {world}\n\
             {camera}size      {width} × {height} px{dpi}\n{channels}\
             sun       azimuth {}°, elevation {}°\n\
             style     {}: {}\n{}\
             again     {}\n",
            self.sun_azimuth_deg,
            self.sun_elevation_deg,
            shown(&self.style),
            printable(&self.style_description, 400),
            lines.collect::<String>(),
            self.command
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_rounded() {
        assert_eq!(rounded("-3.4999999999,0,+150.123456,40,-12.001,60"), "-3.5,0,+150.12,40,-12,60");
    }

    #[test]
    fn names_are_words_of_a_shell() {
        assert_eq!(in_shell("dir/a-b_1.png"), "dir/a-b_1.png");
        assert_eq!(in_shell("it's here.png"), "'it'\\''s here.png'");
        assert_eq!(in_shell("-o.png"), "'-o.png'");
    }
}
