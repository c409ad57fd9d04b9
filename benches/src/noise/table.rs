//! The lines of the table, which is printed line by line.

use super::compare::{Compared, Quotients};
use super::measure::{GroupNoise, SceneNoise};
use super::statistics::Noise;

/// The row of all groups together.
const PICTURE: &str = "(picture)";
/// The width of the column of groups, characters: that of the longest name in the examples. Longer names shift
/// their row.
const GROUP_WIDTH: usize = 16;
/// The columns of numbers.
const HEAD: [&str; 8] =
    ["pixels", "mean", "rms %", "robust %", "ratio", "worst %", "s", "Mpaths/s"];
/// The columns of the comparison with an earlier run.
const COMPARED: [&str; 5] = ["mean x", "efficiency", "of groups", "of robust", "speed"];
/// The least width of a column of numbers, characters.
const NUMBER_WIDTH: usize = 7;

/// The table.
pub(super) struct Table {
    scene_width: usize,
    compares: bool,
}

impl Table {
    /// For scenes of these names; `compares` if there is an earlier run.
    pub(super) fn new<'a>(scenes: impl Iterator<Item = &'a str>, compares: bool) -> Self {
        let longest = scenes.map(|name| name.chars().count()).max().unwrap_or(0);
        Self { scene_width: longest.max("scene".len()), compares }
    }

    /// The headings.
    pub(super) fn head(&self) -> String {
        let compared = COMPARED.map(str::to_owned);
        self.line(["scene", "group"], HEAD.map(str::to_owned), compared)
    }

    /// The lines of a scene: one per group, and one of the whole picture.
    pub(super) fn lines(
        &self,
        scene: &str,
        noise: &SceneNoise,
        compared: Option<&Compared>,
    ) -> Vec<String> {
        let group = |(index, group): (usize, &GroupNoise)| {
            let compared = compared.and_then(|compared| compared.groups[index].as_ref());
            let numbers = numbers(&group.noise, [None, None]);
            self.line([scene, &group.name], numbers, of_group(compared))
        };
        let mut lines: Vec<String> = noise.groups.iter().enumerate().map(group).collect();
        let cost = [Some(noise.seconds), Some(noise.speed() / 1e6)];
        let numbers = numbers(&noise.picture, cost);
        lines.push(self.line([scene, PICTURE], numbers, of_picture(compared)));
        lines
    }

    fn line<const N: usize, const M: usize>(
        &self,
        [scene, group]: [&str; 2],
        numbers: [String; N],
        compared: [String; M],
    ) -> String {
        let width = self.scene_width;
        let mut line = format!("{scene:<width$}  {group:<GROUP_WIDTH$}");
        let heads = HEAD.iter().chain(&COMPARED);
        let cells = numbers.iter().chain(compared.iter().filter(|_| self.compares));
        for (head, cell) in heads.zip(cells) {
            let width = head.len().max(NUMBER_WIDTH);
            line.push_str(&format!("  {cell:>width$}"));
        }
        line.trim_end().to_owned()
    }
}

/// The cells of one set of pixels; groups have no time and speed, which are those of the picture.
fn numbers(noise: &Noise, [seconds, speed]: [Option<f64>; 2]) -> [String; HEAD.len()] {
    let percent = |share: f64, digits| number(Some(100.0 * share), digits);
    [
        noise.pixels.to_string(),
        number(Some(noise.mean), 4),
        percent(noise.rms, 2),
        percent(noise.robust, 2),
        number(noise.ratio(), 2),
        percent(noise.worst, 1),
        number(seconds, 2),
        number(speed, 2),
    ]
}

fn of_group(compared: Option<&Quotients>) -> [String; COMPARED.len()] {
    let number_of = |of: fn(&Quotients) -> Option<f64>| number(compared.and_then(of), 2);
    let none = String::new;
    [
        number(compared.and_then(|compared| compared.mean), 3),
        number_of(|compared| compared.efficiency),
        none(),
        number_of(|compared| compared.robust),
        none(),
    ]
}

fn of_picture(compared: Option<&Compared>) -> [String; COMPARED.len()] {
    let [of_groups, robust] = compared.map_or([None, None], Compared::of_groups);
    [
        number(compared.and_then(|compared| compared.picture.mean), 3),
        number(compared.and_then(|compared| compared.picture.efficiency), 2),
        number(of_groups, 2),
        number(robust, 2),
        number(compared.map(|compared| compared.speed), 2),
    ]
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}

#[cfg(test)]
mod tests {
    use super::super::compare::tests::scene;
    use super::*;

    #[test]
    fn lines_stand_below_their_headings() {
        let table = Table::new(["fig8", "room"].into_iter(), false);
        let noise = scene(2.0, &[("floor", 0.1)]);
        let lines = table.lines("room", &noise, None);
        assert_eq!(
            [table.head(), lines[0].clone(), lines[1].clone()],
            [
                "scene  group              pixels     mean    rms %  robust %    ratio  worst %        s  Mpaths/s",
                "room   floor                1234   0.5000    10.00      5.00     2.00     25.0        -         -",
                "room   (picture)            1234   0.5000    20.00     10.00     2.00     25.0     2.00      0.61",
            ]
        );
    }

    #[test]
    fn what_was_not_measured_before_is_a_dash() {
        let table = Table::new(["room"].into_iter(), true);
        let lines = table.lines("room", &scene(2.0, &[]), None);
        assert!(table.head().ends_with("mean x  efficiency  of groups  of robust    speed"));
        assert_eq!(lines[0].split_whitespace().skip(10).collect::<Vec<_>>(), ["-"; 5]);
        assert_eq!(lines[0].chars().count(), table.head().chars().count());
    }
}
