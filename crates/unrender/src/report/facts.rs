//! How the run was made: command, versions, time, memory, settings, warnings.

use super::number::{Shown, count, number, numbers};
use super::{Key, RunFolder, under};
use maud::{Markup, html};
use unrender_formats::materials::PhotographEntry;

/// The section.
pub(super) fn section(source: &RunFolder<'_>) -> Markup {
    let run = source.run;
    let content = html! {
        h3 id="warnings" { "Warnings" }
        @if run.warnings.is_empty() { p { "None." } }
        ul { @for (index, warning) in run.warnings.iter().enumerate() {
            li id={ "warning-" (index) } { (warning) }
        } }
        h3 { "End" }
        p { (run.termination) "." }
        h3 { "Command" }
        pre tabindex="0" { code { (command(&run.command)) } }
        div class="beside" {
            div { h3 { "Time and memory" } (costs(source)) }
            div { h3 { "Input" } (input(source)) }
            div { h3 { "Settings" } (settings(source)) }
        }
        @if run.photographs.is_empty() && let Some(photograph) = &run.photograph {
            h3 { "Camera" } (camera(&source.key.at("photograph"), photograph))
        }
        @for (k, of) in run.photographs.iter().enumerate() {
            @let key = source.key.at("photographs").at(k);
            h3 { "Camera of photograph " (k + 1) }
            table { tbody { (row("exposure", &html! {
                (numbers(&key.at("exposure"), &of.exposure, Shown::Significant(4)))
                @if let Some(std) = of.photograph.as_ref().and_then(|found| found.std.as_ref()?.exposure.as_ref()) {
                    " ± " (numbers(&key.at("photograph").at("std").at("exposure"), std, Shown::Significant(2)))
                }
            })) } }
            @if let Some(photograph) = &of.photograph { (camera(&key.at("photograph"), photograph)) }
        }
        @if !run.lights.is_empty() { h3 { "Lights" } (lights(source)) }
    };
    under("facts", &content)
}

/// The command line, quoted for a shell.
fn command(words: &[String]) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    let quoted = |word: &String| {
        if !word.is_empty() && word.chars().all(plain) {
            word.clone()
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

fn row(name: &str, value: &Markup) -> Markup {
    html! { tr { th scope="row" { (name) } td { (value) } } }
}

fn costs(source: &RunFolder<'_>) -> Markup {
    let (run, key) = (source.run, &source.key);
    let stages = [
        ("registration", run.stages.registration),
        ("camera", run.stages.camera),
        ("ladder", run.stages.ladder),
        ("refinement", run.stages.refinement),
        ("picture", run.stages.picture),
    ];
    let seconds = |key, value| html! { (number(&key, value, Shown::Fixed(1))) " s" };
    html! {
        table { tbody {
            @for (name, value) in stages {
                (row(name, &seconds(key.at("stages").at(name), value)))
            }
            (row("together", &seconds(key.at("seconds"), run.seconds)))
            @if let Some(bytes) = run.peak_memory_bytes {
                (row("memory at most", &html! {
                    (number(&key.at("peak_memory_bytes"), bytes, Shown::Mebi)) " MiB" }))
            }
            (row("threads", &count(&key.at("settings").at("threads"), run.settings.threads)))
            (row("program", &html! { "unrender " (run.program.unrender) ", "
                (run.program.system) ", " (run.program.processor) }))
        } }
    }
}

fn input(source: &RunFolder<'_>) -> Markup {
    let (run, key) = (source.run, source.key.at("input"));
    html! {
        table { tbody {
            (row("project", &html! { (run.input.project.display()) }))
            (row("scene", &html! { (run.input.scene.display()) }))
            @for of in &run.photographs {
                (row("one of the photographs", &html! { (of.photo.display()) }))
            }
            @if run.input.bracket.is_empty() && run.photographs.is_empty() {
                (row("photograph", &html! { (run.input.photo.display()) }))
            }
            @for photo in &run.input.bracket {
                (row("photograph of a bracket", &html! { (photo.display()) }))
            }
            @if let Some(environment) = &run.input.environment {
                (row("environment", &html! { (environment) }))
            }
            (row("pixels", &html! { (count(&key.at("width"), run.input.width)) " × "
                (count(&key.at("height"), run.input.height))
                @if run.input.side > 1 {
                    ", worked on in squares of " (count(&key.at("side"), run.input.side)) " × "
                    (count(&key.at("side"), run.input.side))
                } }))
            (row("exposure", &html! {
                (numbers(&source.key.at("exposure"), &run.exposure, Shown::Significant(4)))
                @if let Some(std) = &run.exposure_std {
                    " ± " (numbers(&source.key.at("exposure_std"), std, Shown::Significant(2)))
                }
            }))
            @if let Some(off) = run.registration.displacement_pixels {
                (row("model off by", &html! {
                    (number(&source.key.at("registration").at("displacement_pixels"), off,
                        Shown::Fixed(2))) " pixels, as given" }))
            }
        } }
    }
}

fn settings(source: &RunFolder<'_>) -> Markup {
    let (settings, key) = (&source.run.settings, source.key.at("settings"));
    html! {
        table { tbody {
            (row("lobe", &html! { (settings.brdf) }))
            (row("ladder", &html! { (settings.ladder) }))
            (row("effort", &html! { (settings.effort) }))
            (row("refinement", &html! { @if settings.refine { "yes" } @else { "no" } }))
            (row("seed", &count(&key.at("seed"), settings.seed)))
            (row("samples per pixel of the last picture", &count(&key.at("spp"), settings.spp)))
            (row("bounces at most", &count(&key.at("max_bounces"), settings.max_bounces)))
            @for (name, value) in &settings.thresholds {
                (row(&format!("threshold {name}"),
                    &number(&key.at("thresholds").at(name), *value, Shown::Significant(2))))
            }
        } }
    }
}

/// The photometric parameters of the camera that were recovered.
fn camera(key: &Key, found: &PhotographEntry) -> Markup {
    let std = found.std.clone().unwrap_or_default();
    let one = |name: &str, value: Option<f64>, std: Option<f64>| {
        html! { @if let Some(value) = value {
            (row(name, &html! {
                (number(&key.at(name), value, Shown::Fixed(4)))
                @if let Some(std) = std {
                    " ± " (number(&key.at("std").at(name), std, Shown::Significant(2)))
                }
            }))
        } }
    };
    html! {
        table { tbody {
            (one("gamma", found.gamma, std.gamma))
            @if let Some(radial) = &found.vignetting {
                (row("vignetting", &html! { @for (index, value) in radial.iter().enumerate() {
                    (number(&key.at("vignetting").at(index), *value, Shown::Fixed(3))) " "
                } }))
            }
            (one("corner", found.corner, std.corner))
        } }
        @if let Some(note) = &found.note { p class="note" { (note) } }
    }
}

fn lights(source: &RunFolder<'_>) -> Markup {
    html! {
        table { tbody { @for (name, light) in &source.run.lights {
            (row(name, &html! {
                @let key = source.key.at("lights").at(name);
                @if let Some(intensity) = &light.intensity {
                    (numbers(&key.at("intensity"), intensity, Shown::Significant(4)))
                }
                @if let Some(std) = &light.std {
                    " ± " (numbers(&key.at("std"), std, Shown::Significant(2)))
                }
            }))
        } } }
    }
}
