//! Files in S3 buckets: `object_store` builds the URL and signs the request, and [`Client`] talks to the server, so
//! that the same deadlines and checks apply as for any other server.

use std::ops::Range;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};

use object_store::aws::{AmazonS3, AmazonS3Builder};
use object_store::client::{
    HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpResponse, HttpResponseBody, HttpService,
};
use object_store::path::Path;
use object_store::{ClientOptions, GetOptions, GetRange, HeaderMap, HeaderValue, ObjectStore, RetryConfig};
use reqwest::{Request, StatusCode, Url, header};

use super::http::Client;
use super::transport::{Answer, NoAnswer};
use super::url::RemoteUrl;
use super::{RemoteError, Settings};

/// Environment variables that provide credentials.
const CREDENTIALS: [&str; 4] = [
    "AWS_ACCESS_KEY_ID",
    "AWS_WEB_IDENTITY_TOKEN_FILE",
    "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
    "AWS_CONTAINER_CREDENTIALS_FULL_URI",
];

/// A file in a bucket.
pub(super) struct Object {
    store: AmazonS3,
    path: Path,
}

impl Object {
    pub(super) fn new(url: &RemoteUrl, bucket: &str, key: &str, settings: &Settings) -> Result<Self, RemoteError> {
        let bad = |error: &dyn std::error::Error| RemoteError::BadUrl {
            name: url.name.clone(),
            cause: url.printable(&error.to_string()),
        };
        let mut builder = AmazonS3Builder::new();
        for (key, value) in &settings.s3 {
            // Most variables with this prefix are for other programs.
            if let Ok(key) = key.to_ascii_lowercase().parse() {
                builder = builder.with_config(key, value);
            }
        }
        let knows = |name: &str| settings.s3.iter().any(|(key, value)| key == name && !value.is_empty());
        let is_signed = CREDENTIALS.into_iter().any(knows) && !knows("AWS_SKIP_SIGNATURE");
        if !CREDENTIALS.into_iter().any(knows) && !knows("AWS_SKIP_SIGNATURE") {
            builder = builder.with_skip_signature(true);
        }
        // Retries are up to the caller: they must stop when the bytes are no longer needed.
        let once = RetryConfig { max_retries: 0, ..RetryConfig::default() };
        let connector = Connector(Arc::new(Client::new(url, settings, is_signed)?));
        let store = builder.with_bucket_name(bucket).with_retry(once).with_http_connector(connector).build();
        let path = Path::parse(key).map_err(|error| bad(&error))?;
        Ok(Self { store: store.map_err(|error| bad(&error))?, path })
    }

    pub(super) async fn range(&self, range: Range<u64>, url: &RemoteUrl) -> Result<Answer, NoAnswer> {
        let failed = |error: object_store::Error| {
            fault(&error).unwrap_or_else(|| {
                let cause = url.printable(&error.to_string());
                NoAnswer::Never(RemoteError::Unusable { name: url.name.clone(), cause })
            })
        };
        let options = GetOptions { range: Some(GetRange::Bounded(range)), ..GetOptions::default() };
        let result = self.store.get_opts(&self.path, options).await.map_err(failed)?;
        let (size, version) = (result.meta.size, result.meta.e_tag.clone());
        let bytes = result.bytes().await.map_err(failed)?.to_vec();
        Ok(Answer { bytes, size, version })
    }
}

/// A failed request, as it passes through the library's error type.
#[derive(Debug, thiserror::Error)]
#[error("the request failed")]
struct Fault(Mutex<Option<NoAnswer>>);

fn fault(error: &object_store::Error) -> Option<NoAnswer> {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(error) = cause {
        if let Some(Fault(no_answer)) = error.downcast_ref() {
            return no_answer.lock().unwrap_or_else(PoisonError::into_inner).take();
        }
        cause = error.source();
    }
    None
}

/// Makes the library use hachure's own client.
#[derive(Clone, Debug)]
struct Connector(Arc<Client>);

impl HttpConnector for Connector {
    fn connect(&self, _options: &ClientOptions) -> object_store::Result<HttpClient> {
        Ok(HttpClient::new(self.clone()))
    }
}

impl HttpService for Connector {
    fn call<'life0, 'async_trait>(
        &'life0 self,
        request: HttpRequest,
    ) -> Pin<Box<dyn Future<Output = Result<HttpResponse, HttpError>> + Send + 'async_trait>>
    where
        'life0: 'async_trait,
        Self: 'async_trait,
    {
        Box::pin(async move {
            let failed = |no_answer| HttpError::new(HttpErrorKind::Unknown, Fault(Mutex::new(Some(no_answer))));
            self.answer(request).await.map_err(failed)
        })
    }
}

impl Connector {
    async fn answer(&self, request: HttpRequest) -> Result<HttpResponse, NoAnswer> {
        let (parts, body) = request.into_parts();
        let url = Url::parse(&parts.uri.to_string()).map_err(|error| NoAnswer::Again(error.to_string()))?;
        let mut request = Request::new(parts.method, url);
        *request.headers_mut() = parts.headers;
        if let Some(bytes) = body.as_bytes().filter(|bytes| !bytes.is_empty()) {
            *request.body_mut() = Some(bytes.clone().into());
        }
        let Some(range) = range_of(request.headers()) else {
            let whole = self.0.whole(request).await?;
            let mut response = HttpResponse::new(HttpResponseBody::from(whole.bytes));
            *response.status_mut() = whole.status;
            *response.headers_mut() = whole.headers;
            return Ok(response);
        };
        let start = range.start;
        let Answer { bytes, size, version } = self.0.range(request, range).await?;
        // The library checks these headers, and gets the values that were verified.
        let mut headers = HeaderMap::new();
        let last = start + bytes.len() as u64 - 1;
        headers.insert(header::CONTENT_LENGTH, HeaderValue::from(bytes.len()));
        let sent = [(header::CONTENT_RANGE, Some(format!("bytes {start}-{last}/{size}"))), (header::ETAG, version)];
        for (name, text) in sent {
            if let Some(value) = text.and_then(|text| HeaderValue::from_str(&text).ok()) {
                headers.insert(name, value);
            }
        }
        let mut response = HttpResponse::new(HttpResponseBody::from(bytes));
        *response.status_mut() = StatusCode::PARTIAL_CONTENT;
        *response.headers_mut() = headers;
        Ok(response)
    }
}

fn range_of(headers: &HeaderMap) -> Option<Range<u64>> {
    let (first, last) = headers.get(header::RANGE)?.to_str().ok()?.strip_prefix("bytes=")?.split_once('-')?;
    Some(first.parse().ok()?..last.parse::<u64>().ok()?.checked_add(1)?)
}
