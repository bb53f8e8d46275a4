//! Expressions of `x`, `y`, `z`, `t` and named constants in scenes.
//!
//! Operators, in increasing order of precedence: `||`, `&&`, comparisons (`< > <= >= == !=`, which
//! do not chain), `+ -`, `* /`, prefix `- + !`, and `^`, which is right-associative: `-x^2` is
//! `-(x^2)`, `2^3^2` is 512 and `2^-1` is 0.5. Functions: `sqrt exp log log10 sin cos tan asin acos
//! atan sinh cosh tanh abs sign floor ceil min max hypot atan2 pow` and `if(condition, a, b)`;
//! `log` is the natural logarithm and angles are in radians. True is 1 and false is 0.

mod derivative;
mod operation;
mod parser;
#[cfg(test)]
mod tests;

use operation::{FUNCTIONS, Operation};
use std::collections::BTreeMap;
use std::ops::Range;

/// The variables, in the order of their indices.
const VARIABLES: [&str; 4] = ["x", "y", "z", "t"];
/// The index of the variable `t`.
const TIME: usize = 3;
/// Maximum depth of the evaluation stack.
const STACK: usize = 64;

/// A compiled expression of space and time.
///
/// Two expressions are equal when they compile to the same code: `2 * 3` equals `6`.
#[derive(Clone, Debug)]
pub struct Expression {
    text: String,
    code: Vec<Instruction>,
}

/// Postfix code: an operation replaces its arguments on top of the stack by its result.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Instruction {
    Push(f64),
    Variable(usize),
    Apply(Operation),
}

/// Syntax error of an expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpressionError {
    /// Description of the error.
    pub message: String,
    /// Byte range of the error; empty at the end of the text if something is missing there.
    pub at: Range<usize>,
    /// Suggested correction; may be empty.
    pub hint: String,
}

impl Expression {
    /// Compiles `text`, which may contain the variables, `pi` and the `constants`.
    ///
    /// Errors: an unknown name (with the nearest known one), a wrong number of arguments, a missing
    /// operand, and nesting deeper than 64.
    pub fn parse(
        text: &str,
        constants: &BTreeMap<String, f64>,
    ) -> Result<Expression, ExpressionError> {
        let code = parser::compile(text, constants)?;
        Ok(Expression { text: text.to_string(), code })
    }

    /// The constant expression `value`.
    pub fn constant(value: f64) -> Expression {
        Expression { text: value.to_string(), code: vec![Instruction::Push(value)] }
    }

    /// The value at the point `x` and the time `t`; 2-D callers give `x[2] = 0`. Does not allocate.
    ///
    /// The result may be infinite or NaN, as for `1 / x` at `x = 0`.
    pub fn eval(&self, x: [f64; 3], t: f64) -> f64 {
        let variables = [x[0], x[1], x[2], t];
        let mut stack = [0.0; STACK];
        let mut top = 0;
        for instruction in &self.code {
            match *instruction {
                Instruction::Push(v) => stack[top] = v,
                Instruction::Variable(k) => stack[top] = variables[k],
                Instruction::Apply(operation) => {
                    let first = top - operation.arity();
                    stack[first] = operation.apply(&stack[first..top]);
                    top = first;
                }
            }
            top += 1;
        }
        stack[0]
    }

    /// True if the value depends on time.
    pub fn depends_on_time(&self) -> bool {
        self.code.contains(&Instruction::Variable(TIME))
    }

    /// The value, if it depends neither on space nor on time.
    pub fn is_constant(&self) -> Option<f64> {
        match self.code[..] {
            [Instruction::Push(v)] => Some(v),
            _ => None,
        }
    }

    /// The source text of the expression.
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Expression) -> bool {
        self.code == other.code
    }
}

/// The names of the functions.
pub(crate) fn functions() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|f| f.0)
}

/// True if `name` cannot name a constant: a variable, `pi` or a function.
pub(crate) fn is_reserved(name: &str) -> bool {
    name == "pi" || VARIABLES.contains(&name) || FUNCTIONS.iter().any(|f| f.0 == name)
}
