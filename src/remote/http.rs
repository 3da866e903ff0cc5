//! Reads a range of a file from a web server, with a deadline for each step and a check of everything in the answer.
//!
//! The underlying library follows redirects and handles TLS. This module decides which incorrect answers are tolerated:
//! a length is not required, since the range implies it, and a modification time may be any text; but the range must be
//! the requested one, and exactly its bytes must arrive.

use std::ops::Range;
use std::time::{Duration, Instant};

use reqwest::header::{self, HeaderMap, HeaderName, HeaderValue};
use reqwest::{Method, Request, Response, StatusCode, Url, redirect};

use super::transport::{Answer, NoAnswer};
use super::url::{RemoteUrl, base64};
use super::{RemoteError, Settings};

/// Largest number of redirects; more count as a circle.
const MAX_REDIRECTS: usize = 10;
/// Largest plausible size of a file: a pebibyte.
const MAX_BYTES: u64 = 1 << 50;
/// Largest answer, in bytes, that is not a range of a file: the credentials of a bucket, for example.
const MAX_OTHER_BYTES: u64 = 1 << 20;

/// Connections to the server of one file.
#[derive(Debug)]
pub(super) struct Client {
    http: reqwest::Client,
    url: RemoteUrl,
    connect: Duration,
    idle: Duration,
    whole: Duration,
}

/// The status, headers and complete body of an answer.
pub(super) struct Whole {
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub bytes: Vec<u8>,
}

impl Client {
    /// Creates a client for one file. If `keeps_host`, redirects to another server are refused: requests to buckets
    /// have headers with credentials of their own, of which the library does not know that they are secret.
    pub(super) fn new(url: &RemoteUrl, settings: &Settings, keeps_host: bool) -> Result<Self, RemoteError> {
        // Installs the TLS provider of the whole process. If the host program has installed another one, that is fine
        // too.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let http = reqwest::Client::builder()
            .user_agent(concat!("hachure/", env!("CARGO_PKG_VERSION")))
            .connect_timeout(settings.connect_timeout)
            .redirect(redirect::Policy::custom(move |attempt| follow(attempt, keeps_host)))
            // The first address may contain a key in its query, which is none of the business of the next server.
            .referer(false)
            .http1_only()
            .build();
        let http = http.map_err(|error| RemoteError::Unusable {
            name: url.name.clone(),
            cause: format!("connections cannot be set up: {}", deepest(&error)),
        })?;
        let (connect, idle, whole) = (settings.connect_timeout, settings.idle_timeout, settings.request_timeout);
        Ok(Self { http, url: url.clone(), connect, idle, whole })
    }

    /// Builds a request for a file.
    pub(super) fn request(&self, url: &str, login: Option<&str>) -> Result<Request, RemoteError> {
        let bad =
            |cause: String| RemoteError::BadUrl { name: self.url.name.clone(), cause: self.url.printable(&cause) };
        let mut request = Request::new(Method::GET, Url::parse(url).map_err(|error| bad(error.to_string()))?);
        if let Some(login) = login {
            let value = format!("Basic {}", base64(login.as_bytes()));
            let mut value = HeaderValue::from_str(&value).map_err(|error| bad(error.to_string()))?;
            value.set_sensitive(true);
            request.headers_mut().insert(header::AUTHORIZATION, value);
        }
        Ok(request)
    }

