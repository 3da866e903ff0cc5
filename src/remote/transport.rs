//! One request: a range of bytes from a file, a web server, or a bucket.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::pin::pin;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use object_store::aws::AmazonS3Builder;
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{
    ClientConfigKey, ClientOptions, GetOptions, GetRange, HeaderMap, HeaderValue, ObjectStore, RetryConfig,
};
use tokio::runtime::Runtime;

use super::address::{Address, Place, base64};
use super::{Cancelled, RemoteError, Settings};

/// How often a request looks whether it is still wanted.
const LOOK: Duration = Duration::from_millis(20);

/// What answers.
pub enum Transport {
    /// A file on this machine.
    File(File),
    /// A server.
    Store { store: Arc<dyn ObjectStore>, path: Path, timeout: Duration },
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
pub enum NoAnswer {
    /// It may be better next time.
    Again(String),
    /// It will not.
    Never(RemoteError),
}

impl Transport {
    pub fn open(address: &Address, settings: &Settings) -> Result<Self, RemoteError> {
        let bad = |error: &dyn std::error::Error| RemoteError::BadAddress {
            name: address.name.clone(),
            cause: address.told(&error.to_string()),
        };
        // Trying again is our own business: it must stop when the bytes are no longer wanted.
        let once = RetryConfig { max_retries: 0, ..RetryConfig::default() };
        let seconds = |time: Duration| format!("{}ms", time.as_millis());
        let timeout = settings.request_timeout;
        match &address.place {
            Place::File(path) => match File::open(path) {
                Ok(file) => Ok(Self::File(file)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    Err(RemoteError::NotFound { name: address.name.clone() })
                }
                Err(source) => Err(RemoteError::Io { name: address.name.clone(), source }),
            },
            Place::Http { url, login } => {
                let mut options = ClientOptions::new()
                    // Who asks over HTTPS is not sent on to plain HTTP. Other schemes are followed from neither.
                    .with_allow_http(url.starts_with("http://"))
                    .with_connect_timeout(settings.connect_timeout)
                    .with_timeout(timeout);
                if let Some(login) = login {
                    let mut headers = HeaderMap::new();
                    let value = format!("Basic {}", base64(login.as_bytes()));
                    let mut value = HeaderValue::from_str(&value).map_err(|error| bad(&error))?;
                    value.set_sensitive(true);
                    headers.insert("authorization", value);
                    options = options.with_default_headers(headers);
                }
                let store = HttpBuilder::new().with_url(url).with_client_options(options).with_retry(once);
                let store = Arc::new(store.build().map_err(|error| bad(&error))?);
                Ok(Self::Store { store, path: Path::default(), timeout })
            }
            Place::S3 { bucket, key } => {
                let mut builder = AmazonS3Builder::new();
                for (key, value) in &settings.s3 {
                    // Most variables that begin so are for others.
                    if let Ok(key) = key.to_ascii_lowercase().parse() {
                        builder = builder.with_config(key, value);
                    }
                }
                let knows = |name: &str| settings.s3.iter().any(|(key, value)| key == name && !value.is_empty());
                let has_credentials = [
                    "AWS_ACCESS_KEY_ID",
                    "AWS_WEB_IDENTITY_TOKEN_FILE",
                    "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
                    "AWS_CONTAINER_CREDENTIALS_FULL_URI",
                ];
                if !has_credentials.into_iter().any(knows) && !knows("AWS_SKIP_SIGNATURE") {
                    builder = builder.with_skip_signature(true);
                }
                let timeouts = [
                    (ClientConfigKey::ConnectTimeout, seconds(settings.connect_timeout)),
                    (ClientConfigKey::Timeout, seconds(timeout)),
                ];
                for (key, value) in timeouts {
                    builder = builder.with_config(object_store::aws::AmazonS3ConfigKey::Client(key), value);
                }
                let store = builder.with_bucket_name(bucket).with_retry(once).build();
                let store = Arc::new(store.map_err(|error| bad(&error))?);
                let path = Path::parse(key).map_err(|error| bad(&error))?;
                Ok(Self::Store { store, path, timeout })
            }
        }
    }

    /// Whether the bytes come from another machine.
    pub fn is_remote(&self) -> bool {
        matches!(self, Self::Store { .. })
    }

