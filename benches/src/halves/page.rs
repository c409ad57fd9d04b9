//! Writes `halves.md`, a row per constant.

use super::code::Constant;
use super::measure::Outcome;
use crate::table::Table;
use crate::{Failure, machine};
use std::path::Path;
use unrender::formats::atomic;

const FILE: &str = "halves.md";

const HEAD: &str = "# Half and double of the constants

The effect of half and double of the recovery's constants on the six tiny scenes of `examples/corpus`, which other
renderers photographed. Each cell: how many groups have the right hypothesis, the median error of their rho_d, and the
seconds of all recoveries. The scenes are small, so that a row takes minutes: an effect that does not show here may show
in a room. The constants are described in [their list](../constants.md). Written by

```console
cargo run --release -p unrender-benches -- halves NAMES
```

";

/// Writes the row of `constant` into the page in `folder`; those of others stay.
///
/// # Errors
/// If it cannot be written.
pub(super) fn write(
    folder: &Path,
    constant: &Constant,
    as_it_is: &Outcome,
    [half, double]: [String; 2],
) -> Result<(), Failure> {
    let path = folder.join(FILE);
    let before = std::fs::read_to_string(&path).unwrap_or_default();
    let name = format!("`{constant}`");
    let value = format!("`{}`", constant.value);
    let origin = machine::origin();
    let origin = origin.trim_start_matches("Measured on ").trim_end_matches('.').to_owned();
    let row = [name, value, as_it_is.to_string(), half, double, origin];
    std::fs::create_dir_all(folder)?;
    Ok(atomic::write(&path, with_row(&before, row).as_bytes())?)
}

/// The page `before` with this row in its place.
fn with_row(before: &str, row: [String; 6]) -> String {
    let mut rows: Vec<[String; 6]> = before.lines().filter_map(cells).collect();
    rows.retain(|other| other[0] != row[0]);
    rows.push(row);
    rows.sort();
    let mut table = Table::new(["constant", "value", "as it is", "half", "double", "measured"]);
    rows.iter().for_each(|row| table.push(row));
    format!("{HEAD}{}", table.text())
}

/// The cells of a row of the table, if `line` is one.
fn cells(line: &str) -> Option<[String; 6]> {
    let inside = line.strip_prefix("| `")?.strip_suffix(" |")?;
    let cells: Vec<String> = format!("`{inside}").split(" | ").map(str::to_owned).collect();
    cells.try_into().ok()
}

/// The first line of `text`, short.
pub(super) fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_replaced_and_others_stay() {
        let row = |name: &str, half: &str| {
            [name, "`1.0`", "6 of 6", half, "5 of 6", "today"].map(str::to_owned)
        };
        let page = with_row("", row("`b::B`", "4 of 6"));
        let page = with_row(&page, row("`a::A`", "3 of 6"));
        let page = with_row(&page, row("`b::B`", "2 of 6"));
        let rows: Vec<[String; 6]> = page.lines().filter_map(cells).collect();
        assert_eq!(rows, [row("`a::A`", "3 of 6"), row("`b::B`", "2 of 6")]);
    }
}
