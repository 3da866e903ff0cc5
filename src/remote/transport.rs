//! Sends one request for a range of bytes: to a local file or to a server.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::time::Duration;

use super::network::Server;
use super::url::{Location, RemoteUrl};
use super::{Cancelled, RemoteError, Settings};

/// The origin of the bytes.
pub(super) enum Transport {
    /// A local file.
    File(File),
    /// A web server or a bucket.
    Server(Server),
}

/// The bytes of an answer, and the size and version of their file.
pub(super) struct Answer {
    pub bytes: Vec<u8>,
    /// Size of the whole file in bytes.
    pub size: u64,
    /// Changes when the file does: ETag or modification time. `None` if the server reports neither.
    pub version: Option<String>,
}

/// The reason why a request got no answer.
#[derive(Debug)]
pub(super) enum NoAnswer {
    /// Another try may succeed.
    Again(String),
    /// Another try may succeed after the pause that the server requests; the cause does not name the pause.
    AfterPause(String, Duration),
    /// No further try will succeed.
    Never(RemoteError),
}

impl Transport {
    pub(super) fn open(url: &RemoteUrl, settings: &Settings) -> Result<Self, RemoteError> {
        match &url.location {
            Location::File(path) => match File::open(path) {
                Ok(file) => Ok(Self::File(file)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    Err(RemoteError::NotFound { name: url.name.clone() })
                }
                Err(source) => Err(RemoteError::Io { name: url.name.clone(), source }),
            },
            Location::Http { .. } | Location::S3 { .. } => Server::open(url, settings).map(Self::Server),
        }
    }

    /// Returns whether the bytes come from another machine.
    pub(super) fn is_remote(&self) -> bool {
        !matches!(self, Self::File(_))
    }

    /// Requests the bytes of `range`, which must not be empty; returns fewer where the file ends before.
    pub(super) fn get(&self, range: Range<u64>, url: &RemoteUrl, cancelled: Cancelled<'_>) -> Result<Answer, NoAnswer> {
        match self {
            Self::File(file) => {
                read(file, range).map_err(|source| NoAnswer::Never(RemoteError::Io { name: url.name.clone(), source }))
            }
            Self::Server(server) => server.get(range, url, cancelled),
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
