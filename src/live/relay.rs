//! One address for the cases of a study, each of which serves its live view in a process of its own.
//!
//! Connections are forwarded to the case that is shown: of the cases that compute now, the one that has computed longest. Its page stays with it until it
//! ends.

use super::board::{Board, Opening};
use super::response::STALLED_PART;
use super::server::{Access, CONNECTIONS, Counted, Listener, Served, Site};
use crate::math::threads::locked;
use std::io;
use std::net::{Ipv4Addr, Shutdown, TcpStream};
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, Mutex, MutexGuard};

/// Page that is shown while no case computes; the browser reloads it.
const WAITING: &str = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"2\">\
                       <title>Durometer</title></head><body><p>No case computes at this moment. This page looks again every two seconds.</p></body></html>\n";

/// Forwards connections to the case that is shown.
pub struct Relay {
    access: Access,
    /// Cases with their ports, in the order in which they began
    cases: Mutex<Vec<(String, u16)>>,
    connections: AtomicUsize,
}

impl Relay {
    /// Serves a port in a thread of its own; `None` if the system cannot start a thread.
    pub fn serve(listener: Listener) -> Option<(Arc<Self>, Served)> {
        let board = Arc::new(Board::new(Opening::default()));
        board.open(WAITING.into());
        let access = listener.access().clone();
        let site = Arc::new(Site::new(&access, board));
        let relay = Arc::new(Self { access, cases: Mutex::default(), connections: AtomicUsize::new(0) });
        let (own, waiting) = (relay.clone(), site.clone());
        let served = listener.accept(site, move |client| own.take(client, &waiting))?;
        Some((relay, served))
    }

    /// Returns the access that all cases share.
    pub fn access(&self) -> &Access {
        &self.access
    }

    /// Records that a case serves its live view at this port, or with `None` that it no longer does.
    pub fn follow(&self, case: &str, port: Option<u16>) {
        let mut cases = self.cases();
        cases.retain(|(id, _)| id != case);
        cases.extend(port.map(|port| (case.to_string(), port)));
    }

    fn cases(&self) -> MutexGuard<'_, Vec<(String, u16)>> {
        locked(&self.cases)
    }

    /// Forwards a connection to the case that is shown, or to the waiting page if there is none.
    fn take(self: &Arc<Self>, client: TcpStream, waiting: &Arc<Site>) {
        let Some(port) = self.cases().first().map(|(_, port)| *port) else {
            return Site::take(waiting, client);
        };
        let own = self.clone();
        let serve = move || {
            if let Some(_one) = Counted::below(&own.connections, CONNECTIONS) {
                hand_on(client, port).ok();
            }
        };
        // If no thread can be started, the connection is closed
        std::thread::Builder::new().name("live relay".into()).spawn(serve).ok();
    }
}

/// Copies data in both directions until one side disconnects or accepts no more.
fn hand_on(mut client: TcpStream, port: u16) -> io::Result<()> {
    let mut case = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
    client.set_write_timeout(Some(STALLED_PART))?;
    let (mut from, mut to) = (client.try_clone()?, case.try_clone()?);
    let questions = std::thread::Builder::new().spawn(move || {
        io::copy(&mut from, &mut to).ok();
        to.shutdown(Shutdown::Write).ok();
    });
    let answered = questions.and_then(|_| io::copy(&mut case, &mut client));
    // The thread that copies the requests ends with the connections
    client.shutdown(Shutdown::Both).ok();
    case.shutdown(Shutdown::Both).ok();
    answered.map(drop)
}
