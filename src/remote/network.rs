//! Sends one request over the network: to a web server or to a bucket.

use std::ops::Range;
use std::pin::pin;
use std::sync::OnceLock;
use std::time::Duration;

use tokio::runtime::Runtime;

use super::bucket::Object;
use super::http::Client;
use super::transport::{Answer, NoAnswer};
use super::url::{Location, RemoteUrl};
use super::{Cancelled, RemoteError, Settings};

/// Interval at which a request checks whether it was cancelled.
const LOOK: Duration = Duration::from_millis(20);

/// The server of a remote file.
pub(super) enum Server {
    Http { client: Client, request: Box<reqwest::Request> },
    Bucket(Object),
}

impl Server {
    pub(super) fn open(url: &RemoteUrl, settings: &Settings) -> Result<Self, RemoteError> {
        match &url.location {
            Location::S3 { bucket, key } => Object::new(url, bucket, key, settings).map(Self::Bucket),
            Location::Http { url: text, login } => {
                let client = Client::new(url, settings, false)?;
                let request = Box::new(client.request(text, login.as_deref())?);
                Ok(Self::Http { client, request })
            }
            Location::File(_) => {
                let (name, cause) = (url.name.clone(), "is a local file".to_owned());
                Err(RemoteError::BadUrl { name, cause })
            }
        }
    }

    /// Requests the bytes of `range`, which must not be empty; returns fewer where the file ends before.
    pub(super) fn get(&self, range: Range<u64>, url: &RemoteUrl, cancelled: Cancelled<'_>) -> Result<Answer, NoAnswer> {
        match self {
            Self::Http { client, request } => {
                // A request without a body can always be cloned.
                let request =
                    request.try_clone().ok_or_else(|| NoAnswer::Again("the request could not be created".into()))?;
                wait_for(client.range(request, range), url, cancelled)
            }
            Self::Bucket(object) => wait_for(object.range(range, url), url, cancelled),
        }
    }
}

/// Returns the runtime of the network threads: two for the whole program, started by the first request.
fn runtime() -> Result<&'static Runtime, &'static str> {
    static RUNTIME: OnceLock<Result<Runtime, String>> = OnceLock::new();
    let build = || {
        let mut runtime = tokio::runtime::Builder::new_multi_thread();
        runtime
            .worker_threads(2)
            .thread_name("remote")
            .enable_all()
            .build()
            .map_err(|error| format!("the network threads cannot be started: {error}"))
    };
    RUNTIME.get_or_init(build).as_ref().map_err(String::as_str)
}

/// Waits for an answer, which has its own deadlines, and checks now and then whether it was cancelled.
fn wait_for(
    request: impl Future<Output = Result<Answer, NoAnswer>>,
    url: &RemoteUrl,
    cancelled: Cancelled<'_>,
) -> Result<Answer, NoAnswer> {
    let runtime = runtime()
        .map_err(|cause| NoAnswer::Never(RemoteError::Unusable { name: url.name.clone(), cause: cause.to_owned() }))?;
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
