//! The command line of an export.

use super::{Export, Kind, ShownView};
use crate::gpu::device::AdapterWish;
use crate::picture::imprint::{Imprint, More};
use crate::scene::Sun;

/// Returns the arguments that draw what the imprint of a window's picture says, without its size, its output and its
/// style.
pub(crate) fn view_arguments(imprint: &Imprint) -> Vec<String> {
    let Imprint { world, camera, sun: Sun { azimuth_deg, elevation_deg }, more, .. } = imprint;
    // A name that begins with a dash is not an option.
    let world = world.as_ref().map(|name| if name.starts_with('-') { format!("./{name}") } else { name.clone() });
    let mut arguments: Vec<String> = world.into_iter().collect();
    let mut add = |option: &str, value: Option<String>| {
        arguments.extend(value.map(|value| format!("--{option}={value}")));
    };
    add("camera", more.map.is_none().then(|| camera.to_string()));
    add("sun", Some(format!("{azimuth_deg},{elevation_deg}")));
    let number = |value: Option<f64>| value.map(|value| value.to_string());
    // Without `..`, so that a new key is not forgotten.
    let More {
        time_s,
        samples,
        lod_error,
        nodata,
        encoding,
        voids,
        tile_memory,
        height_scale,
        height_offset,
        height_unit,
        tile_rows,
        exaggeration,
        haze,
        sea_level,
        trees,
        seed,
        eyes,
        ipd,
        convergence,
        map,
        map_scale,
        title,
        credits,
        legend,
        peaks,
        saddles,
        lakes,
        names,
        name_layer,
        name_when,
        name_field,
        frame,
        focus,
        water,
        layers,
        graticule,
        drape,
        tone_curve,
        // The window has none of the rest.
        show: _,
        paper: _,
        margin: _,
        tolerance_px: _,
        pens: _,
        path: _,
        fps: _,
        frames: _,
        warm_up: _,
        antialias: _,
    } = more;
    add("exaggeration", number(*exaggeration));
    add("haze", number(*haze));
    add("sea-level", sea_level.clone());
    add("trees", trees.clone());
    add("seed", seed.map(|seed| seed.to_string()));
    add("focus", focus.clone());
    add("water", water.clone());
    add("graticule", graticule.clone());
    layers.iter().flatten().for_each(|file| add("layer", Some(file.clone())));
    drape.iter().flatten().for_each(|file| add("drape", Some(file.clone())));
    add("encoding", encoding.clone());
    add("height-scale", number(*height_scale));
    add("height-offset", number(*height_offset));
    add("height-unit", height_unit.clone());
    add("tile-rows", tile_rows.clone());
    add("nodata", number(*nodata));
    add("voids", voids.clone());
    add("time-s", number(*time_s));
    add("eyes", eyes.clone());
    add("ipd", ipd.clone());
    add("convergence", number(*convergence));
    // A map with a width has its scale.
    let has_width = map.as_ref().is_some_and(|map| map.split(',').count() == 3);
    add("map", map.clone());
    add("map-scale", number(map_scale.filter(|_| !has_width)));
    add("title", title.clone());
    add("credits", credits.clone());
    add("peaks", peaks.map(|count| count.to_string()));
    add("saddles", saddles.map(|count| count.to_string()));
    add("lakes", lakes.map(|count| count.to_string()));
    add("names", names.clone());
    add("name-layer", name_layer.clone());
    add("name-when", name_when.clone());
    add("name-field", name_field.clone());
    add("samples", samples.map(|samples| samples.to_string()));
    add("lod-error", number(*lod_error));
    add("tone-curve", tone_curve.clone());
    add("tile-memory", tile_memory.map(|mib| mib.to_string()));
    arguments.extend(legend.filter(|has_legend| *has_legend).map(|_| "--legend".to_owned()));
    arguments.extend(frame.filter(|is_framed| *is_framed).map(|_| "--map-frame".to_owned()));
    arguments
}

