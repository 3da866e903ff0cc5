//! A web server for tests that is as unreliable as a network: it drops connections, delays, truncates and refuses
//! answers, and changes bytes. HTTP/1.1 on the loopback in plain `std`, one thread per connection.
//!
//! It serves files from memory, whole or in ranges, with ETag, on GET and HEAD. An S3 bucket with path-style addresses
//! and without signatures behaves the same.
#![allow(dead_code, reason = "each test uses only some of this")]

use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

/// The fractions of answers with each fault, from 0 to 1.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rates {
    /// The connection closes before the first byte.
    pub drop: f64,
    /// The answer is up to 100 ms late; one in ten is late by [`Faults::hang`].
    pub delay: f64,
    /// The body ends early; in half of the cases `Content-Length` is that of the short body.
    pub truncate: f64,
    /// The status is 500, 503 or 429.
    pub refuse: f64,
    /// One to three bytes of the body are changed.
    pub flip: f64,
}

impl Rates {
    pub(crate) fn all(rate: f64) -> Self {
        Self { drop: rate, delay: rate, truncate: rate, refuse: rate, flip: rate }
    }
}

/// The faults of a server.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Faults {
    pub rates: Rates,
    /// The delay of an answer that hangs; longer than the reader waits.
    pub hang: Duration,
}

/// How often each fault occurred.
#[derive(Default)]
pub(crate) struct Counts {
    pub answers: AtomicU64,
    pub dropped: AtomicU64,
    pub delayed: AtomicU64,
    pub truncated: AtomicU64,
    pub refused: AtomicU64,
    pub flipped: AtomicU64,
}

struct Entry {
    bytes: Arc<Vec<u8>>,
    etag: String,
}

struct Shared {
    files: Mutex<HashMap<String, Entry>>,
    faults: Mutex<Faults>,
    chance: Mutex<u64>,
    counts: Counts,
    stopping: AtomicBool,
    connections: Mutex<Vec<JoinHandle<()>>>,
}

/// A server that runs until it is dropped; dropping waits for all of its threads.
pub(crate) struct Server {
    address: SocketAddr,
    shared: Arc<Shared>,
    listener: Option<JoinHandle<()>>,
}

impl Server {
    pub(crate) fn start(seed: u64) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let shared = Arc::new(Shared {
            files: Mutex::default(),
            faults: Mutex::default(),
            chance: Mutex::new(seed),
            counts: Counts::default(),
            stopping: AtomicBool::new(false),
            connections: Mutex::default(),
        });
        let ours = shared.clone();
        let listener = std::thread::spawn(move || {
            for stream in listener.incoming() {
                if ours.stopping.load(Ordering::Relaxed) {
                    return;
                }
                let Ok(stream) = stream else { continue };
                let theirs = ours.clone();
                let connection = std::thread::spawn(move || {
                    // Failing connections are the purpose of this server.
                    let _ = serve(stream, &theirs);
                });
                let mut connections = ours.connections.lock().unwrap();
                connections.retain(|connection| !connection.is_finished());
                connections.push(connection);
            }
        });
        Self { address, shared, listener: Some(listener) }
    }

    /// Serves a file at `/path`.
    pub(crate) fn put(&self, path: &str, bytes: Vec<u8>) {
        let hash = bytes.iter().fold(7_u64, |hash, byte| hash.wrapping_mul(31).wrapping_add(u64::from(*byte)));
        let entry = Entry { bytes: Arc::new(bytes), etag: format!("\"{hash:x}\"") };
        self.shared.files.lock().unwrap().insert(format!("/{path}"), entry);
    }

    /// Redirects requests for `/path` to `location`.
    pub(crate) fn redirect(&self, path: &str, location: &str) {
        let entry = Entry { bytes: Arc::new(location.as_bytes().to_vec()), etag: String::new() };
        self.shared.files.lock().unwrap().insert(format!("/{path}"), entry);
    }

    pub(crate) fn url(&self, path: &str) -> String {
        format!("http://{}/{path}", self.address)
    }

    pub(crate) fn set_faults(&self, faults: Faults) {
        *self.shared.faults.lock().unwrap() = faults;
    }

    pub(crate) fn counts(&self) -> &Counts {
        &self.shared.counts
    }

    /// Describes in one line how often each fault occurred.
    pub(crate) fn summary(&self) -> String {
        let counts = self.counts();
        let answers = counts.answers.load(Ordering::Relaxed);
        let mut line = format!("{answers} answers");
        for (what, count) in [
            ("dropped", &counts.dropped),
            ("delayed", &counts.delayed),
            ("truncated", &counts.truncated),
            ("refused", &counts.refused),
            ("flipped", &counts.flipped),
        ] {
            let count = count.load(Ordering::Relaxed);
            write!(line, ", {what} {count} ({:.2} %)", 100.0 * count as f64 / answers.max(1) as f64).unwrap();
        }
        line
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.stopping.store(true, Ordering::Relaxed);
        // Wakes the listener.
        let _ = TcpStream::connect(self.address);
        if let Some(listener) = self.listener.take() {
            let _ = listener.join();
        }
        for connection in self.shared.connections.lock().unwrap().drain(..) {
            let _ = connection.join();
        }
    }
}

/// Advances a xorshift64* generator and returns its next number.
pub(crate) fn next(state: &mut u64) -> u64 {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    state.wrapping_mul(0x2545_F491_4F6C_DD1D)
}

/// Returns a random number in [0, 1).
pub(crate) fn uniform(state: &mut u64) -> f64 {
    (next(state) >> 11) as f64 / (1u64 << 53) as f64
}

