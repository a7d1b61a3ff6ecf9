//! Registry of diagnostic codes: every code once, with its title and the long text that `ncfix explain` prints.
//!
//! Groups: `E01` syntax, `E02` execution, `E03` safety and machine limits, `E04` machine file and error model, `E05` state of the machine, `E06` measured
//! data, `E07` links, `E08` the cycle of a control, `E09` compensation tables; `W…` are these groups as warnings. Codes are stable; a code that is no longer
//! used stays retired. A test demands for each code a bad sample, or the name of another test that provokes it.

use std::fmt;

use super::Severity;

/// Stable diagnostic code such as `E0203`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Code(pub(super) &'static str);

/// Row of the registry.
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

    /// Returns the rows that a person may mean by a code in any case, `e0203`, without its zeros or without its letter: `e203`, `203`.
    pub fn meant(text: &str) -> impl Iterator<Item = &'static CodeRow> {
        let has_letter = text.starts_with(|first: char| first.is_ascii_alphabetic());
        let (letter, digits) = text.split_at(usize::from(has_letter));
        let number: Option<u16> = digits.parse().ok().filter(|_| digits.bytes().all(|byte| byte.is_ascii_digit()));
        CODES.iter().filter(move |row| {
            let (own, digits) = row.code.0.split_at(1);
            number.is_some() && number == digits.parse().ok() && (!has_letter || own.eq_ignore_ascii_case(letter))
        })
    }

    /// Returns the severity, which follows from the first letter.
    #[must_use]
    pub fn severity(self) -> Severity {
        if self.0.starts_with('W') { Severity::Warning } else { Severity::Error }
    }

    /// True if it names a gap in the ranges that were measured.
    #[must_use]
    pub fn is_coverage(self) -> bool {
        matches!(self.0, "W0316" | "W0317" | "W0318" | "W0319" | "W0320" | "W0330" | "W0332" | "E0322")
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
"The text here is not a word, statement or expression of the dialect.

A common cause is a missing '=': in Sinumerik and Grundig programs a value that is not a plain number needs one (X=R1*2, CR=5,
S2=500, X=E1). Another is a comment without ';' in a Sinumerik program, where ( ) belongs to expressions, or without ( ) in
others. A comma is not a decimal point. Write X10.5, not X10,5. If the text is for another control, choose its --dialect.";
    BAD_NUMBER = "E0102" "malformed number"
"A number is digits with at most one decimal point. On a Sinumerik the exponent is written EX, as in 1.5EX-3. Numbers beyond the
range of a double are refused too. Write the number in this form.";
    MISSING_VALUE = "E0103" "address without a value"
"An address letter (X, F, G, …) needs a number, or '=' and an expression, after it. Without a value the motion is not known. Add
the value, or remove the letter.";
    BAD_EXPRESSION = "E0104" "malformed expression"
"The expression ends early, or it contains something that is not an operand or operator. Its value is not known. Correct the
expression at this place.";
    UNCLOSED = "E0105" "bracket or quotation mark not closed"
"A '(', '[' or '\"' that was opened in this block is not closed in it. Where it ends is not known, so the rest of the block may be
lost. Add the closing sign.";
    UNMATCHED_STRUCTURE = "E0106" "control structure not closed or not opened"
"Without its end it is not known which blocks the control repeats or skips. IF needs ENDIF, WHILE needs ENDWHILE, FOR needs ENDFOR,
LOOP needs ENDLOOP, REPEAT needs UNTIL, each in the same program and properly nested. ELSE may occur once between IF and ENDIF.
WHILE ... DO1 of a custom macro needs END1 (with 1, 2 or 3), an O-word of RS274/NGC needs its end with the same label: o100 sub
and o100 endsub, o101 while and o101 endwhile. Add the missing word, or remove the one that is too many.";
    TOO_DEEP = "E0107" "nested too deeply"
"Brackets in an expression may be nested 64 deep, control structures 32 deep. Controls allow far less. Divide the expression with a
variable, or move an inner structure into a subprogram.";
    MUST_STAND_ALONE = "E0108" "statement must be alone in its block"
"Control statements, DEF, PROC, TRANS, ATRANS and calls may share their block only with the block number, a label and a comment
(TRANS also with its axis words). Controls differ in the order of such a block. Write the other words in a block of their own.";
    BLOCK_TOO_LONG = "E0109" "block too long"
"A block has more than 4096 bytes. A Sinumerik 840D sl accepts 512 characters. Probably the file is not a part program, or its line
ends were lost in transfer. Transfer the file again as text, or divide the block.";
    NOT_A_PROGRAM = "E0110" "not a part program"
"The file is empty, or most of it cannot be read as blocks of the dialect. Check --dialect, and that the file is not an archive,
picture or saved setting data.";
    DOUBLE_WORD = "E0111" "word given twice in one block"
"An address that takes effect once per block (an axis, F, a G code of one group …) was programmed twice in it. The control would
raise an alarm or use the last one, depending on its version; ncfix does not guess. Remove one of the two words, or write it in
the next block.";
    DOUBLE_NUMBER = "E0112" "block number given twice"
"G14 repeats blocks and G29 jumps to a block by its N number, and two blocks of this program or macro of a Grundig or MillPlus have
that number. Numbers may repeat, as in long programs of postprocessors, but not those of such blocks. Renumber one of them.";
    EXPONENT = "E0115" "letter inside a number"
"A number is followed directly by E and digits, as spreadsheets and some postprocessors write small numbers. These languages have no
exponents: the control would read X1.5 and a word E, and move 1.5 mm instead of 15 nm.

  N10 G1 X1.5E-05         write X0.000015, or X0
  N20 G65 P9010 A1. E5    an argument E needs a blank before it

Round the number in the postprocessor, or write it out.";
    OTHER_CONTROL = "E0118" "program of another control"
"The program is for a control whose language ncfix does not read, or for another control than the machine file and --dialect state:
Heidenhain Klartext, Okuma OSP, a 3D printer, a Sinumerik program for a Fanuc. Words that look alike move the tool differently. The
message states what was found and where. Choose the right --machine or --dialect, or convert the program.";

    NOT_SUPPORTED = "E0201" "not supported yet"
"The program uses a code, statement, cycle or system variable that ncfix does not execute. ncfix refuses it because skipping it
could change the motion. The message names it. Program the motion another way. If the control is to execute a cycle or subprogram
itself, name it in [[opaque]] of the machine file; ncfix then does not correct the moves within it. docs/how-to/refused-program.md
has more.";
    NO_CENTER = "E0202" "arc without center or radius"
"G2 and G3 need a center or a radius. The words depend on the control. Sinumerik: I, J, K from the start of the arc, I=AC() and so
on for absolute values, or CR= for the radius. Fanuc, RS274/NGC and Grundig: I, J, K, or R for the radius. Without them,
infinitely many arcs lead from the start to the end. Add the center or the radius to the block.";
    ARC_OFF_CIRCLE = "E0203" "arc end is not on the circle"
"The radius at the start of the arc and the radius at its end differ by more than the control allows. Or the nearest center of a
circle through both points is farther away than that and, on a Sinumerik, more than 1.8° as seen from the start. The limit is the
larger of control.arc_tolerance_mm and control.arc_tolerance_ratio times the radius (Sinumerik MD21000 and MD21010, default
0.01 mm and 0.001).

  N10 G1 X0 Y0
  N20 G2 X10 Y0 I4 J0     start radius 4 mm, end radius 6 mm

Correct I and J, or the end point.";
    RADIUS_TOO_SMALL = "E0204" "arc radius smaller than half the chord"
"No circle of this radius (CR= on a Sinumerik, otherwise R) reaches both the start and the end of the arc: they are farther apart
than its diameter. Usually the radius is wrong, or the start is not where the programmer expected it. A full circle cannot be
programmed with a radius: its start is its end, so the center is not determined. Correct the radius or the end point, or write
the center (I, J, K).";
    BAD_ARC = "E0205" "invalid arc"
"The center coincides with the start, center words lie outside the working plane, or center and CR were given together. No arc, or
more than one, fits these words. Correct the center, select the plane (G17, G18, G19) before the block, or remove CR.";
    UNDEFINED_VARIABLE = "E0206" "variable not defined"
"The name is not a variable defined with DEF in this program, an R parameter or a known function. In data that the control saved,
every value is a number, a text or a known name. Check the spelling, or define the variable. If only the control knows it, state
it in [gud] or [system] of the machine file.";
    BAD_INDEX = "E0207" "index outside the array or parameter range"
"R parameters run from R0 to R9999; an array index from 0 to its length minus 1. Correct the index, or make the array longer.";
    TYPE_MISMATCH = "E0208" "value of the wrong type"
"A number was expected and a string found, or vice versa, or a value cannot be converted (an INT cannot hold a fraction). Use a
variable of the right type, or convert the value (ROUND, TRUNC).";
    NOT_COMPUTABLE = "E0209" "expression has no value"
"Division by zero, root of a negative number, logarithm of zero, or a result beyond the range of a double. The control would stop
here too. Correct the expression, or the value of the variable that causes it.";
    BAD_WORD_VALUE = "E0210" "value not allowed for this word"
"A G, M, T, D, N, L or P number must be a whole number in range; a feed and a dwell must not be negative. A word that is not
possible in the current state has this code too: a tool direction without TRAORI, or a position of a modulo axis whose direction
is not determined. The message states the rule. Correct the value, or write the word where the state allows it.";
    NO_TARGET = "E0211" "jump target not found"
"The label or block number does not occur in the search direction: GOTOF searches towards the end of this program, GOTOB towards
its start, never in other programs. Correct the label; on a Sinumerik, GOTO searches in both directions.";
    NO_SUBPROGRAM = "E0212" "subprogram not found"
"The program calls a program that ncfix cannot find. Its moves are not known, so nothing is written. ncfix searches the file itself
(a section %_N_…_SPF) and the folder of the program, for NAME.SPF, NAME.MPF and NAME, also in lower case. L10 and L010 are
different programs. For a Fanuc or Haas, a file of another name with the line O1002 is the program of M98 P1002. If two files have
this line, ncfix takes neither.

Put the called program into this folder, or name its folder in search_path of [control]. If only the control has the program (tool
change, washing), name it in the machine file. The output then keeps the call with its values, and its moves are not corrected:

  [control]
  opaque = [\"TOOLCHANGE\", \"O9832\"]

Or with more details, such as whether it moves the axes:

  [[opaque]]
  name = \"TOOLCHANGE\"
  moves = true               the position after it is unknown";
    TOO_MANY_CALLS = "E0213" "subprogram calls nested too deeply"
"A Sinumerik has 16 program levels. A program that calls itself endlessly is refused here. Look for a program that calls itself, or
reduce the depth of the calls.";
    TOO_MANY_BLOCKS = "E0214" "more blocks executed than allowed"
"The program executed more blocks than --max-blocks. It may never end (WHILE TRUE, a backward jump). Nothing was written. Look for
a loop without an end. If the program does end, give a larger --max-blocks. ncfix simulate also reports this if the trace would
have more than 20 million rows, or if a chord of a move takes more than an hour.";
    MISSING_FEED = "E0215" "feed motion without a feed"
"G1, G2 and G3 need F, programmed earlier or in the block. The control stops here. Program F before this block.";
    DUPLICATE_NAME = "E0216" "name defined twice"
"A variable was defined twice in one program, or with the name of a function or keyword. Which one is meant is not known. Rename
one of the two.";
    SKIPPED_INTO = "E0217" "jump into a control structure"
"A jump led into a FOR loop whose start was not executed, so its end value is unknown. Jump to the FOR block instead.";
    CYCLE_ALARM = "E0218" "alarm of a cycle"
"A built-in cycle (drilling, pockets …) cannot run with these arguments or this tool; the control would stop with the alarm of the
same number. The message states the reason. Correct the arguments of the call, or select the right tool. If the message ends in
CHANGED SINCE CORRECTION, it is the check of --guard: a zero offset or a tool length has changed. Correct the original again.";
    BAD_ARGUMENTS = "E0221" "arguments that do not match the program"
"The call gives more arguments than the PROC block of the called program has parameters, or no variable for a VAR parameter, which
the called program changes.

  PROC HOLE(REAL DEPTH, VAR INT COUNT)      called as HOLE(-5, N_1) with DEF INT N_1

Correct the call, or the PROC block.";
    FULL_CIRCLE_UNSURE = "E0222" "full circle or very short arc"
"Start and end of an arc are so close that the resolution of the control decides between a full circle and a very short arc. A
control puts positions on a grid (Fanuc: increment system; Sinumerik: MD10200) before it compares them, so a full circle with a
computed start may be skipped, or a tiny arc may become a full circle.

  N10 G1 X0 Y-0.0004
  N20 G2 X0 Y0 I10 J0     a full circle on a grid of 0.001 mm, 0.4 µm on one of 0.0001 mm

Program the end of a full circle exactly at its start. For a Sinumerik state the resolution in the machine file: [control]
increments_per_mm = 1000.";
    NO_MOTION = "E0223" "program without a motion"
"The program was read but moves no axis, so there is nothing to correct, and an output would only look like a success. Nothing was
written. Check three places: blocks after the end of the program (M30), a subprogram that is never called, and skip blocks. Check
also whether the file is truncated.";
    MIXED_UNITS = "E0224" "inches and millimeters in one program"
"A Fanuc interprets its tool and zero offsets in the unit in force, so a corrected program keeps the unit of the program. This one
has both G20 and G21, so it has no single unit. Split it into programs with one unit each and correct them separately. A G10 before
the G20 of a program has the unit of the program before, which is unknown: write G20 before it.";
    BAD_SWIVEL = "E0235" "plane that cannot be tilted"
"CYCLE800 (Sinumerik) or G53.1 (Fanuc) tilts the plane in a way that is not supported, the rotary axes cannot align the tool with
it, or the retract position is not known. The message states which. Program the positions of the rotary axes and the frame
directly, or state the retract position with control.swivel_retract_z_mm.";
    BAD_POLAR = "E0230" "ambiguous polar position"
"A polar position (AP=, RP=) shares its block with an axis of the plane, angle or radius was never given since the pole was set, the
plane was changed after the pole, or the meaning of the value under G91 is ambiguous.

  G111 X40 Y20              pole
  G1 AP=30 RP=25            both in the first block after it
  AP=IC(15)                 then either of them

Program the pole in the plane in force, and write AC(…) or IC(…) under G91.";

    NO_SYSTEM_VALUE = "E0219" "system variable without a value"
"The program reads a system variable whose value is known only to the machine: machine data, an input, a measured position, the
tool in the spindle, an R or E parameter, #100 or a common variable that an earlier program has set. Where it affects motion, its value must
be known in advance. Or the program computes a new zero offset or tool value from the old one by something other than adding a
number.

Write a new offset as a sum, such as X[#5221+5.]. Give any other value in the machine file, with the name and indices that the
message shows:

  [system]
  \"$R[5]\" = 12.5
  \"$MN_INT_INCR_PER_MM\" = 1000
  \"$A_IN[1]\" = true";
    OWN_COMPENSATION = "E0220" "the program changes the machine's own compensation"
"The control has its own compensation: tables and a backlash value, with which it corrects its axes. This program changes them
($AN_CEC, $AA_ENC_COMP, $AA_QEC, $MA_BACKLASH of a Sinumerik, G10 L50 of a Fanuc, for example). The machine file describes the
errors that the machine had with the values of the day of the measurement. With other values the errors are others, and the
correction of ncfix would be wrong. Load the values into the control once, measure the machine with them, and remove these blocks
from the program.";
    LATHE_PROGRAM = "E0225" "lathe program"
"The program is for a lathe, and the machine file does not describe one. On a lathe the same words move the tool differently: G92 X
Z F is a thread cycle (on a mill it shifts the zero), G90 X Z F a turning cycle, X a diameter, U and W are increments of X and Z.
The message lists the evidence with line numbers. Choose another program: turning is not supported. If the program is for a mill
after all, state this with control.program_kind = \"mill\" in the machine file.";
    AXIS_IN_DOUBT = "E0226" "ambiguous axis after a rotation"
"The first block after G68, G51, G51.1 or their end names only one axis of the plane. Whether the other axis moves depends on a
parameter of the control (Fanuc 11600, bit 5, AX1): its last programmed value may apply in the new coordinates, or it may stay at
the current tool position. The message gives both positions. Program both axes, or set control.one_axis_in_rotation to \"value\" or
\"place\".

  G0 X10. Y0.
  G68 X0. Y0. R90.
  X20.                    Y is 0 or -10 in the turned coordinates";
    FORBIDDEN_STATE = "E0227" "code not allowed in this state"
"The control does not accept this code while another one is in force: a plane, a zero offset or a reference point within G68, G51 or
G51.1 of a Fanuc, G74 and G75 of a Sinumerik under TRAORI. The operator's manuals forbid it, and the resulting tool position is not
defined. End the state first. Some machine builders allow the codes within a rotation: control.codes_within_rotation = \"allowed\".";
    TWO_MEANINGS = "E0228" "word with two meanings"
"Similar controls interpret this word differently, and both interpretations are possible here: P10. of G4 is ten seconds on a Haas
and an invalid dwell on a Fanuc, M98 P30200 calls program 30200 once or program 200 three times, K of G73 is a depth or a number
of holes, M99 P70 in a subprogram jumps to N70 of the caller or of the subprogram. A missing word can have two meanings too: G79
of a MillPlus without the surface, after another hole. ncfix does not guess. State the setting that the message names, or write
the word in the other form that it gives.";
    LOST_PROGRAM = "E0229" "blocks that would be lost"
"A file may hold several programs, but only one of them is corrected. With --in-place the others would be lost: give another file
with -o, or put each program into its own file. The same applies to blocks that move before the first program number (O1234) of a
Fanuc: on the control they belong to no program, so the file is probably not what was intended. In a file that does not begin
with %, a % between blocks ends the program at many controls. The tool would stop there, perhaps in the material. Remove the %, or
the lines that do not belong to the program.";
    CORNER_DOES_NOT_FIT = "E0231" "rounding or chamfer does not fit"
"RND, RNDM, CHF or CHR requests a transition that is larger than the adjacent contour elements. A control would reduce it by its own
rule. Program a value that fits, or longer elements.

  N10 G1 X5 Y0 RND=10
  N20 Y20                 the first element has 5 mm, the rounding needs 10";
    BAD_COMPENSATION = "E0232" "radius compensation not possible here"
"G41 and G42 begin and end (G40) in a straight block with motion in the working plane; between them plane, mirroring and machine
coordinates must not change, and no more than control.compensation_blocks_between blocks without motion in the plane (Sinumerik
MD20250) are allowed between two contour elements. The radius may change in a straight block that continues in the direction of
the previous one. Elsewhere the path of the tool is not defined. Change the blocks as the message states, for example with G40
before the change.";
    CONTOUR_NOT_FOLLOWED = "E0233" "contour too narrow for the tool"
"With G41 or G42 the tool cannot follow the contour here: an inner arc is narrower than the tool, or an element is so short that the
tool center paths before and after it do not meet, even if up to control.compensation_look_ahead elements (Sinumerik MD20240) are
skipped. With CDON also: the tool would cut into another element than the one it follows. Use a smaller tool, or change the contour.";
    NO_WEAR = "E0234" "wear compensation at the control is not possible here"
"With --compensation wear the control compensates the tool center path by the wear alone. Programs for which this fails are
refused: a change of side, radius or register while compensation is on; an end of the program with it on; G43 and G44 of Grundig;
G41.1 and G42.1, whose diameter is in the program; --frame machine and --five-axis axes, where G41 is not allowed; --rapids all
and a --step below 10 mm, which cut the motion to the contour into pieces; a program that sets the radius in a register, so that
the control would apply it twice; and an output that the control could not follow completely with a wear of plus or minus
--largest-wear: smaller inner arcs of the tool center path, or shorter elements, such as the few micrometers that a correction or
backlash adds across the path. Change the program as the message states, give a smaller --largest-wear, or correct it without the
option; then add the wear to radius_mm in the machine file.";
    NO_ORIENTATION = "E0240" "tool direction out of reach"
"Under TRAORI the rotary axes cannot turn the tool to the programmed direction, at least not within their travel: for example a table
that tilts to one side only, or an axis at its limit. Check the direction (A3, B3, C3 run from the tip to the spindle) and
axis.….travel_deg.";
    THROUGH_POLE = "E0241" "orientation passes a pole"
"Between two directions the tool comes so close to the pole of the five-axis transformation (the tool along the rotary axis that is
nearest to the workpiece) that a rotary axis would have to jump or to turn very fast. There a control deviates from the programmed
orientation by its own rule (Sinumerik MD24530, MD24540; control.pole_limit_deg, default 2 degrees), which cannot be followed.

Move around the pole, end a block at it, or program ORIAXES: rotary axes then move in proportion.";
    CORNER_OVER_UNKNOWN = "E0242" "rounding or chamfer across an unknown effect"
"Between the two contour elements of a rounding or chamfer (RND, RNDM, CHF, CHR; ,R and ,C) there is something whose effect on the
motion is not known: the call of a program that the control itself executes, a stop (M0, M1, STOPRE, a read of $AA_ or $AC_
variables), a tool change, another zero offset, frame, tool length or plane, a message, words that are passed on. Whether and where
a control makes the transition then is not known. Move it before the first element or after the second one, or remove the
transition.

  N70 Y200 RND=10
  N75 L6                    with control.opaque = [\"L6\"]
  N80 X300";
    WAY_OPEN = "E0243" "ambiguous rotary direction"
"A modulo axis can reach the programmed position in two directions, and the program does not state which: DC(…) half a turn away in a
cutting move, ACP(…) or ACN(…) at the current position (no motion, or a full turn), or an absolute position whose direction depends
on a parameter of the control. The tool path differs between the two, so ncfix does not choose. Program the direction: ACP(…),
ACN(…), IC(…).";
    HEAD_CHANGE = "E0244" "head cannot be changed here"
"An M word of the machine file ([[head]], select) changes the head, and ncfix is not sure of the tool or the position here. This is
so while a tool length, a rotated or mirrored frame, a five-axis transformation or radius compensation is active, and in a block
with motion. A tool length then acts along another axis, and the head may move before, with or after the axes. End the state
before the word, write the word into a block of its own, then select the tool anew. After it, program X, Y and Z.

  N100 D0                   Sinumerik; G49 on Fanuc and RS274/NGC, T0 M6 on Grundig
  N110 M54";

    ALREADY_CORRECTED = "E0301" "program already corrected"
"The first comment states that ncfix wrote this file. Or this comment is missing, but the check of --guard or the marks of added
lines remain. Correcting it again would add the corrections twice. Correct the original.";
    OUT_OF_TRAVEL = "E0302" "position outside the travel of an axis"
"A position lies beyond the travel of an axis (travel_mm or travel_deg of [axis.X] in the machine file). In fix and check this is
the corrected position, in snc the position of the program. All values are positions of the axis in machine coordinates, as with
G53. They differ from the words of the program by zero offset and tool length. The message gives the axis, the limit and the
position: the end of the move if that is outside, otherwise the farthest point of the path. Check zero offset and tool length
first: a wrong one shifts the whole program.";
    CORRECTION_TOO_LARGE = "E0303" "correction larger than allowed"
"A correction exceeds --max-correction (default 0.2 mm; for a rotary axis, the arc at the tool counts). Milling machines in working
order have smaller geometric errors, so the reason is usually a wrong unit in the machine file, such as mm instead of µm. A
correction by a wrong amount spoils the part or breaks the tool. Check the units: ncfix machine show M.toml --at X…,Y…,Z… prints
the error of each source. If the machine really has such errors, as some routers do, allow them: --max-correction 2mm.";
    UNKNOWN_START = "E0304" "motion from an unknown position"
"A motion starts from a position that the program has not stated: an incremental move, an arc, or a drilling cycle without X and Y,
at the beginning of the program or after a tool change. The corrected program is absolute, so it would move to another position
than the original. The position is also unknown if the plane is tilted before the axes were positioned.

Program an absolute position of all axes before the block, for example G0 X0 Y0 Z100. At the beginning of a program, --start
X0,Y0,Z0 states it instead. If the tool change moves no axis, state that in the machine file:

  [[opaque]]
  name = \"M6\"
  moves = false

If a probe has stopped the axis (G31, G38.2), or the block gives a value to its position (G92, G10 L20), do not add a motion: it
would change the value that is measured or set. Measure and set the zero in a separate program, and do not correct that program.";
    UNITS_DOUBT = "E0305" "ambiguous units"
"The unit of a number depends on the control. Positions may stand before the first code of the unit, in a program that switches
between inch (G70, G700, G20) and metric (G71, G710, G21) later. Or a number has no decimal point, so a parameter of the control
decides between whole units and increments. State the unit in the first block, or the parameter with control.decimal_point in the
machine file.";
    NO_OFFSET = "E0306" "zero offset has no value"
"The program selects a zero offset that has no value in the machine file, so the position in the machine, and with it the correction,
is unknown. Add it to the machine file or to a set-up file given with --setup:

  [zero_offset.G54]
  X_mm = 350.0
  Y_mm = 200.0
  Z_mm = 80.0";
    NO_TOOL = "E0307" "tool has no value"
"The program activates a tool or cutting edge that has no value in the machine file; the correction depends on its length. Add it to
the machine file or to a set-up file given with --setup:

  [[tool]]
  number = 5
  edge = 1
  length_mm = 120.0
  radius_mm = 5.0";
    NOT_CONVERGED = "E0308" "no correction found"
"ncfix found no axis positions that bring the tool to the programmed point. The error model is far too large for this pose, or the machine cannot
move the tool in some direction. Check the units of the errors, and the directions and points of the axes in the machine file.";
    NO_AXIS = "E0309" "axis missing on the machine"
"The program moves an axis that is not in the machine's topology. Its motion could not be corrected. Use the machine file of the
machine that runs the program, or add the axis to topology with its section [axis.…].";
    WRONG_FILE = "E0310" "input and output are the same file"
"ncfix replaces the original program only with --in-place, and keeps the original as a .bak file. Choose another output, or give
--in-place.";
    CANNOT_ALIGN = "E0311" "programs cannot be compared"
"verify executes the original and the corrected program side by side. Their motions do not follow the same path, or the numbers of
moves differ. The corrected program was edited, or it was made from another original. Give the right pair of files, or correct the
original again.

A program with --guard can also end before its first move: it ends itself if a zero offset or tool differs from the correction. Then
these values have changed since. Correct the original again.";
    NO_SERVO = "E0312" "machine file without servo loops"
"The dynamic behavior of the axes can be computed only if the machine file describes it: [servo] with the interpolation cycle, the
smoothing and the tolerance of corners of the control, and [servo.X] for every axis with its velocity gain, its feed-forward and
its acceleration. Read these values from the control (Sinumerik MD32200, MD32610, MD32300), or let ncfix decompose find gain and
feed-forward in a trace. Write them into the machine file. docs/reference/servo.md has an example.";
    FEED_OF_ANOTHER_WAY = "E0313" "feed would apply to the correction"
"A cut turns rotary axes, and its feed is in degrees per minute or applies to a short path of X, Y, Z. Controls apply a feed to X,
Y and Z whenever these move, so it would apply to the micrometers of a correction, and the rotary axes would turn at full speed.
ncfix writes such blocks with their duration (G93). That is not possible if the language has no G93 (Grundig), or with a feed per
spindle revolution (G95, G96). Turn the axes at rapid there or, on a control that has G93, with a feed in G94. FGROUP with a
rotary axis is not possible with --five-axis axes: omit this option.";
    NEWER_FILE = "E0314" "output changed during the run"
"The output file was created or changed after this run began; with --in-place the program is no longer the one that was read. A
person, a CAM system or a second run has written it. A newer file is never replaced, and nothing of this run is written. Look at the
file, then run the command again.";
    HIDDEN_BLOCK = "E0315" "carriage return within a line"
"The file ends its lines with a line feed, and within a line there is a carriage return followed by text. Some controls end the line
there and read the rest as a separate block, even after a comment; others do not, and on a screen the rest may hide the beginning of
the line. The motion depends on the control, so ncfix does not guess. Replace it with a line feed, or remove it.";
    DECEPTIVE_TEXT = "E0316" "control character within a line"
"A line contains an invisible character that changes the display: escape, backspace, delete between words, one of U+0080 to U+009F,
or one that changes the text direction. The program on the screen then differs from the program that runs. Remove the character.";
    OTHER_ACT = "E0319" "corrected program differs in function"
"A correction changes positions, and divides moves into pieces. All other functions – spindle speed and direction, tools and their
offsets, coolant, M functions, dwells, stops, path modes, work offsets, calls, the end of the program – must occur in the
corrected program at the same position along the path. ncfix verify and ncfix diff compare them one by one. The message names what
is changed, missing or new, with its line in both programs. Make the change in the original, and correct it again.";
    OFF_PROMISE = "E0320" "deviation larger than the correction promised"
"The stamp of a corrected program states how far a piece may deviate from its exactly corrected path (--tolerance). At the ends of
pieces, between them, or where an axis reverses on an arc, this program deviates more on the error model. There are three usual
causes. The program was edited. It was corrected for another machine or state. Or ncfix fix has warned that the tolerance was not
reached (W0305, W0307) or that the position within the backlash is unknown (W0308). Give the machine file and the state of the
correction, or correct the original again.

The limit in the message is a little larger than the tolerance: 5 % for the path between the checked positions, and a quarter of the
largest rounding error. With a tolerance of 1 µm and positions in steps of 0.001 mm, this is 1 + 0.05 + 0.25 · 0.87 = 1.27 µm.";
    OTHER_FEED = "E0321" "corrected program has another feed"
"The pieces of a move have the feed of the move: the same number in the same feed mode, otherwise the same duration within 5 %.
Only --feed-limit lowers feeds, and the stamp states it. In this program a feed was changed. Change it in the original, and
correct it again.";
    NOT_COVERED = "E0322" "coverage by measurements is required and incomplete"
"With --require-coverage, a program is only released if measurements support its correction: every axis that moves has measured
errors, and positions, tool lengths, temperatures and the load are within the ranges of [measured] in the machine file. The message
states the gap. ncfix fix wrote nothing. Measure the missing range and calibrate, change the program, or correct without
--require-coverage after a person has looked at the warnings (W0316 to W0320).";
    STATED_MACHINE_MISSING = "E0323" "machine file of the program not found"
"A corrected program has the checksum of its machine file in its stamp, and a flat stream has the name of its machine. Without
--machine, verify, diff and snc use only this machine file. They search the nearest ncfix.toml, and the folders of the programs. A
file that has changed since has another checksum. Name the machine file with --machine; if it has changed, correct the program
again.";
    GROWS_TOO_MUCH = "E0324" "output longer than allowed"
"The written program would have more blocks per block of the source than --max-growth allows. Loops, subprograms, macros and milling
cycles are written as moves, and so are holes that would leave --hole-tolerance as a cycle. Nothing was written. Allow a larger
growth, choose a larger --tolerance, or correct the repeated part as a separate program.";

    DRIFT_VARIES = "E0325" "one shift of the zero cannot remove the drift"
"A shift of the zero offset moves every cut of a program by the same length. But since the zero was set, the machine has drifted by
different lengths at different places: within the part by more than --tolerance. Nothing was written.
Correct the program for this --state, or allow the difference with a larger --tolerance.";

    BAD_TOML = "E0401" "machine file is not TOML"
"The file breaks the rules of TOML 1.0 at this place, so none of it is used. Correct the line: a key needs '=' and a value, a text
quotation marks, a list brackets.";
    UNKNOWN_KEY = "E0402" "unknown key in the machine file"
"The key is not known in this section. A misspelled key would have no effect without notice, so it is refused. Correct the
spelling, remove the key, or move it to its section; the message lists the known keys.";
    MISSING_KEY = "E0403" "missing key in the machine file"
"A section lacks a key that has no default. The message names the key and the section. Add it with the unit that its name states;
docs/reference/machine-file.md lists all keys.";
    BAD_VALUE = "E0404" "value not allowed in the machine file"
"The machine file has lines of the form key = value. One value cannot be used: it is a text where a number is expected, for
example, or a number outside its range. A machine file with a wrong value would move the tool to a wrong position, so ncfix uses
nothing of the file. The message states which value is possible. Correct the line. If it is the name of the control,
docs/reference/machine-file.md lists the known names.";
    BAD_TOPOLOGY = "E0405" "invalid topology"
"The topology of a machine states which axis carries which. It reads from the workpiece w through the fixed bed F to the tool t.
In wCBXFZYSt, the workpiece is on C, C is on B, B is on X, and X is on the bed. On the other side of the bed are Z, then Y, which
carries the spindle S with the tool. Each axis letter X Y Z U V W A B C occurs at most once, S (optional) is just before t, and
every letter has its section [axis.…]. The order decides the sign of every error. Write the parts in the order in which they
carry each other.";
    UNKNOWN_COMPONENT = "E0406" "unknown error component"
"The name is not an error of this machine. For [[motion]], write E, a direction (X Y Z A B C) and an axis of this machine: EXX,
EAY. For [location], write E, a direction, 0 and an axis or S: EC0Y, EX0S. An error of an axis that the machine lacks would have
no effect. Correct the name, or add the axis to the topology.";
    WRONG_UNIT = "E0407" "wrong unit for this component"
"The unit of the key does not fit the component. EX, EY and EZ are displacements (values_um, amplitude_um, value_um); EA, EB and EC
are rotations (…_urad). Positions of linear axes are …_mm, those of rotary axes …_deg. Change the key, and check that the number
is in this unit.";
    BAD_TABLE = "E0408" "table positions do not increase"
"positions_mm (positions_deg) must increase strictly and have as many entries as the values. Otherwise the error between two
positions is not determined. Sort the positions together with their values, and remove repeated ones.";
    MISSING_SENSOR = "E0501" "temperature of a sensor missing"
"The error model of the machine file depends on the temperature of this sensor, and the given state has temperatures but not this
one. A drift that is computed without it would be wrong by an unknown amount. Add the sensor to the state, as a column T_NAME_C of
the log or as a key of [temperature_C]. Check that its name has the same spelling in both files.";
    DECEPTIVE_NAME = "E0409" "name with control characters"
"A text in the file contains an invisible character: a terminal control character (escape, backspace, bell, delete, U+0080 to U+009F)
or one that changes the text direction (U+202A to U+202E, U+2066 to U+2069). A report would then show something different from the
file. Write the name with letters, digits and signs.";
    OUT_OF_RANGE = "E0410" "number out of its range"
"A number is outside the range of any machine, or a list has too many numbers. Usually the unit is wrong, and a correction would
be wrong by the same factor. Check the unit in the name of the key. docs/reference/settings.md has the range of every key with
its reason.";
    BAD_HEAD = "E0411" "heads that do not fit together"
"The sections [[head]] of a machine file describe several spindles, or positions of a swivel head. Each has a name and the M words
that select it. A word selects one head, and has no other meaning at this control. Exactly one head has start = true. [spindle] is
for a machine with one spindle, so it is not allowed beside [[head]]; neither is control.grundig_head. Correct the sections as the
message states. An entry looks like this:

  [[head]]
  name = \"vertical\"
  select = [\"M54\"]
  origin_mm = [0, 150, 0]
  axis = [0, 1, 0]";

    DATA_NO_TABLE = "E0601" "measured data are not a table"
"Measured data are CSV: a line of column names, then rows with a cell for each of them. Cells are separated by commas, by
semicolons or by tabs; a text that contains the separator has quotation marks. UTF-8, with or without byte order mark, and any
line ends are accepted. Save UTF-16 and workbooks (XLSX) as CSV first, or read them with ncfix import.

  run,X,Y,Z,dx_um
  1,100,50,0,-3.2";
    DATA_COLUMN = "E0602" "column that does not match the machine"
"Every axis of the machine needs a column of its name (X, Y, Z, C …) with positions in mm or degrees. A column named after an axis
that the machine does not have, or a repeated name, is refused: the data are probably from another measurement or machine. Add the
missing column, or rename the wrong one. Readings of lengths are in µm: convert a column value_mm to µm, and name it value_um. A
log needs t_s and at least one temperature (T_head_C for the sensor T_head) or load_N. A table for weighing needs only the axis of
[strain] and strain_um_m.";
    DATA_CELL = "E0603" "cell that is not a number"
"A position, a tool length or a reading is a plain number: 12.5 or, if the separator is not a comma, 12,5. All cells have the same
decimal sign, no unit and no thousands separators. NaN is not a number. Cells must not be empty, with these exceptions: a missing
reading of the kinds direct and displacement, and temperatures and loads in a log. The direction of approach (X_dir …) is -1, 0 or
1, or empty. Temperatures are -60 to 400 °C, a weight is not negative, the time does not decrease. Correct the cell, or remove the
row if the reading failed.";

    DATA_REPEATED = "E0605" "reading given twice"
"Two rows of a measurement are identical to the last digit. A true repetition differs by the noise of the instrument; a copied row
would count twice and make the uncertainty too small. The message gives the first such row and their number. A table that is given
twice, or is also held out, is reported too, even if its readings are rounded or its rows are reordered. Remove the copies, and
give each table once.";
    LOAD_NOT_TOLD = "E0604" "strain readings do not determine the load"
"ncfix weigh weighs a workpiece by the change of a strain along an axis. The readings must lie where [strain] of the machine file
describes the gauge, at enough positions to separate the weight from the offset (and the drift, if there is a column t_s) of each
run. There must be more readings than unknowns, otherwise the uncertainty is not known. Measure every position twice. If two
readings of a position contradict each other, the disturbed one (a lubrication pulse) may not be identifiable; a third run shows
it. A negative weight means a wrong sign in [strain] or in the readings.";
    NOT_TOLD = "E0606" "errors not identifiable from the data"
"ncfix calibrate determines errors of the machine and unknowns of each set-up from readings. Here some of these affect the readings
in exactly the same way, or not at all, so their sizes cannot be determined: a least-squares solution would be one of infinitely
many. The message names them. Measure in poses in which they differ (other angles of the rotary axes, another tool length, a second
set-up, a known length), state what is known of the set-up (remove it from free), or choose a model with fewer parameters (ncfix
machine presets). ncfix diagnose reports this code unless there are at least three more readings than unknowns of the set-ups. It
also reports it if it did not write the file of -o; the causes in its output remain valid.";
    TERM_NOT_STORABLE = "E0620" "term that the machine file cannot hold"
"A term of ncfix calibrate --model needs an entry of the machine file, and no entry fits this one. Tables and grids hold
functions of positions and directions of axes. A temperature acts only as a drift along X, Y or Z ([[drift]]), or as the expansion
of an axis ([[expansion]]). For example, a straightness that changes with a temperature has no entry. The readings may show the
term: ncfix diagnose --hypothesis gives its amount and the evidence, but a program cannot be corrected for it. Remove the term from
--model.";
    NOT_SETTLED = "E0607" "calibration does not converge"
"The parameters still change after the last iteration. Either the model and the readings contradict each other, for instance in a
sign, a set-up or an axis, or some parameters hardly affect the readings. Or the fit ended, but the readings are farther from the fitted
machine than from a machine without errors, in all files or in one of several. Then the sign is usually wrong, or a table of the
control was active: name it in active_tables of the machine file. Check the description of the measurement, --machine, and rows
with large deviations.";
    DATA_SIZE = "E0608" "readings of an implausible size"
"Readings are in µm or µrad, as their column names state. A reading is above --max (for an angle, its effect at an arm of 1 m
counts), or the RMS of all readings is less than the uncertainty of the instrument. Probably values in mm or nm are in a column of µm,
or length_mm and centre_mm of the description are wrong. A parameter that would move the tool by more than --max is reported too.
Check the units of the columns. If the machine really has such errors, give a larger --max.";
    BAD_PARAMETER = "E0609" "not a parameter of this machine"
"A file for --model has one parameter per line, and comments after #. EC0X is a location error, EXX1 the coefficient of degree 1 of
a motion error, EXXb its backlash, EXX2@150 a truncated power that begins at 150 mm. load.EAX, drift.Y and expansion.X.scale are
parameters of loads, drifts, expansions and segments, which the machine file must have. The axis must exist, and each parameter may occur only once. Correct the
line; docs/reference/calibrate.md lists all forms.";
    DATA_FAULT = "E0614" "readings inconsistent with the machine file or the stated units"
"Before ncfix diagnose searches for causes it checks the data for faults. Here all readings of a measurement have one of these
faults: they are wrong by a factor of units (1000, 25.4); they agree with the model only if two axes are exchanged or one is
reversed; they fit only a machine with another order of the axes; or they lack exactly the errors of the machine file, because a
compensation table of the control was active during the measurement. Causes found in such readings would be meaningless. The
message gives the evidence. Change the columns, the machine file or active_tables as it states, or measure again.";
    DATA_SIGN = "E0619" "readings that do not follow a known move"
"The table has rows in which the tool was moved by a known amount (moved_um, moved_urad), and the readings do not follow it. With the opposite
sign, a correction would double the errors of the machine. Correct the sign, the unit or the component of the readings, then repeat
the sign test. ncfix plan laser --variant signs plans one.";
    BAD_HYPOTHESIS = "E0615" "hypothesis that cannot be read"
"ncfix diagnose --hypothesis tests a term: a deviation and what it depends on, such as EXX ~ Y^2 or EYY ~ T_head_C lag 600s, or a
cause by the name that findings have, such as backlash EXX. Here the text is not complete, or it names an axis that the machine
lacks, or a column that the data lack. The line is the number of the hypothesis, and the column the place in it. Correct the text
at this place. docs/reference/terms.md has the grammar.";

    DRIFT_NOT_TOLD = "E0613" "drift that cannot be separated from backlash"
"A drift that is a straight line in time within a back-and-forth cycle makes the backward and forward readings differ more, the
farther a position is from the turning point; backlash or lateral play makes them differ equally everywhere. A drift is removed only
where there is no backlash: the model has none for the component (EXXb; for length readings also EBXb, through its Abbe
offset), and the readings show none by Student's t-test at the 0.1 % level. Each cycle must run in both directions. Remove
\"drift\" from free and let the machine warm up first, measure faster, or remove the backlash from the model if there is none.";

    IMPORT_QUESTION = "E0616" "import needs an answer"
"No file of an instrument contains all that a calibration needs. `ncfix import` asks for the rest on a terminal. In a script it
names the option that answers the question, and writes nothing. It does not guess: a wrong sign doubles an error instead of
removing it. Give all answers as options, for example:

  ncfix import laser.csv --axis X --at Y200,Z100 --sign + --unit um --tool 120 --material 20C -o laser

If the file may have two formats, --as names one.";
    IMPORT_FORMAT = "E0617" "file in no format that import reads"
"The content of the file matches no format of `ncfix import --list`, or the file is not text. Project files of instruments are
usually binary or databases: export the readings as text or CSV from the software of the instrument. A table with unusual headings
can be read with --as targets and --columns. Use a decimal point in numbers if commas separate the cells. If every number
contains a comma, you get this code; if only some do, you get E0601.";
    IMPORT_CONTRADICTION = "E0618" "file contradicts what it seems to be"
"The content of the file does not agree with the options of `ncfix import`, or with itself. Examples are a position outside the
travel of the machine, a deviation that is not actual minus nominal, a measured axis that the machine lacks, a unit that the
heading contradicts, an option that has no effect on these readings. Correct the option, or export the file again.

Targets usually count from a zero of their own, not from machine zero. --at X-600 states that target 0 of the file is X-600 of the machine.
For the other axes, --at gives the machine positions at which they stood.";
    NOT_FOR_LINK = "E0701" "line that the link cannot send"
"The program has a line that cannot be sent over this link. Nothing was sent. There are four reasons; the message states which. With --sensors,
temperatures can add words and digits to a line while the job runs.

- The line is too long for the control. Omit blanks, block numbers and comments, or choose a larger --increment.
- The line has a character with another meaning: Grbl takes ! ? ~ out of the stream wherever they occur. Remove the character.
- The control does not read the language of the program, and could move its axes elsewhere. Choose the right link.
- The control does not execute a word over this link: over the link linuxcnc, LinuxCNC does not stop at M0, M1 and M60, and takes
  no O words. Grbl has no M6, no G43 with a number, no cycles and no variables. With the controller grbl in the machine file, cycles
  and variables become moves. Marlin has no tool change, and other meanings of G10, G28 and G61. End the program at M0 and send
  the rest later, or load the corrected program into the control.";
    STARVED = "E0702" "the link cannot keep up with the motion"
"The link is slower than the motion: the control would run out of lines. The axes then stop within a cut and leave marks on the
surface. The message states the place, the lines per second that the motion needs there, and the lines per second that the link
carries. A link that accepts one line at a time stops the axes at the end of each line. Nothing was sent.

Choose a larger --tolerance, which gives fewer lines, or omit block numbers. Set a higher baud rate at both ends. Or write the
program with ncfix IN -o OUT, and load it into the control. --allow-starvation sends it in spite of the stops.";
    UNFINISHED_JOB = "E0703" "journal of an unfinished job"
"The journal of this transfer already exists, and shows that the job was aborted. It is not known whether the last lines were
executed, so ncfix keeps this journal. Look at `ncfix resume JOURNAL`, remove the journal, or give another one with --journal.";
    OTHER_JOB = "E0704" "not the job that was aborted"
"A job can be resumed only with the program, machine file, state and version with which it began. With others the sent lines
cannot be distinguished from the rest, and the correction would jump. Nothing was sent. The message states what has changed. Give
the same files again.

After a broken tool, a new tool of another length is such a change: its length is in the machine file, and all corrected
positions depend on it. Then this job cannot be resumed. Lift the tool by hand and enter the new length at the control and in the
machine file. Then remove the journal and feed the program from its beginning, or start a corrected file at the control with a
block search.";
    IDLE_UNKNOWN = "E0705" "standstill of the machine not confirmed"
"Lines sent to a machine that executes something else, is held or waits at an open door interfere with that job. Some controls are
queried: Grbl and grblHAL for their state, Marlin for completed moves, LinuxCNC and LSV/2 for their status; they get no line
unless they are idle. RS-232 links without answers and the blockwise transfer of Heidenhain have no such query. Look at the
machine, and confirm with --i-checked-the-machine-stands-still. Nothing was sent.";
    NOT_CLEAR = "E0706" "no safe place to resume"
"Give --clearance. An aborted job is resumed only at a height that the operator has stated to be clear of workpiece and clamps
(--clearance 25mm, Z of the program): the tool crosses to the place at that height from its current position. The program
continues at the end of one of its retracts, with the rapid move that follows; the approach down to it is at a slow feed. If no
such place is known, or the state of the control there cannot be restored, only a restart from the beginning remains. This works
only if the first move of the program lifts the tool, or a lift can be put before it. After a tool change or a length offset, Z
has another meaning. If it is not possible, lift the tool by hand, remove the journal and feed the program from its beginning.
Nothing was sent.";
    CLEARANCE_TOO_LOW = "E0707" "clearance too low, or out of the travel"
"The height of --clearance is not possible. It is a Z of the program, at which the tool moves across the workpiece to the place
where the job continues. It must be at least 1 mm above everything that the program machines: every point of every feed move
counts, including the start of a plunge and the top of an arc. At a lower height the tool could cut through the workpiece. It must
also be within the travel of Z, with the zero offset and the tool in force there. Nothing was sent. The message states both
limits. Give a height between them that is clear of workpiece and clamps.";
    BAD_SET_POINT = "E0801" "line is not a set-point"
"A line of the input of ncfix realtime is not a set-point: a word that is not an axis of the machine, a malformed number, an axis
whose position was never stated, too many or too few cells, an empty line. The run ends, because the machine must not move on a
guess. Every line before it was answered, in order; the control must hold the last correction, or stop. The message has line and
column. Correct the program that sends the set-points.";
    BAD_TABLES = "E0901" "compensation table that cannot be read"
"A file of compensation tables for ncfix tables --read, or for machine.active_tables, violates its format: a malformed number, an
axis that the machine does not have, a product with a missing table, or a field that is not written or has two different values (the
control keeps its previous value, which is not known). None of it is used, because half a compensation moves the tool to a wrong
position. Correct the line, or give the format (--format) or the axes (--axis-name X=AX1).";
    TABLES_DO_NOT_FIT = "E0902" "tables that the control cannot store"
"The tables of the scheme are more, longer or larger than the control can store, or of a kind that it does not have. Nothing was
written. Choose another --scheme (auto looks for the fewest tables), a larger --tolerance, fewer --points, or another --format;
ncfix tables --list shows what each has.";
    TABLES_MAKE_WORSE = "E0903" "tables increase the error"
"The tables were evaluated as the control interpolates them, at poses all over the volume of use, and the error of the tool tip, or
of its direction, is larger with them than without. Nothing was written, because they would make the machine worse. The scheme does
not suit the errors of this machine: own has a table for each axis over its own position and ignores the effect of one axis on
another; a grid ignores rotary axes. Use another --scheme (auto tries them all), the --tool that is used, --orientation off, or
another --format; ncfix tables --list shows what each has.";
    CORRECTION_MAKES_WORSE = "E0904" "correction increases the error"
"The residual error of the corrected program is larger than the error of the original program, and larger than the tolerance.
Nothing was written, because the program would become worse. Usually the increment of the output is coarser than the error to be
corrected, or --tolerance is larger than the error. Choose a smaller --tolerance, or a smaller --increment if the control reads
it; otherwise run the original.";
    SKIP_EXECUTED = "W0201" "skip blocks executed or skipped"
"Blocks with / were executed (or skipped with --skip), and the output contains no /. The skip switch at the control therefore has
no effect on it. Choose the blocks with --skip now, as the switch will be set; for both positions of the switch, correct the
program twice.";
    FEED_ASSUMED = "W0202" "feed motion without a feed"
"G1, G2 and G3 need F; the control stops at this block. snc, diff and verify accept the motion without a feed; check and fix refuse
the program (E0215). Program F before this block.";
    MORE_PROGRAMS = "W0203" "further main programs in the file"
"The file has more than one main program (%_N_…_MPF, %PM, O1234). The first one is executed; the others are executed only if it
calls them. Put each main program into its own file. Lines after the % that closes the program belong to no program, and are
ignored too.";
    LEFT_OUT = "W0204" "statement omitted from the output"
"The program has a statement that the output does not have. WRITE and DELETE change files of the control: with the output, the
control does not write its log file, for example. In ncfix their result variable has the value 0, which means no error. The
motion does not change. Tables of tools and zero offsets in the transfer of a Grundig program (%TM, %ZO) apply to the run and are
not written either. Load the same tables into the control before it runs the output.";
    NOT_CORRECTED = "W0205" "moves that are not corrected"
"SETINT lets an input of the control interrupt the program and start another one, which runs unchanged on the control. Its moves
are not corrected. Correct that program too, or accept its errors if it only retracts the tool.";
    WATCHED_ONCE = "W0206" "synchronized action of one block"
"A synchronized action without ID acts while the next block is executed. If the correction divides the move of that block into
pieces, the action is active only during the first piece. Check the output at this place. If the action must act longer, give it
an ID and cancel it after the move.";
    TAPPING_BY_FEED = "W0207" "tapping by feed moves"
"A tapping cycle (G84, G74) becomes a feed move into the hole, a spindle reversal, and a move out. Spindle and axis are not
synchronized as they may be in the cycle of the control. Use a compensating chuck, as older controls always require, and keep the
override at 100 %.";
    UNUSUAL_MOTION = "W0208" "motion that depends on the control"
"Parameters of the control decide the motion of this block. Such a block is often an error of a post-processor.

- Arc without center and radius: a Fanuc moves in a straight line. With parameter 3403 bit 5, it stops with alarm PS0022.
- Arc whose center fits only the start: a Fanuc that does not compare the radii (parameter 3410 is 0; control.arc_radius_check =
  false) makes a spiral.
- G73 or G83 without Q, or with Q0: a Fanuc drills in one stroke. With parameter 5103 bit 1, it stops with alarm PS0045.
- G12, G13 and G72 of a Haas: the control has its own path between the circles, and its manual does not state where G72 drills
  first.

Check this block in the program. The message states the moves of the corrected program: compare them with those of your control.";
    CORNER_LEFT_OUT = "W0231" "no rounding or chamfer made"
"After the block with RND, CHF or CHR no motion in the working plane follows within three blocks, or a motion of other axes comes
first. A control makes no transition then, and neither does ncfix: the corner stays sharp. Move the other blocks if the corner
must be rounded: before this block, or after the next contour element.";
    COMPENSATION_LEFT_ON = "W0232" "radius compensation still on at the end"
"The program ends with G41 or G42 in force. The tool stops next to the end of the last contour element. End the compensation with
G40.";
    ELEMENT_LEFT_OUT = "W0233" "contour element skipped"
"The tool is too wide for this contour element; its path goes from the previous element to the next one, as on the control. Some
material remains. Check that the correct tool is selected.";
    CONTOUR_DAMAGED = "W0234" "tool cuts into the contour"
"With G41 or G42 the tool comes closer to a contour element than its radius while it follows another one: a slot or notch is
narrower than the tool, a spiral too tight. The control does the same if collision monitoring is off (CDOF); with CDON it skips
what the tool cannot reach, up to control.compensation_look_ahead elements (Sinumerik MD20240). ncfix checks up to three times
this number of elements on each side. Check whether a smaller tool is intended.";
    EITHER_WAY = "W0235" "rotary axis may turn in either direction"
"A rapid motion turns a rotary axis by exactly half a turn in the shortest direction (DC). The control may turn in either
direction. The word is unchanged in the output, but its position is corrected by a few thousandths of a degree, which may reverse
the direction. The end position is the same. Check that the axis may turn in both directions there, or program ACP or ACN.
CYCLE800 has no such words: position the rotary axes before it, or choose the other solution with _DIR.";
    WEAR_WITHOUT_EFFECT = "W0236" "radius compensation is replaced by the tool center path"
"The program uses G41 or G42 (Grundig: G43 and G44 too), and the corrected one has the tool center path instead, for the radius of
the tool in the machine file. The control no longer uses its own radius: another radius or wear entered at the control has no
effect on this program. Enter a new radius or new wear in the machine file instead: radius_mm of [[tool]], wear included, or a
set-up file (--setup also takes the tool table of the control). Then correct the program again. Tool lengths and their wear are
not affected.";
    WEAR_ALONE = "W0237" "radius at the control must be 0 plus wear"
"The program was corrected with --compensation wear: it has the tool center path, for the radius of the tool in the machine file,
and G41 or G42 in addition, so that wear entered at the control keeps its effect. The control must therefore have the radius 0 for
these tools, plus the wear. If it still has the radius of the tool, it offsets the tool twice: too far from the part outside, into
the wall or to an alarm inside. Set the radius in the register (D number) to 0 before this program runs and enter only the wear.
Restore it before any other program uses that register, or give this program its own register. In the machine file, radius_mm is
the radius of the tool without this wear. See docs/reference/output.md.";
    MOVES_NOTHING = "W0238" "no axis is moved"
"The program was executed, and no axis has moved: a correction of it would be refused (E0223). For a file of definitions or
subprograms this is correct. Otherwise something is missing. Check whether its blocks are after the end of the program (M30), in a
subprogram that is never called, or in skip blocks, and whether the file is truncated.";
    OWN_STROKES = "W0239" "milling cycle: the tool path comes from ncfix"
"Controls do not publish the moves of their milling cycles (POCKET3, SLOT1, CYCLE72, G87 of a Grundig). ncfix mills the same shape,
with the programmed depths, allowances, feeds and direction, but with passes and plunges generated by ncfix. A comment
precedes them in the output. Check them like those of a new program. To have the moves of the control, give ncfix its cycles as
files (control.search_path). To let the control execute the cycle without a correction, name it in control.opaque.";
    START_ASSUMED = "W0240" "state at the start of the program assumed"
"Fanuc, Haas and RS274/NGC controls keep the unit of lengths (G20, G21) of an earlier program, of a setting or of the startup code.
An RS274/NGC control also keeps the return of drilling cycles (G98, G99). The program states one of them too late or not at all, and
so does control.startup_code. ncfix assumes the usual start: millimeters, and G99. The corrected program states G21. If the control
has G20, all lengths are wrong by a factor of 25.4: Z1. is then 1 mm above the part. If it has G98, an RS274/NGC control would
return to the initial level between holes. A cycle in the corrected program states neither word, as in the original. If cycles
become moves, they return only to R: a clamp may be in the way. Write the word at the beginning of the program, or state startup_code
in [control].

Or a program of RS274/NGC moves with G28 or G30, and no file states these positions. The output then moves to the machine zero, where the
control would move to its own position. Give the file of the control with --setup.

Or a program reads an R or E parameter, or a variable such as #500, that keeps its value between programs and that it has not set.
On a Fanuc, #100 to #499 may keep theirs too (parameter 6001, bit 6). There snc uses 0, for a variable of a Fanuc null. At the control, the moves that depend on it can differ. check, fix and feed
refuse the program (E0219). Set the value in the program, or in [system] of the machine file.";
    NOT_AT_THIS_CONTROL = "W0241" "words that the control does not have"
"controller names a firmware of the Grbl family, and the output has words that this firmware does not document. Grbl 1.1 has no
M6, no G43 with H and no P for several turns, for example. The control answers such a line with an error and executes nothing of
it, not even its moves; many senders then stop. A line that begins with $1 would change a setting of the control. Only some
builds have M7 (mist): without it, the spindle code in the same line has no effect either. The original program has the same
words. Remove them, or choose the post-processor of this control. feed refuses words that no build has (E0701). ncfix writes
drilling cycles (G81), variables and O words as moves where the firmware lacks them. If the control is another one, correct
controller in the machine file.";
    MAY_SET_OFFSETS = "W0242" "measuring program may set offsets"
"The program calls a measuring program that the control itself executes (opaque in the machine file). With these arguments it sets a
zero offset or the length or radius of a tool to the measured value. ncfix cannot know this value. It corrects the blocks after the
call for the values of the machine file. On most machines, a difference of some tenths of a millimeter changes the correction by less
than a micrometer. A difference of many millimeters can change it by more. Compare the measured value with that of the machine file
after the first run. If they differ much, enter the new value there and correct the original again. Or measure in a program of its
own, give the offsets of the control with --setup, and then correct the program that cuts.";
    VALUE_FIXED = "W0243" "value of the control becomes a number"
"The program reads a zero offset or a tool value of the control, and computes a position or a condition from it: Z=$TC_DP3[1,1]-80,
IF[#2001GT100.]. The output has the number, or the branch, that the values of the machine file give. If the control has another tool
or offset, the original would follow it, and the output does not: a retract can then be too low. Correct the program again after each
change. With --guard, the control compares zero offsets and tool lengths before the first motion; it does not compare radii. Only
the first such place is reported.";
    STEPS_UNDER_G90 = "W0244" "cycle levels from G91 under G90"
"A drilling cycle of a Fanuc or Haas began under G91, where R is counted from the initial level and the depth from R. A later hole of
the cycle is under G90 and does not repeat R or the depth. ncfix drills it between the levels of the first hole, as it does in the
opposite case (G90 first, then G91 X10. K5). No manual states that every control keeps the levels. A control that reads Z-12 as a
position would drill to another depth, or move to R inside the part. Write R and the depth in the first block after G90. Only the
first such hole is reported.";
    OTHER_LENGTH = "W0245" "length offset of another tool"
"A program of a Fanuc or Haas has one tool in the spindle and the H number of another one. The machine file has both lengths, and they
differ by more than a millimeter: G43 H2 with T1 is mostly a mistake, and the tip then cuts too deep or in the air. ncfix corrects
the program with the length of H, as the control does. Compare the T and H numbers. If one tool has two offsets with lengths that
differ so much, nothing is wrong. Only the first such block is reported.";
    GROWING_OFFSET = "W0246" "each run changes a zero offset again"
"The program adds to a zero offset, for example with $P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+10, G91 G10 L2 or X[#5221+10.], and does not take
the change back. The next run begins with the changed value. ncfix corrects for the values of the machine file or of --setup, that is
for one run. After ten runs with 10 mm each, the part is 100 mm away, and the correction there is that of another place. Correct the
program again before each run, with the new values. Or set the offset to a number at the start of the program, or back at its end.";
    RADIUS_ZERO = "W0247" "radius compensation with radius 0"
"The program uses G41 or G42 (Grundig: G43 and G44 too) with a tool whose radius is 0 in the machine file or in the data of the control.
The corrected program then moves the tool center along the programmed contour. If only the radius is missing, the tool cuts into the
part by its radius. State radius_mm of the tool in [[tool]], or give --setup a file that has it ($TC_DP6 of a Sinumerik, L12 of a
Fanuc), and correct the program again. If the program already has the path of the tool center, a radius of 0 is right.";
    OFFSET_ASSUMED = "W0302" "zero offset assumed zero"
"The machine file has no value for this zero offset. snc uses zero, so its positions in the machine are wrong. check, fix, diff and
verify refuse the program. State the zero offset in the machine file or in a set-up file (E0306 has an example).";
    TOOL_ASSUMED = "W0303" "tool assumed without length and radius"
"The machine file has no value for this tool. snc uses length and radius zero, so its positions in the machine are wrong. check,
fix, diff and verify refuse the program. State the tool in the machine file or in a set-up file (E0307 has an example).";
    NO_MACHINE = "W0304" "demo machine used"
"Neither --machine nor the environment variable NCFIX_MACHINE names a machine file, and there is no ncfix.toml in this folder or
above it, so the embedded demo machine was used. The output is corrected for the errors of that machine, and on yours the
correction is wrong. Do not run it on a real machine. The verdict is therefore never better than: check it before it runs. Give
your file with --machine, or save it as ncfix.toml in the folder of the programs, and correct the original again.";
    TOLERANCE_NOT_REACHED = "W0305" "tolerance not reached"
"The output deviates from the exactly corrected path by more than --tolerance at some places. The pieces there are already as
short as 0.01 mm, or as the increment. Either the tolerance is finer than the increment, or the error model has a step there, or
an axis must reverse by less than its backlash. Tapping stays one cycle even if the tip leaves the tolerance, because pieces
would lose the synchronism of spindle and axis. The message states the deviation. Choose a finer --increment that the control
reads if the deviation is too large, otherwise a larger --tolerance.";
    OTHER_STAMP = "W0306" "corrected for another machine file, state or original"
"ncfix writes a stamp into each corrected program: a comment with checksums. A checksum is a short number that ncfix computes from
all characters of a file. If one character of the file changes, the checksum changes. Here the checksum in the stamp differs from that
of the machine file, state or original that you gave: the file was changed, or it is not the one of the correction. Each correction
is valid for one machine in one state. The errors in the result are those of this program on the given machine in the given
state. Give the files of the correction. If tools, zeros or errors have changed since, correct the original again.";
    ONE_PIECE = "W0307" "move that cannot be divided deviates"
"Threads (G33, G34, G35, G331, G332, G63) and positioning axes (POS) are not divided into pieces: spindle and axis would lose
synchronism, or the axes would stop in between. The end of the move is corrected, but along the path the deviation is larger than
--tolerance. The message states it. Accept the deviation, or replace POS by G0 or G1.";
    SENSE_UNKNOWN = "W0308" "side of the backlash unknown at a cut"
"The program cuts while it is unknown on which side of its backlash an axis is: the axis came from an unknown position, for example
after a tool change. ncfix assumes the middle. The cut may therefore be wrong by half of the backlash, until the axis has moved by
more than its backlash in one direction. Program a motion of this axis by more than its backlash before the cut. If no tool change
comes between, --start with the first position helps as well.";
    FEED_LIMIT_MISSED = "W0309" "path deviation larger than --feed-limit"
"With --feed-limit, ncfix fix lowers feeds where the axes would deviate too far from the path. On this block that was not enough:
its feed is at the lowest value tried, 5 % of the programmed one; or it is inverse-time (G93) or that of a thread, which are not
changed; or a lower feed does not help, because the deviation occurs while the axes accelerate from rest. At a corner the lag of
one block may reach into the next one. The program is written with the best feeds found. Program an exact stop at the corner (G9,
G60; G61 if the control has it), so that the axes arrive first, or increase the feed-forward of the drives. Otherwise allow a
larger --feed-limit.";
    NO_STAMP = "W0314" "corrected program without its stamp"
"ncfix fix writes a comment in the first lines that states machine, model, state and source of a corrected program, and its
promised tolerance. This program has no such stamp: it was not written by ncfix, or the stamp was removed or changed. Its validity
is not known; the tolerance of --promised, or 1 µm, is assumed. Correct the original again before you run it.";
    PROMISE_ASSUMED = "W0315" "tolerance of the correction assumed"
"The stamp of the corrected program does not state its tolerance. The tolerance of --promised is used, or 1 µm, the default of
ncfix fix. Give the right one with --promised if it was another.";
    AXIS_WITHOUT_ERRORS = "W0316" "axis without measured errors"
"The axis moves while the tool cuts, and the machine file has neither an error that depends on it nor its range in [measured]. Its
errors are unknown, not zero: the correction leaves them on the workpiece, and the predicted residual does not contain them. Measure
the axis and calibrate. If it was measured and has no error worth a correction, state its range in [measured].";
    BEYOND_MEASURED = "W0317" "position beyond the measured range"
"An axis goes beyond the range of [measured] in the machine file or, without it, beyond the positions of a table of this axis. The
error model is extrapolated there: a polynomial may rise steeply, a table keeps its last value. The positions in the message are
those of the axis in machine coordinates, not of the tool tip. The message states how far, and the part of the error at the tool
tip that no measurement supports. Only feed moves count, unless the program has none. Measure the missing range and calibrate;
for a linear axis you can also clamp the workpiece at another place. Otherwise decide whether the extrapolated part is small
enough.";
    TOOL_BEYOND_MEASURED = "W0318" "tool length beyond the measured range"
"Angular errors and rotary axes move the tool tip in proportion to the tool length. This tool is longer or shorter than all tools
with which the machine was measured ([measured] tool_length_mm), so its error is extrapolated. The message states the extrapolated
part. Measure with a tool or stylus of about this length and calibrate if this part is too large. With one tool length, the
readings show the angle between two linear axes (EB0Z, EA0Z), but not the tilt of the spindle against its axis. ncfix then assumes
that the spindle is tilted as its axis is. Measure the circles or balls with a second tool length, and calibrate with EA0S and EB0S.";
    RANGE_NOT_STATED = "W0319" "measured range of an axis not stated"
"The machine file has a section [measured] without the range of this axis, which moves and has errors. Whether they hold at these
positions is unknown. Add the range, as docs/reference/machine-file.md describes.";
    STATE_BEYOND_MEASURED = "W0320" "temperature or load beyond the measured range"
"A temperature or the weight on the table is beyond the range in which its effect was measured ([measured] temperature_C, load_N).
The effect is extrapolated by the error model. Measure in this condition and calibrate, or wait until the machine is within the
range.";
    ZERO_NOT_STATED = "W0321" "method of setting the zero not stated"
"Nothing states how the zero offset was set. It therefore counts as touched off with the tip at the workpiece zero: it contains
the error of the machine at that point, and only the difference from this error is corrected. If the zero is the true position in
the machine, the cut is wrong by this error.

Temperature and weight count differently. Without a stated method or time, their effect is corrected from the reference
temperature and the empty table. A zero that was touched off on the warm or loaded machine already contains this effect, and the
correction is then too large by it.

If the machine file says \"absolute\" and the set-up file gives a new value, somebody has set the zero since. If they touched
off, \"absolute\" is no longer true.

State the method: set = \"touched\", \"probed\" or \"absolute\" in [zero_offset.NAME], or --zero G54=touched. State the time with
--zero-time. docs/how-to/set-the-zero.md has examples.";
    UNKNOWN_CUT = "W0322" "cut at a position that is not known"
"The program has a feed move while the position of a linear axis is not known. Either no earlier block states it, or a program
that the control itself executes has moved the axes. The errors of the machine depend on this position, so the correction there
is incomplete, and the predicted errors do not count the move. Program a position for these axes before the cut. --start gives their position at
the beginning, and it holds until the first tool change. After a tool change, G1 moves in the plane are treated as the approach.
State Z with a rapid move, or after G43, before you cut.";
    ROTARY_ASSUMED = "W0324" "position of a rotary axis assumed"
"The tool cuts, and the position of a rotary axis of the machine is not known. Either nothing has stated it yet, and ncfix takes it to
be at 0°, as programs for three axes expect. Or the axis may have moved since its last motion in the program: at a reference point
(G74), or in a program that the control executes, for example one that changes the tool. ncfix then takes it to be where the program
moved it last; M6 itself leaves rotary axes where they are. The message states the position. If the axis is elsewhere, the workpiece is turned, and the correction acts in wrong directions.

Program the axis before the cut. A position at the beginning can also be stated: with start_deg in the section of the axis if every
program begins there, or with --start, which holds until the first tool change.";
    SHORT_BLOCKS = "W0325" "blocks shorter than the block cycle"
"[control] block_cycle_ms states the time that the control needs to prepare a block. To stay within the tolerance, ncfix has
divided a move into blocks that take less time at their feed. The tolerance has priority; the control slows down along these
blocks, and surfaces may show it. Choose a larger --tolerance, which gives longer blocks, or a lower feed, which gives more time
for each.";
    ZERO_LENGTH_NOT_STATED = "W0326" "length of the tool at the touch not stated"
"A touched zero contains the error of the machine where the tool touched, and this depends on the length of the tool or probe: a
longer one touches at a higher position of the axes. Without a stated length, the first tool with which the program cuts in this
zero counts. If another tool or a probe touched, all cuts are displaced by up to the size in the message. State the length:
--zero G54=touched@L110, or tool_length_mm in [zero_offset.NAME.set_at]. See docs/how-to/set-the-zero.md.";
    ZERO_TURNED = "W0335" "rotary axes at the touch not stated"
"A touched zero contains the error of the machine at the touch. On a machine with rotary axes this error depends on their angles,
and the statement about the touch has positions of linear axes only. ncfix assumes that the rotary axes were at the zero of this
offset. If one was at another angle, all cuts are displaced by up to the size in the message. State the angles: --zero
G54=touched@X300,Y-198,Z-320,A0,C0,L120, or A_deg and C_deg in [zero_offset.NAME.set_at].";
    BACKWARD_TOOL = "W0327" "negative tool length"
"A tool of the program has a negative length, as on a control whose lengths count from the machine zero or from a reference tool.
The axis positions are then still right, but ncfix needs the distance from the gauge point of the spindle to the tip: angular errors
and rotary axes act over this length, like a lever. With a wrong length, their correction is wrong. State the real lengths, and Z
of the zero offset for these lengths. See docs/how-to/fanuc-from-start-to-finish.md.";
    ZERO_NOT_USED = "W0328" "stated zero offset not used"
"--zero states the method of a zero offset, and no axis of the program moves in this offset. The statement has no effect. The offsets in
which the program does move count as the machine file states, or as touched. Check the name: often it is wrong, or the program selects
another offset than expected. If the message names no offset, the program moves in the coordinates of the machine (G53, or G500 without values):
its positions are true positions, and no touched zero is subtracted.";
    SQUARENESS_NOT_SHOWN = "W0330" "squareness that no measurement shows"
"Both axes move while the tool cuts, and no reading of the calibration shows the angle between them. The list not_shown in [measured] of
the machine file names this squareness. A laser measures each axis alone, and a straightness whose reference was aligned by hand shows no
slope. Or the readings show the angle, and --model of the calibration lacked it (W0620). The squareness is unknown, not zero: the
correction leaves it on the workpiece, and the predicted error does not contain it. Measure it, for example with a ball-bar or a square, and calibrate again.";
    ZERO_OUT_OF_REACH = "W0331" "zero offset outside the travel"
"machine check found a zero offset whose zero no tool of the machine file can reach. For X and Y, its value is outside the travel. For
the axis along the spindle, it is outside with every tool. Mostly a sign or a digit is wrong, or the value is that of another machine.
Compare it with the control. On a part that is longer than the travel, the value may be right.";
    COMPONENT_NOT_SHOWN = "W0332" "error of an axis that no measurement shows"
"An axis moves while the tool cuts, and no reading of the calibration shows one of its errors: the positioning along its own direction (EXX), its
straightness across it (EYX, EZX), or one of its angles (roll EAX, pitch and yaw EBX, ECX). For a rotary axis, it is the place where it stands (EX0C)
or its inclination (EA0C). The list not_shown in [measured] of the machine file names them. A laser for positioning shows no straightness, two
measured diagonals show only a squareness, and an autocollimator shows no place of a rotary axis. These errors are unknown, not zero: the
correction leaves them on the workpiece, and the predicted error does not contain them. Measure them and calibrate again; circles of a ball-bar
or probed balls show several at once.

An angle displaces the tool by its distance from the line of the measurement. On the line itself, it looks like a scale or a straightness. So a laser
along one line and circles at one height show no angle. A level shows a roll, and an autocollimator or angle optics show pitch and yaw. A laser
on a second line beside the first shows the angle between them. The message states how far an angle of 10 µrad shifts the tool. See
docs/how-to/calibrate-a-five-axis-machine.md.";
    BARE_TOOL = "W0333" "tool cuts without its length"
"A tool is in the spindle, and the control adds no length for it: no G43 comes before the cut, or G49, D0 or H0 has ended the length. The
positions are right, because the zero offset then contains the length. But ncfix takes the tip to be at the gauge point of the spindle.
Angular errors and rotary axes act over the length of the tool, like a lever. Their effect over this length is not corrected, and the
predicted error does not contain it. The message estimates its size, with the length of this tool in the machine file or with the longest one.

Program the length before the cut, and enter Z of the zero offset for it. A control without tool lengths, such as Grbl, has one tool for
each zero offset: state the place of its tip as origin_mm in [spindle], and length_mm = 0 in [[tool]]. The longer the tool, the more negative
is Z of origin_mm: [0, 0, -80] for 80 mm. See docs/explanation/not-corrected.md.";
    NO_TRAVEL = "W0401" "axis without travel limits"
"The machine file gives no travel_mm (travel_deg) for this axis, so positions outside its travel cannot be detected. Add the lowest
and the highest position of the axis, in machine coordinates.";
    TWO_DRIFTS = "W0402" "two models of the drift"
"The file has [[drift]] (weighted temperatures) and [[segment]] (the structure as beams). Each describes the drift of the warm
machine; if both describe the same parts, the drift is corrected twice. Use both in one file only if one was fitted to the residual
of the other.";
    UNUSED_SENSOR = "W0403" "unused sensor"
"[sensor.NAME] gives the reference temperature of a sensor that is not used in any [[drift]], [[expansion]] or [[segment]]. If the
name is misspelled, the intended sensor keeps the reference temperature of the machine, and its drift is computed from a wrong
one. Correct the name, or remove the section.";
    PARTIAL_OFFSET = "W0404" "zero offset that lacks an axis"
"[zero_offset.NAME], or a file of the control given with --setup, states only some linear axes of the machine. The others count as
0, unless a later file states them. In a G10 file of a Fanuc they keep the values of an earlier file. If the
control has another value for these axes, the correction is for a wrong position. Write every axis as the control shows it,
including 0. The external offset EXT of a Fanuc may have single axes.";
    NO_EFFECT = "W0405" "location error without effect"
"A location error in [location] moves neither the tip nor the tool axis on this machine. On the workpiece side, the error of the
axis next to the foundation turns the table with all that is on it, and the tool path on the workpiece remains the same. A value
under this name is never corrected. State the squareness at the other axis of the pair, with the opposite sign (EC0X = -15 for
EC0Y = 15). ncfix square chooses name and sign.";
    FOREIGN_KEY = "W0406" "setting of another control"
"A key of [control] belongs to the controls of another language, so that it changes nothing on this machine. Either the machine file
came from another machine, or controller names the wrong language. Remove the key, or correct controller.";
    CONTRADICTED = "W0407" "data of the control contradict the machine file"
"A file of the control, given with --setup, has machine data that differ from the machine file. They are the words in force at the start
of a program (MD20150), or the axes of rotation of TRAORI (MD24500 to MD24572). ncfix calculates with the machine file, so these data
have no effect. One of the two files may be old. If the control begins programs with another zero offset or unit, the correction is for a wrong position.
Correct the machine file, or write the word at the beginning of the program.";
    IMPLAUSIBLE_SIZE = "W0408" "error of an implausible size"
"An error in the machine file has a size that no machine has, or that no instrument resolves. Mostly its number is in another unit. In
[location] angles are in µrad and displacements in µm. Coefficients of polynomials are in mm (rad for angles) per power of mm: 50 µm per
meter is 5e-5. The message states the size at the worst place of the travel, or over the travel, and the help what the number
may have been meant to be. A small number with an entry in [uncertainty] comes from a fit and is not reported. Correct the number.";
    DOUBTFUL_SIGN = "W0409" "value with the sign of an unusual machine"
"machine check has found a value whose sign is possible, but rare. A backlash has the sign of an axis that goes too far after a
reversal: only a control that compensates for too much does that. The correction of a wrong sign doubles the error. Compare the sign
with a measurement: ncfix machine show --at X100 --sense X+ prints the deviation after a positive motion. With lost motion the tool
lags, and dX is negative. Or a tool has a negative length, as controls show it for a tool that was measured against another one or
from the machine zero. Write the distance from the spindle nose to the tip.";
    NO_TEMPERATURES = "W0501" "temperatures not given, or without effect"
"The error model has sources that depend on temperatures, and neither --state nor, in a calibration, the table of readings gives
them. All sensors are assumed to be at their reference temperature: no drift, no expansion. On a warm machine this part of the
error remains. Give the temperatures with --state. Or, conversely, --state is given, and no error of the machine file depends on
temperature, so the temperatures change nothing: measure the drift or the expansion, or omit --state.";
    NO_LOAD = "W0502" "workpiece weight not given, or without effect"
"The error model has effects of the weight on the table, and neither --load nor --state states the load. The table is assumed to be
empty. Give the weight with --load; --load 0 states an empty table. Or, conversely, a weight is given, and the machine file does
not describe its effects, so it changes nothing: measure them ([[load]]), or omit --load.";
    LOAD_TURNS = "W0503" "load off the center of a table that turns"
"The effect of a weight depends on its position in the machine. A rotary axis on the workpiece side moves a load that is not on its
axis; the effect is computed for the position that was given, whatever the position of the axis. That is correct for a table that
does not move while one side of the workpiece is machined. Give the position of the load for this pose, along the axes of the
machine. For a table that moves, correct each side as a separate program.";
    LOAD_ASSUMED = "W0601" "load only partly determined"
"The readings determine the weight, but with a limitation: the position of the load along an axis has the same signal as the weight
itself, the load is below the noise, there are too few other readings to check a disturbed one, or the scatter is above sigma_um_per_m. The
message states which. Give a known position with --known Z-280, or measure every position again.";
    READING_LEFT_OUT = "W0602" "reading excluded"
"A lubrication pulse disturbs the strain for a moment. ncfix excludes one or two readings from the weighing if the others agree
significantly better without them (1 %). The message names them. Look at these readings; if you doubt the result, measure again.";
    ROW_DOES_NOT_FIT = "W0603" "reading that does not fit the others"
"In a calibration, a reading that deviates from the model by more than the noise gets a smaller weight. Beyond 4.7 standard
deviations its weight is 0 (Tukey's biweight). The reading stays in the file and in the report. Look for its cause: a chip under the
ball, a wrong row, a set-up that moved. The message names the largest outlier of a file, and gives the number of the others;
--residuals lists all. With --no-robust all readings have equal weights.";
    POOR_FIT = "W0604" "residual larger than the instrument explains"
"The residual of the calibrated model is well above the uncertainty that sigma_um states, or, without sigma_um, above the scatter of
readings that were repeated at the same pose. The machine has errors that the model
lacks, its temperature changed, or sigma_um is too small. The standard uncertainties are then based on the scatter of the
residuals instead of sigma_um. They do not cover errors that the model lacks. Search for these errors with ncfix diagnose, or
correct sigma_um.";
    REDUCED = "W0605" "parameters omitted"
"With --reduce, or if --model is omitted, ncfix calibrate omits parameters that the data cannot separate from others. Of inseparable
parameters, it omits the most complex one first: truncated powers before backlash, before coefficients from the highest degree
down, later ones of the model before earlier ones, location errors last. Omitted parameters keep their values of the initial
machine file. The others absorb their effect, which is right for similar poses and wrong elsewhere. The message states the reason,
and the help the measurement that is missing. Measure what the help names, or accept the model for similar poses. ncfix diagnose
reports this code if it cannot fit the found terms again together: it then writes them as its search found them.";
    UNLIKE_REPEATED = "W0606" "uncertainties differ from simulated repetitions"
"With --monte-carlo, ncfix calibrate simulates the readings many times, with the noise that it found, and fits them again. The
scatter of a parameter differs from its standard uncertainty by more than 25 %, beyond the statistical spread of the repetitions,
or repetitions could not be fitted. Reasons are few readings, weights that follow the noise, or unknowns with large changes. Use
the scatter of the repetitions as the uncertainty of this parameter, or take more readings.";
    FAULTY_DATA = "W0607" "fault in the data"
"The data have a fault that the machine did not cause. A temperature sensor is dead, stuck, exchanged with another one, moved, or
in degrees Fahrenheit. Or the readings have a pulse of a few minutes, a first cycle before the machine had settled, a step from
one row on, single outliers, or the coarse resolution of a display. Or the rows of a ball-bar go against the direction in the name
of their run, such as 2-cw, or against the columns X_dir and so on: put them into the order of the motion. The message gives the
rows and the evidence. Look at these rows, and repair the cause before the next measurement. The help gives the consequence: ncfix
excludes faulty rows from the search for causes, or gives them their own zero or noise. The file does not change. If the
temperature log ends or pauses, ncfix excludes only the rows without temperatures. In held-out data it keeps all other rows, so
that the test data are not selected.";
    NOT_SHOWN = "W0608" "term that the readings do not show"
"ncfix calibrate fits a term of --model, such as EXX ~ Y^2, and its 95 % interval contains 0. The machine file gets the term,
because the command asks for it. A program would then be corrected by an amount whose sign is not known. Remove the term, or take
readings where it acts: at several positions of the axis on which it depends.";
    IMPORT_GAP = "W0609" "places without a reading"
"The readings of a file form a regular pattern, and some of them are missing: an arc of a circle, a target of a run, a node of a grid, or a
feature of a report. The file may have been cut off, or rows may have been lost. ncfix import writes the measurement without these
places and names them. Export the file again. If the places were not measured, the calibration is less certain there.";
    SLOPE_NOT_SHOWN = "W0610" "slope of a straightness that the readings do not show"
"ncfix calibrate fits the curvature of an axis, such as EZX2, but no slope, and the readings cannot show a slope: the
alignment of the artifact is unknown. A curve without a slope at the zero of the axis would tilt the whole axis by an arbitrary angle. ncfix therefore
adds the slope that makes the mean slope over the measured range zero. The real slope belongs to the squareness of the
axis, which stays unknown. Measure it with a square, two diagonals or ball-bar circles.";
    RELATIVE_SCALE = "W0611" "scale that is only relative to that of another axis"
"The circles of a bar of unknown length are the same if all axes are longer by the same proportion. ncfix calibrate fitted the
scale of some of these axes and took the others as 0, so the fitted scales are differences. A program that is corrected with them
can have the right shape and a wrong size, and the stated uncertainty does not include that. Give the calibrated length of the
bar, measure one axis with a laser, or state the scale of the other axis in the machine file.";
    SLOPE_LEFT_OUT = "W0612" "slope of a straightness outside the model"
"The readings of a straightness contain the angle between its reference and the axis, unless the description makes it an unknown. The
model has only the curvature. A parabola about the zero of the axis then absorbs a part of the angle, so the curvature is wrong,
possibly also in sign. Free the alignment with free = [\"offset\", \"slope\"] in the description, or add the slope to the model:
EYX1 in addition to EYX2.

ncfix diagnose has no stated model. The alignment of the reference and a squareness explain the slope equally well there, so it
uses no slope, and neither finds nor writes a squareness from it. If the reference is a square whose direction is exact, write
reference = \"square\" in [measurement].";
    SCALE_BY_PIVOT = "W0613" "scale that depends on the stated position of a rotary axis"
"ncfix calibrate fits the scales of linear axes from balls on a table, without a known distance between two balls. The balls then
show only the scales relative to the positions of the rotary axes in the machine file, and to the tool length. If a rotary axis is
20 µm away from its stated position, the fit turns this into scales that are wrong by 20 µm over the distance to it, and its residual stays
small. Give the calibrated distance of two balls in [[length]], measure one axis with a laser, or fit the offset of the rotary
axis instead of the scales.";
    SENSOR_LINEARITY = "W0614" "sensor that is not linear"
"The star of [sensors] shows that a sensor departs from its fitted response by more than 0.5 % of its range. At the ends of the
range the displacements are then wrong by this share, and calibrate or decompose would attribute this to the machine. Write
degree = 3 in [sensors] with a star of more rows, keep the ball nearer to the middle of the sensors, or repeat the star if a row
of it is wrong.";
    REFERENCES_DIFFER = "W0615" "readings that refer to different temperatures"
"Readings of a laser refer to 20 °C. A part, a plate or a ball-bar with a stated temperature shows the lengths that the machine has
at this temperature. In one ncfix calibrate or ncfix diagnose, files of both kinds contradict each other: at 22 °C by 23 µm/m on a
machine of steel. A fit ends at a compromise that is right for neither, or turns the difference into a squareness. A search mistakes the
difference for a cause. Give all files one reference temperature. Beside a laser that refers to 20 °C, import the part, plate or bar with
--material 20C: the result then makes parts that have their nominal size at 20 °C, if they expand as the machine does. Or use the
files separately.";
    SQUARENESS_OMITTED = "W0620" "squareness that the model lacks"
"--model states the parameters of the fit, and the squareness of two axes is not among them. The readings show this angle with certainty. Other
parameters have absorbed a part of it, such as the straightness of an axis or the zero of a rotary axis. The residuals can look normal,
but the model is wrong in other poses, and a program corrected with it can miss by several micrometers. Add the named error to --model,
or omit --model: ncfix calibrate then fits all parameters that the readings determine. Until then, not_shown in [measured] of the machine
file names the squareness, and ncfix fix reports W0330.";
    UNCERTAINTY_REPLACED = "W0621" "appended uncertainty that the new file does not have"
"The lists in [uncertainty] have more entries than their fit has parameters. So a person has appended an entry, for example for the
certificate of a laser. ncfix calibrate writes new lists for the parameters that it fits, and cannot know whether the entry is still
true. Add it again in the new file, at a position that no list uses yet: docs/how-to/import-an-instruments-file.md has the steps.";
    OTHER_LETTER = "W0622" "squareness under the letter of the other axis"
"A squareness is an angle between two axes. If both axes are on one side of the machine bed, only the location error of the axis further
from the bed changes the angle, and the machine file has only this one. The reading has the letter of the other axis: EC0Y where
the machine file has EC0X. ncfix uses it with the opposite sign, which is exact: if Y is rotated relative to X by 40 µrad, X is
rotated relative to Y by -40 µrad. Check the definition of the reading. Positive is a rotation by the right-hand rule. Write the name
of the machine file and the opposite sign, and the warning is gone.";
    NO_CERTIFICATE = "W0623" "calibrated length without its uncertainty"
"ncfix import reads circles of a bar of calibrated length, and neither the file nor an option states the uncertainty of this length. The
error of a certificate is the same in all readings: 0.5 µm on a bar of 100 mm makes the scales of all axes uncertain by 5 µm/m, however
many readings there are. Without the value, ncfix calibrate prints an interval that is too narrow. Give --length-sigma, or write
length_sigma_um into the section [setup.A] of the description.";
    FILES_CONTRADICT = "W0624" "files that contradict each other"
"ncfix calibrate gives an error of the machine one value for all files. Here two files show different values of one error, more than four
combined standard uncertainties apart. In consistent files, this happens once in 16,000 comparisons. The fitted value is a compromise, and
possibly right for neither. Its uncertainty in the new machine file is therefore at least the distance to the value of each of the two files. One of
the files measured another state of the machine: another date, another temperature, before and after a repair, or with another offset or
compensation in the control. A wrong sign or a wrong column has the same effect. Choose the file that describes the machine as it is now, and
calibrate without the other one. --hold-out with the other file shows how far it is off. If both are right, the model lacks an error that differs
between their positions: ncfix diagnose searches for it.";
    ORDER_UNKNOWN = "W0625" "rows sorted by position, without directions of approach"
"Without a column X_dir, ncfix takes the direction of approach of a reading from the row before it. The rows of this file are sorted by
position, and its description does not state their order. Readings in the order of the motion can look like this: line after line,
always from the same end. A table that a program has sorted looks the same, and its directions are wrong. ncfix calibrate would find
a backlash that the machine does not have. It therefore takes the directions in this file as unknown, and fits no backlash to its
readings. Write order = \"motion\" into [measurement] of the description if the rows are in the order of the motion. If they are not,
add a column X_dir with 1 or -1 in each row, or write order = \"unknown\".";
    STARVING = "W0701" "the link is too slow in places"
"The machine executes some lines faster than the link can deliver the next ones. At these places the axes stop for a moment until
the next line arrives, and the tool can cut a mark into the surface. All stops together are short: less than half a second, or
less than 1 % of the motion. Therefore ncfix sends the program, or you have permitted longer stops with --allow-starvation. The
message states the lines of the program. Choose a higher baud rate or a larger --tolerance, which gives fewer lines, to avoid the
stops. Or load the corrected file into the control and start it there.";
    SERIAL_SETTINGS = "W0702" "port with different settings or a name that may change"
"The port did not accept all settings of the profile, or its name depends on the order in which adapters were plugged in.
Characters could arrive wrong, or the program could go to another machine. Compare the settings with those of the control. On
Linux, use the name below /dev/serial/by-id, which does not change.";
    WHOLE_FILE = "W0703" "live temperatures and a link that sends a file"
"The link sends the whole program as one file before a person starts it. So the correction is that for the temperatures at the time
of sending. Lines that were sent cannot be corrected for later temperatures. Send the program shortly before the start, or use a
link that sends lines during the run.";
    LINK_OF_OTHERS = "W0704" "link that some controls of this language cannot use"
"The profile of the link names controls that do not receive lines over it, although their programs look the same. ncfix cannot see
which control is at the other end. Load the corrected program into such a control as a file.";
    KERNEL_DIFFERS = "W0801" "kernel that differs from the model"
"The kernel of ncfix realtime tabulates the errors of every axis on 200 intervals, evaluates strongly curved functions directly,
and corrects in two Newton steps. At 1000 poses over the whole travel it was compared with the iterated solution of the model, and
deviates by more than 0.5 µm or 5 µrad somewhere. Errors that change by a hundredth of the path or more cause this: a step in a
table, a wrong unit. Check the machine file for such an error. The program corrections of ncfix fix iterate further and are
correct.";
    NOT_RENEWED = "W0802" "kernel or tables not renewed"
"The state was read again after --update-s, and cannot be used: a file that is missing or half written, a sensor without a value,
corrections beyond --max-correction, tables that do not fit. The current kernel or file, made for the previous state, stays. Check
the sensors and the program that writes the file if the warning comes again.";
    UNUSED_TABLE = "W0901" "part of a table file that is not used"
"Part of a file of compensation tables is unknown or has no effect on the control: a table with step 0, values beyond its end, points
without a value, variables of another function, tables of another kind than --format, or a remark on products that the control
ignores. The rest is read. A list without M17 at its end is reported too, because it may be truncated. Check whether this is
intended.";
    PRODUCTS_ASSUMED = "W0902" "products of tables are ambiguous"
"A file has tables that are multiplied by others, and it is not stated whether the control adds the product instead of the table's
own value, as assumed here, or in addition to it. The manuals allow both interpretations. Load one table with a visible value, check
the effect, and state the result: --multiplication instead or beside, or table_multiplication in [machine]. Files written by ncfix
state it themselves.";
    AXIS_NUMBERS_ASSUMED = "W0903" "numbers of axes assumed"
"The tables name the axes by their numbers at the control (AX4), and the machine file does not state these numbers. ncfix counts X,
Y, Z, U, V, W, A, B, C, as far as the machine has them. On many controls a spindle has a number before the rotary axes: a table for
A would then act on the spindle. Compare the numbers with the names of the machine axes (MD10000). State them with axis_order in
[machine], which has - for an axis that ncfix does not know, or with --axis-name A=AX5. ncfix machine new --from reads them from an
archive.";
}
