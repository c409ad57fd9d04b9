//! Pages of many groups, failed ones and names full of markup.

use crate::kit::synthetic;
use std::path::Path;
use unrender::report;
use unrender::run::Run;

/// Group names, most of which are not harmless.
const NAMES: [&str; 8] = [
    "floor",
    "<script>window.hacked = true</script>",
    "\"quoted\" & 'single' <b>bold</b>",
    "a/b~c 1",
    "<img src=x onerror=\"window.hacked = true\">",
    "wände, größer",
    "</td></tr></table><h1>no</h1>",
    "averylongnamewithoutanyplacetobreakitintoseverallinesofthetable",
];

fn names(count: usize) -> Vec<String> {
    let plain = (NAMES.len()..count.max(NAMES.len())).map(|i| format!("group {i}"));
    let mut names: Vec<String> = NAMES.iter().map(|n| (*n).to_owned()).chain(plain).collect();
    names.truncate(count - 1);
    names.push(synthetic::FAILED.to_owned());
    names
}

/// Writes results of `count` groups and their page, and the places of the groups for check.mjs.
pub(crate) fn make(folder: &Path, count: usize, size: (usize, usize)) -> Run {
    let names = names(count);
    let run = synthetic::write(folder, &names, size);
    report::write(folder).unwrap();
    let rows = count.div_ceil(synthetic::COLUMNS) as f64;
    let place = |(index, name): (usize, &String)| {
        let (column, row) = (index % synthetic::COLUMNS, index / synthetic::COLUMNS);
        let x = (column as f64 + 0.5) / synthetic::COLUMNS as f64;
        serde_json::json!({ "name": name, "x": x, "y": (row as f64 + 0.5) / rows })
    };
    let places: Vec<_> = names.iter().enumerate().map(place).collect();
    std::fs::write(folder.join("places.json"), serde_json::to_string(&places).unwrap()).unwrap();
    run
}
