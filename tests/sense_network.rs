//! Sources of live readings over a network, against servers that are written here from the specifications; and that all documented examples are read.

use std::collections::BTreeMap;
use std::io::{self, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::sense::{ChannelFault, ChannelState, Config, Panel, SensorSources};

use crate::sense_files::{open, until, until_fault, until_value};
use crate::support::repository;

/// A server on a port of its own; each connection has a thread, all end with it.
struct Server {
    port: u16,
    is_over: Arc<AtomicBool>,
    connections: Arc<AtomicUsize>,
}

impl Server {
    fn new(serve: impl Fn(TcpStream) -> io::Result<()> + Send + Sync + 'static) -> Server {
        Server::at(0, serve)
    }

    fn at(port: u16, serve: impl Fn(TcpStream) -> io::Result<()> + Send + Sync + 'static) -> Server {
        let listener = TcpListener::bind(("127.0.0.1", port)).unwrap();
        let port = listener.local_addr().unwrap().port();
        let (is_over, connections) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
        let (over, count, serve) = (Arc::clone(&is_over), Arc::clone(&connections), Arc::new(serve));
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                if over.load(Ordering::SeqCst) {
                    return;
                }
                count.fetch_add(1, Ordering::SeqCst);
                stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
                let serve = Arc::clone(&serve);
                std::thread::spawn(move || serve(stream));
            }
        });
        Server { port, is_over, connections }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::SeqCst);
        // Wakes the listener, which lets its port go.
        let _ = TcpStream::connect(("127.0.0.1", self.port));
    }
}

/// Rules that let single values through at once, and a source of a channel `T`.
fn fast(source: &str, channel: &str) -> String {
    format!(
        "poll_s = 0.05\nconfirm = 1\nmedian = 1\nmax_rate_K_per_min = 10000\n[source.s]\n{source}\n[channel.T]\nsource = \"s\"\n{channel}\n"
    )
}

fn note(panel: &Panel) -> String {
    panel.channels().next().unwrap().note.clone()
}

// MTConnect.

/// An agent that answers with what lies in its box: status and body.
fn agent(answer: &Arc<Mutex<(u16, String)>>, requests: &Arc<Mutex<Vec<String>>>) -> Server {
    let (answer, requests) = (Arc::clone(answer), Arc::clone(requests));
    Server::new(move |mut stream| {
        loop {
            let mut request = Vec::new();
            while !request.ends_with(b"\r\n\r\n") {
                let mut byte = [0];
                stream.read_exact(&mut byte)?;
                request.push(byte[0]);
            }
            let request = String::from_utf8_lossy(&request).into_owned();
            requests.lock().unwrap().push(request.lines().next().unwrap_or_default().to_owned());
            let (status, body) = answer.lock().unwrap().clone();
            let head =
                format!("HTTP/1.1 {status} X\r\nContent-Type: text/xml\r\nContent-Length: {}\r\n\r\n", body.len());
            stream.write_all(head.as_bytes())?;
            stream.write_all(body.as_bytes())?;
        }
    })
}

/// A document of streams as agents write it.
fn streams(version: &str, instance: u32, samples: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<MTConnectStreams xmlns:m=\"urn:mtconnect.org:MTConnectStreams:{version}\" \
         xmlns=\"urn:mtconnect.org:MTConnectStreams:{version}\">\n<Header creationTime=\"2026-03-01T08:00:00Z\" sender=\"shop\" \
         instanceId=\"{instance}\" version=\"{version}.0.0\" bufferSize=\"131072\" nextSequence=\"42\" firstSequence=\"1\" lastSequence=\"41\"/>\n\
         <Streams><DeviceStream name=\"mill-3\" uuid=\"m3\"><ComponentStream component=\"Rotary\" name=\"S\" componentId=\"s1\"><Samples>\
         {samples}</Samples><Events><Availability dataItemId=\"a\" timestamp=\"2026-03-01T08:00:00Z\" sequence=\"1\">AVAILABLE</Availability>\
         </Events></ComponentStream></DeviceStream></Streams></MTConnectStreams>"
    )
}