fn serve(mut stream: TcpStream, shared: &Shared) -> io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_millis(100)))?;
    stream.set_nodelay(true)?;
    let mut received = Vec::new();
    loop {
        let Some(head) = next_head(&mut stream, &mut received, shared)? else { return Ok(()) };
        if !answer(&mut stream, &head, shared)? {
            return Ok(());
        }
    }
}

/// Reads the head of the next request; `None` at the end of the connection.
fn next_head(stream: &mut TcpStream, received: &mut Vec<u8>, shared: &Shared) -> io::Result<Option<String>> {
    loop {
        if let Some(end) = received.windows(4).position(|four| four == b"\r\n\r\n") {
            let head = String::from_utf8_lossy(&received[..end]).into_owned();
            received.drain(..end + 4);
            return Ok(Some(head));
        }
        let mut buffer = [0; 4096];
        match stream.read(&mut buffer) {
            Ok(0) => return Ok(None),
            Ok(count) => received.extend_from_slice(&buffer[..count]),
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
                if shared.stopping.load(Ordering::Relaxed) {
                    return Ok(None);
                }
            }
            Err(error) => return Err(error),
        }
    }
}

/// Answers one request; returns `false` to end the connection.
fn answer(stream: &mut TcpStream, head: &str, shared: &Shared) -> io::Result<bool> {
    let count = |counter: &AtomicU64| counter.fetch_add(1, Ordering::Relaxed);
    count(&shared.counts.answers);
    let mut words = head.split_whitespace();
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let path = target.split('?').next().unwrap_or_default();
    let range = head.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.eq_ignore_ascii_case("range").then(|| value.trim().strip_prefix("bytes=").map(str::to_owned))?
    });
    let faults = *shared.faults.lock().unwrap();
    let mut chance = {
        let mut chance = shared.chance.lock().unwrap();
        next(&mut chance)
    } | 1;

    let rates = faults.rates;
    let mut left = uniform(&mut chance);
    let mut is_fault = |rate: f64| {
        let hit = (0.0..rate).contains(&left);
        left -= rate;
        hit
    };
    if is_fault(rates.drop) {
        count(&shared.counts.dropped);
        return Ok(false);
    }
    if is_fault(rates.delay) {
        count(&shared.counts.delayed);
        let hang = faults.hang > Duration::ZERO && next(&mut chance).is_multiple_of(10);
        std::thread::sleep(if hang { faults.hang } else { Duration::from_millis(next(&mut chance) % 100) });
    }
    let (truncates, refuses, flips) = (is_fault(rates.truncate), is_fault(rates.refuse), is_fault(rates.flip));
    if refuses {
        count(&shared.counts.refused);
        let status = ["500 Internal Server Error", "503 Service Unavailable", "429 Too Many Requests"];
        let status = status[(next(&mut chance) % 3) as usize];
        write!(stream, "HTTP/1.1 {status}\r\nContent-Length: 4\r\n\r\nbusy")?;
        return Ok(true);
    }
    let entry = {
        let files = shared.files.lock().unwrap();
        files.get(path).map(|entry| (entry.bytes.clone(), entry.etag.clone()))
    };
    let Some((bytes, etag)) = entry else {
        write!(stream, "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")?;
        return Ok(true);
    };
    // Files have a tag; an entry without one is a redirection.
    if etag.is_empty() {
        let location = String::from_utf8_lossy(&bytes);
        write!(stream, "HTTP/1.1 302 Found\r\nLocation: {location}\r\nContent-Length: 0\r\n\r\n")?;
        return Ok(true);
    }
    let size = bytes.len();
    let span = match range.as_deref().and_then(|range| range.split_once('-')) {
        None => None,
        Some((first, last)) => {
            let first: usize = first.parse().unwrap_or(0);
            let last = last.parse().map_or(size, |last: usize| (last + 1).min(size));
            if first >= last {
                write!(stream, "HTTP/1.1 416 Range Not Satisfiable\r\nContent-Length: 0\r\n\r\n")?;
                return Ok(true);
            }
            Some(first..last)
        }
    };
    let mut body = bytes[span.clone().unwrap_or(0..size)].to_vec();
    let mut answer = match &span {
        Some(span) => {
            format!("HTTP/1.1 206 Partial Content\r\nContent-Range: bytes {}-{}/{size}\r\n", span.start, span.end - 1)
        }
        None => "HTTP/1.1 200 OK\r\n".to_owned(),
    };
    if flips {
        count(&shared.counts.flipped);
        for _ in 0..1 + next(&mut chance) % 3 {
            let at = next(&mut chance) as usize % body.len();
            body[at] ^= 1 << (next(&mut chance) % 8);
        }
    }
    let mut stays = true;
    let whole = body.len();
    let mut content_length = whole;
    if truncates {
        count(&shared.counts.truncated);
        body.truncate(next(&mut chance) as usize % whole);
        if next(&mut chance).is_multiple_of(2) {
            content_length = body.len();
        } else {
            stays = false;
        }
    }
    write!(answer, "Content-Length: {content_length}\r\nETag: {etag}\r\nAccept-Ranges: bytes\r\n").unwrap();
    answer += "Last-Modified: Mon, 01 Jan 2024 00:00:00 GMT\r\nContent-Type: image/tiff\r\n\r\n";
    stream.write_all(answer.as_bytes())?;
    if method != "HEAD" {
        stream.write_all(&body)?;
    }
    Ok(stays)
}
