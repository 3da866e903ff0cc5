//! MTL files: material libraries.
//!
//! `tobj` has a reader for them, but it rejects the whole library if one line is damaged (`newmtl` without a name, as
//! Blender wrote it; `d` without a number), reads only UTF-8, misses the first material after a byte order mark, and
//! panics where `Kd` has fewer than three numbers. This reader ignores lines that it cannot read.
//!
//! Only the plain colour is read: `Kd`, the texture in its place, and the opacity.
//!
//! The format does not say whether `Kd` is linear light or sRGB. Blender writes its linear colours unchanged (a birch's
//! dark green is `0.0425 0.0727 0.0296`, which would be black in sRGB) and its name into the first line. Colours of
//! other programs were picked on a screen: Kenney's are whole 255ths. So libraries by Blender are read as linear and
//! all others as sRGB, which three.js assumes for all.

/// A material of a library.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Entry {
    pub name: Vec<u8>,
    /// `Kd`, in linear light.
    pub diffuse: Option<[f32; 3]>,
    /// Opacity; 1 is opaque.
    pub opacity: Option<f64>,
    /// The file name of the texture.
    pub texture: Option<Vec<u8>>,
}

/// The content of a library.
#[derive(Debug, Default)]
pub(super) struct Library {
    /// Materials in the order of the file; of several with one name the first counts.
    pub entries: Vec<Entry>,
    /// The first line that could not be read, counted from 1, and the reason.
    pub wrong: Option<(usize, &'static str)>,
}

/// Converts a channel of an sRGB colour to linear light.
pub(crate) fn linear_from_srgb(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

pub(super) fn parse(text: &[u8]) -> Library {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let first = text.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let is_linear = first.starts_with(b"#") && first.windows(7).any(|word| word == b"Blender");
    let mut library = Library::default();
    // If both `d` and `Tr` are given, `d` counts: some programs write `Tr` inverted.
    let mut has_dissolve = false;
    for (number, line) in text.split(|&byte| byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        let word_end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (word, value) = (line[..word_end].to_ascii_lowercase(), line[word_end..].trim_ascii());
        if word == b"newmtl" {
            library.entries.push(Entry { name: value.to_owned(), ..Entry::default() });
            has_dissolve = false;
            continue;
        }
        let Some(entry) = library.entries.last_mut() else { continue };
        let wrong = match word.as_slice() {
            b"kd" => match color(value, is_linear) {
                Some(color) => {
                    entry.diffuse = Some(color);
                    None
                }
                None => Some("Kd needs a red, a green and a blue from 0 to 1"),
            },
            b"d" | b"tr" => {
                // `d -halo 0.5`
                let value = numbers(value.strip_prefix(b"-halo").unwrap_or(value)).first().copied();
                match value {
                    Some(value) if word == b"d" => {
                        has_dissolve = true;
                        entry.opacity = Some(value);
                        None
                    }
                    Some(value) => {
                        if !has_dissolve {
                            entry.opacity = Some(1.0 - value);
                        }
                        None
                    }
                    None => Some("transparency needs a number"),
                }
            }
            b"map_kd" => {
                let file = without_options(value);
                entry.texture = (!file.is_empty()).then(|| file.to_owned());
                file.is_empty().then_some("map_Kd names no file")
            }
            _ => None,
        };
        library.wrong = library.wrong.or(wrong.map(|cause| (number + 1, cause)));
    }
    library
}

fn numbers(value: &[u8]) -> Vec<f64> {
    let words = value.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let number = |word: &[u8]| std::str::from_utf8(word).ok()?.parse::<f64>().ok().filter(|number| number.is_finite());
    words.map_while(number).collect()
}

/// Parses a colour. One number is grey; values above 1 are clamped to 1.
fn color(value: &[u8], is_linear: bool) -> Option<[f32; 3]> {
    let color = match numbers(value)[..] {
        [grey] => [grey; 3],
        [red, green, blue, ..] => [red, green, blue],
        _ => return None,
    };
    let linear = |value: f64| if is_linear { value } else { linear_from_srgb(value) };
    Some(color.map(|value| linear(value.clamp(0.0, 1.0)) as f32))
}

/// Returns the file name of a texture, which may contain spaces, without preceding options: `-s 1 1 -clamp on a
/// tree.png`.
fn without_options(value: &[u8]) -> &[u8] {
    let mut rest = value;
    loop {
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (least, most) = match &rest[..end] {
            b"-blendu" | b"-blendv" | b"-cc" | b"-clamp" | b"-texres" | b"-imfchan" | b"-bm" | b"-boost"
            | b"-colorspace" | b"-type" => (1, 1),
            b"-mm" => (2, 2),
            b"-o" | b"-s" | b"-t" => (1, 3),
            _ => return rest,
        };
        rest = rest[end..].trim_ascii_start();
        for i in 0..most {
            let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
            if i >= least && numbers(&rest[..end]).is_empty() {
                break;
            }
            rest = rest[end..].trim_ascii_start();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_is_read_line_by_line() {
        let text =
            b"\xef\xbb\xbfnewmtl bark\r\n\tKd 0 1 0.5\r\n  newmtl  two words \r\nKd 0.8\r\nTr 0.25\r\nd oops\r\n\
            newmtl \r\nD 0.5\r\nTr 1\r\nmap_Kd -s 1 2 -o 0.1 -clamp on a tree.png\r\nKd 1\r\nKd 1 2\r\n";
        let library = parse(text);
        let [bark, two, none] = &library.entries[..] else { panic!("{library:?}") };
        assert_eq!(
            (bark.name.as_slice(), two.name.as_slice(), none.name.as_slice()),
            (&b"bark"[..], &b"two words"[..], &b""[..])
        );
        let color = bark.diffuse.unwrap();
        assert!(color[0] == 0.0 && color[1] == 1.0 && (color[2] - 0.214).abs() < 1e-3, "{color:?}");
        assert_eq!((two.opacity, none.opacity), (Some(0.75), Some(0.5)));
        assert_eq!(none.texture.as_deref(), Some(&b"a tree.png"[..]));
        assert_eq!(none.diffuse, Some([1.0; 3]), "the line that cannot be read changes nothing");
        assert_eq!(library.wrong, Some((6, "transparency needs a number")));
        // Planted error: the same number from Blender is another colour.
        let blender = parse(b"# Blender MTL File: 'x'\nnewmtl a\nKd 0 1 0.5\n");
        assert_eq!(blender.entries[0].diffuse, Some([0.0, 1.0, 0.5]));
    }

    #[test]
    fn names_of_textures_have_options_before_them() {
        for (line, name) in [
            (&b"-colorspace sRGB -o 0.1 diffuse.jpg"[..], &b"diffuse.jpg"[..]),
            (b"-bm 3 bump.jpg", b"bump.jpg"),
            (b"-s 1 1 1 1.png", b"1.png"),
            (b"a -s 1.png", b"a -s 1.png"),
            (b"-clamp", b""),
        ] {
            assert_eq!(without_options(line), name);
        }
    }
}