fn temperature(id: &str, name: &str, value: &str) -> String {
    format!(
        "<Temperature dataItemId=\"{id}\" name=\"{name}\" timestamp=\"2026-01-01T00:00:00.000Z\" sequence=\"7\">{value}</Temperature>"
    )
}

#[test]
fn an_agent_is_asked_for_its_current_values() {
    let answer = Arc::new(Mutex::new((
        200,
        streams("1.3", 1, &(temperature("t1", "Tspindle", "27.5") + &temperature("t2", "T2", "30"))),
    )));
    let requests = Arc::default();
    let server = agent(&answer, &requests);
    let set = |status: u16, body: String| *answer.lock().unwrap() = (status, body);
    let source = format!(
        "kind = \"mtconnect\"\naddress = \"http://127.0.0.1:{}\"\ndevice = \"mill 3\"\npath = \"//DataItem[@type=\\\"TEMPERATURE\\\"]\"",
        server.port
    );
    let mut panel = open(&fast(&source, "item = \"t1\""), std::path::Path::new(""));
    until_value(&mut panel, 27.5);
    assert_eq!(
        requests.lock().unwrap()[0],
        "GET /mill%203/current?path=%2F%2FDataItem%5B%40type%3D%22TEMPERATURE%22%5D HTTP/1.1"
    );
    // Another version, the name instead of the id, a value that has come by now.
    set(200, streams("2.4", 1, &temperature("other", "t1", "28.5")));
    until_value(&mut panel, 28.5);
    set(200, streams("2.4", 1, &temperature("t1", "Tspindle", "UNAVAILABLE")));
    until_fault(&mut panel, ChannelFault::Invalid);
    assert_eq!(panel.channels().next().unwrap().value_c, Some(28.5), "the last good value");
    set(200, streams("2.4", 1, &temperature("t1", "Tspindle", "28.6")));
    until_value(&mut panel, 28.6);
    set(200, streams("2.4", 1, &temperature("t9", "T9", "21")));
    until(&mut panel, "no such item", |readings| readings[0].note.contains("no data item t1"));
    set(200, streams("2.4", 1, &(temperature("t1", "A", "21") + &temperature("t7", "t1", "22"))));
    until(&mut panel, "two of them", |readings| readings[0].note.contains("several data items t1"));
    // A restart: one answer is left out.
    let count = |requests: &Arc<Mutex<Vec<String>>>| requests.lock().unwrap().len();
    set(200, streams("2.4", 2, &temperature("t1", "Tspindle", "29.5")));
    until(&mut panel, "restart", |readings| {
        readings[0].note.contains("restarted") || readings[0].value_c == Some(29.5)
    });
    until_value(&mut panel, 29.5);
    // What is no answer.
    let errors = "<MTConnectError xmlns=\"urn:mtconnect.org:MTConnectError:1.3\"><Header instanceId=\"2\"/><Errors><Error \
                  errorCode=\"NO_DEVICE\">Could not find the device</Error></Errors></MTConnectError>";
    set(404, errors.to_owned());
    until(&mut panel, "an error", |readings| readings[0].note == "the agent reports: Could not find the device");
    for (status, body) in [
        (200, "<html><body>Login</body></html>".to_owned()),
        (200, String::new()),
        (500, streams("1.3", 2, "")),
        (200, "<a".repeat(1000)),
    ] {
        let before = count(&requests);
        set(status, body);
        until(&mut panel, "asked again", |_| count(&requests) > before + 2);
        until_fault(&mut panel, ChannelFault::Disconnected);
    }
    set(200, streams("1.3", 2, &temperature("t1", "Tspindle", "29.7")));
    until_value(&mut panel, 29.7);
    drop(server);
}

#[test]
fn an_agent_counts_by_the_time_of_its_observation_where_that_is_asked_for() {
    let answer = Arc::new(Mutex::new((200, streams("1.3", 1, &temperature("t1", "T", "27.5")))));
    let server = agent(&answer, &Arc::default());
    let source = format!("kind = \"mtconnect\"\naddress = \"http://127.0.0.1:{}/\"\nuse_time = true", server.port);
    let mut panel = open(&fast(&source, "item = \"t1\""), std::path::Path::new(""));
    until(&mut panel, "old", |readings| readings[0].note.contains(" s old"));
    assert_eq!(panel.channels().next().unwrap().value_c, None);
}

