//! The page of `unrender view`: the picture of a result whose lamps are dimmed and whose groups are recoloured by sliders.
//!
//! Its data are [`crate::playable`]; `play.js` multiplies and adds them up.

use super::files::VIEW;
use super::number::Key;
use super::{RunFolder, groups, head, parameters, why};
use crate::Error;
use crate::playable::{self, Code, Coded, Colour, ColourOf, Curve, Errors, NO_GROUP, Play};
use crate::shell_word::quoted;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use std::path::Path;
use unrender_formats::materials::{Status, StatusEntry};
use unrender_scene::Rgb;

const SCRIPT: &str = include_str!("play.js");
const STYLE: &str = include_str!("play.css");

/// Radiances, from the brightest lamp to a millionth of the walls: steps of 0.5 %. With half the bits gradients have
/// bands, with double of them the page is twice as large.
const RADIANCE: Code = Code { bits: 12, curve: Curve::Logarithm { octaves: 28.0 } };
/// Shares of lamps: steps of 0.6 %, down to what a lamp shows when all others are off and the exposure is raised.
const SHARE: Code = Code { bits: 11, curve: Curve::Logarithm { octaves: 18.0 } };
/// Changes by colours: steps of 0.8 % where a group shows its own colour, and finer ones elsewhere. With half the bits walls
/// have bands, with double of them the page is twice as large.
const CHANGE: Code = Code { bits: 8, curve: Curve::Root };

/// The words of the command that renders the page's picture exactly, before those of the sliders.
#[derive(Clone, Debug)]
pub(crate) struct ExactCommand(String);

impl ExactCommand {
    /// For the results in `folder` of `play`; without a project nothing else states the photograph's size.
    pub(crate) fn of(folder: &Path, play: &Play) -> Self {
        let word = |path: &Path| quoted(&path.to_string_lossy());
        let input = &play.run.input;
        let size = || format!(" --width {} --height {}", input.width, input.height);
        let project = play.project.as_ref();
        let of_photograph =
            project.map_or_else(size, |project| format!(" --project {}", word(project)));
        Self(format!("unrender restage --recovered {}{}", word(folder), of_photograph))
    }
}

/// What the script reads.
#[derive(Serialize)]
struct Data {
    width: usize,
    height: usize,
    exposure: [f32; 3],
    whole: Packed,
    photograph: Packed,
    map: String,
    no_group: u16,
    names: Vec<String>,
    lamps: Vec<LampData>,
    colours: Vec<ColourData>,
    command: String,
}

#[derive(Serialize)]
struct LampData {
    name: String,
    on: bool,
    share: Packed,
}

#[derive(Serialize)]
struct ColourData {
    /// The number of the group in `names`.
    group: usize,
    /// The key of the edit that makes the colour.
    key: &'static str,
    now: [f32; 3],
    response: Packed,
    errors: ErrorData,
}

#[derive(Serialize)]
struct ErrorData {
    first_order: [Vec<(f32, f64)>; 3],
    lamps: Vec<f64>,
}

/// A picture in the page: the number of its element, and how it is coded.
#[derive(Serialize)]
struct Packed {
    id: usize,
    bits: u32,
    /// None if codes are linear in the root.
    octaves: Option<f32>,
    max: f32,
}

/// The packed pictures of a page, one element each.
#[derive(Default)]
struct Store(Vec<String>);

impl Store {
    fn bytes(&mut self, bytes: &[u8]) -> usize {
        self.0.push(BASE64_STANDARD.encode(bytes));
        self.0.len() - 1
    }

    fn picture(&mut self, picture: &unrender_scene::RgbImage, code: Code) -> Packed {
        let Coded { code, max, bytes } = playable::coded(picture, code);
        let octaves = match code.curve {
            Curve::Logarithm { octaves } => Some(octaves),
            Curve::Root => None,
        };
        Packed { id: self.bytes(&bytes), bits: code.bits, octaves, max }
    }
}

