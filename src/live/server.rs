//! The server of the live view: on the loopback interface, under a path with a random token.

use super::board::{Board, Command};
use super::news::{Extent, Seen};
use super::request::Request;
use super::response::{HttpResponse, begin_events, event};
use crate::storage::{hexadecimal, sha256};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::io::{self, Read};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Largest number of simultaneous connections. As many more wait for a free slot; any others are refused at once.
pub(super) const CONNECTIONS: usize = 32;
/// Largest number of connections that follow the run.
const FOLLOWERS: usize = 16;
/// Time that a connection waits for a free slot; slots of disconnected clients are freed at the next message to them.
const PATIENCE: Duration = Duration::from_secs(3);
/// Least time between two messages to a client; changes in between are combined into one message.
pub(super) const PACE: Duration = Duration::from_millis(40);
/// Time after which a client without news gets a keep-alive comment.
const SILENCE: Duration = Duration::from_secs(2);
/// Default port of an address without one.
const DEFAULT_PORT: u16 = 80;
/// Largest number of bytes that are read from a client after the response.
const DRAINED_BYTES: usize = 64 << 10;
/// Time limit for each read from a client after the response.
const DRAINED_TIME: Duration = Duration::from_millis(200);

/// Why there is no live view.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    #[error(
        "--port {port}: another program uses this port; take another one, or leave --port out for one that is free"
    )]
    PortInUse { port: u16 },
    #[error(
        "--port {port}: cannot be opened on the loopback interface: {reason}; take a port above 1023, or leave --port out"
    )]
    Port { port: u16, reason: String },
    #[error("--live: the system gives no random numbers for the token: {reason}; run without --live")]
    Token { reason: String },
}

/// How browsers reach a live view: the port and the token of the printed address.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Access {
    pub port: u16,
    pub token: String,
}

impl Access {
    /// Returns the address for a browser.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }
}

/// An open port that is not served yet.
pub struct Listener {
    listener: TcpListener,
    access: Access,
}

impl Listener {
    /// Opens a port of the loopback interface; 0 takes a free port.
    pub fn open(port: u16) -> Result<Self, LiveError> {
        let (listener, port) = bind(port)?;
        let mut random = [0; 16];
        getrandom::fill(&mut random).map_err(|e| LiveError::Token { reason: e.to_string() })?;
        let token = hexadecimal(&random);
        Ok(Self { listener, access: Access { port, token } })
    }

    /// Opens a free port to which a [`Relay`](super::Relay) forwards the requests to its own port. Also returns the number of the port.
    pub fn behind(access: &Access) -> Result<(Self, u16), LiveError> {
        let (listener, port) = bind(0)?;
        Ok((Self { listener, access: access.clone() }, port))
    }

    /// Returns how browsers reach the live view.
    pub fn access(&self) -> &Access {
        &self.access
    }

    /// Serves the board in threads of its own; `None` if the system cannot start a thread.
    pub fn serve(self, board: Arc<Board>) -> Option<Served> {
        let site = Arc::new(Site::new(&self.access, board));
        let own = site.clone();
        self.accept(site, move |stream| Site::take(&own, stream))
    }

    /// Accepts connections to a site in a thread of its own; `None` if the system cannot start a thread.
    pub(super) fn accept(self, site: Arc<Site>, take: impl Fn(TcpStream) + Send + 'static) -> Option<Served> {
        let port = self.listener.local_addr().ok()?.port();
        let (own, listener) = (site.clone(), self.listener);
        let accept = move || {
            while !own.is_closed() {
                match listener.accept() {
                    Ok((stream, _)) => take(stream),
                    // For example, too many open files: connections that are being served will end at some point
                    Err(_) => std::thread::sleep(PACE),
                }
            }
        };
        let thread = std::thread::Builder::new().name("live".into()).spawn(accept).ok()?;
        Some(Served { port, site, thread: Some(thread) })
    }
}

/// A port that is served until this value is dropped.
pub struct Served {
    port: u16,
    site: Arc<Site>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Served {
    fn drop(&mut self) {
        self.site.closed.store(true, Ordering::SeqCst);
        // The thread waits for a connection; after this one it notices that it must end
        if let Some(thread) =
            self.thread.take().filter(|_| TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).is_ok())
        {
            thread.join().ok();
        }
    }
}

