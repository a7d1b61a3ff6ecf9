//! A sensor that comes and goes while a job runs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use super::cli_feed::passes;
use super::controls::{Faults, Grbl, Wired};
use super::support::Shop;

/// A router whose Z drifts with one sensor.
const ROUTER: &str = "[machine]\nname = \"router\"\ntopology = \"wFYXZSt\"\ncontroller = \"rs274\"\n\
    [control]\nincrement_mm = 0.001\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 900]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-80, 0]\n\
    [[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_head\", um_per_K = 4.0 }]\n\
    [zero_offset.G54]\nX_mm = 100\nY_mm = 100\nZ_mm = -60\n";
const SENSORS: &str = "poll_s = 0.05\nmax_age_s = 30\nconfirm = 1\nmedian = 1\n\
    [source.head]\nkind = \"file\"\nmode = \"value\"\npath = \"head\"\n[channel.T_head]\nsource = \"head\"\n";

/// The plug is loose: a second with a value, half a second without one, over and over. The fault is reported when it first comes, and counted afterwards.
#[test]
fn a_loose_plug_is_reported_once_and_counted() {
    let shop = Shop::new().file("part.ngc", passes(20)).file("s.toml", SENSORS).file("router.toml", ROUTER);
    std::fs::write(shop.path("head"), "24.0\n").unwrap();
    let is_over = Arc::new(AtomicBool::new(false));
    let (over, path) = (Arc::clone(&is_over), shop.path("head"));
    let plug = thread::spawn(move || {
        for step in 0_u64.. {
            if over.load(Ordering::Relaxed) {
                break;
            }
            // 999 °C is out of range.
            let text = if step % 15 < 10 { "24.0\n" } else { "999\n" };
            // A reader never sees half a file.
            std::fs::write(path.with_extension("new"), text).unwrap();
            std::fs::rename(path.with_extension("new"), &path).unwrap();
            thread::sleep(Duration::from_millis(100));
        }
    });
    let bench = Wired::at_line(Grbl::new(&Faults::default(), 0.03));
    let arguments = ["feed", "part.ngc", "--machine", "router.toml", "--link", "grbl", "--port", &bench.name];
    let run = shop.run(arguments.iter().chain(&["--sensors", "s.toml"])).exits(0);
    is_over.store(true, Ordering::Relaxed);
    plug.join().unwrap();
    assert_eq!(run.stderr.matches("sensor readings are doubtful").count(), 1, "{}", run.stderr);
    let last =
        run.stderr.lines().find(|line| line.starts_with("sensor T_head: ")).unwrap_or_else(|| panic!("{}", run.stderr));
    let (count, rest) = last["sensor T_head: ".len()..].split_once(" times without a good reading, ").unwrap();
    assert!((2..40).contains(&count.parse::<u32>().unwrap()), "{last}");
    let (from, to) = rest.strip_suffix(" UTC").unwrap().split_once(" to ").unwrap();
    let seconds =
        |clock: &str| clock.split(':').map(|part| part.parse::<i64>().unwrap()).fold(0, |sum, part| 60 * sum + part);
    // Some seconds pass between the first and the last one, also at midnight.
    assert!((1..600).contains(&(seconds(to) - seconds(from)).rem_euclid(86400)), "{last}");
}
