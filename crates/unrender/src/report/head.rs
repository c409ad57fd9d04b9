//! The page around its sections: style, script, and the policy that nothing is loaded from outside.

use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = concat!(include_str!("script.js"), include_str!("viewer.js"));
/// With this policy the browser fetches nothing, even if something in the page requested it.
const POLICY: &str = include_str!("policy.txt");

/// A whole page.
pub(super) fn page(title: &str, body: &Markup) -> String {
    page_with(title, body, "", SCRIPT)
}

/// A whole page with a `style` of its own beside the usual one, and a `script` of its own instead of it.
pub(super) fn page_with(title: &str, body: &Markup, style: &str, script: &str) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(style)) }
            }
            body {
                (body)
                script { (PreEscaped(script)) }
            }
        }
    };
    page.into_string()
}
