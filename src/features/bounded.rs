//! A buffered file in which the bytes of one feature are limited.
//!
//! A parser stores what it has not finished: a string without an end, or a row whose quotation mark is never closed.
//! Without a limit it would store the rest of the file.

use std::cell::Cell;
use std::fs::File;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Result};
use std::path::Path;
use std::rc::Rc;

use crate::file::input::open_regular;

/// Largest number of bytes that one feature may take in a file.
pub(super) const FEATURE_BYTES: u64 = 512 << 20;

/// Number of bytes that are read from the system at once.
const BUFFER_BYTES: usize = 1 << 17;

/// The number of bytes that have been read of the present feature.
#[derive(Clone, Debug, Default)]
pub(super) struct Gauge(Rc<Cell<u64>>);

impl Gauge {
    /// Starts to count the bytes of the next feature.
    pub(super) fn reset(&self) {
        self.0.set(0);
    }

    fn add(&self, bytes: u64) {
        self.0.set(self.0.get().saturating_add(bytes));
    }

    fn check(&self) -> Result<()> {
        if self.0.get() > FEATURE_BYTES {
            let cause = format!("one of its features has more than {} MiB", FEATURE_BYTES >> 20);
            return Err(Error::new(ErrorKind::FileTooLarge, cause));
        }
        Ok(())
    }
}

/// A file that returns an error if a feature is too large.
pub(super) struct Bounded {
    reader: BufReader<File>,
    gauge: Gauge,
}

impl Bounded {
    /// Opens a text file after its byte order mark.
    pub(super) fn open(path: &Path) -> Result<(Self, Gauge)> {
        let mut reader = BufReader::with_capacity(BUFFER_BYTES, open_regular(path)?);
        if reader.fill_buf()?.starts_with(b"\xef\xbb\xbf") {
            reader.consume(3);
        }
        let gauge = Gauge::default();
        Ok((Self { reader, gauge: gauge.clone() }, gauge))
    }
}

impl Read for Bounded {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let read = self.reader.read(buffer)?;
        self.gauge.add(read as u64);
        self.gauge.check()?;
        Ok(read)
    }
}

impl BufRead for Bounded {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        self.gauge.check()?;
        self.reader.fill_buf()
    }

    fn consume(&mut self, bytes: usize) {
        self.gauge.add(bytes as u64);
        self.reader.consume(bytes);
    }
}

/// Bytes in which one value is replaced by another.
pub(super) struct Replaced<R> {
    pub(super) reader: R,
    pub(super) from: u8,
    pub(super) to: u8,
}

impl<R: Read> Read for Replaced<R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let read = self.reader.read(buffer)?;
        buffer.iter_mut().take(read).filter(|byte| **byte == self.from).for_each(|byte| *byte = self.to);
        Ok(read)
    }
}
