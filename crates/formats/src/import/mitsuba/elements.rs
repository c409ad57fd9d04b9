//! The elements of Mitsuba's XML that are known: others are refused.

use crate::entry::{Entry, Table, read};

const PLUGIN: &str = "with a type: see below";
const NUMBERS: &str = "three numbers in value, or x, y and z";

/// Elements with a type.
pub(super) const PLUGINS: [Entry; 12] = [
    read("bsdf", PLUGIN),
    read("emitter", PLUGIN),
    read("film", PLUGIN),
    read("integrator", PLUGIN),
    read("medium", PLUGIN),
    read("phase", PLUGIN),
    read("rfilter", PLUGIN),
    read("sampler", PLUGIN),
    read("sensor", PLUGIN),
    read("shape", PLUGIN),
    read("texture", PLUGIN),
    read("volume", PLUGIN),
];

/// Elements that are properties.
pub(super) const PROPERTIES: [Entry; 9] = [
    read("float", "a number"),
    read("integer", "a whole number"),
    read("boolean", "true or false, in small letters or large ones"),
    read("string", "a text"),
    read("rgb", "linear sRGB: three numbers, or one for all; in Mitsuba 0.5 #rrggbb, too"),
    read("srgb", "of Mitsuba 0.5 and 0.6: #rrggbb, or numbers as a picture has them, 0 to 1"),
    read(
        "spectrum",
        "a number, wavelengths with values, a file of them, or a plugin; as linear sRGB; in Mitsuba 0.5 three numbers of \
         linear sRGB, too",
    ),
    read("point", NUMBERS),
    read("vector", NUMBERS),
];

/// Elements that put the scene together.
const WHOLE: [Entry; 6] = [
    read("include", "the file in its place; nested up to 15 deep"),
    read("default", "a parameter $name; the first one of a name counts"),
    read("path", "one more folder in which files are looked for"),
    read("alias", "another id"),
    read("ref", "the element with this id, before it or after it"),
    read("transform", "the steps in it, one after the other"),
];

/// The steps of a `<transform>`.
pub(super) const STEPS: [Entry; 5] = [
    read("translate", NUMBERS),
    read("scale", NUMBERS),
    read("rotate", "about an axis, by degrees; one that is no unit vector shears, as in Mitsuba"),
    read("lookat", "origin, target and up"),
    read("matrix", "9 or 16 numbers, row by row"),
];

/// What is read of the elements.
pub(super) fn table() -> Table {
    let all = PLUGINS.iter().chain(&PROPERTIES).chain(&WHOLE).chain(&STEPS);
    Table::new("Mitsuba: elements", "element", all)
}