    /// The bytes of `range`, which is not empty; fewer where the file ends before.
    pub fn get(&self, range: Range<u64>, address: &Address, cancelled: Cancelled<'_>) -> Result<Answer, NoAnswer> {
        match self {
            Self::File(file) => read(file, range)
                .map_err(|source| NoAnswer::Never(RemoteError::Io { name: address.name.clone(), source })),
            Self::Store { store, path, timeout } => {
                let runtime = runtime().map_err(|cause| {
                    NoAnswer::Never(RemoteError::Unusable { name: address.name.clone(), cause: cause.to_owned() })
                })?;
                let request = request(store.as_ref(), path, range, address);
                runtime.block_on(patiently(request, *timeout, cancelled))
            }
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

async fn patiently(
    request: impl Future<Output = Result<Answer, NoAnswer>>,
    timeout: Duration,
    cancelled: Cancelled<'_>,
) -> Result<Answer, NoAnswer> {
    let mut request = pin!(request);
    let end = Instant::now() + timeout;
    loop {
        match tokio::time::timeout(LOOK, request.as_mut()).await {
            Ok(answer) => return answer,
            Err(_) if cancelled() => return Err(NoAnswer::Never(RemoteError::Cancelled)),
            Err(_) if Instant::now() > end => {
                return Err(NoAnswer::Again(format!("no whole answer within {} s", timeout.as_secs_f32())));
            }
            Err(_) => {}
        }
    }
}

async fn request(
    store: &dyn ObjectStore,
    path: &Path,
    range: Range<u64>,
    address: &Address,
) -> Result<Answer, NoAnswer> {
    let failed = |error| why(error, address);
    let options = GetOptions { range: Some(GetRange::Bounded(range.clone())), ..GetOptions::default() };
    let result = store.get_opts(path, options).await.map_err(failed)?;
    let size = result.meta.size;
    let changed = result.meta.last_modified.timestamp_millis();
    // A server that does not tell the time gets the first second there was.
    let version = (result.meta.e_tag.is_some() || changed > 0)
        .then(|| format!("{} {changed}", result.meta.e_tag.as_deref().unwrap_or_default()));
    let expected = range.end.min(size).saturating_sub(range.start);
    let bytes = result.bytes().await.map_err(failed)?;
    if bytes.len() as u64 != expected {
        return Err(NoAnswer::Again(format!("{} of {expected} bytes came", bytes.len())));
    }
    Ok(Answer { bytes: bytes.to_vec(), size, version })
}

/// Sorts the causes: what may pass, and what will not.
fn why(error: object_store::Error, address: &Address) -> NoAnswer {
    use object_store::Error;
    let name = address.name.clone();
    let said = address.told(&error.to_string());
    let causes = std::iter::successors(Some(&error as &dyn std::error::Error), |error| error.source());
    let refuses_scheme = causes.into_iter().any(|error| error.to_string().contains("scheme is not allowed"));
    NoAnswer::Never(match error {
        Error::NotFound { .. } => RemoteError::NotFound { name },
        Error::PermissionDenied { .. } => RemoteError::Denied { name, cause: "403".into() },
        Error::Unauthenticated { .. } => RemoteError::Denied { name, cause: "401".into() },
        // A redirect that the library refuses, or hands over because it cannot read where it leads.
        Error::Generic { .. } if refuses_scheme || matches!(status(&said), Some(300..400)) => {
            let cause = "the server sends us on to an address that is not read".into();
            RemoteError::Unusable { name, cause }
        }
        Error::Generic { .. } if said.contains("non-partial response") => {
            let cause = "the server does not answer requests for a part of a file".into();
            RemoteError::Unusable { name, cause }
        }
        Error::Generic { .. } => match status(&said) {
            Some(416) => RemoteError::Unusable { name, cause: "is empty, or shorter than it was".into() },
            Some(status @ 400..500) if !matches!(status, 408 | 425 | 429) => {
                RemoteError::Unusable { name, cause: format!("the server answers {status}") }
            }
            Some(status) => return NoAnswer::Again(format!("the server answers {status}")),
            None => return NoAnswer::Again(said),
        },
        _ => RemoteError::Unusable { name, cause: said },
    })
}

/// The status in the words of the library, which keeps it to itself.
fn status(said: &str) -> Option<u32> {
    let (_, rest) = said.split_once("status code: ")?;
    rest.get(..3)?.parse().ok()
}