#[test]
fn an_agent_that_hangs_or_is_away_is_disconnected() {
    let server = Server::new(|mut stream| {
        let mut bytes = [0; 1024];
        while stream.read(&mut bytes)? > 0 {}
        Ok(())
    });
    let source = format!("kind = \"mtconnect\"\naddress = \"http://127.0.0.1:{}\"\ntimeout_s = 0.3", server.port);
    let mut panel = open(&fast(&source, ""), std::path::Path::new(""));
    until(&mut panel, "time-out", |readings| readings[0].note.contains("timeout"));
    let start = Instant::now();
    drop(panel);
    assert!(start.elapsed() < Duration::from_secs(5));
    let mut panel = open(&fast("kind = \"mtconnect\"\naddress = \"http://127.0.0.1:9\"", ""), std::path::Path::new(""));
    until(&mut panel, "refused", |readings| readings[0].note.starts_with("http://127.0.0.1:9/current: "));
}

// Modbus.

/// Registers by function and address, and the exceptions that stand for some.
#[derive(Default)]
struct Registers {
    words: BTreeMap<(u8, u16), u16>,
    /// What is done instead of answering well.
    fault: Option<&'static str>,
}

/// A server after section 4 of the guide for messages on TCP/IP.
fn coupler(port: u16, registers: &Arc<Mutex<Registers>>) -> Server {
    let registers = Arc::clone(registers);
    Server::at(port, move |mut stream| {
        loop {
            let mut header = [0; 7];
            stream.read_exact(&mut header)?;
            assert_eq!(header[2..4], [0, 0], "protocol");
            let length = usize::from(u16::from_be_bytes([header[4], header[5]]));
            let mut request = vec![0; length - 1];
            stream.read_exact(&mut request)?;
            let [function, a, b, c, d] = request[..] else { panic!("{request:?}") };
            let (address, count) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
            let registers = registers.lock().unwrap();
            let words: Option<Vec<u16>> =
                (0..count).map(|step| registers.words.get(&(function, address + step)).copied()).collect();
            let mut answer = match words {
                Some(words) => {
                    let bytes = words.iter().flat_map(|word| word.to_be_bytes());
                    [function, 2 * count as u8].into_iter().chain(bytes).collect()
                }
                None => vec![function | 0x80, 2],
            };
            let mut transaction = [header[0], header[1]];
            match registers.fault {
                Some("other transaction") => transaction[1] ^= 1,
                Some("other function") => answer[0] = 1,
                Some("short") => {
                    answer.truncate(2);
                }
                Some("cut") => return stream.write_all(&transaction),
                Some("long") => answer.resize(400, 0),
                _ => {}
            }
            let length = (answer.len() as u16 + 1).to_be_bytes();
            let head = [transaction[0], transaction[1], 0, 0, length[0], length[1], header[6]];
            drop(registers);
            // In two parts, as networks do.
            stream.write_all(&head[..3])?;
            stream.flush()?;
            stream.write_all(&head[3..])?;
            stream.write_all(&answer)?;
        }
    })
}

fn modbus(port: u16, channel: &str) -> String {
    fast(&format!("kind = \"modbus\"\naddress = \"127.0.0.1:{port}\"\ntimeout_s = 0.5"), channel)
}

#[test]
fn registers_are_read_in_all_their_manners() {
    let registers: Arc<Mutex<Registers>> = Arc::default();
    // 21.5 as a number of 32 bits is 0x41AC0000; -5.5 °C in tenths is 0xFFC9; 21500 is 0x000053FC.
    let words = [
        ((4, 10), 0xFFC9),
        ((4, 20), 0x41AC),
        ((4, 21), 0x0000),
        ((4, 30), 0x0000),
        ((4, 31), 0x41AC),
        ((3, 40), 0x53FC),
        ((3, 50), 0x0000),
        ((3, 51), 0x53FC),
        ((3, 52), 0x53FC),
        ((3, 53), 0x0000),
    ];
    registers.lock().unwrap().words.extend(words);
    let server = coupler(0, &registers);
    for (channel, expected_c) in [
        ("address = 10\ntype = \"i16\"\nscale = 0.1", -5.5),
        ("address = 20\ntype = \"f32\"", 21.5),
        ("address = 30\ntype = \"f32\"\nwords = \"low_first\"", 21.5),
        ("address = 40\ntype = \"u16\"\ntable = \"holding\"\nunit = \"mC\"", 21.5),
        ("address = 50\ntype = \"u32\"\ntable = \"holding\"\nunit = \"mC\"", 21.5),
        ("address = 52\ntype = \"i32\"\ntable = \"holding\"\nunit = \"mC\"\nwords = \"low_first\"", 21.5),
    ] {
        until_value(&mut open(&modbus(server.port, channel), std::path::Path::new("")), expected_c);
    }
}

