//! The imprint of an output: a text that says how it was drawn, stored under the key `hachure` of its format.
//! [`crate::picture::imprint`] defines the text.
//!
//! - PNG: an `iTXt` chunk with that keyword. The resolution is also stored in `pHYs`.
//! - EXR: a string attribute of that name. The resolution is `xDensity`; the camera is `worldToCamera` and
//!   `worldToNDC`, and that of the second view `right.worldToCamera` and `right.worldToNDC`.
//! - JPEG: application segments that begin with that word. The resolution is in the header.
//! - SVG: the text of `<metadata id="hachure">`.
//! - GeoTIFF: an item of that name in GDAL's metadata (tag 42112), which `gdalinfo` shows.
//! - PDF: a stream of the type `HachureImprint`.
//! - GIF: a comment that begins with that word.
//! - MP4: the tag of that name, which ffmpeg writes and reads.

use std::io::{BufReader, Read};
use std::path::Path;
use std::process::Command;

use super::input::open_regular;
use super::process::{self, PATIENCE};
use super::{FileError, exr, geotiff, gif, jpg, pdf, png, video};

/// Key under which an output stores its imprint.
pub(crate) const KEY: &str = "hachure";

/// Largest imprint in bytes: a style file may have as many, and so may its recipes.
pub(super) const LARGEST_BYTES: u64 = 4 << 20;

/// Largest part of ffmpeg's messages that is kept, in bytes.
const LONGEST_MESSAGES_BYTES: usize = 1 << 16;

/// Metadata of an output.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Notes<'a> {
    /// The imprint: how the output was drawn.
    pub imprint: Option<&'a str>,
    /// Resolution on paper in dots per inch.
    pub dpi: Option<f64>,
    /// Matrices of the camera, for outputs that have one.
    pub matrices: Option<Matrices>,
    /// Matrices of the second view, for an EXR of a stereo pair, which is a multi-view file; `matrices` are those of
    /// the default view.
    pub second_view: Option<Matrices>,
}

/// The camera of a picture, in the convention of EXR's standard attributes.
///
/// Both matrices multiply a row vector from the right and are stored row by row. World coordinates are east, north, up
/// in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrices {
    /// To camera space: x right, y up, looking along −z.
    pub camera_from_world: [f32; 16],
    /// To the picture after the division by w: x from −1 at the left to 1, y from −1 at the bottom to 1; z is 1 at the
    /// near plane and 0 at infinity.
    pub ndc_from_world: [f32; 16],
}

/// Reads the imprint of a PNG, JPEG, EXR, SVG, PDF, GeoTIFF, GIF or MP4, which is recognised by its content.
///
/// # Errors
/// Fails if the file cannot be read, is damaged where its imprint is stored, or has no imprint.
pub fn read(path: &Path) -> Result<String, FileError> {
    find(path)?.ok_or_else(|| {
        FileError::read(path, "it has no imprint that says how it was drawn; files written by hachure render have one")
    })
}

/// The formats that can hold an imprint.
enum Format {
    Png,
    Exr,
    Jpeg,
    Pdf,
    Gif,
    Mp4,
    Tiff,
    Svg,
}

impl Format {
    /// Returns the format of a file that begins with `head`.
    fn of(head: &[u8]) -> Option<Self> {
        const BEGINNINGS: [(&[u8], Format); 9] = [
            (b"\x89PNG", Format::Png),
            (b"\x76\x2f\x31\x01", Format::Exr),
            (b"\xff\xd8\xff", Format::Jpeg),
            (b"%PDF-", Format::Pdf),
            (b"GIF8", Format::Gif),
            (b"II*\0", Format::Tiff),
            (b"MM\0*", Format::Tiff),
            (b"II+\0", Format::Tiff),
            (b"MM\0+", Format::Tiff),
        ];
        let begins = BEGINNINGS.into_iter().find(|(beginning, _)| head.starts_with(beginning));
        let text = || String::from_utf8_lossy(&head[..head.len().min(HEAD_BYTES)]).contains("<svg");
        match begins {
            Some((_, format)) => Some(format),
            None if head.get(4..8) == Some(b"ftyp") => Some(Self::Mp4),
            None => text().then_some(Self::Svg),
        }
    }
}

/// Length of the part of a file that shows its format, in bytes.
const HEAD_BYTES: usize = 512;

/// Returns whether a file that begins like this has a format that can hold an imprint.
pub(crate) fn may_have(head: &[u8]) -> bool {
    Format::of(head).is_some()
}

