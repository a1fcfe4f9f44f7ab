//! Clients that do what they should not, and programs that are not clients.

use super::client::{BY_HAND, Live, SIGNAL, folders, run, text};
use serde_json::json;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Clients that vanish, take nothing, send garbage or too much, while a good one drives the run.
#[test]
fn bad_clients_change_nothing() {
    let (_folder, [silent, shown]) = folders();
    assert!(run(&silent, &[]).status.success());
    let live = Live::start(&shown, &["--paused"]);
    let (mut good, host) = (live.events(), live.host());
    good.waits(1);
    let with = |headers: &str| format!("GET {} HTTP/1.1\r\nHost: {host}\r\n{headers}\r\n", live.token).into_bytes();
    assert_eq!(live.status(&with("Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n")), 200);
    assert_eq!(live.status(&with(&format!("X: {}\r\n", "a".repeat(1 << 20)))), 431);
    assert_eq!(live.status(&with(&"X: a\r\n".repeat(1000))), 431);
    assert_eq!(live.status(&b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".repeat(99)), 400);
    assert_eq!(live.status(b"GET / HTTP/9.9\r\n\r\n"), 400);
    let post = |length: &str| format!("POST {}command HTTP/1.1\r\nHost: {host}\r\n{length}\r\n\r\n", live.token);
    let large = [post("Content-Length: 10000000").into_bytes(), vec![b'a'; 10_000_000]].concat();
    assert_eq!(live.status(&large), 413);
    assert_eq!(live.status(post("Transfer-Encoding: chunked").as_bytes()), 411);
    assert_eq!(live.status(post("Content-Length: 18446744073709551616").as_bytes()), 400);
    // They never end a request, take no answer, or go in the middle of one
    let slow: Vec<TcpStream> = (0..20).map(|_| live.connect()).collect();
    slow.iter().for_each(|mut stream| stream.write_all(b"GET / HT").expect("the run listens"));
    let stalled: Vec<TcpStream> = (0..5).map(|_| live.events().lines.into_inner()).collect();
    // More than there are places for; those become free when the run next writes to them
    let gone: Vec<_> = (0..20).map(|_| live.events()).collect();
    drop(gone);
    for states in 2..=4 {
        assert_eq!(live.command(&json!("step")), 204);
        good.waits(states);
    }
    // A request that is not complete within 5 s is refused
    let start = Instant::now();
    let mut answer = vec![];
    (&slow[0]).read_to_end(&mut answer).expect("an answer");
    assert!(answer.starts_with(b"HTTP/1.1 408") && start.elapsed() < Duration::from_secs(20), "{answer:?}");
    assert_eq!(live.command(&json!("resume")), 204);
    assert!(live.end().success());
    drop((slow, stalled));
    for name in ["scene.csv", "scene.signals.csv"] {
        assert_eq!(text(&silent, name), text(&shown, name), "{name}");
    }
}

/// Nobody without the token, no page of another site, and nothing but the run.
#[test]
fn others_get_nothing_and_change_nothing() {
    let (_folder, [out]) = folders();
    let live = Live::start(&out, &["--set", BY_HAND, "--paused"]);
    let (mut events, host, token) = (live.events(), live.host(), live.token.clone());
    let news = events.waits(1);
    assert!(token.len() == 34 && token[1..33].chars().all(|c| c.is_ascii_hexdigit()), "{token}");
    let get = |path: &str, headers: &str| live.status(format!("GET {path} HTTP/1.1\r\n{headers}\r\n").as_bytes());
    let own = format!("Host: {host}\r\n");
    assert_eq!(get(&token, &own), 200);
    assert_eq!(
        get(&token, &format!("Host: localhost:{}\r\nOrigin: http://localhost:{}\r\n", live.port, live.port)),
        200
    );
    let wrong = format!("/{}/", "0".repeat(32));
    for path in ["/", "/events", &wrong, &token[..33], &format!("{wrong}events"), "//", "*"] {
        assert_eq!(get(path, &own), 403, "{path}");
    }
    for host in ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1", &format!("evil.example:{}", live.port)]
    {
        assert_eq!(get(&token, &format!("Host: {host}\r\n")), 403, "{host}");
    }
    assert_eq!(get(&token, ""), 403, "without a host");
    assert_eq!(get(&token, &format!("{own}{own}")), 403, "two hosts");
    for other in
        ["Origin: http://evil.example", "Origin: null", "Origin: https://127.0.0.1", "Sec-Fetch-Site: cross-site"]
    {
        assert_eq!(get(&token, &format!("{own}{other}\r\n")), 403, "{other}");
    }
    for path in
        ["states/", "states/-1", "states/1", "states/99999999999999999999", "../scene.csv", "%2e%2e/etc/passwd", "x"]
    {
        assert_eq!(live.get(path).0, 404, "{path}");
    }
    let send = |kind: &str, body: &str| {
        let length = body.len();
        live.status(
            format!("POST {token}command HTTP/1.1\r\nHost: {host}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n\r\n{body}")
                .as_bytes(),
        )
    };
    assert_eq!(send("text/plain", "\"resume\""), 415);
    assert_eq!(send("application/json", "{"), 400);
    assert_eq!(send("application/json", "\"explode\""), 400);
    assert_eq!(send("application/json", &format!("{{\"set\":{{\"signal\":\"{SIGNAL}\",\"value\":1e999}}}}")), 400);
    assert_eq!(send("application/json", &format!("{{\"set\":{{\"signal\":\"{SIGNAL}\",\"value\":null}}}}")), 400);
    assert_eq!(live.command(&json!({ "set": { "signal": SIGNAL, "value": 0.0041 } })), 409);
    assert_eq!(live.command(&json!({ "set": { "signal": "time", "value": 1 } })), 409);
    let other = live.status(format!("DELETE {token} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
    assert_eq!(other, 405);
    live.set(0.004);
    let after = events.until(|news| news["signals"][0]["value"] == 0.004);
    assert!(after["waiting"] == true && after["states"] == news["states"], "{after}");
}
