//! Register of diagnostic codes: every code once, with its title and the long text that `ncfix explain` prints.
//!
//! Groups: `E01` syntax, `E02` execution, `E03` safety and machine limits, `E04` machine file and error model, `E05` state of the machine, `E06` measured
//! data, `E07` links, `E08` the cycle of a control, `E09` compensation tables; `W…` are these groups as warnings. Codes are stable; a code that is no longer
//! used stays retired. A test demands a sample file that provokes each code.

use std::fmt;

use super::Severity;

/// Stable diagnostic code such as `E0203`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Code(pub(super) &'static str);

/// Row of the register.
#[derive(Clone, Copy, Debug)]
pub struct CodeRow {
    /// Code.
    pub code: Code,
    /// Short title.
    pub title: &'static str,
    /// Long text: the meaning, why the program stops there, and what to do, with an example if useful.
    pub explain: &'static str,
}

impl Code {
    /// Returns the code as text.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        self.0
    }

    /// Returns the row of a code given as text in any case, such as `e0203`.
    #[must_use]
    pub fn find(text: &str) -> Option<&'static CodeRow> {
        CODES.iter().find(|row| row.code.0.eq_ignore_ascii_case(text))
    }

    /// Returns the severity, which follows from the first letter.
    #[must_use]
    pub fn severity(self) -> Severity {
        if self.0.starts_with('W') { Severity::Warning } else { Severity::Error }
    }

    /// True if the program text itself was not understood (exit status 3, not 4).
    #[must_use]
    pub fn is_language(self) -> bool {
        self.0.starts_with("E01") || self.0 == "E0201"
    }
}

impl fmt::Debug for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

