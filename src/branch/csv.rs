//! Comma-separated cells (RFC 4180).

use std::io::Write;

/// In which line something is wrong, and what.
pub type Problem = (usize, String);

/// Writes a line of cells, quoted where they have to be.
pub fn write_record(file: &mut impl Write, cells: impl Iterator<Item = String>) -> std::io::Result<()> {
    for (i, cell) in cells.enumerate() {
        if i > 0 {
            file.write_all(b",")?;
        }
        if cell.contains([',', '"', '\n', '\r']) {
            write!(file, "\"{}\"", cell.replace('"', "\"\""))?;
        } else {
            file.write_all(cell.as_bytes())?;
        }
    }
    file.write_all(b"\n")
}

/// Splits CSV into records, each with the line where it begins. Empty lines are skipped.
pub fn records(text: &str) -> Result<Vec<(usize, Vec<String>)>, Problem> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut records = Vec::new();
    let (mut cells, mut cell) = (Vec::new(), String::new());
    let (mut line, mut begin, mut quoted) = (1, 1, false);
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        line += usize::from(c == '\n');
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => cell.extend(chars.next()),
            '"' => quoted = !quoted,
            _ if quoted => cell.push(c),
            ',' => cells.push(std::mem::take(&mut cell)),
            '\r' if chars.peek() == Some(&'\n') => {}
            '\n' => {
                end_record(&mut records, begin, &mut cells, &mut cell);
                begin = line;
            }
            _ => cell.push(c),
        }
    }
    if quoted {
        return Err((begin, "a quotation mark is not closed".into()));
    }
    end_record(&mut records, begin, &mut cells, &mut cell);
    Ok(records)
}

fn end_record(records: &mut Vec<(usize, Vec<String>)>, line: usize, cells: &mut Vec<String>, cell: &mut String) {
    if !(cells.is_empty() && cell.is_empty()) {
        cells.push(std::mem::take(cell));
        records.push((line, std::mem::take(cells)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_come_back_whatever_they_hold() {
        let cells = ["plain", "", "a,b", "say \"no\"", "two\nlines", "\r", "µm⁻¹"];
        let mut file = Vec::new();
        for _ in 0..2 {
            write_record(&mut file, cells.iter().map(|c| c.to_string())).unwrap();
        }
        let records = records(std::str::from_utf8(&file).unwrap()).unwrap();
        assert_eq!(records.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [1, 3]);
        assert!(records.iter().all(|(_, found)| *found == cells));
    }
}
