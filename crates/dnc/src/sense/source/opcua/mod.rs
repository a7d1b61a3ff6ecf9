//! Variables of an OPC UA server (opc.tcp, without encryption), read by the service Read; nothing is ever written.
//!
//! According to OPC 10000-4 (*Services*) and OPC 10000-6 (*Mappings*, 5.3.1.10: texts of nodes). Variables are read, not subscribed to. A server sends only
//! changes to a subscriber, so its silence may mean a steady temperature or a server that hangs. An answer to Read is current. Its source time stamp is that
//! of the last change, so a value is as old as the answer, unless the file says otherwise.
//!
//! The client is asynchronous; its runtime runs in the single thread of this source.

mod endpoint;
mod value;

use std::env;
use std::path::Path;
use std::str::FromStr as _;
use std::sync::Arc;
use std::time::Duration;

use opcua::client::{Client, ClientBuilder, IdentityToken, Session};
use opcua::types::{NodeId, ReadValueId, StatusCode, TimestampsToReturn, UserTokenType, VariableId};
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::file::Section;

use super::super::config::seconds;
use super::super::lines::shortened;
use super::super::monitor::ChannelFault;
use super::super::outlet::ReadingOutlet;
use super::{Kind, OpenedSource, SourcePlan, Wanted};
use endpoint::{choose, host_and_port};
use value::{halt, nothing, told};

/// Maximum number of variables per request; small servers do not accept more.
const MOST_AT_ONCE: usize = 32;
/// Maximum length of an answer, bytes.
const MOST_BYTES: usize = 1 << 20;
/// Lifetime of a channel, ms; it is renewed after three quarters of it. The clock of the server counts: if that is ahead by more, the channel ends once in
/// this time and is opened again.
const CHANNEL_MS: u32 = 3_600_000;
/// Time between two connection attempts: initial and maximum.
const TRY_AGAIN: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(30)];
/// Interval at which the source checks whether it must end.
const LOOK_UP: Duration = Duration::from_millis(50);
/// Maximum time for closing a session; many servers allow only a few sessions.
const FAREWELL: Duration = Duration::from_millis(150);

pub(super) const KIND: Kind =
    Kind { name: "opcua", title: "variables of an OPC UA server", is_record: false, is_standard_input: false, read };

#[derive(Clone, Debug)]
struct Settings {
    url: String,
    /// User name, and environment variable that holds the password.
    user: Option<(String, Option<String>)>,
    timeout: Duration,
    has_times: bool,
    nodes: Vec<(usize, NodeId)>,
}

fn read(section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
    let url = section.required("url", "\"opc.tcp://192.168.0.5:4840\"", Section::text).map(str::to_owned);
    if let Some(url) = url.as_ref().filter(|url| host_and_port(url).is_none()) {
        let help = "write opc.tcp:// and the name or number of the server, for example \"opc.tcp://192.168.0.5:4840\"";
        section.report(
            Code::BAD_VALUE,
            section.place_of("url"),
            format!("'{url}' is not an address of a server"),
            help,
        );
    }
    let user = section.text("user").map(str::to_owned);
    let variable = section.text("password_env").map(str::to_owned);
    if variable.as_ref().is_some_and(|name| name.is_empty() || name.contains(['=', '\0'])) {
        let help = "write the name of an environment variable, for example \"OPCUA_PASSWORD\"";
        section.report(Code::BAD_VALUE, section.place_of("password_env"), "password_env is not a name", help);
    }
    if variable.is_some() && user.is_none() {
        let message = format!("{} has a password but no user", section.title());
        section.report(Code::MISSING_KEY, section.place_of("password_env"), message, "add user = \"…\"");
    }
    let timeout = seconds(section, "timeout_s", 0.05).unwrap_or(Duration::from_secs(5));
    let has_times = section.boolean("use_time").unwrap_or(false);
    let nodes = wanted
        .iter_mut()
        .filter_map(|wanted| read_node(&mut wanted.section).map(|node| (wanted.index, node)))
        .collect();
    Some(Arc::new(Settings { url: url?, user: user.map(|user| (user, variable)), timeout, has_times, nodes }))
}

fn read_node(section: &mut Section<'_>) -> Option<NodeId> {
    let text = section.required("node", "\"ns=2;s=Machine.T_head\"", Section::text)?.to_owned();
    let node = NodeId::from_str(&text).ok();
    if node.is_none() {
        let message = format!("'{}' is not a node", shortened(&text));
        let help = "write ns=, the number of its namespace, and i= with a number, s= with a text, g= with a GUID or b= with Base64, for \
                    example \"ns=2;s=Machine.T_head\"";
        section.report(Code::BAD_VALUE, section.place_of("node"), message, help);
    }
    node
}

impl SourcePlan for Settings {
    fn open(&self, _: &Path, poll: Duration) -> Result<OpenedSource, String> {
        let token = match &self.user {
            None => IdentityToken::Anonymous,
            Some((user, None)) => IdentityToken::new_user_name(user, ""),
            Some((user, Some(variable))) => {
                let no = |_| format!("the password: the environment variable {variable} is not set");
                IdentityToken::new_user_name(user, env::var(variable).map_err(no)?)
            }
        };
        let reader = Reader { settings: self.clone(), token, link: None };
        Ok(OpenedSource::Thread(Box::new(move |outlet| reader.run(poll, &outlet))))
    }
}

struct Reader {
    settings: Settings,
    token: IdentityToken,
    link: Option<Link>,
}

/// Session, and the task that carries its messages.
struct Link {
    session: Arc<Session>,
    task: JoinHandle<StatusCode>,
}

