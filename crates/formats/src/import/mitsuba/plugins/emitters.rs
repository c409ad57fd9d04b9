//! The rows of emitters, sensors and films.

use super::{FILE, Plugin, Shared, plugin, sharing};
use crate::entry::{Entry, passed, read, refused, told};

const fn emitter(entry: Entry, properties: &'static [Entry]) -> Plugin {
    sharing(OF_EMITTERS, plugin(("emitter", entry.name), entry, properties))
}

const fn sky(entry: Entry, properties: &'static [Entry]) -> Plugin {
    sharing(SKIES, plugin(("emitter", entry.name), entry, properties))
}

const fn sensor(entry: Entry, properties: &'static [Entry]) -> Plugin {
    sharing(SENSORS, plugin(("sensor", entry.name), entry, properties))
}

const OF_EMITTERS: &Shared =
    &Shared { of: "emitters", properties: &[passed("sampling_weight", "how it is sampled")] };

const SKIES: &Shared = &Shared {
    of: "sunsky, sky and sun",
    properties: &[
        read("to_world", "how it is turned; up is +y before it, in Mitsuba 3 +z"),
        read("turbidity", "1 to 10; 3 by default"),
        read("sun_direction", "towards the sun, in place of place and time"),
        read("latitude", "of the place, degrees; Tokyo by default"),
        read("longitude", "of the place, degrees"),
        read("timezone", "hours before universal time"),
        read("year", "the date; 10 July 2010 by default"),
        read("month", "the date"),
        read("day", "the date"),
        read("hour", "local time, without daylight saving; 15 by default"),
        read("minute", "local time"),
        read("second", "local time"),
        read("scale", "a factor"),
        read("stretch", "1 to 2; stretches the sky below the horizon"),
        passed("resolution", "of its panorama, which is fine enough"),
        passed("sampling_weight", "how it is sampled"),
    ],
};

const SENSORS: &Shared = &Shared {
    of: "sensors",
    properties: &[
        read("to_world", "where it is and where it looks"),
        read("fov", "the angle of view, degrees"),
        read("fov_axis", "x, y, diagonal, smaller or larger"),
        read(
            "focal_length",
            "in its place, of a film of 24 mm x 36 mm by its diagonal; 50mm by default",
        ),
        read("principal_point_offset_x", "how far the axis is off the middle"),
        read("principal_point_offset_y", "how far the axis is off the middle"),
        read("<film>", "the sides of the picture"),
        passed("<sampler>", "how pixels are sampled"),
        read("near_clip", "the depth from which on surfaces are seen; 0.01 by default"),
        passed("far_clip", "surfaces further away are seen, too"),
        passed("focus_distance", "all is sharp"),
        passed("shutter_open", "nothing moves"),
        passed("shutter_close", "nothing moves"),
    ],
};

const ALBEDO: Entry = read("albedo", "of the ground; 0.2 by default, in Mitsuba 3 0.3");
const EXTEND: Entry = read("extend", "whether the horizon goes on below, fading");
const SUN_RADIUS: Entry = read(
    "sun_radius_scale",
    "how much larger the sun is, at the same power; 0 is a directional light",
);

pub(super) const EMITTERS: &[Plugin] = &[
    emitter(
        read("area", "the shape that it stands in shines"),
        &[read("radiance", "a colour or a spectrum; the mean of a texture, with a warning")],
    ),
    emitter(
        read("point", "a point light"),
        &[
            read("position", "where it is"),
            read("to_world", "where it is, if there is no position"),
            read("intensity", "a colour or a spectrum"),
        ],
    ),
    emitter(
        told(
            "spot",
            "the nearest cone of ours that sends the same light in all; exact only where beam_width is not below \
             cutoff_angle",
        ),
        &[
            read("to_world", "where it is and where it points"),
            read("intensity", "a colour or a spectrum"),
            read("cutoff_angle", "where its light ends; 20 degrees by default"),
            read(
                "beam_width",
                "where it begins to fade; three quarters of cutoff_angle by default",
            ),
            read("texture", "a colour; the mean of a picture, with a warning"),
        ],
    ),
    emitter(
        read("directional", "light from far away"),
        &[
            read("direction", "where it points"),
            read("to_world", "along its z, if there is no direction"),
            read("irradiance", "a colour or a spectrum"),
        ],
    ),
    emitter(
        read("constant", "the environment, the same everywhere"),
        &[read("radiance", "a colour or a spectrum")],
    ),
    emitter(
        read(
            "envmap",
            "the environment; a warning for pictures of 8 or 16 bits, which lack bright light",
        ),
        &[
            FILE,
            read("scale", "a factor"),
            read("to_world", "how it is turned"),
            passed("mis_compensation", "how it is sampled"),
        ],
    ),
    sky(
        read(
            "sunsky",
            "the clear sky of Hosek and Wilkie with its sun, as an environment; of Mitsuba 0.5, with the sun of Preetham",
        ),
        &[
            ALBEDO,
            read("sky_scale", "a factor of the sky; scale by default"),
            read("sun_scale", "a factor of the sun; scale by default"),
            SUN_RADIUS,
            read("sun_aperture", "of Mitsuba 3; the angle under which the sun is seen, degrees"),
            told("complex_sun", "of Mitsuba 3; the sun is as bright at its edge as in its middle"),
            EXTEND,
        ],
    ),
    sky(read("sky", "of Mitsuba 0.5; the sky of sunsky"), &[ALBEDO, EXTEND]),
    sky(read("sun", "of Mitsuba 0.5; the sun of sunsky"), &[SUN_RADIUS]),
    emitter(
        refused(
            "others",
            "put an area, point, spot, directional, constant, envmap or sunsky in their place",
        ),
        &[],
    ),
    sensor(read("perspective", "a camera"), &[]),
    sensor(
        read("thinlens", "a camera without depth of field"),
        &[told("aperture_radius", "above zero it is left out: everything is sharp")],
    ),
    plugin(("sensor", "others"), told("others", "they are not pinholes and are left out"), &[]),
    plugin(
        ("film", "*"),
        read("film", "of all types"),
        &[
            read("width", "768 by default"),
            read("height", "576 by default"),
            read("crop_width", "the part of it that is rendered"),
            read("crop_height", "the part of it that is rendered"),
            read("crop_offset_x", "where that part begins"),
            read("crop_offset_y", "where that part begins"),
            passed("<rfilter>", "how pixels are filtered"),
            passed("pixel_format", "how the picture is written"),
            passed("component_format", "how the picture is written"),
            passed("file_format", "how the picture is written"),
            passed("compression", "how the picture is written"),
            passed("banner", "how the picture is written"),
            passed("gamma", "how the picture is written"),
            passed("attach_log", "how the picture is written"),
            passed("compensate", "how the picture is summed"),
            passed("sample_border", "how pixels are filtered"),
            passed("high_quality_edges", "how pixels are filtered"),
        ],
    ),
];
