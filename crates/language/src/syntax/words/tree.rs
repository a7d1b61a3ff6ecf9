//! The nodes of the syntax tree of the word languages.

use std::ops::Range;
use std::sync::Arc;

use super::node::{Expr, ExprId};
use crate::syntax::names::{NameId, Names};
use crate::syntax::paged_store::{PagedStore, Pages};
use ncfix_base::source::{Source, Span};
use ncfix_dialect::{Dialect, Language};

/// A range of one of the flat lists of [`Program`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Slice {
    pub(super) start: u32,
    pub(super) count: u16,
}

/// A parsed file.
#[derive(Clone, Debug)]
pub struct Program {
    /// The bytes that all spans refer to.
    pub source: Source,
    /// The dialect it was parsed as.
    pub dialect: &'static Dialect,
    /// The programs, macros and tables of the file in order; a file without headers is one part.
    pub parts: Vec<Part>,
    /// All blocks of all parts in order.
    pub blocks: PagedStore<Block>,
    /// Words of all blocks.
    pub words: PagedStore<Word>,
    /// Expressions of all blocks.
    pub exprs: PagedStore<Expr>,
    /// Arguments of O-word calls.
    pub arguments: PagedStore<ExprId>,
    /// Comments of all blocks.
    pub comments: PagedStore<Comment>,
    /// All identifiers, upper case and without blanks.
    pub names: Names,
    /// `true` if `%` begins or ends the tape.
    pub has_tape_marks: bool,
    /// Block numbers: number and block, sorted within each part.
    pub(super) targets: Vec<(u32, u32)>,
    /// O-word subroutines: label and block of `sub`, in file order.
    pub(super) subs: Vec<(Label, u32)>,
    /// Page starts, if the program is loaded by pages.
    pub(super) pages: Option<Arc<Pages<5>>>,
}

/// Purpose of a part of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartKind {
    /// A part program: `%PM`, `O1234`, or a file without headers. It may also be called as a subprogram.
    Program,
    /// `%MM`: macros that G22 calls.
    Macro,
    /// `%TM`: tool memory.
    Tools,
    /// `%ZO`, `%ZE`: zero offsets.
    ZeroOffsets,
    /// `%PO`: points.
    Points,
    /// `%PA`: E parameters.
    Parameters,
    /// `%PL`: pallet offsets.
    Pallets,
    /// `%MC`: machine constants.
    MachineConstants,
    /// Any other memory of the control.
    Other,
}

/// One program, macro or table of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its purpose.
    pub kind: PartKind,
    /// `1234` of `O1234`, `:1234`, `%PM1234` or the line `N1234` after `%PM`.
    pub number: Option<u32>,
    /// `<NAME>` of a program that has a name instead of a number.
    pub name: Option<NameId>,
    /// Header lines, each without its line end: `%PM`, `N9001 (NAME)`, `O1234 (NAME)`.
    pub headers: Vec<Span>,
    /// The comment in its header, without brackets.
    pub title: Option<Span>,
    /// Its blocks in [`Program::blocks`].
    pub blocks: Range<usize>,
    /// Its block numbers in the list of targets.
    pub(super) targets: Range<usize>,
}

/// One block: a line with content.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The line without its line end.
    pub span: Span,
    /// Line number, from 1.
    pub line: u32,
    /// Level of a `/` at its start as written; 0 for a bare `/`.
    pub skip: Option<u8>,
    /// `N10`; the whole part of `N10.5`.
    pub number: Option<u32>,
    /// Statement or words.
    pub body: Body,
    /// O-word label, or the loop number of DO and END.
    pub label: Option<Label>,
    /// A `/` after the first word.
    pub inner_skip: Option<InnerSkip>,
    /// Words, in [`Program::words`].
    pub(super) words: Slice,
    /// Comments, in [`Program::comments`].
    pub(super) comments: Slice,
    /// The block at the other end of a control structure, see [`Body`]; `u32::MAX` if not connected.
    pub(super) partner: u32,
}