    /// Requests the bytes of `range`, which must not be empty; returns fewer where the file ends before.
    pub(super) async fn range(&self, mut request: Request, range: Range<u64>) -> Result<Answer, NoAnswer> {
        let asked = HeaderValue::from_str(&format!("bytes={}-{}", range.start, range.end - 1));
        let asked = asked.map_err(|error| self.unusable(error.to_string()))?;
        request.headers_mut().insert(header::RANGE, asked);
        // Ranges of compressed bytes cannot be used.
        request.headers_mut().entry(header::ACCEPT_ENCODING).or_insert(HeaderValue::from_static("identity"));
        let end = Instant::now() + self.whole;
        let mut response = self.head(request, end).await?;
        let (sent, size) = self.sent(&response, &range)?;
        let length = sent.end - sent.start;
        let headers = response.headers().clone();
        let bytes = self.body(&mut response, length, end).await?;
        if (bytes.len() as u64) < length {
            return Err(NoAnswer::Again(format!("only {} of {length} bytes came", bytes.len())));
        }
        let is_packed = headers.contains_key(header::CONTENT_ENCODING)
            && range.start == 0
            && [&[0x1f, 0x8b][..], &[0x28, 0xb5, 0x2f, 0xfd]].iter().any(|magic| bytes.starts_with(magic));
        if is_packed {
            return Err(
                self.unusable("the server sends the file compressed, so that parts of it cannot be read".into())
            );
        }
        // The modification time is for servers without ETag; it may be any text.
        let version = text(&headers, header::ETAG).or_else(|| text(&headers, header::LAST_MODIFIED));
        Ok(Answer { bytes, size, version })
    }

    /// Returns the complete answer to a request that is not for a range of a file.
    pub(super) async fn whole(&self, request: Request) -> Result<Whole, NoAnswer> {
        let end = Instant::now() + self.whole;
        let mut response = self.head(request, end).await?;
        let (status, headers) = (response.status(), response.headers().clone());
        let bytes = self.body(&mut response, MAX_OTHER_BYTES, end).await?;
        Ok(Whole { status, headers, bytes })
    }

    async fn head(&self, request: Request, end: Instant) -> Result<Response, NoAnswer> {
        let response = self.in_time(end, String::new, self.http.execute(request)).await?;
        response.map_err(|error| self.why(&error))
    }

    /// Reads the body, at most `most` bytes.
    async fn body(&self, response: &mut Response, most: u64, end: Instant) -> Result<Vec<u8>, NoAnswer> {
        let mut bytes = Vec::new();
        loop {
            let came = bytes.len();
            let so_far = || format!(" after {came} bytes");
            let Some(chunk) = self.in_time(end, so_far, response.chunk()).await?.map_err(|error| self.why(&error))?
            else {
                return Ok(bytes);
            };
            bytes.extend_from_slice(&chunk);
            if bytes.len() as u64 > most {
                return Err(NoAnswer::Again(format!("more than the expected {most} bytes came")));
            }
        }
    }

    /// Waits for the next part of the answer, within the deadlines.
    async fn in_time<T>(
        &self,
        end: Instant,
        so_far: impl Fn() -> String,
        next: impl Future<Output = T>,
    ) -> Result<T, NoAnswer> {
        let left = end.saturating_duration_since(Instant::now());
        let (most, deadline) = if left < self.idle { (left, self.whole) } else { (self.idle, self.idle) };
        tokio::time::timeout(most, next).await.map_err(|_| {
            let seconds = deadline.as_secs_f32();
            NoAnswer::Again(match deadline == self.whole {
                true => format!("no complete answer within {seconds} s{}", so_far().replace(" after ", ", only ")),
                false => format!("no data for {seconds} s{}", so_far()),
            })
        })
    }

    /// Returns the range that the head of an answer announces, and the size of the whole file.
    fn sent(&self, response: &Response, asked: &Range<u64>) -> Result<(Range<u64>, u64), NoAnswer> {
        let status = response.status();
        if status != StatusCode::PARTIAL_CONTENT {
            return Err(self.refused(status, response.headers()));
        }
        let Some(range) = text(response.headers(), header::CONTENT_RANGE) else {
            return Err(self.unusable("the server does not say which part of the file it sends".into()));
        };
        let Some((sent, size)) = content_range(&range) else {
            let range = range.chars().take(40).collect::<String>();
            return Err(self.unusable(format!("the server sends a part with the invalid Content-Range {range:?}")));
        };
        let expected = asked.start..asked.end.min(size);
        if sent != expected {
            let [first, last] = [sent.start, sent.end - 1];
            let cause =
                format!("the server sends bytes {first} to {last} instead of {} to {}", asked.start, asked.end - 1);
            return Err(NoAnswer::Again(cause));
        }
        Ok((sent, size))
    }

