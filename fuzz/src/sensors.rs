//! Live readings: the file that says where they come from, and the lines that come.

use std::time::Duration;

use ncfix_dnc::sense::{ChannelReading, Config, LineReader, Monitor, SourceReport, stamp};

use super::{check_findings, source};

/// A file of sensors.
pub fn config(bytes: &[u8]) {
    let file = source("sensors.toml", bytes);
    match Config::read(&file) {
        Err(findings) => {
            check_findings(&findings, &[&file]);
            assert!(findings.iter().any(|finding| finding.is_error()));
        }
        Ok(config) => {
            for origin in &config.sources {
                assert!(origin.channels.iter().all(|&channel| channel < config.channels.len()), "{origin:?}");
            }
        }
    }
}

/// Lines of a file, a command or a broker, of which a monitor believes nothing outside of its range.
pub fn lines(bytes: &[u8]) {
    const SENSORS: &str = "[source.a]\nkind = \"file\"\nfile = \"a.log\"\n\
        [channel.T_nose]\nsource = \"a\"\nitem = \"T_nose\"\nrange_C = [0, 60]\n[channel.T_head]\nsource = \"a\"\nitem = \"x.y\"\n";
    let config = Config::read(&source("sensors.toml", SENSORS.as_bytes()));
    let channels = config.map(|config| config.channels).unwrap_or_default();
    let mut monitors: Vec<Monitor> = channels.iter().map(Monitor::new).collect();
    let items = [("T_nose".to_owned(), 0), ("x.y".to_owned(), 1)];
    let mut lines = LineReader::new(&items, true);
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let now = Duration::from_secs(10 * number as u64);
        lines.read(line, &mut |channel, told, time| {
            assert!(channel < items.len());
            if let (SourceReport::Value(_), Some(monitor)) = (&told, monitors.get(channel)) {
                assert!(monitor.channel().name.starts_with('T'));
            }
            let age = Duration::from_secs(u64::from(time.is_some()));
            if let Some(monitor) = monitors.get_mut(channel) {
                monitor.hear(&told, age, now);
            }
        });
        for monitor in &mut monitors {
            monitor.tick(now);
            let mut reading = ChannelReading::default();
            monitor.show(now, &mut reading);
            let [low, high] = monitor.channel().range_c;
            assert!(reading.value_c.is_none_or(|value| (low..=high).contains(&value)), "{reading:?}");
        }
        let _ = stamp(&String::from_utf8_lossy(line));
    }
}
