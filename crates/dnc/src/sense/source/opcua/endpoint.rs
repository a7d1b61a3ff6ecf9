//! Choice of the endpoint of a server.

use opcua::core::comms::url::hostname_port_from_url;
use opcua::crypto::SecurityPolicy;
use opcua::types::{EndpointDescription, MessageSecurityMode, UserTokenPolicy, UserTokenType};

/// Standard port.
const PORT: u16 = 4840;

/// Returns host and port of an address; the standard port if it has none.
pub(super) fn host_and_port(url: &str) -> Option<(String, u16)> {
    hostname_port_from_url(url, PORT).ok().filter(|(host, port)| !host.is_empty() && *port != 0)
}

/// Returns the endpoint without encryption that accepts such a user: the one that the address names, else the first one. Its host and port are taken from the
/// address, as the server may use a name that is not known here.
pub(super) fn choose(
    url: &str,
    endpoints: Vec<EndpointDescription>,
    kind: UserTokenType,
) -> Result<EndpointDescription, String> {
    let (host, port) = host_and_port(url).ok_or("this is not an address")?;
    let mut plain: Vec<EndpointDescription> = endpoints
        .into_iter()
        .filter(|one| {
            one.security_mode == MessageSecurityMode::None && one.endpoint_url.as_ref().starts_with("opc.tcp://")
        })
        .collect();
    if plain.is_empty() {
        return Err("the server has no endpoint without encryption".into());
    }
    for one in &mut plain {
        let has_certificate = !one.server_certificate.is_null_or_empty();
        if let Some(policies) = &mut one.user_identity_tokens {
            policies.retain(|policy| policy.token_type == kind && is_usable(policy, has_certificate));
            // A password is encrypted if the server offers it.
            policies.sort_by_key(is_plain);
        }
    }
    plain.retain(|one| one.find_policy(kind).is_some());
    let at = plain.iter().position(|one| path(one.endpoint_url.as_ref()) == path(url)).unwrap_or(0);
    if plain.is_empty() {
        let who = if kind == UserTokenType::Anonymous { "anonymous users" } else { "a user with a password" };
        return Err(format!("the server accepts no login: it has no endpoint without encryption for {who}"));
    }
    let mut endpoint = plain.swap_remove(at);
    endpoint.endpoint_url = format!("opc.tcp://{host}:{port}{}", path(endpoint.endpoint_url.as_ref())).into();
    Ok(endpoint)
}

/// Returns the path after host and port.
fn path(url: &str) -> &str {
    let rest = url.strip_prefix("opc.tcp://").unwrap_or(url);
    rest.find('/').map_or("", |at| &rest[at..]).trim_end_matches('/')
}

/// True if a policy does not encrypt passwords.
fn is_plain(policy: &UserTokenPolicy) -> bool {
    let uri = policy.security_policy_uri.as_ref();
    uri.is_empty() || SecurityPolicy::from_uri(uri) == SecurityPolicy::None
}

/// True if the client supports a policy.
fn is_usable(policy: &UserTokenPolicy, has_certificate: bool) -> bool {
    let uri = policy.security_policy_uri.as_ref();
    is_plain(policy) || (has_certificate && SecurityPolicy::from_uri(uri) != SecurityPolicy::Unknown)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: &str = "http://opcfoundation.org/UA/SecurityPolicy#None";
    const BASIC: &str = "http://opcfoundation.org/UA/SecurityPolicy#Basic256Sha256";

    fn policy(id: &str, kind: UserTokenType, uri: &str) -> UserTokenPolicy {
        UserTokenPolicy {
            policy_id: id.into(),
            token_type: kind,
            security_policy_uri: uri.into(),
            ..UserTokenPolicy::default()
        }
    }

    fn endpoint(url: &str, is_plain: bool, policies: Vec<UserTokenPolicy>) -> EndpointDescription {
        let (uri, mode) =
            if is_plain { (NONE, MessageSecurityMode::None) } else { (BASIC, MessageSecurityMode::SignAndEncrypt) };
        EndpointDescription::from((url, uri, mode, policies))
    }

    fn chosen(url: &str, endpoints: &[EndpointDescription], kind: UserTokenType) -> Result<(String, String), String> {
        let endpoint = choose(url, endpoints.to_vec(), kind)?;
        let policy = endpoint.find_policy(kind).unwrap().policy_id.to_string();
        Ok((endpoint.endpoint_url.to_string(), policy))
    }

    #[test]
    fn addresses_are_those_of_the_binary_protocol() {
        let host = |url| host_and_port(url).map(|(host, port)| format!("{host} {port}"));
        assert_eq!(host("opc.tcp://plc").as_deref(), Some("plc 4840"));
        assert_eq!(host("opc.tcp://192.168.0.5:4841/a/b").as_deref(), Some("192.168.0.5 4841"));
        assert_eq!(host("opc.tcp://[fe80::1]:4841").as_deref(), Some("[fe80::1] 4841"));
        let wrong =
            ["", "plc:4840", "http://plc:4840", "opc.tcp://", "opc.tcp:plc", "opc.tcp://:4840", "opc.tcp://plc:x"];
        for url in wrong.into_iter().chain(["opc.tcp://plc:99999", "opc.tcp://plc:0", "opc.tcp:///a", "opc.tcp://a b"])
        {
            assert_eq!(host(url), None, "{url}");
        }
    }

    #[test]
    fn an_endpoint_without_encryption_is_taken_under_the_address_that_is_known_here() {
        let anybody = || vec![policy("open", UserTokenType::Anonymous, "")];
        let url = "opc.tcp://10.0.0.5:14840/b";
        let all = [
            endpoint("opc.tcp://plc.local:4840/a", false, anybody()),
            endpoint("https://plc.local/a", true, anybody()),
            endpoint("opc.tcp://plc.local:4840/a/", true, anybody()),
            endpoint("opc.tcp://plc.local:4840/b/", true, anybody()),
        ];
        let anonymous = UserTokenType::Anonymous;
        assert_eq!(chosen(url, &all, anonymous), Ok(("opc.tcp://10.0.0.5:14840/b".into(), "open".into())));
        assert_eq!(chosen(url, &all[..3], anonymous), Ok(("opc.tcp://10.0.0.5:14840/a".into(), "open".into())));
        let no = "the server has no endpoint without encryption";
        assert_eq!(chosen(url, &all[..2], anonymous).unwrap_err(), no);
        assert!(chosen(url, &all, UserTokenType::UserName).unwrap_err().starts_with("the server accepts no login"));
    }

    #[test]
    fn a_password_is_encrypted_where_the_server_can() {
        let user = UserTokenType::UserName;
        let url = "opc.tcp://plc:4840";
        let policies = || vec![policy("own", user, "urn:own"), policy("plain", user, ""), policy("basic", user, BASIC)];
        let mut one = [endpoint(url, true, policies())];
        assert_eq!(chosen(url, &one, user), Ok((url.into(), "plain".into())), "there is no certificate");
        one[0].server_certificate = vec![1, 2, 3].into();
        assert_eq!(chosen(url, &one, user), Ok((url.into(), "basic".into())));
        one[0].user_identity_tokens = Some(vec![policy("own", user, "urn:own")]);
        assert!(chosen(url, &one, user).is_err());
    }
}
