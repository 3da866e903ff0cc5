//! Parses the URLs of files, and formats them for messages without their secrets.

use std::path::PathBuf;

use super::RemoteError;

/// The location of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Location {
    /// A local path.
    File(PathBuf),
    /// A file on an HTTP or HTTPS server.
    Http {
        /// URL without user name, password and fragment.
        url: String,
        /// `name:password`, if the URL contains them.
        login: Option<String>,
    },
    /// An object in an S3 bucket.
    S3 { bucket: String, key: String },
}

/// A parsed URL.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RemoteUrl {
    pub location: Location,
    /// Name for messages: without user name, password and query, which may contain a signature.
    pub name: String,
    /// Parts that no message may contain.
    secrets: Vec<String>,
}

/// Returns whether the text is the URL of a remote file: `http://`, `https://` or `s3://`.
pub(crate) fn is_remote(location: &str) -> bool {
    scheme(location).is_some_and(|scheme| matches!(scheme.as_str(), "http" | "https" | "s3"))
}

/// Returns the URL of a sidecar file: `suffix` is appended to the path, before any query.
pub(crate) fn sidecar_url(location: &str, suffix: &str) -> String {
    let end = if is_remote(location) { location.find(['?', '#']).unwrap_or(location.len()) } else { location.len() };
    format!("{}{suffix}{}", &location[..end], &location[end..])
}

/// Returns a URL for messages, without parts that may be secret.
pub(crate) fn name_of(location: &str) -> String {
    let without_query = location.split(['?', '#']).next().unwrap_or_default();
    let Some((scheme, rest)) = without_query.split_once("://") else { return without_query.to_owned() };
    let (authority, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
    let host = authority.rsplit_once('@').map_or(authority, |(_, host)| host);
    format!("{scheme}://{host}{path}")
}

fn scheme(location: &str) -> Option<String> {
    let (scheme, _) = location.split_once("://")?;
    let is_scheme = scheme.len() > 1 && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    is_scheme.then(|| scheme.to_ascii_lowercase())
}

impl RemoteUrl {
    pub(super) fn parse(location: &str) -> Result<Self, RemoteError> {
        let Some(scheme) = scheme(location) else {
            return Ok(Self {
                location: Location::File(location.into()),
                name: location.to_owned(),
                secrets: Vec::new(),
            });
        };
        let rest = &location[scheme.len() + 3..];
        let rest = rest.split('#').next().unwrap_or_default();
        let (path, query) = rest.split_once('?').map_or((rest, None), |(path, query)| (path, Some(query)));
        let (authority, path) = path.split_at(path.find('/').unwrap_or(path.len()));
        let (login, host) = authority.rsplit_once('@').map_or((None, authority), |(login, host)| (Some(login), host));
        let name = format!("{scheme}://{host}{path}");
        let bad = |cause: String| RemoteError::BadUrl { name: name.clone(), cause };
        if host.is_empty() {
            return Err(bad("the URL has no server name".into()));
        }
        let mut secrets = Vec::new();
        let location = match scheme.as_str() {
            "http" | "https" => {
                secrets.extend(query.filter(|query| !query.is_empty()).map(str::to_owned));
                secrets.extend(login.filter(|login| !login.is_empty()).map(str::to_owned));
                let query = query.map(|query| format!("?{query}")).unwrap_or_default();
                let path = if path.is_empty() { "/" } else { path };
                let url = format!("{scheme}://{host}{path}{query}");
                Location::Http { url, login: login.map(percent_decoded) }
            }
            "s3" => {
                let key = path.trim_start_matches('/').to_owned();
                if key.is_empty() {
                    return Err(bad("the URL has a bucket but no object key".into()));
                }
                Location::S3 { bucket: host.to_owned(), key }
            }
            _ => return Err(bad(format!("{scheme}:// is not supported; use http, https or s3"))),
        };
        Ok(Self { location, name, secrets })
    }

    /// Formats a library's error message: one line of bounded length, without secrets.
    pub(super) fn printable(&self, said: &str) -> String {
        let mut line = said.split_whitespace().collect::<Vec<_>>().join(" ");
        for secret in &self.secrets {
            line = line.replace(secret.as_str(), "…");
        }
        match line.char_indices().nth(300) {
            Some((end, _)) => format!("{}…", &line[..end]),
            None => line,
        }
    }
}

fn percent_decoded(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let escaped = tail.get(..2).filter(|_| first == b'%').and_then(|hex| std::str::from_utf8(hex).ok());
        match escaped.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Encodes bytes for the header of basic authentication.
pub(super) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for letter in 0..4 {
            let filled = letter <= three.len();
            text.push(if filled { char::from(LETTERS[(bits >> (18 - 6 * letter) & 63) as usize]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urls_are_parsed_and_printed_without_secrets() {
        let parsed = RemoteUrl::parse("https://me:p%40ss@host.org:8080/a/b.tif?X-Signature=abc&x=1#page").unwrap();
        assert_eq!(parsed.name, "https://host.org:8080/a/b.tif");
        let url = "https://host.org:8080/a/b.tif?X-Signature=abc&x=1".to_owned();
        let printed = parsed.printable(&format!("GET {url}\n failed for me:p%40ss"));
        assert_eq!(printed, "GET https://host.org:8080/a/b.tif?… failed for …");
        assert_eq!(parsed.location, Location::Http { url, login: Some("me:p@ss".into()) });

        let parsed = RemoteUrl::parse("s3://bucket/a/b c.tif").unwrap();
        assert_eq!(parsed.location, Location::S3 { bucket: "bucket".into(), key: "a/b c.tif".into() });
        assert!(matches!(RemoteUrl::parse("/a/b.tif").unwrap().location, Location::File(_)));
        assert!(matches!(RemoteUrl::parse("C:\\a.tif").unwrap().location, Location::File(_)));
        for bad in ["ftp://host/a", "s3://bucket", "s3://bucket/", "http:///a", "http://me@/a"] {
            let message = RemoteUrl::parse(bad).unwrap_err().to_string();
            assert!(!message.contains('\n') && !message.contains("me@"), "{message}");
        }
    }

    #[test]
    fn sidecar_urls_keep_the_query() {
        assert_eq!(sidecar_url("http://h/a.tif?k=1", ".tiles"), "http://h/a.tif.tiles?k=1");
        assert_eq!(sidecar_url("s3://b/a.tif", ".tiles"), "s3://b/a.tif.tiles");
        assert_eq!(sidecar_url("/tmp/what?.tif", ".tiles"), "/tmp/what?.tif.tiles");
    }

    #[test]
    fn names_hold_no_secrets() {
        assert_eq!(name_of("https://me:pass@host/a.tif?signature=x"), "https://host/a.tif");
        assert_eq!(name_of("s3://bucket/a.tif"), "s3://bucket/a.tif");
        assert_eq!(name_of("http://host"), "http://host");
    }

    #[test]
    fn base64_is_right() {
        let all: Vec<String> = ["", "f", "fo", "foo", "foob"].iter().map(|text| base64(text.as_bytes())).collect();
        assert_eq!(all, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg=="]);
    }
}
