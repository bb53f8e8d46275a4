//! Spatial derivatives of expressions by automatic differentiation in forward mode.

use super::operation::Operation::{self, *};
use super::{Expression, Instruction, STACK, TIME};

/// A value and its derivatives by x, y and z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Dual {
    value: f64,
    slope: [f64; 3],
}

impl Expression {
    /// The value at the point `x` and the time `t` with its gradient. Does not allocate.
    ///
    /// At a kink, as of `abs` and `if`, the gradient is that of one of the two sides. The
    /// derivative of comparisons, `floor`, `ceil` and `sign` is zero.
    pub fn eval_with_gradient(&self, x: [f64; 3], t: f64) -> (f64, [f64; 3]) {
        let mut stack = [Dual::default(); STACK];
        let mut top = 0;
        for instruction in &self.code {
            match *instruction {
                Instruction::Push(value) => stack[top] = Dual { value, slope: [0.0; 3] },
                Instruction::Variable(TIME) => stack[top] = Dual { value: t, slope: [0.0; 3] },
                Instruction::Variable(k) => {
                    stack[top] = Dual {
                        value: x[k],
                        slope: std::array::from_fn(|i| f64::from(u8::from(i == k))),
                    };
                }
                Instruction::Apply(operation) => {
                    let first = top - operation.arity();
                    stack[first] = apply(operation, &stack[first..top]);
                    top = first;
                }
            }
            top += 1;
        }
        (stack[0].value, stack[0].slope)
    }
}

/// The chain rule. Derivatives by constant arguments are skipped: that of `x^2` by the exponent
/// needs the logarithm of `x`.
fn apply(operation: Operation, arguments: &[Dual]) -> Dual {
    let mut values = [0.0; 3];
    values.iter_mut().zip(arguments).for_each(|(v, a)| *v = a.value);
    let values = &values[..arguments.len()];
    let mut slope = [0.0; 3];
    for (k, argument) in arguments.iter().enumerate() {
        if argument.slope != [0.0; 3] {
            let d = operation.derivative(values, k);
            slope.iter_mut().zip(argument.slope).for_each(|(s, a)| *s += d * a);
        }
    }
    Dual { value: operation.apply(values), slope }
}

impl Operation {
    /// The derivative by argument `k` at the arguments `a`.
    fn derivative(self, a: &[f64], k: usize) -> f64 {
        match *a {
            [x] => self.unary_derivative(x),
            [x, y] => self.binary_derivative(x, y, k),
            [c, ..] => f64::from(u8::from(k == if c != 0.0 { 1 } else { 2 })),
            _ => f64::NAN,
        }
    }

    fn unary_derivative(self, x: f64) -> f64 {
        match self {
            Negate => -1.0,
            Square => 2.0 * x,
            Sqrt => 0.5 / x.sqrt(),
            Exp => x.exp(),
            Log => 1.0 / x,
            Log10 => 1.0 / (x * std::f64::consts::LN_10),
            Sin => x.cos(),
            Cos => -x.sin(),
            Tan => 1.0 / x.cos().powi(2),
            Asin => 1.0 / (1.0 - x * x).sqrt(),
            Acos => -1.0 / (1.0 - x * x).sqrt(),
            Atan => 1.0 / (1.0 + x * x),
            Sinh => x.cosh(),
            Cosh => x.sinh(),
            Tanh => 1.0 / x.cosh().powi(2),
            Abs => x.signum(),
            _ => 0.0,
        }
    }

    /// Derivative by the first argument for `k = 0`, else by the second.
    fn binary_derivative(self, x: f64, y: f64, k: usize) -> f64 {
        let first = k == 0;
        match self {
            Add => 1.0,
            Subtract => choose(first, 1.0, -1.0),
            Multiply => choose(first, y, x),
            Divide => choose(first, 1.0 / y, -x / (y * y)),
            Power if first && y == 0.0 => 0.0,
            Power => choose(first, y * x.powf(y - 1.0), x.powf(y) * x.ln()),
            Min => choose(first == (x <= y), 1.0, 0.0),
            Max => choose(first == (x >= y), 1.0, 0.0),
            Hypot => choose(first, x, y) / x.hypot(y),
            Atan2 => choose(first, y, -x) / (x * x + y * y),
            _ => 0.0,
        }
    }
}

fn choose(c: bool, x: f64, y: f64) -> f64 {
    if c { x } else { y }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn expression(text: &str) -> Expression {
        Expression::parse(text, &BTreeMap::new()).unwrap()
    }

    /// Every function and operator with a derivative.
    const SMOOTH: [&str; 22] = [
        "-x^2 + 3 * x * y - z / (2 + y)",
        "sqrt(1 + x^2 + y)",
        "exp(-x * t) * log(2 + y)",
        "log10(3 + x + z)",
        "sin(2 * x + y) * cos(x - z * t)",
        "tan(x / 2)",
        "asin(x / 3) + acos(y / 3)",
        "atan(x * y)",
        "sinh(x) - cosh(y * z)",
        "tanh(x + y)",
        "abs(x - 3) * y",
        "(2 + x)^y",
        "(2 + x)^3.5",
        "2^(x * z)",
        "min(x + 4, y) + max(x, y - 5)",
        "hypot(x - 3, y)",
        "atan2(y + 4, x - 3)",
        "if(x < 5, x * y, y)",
        "if(x > 5, x * y, y^3)",
        "sign(x + 4) * z + floor(y / 9) + ceil(x / 9)",
        "pow(x + 4, 0.5)",
        "(x < y) * 0 + (x && y) + !x + x",
    ];

    proptest! {
        #[test]
        fn gradients_are_those_of_small_differences(
            x in prop::array::uniform3(0.05f64..0.95), t in 0.0f64..1.0, k in 0usize..SMOOTH.len()
        ) {
            let e = expression(SMOOTH[k]);
            let (value, gradient) = e.eval_with_gradient(x, t);
            prop_assert_eq!(value, e.eval(x, t));
            for i in 0..3 {
                let (mut before, mut after) = (x, x);
                before[i] -= 1e-6;
                after[i] += 1e-6;
                let slope = (e.eval(after, t) - e.eval(before, t)) / 2e-6;
                prop_assert!((slope - gradient[i]).abs() < 1e-7 * (1.0 + slope.abs()), "{}: {slope} {gradient:?}", SMOOTH[k]);
            }
        }
    }

    #[test]
    fn powers_of_zero_and_of_negative_numbers_have_their_derivatives() {
        assert_eq!(
            expression("x^3").eval_with_gradient([-2.0, 0.0, 0.0], 0.0),
            (-8.0, [12.0, 0.0, 0.0])
        );
        assert_eq!(
            expression("x^2 * y^4").eval_with_gradient([0.0, 0.0, 0.0], 0.0),
            (0.0, [0.0; 3])
        );
        assert_eq!(expression("x^0").eval_with_gradient([0.0; 3], 0.0), (1.0, [0.0; 3]));
    }
}
