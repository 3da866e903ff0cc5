//! Exports: the requests of a window's export dialog, as command lines of `hachure render` and as pages.
//!
//! An export is nothing but that command line: the window runs it as it is shown, so both draw the same.

mod command;
mod foreign;
mod page;

#[cfg(test)]
pub(crate) use command::view_arguments;
pub(crate) use command::{quote, quoted};
pub(crate) use page::Page;

use std::path::Path;

use crate::file::unnamed;
use crate::gpu::device::AdapterWish;
use crate::picture::imprint::Imprint;
use crate::studio::file_kind::expand_home;
use crate::style::set::SetValue;

/// The kind of an export: each has its own options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A picture in pixels or on paper.
    Picture,
    /// A poster on paper, cut into sheets for a small printer.
    Sheets,
    /// Strokes and marks as curves, for pens and plotters.
    Lines,
    /// A picture with further channels, for compositors.
    Exr,
    /// A georeferenced map.
    Map,
    /// A stereo pair.
    Stereo,
    /// A film along a camera path.
    Film,
}

impl Kind {
    /// All kinds with their names, in the order in which they are shown.
    pub(crate) const ALL: [(Self, &'static str); 7] = [
        (Self::Picture, "Picture"),
        (Self::Sheets, "Poster sheets"),
        (Self::Lines, "Lines (SVG, PDF)"),
        (Self::Exr, "EXR channels"),
        (Self::Map, "Map"),
        (Self::Stereo, "Stereo"),
        (Self::Film, "Film"),
    ];

    /// Returns the endings of files of this kind, the usual one first.
    pub(crate) fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Picture | Self::Stereo => &["png", "jpg"],
            Self::Sheets => &["png"],
            Self::Lines => &["svg", "pdf"],
            Self::Exr => &["exr"],
            Self::Map => &["tif", "geojson", "png"],
            Self::Film => &["mp4", "gif"],
        }
    }
}

/// The current view of a window.
#[derive(Clone, Debug)]
pub(crate) struct ShownView {
    /// The imprint of the window's picture. Its style is the saved one, without unsaved edits.
    pub imprint: Imprint,
    /// Name of the preset or path of the style file.
    pub style: String,
    /// The values that unsaved edits of the style give to parameters.
    pub set: Vec<SetValue>,
    /// Whether a scene may name files outside of its folder.
    pub trusts_scene: bool,
    /// The choice of the GPU, as on the command line.
    pub adapter: AdapterWish,
}

/// The options of an export, as the dialog has them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Export {
    pub kind: Kind,
    /// Path of the output.
    pub output: String,
    /// Size of the picture in pixels, if it is not on paper.
    pub size_px: [u32; 2],
    pub is_on_paper: bool,
    /// Paper size, as `--paper` takes it.
    pub paper: String,
    pub is_portrait: bool,
    pub dpi: f64,
    /// Samples per pixel.
    pub samples: u32,
    /// Title below the picture; empty for none.
    pub title: String,
    /// Credits in the title block; empty for none.
    pub credits: String,
    /// Whether the title block has a legend.
    pub has_legend: bool,
    /// Paper of the sheets.
    pub sheets: String,
    /// Overlap of the sheets in millimetres.
    pub overlap_mm: f64,
    /// Number of pens; 0 for lines with the widths of the picture.
    pub pens: usize,
    /// Margin of lines on paper in millimetres.
    pub margin_mm: f64,
    /// The channels of an EXR, of those of [`crate::picture::aov::CHANNELS`].
    pub channels: Vec<&'static str>,
    /// Width of a map around the camera in metres; `None` for all of the land.
    pub map_width_m: Option<f64>,
    /// Whether a GeoJSON has longitudes and latitudes.
    pub is_wgs84: bool,
    /// Whether a map has a frame with coordinates.
    pub is_framed: bool,
    /// Value of `--eyes`.
    pub eyes: &'static str,
    /// Camera path of a film.
    pub path: String,
    /// Frames per second.
    pub fps: f64,
}

/// The names of numbered frames.
const FRAMES: &str = "%05d.png";

/// The layouts of a stereo pair, as `--eyes` takes them.
pub(crate) const STEREO: [&str; 3] = ["side-by-side", "anaglyph", "grey-anaglyph"];

impl Export {
    /// Returns what a dialog begins with.
    pub(crate) fn new(size_px: [u32; 2], samples: u32) -> Self {
        Self {
            kind: Kind::Picture,
            output: String::new(),
            size_px,
            is_on_paper: false,
            paper: "a3".to_owned(),
            is_portrait: size_px[0] < size_px[1],
            dpi: 300.0,
            samples,
            title: String::new(),
            credits: String::new(),
            has_legend: false,
            sheets: "a4".to_owned(),
            overlap_mm: 10.0,
            pens: 0,
            margin_mm: 10.0,
            channels: vec!["depth", "normal"],
            map_width_m: None,
            is_wgs84: false,
            is_framed: false,
            eyes: STEREO[0],
            path: String::new(),
            fps: 30.0,
        }
    }

    /// Returns whether the size follows from paper.
    pub(crate) fn has_paper(&self) -> bool {
        match self.kind {
            Kind::Sheets => true,
            Kind::Picture | Kind::Lines => self.is_on_paper,
            // A GeoJSON has no resolution.
            Kind::Map => self.is_on_paper && self.ending() != "geojson",
            Kind::Exr | Kind::Stereo | Kind::Film => false,
        }
    }

    /// Returns the ending of the output.
    pub(crate) fn ending(&self) -> String {
        Path::new(&self.output).extension().unwrap_or_default().to_string_lossy().to_lowercase()
    }

