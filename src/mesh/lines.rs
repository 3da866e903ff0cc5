//! The lines of an OBJ text: those that define triangles are passed to the mesh reader, those about materials are
//! collected here.
//!
//! The mesh reader sees nothing but lines that define triangles, so materials can neither make a file unreadable nor
//! change its geometry. The material of each triangle follows from counting instead: a face of n corners becomes n - 2
//! triangles, in the order of the file. A backslash at the end of a line continues it in the next one.

use std::io::{BufRead, Error, Read, Result};

use rustc_hash::FxHashMap;

/// The reader stores the faces of a group in a form that takes five times the memory of their text; so a larger group
/// is read as several, which gives the same mesh. Only where some corners of such a group have normals and others have
/// none, more normals are retained than otherwise.
const FACES_OF_GROUP: u32 = 1 << 18;
/// Number of bytes that are passed on at once.
const BATCH_BYTES: usize = 1 << 16;

/// The statements of a text about materials.
#[derive(Debug, Default)]
pub(super) struct MaterialStatements {
    /// The arguments of `mtllib`.
    pub libraries: Vec<Vec<u8>>,
    /// The different arguments of `usemtl`.
    pub names: Vec<Vec<u8>>,
    /// Runs of triangles, in order: the index of their material name (`None` before the first), and their number.
    pub runs: Vec<(Option<u32>, u64)>,
    numbers: FxHashMap<Vec<u8>, u32>,
}

impl MaterialStatements {
    fn uses(&mut self, name: &[u8]) {
        let next = self.names.len() as u32;
        let number = *self.numbers.entry(name.to_owned()).or_insert_with(|| {
            self.names.push(name.to_owned());
            next
        });
        self.runs.push((Some(number), 0));
    }

    fn face(&mut self, corners: u64) {
        if self.runs.is_empty() {
            self.runs.push((None, 0));
        }
        if let Some((_, triangles)) = self.runs.last_mut() {
            *triangles += corners.saturating_sub(2);
        }
    }
}

/// The subject of a line.
#[derive(Clone, Copy, PartialEq)]
enum About {
    Vertices,
    Face,
    Group,
    Library,
    Use,
    Nothing,
}

impl About {
    fn of(word: &[u8]) -> Self {
        match word {
            b"v" | b"vn" => Self::Vertices,
            b"f" => Self::Face,
            b"o" | b"g" => Self::Group,
            b"mtllib" => Self::Library,
            b"usemtl" => Self::Use,
            _ => Self::Nothing,
        }
    }

    fn is_kept(self) -> bool {
        matches!(self, Self::Vertices | Self::Face | Self::Group)
    }
}

/// Reads lines one by one.
pub(super) struct Lines<R> {
    from: R,
    raw: Vec<u8>,
    number: usize,
    about: About,
    goes_on: bool,
    /// Number of words of a face so far, without the first.
    corners: u64,
    /// The statement about materials so far.
    statement: Vec<u8>,
    statements: MaterialStatements,
    read_bytes: u64,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(from: R) -> Self {
        Self {
            from,
            raw: Vec::new(),
            number: 0,
            about: About::Nothing,
            goes_on: false,
            corners: 0,
            statement: Vec::new(),
            statements: MaterialStatements::default(),
            read_bytes: 0,
        }
    }

