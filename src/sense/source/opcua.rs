//! Variables of an OPC UA server: the kind is known and says that it is not built in.
//!
//! A client in Rust brings some two hundred crates, more than all the rest together. Until one is worth that, `command` reads such a server with a
//! client of its maker, and gateways hand its variables to MQTT.

use super::{Kind, not_built_in};

pub(super) const KIND: Kind = Kind {
    name: "opcua",
    title: "variables of an OPC UA server",
    is_record: false,
    is_standard_input: false,
    read: |section, wanted| {
        let help = "read the server by a command, or through a gateway to MQTT or Modbus";
        not_built_in("OPC UA", help, section, wanted);
        None
    },
};
