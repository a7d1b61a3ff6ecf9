//! Ctrl-C and other stop signals during a transfer.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::cli::stop::Stop;

/// Ctrl-C and other stop signals.
pub(in crate::cli) struct Keys(Arc<AtomicBool>);

impl Keys {
    pub(in crate::cli) fn new() -> Result<Keys, Stop> {
        let pressed = Arc::new(AtomicBool::new(false));
        let signals = [
            signal_hook::consts::SIGINT,
            signal_hook::consts::SIGTERM,
            #[cfg(unix)]
            signal_hook::consts::SIGHUP,
        ];
        for signal in signals {
            signal_hook::flag::register(signal, Arc::clone(&pressed))
                .map_err(|error| Stop::Usage(format!("cannot catch Ctrl-C: {error}")))?;
        }
        Ok(Keys(pressed))
    }

    pub(in crate::cli) fn pressed(&self) -> bool {
        self.0.swap(false, Ordering::Relaxed)
    }
}