    /// Converts a status other than 206 (partial content) to an error.
    fn refused(&self, status: StatusCode, headers: &HeaderMap) -> NoAnswer {
        let name = self.url.name.clone();
        let number = status.as_u16();
        let answered = format!("the server answers {number}");
        NoAnswer::Never(match number {
            404 | 410 => RemoteError::NotFound { name },
            401 | 403 => RemoteError::Denied { name, cause: number.to_string() },
            416 => RemoteError::Unusable { name, cause: "is empty, or shorter than it was".into() },
            200 => {
                let cause =
                    "the server does not support range requests (for parts of a file); download the file first".into();
                RemoteError::Unusable { name, cause }
            }
            300..=399 => {
                // The redirects that remain here have no location, or one that is not the URL of a web server.
                let cause = match text(headers, header::LOCATION) {
                    Some(place) => not_followed(place.split(['?', '#']).next().unwrap_or_default()),
                    None if number == 304 => answered,
                    None => format!("{answered} without a Location header"),
                };
                return self.unusable(cause);
            }
            408 | 425 | 429 | 500.. => {
                let seconds = text(headers, header::RETRY_AFTER).and_then(|text| text.trim().parse::<u32>().ok());
                return match seconds {
                    Some(seconds @ 1..) => NoAnswer::AfterPause(answered, Duration::from_secs(seconds.into())),
                    _ => NoAnswer::Again(answered),
                };
            }
            _ => RemoteError::Unusable { name, cause: answered },
        })
    }

    fn unusable(&self, cause: String) -> NoAnswer {
        NoAnswer::Never(RemoteError::Unusable { name: self.url.name.clone(), cause: self.url.printable(&cause) })
    }

    /// Converts an error of the library.
    fn why(&self, error: &reqwest::Error) -> NoAnswer {
        let said = self.url.printable(&deepest(error));
        if error.is_redirect() {
            return self.unusable(said);
        }
        NoAnswer::Again(match (error.is_connect(), error.is_timeout()) {
            (true, true) => format!("no connection within {} s", self.connect.as_secs_f32()),
            (true, false) => format!("no connection: {said}"),
            (false, _) => said,
        })
    }
}

/// Decides whether to follow a redirect: only to a web server, not in a circle, and never from an encrypted connection
/// to an unencrypted one; if `keeps_host`, only to the same server.
fn follow(attempt: redirect::Attempt<'_>, keeps_host: bool) -> redirect::Action {
    let next = attempt.url();
    let place = format!("{}://{}{}", next.scheme(), next.host_str().unwrap_or_default(), next.path());
    let is_secret = attempt.previous().last().is_some_and(|url| url.scheme() == "https");
    let allowed = if is_secret { &["https"][..] } else { &["https", "http"] };
    let is_elsewhere = attempt.previous().last().is_some_and(|url| url.origin() != next.origin());
    let refused = if !allowed.contains(&next.scheme()) || (keeps_host && is_elsewhere) {
        Some(not_followed(&place))
    } else if attempt.previous().contains(next) || attempt.previous().len() > MAX_REDIRECTS {
        Some("the server redirects in a circle".to_owned())
    } else {
        None
    };
    match refused {
        Some(cause) => attempt.error(cause),
        None => attempt.follow(),
    }
}

fn not_followed(place: &str) -> String {
    format!("the server redirects to {place}, which is not followed")
}

