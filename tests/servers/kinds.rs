//! The kinds of server, by name, and the expected outcome of each.

/// The expected outcome of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Expected {
    /// The right picture.
    Right,
    /// An error that contains these words.
    Error(&'static str),
    /// The right picture or an error.
    Either,
}
use Expected::{Either, Error, Right};

/// All kinds of server.
pub(crate) const KINDS: &[(&str, Expected)] = &[
    ("as it should be", Right),
    // Unusual, but valid.
    ("chunked", Right),
    ("chunked in small pieces", Right),
    ("no length, closed at the end", Right),
    ("HTTP/1.0", Right),
    ("time of change that is none", Right),
    ("empty time of change", Right),
    ("time of change in Latin-1", Right),
    ("neither ETag nor time of change", Right),
    ("unit of ranges in capitals", Right),
    ("sixty more headers", Right),
    ("a header of 16 KiB", Right),
    ("100 Continue first", Right),
    ("another content type", Right),
    ("a wrong content encoding", Right),
    ("every answer a little late", Right),
    ("the head in two pieces", Right),
    ("slow, but on the way", Right),
    ("redirects once", Right),
    ("redirects five times", Right),
    // Sometimes wrong: the request is repeated.
    ("sometimes drops the connection", Right),
    ("sometimes ends in the middle", Right),
    ("sometimes 500", Right),
    ("sometimes 503 with Retry-After: 0", Right),
    ("once 429 with Retry-After: 1", Right),
    ("sometimes too short, and says so", Right),
    ("sometimes too long", Right),
    ("sometimes another range", Right),
    ("sometimes stops in the middle", Right),
    ("sometimes changes bytes", Either),
    ("sometimes 404", Either),
    ("sometimes another ETag", Either),
    // Does not end.
    ("silence", Error("no data for")),
    ("100 bytes, then nothing", Error("after 100 bytes")),
    ("all but the last byte", Error("no data for")),
    ("stops in the head", Error("no data for")),
    ("a byte now and then", Error("no complete answer within")),
    ("the head, a byte now and then", Error("no data for")),
    ("every answer very late", Error("no data for")),
    ("an endless head", Error("")),
    ("an endless body", Error("more than")),
    ("an endless body, chunked", Error("more than")),
    // Ends too early.
    ("closes at once", Error("")),
    ("closes after the head", Error("")),
    ("closes in the middle", Error("")),
    ("closes in the middle, chunked", Error("")),
    ("a chunk of no size", Error("")),
    ("no web server", Error("")),
    ("noise", Error("")),
    // Refuses.
    ("500", Error("the server answers 500")),
    ("429 with Retry-After: 3600", Error("after 1 try: the server answers 429 and requests a pause of 3600 s")),
    ("204", Error("the server answers 204")),
    ("304", Error("the server answers 304")),
    ("403 after a while", Error("access is denied")),
    ("404 after a while", Error("there is no such file")),
    ("416", Error("shorter than it was")),
    ("500 for the last third", Error("the server answers 500")),
    ("silence for the last third", Error("no data for")),
    // Invalid redirects.
    ("redirects in a circle", Error("in a circle")),
    ("redirects for ever", Error("in a circle")),
    ("redirects to a file", Error("redirects to file:///etc/passwd")),
    ("redirects to ftp", Error("redirects to ftp://")),
    ("redirects without a place", Error("without a Location header")),
    ("redirects to nobody", Error("no connection")),
    // Wrong data.
    ("the whole file, 200", Error("does not support range requests")),
    ("the whole file, 206", Error("instead of")),
    ("no Content-Range", Error("does not say which part")),
    ("Content-Range of another part", Error("instead of")),
    ("Content-Range of nonsense", Error("invalid Content-Range")),
    ("Content-Range of 2^64 bytes", Error("invalid Content-Range")),
    ("several parts", Error("does not say which part")),
    ("bytes of another part", Error("damaged data for tile")),
    ("zeros", Error("is not a GeoTIFF, and only GeoTIFFs")),
    ("bytes changed in every answer", Error("")),
    ("compressed", Error("sends the file compressed")),
    ("a file twice as long", Either),
    ("a file half as long", Error("")),
    ("a length that is too long", Error("")),
    ("a length that is too short", Error("bytes came")),
    // Changes between answers.
    ("another ETag each time", Error("differ")),
    ("another size each time", Error("")),
    ("another file after a while", Error("has changed")),
];
