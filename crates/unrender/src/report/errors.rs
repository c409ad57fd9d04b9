//! The error pictures, signed and absolute, in radiance and in units of the noise, each with its
//! colour bar.

use super::number::{Shown, count, number};
use super::{Key, PhotographOf, RunFolder, embed, of_each};
use crate::Error;
use crate::run::{ErrorPicture, Unit};
use maud::{Markup, html};

/// The section: one picture is seen at a time, chosen by radio buttons.
pub(super) fn section(source: &RunFolder<'_>) -> Result<Markup, Error> {
    of_each("errors", source, |k, of| pictures(source, k, of))
}

/// The pictures of the photograph `of`, which is number `k`.
fn pictures(source: &RunFolder<'_>, k: usize, of: &PhotographOf<'_>) -> Result<Markup, Error> {
    let errors = &of.pictures.errors;
    let key = of.key.at("pictures").at("errors");
    let group = if k == 0 { "error".to_owned() } else { format!("error-{}", k + 1) };
    let figures = errors.iter().enumerate().map(|(index, error)| {
        figure(source, &key.at(index), error).map(|figure| (index, error, figure))
    });
    let figures = figures.collect::<Result<Vec<_>, _>>()?;
    Ok(html! {
        div class="choice" {
            @for (index, error, _) in &figures {
                input type="radio" name=(group) id={ (group) "-" (index) } checked[*index == 0];
                label for={ (group) "-" (index) } { (name(error)) }
            }
            @for (_, _, figure) in &figures { (figure) }
        }
    })
}

fn name(error: &ErrorPicture) -> &'static str {
    match (error.signed, error.unit) {
        (true, Unit::Radiance) => "signed, radiance",
        (false, Unit::Radiance) => "absolute, radiance",
        (true, Unit::Noise) => "signed, noise",
        (false, Unit::Noise) => "absolute, noise",
    }
}

fn figure(source: &RunFolder<'_>, key: &Key, error: &ErrorPicture) -> Result<Markup, Error> {
    let picture = embed::photograph(source.folder, &error.file)?;
    let sides = if error.signed {
        "Re-rendering minus photograph: red where the re-rendering is too bright, blue where it is \
         too dark"
    } else {
        "The size of the difference: the lighter, the larger"
    };
    let unit = match error.unit {
        Unit::Radiance => "luminance, W sr⁻¹ m⁻²",
        Unit::Noise => "standard deviations of the noise of both pictures",
    };
    Ok(html! {
        figure class="error" {
            img src=(picture.src) width=(picture.width) height=(picture.height)
                alt={ (sides) ", in " (unit) };
            (bar(key, error, unit))
            figcaption {
                (sides) ". In " (unit) ", averaged over pixels up to "
                (count(&key.at("reach"), error.reach)) " away; dark grey is not compared."
            }
        }
    })
}

/// The colour bar: every other stop is labelled.
fn bar(key: &Key, error: &ErrorPicture, unit: &str) -> Markup {
    let colors: Vec<&str> = error.bar.iter().map(|stop| stop.color.as_str()).collect();
    let gradient = format!("background:linear-gradient(to right,{})", colors.join(","));
    html! {
        div class="bar" role="group" aria-label={ "Colour bar, " (unit) } {
            div class="ramp" style=(gradient) {}
            div class="ticks" {
                @for (index, stop) in error.bar.iter().enumerate().step_by(2) {
                    span { (number(&key.at("bar").at(index).at("value"), stop.value,
                        Shown::Significant(2))) }
                }
            }
        }
    }
}
