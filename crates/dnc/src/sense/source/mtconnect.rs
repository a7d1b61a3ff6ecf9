//! MTConnect agent, polled with `/current` over HTTP.
//!
//! According to ANSI/MTC1.4-2018 Parts 1 and 2: observations are elements with the attributes `dataItemId`, `timestamp` and, if the device has one, `name`.
//! Their text is the value or `UNAVAILABLE`. The name space changes with each version, so only local names are compared. A restarted agent has another
//! `instanceId`.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::file::Section;

use super::super::config::seconds;
use super::super::lines::{shortened, told};
use super::super::monitor::{ChannelFault, SourceReport};
use super::super::outlet::ReadingOutlet;
use super::super::stamp::stamp;
use super::{Items, Kind, OpenedSource, Polled, SourcePlan, Wanted, items, polled};

/// Maximum length of an answer, bytes.
const MOST_BYTES: u64 = 8 << 20;

pub(super) const KIND: Kind =
    Kind { name: "mtconnect", title: "an MTConnect agent", is_record: false, is_standard_input: false, read };

#[derive(Clone, Debug)]
struct Settings {
    url: String,
    timeout: Duration,
    has_times: bool,
    items: Items,
}

fn read(section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
    let address = section.required("address", "\"http://192.168.0.5:5000\"", Section::text)?;
    if !address.starts_with("http://") || address.len() < 8 {
        let message = format!("'{address}' is not an address of an agent");
        let help = "write http:// and the name or number of the computer; agents are queried without encryption";
        section.report(Code::BAD_VALUE, section.place_of("address"), message, help);
    }
    let mut url = address.trim_end_matches('/').to_owned();
    if let Some(device) = section.text("device") {
        url = format!("{url}/{}", encoded(device));
    }
    url.push_str("/current");
    if let Some(path) = section.text("path") {
        url = format!("{url}?path={}", encoded(path));
    }
    let timeout = seconds(section, "timeout_s", 0.05).unwrap_or(Duration::from_secs(5));
    let has_times = section.boolean("use_time").unwrap_or(false);
    Some(Arc::new(Settings { url, timeout, has_times, items: items(wanted) }))
}