/// Opens a socket of the loopback interface and returns it with its port.
fn bind(port: u16) -> Result<(TcpListener, u16), LiveError> {
    let failed = |e: io::Error| match e.kind() {
        io::ErrorKind::AddrInUse => LiveError::PortInUse { port },
        _ => LiveError::Port { port, reason: e.to_string() },
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
    let bound = listener.local_addr().map_err(failed)?;
    Ok((listener, bound.port()))
}

/// A server and its board.
pub(super) struct Site {
    /// Host names that a request may contain
    hosts: Vec<String>,
    /// Digest of the token, so that the time of a comparison reveals nothing about it
    token: String,
    board: Arc<Board>,
    connections: AtomicUsize,
    waiting: AtomicUsize,
    followers: AtomicUsize,
    /// Set to disconnect the clients that follow the run
    closed: AtomicBool,
}

/// Returns the host names of a server with this port; browsers omit the default port.
fn hosts(port: u16) -> Vec<String> {
    let names = ["127.0.0.1", "localhost"];
    let bare = names.iter().filter(|_| port == DEFAULT_PORT).map(ToString::to_string);
    names.iter().map(|name| format!("{name}:{port}")).chain(bare).collect()
}

/// Counts as one until it is dropped.
pub(super) struct Counted<'a>(&'a AtomicUsize);

impl<'a> Counted<'a> {
    pub fn below(count: &'a AtomicUsize, most: usize) -> Option<Self> {
        let one = Self(count);
        (count.fetch_add(1, Ordering::SeqCst) < most).then_some(one)
    }
}

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// A client that follows the run until this value is dropped.
struct Follower<'a>(&'a Board);

impl Drop for Follower<'_> {
    fn drop(&mut self) {
        self.0.leave();
    }
}

impl Site {
    pub fn new(access: &Access, board: Arc<Board>) -> Self {
        Self {
            hosts: hosts(access.port),
            token: sha256(&access.token),
            board,
            connections: AtomicUsize::new(0),
            waiting: AtomicUsize::new(0),
            followers: AtomicUsize::new(0),
            closed: AtomicBool::new(false),
        }
    }

    fn is_closed(&self) -> bool {
        self.closed.load(Ordering::SeqCst)
    }

    /// Answers a connection in a thread of its own.
    pub fn take(site: &Arc<Self>, mut stream: TcpStream) {
        let own = site.clone();
        let serve = move || {
            let Some(_one) = own.admit() else {
                HttpResponse::refusal(503, "too many connections").send(&mut stream).ok();
                return;
            };
            // A disconnected client needs no response
            own.serve(&mut stream).ok();
        };
        // If no thread can be started, the connection is closed
        std::thread::Builder::new().name("live client".into()).spawn(serve).ok();
    }

