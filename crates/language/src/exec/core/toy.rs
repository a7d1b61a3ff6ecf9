//! A moderate family for tests: jumps, calls, repetitions, a shift and a cycle on the core.

use super::contour::{ContourModal, ContourRequest};
use super::executor::Executor;
use super::family::Family;
use super::fault::{Fault, fault};
use super::interpreter::{self, Execute};
use super::level::{self, RepeatedSection};
use super::library::NoLibrary;
use super::motion_sink::{HasOutlet, MotionSink};
use super::options::Options;
use super::path::{Path, Shape};
use super::program::{LoadedFile, ProgramText, Statement};
use super::run_state::RunState;
use super::standing::InForce;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Plane, PlaneBasis};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::file::{DEMO, MachineFile, read_machine};
use ncfix_machine::snc::{BlockNumber, FeedUnit, Kind, MotionMode, Move, Origin, RotaryDirection, Setup};
use std::collections::HashMap;
use std::convert::Infallible;
use std::sync::Arc;

/// A line: a word, and up to three numbers.
#[derive(Clone, Copy, Debug)]
struct Block {
    word: &'static str,
    numbers: [f64; 3],
    span: Span,
    line: u32,
}

struct Program {
    source: Source,
    blocks: Vec<Block>,
}

struct Toy;
type Interpreter<'a> = interpreter::Runner<'a, Toy>;
type Action = level::AfterBlock<Toy>;
type Level = level::ProgramLevel<Toy>;

impl Statement for Block {
    fn span(&self) -> Span {
        self.span
    }

    fn line(&self) -> u32 {
        self.line
    }

    fn skip(&self) -> Option<u8> {
        None
    }

    fn number(&self) -> Option<BlockNumber> {
        None
    }
}

impl ProgramText for Program {
    type Block = Block;

    fn source(&self) -> &Source {
        &self.source
    }

    fn block_count(&self) -> usize {
        self.blocks.len()
    }

    fn ensure(&mut self, _: usize) {}

    fn block(&self, block: usize) -> Option<&Block> {
        self.blocks.get(block)
    }

    fn is_note(&self, _: &Block) -> bool {
        false
    }
}

impl Family for Toy {
    type Program = Program;
    /// The blocks of its labels.
    type Prepared = HashMap<u32, usize>;
    type Name = String;
    type Entry = usize;
    /// The block of a label.
    type Call = usize;
    type Return = ();
    type End = Infallible;
    type Pass = ();
    type Level = ();
}

/// The state: parameters, shift, depth of the cycle, position; and the motion sink.
struct Channel<'a> {
    outlet: MotionSink<'a>,
    standing: InForce,
    parameters: [f64; 4],
    depth: Option<f64>,
    place: AxisVector,
}

impl<'a> HasOutlet<'a> for Channel<'a> {
    fn outlet(&mut self) -> &mut MotionSink<'a> {
        &mut self.outlet
    }
}

/// A straight motion to a program position.
fn line(channel: &mut Channel<'_>, place: AxisVector, rapid: bool, span: Span) {
    let setup = Arc::clone(&channel.standing.setup);
    let (start, target) = (setup.command(&channel.place), setup.command(&place));
    channel.place = place;
    let motion = Move {
        rapid,
        arc: None,
        target,
        named: AxisSet::XYZ,
        known: AxisSet::XYZ,
        feed: 100.0,
        feed_named: false,
        unit: FeedUnit::PerMinute,
        ways: [RotaryDirection::Plain; 3],
        in_machine_frame: false,
        motion_mode: MotionMode::Path,
        off_curve_mm: 0.0,
        tip: None,
        arc_basis: None,
    };
    let basis = PlaneBasis::Principal(Plane::XY);
    let path = Path { motion, start, start_known: AxisSet::XYZ, basis, shape: Shape::Line, setup, span };
    let wish = ContourRequest::of(ContourModal::default(), 0.0, span, channel.outlet.file());
    let element = channel.outlet.element(Kind::Empty);
    channel.outlet.pass_path(path, element, wish);
}

