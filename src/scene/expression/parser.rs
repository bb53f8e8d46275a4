//! Compiles text to postfix code by operator precedence (Pratt 1973).

use super::operation::{FUNCTIONS, OPERATORS, Operation, binding};
use super::{ExpressionError, Instruction, STACK, VARIABLES};
use crate::scene::nearest::nearest;
use std::collections::BTreeMap;
use std::ops::Range;

/// Maximum nesting depth of parentheses, prefixes and powers.
const DEPTH: usize = 64;

type Result<T> = std::result::Result<T, ExpressionError>;

/// The postfix code of `text`, with constants folded.
pub(super) fn compile(text: &str, constants: &BTreeMap<String, f64>) -> Result<Vec<Instruction>> {
    let mut parser = Parser { text, at: 0, constants, code: Vec::new(), height: 0 };
    parser.skip_spaces();
    if parser.at == text.len() {
        return Err(error("the expression is empty", 0..text.len(), "write a number such as 0"));
    }
    parser.expression(0, 0)?;
    if parser.at < text.len() {
        return Err(parser.unexpected());
    }
    Ok(parser.code)
}

fn error(message: impl Into<String>, at: Range<usize>, hint: impl Into<String>) -> ExpressionError {
    ExpressionError { message: message.into(), at, hint: hint.into() }
}

