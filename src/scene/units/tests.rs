use super::*;
use proptest::prelude::*;

#[test]
fn spellings_of_one_unit_are_one_unit() {
    for spelling in [
        "pN s µm⁻²",
        "pN s μm^-2",
        "pN*s/um^2",
        "pN·s·µm⁻²",
        "pN s / µm^2",
        "s pN/µm/µm",
        " pN  s µm^-2 ",
        "1/µm² * pN s",
    ] {
        assert_eq!(conversion(spelling, "pN s µm^-2"), Ok(1.0), "{spelling}");
    }
}

#[test]
fn factors_are_exact_powers_of_ten() {
    for (from, to, factor) in [
        ("nm", "µm", 1e-3),
        ("µm", "nm", 1e3),
        ("mm", "m", 1e-3),
        ("m", "fm", 1e15),
        ("cm", "mm", 1e1),
        ("N", "g m s^-2", 1e3),
        ("N", "kg m/s^2", 1.0),
        ("Pa", "N/m²", 1.0),
        ("J", "N m", 1.0),
        ("pN/µm²", "Pa", 1.0),
        ("pN µm²", "N m^2", 1e-24),
        ("GPa", "kPa", 1e6),
        ("1/ms", "1/s", 1e3),
        ("kHz", "1/s", 1e3),
        ("rad/s", "1/s", 1.0),
        ("mrad", "rad", 1e-3),
        ("", "-", 1.0),
        ("rad", "", 1.0),
        ("µm/nm", "-", 1e3),
    ] {
        assert_eq!(conversion(from, to), Ok(factor), "{from} -> {to}");
    }
}

#[test]
fn errors_tell_what_to_do() {
    let long = "m ".repeat(200);
    let complaint = |from: &str, to: &str| match conversion(from, to) {
        Ok(factor) => panic!("{from} -> {to} gave {factor}"),
        Err(error) => error.to_string(),
    };
    assert_eq!(
        complaint("nm", "pN s"),
        "the units \"nm\" and \"pN s\" do not fit: their dimensions are m and m g s^-1"
    );
    assert!(complaint("", "s").contains("none (a pure number) and s"));
    assert!(
        complaint("furlong", "m").starts_with("unknown symbol \"furlong\" in the unit \"furlong\"; known are m, s, g")
    );
    assert!(complaint("m", "pN (s").contains("unknown symbol \"(s\""));
    assert!(complaint("Hz", "rad/s").contains("2 pi"));
    assert!(complaint("Gm^99", "m^99").contains("1e891"));
    assert!(complaint(&long, "m").contains("cannot be read"));
    for unreadable in ["/s", "m//s", "m/", "m^", "m^x", "m^1.5", "m²x", "m^999999999999", "m * * s"] {
        assert!(complaint(unreadable, "m").contains("cannot be read near"), "{unreadable}");
    }
}

proptest! {
    #[test]
    fn any_text_is_answered(text in "\\PC{0,30}") {
        let _ = conversion(&text, "m");
    }

    #[test]
    fn any_unit_like_text_is_answered(text in "[mskNPag/*^ ⁻²0-9-]{0,300}") {
        let _ = conversion(&text, "m");
    }
}
