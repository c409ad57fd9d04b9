//! Numbers on a page: rounded for people, with the exact value and its place in run.json beside it.
//!
//! `<data value="0.0348217" data-key="/groups/floor/error" data-scale="100">3.48</data>`: the text is
//! `scale` times the value, rounded; `data-key` is a JSON pointer [RFC 6901] into run.json, on a page
//! of several runs after the run's index.

use maud::{Markup, html};
use std::fmt::Display;

/// A JSON pointer into run.json.
#[derive(Clone, Debug)]
pub(super) struct Key(String);

impl Key {
    /// The whole file.
    pub(super) fn root() -> Self {
        Self(String::new())
    }

    /// The entry `part` at this key.
    pub(super) fn at(&self, part: impl Display) -> Self {
        let part = part.to_string().replace('~', "~0").replace('/', "~1");
        Self(format!("{}/{part}", self.0))
    }
}

/// How a number is shown.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shown {
    /// With this many digits after the point.
    Fixed(usize),
    /// In percent, with this many digits after the point.
    Percent(usize),
    /// With this many significant digits.
    Significant(usize),
    /// With the other sign and this many significant digits: a gain, of a difference that is negative.
    Gain(usize),
    /// In percent with one digit after the point; less than the last digit as `< 0.1`.
    Share,
    /// In percent with its sign and one digit after the point.
    Signed,
    /// As a count of 2^20.
    Mebi,
}

/// A value that a page can show.
pub(super) trait Value: Display + Copy {
    /// The value in double precision.
    fn double(self) -> f64;
}

impl Value for f32 {
    fn double(self) -> f64 {
        f64::from(self)
    }
}

impl Value for f64 {
    fn double(self) -> f64 {
        self
    }
}

impl Value for u32 {
    fn double(self) -> f64 {
        f64::from(self)
    }
}

impl Value for u64 {
    fn double(self) -> f64 {
        self as f64
    }
}

impl Value for usize {
    fn double(self) -> f64 {
        self as f64
    }
}

/// The number at `key`.
pub(super) fn number(key: &Key, value: impl Value, shown: Shown) -> Markup {
    let scale = shown.scale();
    html! { data value=(value) data-key=(key.0) data-scale=(scale) { (shown.text(value.double())) } }
}

/// A whole number.
pub(super) fn count(key: &Key, value: impl Value) -> Markup {
    number(key, value, Shown::Fixed(0))
}

/// The numbers of the array at `key`, with spaces between them.
pub(super) fn numbers(key: &Key, values: &[f32], shown: Shown) -> Markup {
    html! {
        span class="whole" { @for (index, value) in values.iter().enumerate() {
            @if index > 0 { " " }
            (number(&key.at(index), *value, shown))
        } }
    }
}

/// The relative error at `key` in percent, or a dash.
pub(super) fn percent(key: &Key, value: Option<f64>) -> Markup {
    match value {
        Some(value) => html! {
            span class="whole" { (number(key, value, Shown::Percent(2))) " %" }
        },
        None => html! { span aria-label="none" { "–" } },
    }
}

impl Shown {
    fn scale(self) -> f64 {
        match self {
            Self::Fixed(_) | Self::Significant(_) => 1.0,
            Self::Gain(_) => -1.0,
            Self::Percent(_) | Self::Share | Self::Signed => 100.0,
            Self::Mebi => 1.0 / f64::from(1 << 20),
        }
    }

    fn text(self, value: f64) -> String {
        let value = value * self.scale();
        match self {
            Self::Fixed(digits) | Self::Percent(digits) => format!("{value:.digits$}"),
            Self::Significant(digits) | Self::Gain(digits) => significant(value, digits),
            Self::Share if value > 0.0 && value < 0.05 => "< 0.1".to_owned(),
            Self::Share => format!("{value:.1}"),
            Self::Signed => format!("{value:+.1}"),
            Self::Mebi => format!("{value:.0}"),
        }
    }
}

/// `value` with `digits` significant digits; tiny and huge ones with a power of ten.
fn significant(value: f64, digits: usize) -> String {
    let tens = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    if !(-5.0..6.0).contains(&tens) {
        return format!("{value:.*e}", digits - 1);
    }
    let after_point = (digits as f64 - 1.0 - tens).max(0.0) as usize;
    format!("{value:.after_point$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_and_keep_their_value_and_place() {
        let key = Key::root().at("groups").at("a/b~c").at(0);
        let text = number(&key, 0.034_821_7_f32, Shown::Percent(2)).into_string();
        assert_eq!(
            text,
            r#"<data value="0.0348217" data-key="/groups/a~1b~0c/0" data-scale="100">3.48</data>"#
        );
    }

    #[test]
    fn significant_digits_hold_for_small_and_large() {
        let text = [0.000_123_4, 12.34, 0.0, 1.5e-9, 4.26e7].map(|v| significant(v, 2));
        assert_eq!(text, ["0.00012", "12", "0.0", "1.5e-9", "4.3e7"]);
    }

    #[test]
    fn shares_that_round_to_nothing_are_said_to_be_small() {
        let text = [0.0, 0.0004, 0.0012, 0.943].map(|v| Shown::Share.text(v));
        assert_eq!(text, ["0.0", "< 0.1", "0.1", "94.3"]);
        assert_eq!(Shown::Gain(3).text(-120.5), "120");
    }
}
