//! The parameters of a group in one cell: their names, values and standard deviations.

use super::Key;
use super::number::{Shown, number, numbers};
use maud::{Markup, html};
use unrender_formats::materials::{GroupEntry, StdEntry};
use unrender_scene::Hypothesis;
use unrender_scene::color::srgb_from_linear;

const RHO: Shown = Shown::Fixed(3);
const RHO_STD: Shown = Shown::Significant(2);
const ALPHA: Shown = Shown::Fixed(4);
const DEGREES: Shown = Shown::Fixed(2);
/// A reflectance this close to zero is at its bound, and its standard deviation says nothing: the least that a
/// photograph of 16 bits tells from black is ten times as much. Half and double of it name the same numbers.
const AT_BOUND: f32 = 1e-6;
/// The channels in words.
const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// The parameters that the group's hypothesis has, each with its standard deviation.
pub(super) fn list(key: &Key, entry: &GroupEntry) -> Markup {
    let hypothesis = entry.hypothesis.unwrap_or(Hypothesis::Diffuse);
    let std = entry.std.unwrap_or_default();
    let lobe = entry.alpha_x.is_some_and(|alpha| alpha > 0.0);
    let brushed = hypothesis == Hypothesis::Anisotropic;
    let specular = entry.rho_s.filter(|rho| rho.iter().any(|v| *v > 0.0));
    html! {
        ul class="parameters" {
            @if let Some(rho) = entry.rho_d { (color("rho_d", key, rho, std.rho_d)) }
            @if let Some(rho) = specular { (color("rho_s", key, rho, std.rho_s)) }
            @if lobe { (alphas(key, entry, &std, brushed)) }
            @if brushed {
                @if let Some(theta) = entry.theta_deg {
                    li { span class="name" { "theta" } " "
                        (number(&key.at("theta_deg"), theta, DEGREES)) "°"
                        (deviation(&key.at("std").at("theta_deg"), std.theta_deg)) }
                }
            }
        }
    }
}

/// The colour of a reflectance as it looks on a screen; screen readers skip it.
pub(super) fn swatch(rho: [f32; 3]) -> Markup {
    let [r, g, b] = rho.map(|v| (255.0 * srgb_from_linear(v)).round() as u8);
    html! { span class="swatch" aria-hidden="true" style={
    "background:rgb(" (r) " " (g) " " (b) ")" } {} }
}

fn color(name: &str, key: &Key, rho: [f32; 3], std: Option<[f32; 3]>) -> Markup {
    html! {
        li { (swatch(rho)) span class="name" { (name) } " " (numbers(&key.at(name), &rho, RHO))
            @if let Some(std) = std { (deviations(&key.at("std").at(name), rho, std)) }
        }
    }
}

/// The standard deviations of the channels that are not at their bound, and which are.
fn deviations(key: &Key, rho: [f32; 3], std: [f32; 3]) -> Markup {
    let (bound, free): (Vec<usize>, Vec<usize>) = (0..3).partition(|c| rho[*c] < AT_BOUND);
    let named: Vec<&str> = bound.iter().map(|channel| CHANNELS[*channel]).collect();
    html! {
        span class="std" {
            @if !free.is_empty() {
                " ± " span class="whole" { @for (index, channel) in free.iter().enumerate() {
                    @if index > 0 { " " }
                    (number(&key.at(channel), std[*channel], RHO_STD))
                } }
            }
            @if !bound.is_empty() { " (" (named.join(", ")) " at its bound)" }
        }
    }
}

fn alphas(key: &Key, entry: &GroupEntry, std: &StdEntry, brushed: bool) -> Markup {
    let one = |name: &str, shown: &str, value: Option<f32>, std: Option<f32>| {
        html! {
            @if let Some(value) = value {
                li { span class="name" { (shown) } " " (number(&key.at(name), value, ALPHA))
                    (deviation(&key.at("std").at(name), std)) }
            }
        }
    };
    html! {
        (one("alpha_x", if brushed { "alpha_x" } else { "alpha" }, entry.alpha_x, std.alpha_x))
        @if brushed { (one("alpha_y", "alpha_y", entry.alpha_y, std.alpha_y)) }
    }
}

fn deviation(key: &Key, std: Option<f32>) -> Markup {
    html! {
        @if let Some(std) = std {
            span class="std" { " ± " (number(key, std, RHO_STD)) }
        }
    }
}
