//! A look at an MP4 that another program wrote: whether it is complete, and how many frames it has.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::input::open_regular;

/// Largest index (`moov`) that is read, in bytes: about 16 per frame.
const LARGEST_INDEX_BYTES: u64 = 256 << 20;

/// Returns what is wrong with a film that should have `frames` frames, as the end of a sentence; `None` if nothing is.
pub(super) fn fault(path: &Path, frames: u64) -> Option<String> {
    match frame_count(path) {
        Err(error) => Some(format!("wrote a film that cannot be read ({error})")),
        Ok(None) => Some("wrote no film, or only a part of one".to_owned()),
        Ok(Some(found)) if u64::from(found) < frames => Some(format!("wrote {found} of {frames} frames")),
        Ok(Some(_)) => None,
    }
}

/// Returns the number of frames of the first track; `None` if the file is not a complete MP4.
fn frame_count(path: &Path) -> io::Result<Option<u32>> {
    let mut file = open_regular(path)?;
    let length = file.metadata()?.len();
    let (mut at, mut index, mut has_type, mut has_data) = (0, None, false, false);
    while at < length {
        file.seek(SeekFrom::Start(at))?;
        let mut head = Vec::new();
        (&mut file).take(16).read_to_end(&mut head)?;
        let Some((kind, head_bytes, bytes)) = box_head(&head, length - at) else { return Ok(None) };
        has_type |= kind == *b"ftyp";
        has_data |= kind == *b"mdat";
        if kind == *b"moov" && bytes <= LARGEST_INDEX_BYTES {
            let mut moov = Vec::new();
            file.seek(SeekFrom::Start(at + head_bytes))?;
            (&mut file).take(bytes - head_bytes).read_to_end(&mut moov)?;
            index = Some(moov);
        }
        at += bytes;
    }
    let samples = index.as_deref().and_then(|moov| {
        let sizes =
            [b"trak", b"mdia", b"minf", b"stbl", b"stsz"].iter().try_fold(moov, |inside, kind| find(inside, kind))?;
        Some(u32::from_be_bytes(sizes.get(8..12)?.try_into().ok()?))
    });
    Ok(samples.filter(|&samples| has_type && has_data && samples > 0))
}

/// Returns the content of the first box of a kind within another box.
fn find<'a>(mut inside: &'a [u8], wanted: &[u8; 4]) -> Option<&'a [u8]> {
    loop {
        let (kind, head_bytes, bytes) = box_head(inside, inside.len() as u64)?;
        let (this, rest) = inside.split_at_checked(bytes as usize)?;
        if kind == *wanted {
            return this.get(head_bytes as usize..);
        }
        inside = rest;
    }
}

/// Returns the kind of the box that begins with these bytes, the length of its head, and its whole length, of which
/// `room` bytes are available. `None` if it is damaged or cut off.
fn box_head(bytes: &[u8], room: u64) -> Option<([u8; 4], u64, u64)> {
    let short = u32::from_be_bytes(bytes.get(..4)?.try_into().ok()?);
    let kind = bytes.get(4..8)?.try_into().ok()?;
    let (head_bytes, length) = match short {
        0 => (8, room),
        1 => (16, u64::from_be_bytes(bytes.get(8..16)?.try_into().ok()?)),
        _ => (8, short.into()),
    };
    (head_bytes <= length && length <= room).then_some((kind, head_bytes, length))
}

/// A complete film of one frame.
#[cfg(test)]
pub(crate) const SMALLEST: &[u8] = b"\0\0\0\x10ftypisom\0\0\0\0\0\0\0\x3cmoov\0\0\0\x34trak\0\0\0\x2cmdia\
    \0\0\0\x24minf\0\0\0\x1cstbl\0\0\0\x14stsz\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0\x08mdat";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::atomic;

    #[test]
    fn a_film_is_whole_or_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mp4");
        let fault_of = |bytes: &[u8], frames: u64| {
            atomic::write(&path, bytes).unwrap();
            fault(&path, frames)
        };
        assert_eq!(fault_of(SMALLEST, 1), None);
        assert_eq!(fault_of(SMALLEST, 2).unwrap(), "wrote 1 of 2 frames");
        // Every shorter file is found, and so is one without its index, its data or its type.
        for length in 0..SMALLEST.len() {
            assert!(fault_of(&SMALLEST[..length], 1).is_some(), "{length}");
        }
        for kind in ["ftyp", "moov", "stsz", "mdat"] {
            let at = SMALLEST.windows(4).position(|window| window == kind.as_bytes()).unwrap();
            let mut bytes = SMALLEST.to_vec();
            bytes[at] = b'x';
            assert!(fault_of(&bytes, 1).is_some(), "{kind}");
        }
        assert!(fault(&folder.path().join("none"), 1).unwrap().contains("cannot be read"));
    }
}
