//! One request over the network: to a web server, or to a bucket.

use std::ops::Range;
use std::pin::pin;
use std::sync::OnceLock;
use std::time::Duration;

use tokio::runtime::Runtime;

use super::address::{Address, Location};
use super::bucket::Object;
use super::http::Client;
use super::transport::{Answer, NoAnswer};
use super::{Cancelled, RemoteError, Settings};

/// How often a request looks whether it is still wanted.
const LOOK: Duration = Duration::from_millis(20);

/// What answers on another machine.
pub enum Server {
    /// A web server.
    Http { client: Client, request: Box<reqwest::Request> },
    /// A bucket.
    Bucket(Object),
}

impl Server {
    pub fn open(address: &Address, settings: &Settings) -> Result<Self, RemoteError> {
        match &address.location {
            Location::S3 { bucket, key } => Object::new(address, bucket, key, settings).map(Self::Bucket),
            Location::Http { url, login } => {
                let client = Client::new(address, settings)?;
                let request = Box::new(client.request(url, login.as_deref())?);
                Ok(Self::Http { client, request })
            }
            Location::File(_) => {
                let (name, cause) = (address.name.clone(), "is a file of this machine".to_owned());
                Err(RemoteError::BadAddress { name, cause })
            }
        }
    }

    /// The bytes of `range`, which is not empty; fewer where the file ends before.
    pub fn get(&self, range: Range<u64>, address: &Address, cancelled: Cancelled<'_>) -> Result<Answer, NoAnswer> {
        match self {
            Self::Http { client, request } => {
                // A request without a body can be made again.
                let request = request.try_clone().ok_or_else(|| NoAnswer::Again("no request was made".into()))?;
                wait_for(client.range(request, range), address, cancelled)
            }
            Self::Bucket(object) => wait_for(object.range(range, address), address, cancelled),
        }
    }
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
