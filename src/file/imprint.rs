//! The imprint of an output: a text that says how it was drawn, under the key `hachure` of its format. What it says is
//! [`crate::picture::imprint`]'s matter.
//!
//! - PNG: the chunk `iTXt` of that keyword. The resolution also stands in `pHYs`.
//! - EXR: the attribute of that name, a string. The resolution is `xDensity`, and the camera `worldToCamera` and
//!   `worldToNDC`.
//! - SVG: the text of `<metadata id="hachure">`.
//! - MP4: the tag of that name, which ffmpeg writes and reads.

use std::io::{BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

use super::input::open_regular;
use super::{FileError, exr, png, video};

/// Under which an output has its imprint.
pub const KEY: &str = "hachure";

/// An imprint has no more bytes: a style file may have as many, and so may its recipes.
const LARGEST_BYTES: u64 = 4 << 20;

/// What an output says beside its pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Notes<'a> {
    /// How it was drawn.
    pub imprint: Option<&'a str>,
    /// Dots in an inch of paper.
    pub dpi: Option<f64>,
    /// The eye, where there is one.
    pub matrices: Option<Matrices>,
}

/// Where the eye of a picture is, as the standard attributes of EXR have it.
///
/// Both are to be multiplied with a row vector from the left, and stand row by row. The world is east, north, up in
/// metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrices {
    /// To the camera: x right, y up, and it looks along −z.
    pub camera_from_world: [f32; 16],
    /// To the picture after the division by w: x from −1 at its left side to 1, y from −1 at its lower side to 1; z is
    /// 1 at the near plane and 0 at infinity.
    pub ndc_from_world: [f32; 16],
}

/// The imprint of a PNG, EXR, SVG or MP4, which is known by its content.
///
/// # Errors
/// A file that cannot be read, is damaged where its imprint stands, or has none.
pub fn read(path: &Path) -> Result<String, FileError> {
    let failed = |error: std::io::Error| FileError::read(path, error);
    let mut head = [0; 512];
    let mut file = open_regular(path).map_err(failed)?;
    let mut filled = 0;
    while filled < head.len() {
        match file.read(&mut head[filled..]).map_err(failed)? {
            0 => break,
            bytes => filled += bytes,
        }
    }
    let head = &head[..filled];
    let imprint = if head.starts_with(b"\x89PNG") {
        png::imprint(path)?
    } else if head.starts_with(b"\x76\x2f\x31\x01") {
        exr::imprint(path)?
    } else if head.get(4..8) == Some(b"ftyp") {
        video::imprint(path)?
    } else if String::from_utf8_lossy(head).contains("<svg") {
        of_svg(path)?
    } else {
        return Err(FileError::read(path, "it is no PNG, EXR, SVG or MP4"));
    };
    imprint.ok_or_else(|| FileError::read(path, "it does not say how it was drawn; what hachure render writes does"))
}

/// The text of `<metadata id="hachure">`. Editors of SVG move attributes and break lines, but keep both.
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
        return inside.map(|inside| Some(unescaped(inside))).ok_or_else(|| FileError::read(path, "it is cut"));
    }
    Ok(None)
}

/// A text of XML, of which [`escaped`] wrote the entities; numbers are for what editors make of it.
fn unescaped(text: &str) -> String {
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

/// A text between tags, with its line breaks. What XML cannot hold becomes a question mark.
pub(super) fn escaped(text: &str) -> String {
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

/// What `ffmpeg -f ffmetadata` says of a film: lines `key=value`, in which a backslash stands before each `=`, `;`, `#`,
/// backslash and line break of a value.
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

/// What a program says of a film.
pub(super) fn said(program: &mut Command, path: &Path) -> Result<String, FileError> {
    let output = program.stdin(Stdio::null()).output().map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            FileError::read(path, "hachure reads films through ffmpeg, which is not installed")
        }
        _ => FileError::read(path, format!("ffmpeg does not start: {error}")),
    })?;
    if !output.status.success() {
        return Err(FileError::read(path, format!("ffmpeg: {}", String::from_utf8_lossy(&output.stderr))));
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
