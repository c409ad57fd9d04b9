//! Tables whose rows are replaced by their first cells, so that rooms and programs can be measured one at a time.

use crate::table::Table;

/// The rows of a new table of `N` columns: `new` ones, and of those in `old` (Markdown) the ones whose first `key`
/// cells no new row has; in the order of `place`, which ranks a row's first cell.
pub(crate) fn merged<const N: usize>(
    head: [&str; N],
    key: usize,
    old: &str,
    new: Vec<[String; N]>,
    place: impl Fn(&str) -> usize,
) -> String {
    let kept = parse::<N>(old)
        .into_iter()
        .filter(|row| !new.iter().any(|other| other[..key] == row[..key]));
    let mut rows: Vec<[String; N]> = kept.chain(new.iter().cloned()).collect();
    // Stable: the rows of a room stay in the order in which they were measured.
    rows.sort_by_key(|row| place(&row[0]));
    if rows.is_empty() {
        return "Not measured yet.\n".to_owned();
    }
    let mut table = Table::new(head);
    rows.into_iter().for_each(|row| table.push(row));
    table.text().to_owned()
}

/// The rows below the head of a Markdown table; those of another width are left out.
fn parse<const N: usize>(text: &str) -> Vec<[String; N]> {
    let lines = text.lines().map(str::trim).filter(|line| line.starts_with('|')).skip(2);
    lines
        .filter_map(|line| {
            let inner = line.strip_prefix('|')?.strip_suffix('|')?;
            let cells: Vec<String> = inner.split('|').map(|cell| cell.trim().to_owned()).collect();
            cells.try_into().ok()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(cells: [&str; 3]) -> [String; 3] {
        cells.map(str::to_owned)
    }

    #[test]
    fn rows_of_the_same_key_are_replaced_and_others_stay() {
        let place = |room: &str| usize::from(room == "b");
        let head = ["room", "program", "dB"];
        let first = vec![row(["b", "old", "1"]), row(["a", "old", "2"])];
        assert!(!merged(head, 2, "", Vec::new(), place).contains('|'));
        let text = merged(head, 2, "", first, place);
        assert_eq!(
            text,
            "| room | program | dB |\n|---|---|---|\n| a | old | 2 |\n| b | old | 1 |\n"
        );
        let text =
            merged(head, 2, &text, vec![row(["b", "new", "3"]), row(["a", "old", "4"])], place);
        let body: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(body, ["| a | old | 4 |", "| b | old | 1 |", "| b | new | 3 |"]);
    }
}
