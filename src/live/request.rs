//! HTTP requests of browsers, read within limits of size and time.

use super::response::HttpResponse;
use std::io::Read;
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Largest size of the request line with the headers \[bytes\].
const HEAD: usize = 16 << 10;
/// Largest number of headers; a browser sends about 20.
const HEADERS: usize = 64;
/// Largest size of a command \[bytes\].
const BODY: usize = 4 << 10;
/// Time within which a request must be complete.
const PATIENCE: Duration = Duration::from_secs(5);

/// An HTTP request.
#[derive(Debug, Default)]
pub(super) struct Request {
    pub method: String,
    /// Path, without the part after `?`
    pub path: String,
    /// The part after `?`
    pub query: String,
    pub body: Vec<u8>,
    headers: Vec<(String, String)>,
}

impl Request {
    /// Reads a request. Returns `None` if the client has disconnected, and the response as an error if the request is refused.
    pub fn read(stream: &mut TcpStream) -> Result<Option<Self>, HttpResponse> {
        let deadline = Instant::now() + PATIENCE;
        let (mut bytes, mut request, mut length) = (vec![], Self::default(), None);
        loop {
            if let Some(length) = length.filter(|length| bytes.len() >= *length) {
                request.body = bytes;
                request.body.truncate(length);
                return Ok(Some(request));
            }
            let Some(left) = deadline.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) else {
                return Err(HttpResponse::refusal(408, "the request was not complete within 5 s"));
            };
            let mut part = [0; 4096];
            let read = stream.set_read_timeout(Some(left)).and_then(|()| stream.read(&mut part));
            match read {
                Ok(0) => return Ok(None),
                Ok(count) => bytes.extend(&part[..count]),
                Err(e) if matches!(e.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) => continue,
                Err(_) => return Ok(None),
            }
            if length.is_none()
                && let Some((head, end)) = Self::head(&bytes)?
            {
                length = Some(head.length()?);
                request = head;
                bytes.drain(..end);
            }
        }
    }

    /// Parses the request without its body, and returns the offset of the body; `None` while the headers are incomplete.
    fn head(bytes: &[u8]) -> Result<Option<(Self, usize)>, HttpResponse> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        let end = match parsed.parse(bytes) {
            Ok(httparse::Status::Complete(end)) if end <= HEAD => end,
            Ok(httparse::Status::Partial) if bytes.len() <= HEAD => return Ok(None),
            Ok(_) | Err(httparse::Error::TooManyHeaders) => {
                return Err(HttpResponse::refusal(431, "the headers are too long"));
            }
            Err(why) => return Err(HttpResponse::refusal(400, &format!("this is no request of HTTP: {why}"))),
        };
        let (path, query) = parsed.path.unwrap_or_default().split_once('?').unwrap_or((parsed.path.unwrap_or(""), ""));
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_string();
        let request = Self {
            method: parsed.method.unwrap_or_default().into(),
            path: path.into(),
            query: query.into(),
            body: vec![],
            headers: parsed.headers.iter().map(|h| (h.name.to_ascii_lowercase(), text(h.value))).collect(),
        };
        Ok(Some((request, end)))
    }

    /// Returns the length of the body \[bytes\].
    fn length(&self) -> Result<usize, HttpResponse> {
        if self.all("transfer-encoding").next().is_some() {
            return Err(HttpResponse::refusal(411, "give the length of the body"));
        }
        let mut lengths = self.all("content-length");
        let length = lengths.next().map_or(Ok(0), str::parse::<usize>);
        match length {
            Ok(length) if lengths.next().is_none() && length <= BODY => Ok(length),
            Ok(length) if length > BODY => Err(HttpResponse::refusal(413, "a command has at most 4096 bytes")),
            _ => Err(HttpResponse::refusal(400, "the length of the body is no number")),
        }
    }

    fn all(&self, name: &str) -> impl Iterator<Item = &str> {
        self.headers.iter().filter(move |(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// Returns the value of a header, given its lower-case name; `None` if it is absent or repeated.
    pub fn header(&self, name: &str) -> Option<&str> {
        let mut all = self.all(name);
        all.next().filter(|_| all.next().is_none())
    }

    /// Whether the request has a header with this lower-case name.
    pub fn has(&self, name: &str) -> bool {
        self.all(name).next().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_read_whole_or_refused() {
        let text = b"POST /a/command?x=1 HTTP/1.1\r\nHost: h\r\nContent-Length: 3\r\n\r\nabc";
        for cut in 0..text.len() - 3 {
            assert!(Request::head(&text[..cut]).is_ok_and(|found| found.is_none()), "{cut}");
        }
        let (request, end) = Request::head(text).ok().flatten().expect("a head");
        assert_eq!((request.path.as_str(), request.query.as_str(), &text[end..]), ("/a/command", "x=1", &b"abc"[..]));
        assert!(request.length().is_ok_and(|n| n == 3) && request.header("host") == Some("h"));
        let status = |text: &str| match Request::head(text.as_bytes()) {
            Ok(found) => found.map_or(0, |(request, _)| request.length().map_or_else(|a| a.status(), |_| 200)),
            Err(answer) => answer.status(),
        };
        let with = |headers: &str| status(&format!("POST / HTTP/1.1\r\n{headers}\r\n\r\n"));
        assert_eq!(with("Content-Length: 10000000"), 413);
        assert_eq!(with("Content-Length: -1"), 400);
        assert_eq!(with("Content-Length: 1\r\nContent-Length: 2"), 400);
        assert_eq!(with("Transfer-Encoding: chunked"), 411);
        assert_eq!(with(&format!("A: {}", "b".repeat(HEAD))), 431);
        assert_eq!(status(&format!("GET / HTTP/1.1\r\nA: {}", "b".repeat(HEAD))), 431);
        assert_eq!(with(&"A: b\r\n".repeat(HEADERS + 1)), 431);
        assert_eq!(status("\u{0}\u{1}garbage\r\n\r\n"), 400);
    }
}
