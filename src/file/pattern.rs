//! What the name of an output says: its format, and whether it is one file or many.

use std::path::{Path, PathBuf};

use super::FileError;

/// A format for pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8 bits per channel, sRGB.
    Png,
    /// Named channels of 32 bits.
    Exr,
    /// Strokes as paths.
    Svg,
    /// 8 bits per channel, sRGB, with its place on the earth.
    GeoTiff,
    /// Strokes as lines on the earth.
    GeoJson,
}

/// What an output is, by its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// One picture.
    Picture(PictureFormat),
    /// One picture per frame.
    Frames(FramePattern, PictureFormat),
    /// A film.
    Mp4,
}

impl OutputKind {
    /// Reads the name of an output: `.png`, `.exr`, `.svg`, `.mp4`, `.tif` or `.geojson`, or a pattern of pictures such
    /// as `dir/%05d.exr`.
    ///
    /// # Errors
    /// Another ending; a wrong pattern.
    pub fn of(path: &Path) -> Result<Self, FileError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let format = match ending.as_deref() {
            Some("png") => PictureFormat::Png,
            Some("exr") => PictureFormat::Exr,
            Some("mp4") => return Ok(Self::Mp4),
            Some("svg") => PictureFormat::Svg,
            Some("tif" | "tiff") => PictureFormat::GeoTiff,
            Some("geojson") => PictureFormat::GeoJson,
            _ => {
                let cause = "an output ends in .png, .exr, .svg or .mp4, with --map also .tif or .geojson, or is a pattern of \
                             frames like dir/%05d.png";
                return Err(FileError::name(path, cause));
            }
        };
        if path.as_os_str().as_encoded_bytes().contains(&b'%') {
            return Ok(Self::Frames(FramePattern::parse(path)?, format));
        }
        Ok(Self::Picture(format))
    }
}

/// A name with a number in it: exactly one `%d` or `%0Nd` (N digits with leading zeros); `%%` stands for a percent
/// sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramePattern {
    before: String,
    after: String,
    digits: usize,
}

impl FramePattern {
    /// Parses a pattern.
    ///
    /// # Errors
    /// No number, several, or a percent sign with something else behind it.
    pub fn parse(pattern: &Path) -> Result<Self, FileError> {
        let wrong = |cause: &str| {
            let cause = format!("{cause}; a pattern of frames has one %d or %05d, and %% for a percent sign");
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
                // 20 digits hold every number that there is.
                _ => width
                    .strip_prefix('0')
                    .filter(|width| width.bytes().all(|byte| byte.is_ascii_digit()))
                    .and_then(|width| width.parse().ok())
                    .filter(|digits| (1..=20).contains(digits))
                    .ok_or_else(|| wrong("something stands between the percent sign and its d"))?,
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

    /// The path of a frame.
    pub fn path(&self, frame: u64) -> PathBuf {
        PathBuf::from(format!("{}{frame:0digits$}{}", self.before, self.after, digits = self.digits))
    }

    /// The path of a frame, whose folder is there after this.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn prepare(&self, frame: u64) -> Result<PathBuf, FileError> {
        let path = self.path(frame);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| FileError::write(folder, error))?;
        }
        Ok(path)
    }
}