/// A `/` within a block: the words after it are skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InnerSkip {
    /// Its level as written; 0 for a bare `/`.
    pub level: u8,
    /// Number of words before it.
    pub words_before: u16,
}

/// The label of an O-word (`o100`, `o<name>`, `o#1`, `o[…]`) or the number of a DO loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Label {
    /// A number.
    Number(u32),
    /// A name.
    Name(NameId),
    /// Computed during the execution.
    Computed(ExprId),
}

/// Content of a block.
///
/// `partner` of a block: for IF and ELSEIF the next ELSEIF, ELSE or ENDIF; for ELSE its ENDIF; for WHILE, DO and REPEAT their end; for these ends
/// their start; for SUB its ENDSUB; for BREAK and CONTINUE the start of their loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// Only number and comments.
    Empty,
    /// Words, including assignments.
    Words,
    /// `GOTO n`
    Goto(ExprId),
    /// `IF […] GOTO n`
    IfGoto {
        /// The condition.
        condition: ExprId,
        /// The block number.
        target: ExprId,
    },
    /// `IF […] THEN …`: the words of the block are executed if the condition is true.
    IfThen(ExprId),
    /// `WHILE […] DOn`, `DOn` (without a condition, endless), `o… while […]` that opens a loop.
    While(Option<ExprId>),
    /// `ENDn`, `o… endwhile`
    EndWhile,
    /// `o… do`
    Do,
    /// `o… while […]` that ends a loop begun with `do`.
    DoWhile(ExprId),
    /// `o… repeat […]`
    Repeat(ExprId),
    /// `o… endrepeat`
    EndRepeat,
    /// `o… if […]`
    If(ExprId),
    /// `o… elseif […]`
    ElseIf(ExprId),
    /// `o… else`
    Else,
    /// `o… endif`
    EndIf,
    /// `o… break`
    Break,
    /// `o… continue`
    Continue,
    /// `o… sub`
    Sub,
    /// `o… endsub`, with or without a value.
    EndSub(Option<ExprId>),
    /// `o… return`, with or without a value.
    Return(Option<ExprId>),
    /// `o… call […] […]`: its arguments, see [`Program::arguments_of`].
    Call(Slice),
    /// `DPRNT[…]`, `BPRNT[…]`, `POPEN`, `PCLOS`, `SETVN…`: print or name statements without motion.
    Printing(Span),
    /// Unreadable; a diagnostic gives the reason.
    Faulty,
}

/// A word: an address and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// Span of the word.
    pub span: Span,
    /// The address, left of the value.
    pub address: Address,
    /// The value.
    pub value: Value,
}

/// The part of a word left of its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Address {
    /// `X`, `G`, upper case; `@` and `^` of RS274/NGC are the distance and angle of polar coordinates, `$` a spindle.
    Letter(u8),
    /// `X1=`, `B1=`, `E1=`: letter and index, with a value after `=`.
    Indexed(u8, u16),
    /// `,C`, `,R`, `,A`: the letter.
    Comma(u8),
    /// `#1=`, `#[…]=`, `#<name>=`: the variable as an expression.
    Variable(ExprId),
    /// `<NAME>` of `M98 <NAME>`, without value.
    Name(NameId),
}

/// The value of a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// No value, for [`Address::Name`].
    None,
    /// A plain number.
    Number {
        /// The number as written.
        value: f64,
        /// `true` if it has a decimal point.
        has_point: bool,
        /// Number of digits before the point, including leading zeros.
        digits: u8,
    },
    /// An expression.
    Expr(ExprId),
}

/// A comment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comment {
    /// Span of the comment, with brackets or semicolon.
    pub span: Span,
    /// The inner text, without the word that makes it active.
    pub text: Span,
    /// Its function.
    pub kind: CommentKind,
}