#[test]
fn what_a_coupler_says_instead_of_a_value_is_a_fault() {
    let registers: Arc<Mutex<Registers>> = Arc::default();
    let set = |address: u16, word: u16| {
        registers.lock().unwrap().words.insert((4, address), word);
    };
    set(10, 215);
    let server = coupler(0, &registers);
    let port = server.port;
    let keys = "address = 10\ntype = \"i16\"\nscale = 0.1";
    let mut panel = open(&modbus(port, keys), std::path::Path::new(""));
    until_value(&mut panel, 21.5);
    set(10, 0x8000);
    until_fault(&mut panel, ChannelFault::Invalid);
    assert_eq!(note(&panel), "register 10 has -32768: the device has no value");
    set(10, 216);
    until_value(&mut panel, 21.6);
    registers.lock().unwrap().words.clear();
    until(&mut panel, "exception", |readings| readings[0].note.contains("illegal data address (exception 2)"));
    set(10, 217);
    until_value(&mut panel, 21.7);
    for fault in ["other transaction", "other function", "short", "cut", "long"] {
        registers.lock().unwrap().fault = Some(fault);
        until_fault(&mut panel, ChannelFault::Disconnected);
        registers.lock().unwrap().fault = None;
        until_value(&mut panel, 21.7);
    }
    // Unsigned: the same word with another meaning, also where its address is off by one.
    set(11, 0x8000);
    let mut panel = open(&modbus(port, "address = 11\ntype = \"u16\"\nunit = \"mC\""), std::path::Path::new(""));
    until(&mut panel, "no value", |readings| readings[0].note.contains("has 32768"));
    let mut panel =
        open(&modbus(port, "address = 11\ntype = \"u16\"\nunit = \"mC\"\ninvalid = [0]"), std::path::Path::new(""));
    until_value(&mut panel, 32.768);
    // Gone, and back on the same port.
    let mut panel = open(&modbus(port, keys), std::path::Path::new(""));
    until_value(&mut panel, 21.7);
    let used = server.connections.load(Ordering::SeqCst);
    until(&mut panel, "several polls", |_| true);
    assert!(server.connections.load(Ordering::SeqCst) <= used + 1, "one connection for all polls");
}

// MQTT.

/// What the broker keeps, and who listens.
#[derive(Default)]
struct Broker {
    retained: BTreeMap<String, Vec<u8>>,
    listeners: Vec<(Vec<String>, TcpStream)>,
    client_ids: Vec<String>,
}

/// A packet of MQTT 3.1.1: its first byte and what follows (2.2).
fn packet(stream: &mut TcpStream) -> io::Result<(u8, Vec<u8>)> {
    let mut first = [0];
    stream.read_exact(&mut first)?;
    let (mut length, mut shift) = (0_usize, 0);
    loop {
        let mut byte = [0];
        stream.read_exact(&mut byte)?;
        length |= usize::from(byte[0] & 0x7F) << shift;
        shift += 7;
        if byte[0] & 0x80 == 0 {
            break;
        }
    }
    let mut body = vec![0; length];
    stream.read_exact(&mut body)?;
    Ok((first[0], body))
}

/// Texts have two bytes of length before them (1.5.3).
fn text(body: &[u8]) -> (String, &[u8]) {
    let length = usize::from(u16::from_be_bytes([body[0], body[1]]));
    (String::from_utf8(body[2..2 + length].to_vec()).unwrap(), &body[2 + length..])
}