macro_rules! codes {
    ($($name:ident = $code:literal $title:literal $explain:literal;)*) => {
        impl Code {
            $(#[doc = concat!("`", $code, "`: ", $title, ".")] pub const $name: Code = Code($code);)*
        }
        /// All codes, in order.
        pub const CODES: &[CodeRow] =
            &[$(CodeRow { code: Code::$name, title: $title, explain: $explain }),*];
    };
}

codes! {
    UNEXPECTED = "E0101" "unexpected text"
"The text at this place is no word, statement or expression of the dialect.

A common cause is a missing '=': in Sinumerik and Grundig programs a value that is no plain number needs one (X=R1*2, CR=5, S2=500,
X=E1). Another is a comment without ';' in a Sinumerik program, where ( ) belongs to expressions, or without ( ) in others.";
    BAD_NUMBER = "E0102" "malformed number"
"A number is digits with at most one decimal point; the exponent of a Sinumerik number is written EX, as in 1.5EX-3.
Numbers beyond the range of a double are refused too.";
    MISSING_VALUE = "E0103" "address without a value"
"An address letter (X, F, G, …) needs a number, or '=' and an expression, behind it.";
    BAD_EXPRESSION = "E0104" "malformed expression"
"The expression ends early or has something in it that is no operand or operator.";
    UNCLOSED = "E0105" "bracket or quotation mark not closed"
"A '(', '[' or '\"' that was opened in this block is not closed in it.";
    UNMATCHED_STRUCTURE = "E0106" "control structure not closed or not opened"
"IF needs ENDIF, WHILE needs ENDWHILE, FOR needs ENDFOR, LOOP needs ENDLOOP, REPEAT needs UNTIL, each in the same program
and properly nested. ELSE stands once between IF and ENDIF. WHILE ... DO1 of a custom macro needs END1 (with 1, 2 or 3), an O-word
of RS274/NGC its end with the same label: o100 sub and o100 endsub, o101 while and o101 endwhile.";
    TOO_DEEP = "E0107" "nested too deeply"
"Brackets in an expression may be nested 64 deep, control structures 32 deep. Controls allow far less.";
    MUST_STAND_ALONE = "E0108" "statement must stand alone in its block"
"Control statements, DEF, PROC, TRANS and ATRANS and calls share their block with nothing but the block number, a label and a
comment (TRANS also with its axis words).";
    BLOCK_TOO_LONG = "E0109" "block too long"
"A block has more than 4096 bytes. A Sinumerik 840D sl takes 512 characters. The file is probably no part program, or its line
ends were lost on the way.";
    NOT_A_PROGRAM = "E0110" "not a part program"
"The file is empty, or most of it cannot be read as blocks of the dialect. Check --dialect, and that the file is no archive,
picture or setting-data save.";
    DOUBLE_WORD = "E0111" "word given twice in one block"
"An address that takes effect once per block (an axis, F, a G code of one group …) was programmed twice in it. The control would
raise an alarm or use the last one, depending on its version; this program does not guess.";
    DOUBLE_NUMBER = "E0112" "block number given twice"
"Two blocks of a program or macro of a Grundig or MillPlus have the same N number. G14 repeats blocks and G29 jumps to blocks by their
number, so that it must be clear which one is meant; the control refuses such a program. Number the blocks anew.";
    EXPONENT = "E0115" "letter inside a number"
"Directly behind a number stands E with digits, as spreadsheets and some posts write small numbers. These languages have no exponents: the
control would read X1.5 and a word E, and go 1.5 mm instead of 15 nm.

  N10 G1 X1.5E-05         write X0.000015, or X0
  N20 G65 P9010 A1. E5    an argument E has a blank before it

Round the number in the post, or write it out.";
    OTHER_CONTROL = "E0118" "program of another control"
"The text is that of a control whose language this program does not read, or of another control than the machine file and --dialect say:
Heidenhain Klartext, Okuma OSP, a 3D printer, a Sinumerik program for a Fanuc. Where the words look alike they move the tool otherwise. The
message names what was found and where. Choose the right --machine or --dialect, or convert the program.";

    NOT_SUPPORTED = "E0201" "not supported yet"
"The program uses a code, statement, cycle or system variable that ncfix does not execute yet. It is refused because skipping it
could change the motion. The message names it.";
    NO_CENTER = "E0202" "arc without center or radius"
"G2 and G3 need a center (I, J, K, incremental from the start, or absolute with =AC()) or a radius (CR=).";
    ARC_OFF_CIRCLE = "E0203" "arc end is not on the circle"
"The radius at the start of the arc and the radius at its end differ by more than the control allows, or the center is off the
perpendicular bisector of the chord by more than that. The limit is the larger of control.arc_tolerance_mm and
control.arc_tolerance_ratio times the radius (Sinumerik MD21000 and MD21010, default 0.01 mm and 0.001).

  N10 G1 X0 Y0
  N20 G2 X10 Y0 I4 J0     start radius 4 mm, end radius 6 mm

Correct I and J, or the end point.";
    RADIUS_TOO_SMALL = "E0204" "arc radius smaller than half the chord"
"With CR= the two points must be at most 2 · CR apart. A full circle cannot be programmed with CR: start and end coincide and the
center is not determined; use I, J, K.";
    BAD_ARC = "E0205" "arc that is no arc"
"The center coincides with the start, center words lie outside the working plane, or center and CR were given together.";
    UNDEFINED_VARIABLE = "E0206" "variable not defined"
"The name is no variable that was defined with DEF in this program, no R parameter and no known function.";
    BAD_INDEX = "E0207" "index outside the array or parameter range"
"R parameters run from R0 to R9999; an array index from 0 to its length minus 1.";
    TYPE_MISMATCH = "E0208" "value of the wrong type"
"A number was expected and a string found, or the other way round, or a value cannot be converted (an INT is no fraction).";
    NOT_COMPUTABLE = "E0209" "expression has no value"
"Division by zero, root of a negative number, logarithm of zero, or a result beyond the range of a double.";
    BAD_WORD_VALUE = "E0210" "value not allowed for this word"
"A G, M, T, D, N, L or P number must be a whole number in range; a feed and a dwell must not be negative.";
    NO_TARGET = "E0211" "jump target not found"
"The label or block number does not occur in the direction of the search: GOTOF looks towards the end of this program, GOTOB towards
its start, never into other programs.";
    NO_SUBPROGRAM = "E0212" "subprogram not found"
"The called program is neither in this file (as a %_N_…_SPF section) nor beside it. Names searched: NAME.SPF, NAME.MPF, NAME, and the
same in lower case. L10 and L010 are different programs. A program that must run on the control itself (tool change, washing) is named
in the machine file; its call is passed on with its values:

  [[opaque]]
  name = \"TOOLCHANGE\"
  moves = true               the position behind it is unknown";
    TOO_MANY_CALLS = "E0213" "subprogram calls nested too deeply"
"A Sinumerik nests 16 program levels. A program that calls itself without end is refused here.";
    TOO_MANY_BLOCKS = "E0214" "more blocks executed than allowed"
"The program executed more blocks than --max-blocks. It may never end (WHILE TRUE, a backward jump). Raise --max-blocks if it does
end; nothing was written. ncfix simulate says so too where a program takes so long that its trace would have more than 20 million rows, or a chord of
a move more than an hour.";
    MISSING_FEED = "E0215" "feed motion without a feed"
"G1, G2 and G3 need F, programmed earlier or in the block. The control stops here.";
    DUPLICATE_NAME = "E0216" "name defined twice"
"A variable was defined twice in one program, or with the name of a function or keyword.";
    SKIPPED_INTO = "E0217" "jump into a control structure"
"A jump led into a FOR loop whose start was not executed, so its end value is unknown.";
    CYCLE_ALARM = "E0218" "alarm of a cycle"
"A built-in cycle (drilling, pockets …) cannot run with these arguments or this tool; the control would stop with the alarm of the same
number. The message says what is wrong. The cycles and what is known of each are listed in crates/language/cycles/README.md.";
    BAD_ARGUMENTS = "E0221" "arguments that do not fit the program"
"The call gives more arguments than the PROC block of the called program has parameters, or no variable for a VAR parameter, which
the called program changes.

  PROC HOLE(REAL DEPTH, VAR INT COUNT)      called as HOLE(-5, N_1) with DEF INT N_1";
    FULL_CIRCLE_UNSURE = "E0222" "full circle or hardly a move"
"Start and end of an arc are so near to each other that the resolution of the control decides whether it goes all the way round or hardly
moves. A control puts positions on a grid (Fanuc: increment system; Sinumerik: MD10200) before it compares them, so a full circle whose
start was computed may be left out, or a tiny arc may become a full circle.

  N10 G1 X0 Y-0.0004
  N20 G2 X0 Y0 I10 J0     a full circle on a grid of 0.001 mm, 0.4 µm on one of 0.0001 mm

Program the end of a full circle exactly at its start. For a Sinumerik state the resolution in the machine file: [control]
increments_per_mm = 1000.";
    NO_MOTION = "E0223" "program without a motion"
"The program was understood and moves no axis, so there is nothing to correct, and an output would only look like a success. Perhaps its blocks
stand behind the end of the program (M30), in a subprogram that nothing calls, behind skip blocks, or the file is cut off. Nothing was written.";
    MIXED_UNITS = "E0224" "inches and millimeters in one program"
"A Fanuc takes its tool and zero offsets for inches or millimeters by the unit in force, so a corrected program keeps the unit of the program. This one has both
G20 and G21: no single unit is that of all of it. Correct the parts as programs of their own, each with one unit.";
    BAD_SWIVEL = "E0235" "plane that cannot be swivelled"
"CYCLE800 (Sinumerik) or G53.1 (Fanuc) tilts the plane in a way that is not followed here, the rotary axes cannot put the tool on it, or it is not known where the
axes retract to. The message says which. The rotary axes and the frame that a swivel results in can always be programmed directly.";
    BAD_POLAR = "E0230" "polar position that is not clear"
"A polar position (AP=, RP=) shares its block with an axis of the plane, angle or radius was never given since the pole was set, the
plane was changed behind the pole, or G91 leaves open how the value is meant.

  G111 X40 Y20              pole
  G1 AP=30 RP=25            both in the first block behind it
  AP=IC(15)                 then either of them

Program the pole in the plane in force, and write AC(…) or IC(…) under G91.";

    NO_SYSTEM_VALUE = "E0219" "system variable without a value"
"The program reads a system variable whose value only the machine knows: machine data, an input, a measured position, the tool in the
spindle, an R parameter or a common variable that an earlier program has left. Where it decides what moves, it has to be known before. Give it in
the machine file, with the name and indices that the message shows:

  [system]
  \"$R[5]\" = 12.5
  \"$MN_INT_INCR_PER_MM\" = 1000
  \"$A_IN[1]\" = true";
    OWN_COMPENSATION = "E0220" "the program changes the machine's own compensation"
"The program writes compensation tables or backlash of the control ($AN_CEC, $AA_ENC_COMP, $AA_QEC, $MA_BACKLASH …). The error model in the
machine file holds for the machine as it was measured, with the values that were active then. Load such tables before, measure, and take
the assignments out of the program.";
    LATHE_PROGRAM = "E0225" "lathe program"
"The program is one for a lathe, and the machine file describes none. On a lathe the same words move the tool otherwise: G92 X Z F is
a thread cycle (on a mill it shifts the zero), G90 X Z F a turning cycle, X a diameter, U and W are increments of X and Z. The message
names the marks that were found with their lines. Turning is not supported; choose another program, or, where the program is one for a
mill after all, say so with control.program_kind = \"mill\" in the machine file.";
    AXIS_IN_DOUBT = "E0226" "axis in doubt behind a rotation"
"Directly behind G68, G51, G51.1 or their end a block names one axis of the plane only. Whether the other one moves is a parameter of the
control (Fanuc 11600, bit 5, AX1): the value that was programmed for it before may count in the new coordinates, or it may stay where the
tool is. Both ways are named. Name both axes, or set control.one_axis_in_rotation to \"value\" or \"place\".

  G0 X10. Y0.
  G68 X0. Y0. R90.
  X20.                    Y is 0 or -10 in the turned coordinates";
    FORBIDDEN_STATE = "E0227" "code not allowed in this state"
"The control does not take this code while another one is in force: a plane, a zero offset or a reference point within G68, G51 or G51.1 of
a Fanuc, G74 and G75 of a Sinumerik under TRAORI. The operator's manuals forbid it, and where the tool would go is not defined. End the
state first. Some makers allow the codes within a rotation: control.codes_within_rotation = \"allowed\".";
    TWO_MEANINGS = "E0228" "word that controls read in two ways"
"Controls that look alike read this word in different ways, and both readings make sense here: P10. of G4 is ten seconds on a Haas and no
dwell that a Fanuc takes, M98 P30200 calls program 30200 once or program 200 three times, K of G73 is a depth or a number of holes, M99 P70
in a subprogram leads to N70 of the caller or of the subprogram. The program does not guess: the message says which setting decides, or how to write it clearly.";
    LOST_PROGRAM = "E0229" "blocks that would be lost"
"A file may hold several programs, and one of them is corrected. With --in-place the others would be gone from the file: give -o another file, or put each
program into a file of its own. The same holds for blocks that move before the first program number (O1234) of a Fanuc: on the control they belong to no
program, and neither they nor the program behind them is what is meant.";
    CORNER_DOES_NOT_FIT = "E0231" "rounding or chamfer does not fit"
"RND, RNDM, CHF or CHR ask for a transition that is larger than the contour elements beside it. A control would make it smaller by a
rule of its own. Program a value that fits, or longer elements.

  N10 G1 X5 Y0 RND=10
  N20 Y20                 the first element has 5 mm, the rounding needs 10";
    BAD_COMPENSATION = "E0232" "radius compensation not possible here"
"G41 and G42 begin and end (G40) in a straight block with motion in the working plane; between them plane, mirroring and machine
coordinates must not change, and no more than control.compensation_blocks_between blocks without motion in the plane (Sinumerik MD20250)
stand between two contour elements. The radius may change in a straight block that goes on in the direction of the last one.";
    CONTOUR_NOT_FOLLOWED = "E0233" "contour too narrow for the tool"
"With G41 or G42 the tool cannot follow the contour here: an inner arc is narrower than the tool, or an element is so short that the ways
of the tool center before and behind it do not meet, even if up to control.compensation_look_ahead elements (Sinumerik MD20240) are left
out. With CDON also: the tool would cut into another element than the one it follows. Use a smaller tool, or change the contour.";
    NO_WEAR = "E0234" "wear cannot be left to the control here"
"With --compensation wear the control compensates the way of the tool center by the wear alone. What would go wrong with that is refused: a change of side, radius or register while
compensation is on; an end of the program with it on; G43 and G44 of Grundig; G41.1 and G42.1, whose diameter stands in the program; --frame machine and --five-axis axes,
where G41 is not allowed; --rapids all and a --step below 10 mm, which cut the motion to the contour into pieces; and a written program that the control could not follow, or not in full, with a wear of plus or minus --largest-wear: inner arcs of the
way of the tool center that are smaller, elements that are shorter, such as the few micrometers that a correction or a backlash adds across the way. Change the program as the
message says, give a smaller --largest-wear, or correct it without the option: then wear goes into the machine file.";
    NO_ORIENTATION = "E0240" "tool direction out of reach"
"Under TRAORI the rotary axes cannot turn the tool to the programmed direction, or not within their travel: a table that tilts to one
side only, an axis at its limit. Check the direction (A3, B3, C3 run from the tip to the spindle) and axis.….travel_deg.";
    THROUGH_POLE = "E0241" "orientation passes a pole"
"Between two directions the tool comes so near to the pole of the five-axis transformation (the tool along the rotary axis that is nearest
to the workpiece) that a rotary axis would have to jump or to turn very fast. A control leaves the programmed orientation there in a
way of its own (Sinumerik MD24530, MD24540; control.pole_limit_deg, default 2 degrees), which cannot be followed.

Move around the pole, end a block at it, or program ORIAXES: rotary axes then move in proportion.";
    CORNER_OVER_UNKNOWN = "E0242" "rounding or chamfer across what is not known"
"Between the two contour elements of a rounding or chamfer (RND, RNDM, CHF, CHR; ,R and ,C) stands something whose effect on the motion is not known here: the call
of a program that the control runs by itself, a stop (M0, M1, STOPRE, a read of $AA_ or $AC_ variables), a tool change, another zero offset, frame, tool length or plane, a
message, words that are passed on. Whether and where a control makes the
transition then is its own business. Put it before the first element or behind the second one, or take the transition out.

  N70 Y200 RND=10
  N75 L6                    with control.opaque = [\"L6\"]
  N80 X300";
    WAY_OPEN = "E0243" "way of a rotary axis is open"
"A rotary axis that turns without end can reach the programmed position on two ways, and the program does not say which: DC(…) half a turn away in a motion that
cuts, ACP(…) or ACN(…) where the axis stands already (no motion, or a full turn), an absolute position where it depends on a parameter of the control how the axis gets
there. What the tool does on the way is different for both, so nothing is chosen. Program the way: ACP(…), ACN(…), IC(…).";

    ALREADY_CORRECTED = "E0301" "this program was corrected before"
"The first comment says that ncfix made this file. Correcting it again would add the corrections twice. Correct the original.";
    OUT_OF_TRAVEL = "E0302" "position outside the travel of an axis"
"A position – in a correction the corrected one, in check that of the program – lies beyond axis.….travel_mm (travel_deg). The message gives the axis, the limit and the position: the end of the
move where that is outside, else the farthest place on the way. Check zero offset and tool length first: a wrong one moves the whole
program.";
    CORRECTION_TOO_LARGE = "E0303" "correction larger than allowed"
"A correction exceeds --max-correction (default 0.2 mm; rotary axes are judged by the arc at the tool). Geometric errors of a machine in
working order are smaller: check the units in the machine file before raising the limit.";
    UNKNOWN_START = "E0304" "motion from an unknown position"
"An incremental move or an arc starts from a position that the program has not stated: at its beginning, or after a tool change. The
corrected program is absolute, so it would move somewhere else than the original. Begin with an absolute position, or give
--start X0,Y0,Z0 for the beginning.";
    UNITS_DOUBT = "E0305" "units in doubt"
"Positions were programmed before the unit was stated, and the program switches between inch (G70, G700) and metric (G71, G710) later.
Whether the first positions are mm or inch depends on what was active on the control before. State the unit in the first block.";
    NO_OFFSET = "E0306" "zero offset has no value"
"The program selects a zero offset that the machine file does not know, so the place in the machine, and with it the correction, is
unknown. Add it to the machine file or to a set-up file given with --setup:

  [zero_offset.G54]
  X_mm = 350.0
  Y_mm = 200.0
  Z_mm = 80.0";
    NO_TOOL = "E0307" "tool has no value"
"The program activates a tool or cutting edge that the machine file does not know; the correction depends on its length. Add it to
the machine file or to a set-up file given with --setup:

  [[tool]]
  number = 5
  edge = 1
  length_mm = 120.0
  radius_mm = 5.0";
    NOT_CONVERGED = "E0308" "no correction found"
"The iteration on the exact kinematics did not reach 1e-6 mm. The error model is far too large for this pose, or the machine cannot
move the tool in some direction.";
    NO_AXIS = "E0309" "axis that the machine lacks"
"The program moves an axis that is not in the machine's topology.";
    WRONG_FILE = "E0310" "input and output are the same file"
"The original program is never overwritten. Choose another output, or --in-place, which keeps the original as a .bak file.";
    CANNOT_ALIGN = "E0311" "programs cannot be compared"
"verify walks the original and the corrected program side by side. Their motions do not follow the same path, or one has more moves than the
other.";
    NO_SERVO = "E0312" "machine file without servo loops"
"What the axes do at feed can only be told where the machine file says how they follow: [servo] with the interpolation cycle, the smoothing and the tolerance
of corners of the control, and [servo.X] for every axis with its velocity gain, its feed-forward and its acceleration. The control shows them (Sinumerik MD32200,
MD32610, MD32300); ncfix decompose finds gain and feed-forward in a trace. docs/reference/servo.md has an example.";
    FEED_OF_ANOTHER_WAY = "E0313" "feed would be that of the correction"
"A cut turns rotary axes, and its feed is in degrees per minute or that of a short way of X, Y, Z. Controls take a feed for X, Y and Z where these move at all, so the
micrometers of a correction would take the feed over, and the axes would turn as fast as they can. Such blocks are written with the time that they take (G93). That is not
possible where the language has no G93 (Grundig), and where the feed is one per turn of the spindle (G95, G96).";
    NEWER_FILE = "E0314" "output was written by somebody else meanwhile"
"When a run began, another file stood where it would write, or none did; with --in-place the program is no longer the one that was read. A person, a CAM system or a
second run has written there in the meantime. Nothing newer is ever replaced: what is there stays, and nothing of this run is written. Look at the file, then run the
command again.";
    HIDDEN_BLOCK = "E0315" "carriage return within a line"
"The file ends its lines with a line feed, and within a line there is a carriage return with something behind it. To some controls that is the end of the line and what is behind
it a block of its own, even behind a comment; to others it is not, and on a screen it may cover the beginning of the line. What moves depends on the control, so nothing
is guessed. Put a line feed in its place, or take it out.";
    DECEPTIVE_TEXT = "E0316" "control character within a line"
"A line holds a character that does not show but changes what shows: escape, backspace, delete between words, one of U+0080 to U+009F, or one that turns the direction of text. A
person who reads the program sees other blocks than those that run. Take the character out.";
    OTHER_ACT = "E0319" "corrected program does something else"
"A correction changes positions, and cuts moves into pieces. Whatever else a program does – speed and sense of the spindle, tools and their offsets, coolant, M
functions, dwells, stops, modes of the path, work offsets, calls, the end of the program – stands in the corrected program in the same place along the path. ncfix verify
and ncfix diff compare it one by one, and name what is changed, missing or new with its line in both programs.";
    OFF_PROMISE = "E0320" "tool further off than the correction promised"
"The stamp of a corrected program says how far a piece may be from its exactly corrected path (--tolerance). At the ends of pieces, between them and where arcs turn
an axis around, the tool of this program is further off on the error model: it was edited, was corrected for another machine or state, or ncfix fix has warned that the
tolerance was not reached (W0305, W0307), or that the side of a backlash is unknown (W0308).";
    OTHER_FEED = "E0321" "corrected program has another feed"
"The pieces of a move have the feed of the move: the same number where both count the same way, else the same time within 5 %. Only --feed-limit lowers feeds, and the
stamp says so.";

    BAD_TOML = "E0401" "machine file is no TOML"
"The file breaks the rules of TOML 1.0 at this place.";
    UNKNOWN_KEY = "E0402" "unknown key in the machine file"
"The key is not known in this section; a misspelt key would be silently without effect, so it is refused.";
    MISSING_KEY = "E0403" "missing key in the machine file"
"The section needs this key.";
    BAD_VALUE = "E0404" "value not allowed in the machine file"
"The value has the wrong type, is not finite, or is outside its range; the message says what is expected.";
    BAD_TOPOLOGY = "E0405" "topology that makes no machine"
"A topology reads from the workpiece w through the foundation F to the tool t, for example wCBXFZYSt; axis letters X Y Z U V W A B C at most
once each, S (optional) just before t, every letter with its [axis.…] section.";
    UNKNOWN_COMPONENT = "E0406" "unknown error component"
"A component is E, a direction (X Y Z A B C) and an axis of this machine for [[motion]], or E, a direction, 0 and an axis or S for [location]:
EXX, EAY, EC0Y, EX0S.";
    WRONG_UNIT = "E0407" "wrong unit for this component"
"EX EY EZ are displacements (values_um, amplitude_um, value_um), EA EB EC rotations (…_urad); positions of linear axes are _mm, of rotary
axes _deg.";
    BAD_TABLE = "E0408" "table that does not increase"
"positions_mm (positions_deg) must increase strictly and have as many entries as the values.";
    MISSING_SENSOR = "E0501" "temperature of a sensor missing"
"The error model of the machine file depends on the temperature of this sensor, and the state that was given has temperatures but not
this one. A drift that is computed without it would be wrong by an unknown amount.";
    DECEPTIVE_NAME = "E0409" "name with control characters"
"A text of the file holds a character that does not show: a control of terminals (escape, backspace, bell, delete, U+0080 to U+009F) or one that turns the direction of text
(U+202A to U+202E, U+2066 to U+2069). What a person reads in a report would not be what the file says. Write the name with letters, digits and signs.";
    OUT_OF_RANGE = "E0410" "number out of its range"
"A number is larger or smaller than any machine has, or a list has more numbers than any table: mostly a wrong unit. docs/reference/settings.md has the range of every key with its
reason.";

    DATA_NO_TABLE = "E0601" "measured data that are no table"
"Measured data are CSV: a line of column names, then rows with a cell for each of them. Cells are separated by commas, by semicolons or
by tabs; a text that contains the separator has quotation marks. UTF-8, with or without byte order mark, and any line ends will do; UTF-16
and workbooks (XLSX) have to be saved as CSV first.

  run,X,Y,Z,dx_um
  1,100,50,0,-3.2";
    DATA_COLUMN = "E0602" "column that does not fit the machine"
"Every axis of the machine needs a column of its name (X, Y, Z, C …) with positions in mm or degrees. A column named like an axis that
the machine lacks, or a name that is there twice, is refused: something else was measured, or on another machine. A log
needs t_s and at least one temperature (T_head_C for the sensor T_head) or load_N.";
    DATA_CELL = "E0603" "cell that is no number"
"A position or a tool length is a plain number: 12.5 or, where the separator is no comma, 12,5; the same decimal sign in all cells, no
unit, no separators of thousands. Cells must not be empty. The sense of motion (X_dir …) is -1, 0 or 1, or empty.
In a log temperatures and loads may be empty; temperatures are -30 to 150 °C, a weight is not negative, the time does not go back.";

    DATA_REPEATED = "E0605" "reading given twice"
"Two rows of a measurement are the same to the last digit. A repetition differs by the noise of the instrument; a copied row would count twice and make
the result look more certain than it is. The first of them is told, and how many there are. The same is said of a table that is given twice, or held out
as well, also where its readings are rounded or its rows in another order.";
    LOAD_NOT_TOLD = "E0604" "strain readings that tell no load"
"ncfix weigh weighs a workpiece by the change of a strain along an axis. The readings must lie where [strain] of the machine file knows the
gauge, at enough positions to tell the weight from the offset (and the drift, where there is a column t_s) of each run, and there must be more
of them than unknowns, or nothing says how uncertain the result is: measure every position twice. Of two readings of a position that contradict each
other nothing may say which one is disturbed (a pulse of lubricant); a third run tells. A negative weight means a wrong sign in [strain] or in the
readings.";
    NOT_TOLD = "E0606" "errors that the data cannot tell"
"ncfix calibrate finds errors of the machine and what is unknown of each set-up from readings. Here some of these move what was read in just the same
way, or not at all, so that nobody could say how much each of them is: a least-squares solution would be one of infinitely many. The message
names them. Measure in poses in which they differ (other angles of the rotary axes, another tool length, a second set-up, a known length), describe
what is known of the set-up (take it out of free), or choose a model with fewer parameters (ncfix machine presets). ncfix diagnose says so where fewer than
three readings are left beside the unknowns of the set-ups, and where the file of -o was not written; its findings stand all the same.";
    NOT_SETTLED = "E0607" "calibration that does not settle"
"The parameters still change after the last round: the model and the readings contradict each other, for instance in a sign, a set-up or an axis, or
single parameters hardly move what was read. Check the description of the measurement, --machine, and rows with large deviations.";
    DATA_SIZE = "E0608" "readings of an implausible size"
"Readings are µm or µrad, as the names of their columns say. This one is above --max (an angle counts by what it moves at an arm of 1 m), or all readings
of a measurement are below the uncertainty of the instrument: values in mm, or in nm, were written into a column of µm, or length_mm and centre_mm of
the description are wrong. The same is said of a parameter that would move the tool by more than --max. Where a machine has such errors give
a larger --max.";
    BAD_PARAMETER = "E0609" "no parameter of this machine"
"A file for --model has a parameter in each line, and comments behind #: EC0Y is a location error, EXX1 the coefficient of degree 1 of a motion error,
EXXb its backlash, EXX2@150 a truncated power that begins at 150 mm; load.EAX, drift.Y or expansion.X.scale are those of effects, which must be there in
the machine file. The axis must be there, too, and a parameter stands there once.";
    DATA_FAULT = "E0614" "readings that say something else than was measured"
"Before ncfix diagnose looks for causes it looks for faults of the data. Here all readings of a measurement are off by a factor of units (1000, 25.4), go
with the model only when two axes are exchanged or one is reversed, fit only a machine with another order of the axes
than the file has, or lack exactly those errors that the machine file has, because a table of the control was active while measuring. Causes found in such readings would be nonsense; the finding says what the evidence is and what to change.";

    DRIFT_NOT_TOLD = "E0613" "drift that cannot be told from a reversal"
"A drift that is a straight line in time within a back-and-forth cycle makes the way back differ from the way forth by more the farther from the turn
a position is; a reversal (backlash, lateral play) makes it differ by the same everywhere. A drift is only taken out where there is no reversal: the
model has none for the component (EXXb, or for a reading of a length EBXb too, which acts with its Abbe arm), and the readings show none, which a test
of Student says with an error of 0.1 %. Each cycle must go both ways. Take \"drift\" out of free and let the machine warm up before, measure faster, or take the
reversal out of the model where there is none.";

    NOT_FOR_LINK = "E0701" "line that the link cannot take"
"A line of the corrected program is too long for the control at the other end of the link, or has a character that means something else there: Grbl takes
! ? ~ out of the stream wherever they stand. Nothing was sent. Leave out blanks, numbers of blocks and comments, or choose a larger --tolerance or
--increment where corrected numbers are too long.";
    STARVED = "E0702" "the link cannot keep up with the motion"
"The control would stand still and wait for lines: the axes stop in mid-cut and leave marks. The finding says where, how many lines a second the motion
needs there and how many come. A link that takes line by line stops the axes at the end of each. Choose a higher baud rate on both sides, a larger --tolerance (fewer lines), leave out numbers of blocks, or write the
program with `ncfix IN -o OUT` and load it into the control. --allow-starvation sends it all the same.";
    UNFINISHED_JOB = "E0703" "journal of an unfinished job"
"The journal of this transfer is there already, and says that the job was broken off: lines were sent that may have been carried out or not. It is not
overwritten. Look at `ncfix resume JOURNAL`, or remove the journal, or give another one with --journal.";
    OTHER_JOB = "E0704" "not the job that was broken off"
"A job can only be taken up again with the program, the machine file, the state and the version with which it began: with others the lines that were sent cannot
be told from those that were not, and the correction would jump. Nothing was sent.";
    IDLE_UNKNOWN = "E0705" "nobody says that the machine stands still"
"Lines that are sent into a machine that carries something else out, stands in a hold or waits at an open door run into what it does. Controls that can be asked
are: Grbl and grblHAL for their state, Marlin whether all moves are done, LinuxCNC for its status; they get no line unless they are idle. A tape reader and the
blockwise transfer of Heidenhain have no such question. Look at the machine, and say so with --i-checked-the-machine-stands-still. Nothing was sent.";
    NOT_CLEAR = "E0706" "no place from which the tool comes clear of the workpiece"
"A job that was broken off is only taken up again over a height that a person has stated to be clear of workpiece and clamps (--clearance 25mm, Z of the program):
the way to the place crosses at that height, from wherever the tool stands. The program goes on where one of its retracts had ended, with the rapid move that
follows; a slow feed leads down to it. Where no such place is known, or the state of the control there cannot be rebuilt, the beginning is left, and that only
where the stated height can be reached before its first move or with it: behind a tool or its length Z means something else. Else lift the tool by hand, remove the
journal and feed the program from its beginning. Nothing was sent.";
    CLEARANCE_TOO_LOW = "E0707" "clearance too low, or out of the travel"
"The height of --clearance, Z in the coordinates of the program, must lie 1 mm or more above the highest place that the program machines, along the tool: every point of
every move with feed counts, the start of a plunge and the top of an arc too. Below that the way across would lead through the workpiece. It must also lie within the
travel of Z of the machine file, with the zero offset and the tool that are in force there. The message names the limit; state a height between, above the workpiece
and its clamps. Nothing was sent.";
    BAD_SET_POINT = "E0801" "line that is no set-point"
"A line of the input of ncfix realtime is no set-point: a word that is no axis of the machine, a number that is none, an axis whose position was never stated,
too many or too few cells, an empty line. The run ends, because a control that goes on with a guess moves a machine. Every line before it was answered, in order;
the control must hold the last correction, or stop. The message has line and column.";
    BAD_TABLES = "E0901" "compensation table that cannot be read"
"A file of compensation tables for ncfix tables --read, or for machine.active_tables, is not what its format says: a number that is none, an axis that the
machine lacks, a product with a table that is not there, a field that is not written, or twice with different values (the control keeps what it had there, and nothing
tells what that is). Nothing of it is used, because half of a compensation moves the tool to a wrong place. Correct
the line, or name the format (--format) or the axes (--axis-name X=AX1).";
    TABLES_DO_NOT_FIT = "E0902" "tables that the control cannot take"
"The tables that the scheme asks for are more, longer or larger than the control takes, or of a kind that it does not have. Nothing was written. Choose
another --scheme (auto looks for the fewest tables), a larger --tolerance, fewer --points, or another --format; ncfix tables --list shows what each has.";
    TABLES_MAKE_WORSE = "E0903" "tables that leave more than no tables"
"The tables were evaluated as the control interpolates them, at poses all over the volume of use, and the tip of the tool, or its direction, is farther off with them than
without. Nothing was written, because a compensation that makes the machine worse is worse than none. The scheme does not fit the errors of this machine: own has a table
for each axis over its own position and knows nothing of what one axis does to another; a grid knows no rotary axes. Take another --scheme (auto tries them all), the --tool
that is used, --orientation off, or another --format; ncfix tables --list shows what each has.";
    CORRECTION_MAKES_WORSE = "E0904" "correction that leaves more than none"
"The error that the corrected program would leave is larger than that of the program as it is, and larger than the tolerance. Nothing was written. Mostly the smallest
increment of the output is coarser than the error that is to be corrected (--increment, control.increment_mm), or --tolerance allows more than there is.";
    SKIP_EXECUTED = "W0201" "skip blocks are decided"
"Blocks with / were executed (or skipped with --skip) and the output has no / any more: a switch at the control has no effect on it.";
    FEED_ASSUMED = "W0202" "feed motion without a feed"
"G1, G2 and G3 need F; the control stops at this block. For check and snc the motion is shown without a feed; a correction is refused
(E0215).";
    MORE_PROGRAMS = "W0203" "further main programs in the file"
"The file has more than one main program (%_N_…_MPF, %PM, O1234). The first one is executed; the others are only executed where it
calls them. Put each main program into a file of its own.";
    LEFT_OUT = "W0204" "statement left out of the output"
"WRITE and DELETE access files of the control. They are not carried out here and not written to the output; their result variable counts
as 0, no error. Nothing about the motion changes. Tables of tools and zero offsets in the transfer of a Grundig program (%TM, %ZO) hold for
the run and are not written either: the control must have the same tables before it runs the output.";
    NOT_CORRECTED = "W0205" "moves that are not corrected"
"SETINT lets an input of the control interrupt the program and start another one, which is run as it lies on the control. Its moves are
not corrected, unless that program has been corrected too.";
    WATCHED_ONCE = "W0206" "synchronised action of one block"
"A synchronised action without ID acts while the next block is executed. Where the correction cuts the move of that block into pieces, the
action is watched during the first piece only.";
    TAPPING_BY_FEED = "W0207" "tapping by feed moves"
"A tapping cycle (G84, G74) becomes a move with feed into the hole, the other sense of the spindle, and a move out. Spindle and axis do
not go in step as they may in the cycle of the control, so the tap needs a chuck that gives way, as older controls always do.";
    CORNER_LEFT_OUT = "W0231" "no rounding or chamfer made"
"RND, CHF or CHR stand in a block behind which no motion in the working plane follows within three blocks, or a motion of other axes comes
first. A control makes no transition then, and neither does this program.";
    COMPENSATION_LEFT_ON = "W0232" "radius compensation still on at the end"
"The program ends with G41 or G42 in force. The tool stops beside the end of the last contour element. End the compensation with G40.";
    ELEMENT_LEFT_OUT = "W0233" "contour element left out"
"The tool is too wide for this contour element; its way goes from the element before to the one behind, as the control does it. Some
material is left. Check that the right tool is meant.";
    CONTOUR_DAMAGED = "W0234" "tool cuts into the contour"
"With G41 or G42 the tool comes nearer to a contour element than its radius while it follows another one: a slot or notch is narrower
than the tool, a spiral too tight. The control does the same where collision monitoring is off (CDOF); with CDON it leaves out what the
tool cannot reach, up to control.compensation_look_ahead elements (Sinumerik MD20240). Elements within three times this number before
and behind are looked at. Check that a smaller tool is not meant.";
    EITHER_WAY = "W0235" "rotary axis may turn either way"
"A rapid motion turns a rotary axis by exactly half a turn the shortest way (DC). The control may go either way. The word stays as it is in the output, but its position is
corrected by a few thousandths of a degree, which may decide for the other way. Both ends are the same; see that the axis may turn both ways there, or program ACP or ACN.";
    WEAR_WITHOUT_EFFECT = "W0236" "radius compensation is worked out"
"The program uses G41 or G42 (Grundig: G43 and G44 too), and the corrected one has the way of the tool center instead, for the radius that the machine file gives the tool. The control
does not look at its own radius any more: another radius, and wear that is entered at the control, have no effect on this program. After a change
of radius or wear put the new value into the machine file or a set-up file ([[tool]] radius_mm, wear included; --setup takes the tool table of the
control) and correct the program again. The lengths of tools and their wear are not concerned.";
    WEAR_ALONE = "W0237" "radius compensation at the control is for wear alone"
"The program was corrected with --compensation wear: it has the way of the tool center, for the radius that the machine file gives the tool, and G41 or G42 on top of it, so that
wear which is entered at the control keeps its effect. The control must therefore have the radius 0 for these tools, plus the wear: where it still has the radius
of the tool, it moves the tool away by it a second time, outside too far from the part, inside into the wall or onto an alarm. Set the radius in the
register (D number) to 0 before this program runs and enter wear alone; put it back before any other program uses that register, or give this program a register
of its own. The machine file needs the real radius. See docs/reference/output.md.";
    MOVES_NOTHING = "W0238" "no axis is moved"
"The program was understood and executed, and no axis has moved: a correction of it would be refused (E0223). For a file of definitions or of subprograms that is as it should be.
Else its blocks may stand behind the end of the program (M30), in a subprogram that nothing calls, behind skip blocks, or the file is cut off.";
    OFFSET_ASSUMED = "W0302" "zero offset assumed zero"
"The machine file has no value for this zero offset. For check and snc zero is used; a correction is refused.";
    TOOL_ASSUMED = "W0303" "tool assumed without length and radius"
"The machine file has no value for this tool. For check and snc zero is used; a correction is refused.";
    NO_MACHINE = "W0304" "demo machine used"
"Neither --machine nor the environment variable NCFIX_MACHINE names a machine file, and there is no ncfix.toml in this folder or above
it, so the embedded demo machine was used. The output is good for looking at, not for a real machine.";
    TOLERANCE_NOT_REACHED = "W0305" "tolerance not reached"
"At some place the pieces became as short as 0.01 mm, or as fine as the increment, and still deviate by more than --tolerance. The
tolerance is below what the increment can express, or the error model has a step there, or the increment leaves an axis within its backlash.";
    OTHER_STAMP = "W0306" "corrected for another machine or model"
"The stamp of the corrected program names another model than the one it is compared on. Each correction is good for one machine in one
state: the numbers say what this program would do on the machine that was given.";
    ONE_PIECE = "W0307" "move in one piece bends"
"Threads (G33, G34, G35, G331, G332, G63) and positioning axes (POS) are not cut into pieces: the spindle and the axis would lose step, or the
axes would stop in between. The end of the move is corrected, and on the way the tool is off by more than --tolerance.";
    SENSE_UNKNOWN = "W0308" "side of a backlash unknown"
"An axis with backlash came to its place from where the program had not stated it (before the first block, behind a tool change), so that nobody knows from
which side. The backlash counts as its mean there, and half of it may be left until the axis moves again. A short motion of the axis before the cut,
or --start, decides it.";
    FEED_LIMIT_MISSED = "W0309" "tool further off its path than --feed-limit"
"With --feed-limit, ncfix fix lowers feeds where the axes would be too far off the path. On this block that was not enough: its feed is at the lowest that is
tried, 5 % of the programmed one; or it is a time (G93) or that of a thread, which stay; or a lower feed does not help, because what gives way does so while the
axes accelerate from rest. At a corner the lag of one block may reach into the next one: an exact stop (G9, G60; G61 where a control has it) lets the axes arrive
first, feed-forward in the drives makes the lag smaller. The program is written with what could be done.";
    NO_STAMP = "W0314" "corrected program without its stamp"
"ncfix fix writes a comment among the first lines that says for which machine, model, state and source a corrected program is good, and what it promises. This program
has none: it was not written by ncfix, or the stamp was taken out or changed. Nobody can say what it is good for; the tolerance of --promised, or 1 µm, is assumed.";
    PROMISE_ASSUMED = "W0315" "tolerance of the correction assumed"
"The stamp of the corrected program does not say what tolerance it was made with. The tolerance of --promised is taken, or 1 µm, which ncfix fix has without --tolerance.";
    NO_TRAVEL = "W0401" "axis without travel limits"
"The machine file gives no travel_mm (travel_deg) for this axis, so positions outside its travel cannot be found.";
    TWO_DRIFTS = "W0402" "two models of the drift"
"The file has [[drift]] (weighted temperatures) and [[segment]] (the structure as beams). Each describes the drift of the warm machine; where both do so
for the same parts, twice as much is corrected. Both are right in one file only where one was fitted to what the other leaves.";
    UNUSED_SENSOR = "W0403" "sensor that nothing uses"
"[sensor.NAME] gives the reference temperature of a sensor that is in no [[drift]], [[expansion]] or [[segment]]. A misspelt name leaves the sensor that was
meant at the reference temperature of the machine.";
    PARTIAL_OFFSET = "W0404" "zero offset without an axis"
"[zero_offset.NAME] states a linear axis and lacks another one of the machine, which counts as 0. If the control has another value there, the corrected program
is related to the wrong place. Write every axis as the control shows it, 0 too. The external offset EXT of a Fanuc may have single axes.";
    NO_TEMPERATURES = "W0501" "temperatures not given"
"The error model has sources that depend on temperatures, and no --state, or in a calibration the table of readings, gives them. They count as if all sensors were at their
reference temperature: no drift, no expansion.";
    NO_LOAD = "W0502" "workpiece weight not given, or without effect"
"The error model has effects of the weight on the table, and neither --load nor --state says what stands there. The table counts as
empty. Or the other way round: a weight is given, and the machine file says nothing about its effects.";
    LOAD_TURNS = "W0503" "load off the center of a table that turns"
"The effect of a weight depends on where it stands in the machine. A rotary axis under the table carries a load that is not on its line to other
places; the effect is computed for the place that was given, whatever the position of the axis. That is right for a table that stands still while a
side of the workpiece is machined: give the place for this position, along the axes of the machine.";
    LOAD_ASSUMED = "W0601" "load with a reservation"
"The readings tell the weight, but not all that is wanted: the place of the load along an axis, whose signal is like that of the weight itself
(give it with --known Z-280), a load that the noise hides, a disturbed reading that too few others check, or a scatter above sigma_um_per_m.";
    READING_LEFT_OUT = "W0602" "reading left out"
"The strain is disturbed for a moment by every pulse of lubricant. A reading (or two) without which the others agree far better than by chance (1 %)
is left out of the weighing.";
    ROW_DOES_NOT_FIT = "W0603" "reading that does not fit the others"
"In a calibration a reading further from the model than noise explains counts for less, and beyond 4.7 standard deviations for nothing
(Tukey's weights). It stays in the file and in the report. Look for its cause: a chip under the ball, a wrong row, a set-up that
moved. With --no-robust all readings count alike.";
    POOR_FIT = "W0604" "the residual is larger than the instrument explains"
"The residual of the calibrated model is well above the uncertainty that sigma_um states. The machine has errors that the model lacks, its temperature changed,
or sigma_um is too small. The standard uncertainties then rest on the scatter of the residuals instead of sigma_um. They do not cover errors that the model lacks.";
    REDUCED = "W0605" "parameters left out"
"With --reduce, ncfix calibrate leaves out parameters that the data cannot tell from others, and fits the rest. Of those that cannot be told from each other
the least simple one goes: truncated powers before backlashes, before coefficients from the highest degree down, later ones of the model before earlier
ones, location errors last. What was left out stays as it is in the machine file that the calibration begins with; what it does on the machine is
in the others as far as the poses were alike, and wrong elsewhere. The message says why, and the help what to measure instead. ncfix diagnose says so
where the terms that it found cannot be fitted again together: they are written as its search found them.";
    UNLIKE_REPEATED = "W0606" "uncertainties unlike simulated repetitions"
"With --monte-carlo, ncfix calibrate simulates the readings many times, with the noise that it found, and fits them again. The scatter of a parameter differs from
its standard uncertainty by more than 25 %, beyond what the number of repetitions lets expect, or repetitions could not be fitted. Reasons are few
readings, weights that follow the noise, or unknowns that move far.";
    FAULTY_DATA = "W0607" "fault of the data"
"Something went wrong between the machine and the file: a sensor of temperature that is dead, stuck, exchanged with another one, moved or in degrees Fahrenheit; a
pulse of some minutes, a first cycle before the machine had settled, a step of all that follows, single readings far from all others, steps of a display. The
message says in which rows and why this is thought, and the help what follows: what is at fault is left out of the search for causes, or counts with a zero
or noise of its own. The file stays as it is. In data held out rows stay in, so that nobody chooses what the judge sees.";
    STARVING = "W0701" "the link is late in places"
"In some places the control waits a little for lines (E0702 says what that means), less than what forbids the transfer.";
    SERIAL_SETTINGS = "W0702" "port with other settings, or a name that changes"
"The port did not take all settings of the profile, or its name depends on the order in which adapters were plugged in.";
    KERNEL_DIFFERS = "W0801" "kernel that differs from the model"
"The kernel of ncfix realtime has the errors of every axis on 200 intervals, functions that bend more directly, and corrects in two of Newton's steps. At 1000 poses
all over the travel it was held against the iterated solution of the model, and is off by more than 0.5 µm or 5 µrad somewhere. Errors that change by a hundredth
of the way or more do that: a step in a table, a wrong unit. The program corrections of ncfix fix iterate further and are right.";
    NOT_RENEWED = "W0802" "kernel not renewed"
"The state was read again, as --update-s says, and cannot be used: a file that is missing or half written, a sensor without a value, corrections beyond --max-correction. The
kernel in force stays, made for the state before, and the next reading follows.";
    UNUSED_TABLE = "W0901" "part of a table file that is not used"
"Something in a file of compensation tables has no effect on the control or is not known: a table with step 0, values behind its end, points
without a value, variables of another function, tables of another kind than --format, a remark on products that the control does not follow. The rest is read. A list that
no M17 ends is pointed out too, because it may have been cut off. Look whether it was meant.";
    PRODUCTS_ASSUMED = "W0902" "products of tables may be read otherwise"
"A file has tables that are multiplied by others, and nothing says what the control adds then: the product instead of the own value of the table, which is what is
taken, or beside it. The manuals can be read in both ways. Load one table with a value that can be seen, look, and say it: --multiplication instead or beside, or
table_multiplication in [machine]. Files that ncfix writes say it themselves.";
}
