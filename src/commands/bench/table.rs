//! Plain tables for a terminal.

/// Rows of cells as aligned lines; the first column to the left, the others to the right.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter()
            .filter_map(|row| row.get(column))
            .map(|cell| cell.chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let cell = |(column, text): (usize, &String)| {
        let width = widths[column];
        if column == 0 { format!("{text:<width$}") } else { format!("{text:>width$}") }
    };
    let line = |row: &Vec<String>| {
        row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// A time in the unit that reads best, or a dash.
pub fn seconds(time: Option<f64>) -> String {
    match time {
        None => "-".to_owned(),
        Some(time) if time < 1e-6 => format!("{:.0} ns", time * 1e9),
        Some(time) if time < 1e-3 => format!("{:.1} us", time * 1e6),
        Some(time) if time < 1.0 => format!("{:.1} ms", time * 1e3),
        Some(time) => format!("{time:.2} s"),
    }
}

/// A count, or a dash.
pub fn count(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.0}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let rows =
            [vec!["name".to_owned(), "x".to_owned()], vec!["a".to_owned(), "100".to_owned()]];
        assert_eq!(aligned(&rows), "name    x\na     100");
        assert_eq!(aligned(&[]), "");
    }

    #[test]
    fn times_have_their_units() {
        let texts = [None, Some(2e-7), Some(2e-5), Some(0.02), Some(2.0)].map(seconds);
        assert_eq!(texts, ["-", "200 ns", "20.0 us", "20.0 ms", "2.00 s"]);
    }
}
