//! Interprets the name of an output: its format, and whether it is one file or many.

use std::path::{Path, PathBuf};

use super::FileError;

/// A format for pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// 8 bits per channel, sRGB.
    Png,
    /// 8 bits per channel, sRGB, with losses.
    Jpg,
    /// Named channels of 32 bits.
    Exr,
    /// Strokes as SVG paths.
    Svg,
    /// Strokes as paths on a page of a PDF.
    Pdf,
    /// 8 bits per channel, sRGB, with a georeference.
    GeoTiff,
    /// Strokes as lines with earth coordinates.
    GeoJson,
}

/// A format for meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeshFormat {
    /// glTF in one binary file: the land from above, with normals.
    Glb,
    /// A closed solid for 3D printers.
    Stl,
}

/// The kind of output that a name denotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum OutputKind {
    /// A single picture.
    Picture(PictureFormat),
    /// A picture per frame.
    Frames(FramePattern, PictureFormat),
    /// A film in one file.
    Mp4,
    /// A short film in one file, of few colours.
    Gif,
    /// The land as triangles.
    Mesh(MeshFormat),
}

impl OutputKind {
    /// Returns the format of the pictures, if the output is one or several.
    pub(crate) fn picture_format(&self) -> Option<PictureFormat> {
        match self {
            Self::Picture(format) | Self::Frames(_, format) => Some(*format),
            Self::Mp4 | Self::Gif | Self::Mesh(_) => None,
        }
    }

    /// Returns whether the output is a page of paths: an SVG or a PDF, or several.
    pub(crate) fn is_drawing(&self) -> bool {
        matches!(self.picture_format(), Some(PictureFormat::Svg | PictureFormat::Pdf))
    }

    /// Returns the kind of a file of lines in words, for messages: `an .svg`.
    pub(crate) fn lines_name(&self) -> &'static str {
        match self.picture_format() {
            Some(PictureFormat::GeoJson) => "a .geojson",
            Some(PictureFormat::Pdf) => "a .pdf",
            _ => "an .svg",
        }
    }

    /// Parses the name of an output, by its ending, or a pattern of pictures such as `dir/%05d.exr`.
    ///
    /// # Errors
    /// Fails for another extension or an invalid pattern.
    pub(crate) fn of(path: &Path) -> Result<Self, FileError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let is_pattern = path.as_os_str().as_encoded_bytes().contains(&b'%');
        let whole = match ending.as_deref() {
            Some("mp4") => Some((Self::Mp4, "an MP4 holds the whole film")),
            Some("gif") => Some((Self::Gif, "a GIF holds the whole film")),
            Some("glb") => Some((Self::Mesh(MeshFormat::Glb), "a .glb holds one mesh")),
            Some("stl") => Some((Self::Mesh(MeshFormat::Stl), "an .stl holds one mesh")),
            _ => None,
        };
        match whole {
            Some((_, what)) if is_pattern && FramePattern::parse(path).is_ok() => {
                return Err(FileError::name(path, format!("{what}; leave out the pattern of frames")));
            }
            Some((kind, _)) => return Ok(kind),
            None => {}
        }
        let format = match ending.as_deref() {
            Some("png") => PictureFormat::Png,
            Some("exr") => PictureFormat::Exr,
            Some("jpg" | "jpeg") => PictureFormat::Jpg,
            Some("svg") => PictureFormat::Svg,
            Some("pdf") => PictureFormat::Pdf,
            Some("tif" | "tiff") => PictureFormat::GeoTiff,
            Some("geojson") => PictureFormat::GeoJson,
            _ => {
                let cause = "it must end in .png, .jpg, .jpeg, .exr, .svg, .pdf, .mp4, .gif, .glb or .stl (.tif, \
                             .tiff, .geojson with --map), or be like dir/%05d.png";
                return Err(FileError::name(path, cause));
            }
        };
        if is_pattern {
            return Ok(Self::Frames(FramePattern::parse(path)?, format));
        }
        Ok(Self::Picture(format))
    }
}

/// A name that contains a number: exactly one `%d` or `%0Nd` (N digits with leading zeros); `%%` stands for a percent
/// sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FramePattern {
    before: String,
    after: String,
    digits: usize,
}

impl FramePattern {
    /// Parses a pattern.
    ///
    /// # Errors
    /// Fails if there is no number, more than one, or a percent sign followed by anything else.
    pub(crate) fn parse(pattern: &Path) -> Result<Self, FileError> {
        let wrong = |cause: &str| {
            let cause = format!("{cause}; a frame pattern has exactly one %d or %05d, and %% for a percent sign");
            FileError::name(pattern, cause)
        };
        let mut rest = pattern.to_str().ok_or_else(|| wrong("the name is not UTF-8"))?;
        let mut text = String::new();
        let mut number: Option<(String, usize)> = None;
        while let Some((before, after)) = rest.split_once('%') {
            text += before;
            if let Some(after) = after.strip_prefix('%') {
                text.push('%');
                rest = after;
                continue;
            }
            let (width, after) = after.split_once('d').ok_or_else(|| wrong("a percent sign without d"))?;
            let digits = match width {
                "" => 1,
                // 20 digits hold every u64.
                _ => width
                    .strip_prefix('0')
                    .filter(|width| width.bytes().all(|byte| byte.is_ascii_digit()))
                    .and_then(|width| width.parse().ok())
                    .filter(|digits| (1..=20).contains(digits))
                    .ok_or_else(|| wrong("only 0 and a number of digits (up to 20) may come between % and d"))?,
            };
            if number.is_some() {
                return Err(wrong("it has more than one number"));
            }
            number = Some((std::mem::take(&mut text), digits));
            rest = after;
        }
        text += rest;
        let (before, digits) = number.ok_or_else(|| wrong("it has no number"))?;
        Ok(Self { before, after: text, digits })
    }

    /// Returns the path of a frame.
    pub(crate) fn path(&self, frame: u64) -> PathBuf {
        PathBuf::from(format!("{}{frame:0digits$}{}", self.before, self.after, digits = self.digits))
    }

    /// Returns the numbers of the frames that may exist, found by listing the folder that the number is in.
    pub(crate) fn existing(&self) -> Vec<u64> {
        let (folder, begin) = self.before.rsplit_once(['/', '\\']).unwrap_or((".", &self.before));
        let folder = if folder.is_empty() { "/" } else { folder };
        let end = self.after.split(['/', '\\']).next().unwrap_or_default();
        // Some file systems ignore case.
        let [begin, end] = [begin, end].map(str::to_lowercase);
        let number = |entry: std::fs::DirEntry| {
            let name = entry.file_name().to_str()?.to_lowercase();
            name.strip_prefix(&begin)?.strip_suffix(&end)?.parse().ok()
        };
        std::fs::read_dir(folder).into_iter().flatten().flatten().filter_map(number).collect()
    }

    /// Creates the folder of a frame and returns the frame's path.
    ///
    /// # Errors
    /// Fails if the folder cannot be created.
    pub(crate) fn prepare(&self, frame: u64) -> Result<PathBuf, FileError> {
        let path = self.path(frame);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| FileError::write(folder, error))?;
        }
        Ok(path)
    }
}
