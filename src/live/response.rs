//! HTTP responses to browsers.

use std::io::{self, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Time within which a client must accept some bytes.
pub(super) const STALLED_PART: Duration = Duration::from_secs(5);
/// Time within which a client must accept a whole response.
const STALLED_ANSWER: Duration = Duration::from_secs(60);
/// Number of bytes that are written at a time.
const PART: usize = 64 << 10;
/// Headers of every response: it is not cached, not embedded in other pages, and its address is not disclosed to others.
const ALWAYS: &str = "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
                      Cross-Origin-Resource-Policy: same-origin\r\nContent-Security-Policy: frame-ancestors 'none'\r\n";

/// An HTTP response.
#[derive(Debug)]
pub(super) struct HttpResponse {
    status: u16,
    kind: &'static str,
    body: Vec<u8>,
}

impl HttpResponse {
    pub fn found(kind: &'static str, body: Vec<u8>) -> Self {
        Self { status: 200, kind, body }
    }

    /// Returns a response without content.
    pub fn done() -> Self {
        Self { status: 204, kind: "text/plain", body: vec![] }
    }

    pub fn refusal(status: u16, why: &str) -> Self {
        Self { status, kind: "text/plain; charset=utf-8", body: format!("{why}\n").into_bytes() }
    }

    #[cfg(test)]
    pub fn status(&self) -> u16 {
        self.status
    }

    /// Sends the response.
    pub fn send(&self, stream: &mut TcpStream) -> io::Result<()> {
        let Self { status, kind, body } = self;
        let head = format!(
            "HTTP/1.1 {status} {}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n{ALWAYS}\r\n",
            words(*status),
            body.len()
        );
        stream.set_write_timeout(Some(STALLED_PART))?;
        stream.write_all(head.as_bytes())?;
        let start = Instant::now();
        for part in body.chunks(PART) {
            if start.elapsed() > STALLED_ANSWER {
                return Err(io::ErrorKind::TimedOut.into());
            }
            stream.write_all(part)?;
        }
        stream.flush()
    }
}

/// Begins a stream of events, as the HTML standard defines them (server-sent events).
pub(super) fn begin_events(stream: &mut TcpStream) -> io::Result<()> {
    stream.set_write_timeout(Some(STALLED_PART))?;
    stream.write_all(format!("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{ALWAYS}\r\n").as_bytes())
}

/// Sends an event, or a comment if there is no data, so that both sides notice a closed connection.
pub(super) fn event(stream: &mut TcpStream, data: Option<&str>) -> io::Result<()> {
    stream.write_all(data.map_or_else(|| ":\n\n".into(), |data| format!("data: {data}\n\n")).as_bytes())
}

fn words(status: u16) -> &'static str {
    match status {
        200 => "OK",
        204 => "No Content",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        409 => "Conflict",
        411 => "Length Required",
        413 => "Content Too Large",
        415 => "Unsupported Media Type",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Bad Request",
    }
}
