//! The nodes of the syntax tree.

use std::ops::Range;
use std::sync::Arc;

use super::call::{CallStatement, Parameter};
use super::definition::Definition;
use super::jump::{Jump, Repetition};
use crate::syntax::names::{NameId, Names};
use crate::syntax::paged_store::{PagedStore, Pages};
use ncfix_base::source::{Source, Span};
use ncfix_dialect::Dialect;

/// Index of an expression in [`Program::exprs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExprId(pub(super) u32);

/// A block number: `N10` or `:10`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BlockNumber {
    /// `:` instead of `N`.
    pub main: bool,
    /// The number.
    pub number: u32,
}

/// A range of [`Program::arguments`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ArgumentRange {
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
    /// The files of the archive; a file without headers is one section.
    pub sections: Vec<Section>,
    /// All blocks of all sections in order.
    pub blocks: PagedStore<Block>,
    /// Words of all blocks.
    pub words: PagedStore<Word>,
    /// Expressions of all blocks.
    pub exprs: PagedStore<Expr>,
    /// Arguments of calls and indices; `None` is an empty slot.
    pub arguments: PagedStore<Option<ExprId>>,
    /// Jumps of all blocks.
    pub jumps: Vec<Jump>,
    /// Variables of all DEF blocks.
    pub definitions: PagedStore<Definition>,
    /// Parameters of all PROC blocks.
    pub parameters: Vec<Parameter>,
    /// Call statements of all blocks.
    pub calls: Vec<CallStatement>,
    /// `REPEAT label` of all blocks.
    pub repetitions: Vec<Repetition>,
    /// All identifiers.
    pub names: Names,
    /// Page starts, if the program is loaded by pages.
    pub(super) pages: Option<Arc<Pages<5>>>,
}

/// One file of an archive.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Name without `_N_` and extension, upper case; empty if the file has no header.
    pub name: String,
    /// `MPF`, `SPF` …, upper case; empty if the file has no header.
    pub ending: String,
    /// Header lines, each without its line end.
    pub headers: Vec<Span>,
    /// Its blocks in [`Program::blocks`].
    pub blocks: Range<usize>,
}

/// One line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The line without its line end.
    pub span: Span,
    /// Line number, from 1.
    pub line: u32,
    /// Skip level of a leading `/`.
    pub skip: Option<u8>,
    /// `N10` or `:10`.
    pub number: Option<BlockNumber>,
    /// `NAME:`.
    pub label: Option<NameId>,
    /// Statement or words.
    pub body: Body,
    /// First word in [`Program::words`].
    pub(super) first_word: u32,
    /// Number of words.
    pub(super) word_count: u16,
    /// `true` if a word may assign a variable, so that assignments must be searched.
    pub has_names: bool,
    /// Comment with its `;`; empty if there is no comment.
    pub comment: Span,
    /// The block at the other end of a control structure, see [`Body`]; `u32::MAX` if not connected.
    pub(super) partner: u32,
}

/// Content of a block.
///
/// `partner` of a block: for IF its ELSE or ENDIF; for ELSE its ENDIF; for WHILE, FOR, LOOP their end, for these ends their start; for UNTIL its
/// REPEAT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// Only number, label, comment.
    Empty,
    /// Words, including keywords and calls.
    Words,
    /// `IF` without jump.
    If(ExprId),
    /// `ELSE`
    Else,
    /// `ENDIF`
    EndIf,
    /// `LOOP`
    Loop,
    /// `ENDLOOP`
    EndLoop,
    /// `FOR variable = from TO to`
    For {
        /// The variable: a parameter or variable expression.
        variable: ExprId,
        /// Start value.
        from: ExprId,
        /// Last value.
        to: ExprId,
    },
    /// `ENDFOR`
    EndFor,
    /// `WHILE`
    While(ExprId),
    /// `ENDWHILE`
    EndWhile,
    /// `REPEAT` alone
    Repeat,
    /// `UNTIL`
    Until(ExprId),
    /// Jumps, evaluated from left to right: a range of [`Program::jumps`].
    Jumps {
        /// First.
        start: u32,
        /// Count.
        count: u16,
    },
    /// `DEF`: a range of [`Program::definitions`].
    Define {
        /// First.
        start: u32,
        /// Count.
        count: u16,
    },
    /// `PROC`: its parameters are a range of [`Program::parameters`].
    Proc {
        /// The name.
        name: NameId,
        /// First.
        start: u32,
        /// Count.
        count: u16,
        /// `SAVE`: the modal state of the caller is restored at the return.
        save: bool,
    },
    /// `MCALL`, `CALL`, `PCALL` …: an index in [`Program::calls`].
    Call(u32),
    /// `REPEAT label`, `REPEATB label`: an index in [`Program::repetitions`].
    RepeatPart(u32),
    /// A declaration without effect on the execution: `EXTERN`, `DEFINE`.
    Declaration,
    /// `ID=1 WHEN … DO …`; missing parts are empty.
    Synchronised {
        /// The whole action.
        whole: Span,
        /// The number after `ID=` or `IDS=`.
        id: Span,
        /// The text after WHEN, WHENEVER, EVERY or FROM.
        condition: Span,
        /// The text after DO.
        actions: Span,
    },
    /// A statement that is known but not executed: its keyword.
    Unsupported(Span),
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
    /// `X`, `G`, upper case.
    Letter(u8),
    /// `S2=`, `M1=`, `R5=`: letter and extension.
    Extended(u8, u32),
    /// `CR=`, `SOFT`, `MSG(…)`, a variable.
    Name(NameId),
    /// `R[…]=`, `NAME[…]=`, `$P_UIFR[…]=`: the left side as an expression.
    Indexed(ExprId),
}

