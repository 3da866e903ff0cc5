//! A web server on the loopback that is faulty in one of many ways, chosen by name.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

struct Shared {
    kind: &'static str,
    file: Vec<u8>,
    /// Duration that replaces a second, so that tests are quick.
    second: Duration,
    asked: AtomicU64,
    stopping: AtomicBool,
    connections: Mutex<Vec<JoinHandle<()>>>,
}

/// A server that serves `/world.tif` until it is dropped.
pub(crate) struct Server {
    address: SocketAddr,
    shared: Arc<Shared>,
    listener: Option<JoinHandle<()>>,
}

impl Server {
    pub(crate) fn start(kind: &'static str, file: Vec<u8>, second: Duration) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let shared = Arc::new(Shared {
            kind,
            file,
            second,
            asked: AtomicU64::new(0),
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
                // A connection that fails is one purpose of this server.
                let serve = move || drop(theirs.serve(stream));
                ours.connections.lock().unwrap().push(std::thread::spawn(serve));
            }
        });
        Self { address, shared, listener: Some(listener) }
    }

    pub(crate) fn url(&self) -> String {
        format!("http://{}/world.tif", self.address)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.stopping.store(true, Ordering::Relaxed);
        drop(TcpStream::connect(self.address));
        if let Some(listener) = self.listener.take() {
            listener.join().unwrap();
        }
        for connection in self.shared.connections.lock().unwrap().drain(..) {
            connection.join().unwrap();
        }
    }
}

/// A request for a range of bytes.
struct Ask {
    number: u64,
    path: String,
    first: usize,
    /// One beyond the last byte.
    end: usize,
}

/// The answer, which the kinds of server change.
struct Answer {
    status: &'static str,
    /// Lines of headers.
    head: String,
    length: Option<usize>,
    body: Vec<u8>,
}