/// Parses `bytes 0-99/1234`: the range and the size of the whole file.
fn content_range(text: &str) -> Option<(Range<u64>, u64)> {
    let (unit, rest) = text.trim().split_once(' ')?;
    let (range, size) = rest.trim().split_once('/')?;
    let (first, last) = range.split_once('-')?;
    let number = |text: &str| text.trim().parse::<u64>().ok().filter(|&number| number <= MAX_BYTES);
    let (first, last, size) = (number(first)?, number(last)?, number(size)?);
    (unit.eq_ignore_ascii_case("bytes") && first <= last && last < size).then_some((first..last + 1, size))
}

fn text(headers: &HeaderMap, name: HeaderName) -> Option<String> {
    headers.get(name).map(|value| String::from_utf8_lossy(value.as_bytes()).into_owned())
}

/// Returns the innermost cause; the outer ones only name the library that failed.
fn deepest(error: &dyn std::error::Error) -> String {
    let mut cause = error;
    while let Some(inner) = cause.source() {
        cause = inner;
    }
    cause.to_string()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn content_ranges_are_parsed() {
        assert_eq!(content_range("bytes 0-99/1234"), Some((0..100, 1234)));
        assert_eq!(content_range("Bytes 5-5/6 "), Some((5..6, 6)));
        for bad in [
            "bytes */1234",
            "bytes 0-99/*",
            "bytes 9-3/20",
            "bytes 0-99/50",
            "bytes 0-18446744073709551615/18446744073709551615",
            "lines 0-99/1234",
            "0-99/1234",
            "",
        ] {
            assert_eq!(content_range(bad), None, "{bad}");
        }
    }

    /// Answers one request with `answer`, and returns its head.
    fn server(answer: impl FnOnce() -> String + Send + 'static) -> (String, std::thread::JoinHandle<String>) {
        use std::io::{Read, Write};
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let serve = move || {
            let (mut stream, _) = listener.accept().unwrap();
            let mut head = String::new();
            while !head.ends_with("\r\n\r\n") {
                let mut byte = [0];
                stream.read_exact(&mut byte).unwrap();
                head.push(char::from(byte[0]));
            }
            stream.write_all(answer().as_bytes()).unwrap();
            head.to_ascii_lowercase()
        };
        (address, std::thread::spawn(serve))
    }

    #[test]
    fn another_server_learns_neither_the_key_nor_where_it_was_sent() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let part = "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes 0-0/1\r\nContent-Length: 1\r\n\r\nx";
        // Asks through a redirect, and returns the head that the second server got.
        let told = |client: &dyn Fn(&RemoteUrl) -> Client| {
            let (second, other) = server(|| part.to_owned());
            let place = format!("http://{second}/b.tif");
            let moved = format!("HTTP/1.1 302 Found\r\nLocation: {place}\r\nContent-Length: 0\r\n\r\n");
            let (first, _) = server(move || moved);
            let url = format!("http://{first}/a.tif?token=s3cret");
            let client = client(&RemoteUrl::parse(&url).unwrap());
            let request = client.request(&url, Some("me:word")).unwrap();
            match runtime.block_on(client.range(request, 0..1)) {
                Ok(_) => other.join().unwrap(),
                Err(NoAnswer::Never(error)) => error.to_string(),
                Err(_) => panic!("no answer"),
            }
        };
        let settings = Settings::default();
        let head = told(&|url| Client::new(url, &settings, false).unwrap());
        assert!(head.starts_with("get /b.tif") && head.contains("range: bytes=0-0"), "{head}");
        let leaks = |head: &str| ["referer", "s3cret", "authorization", "a.tif"].iter().any(|word| head.contains(word));
        assert!(!leaks(&head), "{head}");
        // Planted: the library's default reveals the whole first address.
        let careless = told(&|url| {
            let client = Client::new(url, &settings, false).unwrap();
            Client { http: reqwest::Client::new(), ..client }
        });
        assert!(leaks(&careless), "{careless}");
        // A signed request, whose headers have credentials, stays on its server.
        let refused = told(&|url| Client::new(url, &settings, true).unwrap());
        assert!(refused.contains("redirects to") && refused.contains("not followed"), "{refused}");
    }
}
