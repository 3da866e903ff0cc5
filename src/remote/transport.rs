//! One request: a range of bytes from a file, a web server, or a bucket.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::pin::pin;
use std::sync::OnceLock;
use std::time::Duration;

use tokio::runtime::Runtime;

use super::address::{Address, Place};
use super::bucket::Object;
use super::http::Client;
use super::{Cancelled, RemoteError, Settings};

/// How often a request looks whether it is still wanted.
const LOOK: Duration = Duration::from_millis(20);

/// What answers.
pub enum Transport {
    /// A file on this machine.
    File(File),
    /// A web server.
    Http { client: Client, request: Box<reqwest::Request> },
    /// A bucket.
    Bucket(Object),
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
    Later(String, Duration),
    /// It will not.
    Never(RemoteError),
}

impl Transport {
    pub fn open(address: &Address, settings: &Settings) -> Result<Self, RemoteError> {
        match &address.place {
            Place::File(path) => match File::open(path) {
                Ok(file) => Ok(Self::File(file)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    Err(RemoteError::NotFound { name: address.name.clone() })
                }
                Err(source) => Err(RemoteError::Io { name: address.name.clone(), source }),
            },
            Place::Http { url, login } => {
                let client = Client::new(address, settings)?;
                let request = Box::new(client.request(url, login.as_deref())?);
                Ok(Self::Http { client, request })
            }
            Place::S3 { bucket, key } => Object::new(address, bucket, key, settings).map(Self::Bucket),
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
            Self::Http { client, request } => {
                // A request without a body can be made again.
                let request = request.try_clone().ok_or_else(|| NoAnswer::Again("no request was made".into()))?;
                wait_for(client.range(request, range), address, cancelled)
            }
            Self::Bucket(object) => wait_for(object.range(range, address), address, cancelled),
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

/// The threads on which connections live: two for the whole program, from the first request on.
fn runtime() -> Result<&'static Runtime, &'static str> {
    static RUNTIME: OnceLock<Result<Runtime, String>> = OnceLock::new();
    let build = || {
        let mut runtime = tokio::runtime::Builder::new_multi_thread();
        runtime
            .worker_threads(2)
            .thread_name("remote")
            .enable_all()
            .build()
            .map_err(|error| format!("no threads for the network: {error}"))
    };
    RUNTIME.get_or_init(build).as_ref().map_err(String::as_str)
}

/// Waits for an answer, which has deadlines of its own, and looks now and then whether it is still wanted.
fn wait_for(
    request: impl Future<Output = Result<Answer, NoAnswer>>,
    address: &Address,
    cancelled: Cancelled<'_>,
) -> Result<Answer, NoAnswer> {
    let runtime = runtime().map_err(|cause| {
        NoAnswer::Never(RemoteError::Unusable { name: address.name.clone(), cause: cause.to_owned() })
    })?;
    runtime.block_on(async {
        let mut request = pin!(request);
        loop {
            match tokio::time::timeout(LOOK, request.as_mut()).await {
                Ok(answer) => return answer,
                Err(_) if cancelled() => return Err(NoAnswer::Never(RemoteError::Cancelled)),
                Err(_) => {}
            }
        }
    })
}
