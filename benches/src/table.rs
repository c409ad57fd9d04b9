//! Tables in Markdown.

/// A table whose rows are as wide as its head.
pub(crate) struct Table {
    text: String,
    columns: usize,
}

impl Table {
    /// A table without rows.
    pub(crate) fn new<const N: usize>(head: [&str; N]) -> Self {
        let text = format!("| {} |\n|{}\n", head.join(" | "), "---|".repeat(N));
        Self { text, columns: N }
    }

    /// Adds a row; bars in its cells are escaped.
    ///
    /// # Panics
    /// If the row is not as wide as the head.
    pub(crate) fn push<S: AsRef<str>>(&mut self, row: impl IntoIterator<Item = S>) {
        let cells: Vec<String> =
            row.into_iter().map(|cell| cell.as_ref().replace('|', "\\|")).collect();
        assert_eq!(cells.len(), self.columns, "{cells:?}");
        self.text.push_str(&format!("| {} |\n", cells.join(" | ")));
    }

    /// The whole table.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }
}

/// The last cells of a claim's line in the table at the head of a section: the measured value, and
/// whether the claim holds.
pub(crate) fn verdict(measured: f64, holds: bool) -> [String; 2] {
    let measured = if measured.is_finite() { format!("{measured:.2}") } else { "-".to_owned() };
    let held = if measured == "-" {
        "not measured"
    } else if holds {
        "yes"
    } else {
        "no"
    };
    [measured, held.to_owned()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_markdown() {
        let mut table = Table::new(["a", "b"]);
        table.push(["1", "x|y"]);
        assert_eq!(table.text(), "| a | b |\n|---|---|\n| 1 | x\\|y |\n");
    }

    #[test]
    fn what_was_not_measured_is_not_held() {
        assert_eq!(verdict(f64::NAN, false), ["-", "not measured"]);
        assert_eq!(verdict(0.951, true), ["0.95", "yes"]);
    }
}