/// Function of a comment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommentKind {
    /// No function.
    Plain,
    /// `(MSG,…)`: shows a text.
    Message,
    /// `(DEBUG,…)`: shows a text with values.
    Debug,
    /// `(PRINT,…)`: prints a text with values.
    Print,
    /// `(LOG,…)`, `(LOGOPEN,…)`, `(LOGAPPEND,…)`, `(LOGCLOSE)`: writes a file.
    Log,
    /// `(PROBEOPEN …)`, `(PROBECLOSE)`: writes probing results into a file.
    Probe,
}

impl Block {
    /// The block at the other end of its control structure, see [`Body`].
    #[must_use]
    pub fn partner(&self) -> Option<usize> {
        (self.partner != u32::MAX).then_some(self.partner as usize)
    }
}

impl Slice {
    fn range(self) -> Range<usize> {
        let start = self.start as usize;
        start..start + usize::from(self.count)
    }
}

impl Program {
    /// The words of a block, including those after an inner skip.
    #[must_use]
    pub fn words_of(&self, block: &Block) -> &[Word] {
        self.words.range(block.words.range())
    }

    /// The words of a block before its inner skip.
    #[must_use]
    pub fn words_before_skip(&self, block: &Block) -> &[Word] {
        let words = self.words_of(block);
        let count = block.inner_skip.map_or(words.len(), |skip| usize::from(skip.words_before));
        words.get(..count).unwrap_or(words)
    }

    /// The comments of a block.
    #[must_use]
    pub fn comments_of(&self, block: &Block) -> &[Comment] {
        self.comments.range(block.comments.range())
    }

    /// An expression.
    #[must_use]
    pub fn expr(&self, id: ExprId) -> &Expr {
        &self.exprs[id.0 as usize]
    }

    /// Arguments of a call.
    #[must_use]
    pub fn arguments_of(&self, slice: Slice) -> &[ExprId] {
        self.arguments.range(slice.range())
    }

    /// The part that a block belongs to.
    #[must_use]
    pub fn part_of(&self, block: usize) -> Option<usize> {
        let next = self.parts.partition_point(|part| part.blocks.end <= block);
        self.parts.get(next).filter(|part| part.blocks.contains(&block)).map(|_| next)
    }

    /// The first part of a kind with a number.
    #[must_use]
    pub fn find_part(&self, kind: PartKind, number: u32) -> Option<usize> {
        self.parts.iter().position(|part| part.kind == kind && part.number == Some(number))
    }

    /// The program with a name.
    #[must_use]
    pub fn find_named_part(&self, name: NameId) -> Option<usize> {
        self.parts.iter().position(|part| part.name == Some(name))
    }

    /// The block with a number in a part: the first one after block `from`, otherwise the first one of the part.
    #[must_use]
    pub fn find_block(&self, part: usize, number: u32, from: usize) -> Option<usize> {
        if self.dialect.language == Language::Rs274 {
            // Block numbers of RS274/NGC are never jump targets.
            return None;
        }
        if self.has_pages() {
            return self.search_block(number, from);
        }
        let targets = self.targets.get(self.parts.get(part)?.targets.clone())?;
        let first = targets.partition_point(|target| target.0 < number);
        let behind = targets.partition_point(|target| (target.0, target.1 as usize) <= (number, from));
        let of_number = |index: usize| targets.get(index).filter(|target| target.0 == number);
        of_number(behind).or_else(|| of_number(first)).map(|target| target.1 as usize)
    }

    /// The block `o… sub` with a label.
    #[must_use]
    pub fn find_sub(&self, label: Label) -> Option<usize> {
        self.subs.iter().find(|(known, _)| *known == label).map(|(_, block)| *block as usize)
    }

    /// The O-word subroutines: label and block of `sub`, in file order.
    #[must_use]
    pub fn subs(&self) -> &[(Label, u32)] {
        &self.subs
    }
}
