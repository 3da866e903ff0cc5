//! One request: a range of bytes from a file, or from another machine.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::time::Duration;

use super::address::{Address, Location};
use super::network::Server;
use super::{Cancelled, RemoteError, Settings};

/// What answers.
pub enum Transport {
    /// A file on this machine.
    File(File),
    /// A web server, or a bucket.
    Server(Server),
}

/// Bytes, and which file they are of.
pub struct Answer {
    pub bytes: Vec<u8>,
    /// Of the whole file.
    pub size: u64,
    /// Changes when the file does: ETag and time of change. None where the server tells neither.
    pub version: Option<String>,
}

/// Why there are none.
#[derive(Debug)]
pub enum NoAnswer {
    /// It may be better next time.
    Again(String),
    /// The same, and the server asks for a pause.
    AsyncReadback(String, Duration),
    /// It will not.
    Never(RemoteError),
}

impl Transport {
    pub fn open(address: &Address, settings: &Settings) -> Result<Self, RemoteError> {
        match &address.location {
            Location::File(path) => match File::open(path) {
                Ok(file) => Ok(Self::File(file)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    Err(RemoteError::NotFound { name: address.name.clone() })
                }
                Err(source) => Err(RemoteError::Io { name: address.name.clone(), source }),
            },
            Location::Http { .. } | Location::S3 { .. } => Server::open(address, settings).map(Self::Server),
        }
    }

    /// Whether the bytes come from another machine.
    pub fn is_remote(&self) -> bool {
        !matches!(self, Self::File(_))
    }

    /// The bytes of `range`, which is not empty; fewer where the file ends before.
    pub fn get(&self, range: Range<u64>, address: &Address, cancelled: Cancelled<'_>) -> Result<Answer, NoAnswer> {
        match self {
            Self::File(file) => read(file, range)
                .map_err(|source| NoAnswer::Never(RemoteError::Io { name: address.name.clone(), source })),
            Self::Server(server) => server.get(range, address, cancelled),
        }
    }
}

fn read(file: &File, range: Range<u64>) -> io::Result<Answer> {
    let metadata = file.metadata()?;
    let size = metadata.len();
    let end = range.end.min(size);
    let mut bytes = vec![0; end.saturating_sub(range.start) as usize];
    read_exact_at(file, &mut bytes, range.start)?;
    let version = metadata.modified().ok().map(|time| format!("{time:?}"));
    Ok(Answer { bytes, size, version })
}

#[cfg(unix)]
fn read_exact_at(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, offset)
}

#[cfg(windows)]
fn read_exact_at(file: &File, mut bytes: &mut [u8], mut offset: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, bytes, offset)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            read => {
                bytes = &mut bytes[read..];
                offset += read as u64;
            }
        }
    }
    Ok(())
}
