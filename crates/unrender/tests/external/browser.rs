//! The pages in headless Chromium: they load completely and offline, respond to pointer and keys,
//! work with many groups, failed ones and names full of markup, and show the values of run.json.
//!
//! The steps in the browser are in `check.mjs`. Node.js drives it with puppeteer; the browser is
//! Chromium or Chrome if one is installed, or else one from npm.

use crate::kit::folder::{command, succeeds};
use crate::kit::pages::make;
use crate::kit::programs::{installed, need};
use crate::kit::recovered;
use std::path::{Path, PathBuf};
use std::process::Command;
use unrender::formats::picture;
use unrender::report::{self, Exhibit, Gallery};

/// The exit code of check.mjs if there is no browser.
const NO_BROWSER: i32 = 77;

#[test]
#[ignore = "slow: needs a browser, which .ci/programs installs"]
fn the_pages_work_in_a_browser() {
    let Some(scripts) = need(scripts()) else { return };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("external");
    std::fs::create_dir_all(&folder).unwrap();
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
    let gallery = Gallery {
        title: "A gallery",
        lead: "of two",
        edits: &["Removed <b>sofa</b>.".to_owned()],
        pair: Some(&exhibits),
        exhibits: &exhibits,
    };
    let text = report::gallery(&runs[0], &gallery).unwrap();
    std::fs::write(folder.join("gallery.html"), text).unwrap();
    make_view(&folder);
    let output = Command::new("node").arg(scripts.join("check.mjs")).arg(&folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    println!("{}", text(&output.stdout));
    if output.status.code() == Some(NO_BROWSER) {
        need::<()>(Err(text(&output.stderr)));
        return;
    }
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// The page of `unrender view` of the real recovery, and what its sliders should show, rendered by `unrender restage`:
/// `exact.json` has the radiance of each pixel.
fn make_view(folder: &Path) {
    let unrender = |words: &[&str]| {
        let output = command(words).current_dir(folder).output().unwrap();
        succeeds(&output);
    };
    unrender(&["view", "real", "--no-open", "--spp", "512", "--quiet"]);
    let lamp = ["--light", "lamp: scale = [0.3, 0.2, 0.1]"];
    let both = [&lamp[..], &["--repaint", "wall & co: rho_d = [0.7, 0.2, 0.05]"]].concat();
    let exact = [("lamp", &lamp[..]), ("both", &both)].map(|(name, edits)| {
        let words = ["restage", "--recovered", "real", "--spp", "1024", "--quiet", "--out", name];
        let size = ["--width", "48", "--height", "48"];
        unrender(&[&words[..], &size, edits].concat());
        let (picture, _) = picture::read(&folder.join(name).join("synthetic.exr")).unwrap();
        let pixels: Vec<[f32; 3]> =
            picture.to_linear().pixels().iter().map(|pixel| pixel.to_array()).collect();
        (name.to_owned(), serde_json::json!(pixels))
    });
    let exact = serde_json::Value::Object(exact.into_iter().collect());
    std::fs::write(folder.join("exact.json"), exact.to_string()).unwrap();
}

/// The scripts as they are now, beside what npm has installed for them.
fn scripts() -> Result<PathBuf, String> {
    let folder = installed("report-browser")?;
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/external/report_browser");
    for file in ["browser.mjs", "check.mjs"] {
        std::fs::copy(source.join(file), folder.join(file)).map_err(|error| error.to_string())?;
    }
    Ok(folder)
}
