//! Why a group has its kind of material: what it was compared with and by how much it won, and what it still misses.

use super::number::{Shown, count, number, percent};
use super::{Key, RunFolder};
use crate::run::{DecisionEntry, MissEntry, RunGroup};
use maud::{Markup, html};
use unrender_formats::materials::{Hypothesis, Status, StatusEntry};

/// Misses on less than this share of a group's pixels are chance: noise alone exceeds two standard deviations on 5 %.
/// At half of it groups that match are said to miss; at double of it edges of a wrong highlight go unsaid.
const BY_CHANCE: f64 = 0.1;

/// The reason in words.
pub(super) fn reason(source: &RunFolder<'_>, name: &str, group: &RunGroup) -> Markup {
    let hypothesis = group.entry.hypothesis.unwrap_or(Hypothesis::Diffuse);
    let key = source.key.at("groups").at(name);
    let last = group.decisions.iter().rposition(|decision| decision.accepted);
    html! {
        @match (&group.entry.status, last) {
            (Some(StatusEntry::Ignored), _) => "Left out by the project; it keeps the scene's material.",
            (Some(StatusEntry::SameAs(other)), _) => { "One material with " (other) ", as the project states." }
            (Some(StatusEntry::Of(Status::Known)), _) => "Given by the project or the scene, not recovered.",
            (Some(StatusEntry::Of(Status::Assumed)), None) => "No valid pixel determines it; the values are a guess.",
            _ if source.run.settings.ladder == "paper" => "The paper's ladder stopped here: its error is below the \
                threshold, or nothing comes after it.",
            (_, Some(last)) => { (won(&key, group, hypothesis, last)) (rivals(&key, group, hypothesis, last + 1)) }
            (_, None) if group.decisions.is_empty() => (alone(&key, group, hypothesis)),
            (_, None) => (rivals(&key, group, hypothesis, 0)),
        }
    }
}

/// A group for which nothing was compared.
fn alone(key: &Key, group: &RunGroup, hypothesis: Hypothesis) -> Markup {
    html! {
        "Nothing was compared with " (hypothesis) ": it leaves "
        (percent(&key.at("error"), group.entry.error)) " on "
        (count(&key.at("counted").at("valid"), group.counted.valid)) " valid pixels."
    }
}

/// The change that the decision number `last` made, and the evidence for it.
fn won(key: &Key, group: &RunGroup, hypothesis: Hypothesis, last: usize) -> Markup {
    let made = &group.decisions[last];
    let key = key.at("decisions").at(last);
    let [from, to] = [made.from, made.to].map(|kind| word(kind, hypothesis));
    html! {
        // What is diffuse before a lobe is found may be Lambert's.
        @match made.to {
            Hypothesis::Diffuse => { (capital(to)) " instead of " (from) ": " }
            _ => { (capital(own_word(made.to, hypothesis))) " instead of " (made.from) ": " }
        }
        @match made.rule.as_str() {
            "light samples" if gain(made) < 0.0 => {
                "it needs fewer parameters, and fits hardly worse (loss "
                (number(&key.at("difference"), made.difference.unwrap_or(0.0), Shown::Significant(3)))
                @if let Some(price) = made.price {
                    ", price of the parameters that it saves "
                    (number(&key.at("price"), price, Shown::Gain(2)))
                }
                ")."
            }
            "light samples" => { "with the light sampled at its pixels, it fits better" (by(&key, made)) }
            "prediction" => { "texels from some of its pixels predict the others better" (by(&key, made)) }
            "simpler" => { "the additional parameters of " (made.from) " make no significant difference." }
            "project" => "the project allows no other.",
            _ => "the paper's rules chose it.",
        }
    }
}

