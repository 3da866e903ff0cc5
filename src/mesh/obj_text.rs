//! Sorts the lines of an OBJ text: statements about geometry (`v`, `vn`, `f`, `o`, `g`) are passed to the mesh reader,
//! those about materials (`mtllib`, `usemtl`) are collected here, and all others, texture coordinates included, are
//! left out.
//!
//! The mesh reader gets only the geometry, so materials can neither make a file unreadable nor change its triangles.
//! The material of each triangle follows from counting instead: a face of n corners becomes n - 2 triangles, in the
//! order of the file. A backslash at the end of a line continues it in the next one.

use std::io::{BufRead, Error, Read, Result};

use rustc_hash::FxHashMap;

/// Largest number of faces of a group. A larger group is split, because the mesh reader stores the faces of a group in
/// a form that takes five times the memory of their text. The mesh stays the same; only if some corners of the group
/// have normals and others have none, more of the normals are used than without the split.
const MAX_GROUP_FACES: u32 = 1 << 18;
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
    /// The index of each name in `names`.
    indices: FxHashMap<Vec<u8>, u32>,
}

impl MaterialStatements {
    /// Adds a `usemtl`: a new run begins.
    fn begin_run(&mut self, name: &[u8]) {
        let next = self.names.len() as u32;
        let index = *self.indices.entry(name.to_owned()).or_insert_with(|| {
            self.names.push(name.to_owned());
            next
        });
        self.runs.push((Some(index), 0));
    }

    /// Adds the triangles of a face with this number of corners to the current run.
    fn add_face(&mut self, corners: u64) {
        if self.runs.is_empty() {
            self.runs.push((None, 0));
        }
        if let Some((_, triangles)) = self.runs.last_mut() {
            *triangles += corners.saturating_sub(2);
        }
    }
}

/// The subject of a statement.
#[derive(Clone, Copy, PartialEq)]
enum Subject {
    Vertices,
    Face,
    Group,
    Library,
    Use,
    Nothing,
}

impl Subject {
    /// Returns the subject of a statement by its first word.
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

    fn is_geometry(self) -> bool {
        matches!(self, Self::Vertices | Self::Face | Self::Group)
    }
}

/// Reads a text line by line.
pub(super) struct LineReader<R> {
    from: R,
    /// The current line, and its number, counted from 1.
    line: Vec<u8>,
    number: usize,
    /// The statement of the line.
    subject: Subject,
    /// Whether the statement continues in the next line.
    continues: bool,
    /// Number of corners of a face so far.
    corners: u64,
    /// Text of a statement about materials so far.
    statement: Vec<u8>,
    statements: MaterialStatements,
    /// Number of bytes read so far.
    read_bytes: u64,
}

impl<R: BufRead> LineReader<R> {
    pub(super) fn new(from: R) -> Self {
        Self {
            from,
            line: Vec::new(),
            number: 0,
            subject: Subject::Nothing,
            continues: false,
            corners: 0,
            statement: Vec::new(),
            statements: MaterialStatements::default(),
            read_bytes: 0,
        }
    }

    /// Reads a line, and appends it to `geometry` if it is of a geometry statement, with `?` for each byte that is not
    /// ASCII. Returns whether a geometry statement began in the line, or `None` at the end of the text.
    pub(super) fn read_line(&mut self, geometry: &mut Vec<u8>) -> Result<Option<bool>> {
        self.line.clear();
        let read_bytes = self.from.read_until(b'\n', &mut self.line)?;
        if read_bytes == 0 {
            // The text may end in an unfinished continued line.
            if std::mem::take(&mut self.continues) {
                self.end();
            }
            return Ok(None);
        }
        self.read_bytes += read_bytes as u64;
        self.number += 1;
        // Some editors begin a file with a byte order mark.
        let mark: &[u8] = if self.number == 1 { b"\xef\xbb\xbf" } else { b"" };
        let line = self.line.strip_prefix(mark).unwrap_or(&self.line).trim_ascii();
        let part = line.strip_suffix(b"\\").unwrap_or(line);
        let begins = !self.continues;
        if begins {
            let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            self.subject = Subject::of(word);
        }
        self.continues = part.len() < line.len();
        if self.subject.is_geometry() {
            geometry.extend(part.iter().map(|byte| if byte.is_ascii() { *byte } else { b'?' }));
            geometry.push(if self.continues { b' ' } else { b'\n' });
        }
        match self.subject {
            // The reader's whitespace, which includes the vertical tab.
            Subject::Face => {
                let words = part.split(|byte| matches!(byte, 9..=13 | b' ')).filter(|word| !word.is_empty()).count();
                self.corners += (words - usize::from(begins && words > 0)) as u64;
            }
            Subject::Library | Subject::Use => {
                self.statement.extend_from_slice(part);
                self.statement.push(b' ');
            }
            Subject::Vertices | Subject::Group | Subject::Nothing => {}
        }
        if !self.continues {
            self.end();
        }
        Ok(Some(begins && self.subject.is_geometry()))
    }

