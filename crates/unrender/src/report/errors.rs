//! The pictures of the difference, each with its colour bar.

use super::number::{Shown, count, number};
use super::{Key, PhotographOf, RunFolder, embed};
use crate::Error;
use crate::run::{ErrorPicture, Unit};
use maud::{Markup, html};

/// The main picture of a photograph: the difference as a share of the photograph's mean; in older results the first one.
pub(super) fn main(source: &RunFolder<'_>, of: &PhotographOf<'_>) -> Result<Markup, Error> {
    let key = of.key.at("pictures").at("errors");
    match of.pictures.errors.first() {
        Some(error) => picture(source, &key.at(0), error, true),
        None => Ok(html! {}),
    }
}

/// The others, folded.
pub(super) fn others(source: &RunFolder<'_>, of: &PhotographOf<'_>) -> Result<Markup, Error> {
    let key = of.key.at("pictures").at("errors");
    let others = of.pictures.errors.iter().enumerate().skip(1);
    let others = others
        .map(|(index, error)| Ok((name(error), picture(source, &key.at(index), error, false)?)));
    let others = others.collect::<Result<Vec<_>, Error>>()?;
    Ok(html! {
        @for (name, picture) in &others {
            details { summary { (name) } div class="half" { (picture) } }
        }
    })
}

fn name(error: &ErrorPicture) -> &'static str {
    match (error.signed, error.unit) {
        (true, Unit::Share) => "The difference in percent of the photograph's mean",
        (false, Unit::Share) => "The absolute difference in percent of the photograph's mean",
        (true, Unit::Radiance) => "The difference in radiance",
        (false, Unit::Radiance) => "The absolute difference in radiance",
        (true, Unit::Noise) => "The difference in standard deviations of the noise",
        (false, Unit::Noise) => "The absolute difference in standard deviations of the noise",
    }
}

/// An error picture with its colour bar; one in the viewer can be zoomed.
fn picture(
    source: &RunFolder<'_>,
    key: &Key,
    error: &ErrorPicture,
    zooms: bool,
) -> Result<Markup, Error> {
    let picture = match zooms {
        true => embed::exact(source.folder, &error.file)?,
        false => embed::photograph(source.folder, &error.file)?,
    };
    let alt = name(error);
    let diverges = (error.signed && error.unit != Unit::Radiance).then_some("map-of-difference");
    let image = html! { img class=[diverges] src=(picture.src) width=(picture.width) height=(picture.height) alt=(alt); };
    let what = "Difference map: arrow keys move the view, plus and minus zoom";
    Ok(html! {
        @if zooms {
            div class="frame error" style=(picture.aspect()) tabindex="0" role="group" aria-label=(what) {
                div class="layer" { (image) }
                span class="tag left" aria-hidden="true" { "difference" }
            }
        } @else {
            div class="frame" style=(picture.aspect()) { (image) }
        }
        (bar(key, error))
        figcaption {
            "Re-rendering minus photograph in luminance, " (unit(error.unit)) ", averaged over about "
            (count(&key.at("reach"), error.reach)) @if error.reach == 1 { " pixel. " } @else { " pixels. " }
            @if error.unit != Unit::Radiance {
                "Blank: within two standard deviations of the noise; colours fade in up to four. Hatched: not \
                 compared (beside an edge, clipped, or left out)."
            }
        }
    })
}

fn unit(unit: Unit) -> &'static str {
    match unit {
        Unit::Share => "in percent of the photograph's mean",
        Unit::Radiance => "in W sr⁻¹ m⁻²",
        Unit::Noise => "in standard deviations of the noise of both pictures",
    }
}

/// The colour bar: every other stop is labelled.
fn bar(key: &Key, error: &ErrorPicture) -> Markup {
    let colors: Vec<&str> = error.bar.iter().map(|stop| stop.color.as_str()).collect();
    let gradient = format!("background:linear-gradient(to right,{})", colors.join(","));
    let last = error.bar.len().saturating_sub(1);
    html! {
        div class="bar" role="group" aria-label={ "Colour bar, " (unit(error.unit)) } {
            div class={ "ramp" @if error.signed && error.unit != Unit::Radiance { " diverging" } } style=(gradient) {}
            div class="ticks" {
                @for (index, stop) in error.bar.iter().enumerate().step_by(2) {
                    @let key = key.at("bar").at(index).at("value");
                    span {
                        @match error.unit {
                            Unit::Share => { (number(&key, stop.value, Shown::Percent(0))) " %" }
                            _ => (number(&key, stop.value, Shown::Significant(2))),
                        }
                        @if index == 0 && error.signed { " or less" }
                        @if index == last { " or more" }
                    }
                }
            }
            @if error.signed {
                div class="ends" { span { "re-rendering too dark" } span { "too bright" } }
            }
        }
    }
}
