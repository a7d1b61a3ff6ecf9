//! Examples that stand below the help of commands.

pub(super) const CHECK: &str = "\
Examples:
  ncfix check part.mpf
  ncfix check part.nc --dialect fanuc --machine mill.toml --json
  ncfix check SAVE.arc/PART.MPF";

pub(super) const SNC: &str = "\
Examples:
  ncfix snc part.mpf | head
  ncfix snc part.pm --machine mill.toml -o part.snc";

pub(super) const VERIFY: &str = "\
Examples:
  ncfix verify part.mpf part_corrected.mpf --machine mill.toml
  ncfix verify part.mpf part_corrected.mpf --machine mill.toml --state warm.toml --load 1700";

pub(super) const MACHINE: &str = "\
Examples:
  ncfix machine check mill.toml
  ncfix machine show mill.toml --at X100,Y50,Z-20 --tool 120
  ncfix machine presets mayer-13 --machine mill.toml";

pub(super) const SHOW: &str = "\
Examples:
  ncfix machine show mill.toml
  ncfix machine show mill.toml --at X100,Y50,Z-20,C30 --tool 120 --sense X+,Y-
  ncfix machine show mill.toml --at X100,Y50,Z-20 --state warm.toml --load 1700@0,0,-280 --json

Sources: geometry (location and motion errors), coupling (functions of two axes), reversal (backlash, lateral play), load (weight of the \
workpiece), structure (segments that warm up), drift (weighted temperatures), expansion (scales, workpiece). Deviations are those of the tool \
relative to the workpiece, along the axes of F.";

pub(super) const PRESETS: &str = "\
Examples:
  ncfix machine presets
  ncfix machine presets 84 --machine mill.toml";

pub(super) const EXPLAIN: &str = "\
Examples:
  ncfix explain E0203
  ncfix explain";