    pub(super) fn into_material_statements(self) -> MaterialStatements {
        self.statements
    }

    /// Ends the current statement.
    fn end(&mut self) {
        let value = |statement: &[u8], word: &str| statement[word.len().min(statement.len())..].trim_ascii().to_owned();
        match self.subject {
            Subject::Face => self.statements.add_face(self.corners),
            Subject::Library => self.statements.libraries.push(value(&self.statement, "mtllib")),
            Subject::Use => self.statements.begin_run(&value(&self.statement, "usemtl")),
            Subject::Vertices | Subject::Group | Subject::Nothing => {}
        }
        self.corners = 0;
        self.statement.clear();
    }
}

/// Returns the geometry statements of a text, one in each line, and the number of the line in which each begins,
/// counted from 1.
pub(super) fn numbered_geometry(text: &[u8]) -> (Vec<usize>, String) {
    let mut lines = LineReader::new(text);
    let (mut numbers, mut geometry) = (Vec::new(), Vec::new());
    while let Ok(Some(begins)) = lines.read_line(&mut geometry) {
        if begins {
            numbers.push(lines.number);
        }
    }
    (numbers, String::from_utf8_lossy(&geometry).into_owned())
}

/// A stream of the geometry statements of a text, for the mesh reader.
pub(super) struct GeometryStream<'a, R> {
    lines: LineReader<R>,
    /// The batch of statements that is passed on, and the number of its bytes that were taken.
    batch: Vec<u8>,
    taken_bytes: usize,
    /// Number of faces of the current group so far.
    group_faces: u32,
    /// Called occasionally with the number of bytes read.
    progress: &'a dyn Fn(u64),
    /// The error that ended the stream.
    error: Option<Error>,
}

impl<'a, R: BufRead> GeometryStream<'a, R> {
    pub(super) fn new(from: R, progress: &'a dyn Fn(u64)) -> Self {
        Self {
            lines: LineReader::new(from),
            batch: Vec::with_capacity(2 * BATCH_BYTES),
            taken_bytes: 0,
            group_faces: 0,
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

    /// Reads the next batch.
    fn fill(&mut self) -> Result<()> {
        self.batch.clear();
        self.taken_bytes = 0;
        while self.batch.len() < BATCH_BYTES {
            let Some(begins) = self.lines.read_line(&mut self.batch)? else { break };
            match self.lines.subject {
                Subject::Face if begins => self.group_faces += 1,
                Subject::Group => self.group_faces = 0,
                _ => {}
            }
            if self.group_faces == MAX_GROUP_FACES && !self.lines.continues {
                self.group_faces = 0;
                self.batch.extend_from_slice(b"g\n");
            }
        }
        (self.progress)(self.lines.read_bytes);
        Ok(())
    }
}

impl<R: BufRead> Read for GeometryStream<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl<R: BufRead> BufRead for GeometryStream<'_, R> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        if self.taken_bytes == self.batch.len()
            && let Err(error) = self.fill()
        {
            // The mesh reader would lose the details of the error.
            let kind = error.kind();
            self.error = Some(error);
            return Err(kind.into());
        }
        Ok(&self.batch[self.taken_bytes..])
    }

    fn consume(&mut self, read: usize) {
        self.taken_bytes += read;
    }
}
