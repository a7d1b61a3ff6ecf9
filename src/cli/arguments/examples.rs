//! Examples at the end of the help of commands.

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

pub(in crate::cli) const MACHINE: &str = "\
Examples:
  ncfix machine check mill.toml
  ncfix machine show mill.toml --at X100,Y50,Z-20 --tool 120
  ncfix machine presets mayer-13 --machine mill.toml";

pub(in crate::cli) const SHOW: &str = "\
Sources: geometry (location and motion errors), coupling (functions of two axes), reversal (backlash, lateral play), load (weight of the \
workpiece), structure (thermal expansion of segments), drift (weighted temperatures), expansion (scales, workpiece). Deviations are those of the tool \
relative to the workpiece, along the axes of F.

--origin shows the source of every value: a line of the machine file or of a set-up file, or default.

Examples:
  ncfix machine show mill.toml
  ncfix machine show mill.toml --at X100,Y50,Z-20,C30 --tool 120 --sense X+,Y-
  ncfix machine show mill.toml --at X100,Y50,Z-20 --state warm.toml --load 1700@0,0,-280 --json
  ncfix machine show --origin --setup job.toml";

pub(in crate::cli) const NEW: &str = "\
On a terminal, ncfix asks for travels, directions and pivots that no option states. In a script it assumes the travels of the template, and marks them in the \
file. It never assumes the direction of a rotary axis or a point on it.

Examples:
  ncfix machine new --list
  ncfix machine new router.toml --like router --control grbl --travel X=-600..0 --travel Y=-900..0
  ncfix machine new mill.toml --like trunnion-ac --from mill.ini --picture mill.svg";

pub(in crate::cli) const PRESETS: &str = "\
Examples:
  ncfix machine presets
  ncfix machine presets 84 --machine mill.toml";

pub(super) const EXPLAIN: &str = "\
Examples:
  ncfix explain E0203
  ncfix explain touched zero
  ncfix explain";

pub(super) const COMPLETIONS: &str = "\
A shell reads the script when it starts: bash from ~/.local/share/bash-completion/completions/ncfix, zsh from a file _ncfix in a folder of $fpath, \
fish from ~/.config/fish/completions/ncfix.fish, PowerShell and elvish from a line in their profile.

Examples:
  ncfix completions bash > ~/.local/share/bash-completion/completions/ncfix
  source <(ncfix completions bash)
  ncfix completions fish > ~/.config/fish/completions/ncfix.fish";

pub(super) const MAN: &str = "\
Examples:
  ncfix man | man -l -
  ncfix man machine show | man -l -
  ncfix man -o /usr/local/share/man/man1";
