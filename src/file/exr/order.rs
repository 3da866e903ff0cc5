//! The order of attributes in the header of an EXR. The crate `exr` writes its own attributes in the random order of a
//! hash map; sorted by name, the same picture has the same bytes in every run.

use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};

/// Bytes before the first attribute: the magic number and the version.
const FIRST_AT: u64 = 8;
/// Upper bound of the length of an attribute, in bytes, to detect a damaged header.
const LARGEST_BYTES: u64 = 256 << 20;

/// Sorts the attributes of the header in place. Their order means nothing, and they take the same bytes in any order.
pub(super) fn sort_attributes(file: &mut BufWriter<File>) -> io::Result<()> {
    file.flush()?;
    let file = file.get_mut();
    file.seek(SeekFrom::Start(FIRST_AT))?;
    let mut attributes = Vec::new();
    let mut reader = BufReader::new(&*file);
    while let Some(attribute) = read_attribute(&mut reader)? {
        attributes.push(attribute);
    }
    attributes.sort();
    file.seek(SeekFrom::Start(FIRST_AT))?;
    file.write_all(&attributes.concat())?;
    file.seek(SeekFrom::End(0)).map(drop)
}

/// Reads an attribute with its name, type and length; `None` at the end of the header.
fn read_attribute(reader: &mut impl BufRead) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    reader.read_until(0, &mut bytes)?;
    if bytes == [0] {
        return Ok(None);
    }
    reader.read_until(0, &mut bytes)?;
    let mut length = [0; 4];
    reader.read_exact(&mut length)?;
    bytes.extend(length);
    let length = u64::from(u32::from_le_bytes(length));
    let found = reader.take(length.min(LARGEST_BYTES)).read_to_end(&mut bytes)?;
    if found as u64 == length { Ok(Some(bytes)) } else { Err(ErrorKind::UnexpectedEof.into()) }
}
