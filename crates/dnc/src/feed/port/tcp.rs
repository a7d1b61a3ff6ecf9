//! Port over TCP: terminal servers, controls with a network socket.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

use super::OpenPort;
use crate::feed::Port;

/// Timeout of a connection attempt.
const CONNECT: Duration = Duration::from_secs(5);

struct Tcp(TcpStream);

/// Connects to `host:port`.
pub(super) fn open(address: &str) -> Result<OpenPort, String> {
    let fault = |error: &io::Error| format!("cannot connect to {address}: {error}");
    let addresses = address.to_socket_addrs().map_err(|error| fault(&error))?;
    let mut last = format!("{address} has no address");
    for address in addresses {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => {
                // Lines are sent without waiting for further ones.
                stream.set_nodelay(true).and_then(|()| stream.set_nonblocking(true)).map_err(|error| fault(&error))?;
                return Ok(OpenPort { port: Box::new(Tcp(stream)), notes: Vec::new() });
            }
            Err(error) => last = fault(&error),
        }
    }
    Err(last)
}

impl Port for Tcp {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self.0.read(into) {
            Ok(0) if !into.is_empty() => Err(ErrorKind::UnexpectedEof.into()),
            other => nothing_now(other),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        nothing_now(self.0.write(bytes))
    }

    fn wait(&mut self, most: Duration) {
        // An error here occurs again at the next read.
        let most = most.max(Duration::from_micros(1));
        if self.0.set_read_timeout(Some(most)).is_ok() && self.0.set_nonblocking(false).is_ok() {
            let _ = self.0.peek(&mut [0]);
        }
        let _ = self.0.set_nonblocking(true);
    }
}

fn nothing_now(result: io::Result<usize>) -> io::Result<usize> {
    match result {
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted | ErrorKind::TimedOut) => {
            Ok(0)
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;
    use std::time::Instant;

    #[test]
    fn bytes_go_both_ways_and_an_end_is_a_fault() {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut port = open(&server.local_addr().unwrap().to_string()).unwrap().port;
        let (mut peer, _) = server.accept().unwrap();
        let mut heard = [0; 8];
        assert_eq!(port.read(&mut heard).unwrap(), 0);
        assert_eq!(port.write(b"G1\n").unwrap(), 3);
        peer.read_exact(&mut heard[..3]).unwrap();
        peer.write_all(b"ok\n").unwrap();
        let from = Instant::now();
        port.wait(Duration::from_secs(20));
        assert!(from.elapsed() < Duration::from_secs(10));
        assert_eq!(port.read(&mut heard).unwrap(), 3);
        drop(peer);
        port.wait(Duration::from_secs(20));
        assert_eq!(port.read(&mut heard).unwrap_err().kind(), ErrorKind::UnexpectedEof);
    }

    #[test]
    fn a_port_without_a_server_is_refused_with_its_name() {
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        assert!(open(&free.to_string()).err().unwrap().contains(&free.to_string()));
    }
}