/// Encodes a text as part of an address, RFC 3986.
fn encoded(text: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    text.bytes()
        .map(|byte| if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") })
        .collect()
}

impl SourcePlan for Settings {
    fn open(&self, _: &Path, poll: Duration) -> Result<OpenedSource, String> {
        let config = ureq::Agent::config_builder()
            .timeout_global(Some(self.timeout))
            .http_status_as_error(false)
            .max_redirects(0)
            .proxy(None)
            .build();
        Ok(polled(Client { settings: self.clone(), agent: config.into(), instance: None }, poll))
    }
}

struct Client {
    settings: Settings,
    agent: ureq::Agent,
    /// Instance of the agent.
    instance: Option<String>,
}

impl Polled for Client {
    fn poll(&mut self, outlet: &ReadingOutlet) -> Result<(), String> {
        let no = |error: ureq::Error| format!("{}: {error}", self.settings.url);
        let mut response = self.agent.get(&self.settings.url).call().map_err(no)?;
        let status = response.status();
        let text = response.body_mut().with_config().limit(MOST_BYTES).read_to_string().map_err(no)?;
        let document = Document::read(&text).map_err(|why| format!("{}: {why}", self.settings.url))?;
        if let Some(error) = document.error {
            return Err(format!("the agent reports: {}", shortened(&error)));
        }
        if !status.is_success() {
            return Err(format!("{}: the answer is {status}", self.settings.url));
        }
        let before = self.instance.replace(document.instance.clone());
        if before.is_some_and(|before| before != document.instance) {
            return Err("the agent was restarted; its next answer is used".into());
        }
        for (item, channel) in &self.settings.items {
            let mut found = document.observations.iter().filter(|one| one.id == *item || one.name == *item);
            let (told, stamp) = match (found.next(), found.next()) {
                (Some(one), None) => (told(&one.text), stamp(&one.timestamp).filter(|_| self.settings.has_times)),
                (None, _) => (nothing(format!("the agent has no data item {item}")), None),
                (Some(_), Some(_)) => (nothing(format!("the agent has several data items {item}; give its id")), None),
            };
            outlet.tell(*channel, told, stamp);
        }
        Ok(())
    }
}

fn nothing(why: String) -> SourceReport {
    SourceReport::Nothing(ChannelFault::Invalid, why)
}

/// Answer of an agent.
#[derive(Debug, Default)]
struct Document {
    instance: String,
    observations: Vec<Observation>,
    error: Option<String>,
}

#[derive(Debug, Default)]
struct Observation {
    id: String,
    name: String,
    timestamp: String,
    text: String,
}

impl Document {
    fn read(text: &str) -> Result<Document, String> {
        let mut document = Document::default();
        let mut reader = Reader::from_str(text);
        let mut depth = 0_usize;
        // The observation or error whose text is being read, and its depth.
        let mut open: Option<(usize, Observation)> = None;
        let mut has_root = false;
        loop {
            match reader.read_event().map_err(|error| format!("this is not XML: {error}"))? {
                Event::Start(start) => {
                    depth += 1;
                    has_root |= document.begin(&start, depth)?;
                    if let Some(observation) = observation(&start)? {
                        open = Some((depth, observation));
                    }
                }
                Event::Empty(start) => {
                    has_root |= document.begin(&start, depth + 1)?;
                    document.observations.extend(observation(&start)?);
                }
                Event::Text(text) => {
                    if let Some((_, observation)) = open.as_mut().filter(|(at, _)| *at == depth) {
                        observation.text.push_str(&text.xml10_content());
                    }
                }
                Event::CData(text) => {
                    if let Some((_, observation)) = open.as_mut().filter(|(at, _)| *at == depth) {
                        observation.text.push_str(&text.xml10_content());
                    }
                }
                Event::End(_) => {
                    if let Some((_, observation)) = open.take_if(|(at, _)| *at == depth) {
                        if observation.id.is_empty() {
                            document.error = Some(observation.text);
                        } else {
                            document.observations.push(observation);
                        }
                    }
                    depth = depth.saturating_sub(1);
                }
                Event::Eof if depth == 0 && has_root => return Ok(document),
                Event::Eof => return Err("this is not a complete MTConnect document".into()),
                _ => {}
            }
        }
    }

    /// Handles the start of an element. Returns true if it is the root of a document of streams or errors.
    fn begin(&mut self, start: &BytesStart<'_>, depth: usize) -> Result<bool, String> {
        let name = local(start);
        if name == "Header" {
            self.instance = attribute(start, "instanceId")?.unwrap_or_default().into_owned();
        }
        if name == "MTConnectError" {
            self.error.get_or_insert_with(|| "an error without a text".into());
        }
        Ok(depth == 1 && (name == "MTConnectStreams" || name == "MTConnectError"))
    }
}

/// Returns the observation that begins with an element; one without an id is the text of an error.
fn observation(start: &BytesStart<'_>) -> Result<Option<Observation>, String> {
    if local(start) == "Error" {
        return Ok(Some(Observation::default()));
    }
    let Some(id) = attribute(start, "dataItemId")? else { return Ok(None) };
    let text = |name: &str| attribute(start, name).map(|found| found.unwrap_or_default().into_owned());
    Ok(Some(Observation {
        id: id.into_owned(),
        name: text("name")?,
        timestamp: text("timestamp")?,
        text: String::new(),
    }))
}

/// Returns the name of an element without its name space.
fn local(start: &BytesStart<'_>) -> String {
    let name = start.name();
    let text: &str = name.as_ref();
    text.rsplit(':').next().unwrap_or_default().to_owned()
}

fn attribute<'e>(start: &'e BytesStart<'_>, name: &str) -> Result<Option<Cow<'e, str>>, String> {
    for attribute in start.attributes() {
        let attribute = attribute.map_err(|error| format!("this is not XML: {error}"))?;
        let key: &str = attribute.key.as_ref();
        if key == name {
            let value = attribute.normalized_value(quick_xml::XmlVersion::default());
            return value.map(Some).map_err(|error| format!("this is not XML: {error}"));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn documents_are_read_whatever_their_name_space_and_order_of_attributes() {
        let text = "<?xml version=\"1.0\"?><m:MTConnectStreams xmlns:m=\"urn:mtconnect.org:MTConnectStreams:2.3\"><m:Header instanceId=\"17\"/>\
                    <m:Streams><m:Samples><m:Temperature timestamp=\"2024-02-29T12:00:00Z\" dataItemId=\"t1\" name=\"T&amp;1\"> 21.5\n</m:Temperature>\
                    <x:Own xmlns:x=\"urn:x\" dataItemId='t2'><![CDATA[UNAVAILABLE]]></x:Own><m:Temperature dataItemId=\"t3\"/></m:Samples>\
                    </m:Streams></m:MTConnectStreams>";
        let document = Document::read(text).unwrap();
        let seen: Vec<_> =
            document.observations.iter().map(|one| (one.id.as_str(), one.name.as_str(), one.text.trim())).collect();
        assert_eq!(seen, [("t1", "T&1", "21.5"), ("t2", "", "UNAVAILABLE"), ("t3", "", "")]);
        assert_eq!((document.instance.as_str(), document.error), ("17", None));
    }

    #[test]
    fn what_is_no_whole_document_is_refused() {
        let whole = "<MTConnectStreams><Header instanceId=\"1\"/><Streams><Temperature dataItemId=\"t\">21</Temperature></Streams></MTConnectStreams>";
        assert!(Document::read(whole).is_ok());
        for end in 0..whole.len() {
            assert!(Document::read(&whole[..end]).is_err(), "{}", &whole[..end]);
        }
        assert!(Document::read("<html><body>Welcome</body></html>").is_err());
        let error = "<MTConnectError><Header instanceId=\"1\"/><Errors><Error errorCode=\"NO_DEVICE\">no such device</Error></Errors></MTConnectError>";
        assert_eq!(Document::read(error).unwrap().error.as_deref(), Some("no such device"));
        assert_eq!(encoded("//DataItem[@type=\"T\"]"), "%2F%2FDataItem%5B%40type%3D%22T%22%5D");
    }
}