    /// Waits for a free slot among the connections; `None` if there is none in time or too many are waiting.
    fn admit(&self) -> Option<Counted<'_>> {
        let _one = Counted::below(&self.waiting, CONNECTIONS)?;
        let start = Instant::now();
        loop {
            let place = Counted::below(&self.connections, CONNECTIONS);
            if place.is_some() || start.elapsed() > PATIENCE {
                return place;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn serve(&self, stream: &mut TcpStream) -> io::Result<()> {
        stream.set_nodelay(true)?;
        let answer = match Request::read(stream) {
            Ok(None) => return Ok(()),
            Ok(Some(request)) => match self.answer(&request) {
                Some(answer) => answer,
                None => return self.follow(stream),
            },
            Err(refusal) => refusal,
        };
        answer.send(stream)?;
        finish(stream)
    }

    /// Returns the response to a request; `None` for the event stream.
    fn answer(&self, request: &Request) -> Option<HttpResponse> {
        Some(match self.place(request) {
            Err(refusal) => refusal,
            Ok(place) => match (request.method.as_str(), place) {
                ("GET", "") => HttpResponse::found("text/html; charset=utf-8", self.board.page().as_bytes().to_vec()),
                ("GET", "events") => return None,
                ("GET", "rows") => self.rows(&request.query),
                ("POST", "command") => self.command(request),
                ("GET", place) => match place.strip_prefix("states/").map(str::parse) {
                    Some(Ok(number)) => self.state(number),
                    _ => HttpResponse::refusal(404, "there is no such page"),
                },
                ("POST", _) => HttpResponse::refusal(404, "there is no such page"),
                _ => HttpResponse::refusal(405, "use GET or POST"),
            },
        })
    }

    /// Returns the path below the token. Refuses host names under which another site could reach this server, requests from scripts of other sites, and
    /// requests without the token.
    fn place<'r>(&self, request: &'r Request) -> Result<&'r str, HttpResponse> {
        let known = |name: &str| self.hosts.iter().any(|host| host == name);
        if !request.header("host").is_some_and(known) {
            return Err(HttpResponse::refusal(403, "this server answers under its own address alone"));
        }
        let own_site = |origin: &str| origin.strip_prefix("http://").is_some_and(known);
        let other_origin = request.has("origin") && !request.header("origin").is_some_and(own_site);
        let other_site = request.header("sec-fetch-site").is_some_and(|site| !["same-origin", "none"].contains(&site));
        if other_origin || other_site {
            return Err(HttpResponse::refusal(403, "another page may not use this server"));
        }
        let (token, place) = request.path.trim_start_matches('/').split_once('/').unwrap_or_default();
        if sha256(token) != self.token {
            return Err(HttpResponse::refusal(403, "open the whole address that the run has printed, with its token"));
        }
        Ok(place)
    }

    fn state(&self, number: usize) -> HttpResponse {
        match self.board.frame(number) {
            Some(frame) => HttpResponse::found("application/octet-stream", frame.bytes()),
            None => HttpResponse::refusal(404, "this state is not kept"),
        }
    }

    fn rows(&self, query: &str) -> HttpResponse {
        let first = query.strip_prefix("from=").and_then(|text| text.parse().ok()).unwrap_or(0);
        let (Extent { stride, count }, rows) = self.board.rows(first);
        let rows: Vec<_> = rows.iter().map(|(k, row)| json!([k, &row[..]])).collect();
        let answer = json!({ "stride": stride, "count": count, "rows": rows });
        HttpResponse::found("application/json", answer.to_string().into_bytes())
    }

    fn command(&self, request: &Request) -> HttpResponse {
        // A form on another site's page cannot send this content type
        if request.header("content-type") != Some("application/json") {
            return HttpResponse::refusal(415, "send a command as application/json");
        }
        match serde_json::from_slice::<Command>(&request.body) {
            Ok(command) => match self.board.obey(command) {
                Ok(()) => HttpResponse::done(),
                Err(why) => HttpResponse::refusal(409, &why),
            },
            Err(why) => HttpResponse::refusal(400, &format!("this is no command: {why}")),
        }
    }

    /// Sends events until the client disconnects or accepts no more, or the server is closed.
    fn follow(&self, stream: &mut TcpStream) -> io::Result<()> {
        let Some(_one) = Counted::below(&self.followers, FOLLOWERS) else {
            return HttpResponse::refusal(503, "too many pages are open").send(stream);
        };
        begin_events(stream)?;
        self.board.join();
        let (_follower, mut seen) = (Follower(&self.board), Seen::default());
        while !self.is_closed() {
            let news = self.board.news(&mut seen, SILENCE);
            event(stream, news.map(|news| news.json().to_string()).as_deref())?;
            std::thread::sleep(PACE);
        }
        Ok(())
    }
}

/// Closes a connection in such a way that the client receives the response even if it is still sending.
fn finish(stream: &mut TcpStream) -> io::Result<()> {
    stream.shutdown(Shutdown::Write)?;
    stream.set_read_timeout(Some(DRAINED_TIME))?;
    let (mut left, mut part) = (DRAINED_BYTES, [0; 4096]);
    while left > 0 {
        match stream.read(&mut part)? {
            0 => break,
            count => left = left.saturating_sub(count),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::hosts;

    #[test]
    fn the_default_port_may_be_left_out() {
        assert_eq!(hosts(80), ["127.0.0.1:80", "localhost:80", "127.0.0.1", "localhost"]);
        assert_eq!(hosts(8080), ["127.0.0.1:8080", "localhost:8080"]);
    }
}
