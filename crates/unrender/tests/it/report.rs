//! The pages and the file from which they are made. Their tests in a browser are in `external`.

use crate::kit::pages::make;
use crate::kit::recovered;
use std::path::{Path, PathBuf};
use std::process::Command;
use unrender::report;
use unrender::run::Run;

/// The folder in which the pages are made.
fn workplace() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report_browser");
    std::fs::create_dir_all(&folder).unwrap();
    folder
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
    let folder = workplace().join("large");
    make(&folder, 60, (1600, 1200));
    let bytes = std::fs::metadata(folder.join(report::FILE)).unwrap().len();
    assert!(bytes < 5_000_000, "{bytes} bytes");
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