struct Parser<'a> {
    text: &'a str,
    /// The next byte to read; always at a character boundary, and at no white space between two
    /// tokens.
    at: usize,
    constants: &'a BTreeMap<String, f64>,
    code: Vec<Instruction>,
    /// Stack height after `code` has run.
    height: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or("")
    }

    fn skip_spaces(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    fn advance(&mut self, bytes: usize) {
        self.at += bytes;
        self.skip_spaces();
    }

    /// Reads `symbol` if it comes next.
    fn accept(&mut self, symbol: &str) -> bool {
        let found = self.rest().starts_with(symbol);
        if found {
            self.advance(symbol.len());
        }
        found
    }

    /// The range of the next character, for errors.
    fn here(&self) -> Range<usize> {
        self.at..self.at + self.rest().chars().next().map_or(0, char::len_utf8)
    }

    /// An operand followed by the operators that bind at least as tightly as `loosest`.
    fn expression(&mut self, loosest: u8, depth: usize) -> Result<()> {
        if depth > DEPTH {
            return Err(error(
                format!("the expression is nested deeper than {DEPTH}"),
                self.here(),
                "split it, or name parts of it in [constants]",
            ));
        }
        self.operand(depth)?;
        while let Some((symbol, operation, power)) = self.operator().filter(|o| o.2 >= loosest) {
            let start = self.at;
            self.advance(symbol.len());
            self.expression(
                if power == binding::POWER { binding::PREFIX } else { power + 1 },
                depth + 1,
            )?;
            self.emit_operation(operation, start)?;
            if power == binding::COMPARISON && self.operator().is_some_and(|o| o.2 == power) {
                return Err(error("comparisons do not chain", self.here(), "write a < b && b < c"));
            }
        }
        Ok(())
    }

    fn operator(&self) -> Option<(&'static str, Operation, u8)> {
        OPERATORS.into_iter().find(|o| self.rest().starts_with(o.0))
    }

    /// A number, a name, a call, a parenthesis, or a prefix with its operand.
    fn operand(&mut self, depth: usize) -> Result<()> {
        let start = self.at;
        let prefix = |p: &mut Self| p.expression(binding::PREFIX, depth + 1);
        match self.rest().chars().next() {
            Some('(') => {
                self.advance(1);
                self.expression(0, depth + 1)?;
                self.close(start)
            }
            Some('-') => {
                self.advance(1);
                prefix(self)?;
                self.emit_operation(Operation::Negate, start)
            }
            Some('!') => {
                self.advance(1);
                prefix(self)?;
                self.emit_operation(Operation::Not, start)
            }
            Some('+') => {
                self.advance(1);
                prefix(self)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' => self.name(depth),
            Some('*') if self.text[..self.at].ends_with('*') => Err(error(
                "a number or a name is missing here",
                self.here(),
                "write a power as x^2",
            )),
            Some(_) => Err(error("expected a number, a name or `(`", self.here(), "")),
            None => Err(error(
                "the expression ends too early",
                self.here(),
                "a number, a name or `(` is missing at its end",
            )),
        }
    }

    /// Reads the parenthesis that closes the one at byte `open`.
    fn close(&mut self, open: usize) -> Result<()> {
        if self.accept(")") {
            return Ok(());
        }
        if self.at < self.text.len() {
            return Err(self.unexpected());
        }
        Err(error("this `(` is never closed", open..open + 1, "add `)`"))
    }

    /// The error for an unexpected token in place of an operator.
    fn unexpected(&self) -> ExpressionError {
        let hint = match self.rest().chars().next() {
            Some(')') => "remove this `)` or add the `(` it closes",
            Some(',') => {
                "only arguments of a function are separated by commas; decimals are written with \
                 a point"
            }
            Some('=') => "write == to compare",
            Some('&' | '|') => "write && for and, || for or",
            Some(c) if c.is_alphanumeric() || "(._".contains(c) => {
                "write a product with *, as in 2*x"
            }
            _ => "",
        };
        error("expected an operator", self.here(), hint)
    }

    fn number(&mut self) -> Result<()> {
        let start = self.at;
        let rest = self.rest();
        let digits = |s: &str| s.bytes().take_while(u8::is_ascii_digit).count();
        let mut length = digits(rest);
        if rest[length..].starts_with('.') {
            length += 1;
            length += digits(&rest[length..]);
        }
        let exponent = rest[length..].strip_prefix(['e', 'E']);
        if let Some(exponent) = exponent {
            let sign = usize::from(exponent.starts_with(['+', '-']));
            let count = digits(&exponent[sign..]);
            length += if count > 0 { 1 + sign + count } else { 0 };
        }
        match rest[..length].parse::<f64>() {
            Ok(v) if v.is_finite() => {
                self.advance(length);
                self.emit(Instruction::Push(v), start)
            }
            Ok(_) => Err(error(
                "the number is too large",
                start..start + length,
                "numbers go up to 1.7e308",
            )),
            Err(_) => Err(error(
                "this is not a number",
                start..start + length.max(1),
                "write numbers like 0.5 or 1e-3",
            )),
        }
    }

    fn name(&mut self, depth: usize) -> Result<()> {
        let start = self.at;
        let length =
            self.rest().bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count();
        let name = &self.rest()[..length];
        let place = start..start + length;
        self.advance(length);
        let function = FUNCTIONS.iter().find(|f| f.0 == name);
        let called = self.rest().starts_with('(');
        if let Some(&(_, operation)) = function {
            return if called {
                self.call(name, operation, place, depth)
            } else {
                Err(not_called(name, place))
            };
        }
        let instruction = if let Some(k) = VARIABLES.iter().position(|v| *v == name) {
            Instruction::Variable(k)
        } else if name == "pi" {
            Instruction::Push(std::f64::consts::PI)
        } else if let Some(&v) = self.constants.get(name) {
            Instruction::Push(v)
        } else {
            return Err(self.unknown(name, place, called));
        };
        self.emit(instruction, start)
    }

    /// Reads the arguments of a function and emits the call.
    fn call(
        &mut self,
        name: &str,
        operation: Operation,
        place: Range<usize>,
        depth: usize,
    ) -> Result<()> {
        let open = self.at;
        self.advance(1);
        let mut count = 0;
        if !self.rest().starts_with(')') {
            loop {
                self.expression(0, depth + 1)?;
                count += 1;
                if !self.accept(",") {
                    break;
                }
            }
        }
        self.close(open)?;
        let arity = operation.arity();
        if count != arity {
            let plural = if arity == 1 { "" } else { "s" };
            let arguments = ["a", "b", "c"][..arity].join(", ");
            let message = format!("`{name}` takes {arity} argument{plural}, {count} given");
            return Err(error(message, place, format!("write {name}({arguments})")));
        }
        self.emit_operation(operation, place.start)
    }

    fn unknown(&self, name: &str, place: Range<usize>, called: bool) -> ExpressionError {
        let functions = FUNCTIONS.iter().map(|f| f.0).filter(|_| called);
        let names =
            VARIABLES.into_iter().chain(["pi"]).chain(self.constants.keys().map(String::as_str));
        let values: Vec<&str> = names.filter(|_| !called).collect();
        let known: Vec<&str> = functions.chain(values.iter().copied()).collect();
        let what = if called { "function" } else { "name" };
        let hint = match nearest(name, known.iter().copied()) {
            Some(n) => format!("did you mean `{n}`?"),
            None => format!("known {what}s: {}", known.join(", ")),
        };
        error(format!("the {what} `{name}` is not known"), place, hint)
    }

    fn emit(&mut self, instruction: Instruction, start: usize) -> Result<()> {
        if self.height == STACK {
            let message = format!("the expression holds more than {STACK} intermediate values");
            return Err(error(message, start..self.at, "split it into smaller ones"));
        }
        self.height += 1;
        self.code.push(instruction);
        Ok(())
    }

    /// Emits an operation; evaluates it at once if its arguments are constants. `start` is the
    /// position for an error.
    fn emit_operation(&mut self, operation: Operation, start: usize) -> Result<()> {
        let arity = operation.arity();
        let mut arguments = [0.0; 3];
        let first = self.code.len() - arity.min(self.code.len());
        let constant = self.code[first..].iter().zip(&mut arguments).all(|(i, a)| match i {
            Instruction::Push(v) => {
                *a = *v;
                true
            }
            _ => false,
        });
        self.height -= arity.min(self.height);
        let instruction = match (operation, self.code.last()) {
            _ if constant => {
                self.code.truncate(first);
                Instruction::Push(operation.apply(&arguments[..arity]))
            }
            (Operation::Power, Some(&Instruction::Push(p))) if p == 2.0 || p == 0.5 => {
                self.code.pop();
                Instruction::Apply(if p == 2.0 { Operation::Square } else { Operation::Sqrt })
            }
            _ => Instruction::Apply(operation),
        };
        self.emit(instruction, start)
    }
}

fn not_called(name: &str, place: Range<usize>) -> ExpressionError {
    error(
        format!("`{name}` is a function"),
        place,
        format!("write its argument in parentheses: {name}(...)"),
    )
}