    /// Reads a line and appends it to `kept`, as ASCII, if it defines triangles. Returns whether a statement began
    /// there, or `None` at the end of the text.
    pub(super) fn step(&mut self, kept: &mut Vec<u8>) -> Result<Option<bool>> {
        self.raw.clear();
        let read = self.from.read_until(b'\n', &mut self.raw)?;
        if read == 0 {
            // The text may end in an unfinished continued line.
            if std::mem::take(&mut self.goes_on) {
                self.end();
            }
            return Ok(None);
        }
        self.read_bytes += read as u64;
        self.number += 1;
        // Some editors begin a file with a byte order mark.
        let mark: &[u8] = if self.number == 1 { b"\xef\xbb\xbf" } else { b"" };
        let line = self.raw.strip_prefix(mark).unwrap_or(&self.raw).trim_ascii();
        let part = line.strip_suffix(b"\\").unwrap_or(line);
        let begins = !self.goes_on;
        if begins {
            let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            self.about = About::of(word);
        }
        self.goes_on = part.len() < line.len();
        if self.about.is_kept() {
            kept.extend(part.iter().map(|byte| if byte.is_ascii() { *byte } else { b'?' }));
            kept.push(if self.goes_on { b' ' } else { b'\n' });
        }
        match self.about {
            // The reader's whitespace, which includes the vertical tab.
            About::Face => {
                let words = part.split(|byte| matches!(byte, 9..=13 | b' ')).filter(|word| !word.is_empty()).count();
                self.corners += (words - usize::from(begins && words > 0)) as u64;
            }
            About::Library | About::Use => {
                self.statement.extend_from_slice(part);
                self.statement.push(b' ');
            }
            About::Vertices | About::Group | About::Nothing => {}
        }
        if !self.goes_on {
            self.end();
        }
        Ok(Some(begins && self.about.is_kept()))
    }

    pub(super) fn into_material_statements(self) -> MaterialStatements {
        self.statements
    }

    /// Ends a statement.
    fn end(&mut self) {
        let value = |statement: &[u8], word: &str| statement[word.len().min(statement.len())..].trim_ascii().to_owned();
        match self.about {
            About::Face => self.statements.face(self.corners),
            About::Library => self.statements.libraries.push(value(&self.statement, "mtllib")),
            About::Use => self.statements.uses(&value(&self.statement, "usemtl")),
            About::Vertices | About::Group | About::Nothing => {}
        }
        self.corners = 0;
        self.statement.clear();
    }
}

/// Returns the lines of a text that define triangles, with their numbers, counted from 1.
pub(super) fn numbered(text: &[u8]) -> (Vec<usize>, String) {
    let mut lines = Lines::new(text);
    let (mut numbers, mut kept) = (Vec::new(), Vec::new());
    while let Ok(Some(begins)) = lines.step(&mut kept) {
        if begins {
            numbers.push(lines.number);
        }
    }
    (numbers, String::from_utf8_lossy(&kept).into_owned())
}

/// A stream of the lines that define triangles.
pub(super) struct Stream<'a, R> {
    lines: Lines<R>,
    kept: Vec<u8>,
    at: usize,
    faces: u32,
    /// Called occasionally with the number of bytes read.
    progress: &'a dyn Fn(u64),
    error: Option<Error>,
}

impl<'a, R: BufRead> Stream<'a, R> {
    pub(super) fn new(from: R, progress: &'a dyn Fn(u64)) -> Self {
        Self {
            lines: Lines::new(from),
            kept: Vec::with_capacity(2 * BATCH_BYTES),
            at: 0,
            faces: 0,
            progress,
            error: None,
        }
    }

    /// Returns the text's statements about materials, or the error that occurred while reading it.
    pub(super) fn into_material_statements(self) -> Result<MaterialStatements> {
        match self.error {
            Some(error) => Err(error),
            None => Ok(self.lines.into_material_statements()),
        }
    }

    fn fill(&mut self) -> Result<()> {
        self.kept.clear();
        self.at = 0;
        while self.kept.len() < BATCH_BYTES {
            let Some(begins) = self.lines.step(&mut self.kept)? else { break };
            match self.lines.about {
                About::Face if begins => self.faces += 1,
                About::Group => self.faces = 0,
                _ => {}
            }
            if self.faces == FACES_OF_GROUP && !self.lines.goes_on {
                self.faces = 0;
                self.kept.extend_from_slice(b"g\n");
            }
        }
        (self.progress)(self.lines.read_bytes);
        Ok(())
    }
}

impl<R: BufRead> Read for Stream<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl<R: BufRead> BufRead for Stream<'_, R> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        if self.at == self.kept.len()
            && let Err(error) = self.fill()
        {
            // The mesh reader would lose the details of the error.
            let kind = error.kind();
            self.error = Some(error);
            return Err(kind.into());
        }
        Ok(&self.kept[self.at..])
    }

    fn consume(&mut self, read: usize) {
        self.at += read;
    }
}
