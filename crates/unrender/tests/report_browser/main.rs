//! The pages in headless Chromium: they load whole and offline, answer to pointer and keys, hold
//! with many groups, failed ones and names full of markup, and say what run.json says.
//!
//! What is done in the browser stands in `check.mjs`. Node.js drives it with puppeteer, which `npm`
//! installs into the build folder; the browser is Chromium or Chrome where there is one, or else one
//! from npm. Where something of this is missing, the test says so and is skipped.

mod recovered;
mod synthetic;

use std::path::{Path, PathBuf};
use std::process::Command;
use unrender::report::{self, Exhibit};
use unrender::run::Run;

/// The exit code with which check.mjs says that there is no browser.
const NO_BROWSER: i32 = 77;

/// Names that are not as harmless as they should be.
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

/// Where the pages are made, and where npm installs.
fn workplace() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report_browser");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn names(count: usize) -> Vec<String> {
    let plain = (NAMES.len()..count.max(NAMES.len())).map(|i| format!("group {i}"));
    let mut names: Vec<String> = NAMES.iter().map(|n| (*n).to_owned()).chain(plain).collect();
    names.truncate(count - 1);
    names.push(synthetic::FAILED.to_owned());
    names
}

/// Writes results of `count` groups and their page; tells check.mjs where the groups are.
fn make(folder: &Path, count: usize, size: (usize, usize)) -> Run {
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

#[test]
fn run_json_reads_back() {
    let folder = workplace().join("back");
    let run = make(&folder, 9, (160, 90));
    assert_eq!(Run::read(&folder).unwrap(), run);
    let error = Run::read(&workplace().join("nowhere")).unwrap_err().to_string();
    assert!(error.contains("run.json: cannot be read"), "{error}");
}

#[test]
fn a_page_of_a_large_photograph_stays_small() {
    for (width, height) in [(1200, 900), (2400, 1600)] {
        let folder = workplace().join("large");
        make(&folder, 60, (width, height));
        let bytes = std::fs::metadata(folder.join(report::FILE)).unwrap().len();
        assert!(bytes < 5_000_000, "{width} x {height}: {bytes} bytes");
    }
}

#[test]
fn the_page_is_made_of_the_files_beside_it() {
    let folder = workplace().join("remade");
    let told = recovered::make(&folder);
    let run = std::fs::read_to_string(folder.join(Run::FILE)).unwrap();
    assert_eq!(told, serde_json::from_str::<serde_json::Value>(&run).unwrap());
    let page = folder.join(report::FILE);
    let before = std::fs::read_to_string(&page).unwrap();
    std::fs::remove_file(&page).unwrap();
    let mut unrender = Command::new(env!("CARGO_BIN_EXE_unrender"));
    assert!(unrender.args(["report", "--quiet"]).arg(&folder).status().unwrap().success());
    assert_eq!(std::fs::read_to_string(&page).unwrap(), before);
    std::fs::remove_file(folder.join("report/groups.png")).unwrap();
    let error = report::page(&folder).unwrap_err().to_string();
    assert!(error.contains("groups.png"), "{error}");
    let mut unrender = Command::new(env!("CARGO_BIN_EXE_unrender"));
    let output = unrender.args(["report", "--quiet"]).args([&folder, &folder]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--out FILE.html"));
}

#[test]
fn the_pages_work_in_a_browser() {
    let folder = workplace();
    recovered::make(&folder.join("real"));
    make(&folder.join("few"), 9, (480, 320));
    make(&folder.join("many"), 60, (480, 320));
    let runs = ["few", "many"].map(|name| folder.join(name));
    let text = report::comparison(&runs).unwrap();
    std::fs::write(folder.join("comparison.html"), text).unwrap();
    let exhibit = |file: &str| Exhibit {
        file: file.to_owned(),
        title: "<i>Title</i>".to_owned(),
        caption: "The caption & more".to_owned(),
    };
    let exhibits = ["photo.png", "rerendered.png"].map(exhibit);
    let text =
        report::gallery("A gallery", "of two", &runs[0], Some(&exhibits), &exhibits).unwrap();
    std::fs::write(folder.join("gallery.html"), text).unwrap();
    let Some(scripts) = install() else { return };
    let mut node = Command::new("node");
    let output = node.arg(scripts.join("check.mjs")).arg(&folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    println!("{}", text(&output.stdout));
    if output.status.code() == Some(NO_BROWSER) {
        println!("skipped: {}", text(&output.stderr));
        return;
    }
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// Copies the scripts to where npm has installed what they need; none, saying so, if it cannot.
fn install() -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/report_browser");
    let scripts = workplace().join("scripts");
    std::fs::create_dir_all(&scripts).unwrap();
    for file in ["package.json", "package-lock.json", "browser.mjs", "check.mjs"] {
        std::fs::copy(source.join(file), scripts.join(file)).unwrap();
    }
    let installed = scripts.join("node_modules/.package-lock.json");
    if installed.exists() {
        return Some(scripts);
    }
    let mut npm = Command::new("npm");
    npm.args(["ci", "--no-audit", "--no-fund"]).current_dir(&scripts);
    match npm.output() {
        Ok(output) if output.status.success() => Some(scripts),
        Ok(output) => {
            println!("skipped: npm ci: {}", String::from_utf8_lossy(&output.stderr));
            None
        }
        Err(error) => {
            println!("skipped: npm cannot be run: {error}");
            None
        }
    }
}