/// PUBLISH of quality 0 (3.3); bodies here are shorter than 128 bytes.
fn publish(topic: &str, payload: &[u8], retain: bool) -> Vec<u8> {
    let length = u8::try_from(2 + topic.len() + payload.len()).unwrap();
    assert!(length < 128);
    let mut bytes = vec![0x30 | u8::from(retain), length];
    bytes.extend((topic.len() as u16).to_be_bytes());
    bytes.extend(topic.bytes());
    bytes.extend(payload);
    bytes
}

fn broker(port: u16, state: &Arc<Mutex<Broker>>) -> Server {
    let state = Arc::clone(state);
    Server::at(port, move |mut stream| {
        let (first, body) = packet(&mut stream)?;
        assert_eq!(first, 0x10, "CONNECT comes first (3.1)");
        let (protocol, rest) = text(&body);
        assert_eq!((protocol.as_str(), rest[0], rest[1] & 2), ("MQTT", 4, 2), "protocol level 4, clean session");
        state.lock().unwrap().client_ids.push(text(&rest[4..]).0);
        stream.write_all(&[0x20, 2, 0, 0])?;
        loop {
            let (first, body) = packet(&mut stream)?;
            match first {
                0x82 => {
                    let mut topics = Vec::new();
                    let mut rest = &body[2..];
                    while !rest.is_empty() {
                        let (topic, behind) = text(rest);
                        rest = &behind[1..];
                        topics.push(topic);
                    }
                    let codes: Vec<u8> = topics.iter().map(|topic| if topic == "secret" { 0x80 } else { 0 }).collect();
                    stream.write_all(&[0x90, 2 + codes.len() as u8, body[0], body[1]])?;
                    stream.write_all(&codes)?;
                    let mut state = state.lock().unwrap();
                    for (topic, payload) in state.retained.iter().filter(|(topic, _)| topics.contains(topic)) {
                        stream.write_all(&publish(topic, payload, true))?;
                    }
                    state.listeners.push((topics, stream.try_clone()?));
                }
                0xC0 => stream.write_all(&[0xD0, 0])?,
                0xE0 => return Ok(()),
                other => panic!("packet {other:#x}"),
            }
        }
    })
}

impl Broker {
    fn send(state: &Arc<Mutex<Broker>>, topic: &str, payload: &str) {
        let mut state = state.lock().unwrap();
        for (_, stream) in state.listeners.iter_mut().filter(|(topics, _)| topics.iter().any(|one| one == topic)) {
            let _ = stream.write_all(&publish(topic, payload.as_bytes(), false));
        }
    }
}

fn mqtt(port: u16, channel: &str) -> Panel {
    open(&fast(&format!("kind = \"mqtt\"\naddress = \"127.0.0.1:{port}\""), channel), std::path::Path::new(""))
}

fn now_s(ago_s: u64) -> u64 {
    std::time::SystemTime::now().duration_since(std::time::SystemTime::UNIX_EPOCH).unwrap().as_secs() - ago_s
}

#[test]
fn a_kept_message_counts_only_with_a_young_time_of_its_own() {
    let state: Arc<Mutex<Broker>> = Arc::default();
    let keep = |topic: &str, payload: String| state.lock().unwrap().retained.insert(topic.into(), payload.into_bytes());
    keep("plain", "21.5".into());
    keep("young", format!("{{\"value\": 22.5, \"time\": {}}}", now_s(5)));
    keep("old", format!("{{\"value\": 23.5, \"time\": {}}}", now_s(3600)));
    keep("ahead", format!("{{\"value\": 24.5, \"time\": {}}}", now_s(0) + 3600));
    let server = broker(0, &state);
    let text = format!(
        "poll_s = 0.05\nconfirm = 1\n[source.s]\nkind = \"mqtt\"\naddress = \"127.0.0.1:{}\"\n{}",
        server.port,
        ["plain", "young", "old", "ahead", "secret"]
            .map(|topic| format!("[channel.{topic}]\nsource = \"s\"\ntopic = \"{topic}\"\n"))
            .concat()
    );
    let mut panel = open(&text, std::path::Path::new(""));
    until(&mut panel, "all have come", |readings| {
        readings[1].state == ChannelState::Good
            && readings.iter().enumerate().all(|(index, one)| index == 1 || !one.note.is_empty())
    });
    let readings: Vec<_> = panel.channels().cloned().collect();
    assert_eq!(readings.iter().map(|one| one.value_c).collect::<Vec<_>>(), [None, Some(22.5), None, None, None]);
    assert!((5.0..60.0).contains(&readings[1].age.unwrap().as_secs_f64()), "{:?}", readings[1].age);
    assert!(readings[0].note.contains("retained message"), "{}", readings[0].note);
    assert!(readings[2].note.contains(" s old"), "{}", readings[2].note);
    assert!(readings[3].note.contains("in the future"), "{}", readings[3].note);
    assert_eq!(readings[4].note, "the broker refuses the topic secret");
    // The same value, said now, counts.
    Broker::send(&state, "plain", "21.5");
    until_value(&mut panel, 21.5);
}