/// Reads the imprint of a file like [`read`]; returns `None` if it has none.
///
/// # Errors
/// Fails if the file cannot be read, is damaged where its imprint is stored, or has another format.
pub(crate) fn find(path: &Path) -> Result<Option<String>, FileError> {
    let failed = |error: std::io::Error| FileError::read(path, error);
    let mut head = [0; HEAD_BYTES];
    let mut file = open_regular(path).map_err(failed)?;
    let mut filled = 0;
    while filled < head.len() {
        match file.read(&mut head[filled..]).map_err(failed)? {
            0 => break,
            bytes => filled += bytes,
        }
    }
    let head = &head[..filled];
    let found = match Format::of(head) {
        Some(Format::Png) => png::imprint(path),
        Some(Format::Exr) => exr::imprint(path),
        Some(Format::Jpeg) => jpg::imprint(path, LARGEST_BYTES as usize),
        Some(Format::Pdf) => pdf::imprint(path, LARGEST_BYTES as usize),
        Some(Format::Gif) => gif::imprint(path, LARGEST_BYTES as usize),
        Some(Format::Mp4) => video::imprint(path),
        Some(Format::Tiff) => geotiff::imprint(path),
        Some(Format::Svg) => of_svg(path),
        None => Err(FileError::read(path, "it is not a PNG, JPEG, EXR, SVG, PDF, GeoTIFF, GIF or MP4")),
    }?;
    if found.as_ref().is_some_and(|found| found.len() as u64 > LARGEST_BYTES) {
        return Err(FileError::read(path, "its imprint is larger than 4 MiB"));
    }
    Ok(found)
}

/// Returns the text of `<metadata id="hachure">`. SVG editors move attributes and break lines, but keep both.
fn of_svg(path: &Path) -> Result<Option<String>, FileError> {
    let failed = |error: std::io::Error| FileError::read(path, error);
    let mut bytes = Vec::new();
    let file = open_regular(path).map_err(failed)?;
    BufReader::new(file).take(2 * LARGEST_BYTES).read_to_end(&mut bytes).map_err(failed)?;
    let text = String::from_utf8_lossy(&bytes);
    let mut rest = text.as_ref();
    while let Some((_, after)) = rest.split_once("<metadata") {
        let Some((attributes, inside)) = after.split_once('>') else { break };
        rest = inside;
        if !attributes.contains("id=\"hachure\"") && !attributes.contains("id='hachure'") {
            continue;
        }
        let inside = inside.split_once("</metadata>").map(|(inside, _)| inside);
        return inside
            .map(|inside| Some(unescaped(inside)))
            .ok_or_else(|| FileError::read(path, "its metadata is truncated"));
    }
    Ok(None)
}

/// Resolves the entities of XML text. [`escaped`] writes the named ones; editors may also write numeric ones.
pub(super) fn unescaped(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('&') {
        plain += before;
        let (entity, behind) = after.split_once(';').unwrap_or((after, ""));
        let number = entity.strip_prefix('#').and_then(|number| match number.strip_prefix(['x', 'X']) {
            Some(number) => u32::from_str_radix(number, 16).ok(),
            None => number.parse().ok(),
        });
        match entity {
            "amp" => plain.push('&'),
            "lt" => plain.push('<'),
            "gt" => plain.push('>'),
            "quot" => plain.push('"'),
            "apos" => plain.push('\''),
            _ => plain.extend(number.and_then(char::from_u32)),
        }
        rest = behind;
    }
    plain + rest
}

/// Escapes text for use between tags; keeps its line breaks. Characters that XML cannot represent become question
/// marks.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '\n' | '\t' => safe.push(character),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => safe.push('?'),
            _ => safe.push(character),
        }
    }
    safe
}

/// Extracts the imprint from the output of `ffmpeg -f ffmetadata`: lines `key=value`, with a backslash before each `=`,
/// `;`, `#`, backslash and line break of a value.
pub(super) fn of_ffmetadata(text: &str) -> Option<String> {
    let mut lines: Vec<String> = vec![String::new()];
    let mut is_escaped = false;
    for character in text.chars() {
        match character {
            '\\' if !is_escaped => is_escaped = true,
            '\n' if !is_escaped => lines.push(String::new()),
            _ => {
                is_escaped = false;
                lines.last_mut()?.push(character);
            }
        }
    }
    lines.into_iter().find_map(|line| Some(line.strip_prefix(KEY)?.strip_prefix('=')?.to_owned()))
}

/// Runs a program (ffmpeg) on a film and returns its standard output.
pub(super) fn output_of(program: &mut Command, path: &Path) -> Result<String, FileError> {
    let output = process::output(program, PATIENCE).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            FileError::read(path, "hachure reads films through ffmpeg, which is not installed")
        }
        std::io::ErrorKind::TimedOut => FileError::read(path, format!("ffmpeg: {error}")),
        _ => FileError::read(path, format!("ffmpeg cannot be started: {error}")),
    })?;
    // Tags and messages are as long as the film's author likes; `process` keeps their beginning.
    if !output.status.success() {
        let messages = &output.stderr[..output.stderr.len().min(LONGEST_MESSAGES_BYTES)];
        return Err(FileError::read(path, format!("ffmpeg: {}", String::from_utf8_lossy(messages))));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_come_back_from_xml_and_from_ffmpeg() {
        let text = "a = \"<&amp;>\"\n\tb = '''x ä'''\n";
        assert_eq!(unescaped(&escaped(text)), text);
        assert_eq!(unescaped("&#65;&#x42;&quot;&apos;&nothing;&"), "AB\"'");
        let written = ";FFMETADATA1\nmajor_brand=isom\nhachure=a \\= 1 \\# \\\\ \\;\\\nb\\=2\nencoder=x\n";
        assert_eq!(of_ffmetadata(written).as_deref(), Some("a = 1 # \\ ;\nb=2"));
        assert_eq!(of_ffmetadata(";FFMETADATA1\nencoder=hachure\n"), None);
    }
}
