//! Reads the words and numbers of text formats one after the other, without the whole text in memory.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use super::SourceError;
use super::place::{cannot_open, inconsistent};

/// Largest length of a number or keyword in bytes.
const MAX_WORD_BYTES: usize = 256;

/// The words of a text file.
pub(super) struct Words {
    path: PathBuf,
    reader: BufReader<File>,
    word: Vec<u8>,
    /// Whether the next call returns the last word again.
    is_put_back: bool,
}

impl Words {
    /// Opens a file at its beginning.
    pub(super) fn open(path: &Path) -> Result<Self, SourceError> {
        let file = File::open(path).map_err(cannot_open(path))?;
        let mut reader = BufReader::with_capacity(1 << 18, file);
        // Windows programs begin UTF-8 with a byte order mark.
        if reader.fill_buf().map_err(cannot_open(path))?.starts_with(b"\xef\xbb\xbf") {
            reader.consume(3);
        }
        Ok(Self { path: path.into(), reader, word: Vec::new(), is_put_back: false })
    }

    /// Returns the next word, or `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<&str>, SourceError> {
        if !std::mem::take(&mut self.is_put_back) {
            self.advance()?;
        }
        match std::str::from_utf8(&self.word) {
            Ok("") => Ok(None),
            Ok(word) => Ok(Some(word)),
            Err(_) => Err(inconsistent(&self.path, "it is not text throughout")),
        }
    }

    /// Makes the next call return the last word again.
    pub(super) fn put_back(&mut self) {
        self.is_put_back = true;
    }

    /// Returns the next word as a number; `what` is its name in errors.
    pub(super) fn number(&mut self, what: &str) -> Result<f64, SourceError> {
        let word = self.next()?.map(str::to_owned);
        let number = word.as_deref().and_then(number);
        number.ok_or_else(|| match word {
            Some(word) => inconsistent(&self.path, format!("{what} is {word:?}, which is not a number")),
            None => inconsistent(&self.path, format!("it ends before {what}")),
        })
    }

    fn advance(&mut self) -> Result<(), SourceError> {
        self.word.clear();
        loop {
            let bytes = self.reader.fill_buf().map_err(cannot_open(&self.path))?;
            if bytes.is_empty() {
                return Ok(());
            }
            let skipped = match self.word.is_empty() {
                true => bytes.iter().take_while(|byte| is_space(**byte)).count(),
                false => 0,
            };
            let rest = &bytes[skipped..];
            let taken = rest.iter().take_while(|byte| !is_space(**byte)).count();
            self.word.extend_from_slice(&rest[..taken.min(MAX_WORD_BYTES + 1)]);
            let is_whole = taken < rest.len() && !self.word.is_empty();
            self.reader.consume(skipped + taken);
            if self.word.len() > MAX_WORD_BYTES {
                return Err(inconsistent(&self.path, "a word in it is longer than any number"));
            }
            if is_whole {
                return Ok(());
            }
        }
    }
}

fn is_space(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0
}

/// Parses a number in the notation of any program: with a decimal comma, or with Fortran's `D` before the exponent. The
/// spellings of undefined numbers (`nan`, `1.#QNAN`) give NaN, and `inf` is infinite.
pub(super) fn number(word: &str) -> Option<f64> {
    if let Ok(number) = word.parse::<f64>() {
        return Some(number);
    }
    let plain = word.to_ascii_lowercase();
    if plain.contains("1.#") || plain.trim_start_matches(['-', '+']) == "nan" {
        return Some(f64::NAN);
    }
    let plain = plain.replace('d', "e");
    match plain.contains('.') {
        true => plain.parse().ok(),
        false => plain.replacen(',', ".", 1).parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_however_they_are_written() {
        let written = ["1.5", "1,5", ",15E+01", "0.15D1", "+1.5", "15d-1"];
        assert!(written.iter().all(|word| number(word) == Some(1.5)), "{written:?}");
        assert!(["nan", "-NaN", "1.#QNAN", "-1.#IND00"].iter().all(|word| number(word).unwrap().is_nan()));
        assert!(["", "x", "1,2,3", "1.5,2", "*", "--1"].iter().all(|word| number(word).is_none()));
    }
}