fn at(x: f64, y: f64, z: f64) -> AxisVector {
    AxisVector([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
}

impl Execute for Toy {
    type Channel<'a> = Channel<'a>;
    type Run = ();

    fn parse(_: &Interpreter<'_>, source: &Source) -> (Program, Vec<Diagnostic>) {
        (read(source), Vec::new())
    }

    fn end_of(_: &Channel<'_>, file: &LoadedFile<Program, HashMap<u32, usize>>, _: &Level) -> usize {
        file.program.blocks.len()
    }

    fn begin(run: &mut Interpreter<'_>, _: &Block, own: Origin) {
        run.channel.outlet.begin_block(own, None);
    }

    fn block(run: &mut Interpreter<'_>, block: &Block, index: usize) -> Result<Action, Fault> {
        let [first, second, third] = block.numbers;
        let channel = &mut run.channel;
        let target = |label: f64| {
            let found = run.programs[0].own.get(&(label as u32)).copied();
            found.ok_or_else(|| fault(Code::NO_TARGET, block.span, "no such label", "add it"))
        };
        match block.word {
            "L" => line(channel, at(first, second, channel.place[Axis::Z]), false, block.span),
            "SHIFT" => {
                let frame = Frame::translation(at(first, second, 0.0));
                channel.standing.setup = Arc::new(Setup { frame, ..Setup::default() });
            }
            "ADD" => channel.parameters[first as usize] += second,
            "DEF" => channel.depth = Some(first),
            "DRILL" => {
                let here = channel.place;
                let bottom = channel.depth.ok_or_else(|| fault(Code::CYCLE_ALARM, block.span, "no cycle", "DEF"))?;
                line(channel, at(here[Axis::X], here[Axis::Y], bottom), false, block.span);
                line(channel, here, true, block.span);
            }
            "IFLESS" if channel.parameters[first as usize] < second => return target(third).map(Action::Goto),
            "CALL" => return target(first).map(Action::Call),
            "REP" => {
                let section =
                    RepeatedSection { first: target(first)?, last: index - 1, passes: second as u64, pass: () };
                return Ok(Action::Repeat(section));
            }
            "RET" => return Ok(Action::Return(())),
            _ => {}
        }
        Ok(Action::Next)
    }

    fn call(run: &mut Interpreter<'_>, start: usize, block: &Block) -> Result<(), Fault> {
        if run.levels.len() >= 8 {
            return Err(fault(Code::TOO_MANY_CALLS, block.span, "too many calls", "does it call itself?"));
        }
        let calls = run.chain(block.line);
        run.levels.push(Level::new(0, 0, start, calls, ()));
        Ok(())
    }

    fn return_to(run: &mut Interpreter<'_>, (): (), _: Span) -> Result<(), Fault> {
        run.levels.pop();
        Ok(())
    }

    fn end_of_program(_: &mut Interpreter<'_>, end: Infallible) {
        match end {}
    }

    fn end_of_blocks(run: &mut Interpreter<'_>) {
        run.ledger.end();
    }

    fn finish(run: &mut Interpreter<'_>) {
        run.channel.outlet.end(run.ledger.has_errors());
        run.report_warnings(run.channel.outlet.file());
    }
}

const WORDS: [&str; 10] = ["LBL", "L", "SHIFT", "ADD", "DEF", "DRILL", "IFLESS", "CALL", "REP", "RET"];

fn read(source: &Source) -> Program {
    let text = String::from_utf8(source.bytes().to_vec()).unwrap();
    let mut blocks = Vec::new();
    for (line, written) in (1..).zip(text.lines()) {
        let mut parts = written.split_whitespace();
        let word = parts.next().and_then(|word| WORDS.into_iter().find(|known| *known == word)).unwrap();
        let mut numbers = [0.0; 3];
        numbers.iter_mut().zip(parts).for_each(|(number, part)| *number = part.parse().unwrap());
        blocks.push(Block { word, numbers, span: Span { start: line, end: line }, line });
    }
    Program { source: source.clone(), blocks }
}

fn demo() -> Machine {
    let source = Source::new(FileId(0), "demo", DEMO.as_bytes().to_vec()).unwrap();
    read_machine(&MachineFile::parse(&source).unwrap()).0.unwrap()
}

/// Ends of the moves, X Y Z, and the codes of the diagnostics.
fn run(text: &str) -> (Vec<[f64; 3]>, Vec<Code>) {
    let (machine, options) = (demo(), Options { max_blocks: Some(1000), ..Options::default() });
    let source = Source::new(FileId(0), "toy", text.as_bytes().to_vec()).unwrap();
    let program = read(&source);
    let labels = program.blocks.iter().enumerate().filter(|(_, block)| block.word == "LBL");
    let labels = labels.map(|(index, block)| (block.numbers[0] as u32, index)).collect();
    let channel = Channel {
        outlet: MotionSink::new(&machine, &options),
        standing: InForce::default(),
        parameters: [0.0; 4],
        depth: None,
        place: AxisVector::ZERO,
    };
    let ledger = RunState::new(source, program.blocks.len(), &options);
    let main = (LoadedFile::with(program, labels), Level::new(0, 0, 0, 0, ()));
    let mut running = Interpreter::start(&machine, Box::new(NoLibrary), ledger, (channel, ()), main);
    let (mut ends, mut found) = (Vec::new(), Vec::new());
    while let Some(item) = running.advance() {
        match item {
            Ok(element) => {
                if let Kind::Move(step) = element.kind {
                    ends.push([step.target[Axis::X], step.target[Axis::Y], step.target[Axis::Z]]);
                }
            }
            Err(finding) => found.push(finding.code),
        }
    }
    (ends, found)
}

#[test]
fn a_section_is_repeated_and_a_jump_out_of_it_ends_that() {
    let (ends, found) = run("LBL 1\nADD 0 1\nL 1 0\nREP 1 2\nL 2 0");
    assert_eq!((ends, found), (vec![[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], vec![]));
    // The second pass finds the parameter at 2 and leaves: the block after the label is the last one.
    let (ends, _) = run("LBL 1\nADD 0 1\nIFLESS 0 2 2\nL 9 9\nIFLESS 0 9 3\nLBL 2\nREP 1 5\nLBL 3\nL 3 0");
    assert_eq!(ends, [[9.0, 9.0, 0.0], [3.0, 0.0, 0.0]]);
}

#[test]
fn a_call_comes_back_and_one_that_calls_itself_is_refused() {
    let (ends, found) = run("CALL 7\nL 2 0\nIFLESS 0 1 8\nLBL 7\nL 1 0\nRET\nLBL 8");
    assert_eq!((ends, found), (vec![[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], vec![]));
    assert_eq!(run("LBL 1\nCALL 1").1, [Code::TOO_MANY_CALLS]);
}

#[test]
fn a_cycle_is_carried_out_behind_the_shift_in_force() {
    let (ends, _) = run("SHIFT 10 20\nDEF -5\nL 1 2\nDRILL");
    assert_eq!(ends, [[11.0, 22.0, 0.0], [11.0, 22.0, -5.0], [11.0, 22.0, 0.0]]);
    assert_eq!(run("DRILL").1, [Code::CYCLE_ALARM]);
}

#[test]
fn an_endless_loop_ends_with_a_finding() {
    assert_eq!(run("LBL 1\nIFLESS 0 1 1").1, [Code::TOO_MANY_BLOCKS]);
}
