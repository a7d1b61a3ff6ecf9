//! Standard input: lines of another program, `logger | ncfix sensors S.toml --watch`.

use std::io::{self, Read as _};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use ncfix_machine::machine::file::Section;

use super::super::lines::{LineReader, Splitter};
use super::{Items, Kind, OpenedSource, SourcePlan, Wanted, items};

pub(super) const KIND: Kind =
    Kind { name: "stdin", title: "lines on standard input", is_record: false, is_standard_input: true, read };

#[derive(Debug)]
struct Settings {
    has_times: bool,
    items: Items,
}

fn read(section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
    let has_times = section.boolean("use_time").unwrap_or(true);
    Some(Arc::new(Settings { has_times, items: items(wanted) }))
}

impl SourcePlan for Settings {
    fn open(&self, _: &Path, _: Duration) -> Result<OpenedSource, String> {
        let mut lines = LineReader::new(&self.items, self.has_times);
        Ok(OpenedSource::Thread(Box::new(move |outlet| {
            let (mut input, mut bytes, mut splitter) = (io::stdin(), [0; 1 << 12], Splitter::default());
            // A waiting read cannot be aborted; the thread ends with the next line, or with the program.
            while let Ok(count) = input.read(&mut bytes) {
                if count == 0 || outlet.is_over() {
                    return;
                }
                let mut tell = |channel, told, stamp| outlet.tell(channel, told, stamp);
                splitter.take(bytes.get(..count).unwrap_or_default(), &mut |line| lines.read(line, &mut tell));
            }
        })))
    }
}