/// The page of the results in `folder`.
///
/// # Errors
/// If its data cannot be written as JSON.
pub(crate) fn page(folder: &Path, play: &Play, command: &ExactCommand) -> Result<String, Error> {
    let mut store = Store::default();
    let data = data(play, command, &mut store);
    let json = serde_json::to_string(&data)
        .map_err(|error| Error::Request(format!("{VIEW} cannot be written: {error}")))?;
    let source = RunFolder { run: &play.run, folder, key: Key::root() };
    let body = html! {
        header {
            h1 { "Light and colours" }
            p class="lead" { (play.run.input.project.display()) ", " (play.run.input.photo.display()) }
        }
        main class="play" {
            div class="stage" {
                (tools()) (frame(play)) (probe())
                section class="chosen" id="chosen" aria-live="polite" aria-label="The chosen group" {
                    p { "Click on the picture to choose a group: what it is, and why." }
                }
                (exactness(play))
            }
            div class="controls" {
                (lamps(play))
                (colours(play))
                section aria-labelledby="h-exact" {
                    h2 id="h-exact" { "Rendered exactly" }
                    p class="errors" id="errors" aria-live="polite" {}
                    pre { code id="command" {} }
                    button type="button" id="copy" { "Copy the command" }
                }
            }
            (details(&source))
        }
        script type="application/json" id="play" { (PreEscaped(json.replace('<', "\\u003c"))) }
        @for (id, text) in store.0.iter().enumerate() {
            script type="text/plain" id={ "p" (id) } { (PreEscaped(text)) }
        }
    };
    let title = format!("unrender: {}", play.run.input.project.display());
    Ok(head::page_with(&title, &body, STYLE, SCRIPT))
}

/// The data of the script; the pictures go to `store`.
fn data(play: &Play, command: &ExactCommand, store: &mut Store) -> Data {
    let names: Vec<String> = play.run.groups.keys().cloned().collect();
    let number = |group: usize| names.iter().position(|name| *name == play.groups[group]);
    let codes: Vec<u8> = play.map.pixels().iter().flat_map(|group| group.to_le_bytes()).collect();
    let colour = |(colour, errors): (&Colour, &Errors)| {
        Some(ColourData {
            group: number(colour.own.group)?,
            key: key(colour.own.of),
            now: colour.own.now.to_array(),
            response: store.picture(&colour.response, CHANGE),
            errors: ErrorData {
                first_order: errors.first_order.clone(),
                lamps: errors.lamps.clone(),
            },
        })
    };
    let colours = play.colours.iter().zip(&play.errors).filter_map(colour).collect();
    let lamps = play.lamps.iter().map(|lamp| LampData {
        name: lamp.name.clone(),
        on: lamp.is_on,
        share: store.picture(&lamp.share, SHARE),
    });
    let lamps = lamps.collect();
    Data {
        width: play.whole.width(),
        height: play.whole.height(),
        exposure: play.exposure.to_array(),
        whole: store.picture(&play.whole, RADIANCE),
        photograph: store.picture(&play.photograph.map(|rgb| rgb.max(Rgb::ZERO)), RADIANCE),
        map: format!("p{}", store.bytes(&playable::packed(&codes))),
        no_group: NO_GROUP,
        names,
        lamps,
        colours,
        command: command.0.clone(),
    }
}

/// The key of `[[repaint]]` that makes a colour.
fn key(of: ColourOf) -> &'static str {
    match of {
        ColourOf::Diffuse => "rho_d",
        ColourOf::Specular => "rho_s",
        ColourOf::Texture => "tint",
    }
}

/// What is shown, exposure and zoom.
fn tools() -> Markup {
    html! {
        div class="tools" role="group" aria-label="View of the picture" {
            span class="tool" role="radiogroup" aria-label="What is lit anew" {
                label { input type="radio" name="base" value="whole" checked; " re-rendering" }
                label { input type="radio" name="base" value="photograph"; " photograph" }
            }
            label class="tool" { "Exposure "
                input id="exposure" type="range" min="-4" max="6" step="0.25" value="0";
                output id="stops" {}
            }
            span class="tool" {
                button type="button" id="zoom-out" aria-label="Zoom out" { "−" }
                output id="zoom" aria-label="Zoom" {}
                button type="button" id="zoom-in" aria-label="Zoom in" { "+" }
                button type="button" id="zoom-fit" { "Fit" }
            }
            button type="button" id="as-it-was" { "All as it was" }
        }
    }
}