#[test]
fn messages_are_numbers_or_values_of_objects() {
    let state: Arc<Mutex<Broker>> = Arc::default();
    let server = broker(0, &state);
    let mut panel = mqtt(server.port, "topic = \"head\"\nkey = \"air.temperature\"");
    until(&mut panel, "subscribed", |_| !state.lock().unwrap().listeners.is_empty());
    Broker::send(&state, "head", "{\"air\": {\"temperature\": 21.25, \"humidity\": 40}}");
    until_value(&mut panel, 21.25);
    for payload in ["21.5", "{\"air\": 1}", "{\"air\": {\"temperature\": null}}", "", "\u{0}\u{1}"] {
        Broker::send(&state, "head", payload);
        until_fault(&mut panel, ChannelFault::Invalid);
        Broker::send(&state, "head", "{\"air\": {\"temperature\": 21.5}}");
        until_value(&mut panel, 21.5);
    }
}

#[test]
fn a_broker_that_goes_and_comes_is_found_again() {
    let state: Arc<Mutex<Broker>> = Arc::default();
    let server = broker(0, &state);
    let port = server.port;
    let mut panel = mqtt(port, "topic = \"head\"");
    until(&mut panel, "subscribed", |_| !state.lock().unwrap().listeners.is_empty());
    Broker::send(&state, "head", "21.5");
    until_value(&mut panel, 21.5);
    // Thrown out: the connection ends, the broker stays.
    let listeners = std::mem::take(&mut state.lock().unwrap().listeners);
    listeners.iter().for_each(|(_, stream)| stream.shutdown(std::net::Shutdown::Both).unwrap());
    until_fault(&mut panel, ChannelFault::Disconnected);
    until(&mut panel, "subscribed again", |_| !state.lock().unwrap().listeners.is_empty());
    Broker::send(&state, "head", "{\"value\": 21.75}");
    until_value(&mut panel, 21.75);
    let other = mqtt(port, "topic = \"head\"");
    until(&mut panel, "the other", |_| state.lock().unwrap().client_ids.len() == 3);
    let ids = state.lock().unwrap().client_ids.clone();
    assert!(ids[0] == ids[1] && ids[0] != ids[2], "{ids:?}");
    drop(other);
    drop(server);
}

// OPC UA.

#[cfg(feature = "opcua")]
mod opc_ua {
    use super::*;

    fn source(port: u16, keys: &str) -> String {
        let source = format!("kind = \"opcua\"\nurl = \"opc.tcp://127.0.0.1:{port}\"\ntimeout_s = 0.2\n{keys}");
        fast(&source, "node = \"ns=2;s=T\"")
    }