impl Export {
    /// Returns the arguments of the program: `render` with everything that the drawing depends on.
    pub(crate) fn arguments(&self, view: &ShownView) -> Vec<String> {
        let mut imprint = view.imprint.clone();
        let more = &mut imprint.more;
        more.samples = Some(self.samples).filter(|samples| *samples != 1 && self.has_samples());
        if self.kind != Kind::Stereo {
            (more.eyes, more.ipd, more.convergence) = (None, None, None);
        } else {
            more.eyes = Some(self.eyes.to_owned());
            // A window that shows one eye has no distance between eyes; that of a person shows no depth in mountains.
            more.ipd.get_or_insert_with(|| "auto".to_owned());
        }
        if self.kind == Kind::Film {
            more.time_s = None;
        }
        let title = self.title.trim();
        more.title = Some(title).filter(|title| !title.is_empty() && self.has_title()).map(str::to_owned);
        let credits = self.credits.trim();
        more.credits = Some(credits).filter(|text| !text.is_empty() && more.title.is_some()).map(str::to_owned);
        more.legend = (self.has_legend && more.title.is_some()).then_some(true);
        if self.kind == Kind::Map {
            let [x, y] = [imprint.camera.position_m.x, imprint.camera.position_m.y].map(f64::round);
            imprint.more.map =
                Some(self.map_width_m.map_or_else(|| "whole".to_owned(), |width_m| format!("{x},{y},{width_m}")));
            imprint.more.time_s = None;
            imprint.more.frame = (self.is_framed && self.has_title()).then_some(true);
        }
        let mut arguments = vec!["render".to_owned()];
        let mut of_view = view_arguments(&imprint);
        if self.kind == Kind::Film {
            of_view.retain(|argument| !argument.starts_with("--camera="));
        }
        arguments.extend(of_view);
        let mut add = |argument: String| arguments.push(argument);
        add(format!("--style={}", view.style));
        view.set.iter().for_each(|value| add(format!("--set={value}")));
        match (self.has_paper(), self.kind) {
            (true, Kind::Lines) => {
                let [width, height] = self.size_px;
                add(format!("--size={width}x{height}"));
                add(format!("--paper={}", self.paper.trim()));
                add(format!("--margin={}", self.margin_mm));
            }
            (true, _) => {
                add(format!("--paper={}", self.paper.trim()));
                add(if self.is_portrait { "--portrait" } else { "--landscape" }.to_owned());
                add(format!("--dpi={}", self.dpi));
            }
            (false, _) => {
                let [width, height] = self.size_px;
                add(format!("--size={width}x{height}"));
            }
        }
        match self.kind {
            Kind::Sheets => {
                add(format!("--sheets={}", self.sheets.trim()));
                add(format!("--sheets-overlap={}", self.overlap_mm));
            }
            Kind::Exr if !self.channels.is_empty() => add(format!("--aov={}", self.channels.join(","))),
            Kind::Map if self.is_wgs84 && self.ending() == "geojson" => add("--wgs84".to_owned()),
            Kind::Film => {
                add(format!("--path={}", self.path.trim()));
                add(format!("--fps={}", self.fps));
                add("--antialias=temporal".to_owned());
            }
            _ => {}
        }
        if self.pens > 0 && (self.kind == Kind::Lines || self.kind == Kind::Map && self.ending() == "geojson") {
            add(format!("--pens={}", self.pens));
        }
        if view.trusts_scene {
            add("--trust-scene".to_owned());
        }
        match &view.adapter {
            AdapterWish::Best => {}
            AdapterWish::Software => add("--adapter=software".to_owned()),
            AdapterWish::Name(name) => add(format!("--adapter={name}")),
        }
        add(format!("--output={}", self.output_path()));
        arguments
    }

    /// Returns whether pixels of this export have several samples.
    pub(crate) fn has_samples(&self) -> bool {
        match self.kind {
            Kind::Lines | Kind::Film => false,
            Kind::Exr => true,
            Kind::Map => self.ending() != "geojson",
            Kind::Picture | Kind::Sheets | Kind::Stereo => true,
        }
    }

    /// Returns whether this export may have a title.
    pub(crate) fn has_title(&self) -> bool {
        match self.kind {
            Kind::Picture | Kind::Sheets | Kind::Lines | Kind::Stereo => true,
            Kind::Map => self.ending() == "png",
            Kind::Exr | Kind::Film => false,
        }
    }
}

/// Returns a command line for a shell: `hachure` with quoted arguments.
pub(crate) fn quoted(arguments: &[String]) -> String {
    let words = arguments.iter().map(|argument| quote(argument));
    std::iter::once("hachure".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Returns a word for a shell.
pub(crate) fn quote(word: &str) -> String {
    let is_plain = |sign: char| sign.is_ascii_alphanumeric() || "-_=+,./:@%".contains(sign);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    match cfg!(windows) {
        true => format!("\"{}\"", word.replace('"', "\\\"")),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_shell_reads_what_was_quoted() {
        let words = ["plain", "it's", "two words", "$HOME `x` \\ \"q\"", "", "--title=Höhe; rm *", "a\nb", "-1,2"];
        let words = words.map(str::to_owned);
        let line = quoted(&words).replacen("hachure", "printf '%s\\0'", 1);
        let output = std::process::Command::new("sh").args(["-c", &line]).output().unwrap();
        let read: Vec<String> =
            String::from_utf8(output.stdout).unwrap().split_terminator('\0').map(str::to_owned).collect();
        assert_eq!(read, words);
        // Planted: without quotes, the shell reads something else.
        let bare = format!("printf '%s\\0' {}", words[2]);
        assert_ne!(std::process::Command::new("sh").args(["-c", &bare]).output().unwrap().stdout, b"two words\0");
    }
}
