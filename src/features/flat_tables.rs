//! Reads tables of FlatBuffers with checked bounds.
//!
//! A table begins with the signed distance back to its list of fields, which has an offset from the table for each field
//! that is present. Strings, lists and other tables are stored elsewhere, at a distance forward from their field. Every
//! access returns `None` outside of the buffer: the code that is generated for FlatBuffers panics at lists that are
//! shorter than expected.

/// A buffer that begins with the distance to its root table.
#[derive(Clone, Copy)]
pub(super) struct Buffer<'a>(&'a [u8]);

/// A table in a buffer.
#[derive(Clone, Copy)]
pub(super) struct Table<'a> {
    buffer: &'a [u8],
    begin: usize,
    /// Where the list of fields begins.
    fields: usize,
    /// Length of the list of fields in bytes.
    fields_bytes: usize,
}

/// A list of entries of a fixed size.
#[derive(Clone, Copy)]
pub(super) struct List<'a> {
    buffer: &'a [u8],
    begin: usize,
    length: usize,
}

fn chunk<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..)?.first_chunk::<N>().copied()
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    usize::try_from(u32::from_le_bytes(chunk(bytes, at)?)).ok()
}

fn u16_at(bytes: &[u8], at: usize) -> Option<usize> {
    Some(usize::from(u16::from_le_bytes(chunk(bytes, at)?)))
}

/// Returns the place to which the distance at `at` points.
fn follow(bytes: &[u8], at: usize) -> Option<usize> {
    at.checked_add(u32_at(bytes, at)?)
}

impl<'a> Buffer<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Returns the root table.
    pub(super) fn root(self) -> Option<Table<'a>> {
        Table::at(self.0, follow(self.0, 0)?)
    }
}

impl<'a> Table<'a> {
    fn at(buffer: &'a [u8], begin: usize) -> Option<Self> {
        let back = i32::from_le_bytes(chunk(buffer, begin)?);
        let fields = usize::try_from(i64::try_from(begin).ok()?.checked_sub(i64::from(back))?).ok()?;
        let fields_bytes = u16_at(buffer, fields)?;
        let end = fields.checked_add(fields_bytes)?;
        (fields_bytes >= 4 && end <= buffer.len()).then_some(Self { buffer, begin, fields, fields_bytes })
    }

    /// Returns where a field is stored; `None` if it is absent.
    fn field(&self, number: usize) -> Option<usize> {
        let entry = 4 + 2 * number;
        if entry + 2 > self.fields_bytes {
            return None;
        }
        let offset = u16_at(self.buffer, self.fields + entry)?;
        (offset != 0).then(|| self.begin.checked_add(offset)).flatten()
    }

    /// Returns a number of one byte.
    pub(super) fn u8(&self, number: usize) -> Option<u8> {
        chunk::<1>(self.buffer, self.field(number)?).map(|[byte]| byte)
    }

    /// Returns a number of two bytes.
    pub(super) fn u16(&self, number: usize) -> Option<u16> {
        chunk(self.buffer, self.field(number)?).map(u16::from_le_bytes)
    }

    /// Returns a signed number of four bytes.
    pub(super) fn i32(&self, number: usize) -> Option<i32> {
        chunk(self.buffer, self.field(number)?).map(i32::from_le_bytes)
    }

    /// Returns a number of eight bytes.
    pub(super) fn u64(&self, number: usize) -> Option<u64> {
        chunk(self.buffer, self.field(number)?).map(u64::from_le_bytes)
    }

    /// Returns a table.
    pub(super) fn table(&self, number: usize) -> Option<Table<'a>> {
        Self::at(self.buffer, follow(self.buffer, self.field(number)?)?)
    }

    /// Returns a list whose entries take `entry_bytes` each.
    pub(super) fn list(&self, number: usize, entry_bytes: usize) -> Option<List<'a>> {
        let place = follow(self.buffer, self.field(number)?)?;
        let (length, begin) = (u32_at(self.buffer, place)?, place.checked_add(4)?);
        let end = begin.checked_add(length.checked_mul(entry_bytes)?)?;
        (end <= self.buffer.len()).then_some(List { buffer: self.buffer, begin, length })
    }

    /// Returns a list of bytes.
    pub(super) fn bytes(&self, number: usize) -> Option<&'a [u8]> {
        let List { buffer, begin, length } = self.list(number, 1)?;
        buffer.get(begin..begin + length)
    }

    /// Reads a field that holds a UTF-8 string.
    pub(super) fn text(&self, number: usize) -> Option<&'a str> {
        std::str::from_utf8(self.bytes(number)?).ok()
    }

    /// Returns whether a field is present, even if it cannot be read.
    pub(super) fn has(&self, number: usize) -> bool {
        self.field(number).is_some()
    }
}

impl<'a> List<'a> {
    /// Returns the number of entries.
    pub(super) fn len(&self) -> usize {
        self.length
    }

    /// Returns an entry of a list of numbers of eight bytes.
    pub(super) fn f64(&self, index: usize) -> Option<f64> {
        chunk(self.buffer, self.place(index, 8)?).map(f64::from_le_bytes)
    }

    /// Returns an entry of a list of numbers of four bytes.
    pub(super) fn u32(&self, index: usize) -> Option<usize> {
        u32_at(self.buffer, self.place(index, 4)?)
    }

    /// Returns an entry of a list of tables.
    pub(super) fn table(&self, index: usize) -> Option<Table<'a>> {
        Table::at(self.buffer, follow(self.buffer, self.place(index, 4)?)?)
    }

    fn place(&self, index: usize, entry_bytes: usize) -> Option<usize> {
        (index < self.length).then(|| index.checked_mul(entry_bytes)?.checked_add(self.begin)).flatten()
    }
}
