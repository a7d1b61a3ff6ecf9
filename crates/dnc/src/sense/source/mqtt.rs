//! Messages of an MQTT broker (3.1.1, without TLS).
//!
//! A broker sends a retained message to every new subscriber, and the message does not say how old it is. Such a value counts only if it contains its own
//! time.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, SystemTime};

use rumqttc::{Client, Event, MqttOptions, Packet, Publish, QoS, SubscribeFilter, SubscribeReasonCode};
use serde_json::Value;

use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::file::Section;

use super::super::lines::{LONGEST_LINE, inside, plain, told};
use super::super::monitor::{ChannelFault, SourceReport};
use super::super::outlet::ReadingOutlet;
use super::super::stamp::stamp;
use super::{Kind, OpenedSource, SourcePlan, Wanted, host_and_port};

/// Standard port.
const PORT: u16 = 1883;
/// Interval at which a connection without messages shows that it is alive; a thread ends within this time.
const KEEP_ALIVE: Duration = Duration::from_secs(5);
/// Time between two connection attempts: initial and maximum.
const TRY_AGAIN: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(30)];

pub(super) const KIND: Kind =
    Kind { name: "mqtt", title: "messages of an MQTT broker", is_record: false, is_standard_input: false, read };

/// Topic of a channel.
#[derive(Clone, Debug)]
struct Topic {
    channel: usize,
    topic: String,
    /// Key of the value in an object. If absent, the message is a number, or an object with `value`.
    key: Option<String>,
}

#[derive(Clone, Debug)]
struct Settings {
    host: String,
    port: u16,
    username: Option<String>,
    password_file: Option<String>,
    has_times: bool,
    topics: Vec<Topic>,
}

fn read(section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
    let address = host_and_port(section, PORT);
    let username = section.text("username").map(str::to_owned);
    let password_file = section.text("password_file").map(str::to_owned);
    let has_times = section.boolean("use_time").unwrap_or(true);
    let topics = wanted.iter_mut().filter_map(|wanted| read_topic(wanted.index, &mut wanted.section)).collect();
    let address = address?;
    let (host, port) = address.rsplit_once(':')?;
    let port = port.parse().ok()?;
    let host = host.trim_start_matches('[').trim_end_matches(']').to_owned();
    Some(Arc::new(Settings { host, port, username, password_file, has_times, topics }))
}

fn read_topic(channel: usize, section: &mut Section<'_>) -> Option<Topic> {
    let topic = section.required("topic", "\"shop/mill/T_head\"", Section::text);
    let key = section.text("key").map(str::to_owned);
    let topic = topic?.to_owned();
    if topic.is_empty() || topic.contains(['#', '+', '\0']) || topic.len() > 1024 {
        let help = "a channel has one topic, without # and +";
        section.report(Code::BAD_VALUE, section.place_of("topic"), format!("'{topic}' is not a topic"), help);
    }
    Some(Topic { channel, topic, key })
}

impl SourcePlan for Settings {
    fn open(&self, base: &Path, _: Duration) -> Result<OpenedSource, String> {
        let settings = self.clone();
        let password_file = self.password_file.as_ref().map(|path| base.join(path));
        Ok(OpenedSource::Thread(Box::new(move |outlet| settings.run(password_file.as_ref(), &outlet))))
    }
}

impl Settings {
    fn run(&self, password_file: Option<&PathBuf>, outlet: &ReadingOutlet) {
        // Two clients with the same name disconnect each other.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let started = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().subsec_nanos();
        let own = format!("ncfix-{:x}-{:x}-{:x}", std::process::id(), started, COUNT.fetch_add(1, Ordering::Relaxed));
        let mut options = MqttOptions::new(own, &self.host, self.port);
        options.set_keep_alive(KEEP_ALIVE).set_clean_session(true).set_max_packet_size(LONGEST_LINE, LONGEST_LINE);
        if let Some(username) = &self.username {
            let password = match password_file.map(fs::read_to_string).transpose() {
                Ok(password) => password.unwrap_or_default(),
                Err(error) => return outlet.fail(ChannelFault::Disconnected, &format!("the password file: {error}")),
            };
            options.set_credentials(username, password.trim_end());
        }
        let (client, mut connection) = Client::new(options, 16);
        let [mut pause, longest] = TRY_AGAIN;
        while !outlet.is_over() {
            match connection.recv() {
                Ok(Ok(Event::Incoming(Packet::ConnAck(_)))) => {
                    pause = TRY_AGAIN[0];
                    // A clean session ends with the connection: everything is subscribed again.
                    let filters =
                        self.topics.iter().map(|one| SubscribeFilter::new(one.topic.clone(), QoS::AtMostOnce));
                    if client.try_subscribe_many(filters).is_err() {
                        outlet.fail(ChannelFault::Disconnected, "the topics cannot be subscribed to");
                    }
                }
                Ok(Ok(Event::Incoming(Packet::SubAck(answer)))) => {
                    for (topic, code) in self.topics.iter().zip(&answer.return_codes) {
                        if *code == SubscribeReasonCode::Failure {
                            let why = format!("the broker refuses the topic {}", topic.topic);
                            outlet.tell(topic.channel, SourceReport::Nothing(ChannelFault::Disconnected, why), None);
                        }
                    }
                }
                Ok(Ok(Event::Incoming(Packet::Publish(message)))) => self.hear(&message, outlet),
                Ok(Ok(_)) => {}
                Ok(Err(error)) => {
                    outlet.fail(ChannelFault::Disconnected, &format!("{}:{}: {error}", self.host, self.port));
                    if !outlet.wait(pause) {
                        break;
                    }
                    pause = longest.min(2 * pause);
                }
                Err(_) => break,
            }
        }
    }

    fn hear(&self, message: &Publish, outlet: &ReadingOutlet) {
        let text = String::from_utf8_lossy(&message.payload);
        let object = serde_json::from_str::<Value>(&text).ok().filter(Value::is_object);
        let time =
            object.as_ref().and_then(|object| ["time", "timestamp", "ts"].iter().find_map(|key| object.get(*key)));
        let stamp = time.filter(|_| self.has_times).and_then(|time| stamp(&plain(time)));
        for topic in self.topics.iter().filter(|one| one.topic == message.topic) {
            let value = match (&object, &topic.key) {
                (None, None) => Some(text.trim().to_owned()),
                (Some(object), key) => inside(object, key.as_deref().unwrap_or("value")).map(plain),
                (None, Some(_)) => None,
            };
            let told = match value {
                _ if message.retain && stamp.is_none() => {
                    SourceReport::Nothing(ChannelFault::Retained, "it is a retained message of unknown age".into())
                }
                Some(value) => told(&value),
                None => {
                    let key = topic.key.as_deref().unwrap_or("value");
                    SourceReport::Nothing(ChannelFault::Invalid, format!("the message has no {key}"))
                }
            };
            outlet.tell(topic.channel, told, stamp);
        }
    }
}
