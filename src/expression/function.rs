//! The usual functions of one variable.

use num_dual::DualNum;

/// Above this, tanh is taken from exp(-2|x|): num-dual's sinh / cosh is inf / inf from 711 on.
const LARGE_TANH: f64 = 20.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Exp,
    Log,
    Log10,
    Sqrt,
    Abs,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
}

impl Function {
    pub const ALL: [(&'static str, Function); 17] = [
        ("sin", Function::Sin),
        ("cos", Function::Cos),
        ("tan", Function::Tan),
        ("asin", Function::Asin),
        ("acos", Function::Acos),
        ("atan", Function::Atan),
        ("exp", Function::Exp),
        ("log", Function::Log),
        ("log10", Function::Log10),
        ("sqrt", Function::Sqrt),
        ("abs", Function::Abs),
        ("sinh", Function::Sinh),
        ("cosh", Function::Cosh),
        ("tanh", Function::Tanh),
        ("asinh", Function::Asinh),
        ("acosh", Function::Acosh),
        ("atanh", Function::Atanh),
    ];

    pub fn named(name: &str) -> Option<Function> {
        Function::ALL.iter().find(|(known, _)| *known == name).map(|&(_, function)| function)
    }

    pub fn name(self) -> &'static str {
        Function::ALL.iter().find(|(_, known)| *known == self).map_or("", |&(name, _)| name)
    }

    /// Outside the domain the result is not finite, as IEEE arithmetic has it.
    pub fn apply<S: DualNum<Primitive = f64> + Clone>(self, x: S) -> S {
        match self {
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tan => x.tan(),
            Function::Asin => x.asin(),
            Function::Acos => x.acos(),
            Function::Atan => x.atan(),
            Function::Exp => x.exp(),
            Function::Log => x.ln(),
            Function::Log10 => x.log10(),
            Function::Sqrt => x.sqrt(),
            Function::Abs => x.abs(),
            Function::Sinh => x.sinh(),
            Function::Cosh => x.cosh(),
            Function::Tanh => tanh(x),
            Function::Asinh => x.asinh(),
            Function::Acosh => x.acosh(),
            Function::Atanh => x.atanh(),
        }
    }
}

fn tanh<S: DualNum<Primitive = f64> + Clone>(x: S) -> S {
    let value = x.re();
    if value.abs() < LARGE_TANH || value.is_nan() {
        return x.tanh();
    }
    let small = (x.abs() * -2.0).exp();
    let result = (-small.clone() + 1.0) / (small + 1.0);
    if value < 0.0 { -result } else { result }
}