impl Drop for Link {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Reader {
    fn run(mut self, poll: Duration, outlet: &ReadingOutlet) {
        let runtime = match tokio::runtime::Builder::new_current_thread().enable_all().build() {
            Ok(runtime) => runtime,
            Err(error) => {
                return outlet.fail(ChannelFault::Disconnected, &format!("cannot start the runtime: {error}"));
            }
        };
        runtime.block_on(async {
            tokio::select! {
                () = is_over(outlet) => {}
                () = self.go_on(poll, outlet) => {}
            }
            self.leave().await;
        });
        // A pending name look-up cannot be aborted; it is not waited for.
        runtime.shutdown_background();
    }

    /// Reads at each poll and reconnects if the connection is lost.
    async fn go_on(&mut self, poll: Duration, outlet: &ReadingOutlet) {
        let [mut pause, longest] = TRY_AGAIN;
        loop {
            let result = match self.poll(outlet).await {
                Ok(()) => {
                    pause = TRY_AGAIN[0];
                    self.rest(poll).await
                }
                Err(why) => Err(why),
            };
            if let Err(why) = result {
                outlet.fail(ChannelFault::Disconnected, &format!("{}: {why}", self.settings.url));
                self.leave().await;
                sleep(pause).await;
                pause = longest.min(2 * pause);
            }
        }
    }

    /// Waits for the next poll, or until the connection is lost.
    async fn rest(&mut self, poll: Duration) -> Result<(), String> {
        let Some(link) = &mut self.link else { return Ok(()) };
        match timeout(poll, &mut link.task).await {
            Ok(Ok(status)) if status.is_bad() => Err(format!("the connection is lost: {status}")),
            Ok(_) => Err("the connection is lost".into()),
            Err(_) => Ok(()),
        }
    }

    /// Ends the session.
    async fn leave(&mut self) {
        if let Some(link) = self.link.take().filter(|link| !link.task.is_finished()) {
            let _ = timeout(FAREWELL, link.session.disconnect()).await;
        }
    }

    /// Reads all variables once.
    async fn poll(&mut self, outlet: &ReadingOutlet) -> Result<(), String> {
        let link = match self.link.take() {
            Some(link) => link,
            None => within(self.settings.timeout, self.settings.connect(&self.token)).await?,
        };
        let session = Arc::clone(&self.link.insert(link).session);
        for nodes in self.settings.nodes.chunks(MOST_AT_ONCE) {
            // The state of the server is read with its values.
            let state = NodeId::from(VariableId::Server_ServerStatus_State);
            let ids: Vec<ReadValueId> = std::iter::once(&state)
                .chain(nodes.iter().map(|(_, node)| node))
                .map(|node| ReadValueId::from(node.clone()))
                .collect();
            // Maximum age 0: the server asks its source.
            let answer = within(self.settings.timeout, async {
                session.read(&ids, TimestampsToReturn::Both, 0.0).await.map_err(|error| error.to_string())
            });
            let answer = answer.await?;
            let [state, values @ ..] = answer.as_slice() else { return Err("the answer is empty".into()) };
            if values.len() != nodes.len() {
                return Err("the answer does not fit the request".into());
            }
            let halt = halt(state);
            for ((channel, node), value) in nodes.iter().zip(values) {
                let (told, stamp) = match &halt {
                    Some(why) => (nothing(why.clone()), None),
                    None => told(node, value, self.settings.has_times),
                };
                outlet.tell(*channel, told, stamp);
            }
        }
        Ok(())
    }
}

impl Settings {
    /// Asks the server for its endpoints and opens a session at one of them.
    async fn connect(&self, token: &IdentityToken) -> Result<Link, String> {
        let mut client = self.client()?;
        let endpoints =
            client.get_server_endpoints_from_url(self.url.as_str()).await.map_err(|error| error.to_string())?;
        let kind =
            if matches!(token, IdentityToken::Anonymous) { UserTokenType::Anonymous } else { UserTokenType::UserName };
        let endpoint = choose(&self.url, endpoints, kind)?;
        let (session, events) =
            client.connect_to_endpoint_directly(endpoint, token.clone()).map_err(|error| error.to_string())?;
        // A new connection needs a new session, which is opened here.
        session.disable_reconnects();
        let mut link = Link { session: Arc::clone(&session), task: events.spawn() };
        tokio::select! {
            _ = session.wait_for_connection() => Ok(link),
            ended = &mut link.task => Err(match ended {
                Ok(status) => format!("the server does not open a session: {status}"),
                Err(_) => "the server does not open a session".into(),
            }),
        }
    }

    fn client(&self) -> Result<Client, String> {
        let client = ClientBuilder::new()
            .application_name("ncfix")
            .application_uri("urn:ncfix")
            .product_uri("urn:ncfix")
            .session_name("ncfix")
            // Certificates are not used: no folders may be created for them, and this path cannot exist.
            .pki_dir("\0")
            .create_sample_keypair(false)
            .session_retry_limit(0)
            .request_timeout(self.timeout)
            .max_message_size(MOST_BYTES)
            .channel_lifetime(CHANNEL_MS)
            .recreate_subscriptions(false);
        client.client().map_err(|why| why.join(", "))
    }
}

/// Waits until the source must end.
async fn is_over(outlet: &ReadingOutlet) {
    while !outlet.is_over() {
        sleep(LOOK_UP).await;
    }
}

/// Runs work with a timeout.
async fn within<T>(time: Duration, work: impl Future<Output = Result<T, String>>) -> Result<T, String> {
    timeout(time, work).await.unwrap_or_else(|_| Err(format!("no answer within {} s", time.as_secs_f64())))
}
