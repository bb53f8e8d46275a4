//! Operators and functions of expressions.

/// Operation of an instruction on the top values of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operation {
    Negate,
    Not,
    Square,
    Sqrt,
    Exp,
    Log,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Abs,
    Sign,
    Floor,
    Ceil,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Less,
    Greater,
    LessEqual,
    GreaterEqual,
    Equal,
    NotEqual,
    And,
    Or,
    Min,
    Max,
    Hypot,
    Atan2,
    If,
}

use Operation::*;

/// The functions by name.
pub(super) const FUNCTIONS: [(&str, Operation); 23] = [
    ("sqrt", Sqrt),
    ("exp", Exp),
    ("log", Log),
    ("log10", Log10),
    ("sin", Sin),
    ("cos", Cos),
    ("tan", Tan),
    ("asin", Asin),
    ("acos", Acos),
    ("atan", Atan),
    ("sinh", Sinh),
    ("cosh", Cosh),
    ("tanh", Tanh),
    ("abs", Abs),
    ("sign", Sign),
    ("floor", Floor),
    ("ceil", Ceil),
    ("min", Min),
    ("max", Max),
    ("hypot", Hypot),
    ("atan2", Atan2),
    ("pow", Power),
    ("if", If),
];

/// Precedence of the operators. Comparisons do not chain; powers are right-associative.
pub(super) mod binding {
    pub const OR: u8 = 1;
    pub const AND: u8 = 2;
    pub const COMPARISON: u8 = 3;
    pub const SUM: u8 = 4;
    pub const PRODUCT: u8 = 5;
    pub const PREFIX: u8 = 6;
    pub const POWER: u8 = 7;
}

/// The binary operators; an operator with another one as prefix comes before it.
pub(super) const OPERATORS: [(&str, Operation, u8); 13] = [
    ("||", Or, binding::OR),
    ("&&", And, binding::AND),
    ("<=", LessEqual, binding::COMPARISON),
    (">=", GreaterEqual, binding::COMPARISON),
    ("==", Equal, binding::COMPARISON),
    ("!=", NotEqual, binding::COMPARISON),
    ("<", Less, binding::COMPARISON),
    (">", Greater, binding::COMPARISON),
    ("+", Add, binding::SUM),
    ("-", Subtract, binding::SUM),
    ("*", Multiply, binding::PRODUCT),
    ("/", Divide, binding::PRODUCT),
    ("^", Power, binding::POWER),
];

impl Operation {
    /// The number of arguments.
    pub fn arity(self) -> usize {
        match self {
            If => 3,
            _ if (self as usize) >= (Add as usize) => 2,
            _ => 1,
        }
    }

    /// The result for the first [`arity`](Self::arity) arguments of `a`. True is 1, false is 0.
    #[inline]
    pub fn apply(self, a: &[f64]) -> f64 {
        match *a {
            [x] => self.unary(x),
            [x, y] => self.binary(x, y),
            [c, x, y] => choose(c != 0.0, x, y),
            _ => f64::NAN,
        }
    }

    #[inline]
    fn unary(self, x: f64) -> f64 {
        match self {
            Negate => -x,
            Not => truth(x == 0.0),
            Square => x * x,
            Sqrt => x.sqrt(),
            Exp => x.exp(),
            Log => x.ln(),
            Log10 => x.log10(),
            Sin => x.sin(),
            Cos => x.cos(),
            Tan => x.tan(),
            Asin => x.asin(),
            Acos => x.acos(),
            Atan => x.atan(),
            Sinh => x.sinh(),
            Cosh => x.cosh(),
            Tanh => x.tanh(),
            Abs => x.abs(),
            Sign if x > 0.0 => 1.0,
            Sign if x < 0.0 => -1.0,
            Sign => x * 0.0,
            Floor => x.floor(),
            Ceil => x.ceil(),
            _ => f64::NAN,
        }
    }

    #[inline]
    fn binary(self, x: f64, y: f64) -> f64 {
        match self {
            Add => x + y,
            Subtract => x - y,
            Multiply => x * y,
            Divide => x / y,
            Power => x.powf(y),
            Less => truth(x < y),
            Greater => truth(x > y),
            LessEqual => truth(x <= y),
            GreaterEqual => truth(x >= y),
            Equal => truth(x == y),
            NotEqual => truth(x != y),
            And => truth(x != 0.0 && y != 0.0),
            Or => truth(x != 0.0 || y != 0.0),
            Min => x.min(y),
            Max => x.max(y),
            Hypot => x.hypot(y),
            Atan2 => x.atan2(y),
            _ => f64::NAN,
        }
    }
}

fn truth(c: bool) -> f64 {
    choose(c, 1.0, 0.0)
}

fn choose(c: bool, x: f64, y: f64) -> f64 {
    if c { x } else { y }
}