    #[test]
    fn what_is_no_server_is_a_fault_and_keeps_nobody_waiting() {
        // An acknowledgement of 4 GiB, one that is too short, and an error without a text.
        let answers: [(&[u8], usize); 7] = [
            (b"", 0),
            (b"HTTP/1.1 400 Bad Request\r\n\r\n", 1),
            (b"ACKF\xff\xff\xff\xff", 1),
            (b"ACKF\x08\0\0\0", 1),
            (b"ERRF\x10\0\0\0\0\0\x7d\x80\xff\xff\xff\xff", 1),
            (b"MSGF\x0c\0\0\0\0\0\0\0", 1),
            (b"\0", 4 << 20),
        ];
        for (answer, times) in answers {
            for is_held in [true, false] {
                let server = Server::new(move |mut stream| {
                    let mut hello = [0; 8];
                    stream.read_exact(&mut hello)?;
                    assert_eq!(&hello[..4], b"HELF");
                    for _ in 0..times {
                        stream.write_all(answer)?;
                    }
                    // Open until the other side closes it.
                    while is_held && stream.read(&mut [0; 512])? > 0 {}
                    Ok(())
                });
                let mut panel = open(&source(server.port, ""), std::path::Path::new(""));
                until(&mut panel, "a fault", |readings| !readings[0].note.is_empty());
                assert!(note(&panel).starts_with("opc.tcp://127.0.0.1:"), "{}", note(&panel));
                assert_eq!(panel.channels().next().unwrap().value_c, None);
                until(&mut panel, "another try", |_| server.connections.load(Ordering::SeqCst) > 1);
                let start = Instant::now();
                drop(panel);
                assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
            }
        }
    }

    #[test]
    fn a_server_that_is_not_there_is_tried_again() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        drop(listener);
        let mut panel = open(&source(port, ""), std::path::Path::new(""));
        until(&mut panel, "a fault", |readings| readings[0].note.contains("refused"));
        let server = Server::at(port, |_| Ok(()));
        until(&mut panel, "another try", |_| server.connections.load(Ordering::SeqCst) > 0);
    }

    #[test]
    fn a_password_is_that_of_the_environment() {
        let keys = "user = \"u\"\npassword_env = \"NCFIX_TEST_NO_SUCH_VARIABLE\"";
        let text = source(1, keys);
        let text = Source::new(FileId(0), "S.toml", text.into_bytes()).unwrap();
        let config = Config::read(&text).unwrap();
        let findings = Panel::open(&config, std::path::Path::new("")).err().unwrap();
        let why = "the password: the environment variable NCFIX_TEST_NO_SUCH_VARIABLE is not set";
        assert_eq!(findings[0].message, why);
        // A user without a password is one.
        let server = Server::new(|_| Ok(()));
        drop(open(&source(server.port, "user = \"u\""), std::path::Path::new("")));
    }
}

// Examples.

fn read(name: &str, text: &str) -> Result<Config, Vec<String>> {
    let source = Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap();
    Config::read(&source).map_err(|findings| findings.iter().map(|finding| finding.message.clone()).collect())
}

#[test]
fn all_examples_and_samples_are_read() {
    let page = std::fs::read_to_string(repository("docs/reference/sensors.md")).unwrap();
    let mut kinds = Vec::new();
    for block in page.split("```toml\n").skip(1) {
        let text = block.split("```").next().unwrap();
        match read("docs/reference/sensors.md", text) {
            Ok(config) => kinds.extend(config.sources.iter().map(|origin| origin.kind.name().to_owned())),
            Err(messages) => {
                // Off by default; nothing else is wrong with an example.
                let missing: &[&str] =
                    if cfg!(feature = "opcua") { &[] } else { &["this ncfix was built without opcua"] };
                assert_eq!(messages, missing, "{text}");
                kinds.push("opcua".to_owned());
            }
        }
    }
    assert!(SensorSources::default().names().all(|name| kinds.iter().any(|kind| kind == name)), "{kinds:?}");
    let mut samples = 0;
    for entry in std::fs::read_dir(repository("samples/sensors")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            samples += 1;
            let config = read("sample", &std::fs::read_to_string(&path).unwrap());
            assert!(config.is_ok(), "{}: {:?}", path.display(), config.err());
        }
    }
    assert!(samples >= 3);
    // The first one can be tried as it is.
    let text = std::fs::read_to_string(repository("samples/sensors/replay.toml")).unwrap();
    let mut panel = open(&text, &repository("samples/sensors"));
    panel.take(Duration::from_secs(360));
    // An hour: 21 + 9 (1 - e^-2) and 20.5 + 1.5 (1 - e^-0.4), medians of three rows.
    let values: Vec<f64> = panel.channels().map(|reading| reading.value_c.unwrap()).collect();
    assert!((values[0] - 28.78).abs() < 0.1 && (values[1] - 20.99).abs() < 0.02, "{values:?}");
}
