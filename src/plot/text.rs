//! Text on the page: how wide it is, how it is cut to fit, how names of columns are written.

/// An estimate from above of a text's width; DejaVu Sans, the widest of the usual sans-serif fonts, is the measure.
pub fn width(text: &str, size: f64) -> f64 {
    text.chars().map(advance).sum::<f64>() * size
}

fn advance(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | 'I' | '\'' => 0.3,
        ' ' | '.' | ',' | ':' | ';' | '|' | '/' => 0.34,
        'f' | 'r' | 't' | '(' | ')' | '[' | ']' | '-' => 0.42,
        '⁰' | '¹' | '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' => 0.41,
        '⁻' => 0.53,
        'm' => 0.98,
        'M' | 'W' | 'w' | '×' | '−' | '+' | '=' | '%' => 0.9,
        'a'..='z' | '0'..='9' | 'µ' | 'α'..='ω' => 0.64,
        'A'..='Z' => 0.74,
        _ => 1.0,
    }
}

/// The text, shortened by an ellipsis if it is wider than there is room.
pub fn fitted(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let mut short = String::new();
    let mut used = width("…", size);
    for c in text.chars() {
        used += advance(c) * size;
        if used > room {
            break;
        }
        short.push(c);
    }
    format!("{}…", short.trim_end())
}

/// Breaks a text into lines between words.
pub fn wrapped(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let word = fitted(word, size, room);
        match lines.last_mut() {
            Some(line) if width(&format!("{line} {word}"), size) <= room => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

/// A column's name for readers.
pub fn readable(name: &str) -> String {
    name.replace('_', " ")
}

/// "name (unit)", with a power of ten where the tick labels leave one out.
pub fn with_unit(name: &str, unit: &str, power: i32) -> String {
    let factor = match power {
        0 => String::new(),
        _ => format!("×10{}", superscript(power)),
    };
    match (factor.is_empty(), unit.is_empty()) {
        (true, true) => name.to_owned(),
        (true, false) => format!("{name} ({unit})"),
        (false, true) => format!("{name} ({factor})"),
        (false, false) => format!("{name} ({factor} {unit})"),
    }
}

/// A power of ten as it is written raised.
pub fn superscript(power: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    };
    power.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_labels_have_units_and_powers() {
        assert_eq!(with_unit("p", "pN µm⁻¹", 0), "p (pN µm⁻¹)");
        assert_eq!(with_unit("p", "pN µm⁻¹", -12), "p (×10⁻¹² pN µm⁻¹)");
        assert_eq!(with_unit("ratio", "", 9), "ratio (×10⁹)");
        assert_eq!(with_unit(&readable("tip_angle"), "", 0), "tip angle");
    }

    #[test]
    fn long_text_is_cut_or_broken() {
        let text = "a rather long title of a figure";
        assert_eq!(fitted(text, 10.0, 1000.0), text);
        let short = fitted(text, 10.0, 60.0);
        assert!(short.ends_with('…') && width(&short, 10.0) <= 60.0);
        let lines = wrapped(text, 10.0, 100.0);
        assert!(lines.len() > 1 && lines.iter().all(|l| width(l, 10.0) <= 100.0));
        assert_eq!(lines.join(" "), text);
        assert!(wrapped("  ", 10.0, 100.0).is_empty());
    }
}
