//! A formula as a program for a stack machine, in reverse Polish notation.

use super::functions::{Function, Operation};

/// One step of a program.
#[derive(Clone, Copy)]
pub enum Step {
    /// Pushes a number
    Number(f64),
    /// Pushes the value of a variable
    Variable(usize),
    /// Negates the last value
    Negate,
    /// Replaces the last value by a function of it
    Apply(&'static Function),
    /// Replaces the last two values by one
    Combine(Operation),
}

/// A value with its derivative.
#[derive(Clone, Copy)]
struct Dual {
    value: f64,
    rate: f64,
}

/// Factor times rate; a zero rate stays zero whatever the factor, even NaN.
fn chain(factor: f64, rate: f64) -> f64 {
    if rate == 0.0 { 0.0 } else { factor * rate }
}

/// Numbers on which a program computes: values, or values with derivatives.
trait Arithmetic: Copy {
    fn constant(value: f64) -> Self;
    fn negate(self) -> Self;
    fn apply(self, function: &Function) -> Self;
    fn combine(self, other: Self, operation: Operation) -> Self;
}

impl Arithmetic for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn negate(self) -> Self {
        -self
    }

    fn apply(self, function: &Function) -> Self {
        (function.value)(self)
    }

    fn combine(self, other: Self, operation: Operation) -> Self {
        operation.value(self, other)
    }
}

impl Arithmetic for Dual {
    fn constant(value: f64) -> Self {
        Self { value, rate: 0.0 }
    }

    fn negate(self) -> Self {
        Self { value: -self.value, rate: -self.rate }
    }

    fn apply(self, function: &Function) -> Self {
        let factor = function.derivative.map_or(f64::NAN, |derivative| derivative(self.value));
        Self { value: (function.value)(self.value), rate: chain(factor, self.rate) }
    }

    fn combine(self, other: Self, operation: Operation) -> Self {
        let [a, b] = operation.derivatives(self.value, other.value);
        Self { value: operation.value(self.value, other.value), rate: chain(a, self.rate) + chain(b, other.rate) }
    }
}

/// The steps of a formula, which leave one value on the stack.
#[derive(Default)]
pub struct Program(pub Vec<Step>);

impl Program {
    fn run<N: Arithmetic>(&self, variable: impl Fn(usize) -> N) -> N {
        let mut stack: Vec<N> = Vec::with_capacity(8);
        for step in &self.0 {
            let next = match step {
                Step::Number(number) => N::constant(*number),
                Step::Variable(k) => variable(*k),
                Step::Negate => pop(&mut stack).negate(),
                Step::Apply(function) => pop(&mut stack).apply(function),
                Step::Combine(operation) => {
                    let other = pop(&mut stack);
                    pop(&mut stack).combine(other, *operation)
                }
            };
            stack.push(next);
        }
        pop(&mut stack)
    }

    /// Value for these values of the variables.
    pub fn value(&self, variables: &[f64]) -> f64 {
        self.run(|k| variables[k])
    }

    /// Derivative with respect to the first variable with the others fixed; NaN if it does not exist.
    pub fn derivative(&self, variables: &[f64]) -> f64 {
        self.run(|k| Dual { value: variables[k], rate: if k == 0 { 1.0 } else { 0.0 } }).rate
    }
}

fn pop<N>(stack: &mut Vec<N>) -> N {
    stack.pop().expect("the parser puts values before what takes them")
}
