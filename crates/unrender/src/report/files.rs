//! Links to the files of the result, which lie beside the page.

use super::RunFolder;
use crate::result_folder::MATERIALS;
use crate::run::{Pictures, Run};
use maud::{Markup, html};

/// The page of `unrender view` in a folder of results.
pub(crate) const VIEW: &str = "view.html";

/// The list of links.
pub(super) fn links(source: &RunFolder<'_>) -> Markup {
    let run = source.run;
    let mut files = vec![MATERIALS.to_owned(), "scene.glb".to_owned(), Run::FILE.to_owned()];
    if run.photographs.is_empty() {
        files.extend(of_photograph(&run.pictures));
    }
    files.extend(run.photographs.iter().flat_map(|of| of_photograph(&of.pictures)));
    files.extend(run.groups.values().filter_map(|group| group.entry.texture.clone()));
    html! {
        nav class="files" aria-label="Files of the result" {
            "Files: "
            ul { @for file in &files { li { a href=(address(file)) { (file) } } } }
        }
        p class="files" {
            @if source.folder.join(VIEW).is_file() {
                a href=(VIEW) { "Play with its light and colours" }
            } @else {
                "Play with its light and colours: " code { "unrender view FOLDER" }
            }
        }
    }
}

/// The pictures of a photograph.
fn of_photograph(pictures: &Pictures) -> [String; 3] {
    let stem = pictures.rerendered.trim_end_matches(".png");
    let number = stem.trim_start_matches("rerendered");
    [format!("{stem}.exr"), pictures.rerendered.clone(), format!("error{number}.png")]
}

/// A file's name as a relative address.
fn address(file: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_./".contains(&byte);
    let coded =
        |byte: u8| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    file.bytes().map(coded).collect()
}