impl Shared {
    fn serve(&self, mut stream: TcpStream) -> io::Result<()> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(Duration::from_secs(5)))?;
        stream.set_write_timeout(Some(Duration::from_secs(5)))?;
        let mut head = Vec::new();
        let mut byte = [0; 512];
        while !head.windows(4).any(|four| four == b"\r\n\r\n") {
            match stream.read(&mut byte)? {
                0 => return Ok(()),
                count => head.extend_from_slice(&byte[..count]),
            }
        }
        let head = String::from_utf8_lossy(&head).into_owned();
        let path = head.split(' ').nth(1).unwrap_or_default().to_owned();
        if path.contains(".tiles") {
            return stream.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
        }
        let range = head.lines().find_map(|line| {
            line.to_ascii_lowercase()
                .strip_prefix("range: bytes=")?
                .split_once('-')
                .map(|(first, last)| (first.parse::<usize>().unwrap(), last.trim().parse::<usize>().unwrap()))
        });
        let (first, last) = range.unwrap_or((0, self.file.len()));
        let end = (last + 1).min(self.file.len());
        let number = self.asked.fetch_add(1, Ordering::Relaxed);
        self.answer(&mut stream, Ask { number, path, first: first.min(end), end })
    }

    /// Does nothing until the test is over.
    fn sleep(&self) -> io::Result<()> {
        while !self.stopping.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(10));
        }
        Ok(())
    }

    fn write(&self, stream: &mut TcpStream, answer: &Answer) -> io::Result<()> {
        let mut head = format!("HTTP/1.1 {}\r\nConnection: close\r\n{}", answer.status, answer.head);
        if let Some(length) = answer.length {
            head += &format!("Content-Length: {length}\r\n");
        }
        head += "\r\n";
        stream.write_all(head.as_bytes())?;
        stream.write_all(&answer.body)
    }

    fn slowly(&self, stream: &mut TcpStream, bytes: &[u8]) -> io::Result<()> {
        for byte in bytes {
            if self.stopping.load(Ordering::Relaxed) {
                break;
            }
            stream.write_all(&[*byte])?;
            std::thread::sleep(self.second);
        }
        Ok(())
    }

    fn answer(&self, stream: &mut TcpStream, ask: Ask) -> io::Result<()> {
        let size = self.file.len();
        let Ask { number, first, end, .. } = ask;
        let range =
            |first: usize, end: usize, size: usize| format!("Content-Range: bytes {first}-{}/{size}\r\n", end - 1);
        let body = self.file[first..end].to_vec();
        let mut answer = Answer {
            status: "206 Partial Content",
            head: range(first, end, size) + "ETag: \"one\"\r\n",
            length: Some(body.len()),
            body,
        };
        let length = end - first;
        let half = length / 2;
        let third = number % 3 == 1;
        let redirect = |place: &str| {
            format!("HTTP/1.1 302 Found\r\nLocation: {place}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
        };
        let status = |line: &str| format!("HTTP/1.1 {line}\r\nContent-Length: 4\r\nConnection: close\r\n\r\nbusy");
        let chunked = |body: &[u8], piece: usize| {
            let mut bytes = Vec::new();
            for chunk in body.chunks(piece) {
                bytes.extend(format!("{:x}\r\n", chunk.len()).as_bytes());
                bytes.extend(chunk);
                bytes.extend(b"\r\n");
            }
            bytes
        };
        let hops = ask.path.trim_start_matches("/hop").parse::<u32>().unwrap_or(0);
        match self.kind {
            "chunked"
            | "chunked in small pieces"
            | "closes in the middle, chunked"
            | "a chunk of no size"
            | "an endless body, chunked" => {
                answer.head += "Transfer-Encoding: chunked\r\n";
                answer.length = None;
                let piece = if self.kind.contains("small") { 97 } else { 10_000 };
                answer.body = chunked(&answer.body, piece);
                match self.kind {
                    "closes in the middle, chunked" => answer.body.truncate(half),
                    "a chunk of no size" => answer.body.extend(b"zz\r\n"),
                    "an endless body, chunked" => {}
                    _ => answer.body.extend(b"0\r\n\r\n"),
                }
                self.write(stream, &answer)?;
                while self.kind.contains("endless") {
                    stream.write_all(&chunked(&[7; 4096], 4096))?;
                }
                return Ok(());
            }
            "no length, closed at the end" => answer.length = None,
            "HTTP/1.0" => {
                stream.write_all(format!("HTTP/1.0 206 Partial Content\r\n{}\r\n", answer.head).as_bytes())?;
                return stream.write_all(&answer.body);
            }
            "time of change that is none" => answer.head += "Last-Modified: the day before yesterday\r\n",
            "empty time of change" => answer.head = range(first, end, size) + "Last-Modified:\r\n",
            "time of change in Latin-1" => {
                let mut head = format!("HTTP/1.1 206 Partial Content\r\nContent-Length: {length}\r\n").into_bytes();
                head.extend(range(first, end, size).as_bytes());
                head.extend(b"Last-Modified: 1. M\xe4rz 2024\r\nConnection: close\r\n\r\n");
                stream.write_all(&head)?;
                return stream.write_all(&answer.body);
            }
            "neither ETag nor time of change" => answer.head = range(first, end, size),
            "unit of ranges in capitals" => answer.head = answer.head.replace("bytes", "BYTES"),
            "sixty more headers" => (0..60).for_each(|i| answer.head += &format!("X-{i}: {i}\r\n")),
            "a header of 16 KiB" => answer.head += &format!("X-Long: {}\r\n", "x".repeat(16 << 10)),
            "100 Continue first" => stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n")?,
            "another content type" => answer.head += "Content-Type: text/html\r\n",
            "a wrong content encoding" => answer.head += "Content-Encoding: gzip\r\n",
            "every answer a little late" => std::thread::sleep(self.second / 4),
            "the head in two pieces" => {
                stream.write_all(b"HTTP/1.1 206 Part")?;
                std::thread::sleep(self.second / 4);
                stream
                    .write_all(format!("ial Content\r\n{}Content-Length: {length}\r\n\r\n", answer.head).as_bytes())?;
                return stream.write_all(&answer.body);
            }
            "slow, but on the way" => {
                let pieces = std::mem::take(&mut answer.body);
                self.write(stream, &answer)?;
                for piece in pieces.chunks(60_000) {
                    stream.write_all(piece)?;
                    std::thread::sleep(self.second / 10);
                }
                return Ok(());
            }
            "redirects once" if hops == 0 => return stream.write_all(redirect("/hop1").as_bytes()),
            "redirects five times" if hops < 5 => {
                return stream.write_all(redirect(&format!("/hop{}", hops + 1)).as_bytes());
            }
            "sometimes drops the connection" if third => return Ok(()),
            "sometimes ends in the middle" if third => answer.body.truncate(half),
            "sometimes 500" if third => return stream.write_all(status("500 Oh").as_bytes()),
            "sometimes 503 with Retry-After: 0" if third => {
                return stream.write_all(status("503 Oh\r\nRetry-After: 0").as_bytes());
            }
            "once 429 with Retry-After: 1" if number == 1 => {
                return stream.write_all(status("429 Oh\r\nRetry-After: 1").as_bytes());
            }
            "sometimes too short, and says so" if third => {
                answer.body.truncate(half);
                answer.length = Some(half);
            }
            "sometimes too long" if third => {
                answer.body.extend([1; 99]);
                answer.length = None;
            }
            "sometimes another range" if third => answer.head = range(first + 7, end + 7, size),
            "sometimes stops in the middle" if number % 5 == 4 => {
                answer.body.truncate(half);
                self.write(stream, &answer)?;
                return self.sleep();
            }
            "sometimes changes bytes" if number % 4 == 3 => answer.body[half] ^= 4,
            "sometimes 404" if number % 8 == 7 => return stream.write_all(status("404 Gone").as_bytes()),
            "sometimes another ETag" if number % 8 == 7 => answer.head = answer.head.replace("one", "two"),
            "silence" => return self.sleep(),
            "silence for the last third" if end > size / 3 * 2 => return self.sleep(),
            "100 bytes, then nothing" | "all but the last byte" => {
                answer.body.truncate(if self.kind.starts_with("100") { 100 } else { length - 1 });
                self.write(stream, &answer)?;
                return self.sleep();
            }
            "stops in the head" => {
                stream.write_all(b"HTTP/1.1 206 Partial Content\r\nContent-")?;
                return self.sleep();
            }
            "a byte now and then" => {
                let bytes = std::mem::take(&mut answer.body);
                self.write(stream, &answer)?;
                return self.slowly(stream, &bytes);
            }
            "the head, a byte now and then" => {
                return self.slowly(stream, b"HTTP/1.1 206 Partial Content\r\nX-A: b\r\nX-B: c\r\nX-C: d\r\n");
            }
            "every answer very late" => std::thread::sleep(self.second * 15),
            "an endless head" => {
                stream.write_all(b"HTTP/1.1 206 Partial Content\r\n")?;
                while !self.stopping.load(Ordering::Relaxed) {
                    stream.write_all(format!("X-Y: {}\r\n", "y".repeat(4000)).as_bytes())?;
                }
                return Ok(());
            }
            "an endless body" => {
                answer.length = None;
                self.write(stream, &answer)?;
                while !self.stopping.load(Ordering::Relaxed) {
                    stream.write_all(&[7; 4096])?;
                }
                return Ok(());
            }
            "closes at once" => return Ok(()),
            "closes after the head" => answer.body.clear(),
            "closes in the middle" => answer.body.truncate(half),
            "no web server" => return stream.write_all(b"220 mail.example ESMTP\r\n"),
            "noise" => return stream.write_all(&self.file[size / 2..size / 2 + 1000]),
            "500" => return stream.write_all(status("500 Oh").as_bytes()),
            "500 for the last third" if end > size / 3 * 2 => return stream.write_all(status("500 Oh").as_bytes()),
            "429 with Retry-After: 3600" => {
                return stream.write_all(status("429 Oh\r\nRetry-After: 3600").as_bytes());
            }
            "204" | "304" => {
                return stream.write_all(format!("HTTP/1.1 {} Oh\r\nConnection: close\r\n\r\n", self.kind).as_bytes());
            }
            "403 after a while" if number > 2 => return stream.write_all(status("403 No").as_bytes()),
            "404 after a while" if number > 2 => return stream.write_all(status("404 No").as_bytes()),
            "416" => return stream.write_all(status("416 No").as_bytes()),
            "redirects in a circle" => return stream.write_all(redirect("/world.tif").as_bytes()),
            "redirects for ever" => return stream.write_all(redirect(&format!("/hop{}", hops + 1)).as_bytes()),
            "redirects to a file" => return stream.write_all(redirect("file:///etc/passwd").as_bytes()),
            "redirects to ftp" => return stream.write_all(redirect("ftp://127.0.0.1/world.tif").as_bytes()),
            "redirects without a place" => {
                return stream.write_all(status("302 Found").as_bytes());
            }
            // A port on which nothing listens.
            "redirects to nobody" => return stream.write_all(redirect("http://127.0.0.1:1/world.tif").as_bytes()),
            "the whole file, 200" | "the whole file, 206" => {
                answer.body = self.file.clone();
                answer.length = Some(size);
                answer.head = range(0, size, size) + "ETag: \"one\"\r\n";
                if self.kind.ends_with("200") {
                    answer.status = "200 OK";
                    answer.head = "ETag: \"one\"\r\n".into();
                }
            }
            "no Content-Range" => answer.head = "ETag: \"one\"\r\n".into(),
            "several parts" => answer.head = "Content-Type: multipart/byteranges; boundary=x\r\n".into(),
            "Content-Range of another part" => answer.head = range(first + 4096, end + 4096, size + 4096),
            "Content-Range of nonsense" => answer.head = "Content-Range: some of it\r\n".into(),
            "Content-Range of 2^64 bytes" => {
                answer.head = format!("Content-Range: bytes {first}-{}/{}\r\n", u64::MAX, u64::MAX);
            }
            "bytes of another part" if first > 0 => {
                answer.body = self.file[first - 1000..end - 1000].to_vec();
            }
            "zeros" => answer.body.fill(0),
            "bytes changed in every answer" => (0..length).step_by(3000).for_each(|at| answer.body[at] ^= 0x55),
            "compressed" => {
                answer.head += "Content-Encoding: gzip\r\n";
                answer.body[..2].copy_from_slice(&[0x1f, 0x8b]);
            }
            "a file twice as long" => answer.head = range(first, end, 2 * size),
            "a file half as long" => {
                let end = end.min(size / 2).max(first + 1);
                answer.head = range(first, end, (size / 2).max(end));
                answer.body.truncate(end - first);
                answer.length = Some(end - first);
            }
            "a length that is too long" => answer.length = Some(length + 100),
            "a length that is too short" => answer.length = Some(length - 100),
            "another ETag each time" => answer.head = answer.head.replace("one", &number.to_string()),
            "another size each time" => answer.head = range(first, end, size + number as usize),
            "another file after a while" if number > 2 => answer.head = answer.head.replace("one", "two"),
            _ => {}
        }
        self.write(stream, &answer)
    }
}