/// How much better, in standard deviations, and what it had to gain.
fn by(key: &Key, of: &DecisionEntry) -> Markup {
    let price = of.price.filter(|price| *price > 0.0);
    html! {
        @if let Some(sigmas) = of.sigmas {
            " by " (number(&key.at("sigmas"), sigmas, Shown::Significant(2))) " standard deviations"
        }
        @if let (Some(difference), Some(price)) = (of.difference, price) {
            " (gain " (number(&key.at("difference"), difference, Shown::Gain(3))) ", price of its parameters "
            (number(&key.at("price"), price, Shown::Significant(2))) ")"
        }
        "."
    }
}

fn gain(of: &DecisionEntry) -> f64 {
    -of.difference.unwrap_or(0.0)
}

/// The kinds that were compared and not chosen from the decision number `start` on: the nearest of each sort.
fn rivals(key: &Key, group: &RunGroup, hypothesis: Hypothesis, start: usize) -> Markup {
    let is_texture = |of: &DecisionEntry| of.rule == "prediction";
    let lost = |texture: bool| {
        let all = group.decisions.iter().enumerate().skip(start);
        let lost = all.filter(|(_, of)| !of.accepted && of.difference.is_some());
        let lost = lost.filter(|(_, of)| of.to != hypothesis && is_texture(of) == texture);
        lost.max_by(|(_, a), (_, b)| gain(a).total_cmp(&gain(b)))
    };
    let (rival, texture) = (lost(false), lost(true));
    html! {
        @if start == 0 && rival.is_none() {
            (capital(hypothesis.name())) ": no uniform rival came near. "
        }
        @if let Some((index, of)) = rival {
            (nearest(&key.at("decisions").at(index), of, hypothesis, start == 0))
        }
        @if let Some((index, of)) = texture {
            @let key = key.at("decisions").at(index);
            " A texture " (compared(&key, of))
        }
    }
}

/// The nearest rival of the `chosen` hypothesis, which was kept from the start or not.
fn nearest(key: &Key, of: &DecisionEntry, chosen: Hypothesis, is_kept: bool) -> Markup {
    let rival = word(of.to, chosen);
    html! {
        @if is_kept {
            (capital(chosen.name())) ": the nearest rival, " (rival) ", "
        } @else {
            " After that, " (rival) " "
        }
        (compared(key, of))
    }
}

/// What a rival gained, and why that was not enough.
fn compared(key: &Key, of: &DecisionEntry) -> Markup {
    let price = of.price.unwrap_or(0.0);
    let gains = html! {
        (number(&key.at("difference"), of.difference.unwrap_or(0.0), Shown::Gain(2)))
        @if let Some(deviation) = of.deviation {
            " ± " (number(&key.at("deviation"), deviation, Shown::Significant(2)))
        }
    };
    html! {
        @if gain(of) <= 0.0 {
            "fits no better (gain " (gains) ")."
        } @else if gain(of) < price {
            "gains " (gains) ", less than the price of its parameters ("
            (number(&key.at("price"), price, Shown::Significant(2))) ")."
        } @else {
            "gains " (gains) ", which is not significant."
        }
    }
}

/// What a kind of material that was compared is called beside the `chosen` one: beside a plastic, what shows no lobe is one
/// without gloss.
fn word(kind: Hypothesis, chosen: Hypothesis) -> &'static str {
    match (kind, chosen) {
        (Hypothesis::Diffuse, Hypothesis::Plastic) => "plastic without gloss",
        (Hypothesis::Isotropic, Hypothesis::Plastic) => "plastic with gloss",
        (kind, chosen) => own_word(kind, chosen),
    }
}

/// The same where both are of one rung of the paper's ladder: a lobe is a plastic's or a metal's.
fn own_word(kind: Hypothesis, chosen: Hypothesis) -> &'static str {
    if kind.of_paper() == chosen.of_paper() { chosen.name() } else { kind.name() }
}

fn capital(name: &str) -> String {
    name[..1].to_uppercase() + &name[1..]
}

