//! Feeds a control line by line. Z drifts with the temperature of the spindle head, which a custom sensor measures.
#![allow(clippy::print_stdout, reason = "an example shows what it found")]
use std::io::{self, Read as _, Write as _};
use std::sync::{Arc, Mutex};

use ncfix::prelude::*;
use ncfix::sensors::{self, Items, OpenedSource, Section, SensorSource, SensorSources, SourcePlan, Wanted, from_text};

/// A custom sensor that reads 30 °C on every channel.
#[derive(Clone, Debug)]
struct Thermometer(Items);

#[rustfmt::skip]
impl SensorSource for Thermometer {
    fn name(&self) -> &str { "thermometer" }
    fn title(&self) -> &str { "a custom thermometer" }
    fn read(&self, _: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
        Some(Arc::new(Thermometer(sensors::items(wanted))))
    }
}

impl SourcePlan for Thermometer {
    fn open(&self, _: &std::path::Path, every: std::time::Duration) -> Result<OpenedSource, String> {
        let channels = self.0.clone();
        Ok(OpenedSource::Thread(Box::new(move |outlet| {
            while !outlet.is_over() {
                channels.iter().for_each(|(_, one)| outlet.tell(*one, sensors::SourceReport::Value(30.0), None));
                let _ = outlet.wait(every);
            }
        })))
    }
}

/// A control with a tape reader: it sends XON once and stores the received bytes.
struct Tape(io::Cursor<[u8; 1]>, Arc<Mutex<Vec<u8>>>);

#[rustfmt::skip]
impl Port for Tape {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> { self.0.read(into) }
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> { self.1.lock().unwrap_or_else(|e| e.into_inner()).write(bytes) }
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let drift = "[[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_head\", um_per_K = 2.0 }]\n";
    let machine = Machine::from_text("mill.toml", &[include_str!("../samples/machines/demo.toml"), drift].concat())?;
    let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F9000\nM30\n", DialectChoice::Sinumerik)?;
    let mut how = FeedOptions::default();
    (how.machine_stands_still, how.allow_starvation) = (true, true);
    let transfer = program.feed(&machine, ControlLink::named("siemens-v24")?, &Options::default(), how)?;

    let text = "[source.own]\nkind = \"thermometer\"\n[channel.T_head]\nsource = \"own\"\n";
    let sensors = from_text("sensors.toml", text, &SensorSources::default().with(Thermometer(Items::new())))?;
    let port = Box::new(Tape(io::Cursor::new([17]), Arc::default()));
    let journal = std::env::temp_dir().join(format!("ncfix_example_{}.journal", std::process::id()));
    let sent = transfer.send(port, Some(sensors), &journal)?;
    std::fs::remove_file(&journal)?;
    println!("{}", sent.status.table());
    assert!(sent.status.applied[&AxisKey::of_deviation(Axis::Z)] < -10.0, "10 K, 2 µm each: {:?}", sent.status.applied);
    Ok(())
}
