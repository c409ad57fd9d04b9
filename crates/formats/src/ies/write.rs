//! A profile as an IES file that reads back to the same bits.

use std::fmt::{Display, Write};
use unrender_scene::{LightProfile, Photometry};

/// Numbers on a line. Lines of LM-63-1995 have 132 characters at most, and a number has up to 25.
const PER_LINE: usize = 5;

/// `profile` as the text of an IES file of LM-63-2002, the edition that most programs read; `name` is the lamp's.
pub fn text(profile: &LightProfile, name: &str) -> String {
    let name: String = name.chars().filter(|c| !c.is_control()).take(100).collect();
    let kind = match profile.photometry() {
        Photometry::C => 1,
        Photometry::B => 2,
        Photometry::A => 3,
    };
    let (vertical, horizontal) = (profile.vertical_deg(), profile.horizontal_deg());
    let mut text = format!(
        "IESNA:LM-63-2002\n[TEST] none\n[TESTLAB] none\n[ISSUEDATE] none\n[MANUFAC] none\n[LUMINAIRE] {name}\n\
         TILT=NONE\n1 -1 1 {} {} {kind} 2 0 0 0\n1 1 0\n",
        vertical.len(),
        horizontal.len()
    );
    lines(&mut text, vertical);
    lines(&mut text, horizontal);
    let candela: Vec<f64> = profile.candela().collect();
    candela.chunks(vertical.len()).for_each(|column| lines(&mut text, column));
    text
}

fn lines(text: &mut String, numbers: &[impl Display]) {
    for line in numbers.chunks(PER_LINE) {
        for (place, number) in line.iter().enumerate() {
            let _ = write!(text, "{}{number}", if place == 0 { "" } else { " " });
        }
        text.push('\n');
    }
}