/// What the group still misses, and where; nothing where it matches.
pub(super) fn miss(key: &Key, name: &str, (miss, is_doubtful): (&MissEntry, bool)) -> Markup {
    if miss.too_bright + miss.too_dark < BY_CHANCE {
        let hidden = "Noise hides where it differs: the map shows no place.";
        return html! { @if is_doubtful { (hidden) } };
    }
    let share = |part: &str, value: f64| number(&key.at(part), value, Shown::Share);
    html! {
        "It is "
        @if miss.too_bright > 0.0 { "too bright on " (share("too_bright", miss.too_bright)) " %" }
        @if miss.too_bright > 0.0 && miss.too_dark > 0.0 { " and " }
        @if miss.too_dark > 0.0 { "too dark on " (share("too_dark", miss.too_dark)) " %" }
        " of its pixels; at most by "
        span class="whole" { (number(&key.at("largest"), miss.largest, Shown::Signed)) " %" }
        " of the photograph's mean, " (place(miss.place)) ". "
        button type="button" class="show" data-x=(miss.place[0]) data-y=(miss.place[1])
            data-viewer=(miss.photograph.saturating_sub(1)) aria-label={ "Show where " (name) " differs most" } { "Show" }
    }
}

/// A place in the picture in words, by thirds.
fn place([x, y]: [f64; 2]) -> &'static str {
    let third = |at: f64| ((3.0 * at) as usize).min(2);
    [
        ["at the upper left", "at the top", "at the upper right"],
        ["at the left", "in the middle", "at the right"],
        ["at the lower left", "at the bottom", "at the lower right"],
    ][third(y)][third(x)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::number::Key;

    fn decision(from: Hypothesis, to: Hypothesis, [difference, price]: [f64; 2]) -> DecisionEntry {
        DecisionEntry {
            iteration: 2,
            from,
            to,
            rule: "light samples".to_owned(),
            difference: Some(difference),
            deviation: Some(2.5),
            price: Some(price),
            sigmas: Some(-difference / 2.5),
            accepted: true,
        }
    }

    /// The text of a reason, without its markup.
    fn text(markup: Markup) -> String {
        let whole = markup.into_string();
        let parts = whole.split('<').map(|part| part.rsplit('>').next().unwrap_or(""));
        parts.collect()
    }

    #[test]
    fn a_simpler_hypothesis_that_fits_less_well_is_not_said_to_fit_better() {
        let chosen = Hypothesis::PartialMirror;
        let made = decision(Hypothesis::DiffuseSpecular, chosen, [11.6, -9.98]);
        let group = RunGroup { decisions: vec![made], ..RunGroup::default() };
        let told = text(won(&Key::root(), &group, chosen, 0));
        assert_eq!(
            told,
            "Partial-mirror instead of diffuse-specular: it needs fewer parameters, and fits hardly worse (loss 11.6, \
             price of the parameters that it saves 10.0)."
        );
    }

    #[test]
    fn a_plastic_is_called_one_with_gloss_and_without() {
        let chosen = Hypothesis::Plastic;
        let made = decision(Hypothesis::Diffuse, Hypothesis::Isotropic, [-50.0, 4.0]);
        let group = RunGroup { decisions: vec![made.clone()], ..RunGroup::default() };
        let told = text(won(&Key::root(), &group, chosen, 0));
        assert!(told.starts_with("Plastic instead of diffuse: "), "{told}");
        assert!(told.contains("fits better by 20 standard deviations"), "{told}");
        let simpler = decision(Hypothesis::Isotropic, Hypothesis::Diffuse, [2.0, -4.0]);
        let group = RunGroup { decisions: vec![simpler], ..RunGroup::default() };
        let told = text(won(&Key::root(), &group, chosen, 0));
        assert!(
            told.starts_with("Plastic without gloss instead of plastic with gloss: "),
            "{told}"
        );
        let told = text(nearest(&Key::root(), &made, chosen, true));
        assert!(
            told.starts_with("Plastic: the nearest rival, plastic with gloss, gains"),
            "{told}"
        );
    }
}
