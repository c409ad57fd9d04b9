//! The cell of a group's numbers in Blender, each with a button that copies it.

use super::Key;
use super::number::{Shown, number};
use crate::run::RunGroup;
use maud::{Markup, html};

/// The cell.
pub(super) fn cell(key: &Key, name: &str, group: &RunGroup) -> Markup {
    let Some(artist) = &group.artist else { return html! { span aria-label="none" { "–" } } };
    let key = key.at("artist");
    let is_textured = group.entry.texture.is_some();
    let base = if is_textured { "Base Color (mean)" } else { "Base Color" };
    let roughness = html! { (number(&key.at("roughness"), artist.roughness, Shown::Fixed(3))) };
    html! {
        ul class="artist" {
            (hex(base, name, &artist.base_color))
            li { span class="name" { "Roughness" } " " (roughness)
                (copy(&format!("{:.3}", artist.roughness), &format!("Roughness of {name}"))) }
            @if artist.metallic { li { span class="name" { "Metallic" } } }
            @if let Some(ior) = artist.ior {
                li { span class="name" { "IOR" } " " (number(&key.at("ior"), ior, Shown::Fixed(3))) }
            }
            @if artist.glossy { li { span class="share" { "with a Glossy BSDF for the shine" } } }
            @if artist.color != artist.base_color { (hex("Shine", name, &artist.color)) }
        }
    }
}

/// A colour with its swatch.
fn hex(what: &str, name: &str, color: &str) -> Markup {
    html! {
        li {
            span class="name" { (what) } " "
            span class="whole" {
                span class="swatch" aria-hidden="true" style={ "background:" (color) } {}
                code { (color) }
            }
            (copy(color, &format!("{what} of {name}")))
        }
    }
}

fn copy(text: &str, what: &str) -> Markup {
    html! {
        " " button type="button" class="copy" data-copy=(text) aria-label={ "Copy the " (what) } { "Copy" }
    }
}
