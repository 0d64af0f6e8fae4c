//! Plain-text tables.

use std::fmt;

/// Alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A table of aligned columns, two spaces apart, with a line under its head. Colours do not count towards a width.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    head: Vec<(String, Align)>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table with these columns.
    pub(crate) fn new<T: Into<String>>(head: impl IntoIterator<Item = (T, Align)>) -> Self {
        Self { head: head.into_iter().map(|(title, align)| (title.into(), align)).collect(), rows: Vec::new() }
    }

    /// Adds a row; cells that are missing at its end stay empty.
    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.rows.push(cells.into_iter().map(Into::into).take(self.head.len()).collect());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let titles: Vec<String> = self.head.iter().map(|(title, _)| title.clone()).collect();
        let widths: Vec<usize> = (0..titles.len())
            .map(|n| {
                let cells = self.rows.iter().filter_map(|row| row.get(n));
                cells.chain([&titles[n]]).map(|cell| width(cell)).max().unwrap_or(0)
            })
            .collect();
        let line = |cells: &[String]| {
            let padded: Vec<String> = cells
                .iter()
                .zip(&self.head)
                .zip(&widths)
                .map(|((cell, (_, align)), &wide)| {
                    let space = " ".repeat(wide - width(cell));
                    match align {
                        Align::Left => format!("{cell}{space}"),
                        Align::Right => format!("{space}{cell}"),
                    }
                })
                .collect();
            padded.join("  ").trim_end().to_owned()
        };
        let rule: Vec<String> = widths.iter().map(|&wide| "-".repeat(wide)).collect();
        writeln!(f, "{}\n{}", line(&titles), rule.join("  "))?;
        self.rows.iter().try_for_each(|row| writeln!(f, "{}", line(row)))
    }
}

/// Columns that a text takes on a terminal, apart from colours (`ESC [ .. m`).
fn width(text: &str) -> usize {
    let mut coloured = false;
    text.chars()
        .filter(|&c| {
            let counts = !coloured && c != '\u{1b}';
            coloured = c == '\u{1b}' || coloured && c != 'm';
            counts
        })
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_colours_do_not_count() {
        let mut table = Table::new([("name", Align::Left), ("cost", Align::Right)]);
        table.row(["a", "1.25"]);
        table.row(["longer", "\u{1b}[31m7\u{1b}[0m"]);
        table.row(["b"]);
        let text = table.to_string();
        assert_eq!(text, "name    cost\n------  ----\na       1.25\nlonger     \u{1b}[31m7\u{1b}[0m\nb\n");
    }
}
