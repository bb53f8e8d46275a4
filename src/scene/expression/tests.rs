use super::*;
use proptest::prelude::*;

fn constants() -> BTreeMap<String, f64> {
    BTreeMap::from([("lambda".to_string(), 10.0), ("R".to_string(), 0.5)])
}

fn value(text: &str) -> f64 {
    Expression::parse(text, &constants()).unwrap().eval([2.0, 3.0, 5.0], 7.0)
}

fn fault(text: &str) -> ExpressionError {
    Expression::parse(text, &constants()).unwrap_err()
}

#[test]
fn precedence_follows_the_written_formula() {
    for (text, expected) in [
        ("-x^2", -4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("-2^-x^2", -0.0625),
        ("1 + 2*3 - 4/2", 5.0),
        ("8 - 4 - 2", 2.0),
        ("16 / 4 / 2", 2.0),
        ("2*-3", -6.0),
        ("--x", 2.0),
        ("+x", 2.0),
        ("(1+2)*3", 9.0),
        (" x\t*\n y ", 6.0),
        ("1 < 2 && 2 < 1 || 3 >= 3", 1.0),
        ("!(x == 2)", 0.0),
        ("!x + 1", 1.0),
        ("x != 2", 0.0),
        ("1 + 1 <= 2", 1.0),
        (".5 + 1. + 1e-1 + 2E+1", 21.6),
        ("x + y*z - t", 10.0),
        ("lambda * R", 5.0),
    ] {
        assert!((value(text) - expected).abs() < 1e-14, "{text} gave {}", value(text));
    }
}

#[test]
fn functions_are_those_of_the_mathematics() {
    let e = std::f64::consts::E;
    for (text, expected) in [
        ("sqrt(16)", 4.0),
        ("x^0.5", 2f64.sqrt()),
        ("exp(1)", e),
        ("log(exp(x))", 2.0),
        ("log10(1000)", 3.0),
        ("sin(pi/6)", 0.5),
        ("cos(pi/3)", 0.5),
        ("tan(pi/4)", 1.0),
        ("asin(1)*2/pi", 1.0),
        ("acos(0)*2/pi", 1.0),
        ("atan(1)*4/pi", 1.0),
        ("sinh(x)", (e * e - 1.0 / (e * e)) / 2.0),
        ("cosh(x)", (e * e + 1.0 / (e * e)) / 2.0),
        ("tanh(x)", ((4.0f64).exp() - 1.0) / ((4.0f64).exp() + 1.0)),
        ("abs(-x)", 2.0),
        ("sign(-x) + sign(x)*10 + sign(x-2)", 9.0),
        ("floor(-0.5) + ceil(0.2)", 0.0),
        ("min(x, y) + 10*max(x, y)", 32.0),
        ("hypot(3, 4)", 5.0),
        ("atan2(1, -1)", 0.75 * std::f64::consts::PI),
        ("pow(x, y)", 8.0),
        ("if(x < y, 1, 2)", 1.0),
        ("if(x > y, 1/0, 2)", 2.0),
    ] {
        assert!((value(text) - expected).abs() < 1e-13, "{text} gave {}", value(text));
    }
}

#[test]
fn constants_and_time_are_recognised() {
    let parse = |text| Expression::parse(text, &constants()).unwrap();
    assert_eq!(parse("2*lambda + sin(0)").is_constant(), Some(20.0));
    assert_eq!(parse("2*x").is_constant(), None);
    assert!(parse("sin(t)").depends_on_time());
    assert!(!parse("x*y").depends_on_time());
    assert_eq!(Expression::constant(6.0), parse("2*3"));
    assert_eq!(Expression::constant(0.1).text(), "0.1");
}

#[test]
fn errors_say_what_where_and_what_to_write() {
    for (text, at, part) in [
        ("", 0..0, "empty"),
        ("  ", 0..2, "empty"),
        ("1 +", 3..3, "ends too early"),
        ("(1", 0..1, "never closed"),
        ("1)", 1..2, "remove this"),
        ("2x", 1..2, "2*x"),
        ("x y", 2..3, "2*x"),
        ("x**2", 2..3, "x^2"),
        ("sinn(x)", 0..4, "did you mean `sin`?"),
        ("1 + Lambda", 4..10, "did you mean `lambda`?"),
        ("1 + foo", 4..7, "x, y, z, t, pi, R, lambda"),
        ("sin", 0..3, "sin(...)"),
        ("x(2)", 1..2, "2*x"),
        ("atan2(1)", 0..5, "takes 2 arguments, 1 given"),
        ("if(1,2)", 0..2, "if(a, b, c)"),
        ("sin()", 0..3, "takes 1 argument, 0 given"),
        ("1 < x < 2", 6..7, "a < b && b < c"),
        ("x = 2", 2..3, "=="),
        ("1,5", 1..2, "point"),
        ("1e999", 0..5, "1.7e308"),
        (".", 0..1, "0.5"),
        ("2 * é", 4..6, "expected a number"),
    ] {
        let e = fault(text);
        assert_eq!(e.at, at, "{text}: {e:?}");
        assert!(format!("{} {}", e.message, e.hint).contains(part), "{text}: {e:?}");
    }
}

#[test]
fn deep_nesting_is_refused_and_long_sums_are_not() {
    for text in
        ["(".repeat(100_000), "-".repeat(100_000), "2^".repeat(100_000), "sin(".repeat(100_000)]
    {
        assert!(fault(&text).message.contains("than 64"));
    }
    let deep = format!("{}x{}", "(".repeat(60), ")".repeat(60));
    assert_eq!(value(&deep), 2.0);
    assert_eq!(value(&vec!["x"; 100_000].join("+")), 200_000.0);
    let wide = format!("{}x{}", "max(x, (x+(x*".repeat(25), ")))".repeat(25));
    assert!(fault(&wide).message.contains("64"));
}

/// A random expression with its value computed beside it.
fn tree() -> impl Strategy<Value = (String, f64)> {
    let number = (0u32..1000).prop_map(|n| (format!("{}", f64::from(n) / 8.0), f64::from(n) / 8.0));
    let name =
        prop::sample::select(vec![("x", 2.0), ("y", 3.0), ("z", 5.0), ("t", 7.0), ("R", 0.5)])
            .prop_map(|(s, v)| (s.to_string(), v));
    prop_oneof![number, name].prop_recursive(5, 64, 3, |inner| {
        let pair = (inner.clone(), inner.clone());
        let binary = (pair, 0..10usize).prop_map(|(((a, x), (b, y)), k)| match k {
            0 => (format!("({a}) + ({b})"), x + y),
            1 => (format!("({a}) - ({b})"), x - y),
            2 => (format!("({a})*({b})"), x * y),
            3 => (format!("({a})/({b})"), x / y),
            4 => (format!("min({a},{b})"), x.min(y)),
            5 => (format!("hypot({a}, {b})"), x.hypot(y)),
            6 => (format!("({a})<({b})"), f64::from(u8::from(x < y))),
            7 => (format!("atan2({a}, {b})"), x.atan2(y)),
            8 => (format!("({a}) >= ({b}) || !({a})"), f64::from(u8::from(x >= y || x == 0.0))),
            _ => (format!("if({a}, {b}, -1)"), if x != 0.0 { y } else { -1.0 }),
        });
        let unary = (inner, 0..5usize).prop_map(|((a, x), k)| match k {
            0 => (format!("-({a})"), -x),
            1 => (format!("sin({a})"), x.sin()),
            2 => (format!("abs({a})"), x.abs()),
            3 => (format!("({a})^2"), x * x),
            _ => (format!("tanh({a})"), x.tanh()),
        });
        prop_oneof![2 => binary, 1 => unary]
    })
}

proptest! {
    #[test]
    fn random_trees_agree_with_direct_evaluation((text, expected) in tree()) {
        match Expression::parse(&text, &constants()) {
            Ok(e) => {
                let got = e.eval([2.0, 3.0, 5.0], 7.0);
                prop_assert!(got == expected || (got.is_nan() && expected.is_nan()), "{text}: {got} != {expected}");
            }
            Err(e) => prop_assert!(false, "{text}: {e:?}"),
        }
    }

    #[test]
    fn arbitrary_text_never_panics(text in ".*") {
        if let Err(e) = Expression::parse(&text, &constants()) {
            prop_assert!(text.get(e.at).is_some());
        }
    }

    #[test]
    fn arbitrary_tokens_never_panic(words in prop::collection::vec(prop::sample::select(vec![
        "x", "t", "1", ".5", "1e", "sin", "if", "(", ")", ",", "+", "-", "*", "/", "^", "<", "<=", "==", "&&", "||", "!",
        "R", "é", " ", "=", "&",
    ]), 0..40)) {
        match Expression::parse(&words.concat(), &constants()) {
            Ok(e) => { e.eval([1.0, 2.0, 3.0], 4.0); }
            Err(e) => prop_assert!(words.concat().get(e.at).is_some()),
        }
    }
}