/// The picture, left of a divider the photograph as it is.
fn frame(play: &Play) -> Markup {
    let shape = format!(
        "--width:{}px;--aspect:{}",
        play.whole.width(),
        play.whole.width() as f64 / play.whole.height().max(1) as f64
    );
    html! {
        div class="view" {
            div class="canvas" id="frame" style=(shape) {
                canvas id="picture" tabindex="0" role="img" width=(play.whole.width()) height=(play.whole.height())
                    aria-label="The picture under the lamps and colours of the sliders" {}
                canvas id="shade" width=(play.whole.width()) height=(play.whole.height()) aria-hidden="true" {}
            }
        }
        label class="tool divide" { "Photograph as it is, from the left "
            input id="divider" type="range" min="0" max="100" step="0.5" value="0";
        }
        noscript { p class="warn" { "This page needs its own script to show the picture; it loads nothing." } }
    }
}

fn probe() -> Markup {
    html! { output class="probe" id="probe" aria-live="off" { "Point at the picture to read its values." } }
}

/// What is exact, in words.
fn exactness(play: &Play) -> Markup {
    let step = |code: Code| format!("{:.2} %", 100.0 * code.error());
    html! {
        p class="hint" {
            "Lamps are exact but for noise: the picture is the sum of their light. Colours count to first order, with all \
             light that they throw on other things; how far that is off stands beside the command. Values are stored \
             within " (step(RADIANCE)) ", shares of lamps within " (step(SHARE)) ", changes by colours within "
            (step(CHANGE)) " of the largest change. "
            @if play.side > 1 {
                "One pixel here is " (play.side) " x " (play.side) " of the photograph. "
            }
            "With the photograph lit anew, its own pixels are multiplied by the change: its noise and its detail stay, \
             and what is black or clipped in it stays so."
        }
    }
}

fn lamps(play: &Play) -> Markup {
    html! {
        section aria-labelledby="h-lamps" {
            h2 id="h-lamps" { "Lamps" }
            @if play.lamps.is_empty() { p { "The scene has none." } }
            ul class="lamps" {
                @for (index, lamp) in play.lamps.iter().enumerate() {
                    li data-lamp=(index) {
                        span class="name" { (lamp.name) @if !lamp.is_on { " (off in the photograph)" } }
                        input type="color" value="#ffffff" aria-label={ "Colour of " (lamp.name) };
                        input type="range" min="0" max="2" step="0.01" value=(u8::from(lamp.is_on)) aria-label={ "Brightness of " (lamp.name) };
                        output { }
                        button type="button" class="only" aria-label={ "Only " (lamp.name) } { "only" }
                    }
                }
            }
        }
    }
}

fn colours(play: &Play) -> Markup {
    let number =
        |colour: &Colour| play.run.groups.get_index_of(play.groups[colour.own.group].as_str());
    html! {
        section aria-labelledby="h-colours" {
            h2 id="h-colours" { "Colours" }
            ul class="colours" {
                @for (index, colour) in play.colours.iter().filter(|c| number(c).is_some()).enumerate() {
                    @let name = &play.groups[colour.own.group];
                    li data-colour=(index) {
                        input type="color" aria-label={ "Colour of " (name) };
                        button type="button" class="pick" { (name) }
                        button type="button" class="back" hidden aria-label={ (name) " as it was" } { "↺" }
                    }
                }
            }
        }
    }
}

/// What is known of each group, shown when it is chosen.
fn details(source: &RunFolder<'_>) -> Markup {
    html! {
        @for (index, (name, group)) in source.run.groups.iter().enumerate() {
            @let key = source.key.at("groups").at(name);
            template id={ "group-" (index) } {
                h2 { (name) }
                p {
                    (group.entry.hypothesis.map_or("", |hypothesis| hypothesis.name()))
                    @if let Some(status) = &group.entry.status {
                        " " span class=(if groups::is(group, Status::Doubtful) { "status bad" } else { "status" }) {
                            @if status == &StatusEntry::Of(Status::Known) { "given" } @else { (status) }
                        }
                    }
                }
                (parameters::list(&key, &group.entry))
                p class="why" { (why::reason(source, name, group)) }
                @if let Some(note) = &group.entry.note { p class="note" { (note) } }
            }
        }
    }
}