/// The value of a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A bare word without value.
    None,
    /// A plain number after a letter; `true` if written without decimal point and exponent.
    Number(f64, bool),
    /// `=` and an expression.
    Expr(ExprId),
    /// `=AC(…)` and related functions.
    Dimension(DimensionFunction, ExprId),
    /// `(…)` after a name.
    Arguments(ArgumentRange),
}

/// Functions that define the meaning of one value, independent of G90 or G91.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DimensionFunction {
    /// `AC`: absolute.
    Absolute,
    /// `IC`: incremental.
    Incremental,
    /// `DC`: rotary axis, absolute in the shortest direction.
    Shortest,
    /// `ACP`: rotary axis, absolute in the positive direction.
    Positive,
    /// `ACN`: rotary axis, absolute in the negative direction.
    Negative,
    /// Any other function, which is known but not executed (`QU`, `CAC`, `DIC` …).
    Other,
}

/// An expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expr {
    /// Span of the expression.
    pub span: Span,
    /// Kind and operands.
    pub node: Node,
}

/// Kind and operands of an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Node {
    /// `1.5`, `1EX3`
    Real(f64),
    /// `15`, `'H1F'`, `'B101'`
    Integer(i64),
    /// `TRUE`
    Boolean(bool),
    /// `"…"`: the bytes between the quotation marks.
    Text(Span),
    /// `R5`
    Parameter(u32),
    /// `R[…]`
    ParameterAt(ExprId),
    /// A name: variable, axis, system variable.
    Name(NameId),
    /// `NAME[…]`
    Indexed(NameId, ArgumentRange),
    /// `SIN(…)`
    Call(NameId, ArgumentRange),
    /// `-a`, `NOT a`
    Unary(UnaryOperator, ExprId),
    /// `a + b`
    Binary(Operator, ExprId, ExprId),
}

/// Operators with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnaryOperator {
    /// `+`
    Plus,
    /// `-`
    Minus,
    /// `NOT`
    Not,
    /// `B_NOT`
    BitNot,
    /// `<<` without a left side
    ToText,
}

/// Operators with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are the operators' names")]
pub enum Operator {
    Multiply,
    Divide,
    Div,
    Mod,
    Add,
    Subtract,
    BitAnd,
    BitXor,
    BitOr,
    And,
    Xor,
    Or,
    Concatenate,
    Equal,
    NotEqual,
    Greater,
    Less,
    GreaterEqual,
    LessEqual,
    /// `:` between frames
    Chain,
}

impl Block {
    /// The block at the other end of its control structure, see [`Body`].
    #[must_use]
    pub fn partner(&self) -> Option<usize> {
        (self.partner != u32::MAX).then_some(self.partner as usize)
    }
}

impl Program {
    /// The words of a block.
    #[must_use]
    pub fn words_of(&self, block: &Block) -> &[Word] {
        let start = block.first_word as usize;
        &self.words[start..start + usize::from(block.word_count)]
    }

    /// An expression.
    #[must_use]
    pub fn expr(&self, id: ExprId) -> &Expr {
        &self.exprs[id.0 as usize]
    }

    /// Arguments of a call or index.
    #[must_use]
    pub fn arguments_of(&self, range: ArgumentRange) -> &[Option<ExprId>] {
        &self.arguments[range.start as usize..range.start as usize + usize::from(range.count)]
    }

    /// Jumps of a block.
    #[must_use]
    pub fn jumps_of(&self, start: u32, count: u16) -> &[Jump] {
        &self.jumps[start as usize..start as usize + usize::from(count)]
    }

    /// Parameters of a PROC block.
    #[must_use]
    pub fn parameters_of(&self, start: u32, count: u16) -> &[Parameter] {
        &self.parameters[start as usize..start as usize + usize::from(count)]
    }

    /// Definitions of a block.
    #[must_use]
    pub fn definitions_of(&self, start: u32, count: u16) -> &[Definition] {
        &self.definitions[start as usize..start as usize + usize::from(count)]
    }
}
