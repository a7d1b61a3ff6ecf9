//! A simulated control in real time, at a pseudo-terminal or a TCP port that the program under test opens.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serialport::{SerialPort as _, TTYPort};

use super::Control;

/// Nothing here takes longer.
const LONG: Duration = Duration::from_secs(60);
/// How long the control listens before it looks at its clock: short against the time of a block.
const LISTENING: Duration = Duration::from_micros(300);

/// A control that listens at a port in a thread of its own until it is dropped.
pub(crate) struct Wired<C> {
    /// Value of `--port`.
    pub(crate) name: String,
    pub(crate) shared: Arc<Mutex<C>>,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl<C: Control + Send + 'static> Wired<C> {
    /// At a pseudo-terminal.
    pub(crate) fn at_line(control: C) -> Wired<C> {
        let (mut master, slave) = TTYPort::pair().unwrap();
        let name = slave.name().unwrap();
        // Its other end is opened by the program under test.
        drop(slave);
        master.set_timeout(LISTENING).unwrap();
        Wired::at(control, name, move || Some(master))
    }

    /// At a TCP port: of a pseudo-terminal the program under test would inherit this end, too, and no cable could be cut.
    pub(crate) fn at_network(control: C) -> Wired<C> {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let name = format!("tcp:{}", server.local_addr().unwrap());
        Wired::at(control, name, move || {
            let (stream, _) = server.accept().ok()?;
            stream.set_read_timeout(Some(LISTENING)).ok()?;
            Some(stream)
        })
    }

    fn at<P: Read + Write>(control: C, name: String, open: impl FnOnce() -> Option<P> + Send + 'static) -> Wired<C> {
        let shared = Arc::new(Mutex::new(control));
        let is_over = Arc::new(AtomicBool::new(false));
        let (control, over) = (Arc::clone(&shared), Arc::clone(&is_over));
        let from = Instant::now();
        let thread = thread::spawn(move || {
            let mut port = open().unwrap();
            let mut bytes = [0; 4096];
            let mut said: Vec<u8> = Vec::new();
            while !over.load(Ordering::Relaxed) {
                // As long as nobody has opened the other end this fails.
                let count = port.read(&mut bytes).unwrap_or(0);
                let mut control = control.lock().unwrap();
                let now_s = from.elapsed().as_secs_f64();
                bytes[..count].iter().for_each(|byte| control.hear(*byte, now_s));
                control.tick(now_s);
                said.extend(control.say());
                drop(control);
                if !said.is_empty()
                    && let Ok(count) = port.write(&said)
                {
                    said.drain(..count);
                }
                if count == 0 && said.is_empty() {
                    thread::sleep(Duration::from_micros(100));
                }
            }
        });
        Wired { name, shared, is_over, thread: Some(thread) }
    }

    pub(crate) fn executed(&self) -> Vec<String> {
        let control = self.shared.lock().unwrap();
        control.executed().iter().map(|line| String::from_utf8(line.clone()).unwrap()).collect()
    }

    /// Waits until so many lines are carried out.
    pub(crate) fn wait_for(&self, count: usize) {
        let from = Instant::now();
        while self.executed().len() < count {
            assert!(from.elapsed() < LONG, "{} lines", self.executed().len());
            thread::sleep(Duration::from_millis(2));
        }
    }
}

impl<C> Drop for Wired<C> {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        let _ = self.thread.take().unwrap().join();
    }
}
