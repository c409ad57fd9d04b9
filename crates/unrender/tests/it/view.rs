//! `unrender view`: one page, the same bits with any number of threads, to which the report leads; and what is refused.

use crate::kit::folder::{Folder, is_refused, succeeds};
use crate::kit::recovered;

#[test]
fn a_result_becomes_one_page_that_loads_nothing() {
    let folder = &Folder::new();
    recovered::make(&folder.path("out"));
    succeeds(&folder.run(&["view", "out", "--no-open", "--spp", "8", "--quiet"]));
    let first = folder.text("out/view.html");
    for foreign in ["http:", "https:", "src=\"/", "fetch(", "import("] {
        assert!(!first.contains(foreign), "{foreign}");
    }
    assert!(first.contains("default-src 'none'"));
    // Names of groups are escaped, and so are the data of the script.
    assert!(first.contains("wall &amp; co") && !first.contains("</script>\""));
    assert!(folder.text("out/report.html").contains("href=\"view.html\""));

    // The folder is whole, and the page does not depend on the number of threads.
    succeeds(&folder.run(&["report", "out", "--quiet"]));
    let words = ["view", "out", "--no-open", "--spp", "8", "--quiet", "--threads", "1"];
    succeeds(&folder.run(&[&words[..], &["--out", "again.html"]].concat()));
    assert!(first == folder.text("again.html"), "another page with one thread");

    // Without its project, the scene and the photograph of the result are taken.
    std::fs::rename(folder.path("out.inputs"), folder.path("moved")).unwrap();
    succeeds(&folder.run(&[&words[..], &["--out", "alone.html"]].concat()));
    assert!(!folder.text("alone.html").contains("--project"));
}

#[test]
fn what_is_no_result_is_refused() {
    let folder = &Folder::new();
    std::fs::create_dir(folder.path("empty")).unwrap();
    is_refused(&folder.run(&["view", "empty", "--no-open"]), "run.json");
    is_refused(&folder.run(&["view", "missing", "--no-open"]), "missing");
    is_refused(&folder.run(&["view", "empty", "--no-open", "--out", "page.png"]), ".html");
    assert!(!folder.path("page.png").exists() && !folder.path("empty/view.html").exists());
}