    /// Changes the kind, and the ending of the output where it does not suit.
    pub(crate) fn set_kind(&mut self, kind: Kind) {
        self.kind = kind;
        let ending = self.ending();
        if !kind.endings().contains(&&*ending) {
            self.set_ending(kind.endings()[0]);
        }
    }

    /// Changes the ending of the output. Numbered frames become one file, named after their folder.
    pub(crate) fn set_ending(&mut self, ending: &str) {
        let output = Path::new(&self.output);
        let folder = output.parent().filter(|folder| self.is_frames() && folder.file_name().is_some());
        self.output = match folder {
            Some(folder) => format!("{}.{ending}", folder.display()),
            None => output.with_extension(ending).to_string_lossy().into_owned(),
        };
    }

    /// Returns whether the output is a pattern of numbered frames.
    pub(crate) fn is_frames(&self) -> bool {
        self.kind == Kind::Film && self.output.contains('%')
    }

    /// Writes numbered frames into a folder that is named after the output.
    pub(crate) fn set_frames(&mut self) {
        if !self.is_frames() {
            let folder = Path::new(&self.output).with_extension("");
            self.output = folder.join(FRAMES).to_string_lossy().into_owned();
        }
    }

    /// Returns the output with the user's folder in place of `~`.
    pub(crate) fn output_path(&self) -> String {
        expand_home(&self.output)
    }

    /// Returns why the export cannot run, in one line. Errors that only `render` can find are reported by `render`.
    pub(crate) fn refusal(&self) -> Option<String> {
        let output = self.output_path();
        let output = Path::new(&output);
        let shown = crate::file::message::named(output);
        if output.file_stem().is_none() {
            return Some("The output has no name".to_owned());
        }
        let endings = self.kind.endings();
        if !self.is_frames() && !endings.contains(&&*self.ending()) {
            return Some(format!("{shown}: it must end in .{}", endings.join(", .")));
        }
        if self.kind == Kind::Film && self.path.trim().is_empty() {
            return Some("A film needs a camera path".to_owned());
        }
        if let Err(error) = Page::of(self) {
            return Some(error);
        }
        // Links and devices are among them: a drawing would take their place.
        let is_other = output.symlink_metadata().is_ok_and(|found| !found.is_file());
        is_other.then(|| format!("{shown}: exists, and is not a regular file; choose another name"))
    }

    /// Returns whether the output replaces a file that hachure drew.
    pub(crate) fn replaces_own(&self) -> bool {
        let output = self.output_path();
        let output = Path::new(&output);
        output.symlink_metadata().is_ok_and(|found| found.is_file()) && unnamed::is_export(output)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;
    use crate::file::imprint::Notes;
    use crate::file::png::{PngPixels, PngWriter};

    #[test]
    fn only_what_hachure_drew_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        let mut export = Export::new([64, 36], 1);
        assert_eq!(export.refusal().as_deref(), Some("The output has no name"));
        export.output = at("new.png");
        assert_eq!((export.refusal(), export.replaces_own()), (None, false));
        atomic::write(Path::new(&at("photo.png")), b"mine").unwrap();
        export.output = at("photo.png");
        assert_eq!((export.refusal(), export.replaces_own()), (None, false));
        assert_eq!(export.foreign(), [Path::new(&export.output)], "the dialog asks");
        let notes = Notes { imprint: Some("version = 1\n"), ..Notes::default() };
        let drawn = at("drawn.png");
        let mut writer = PngWriter::create_noted(Path::new(&drawn), 1, 1, PngPixels::Rgb8, &notes).unwrap();
        writer.write_rows(&[0; 3]).unwrap();
        writer.finish().unwrap();
        export.output = drawn;
        assert_eq!((export.refusal(), export.replaces_own()), (None, true));
        assert!(export.foreign().is_empty());
        std::fs::create_dir(at("folder.png")).unwrap();
        export.output = at("folder.png");
        let refusal = export.refusal().unwrap();
        assert!(refusal.ends_with("folder.png: exists, and is not a regular file; choose another name"), "{refusal}");
    }

    #[test]
    fn each_kind_has_its_endings() {
        let mut export = Export { output: "/nowhere/a.png".to_owned(), ..Export::new([64, 36], 1) };
        for (kind, _) in Kind::ALL {
            export.set_kind(kind);
            assert!(kind.endings().contains(&&*export.ending()), "{kind:?}: {}", export.output);
            assert!(export.output.starts_with("/nowhere/a."));
        }
        export.set_kind(Kind::Lines);
        export.set_ending("pdf");
        assert_eq!((&*export.output, export.refusal()), ("/nowhere/a.pdf", None));
        export.output = "/nowhere/a.tif".to_owned();
        assert_eq!(export.refusal().as_deref(), Some("/nowhere/a.tif: it must end in .svg, .pdf"));
        export.set_kind(Kind::Film);
        assert_eq!(export.refusal().as_deref(), Some("A film needs a camera path"));
        export.path = "tour".to_owned();
        assert_eq!(export.refusal(), None);
        export.output = "/nowhere/alps.v2.mp4".to_owned();
        export.set_frames();
        assert_eq!((&*export.output, export.refusal()), ("/nowhere/alps.v2/%05d.png", None), "frames");
        export.set_frames();
        export.set_ending("gif");
        assert_eq!(export.output, "/nowhere/alps.v2.gif", "and back to one file");
        export.output = "/nowhere/%05d.png".to_owned();
        assert_eq!(export.refusal(), None, "frames");
        (export.kind, export.output, export.paper) = (Kind::Sheets, "/nowhere/a.png".to_owned(), "a99".to_owned());
        let refusal = export.refusal().unwrap();
        assert!(refusal.starts_with("Paper \"a99\""), "{refusal}");
    }
}
