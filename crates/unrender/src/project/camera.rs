//! The table `[camera]` of a project file: reads it to a camera, and writes one into a file that
//! keeps everything else.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml_edit::{Array, DocumentMut, Item, Table, Value};
use unrender_formats::FileError;
use unrender_scene::origin::in_digits;
use unrender_scene::{Camera, Lens};

/// A camera as in the project file; reading a written one gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraTable {
    /// The camera's centre in the world of the scene's file, metres.
    pub eye: DVec3,
    /// A point that it looks at.
    pub target: DVec3,
    /// Upwards in the picture, not along the line of sight.
    pub up: Vec3,
    /// Full vertical field of view, degrees.
    pub fov_y_deg: f32,
    /// Principal point and distortion.
    pub lens: Lens,
    /// The depth from which on things are seen, metres; zero where nothing is cut away.
    pub near: f32,
}

/// Where a camera stands and looks, in the world of the scene's file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stand {
    /// The camera's centre, metres.
    pub eye: DVec3,
    /// A point that it looks at.
    pub target: DVec3,
    /// Upwards in the picture, not along the line of sight.
    pub up: Vec3,
    /// The depth from which on things are seen, metres; zero where nothing is cut away.
    pub near: f32,
}

impl Stand {
    /// The camera that stands there, called `name`, its position counted from `origin`.
    pub fn camera(&self, name: &str, origin: DVec3, fov_y_rad: f32) -> Camera {
        let [eye, target] = [self.eye, self.target].map(|place| (place - origin).as_vec3());
        let camera = Camera::look_at(name, eye, target, self.up, fov_y_rad);
        Camera { near: self.near, ..camera }
    }
}

impl CameraTable {
    /// The table for `camera`, whose position counts from `origin`, with a target `distance` metres before it.
    pub fn of(camera: &Camera, distance: f32, origin: DVec3) -> Self {
        let axes = camera.world_from_camera.matrix3;
        let eye = camera.origin();
        let in_world = |here: Vec3| {
            // Near zero these are exactly the numbers in single precision.
            let axis = |axis: usize| match origin[axis] {
                0.0 => f64::from(here[axis]),
                from => in_digits(from, here[axis]),
            };
            DVec3::from_array([0, 1, 2].map(axis))
        };
        Self {
            eye: in_world(eye),
            target: in_world(eye - distance * Vec3::from(axes.z_axis)),
            up: axes.y_axis.into(),
            fov_y_deg: camera.fov_y_rad.to_degrees(),
            lens: camera.lens,
            near: camera.near,
        }
    }

    /// The camera, called `name`, its position counted from `origin`.
    pub fn camera(&self, name: &str, origin: DVec3) -> Camera {
        let Self { eye, target, up, near, .. } = *self;
        let stand = Stand { eye, target, up, near };
        let camera = stand.camera(name, origin, self.fov_y_deg.to_radians());
        Camera { lens: self.lens, ..camera }
    }

    /// The project file `text`, which `path` names in messages, with this camera instead of its
    /// former one. Comments and all other keys stay. `origin` is a line that states the source of
    /// the camera.
    ///
    /// # Errors
    /// If `text` is not TOML.
    pub fn put_into(&self, text: &str, path: &Path, origin: &str) -> Result<String, FileError> {
        let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| {
            FileError::new(path, format!("is not TOML: {}", error.message()))
        })?;
        if !document.get("camera").is_some_and(Item::is_table) {
            document.remove("camera");
            document.insert("camera", Item::Table(Table::new()));
        }
        if let Some(table) = document["camera"].as_table_mut() {
            self.fill(table);
            let before = table.decor().prefix().and_then(|p| p.as_str()).unwrap_or("\n");
            let kept = before.lines().filter(|line| !line.starts_with(ORIGIN));
            let kept: String = kept.map(|line| format!("{line}\n")).collect();
            let gap = if kept.is_empty() && !text.trim().is_empty() { "\n" } else { "" };
            table.decor_mut().set_prefix(format!("{gap}{kept}{ORIGIN}{origin}\n"));
        }
        Ok(document.to_string())
    }

    fn fill(&self, table: &mut Table) {
        let place =
            |v: DVec3| Item::Value(v.to_array().map(double).into_iter().collect::<Array>().into());
        table.insert("eye", place(self.eye));
        table.insert("target", place(self.target));
        table.insert("up", Item::Value(list(&self.up.to_array())));
        table.insert("fov_y_deg", Item::Value(number(self.fov_y_deg)));
        let Lens { principal_point, fx_over_fy, k1, k2, k3, p1, p2 } = self.lens;
        let shift = (principal_point != [0.0; 2]).then(|| list(&principal_point));
        let ratio = (fx_over_fy != 1.0).then(|| number(fx_over_fy));
        let bend = |k: f32| self.lens.distorts().then(|| number(k));
        let rare = |k: f32| (k != 0.0).then(|| number(k));
        let terms = [("k1", bend(k1)), ("k2", bend(k2)), ("k3", rare(k3))];
        let terms = terms.into_iter().chain([("p1", rare(p1)), ("p2", rare(p2))]);
        let terms = terms.chain([("near", rare(self.near))]);
        let others = OTHER_FORMS.map(|key| (key, None));
        let optional = [("principal_point", shift), ("fx_over_fy", ratio)].into_iter();
        for (key, value) in optional.chain(terms).chain(others) {
            match value {
                Some(value) => table.insert(key, Item::Value(value)),
                None => table.remove(key),
            };
        }
    }
}

/// The other keys by which a table can state the same.
const OTHER_FORMS: [&str; 11] = [
    "fx",
    "fy",
    "cx",
    "cy",
    "opencv",
    "view",
    "colmap",
    "image",
    "scene_from_world",
    "crop",
    "pixels",
];

/// The beginning of the line that states the source of the camera.
const ORIGIN: &str = "# Calibrated ";

fn list(values: &[f32]) -> Value {
    let numbers: Array = values.iter().map(|value| number(*value)).collect();
    Value::Array(numbers)
}

/// The shortest decimal that reads back as `value`, which is single precision near zero.
fn double(value: f64) -> Value {
    let single = value as f32;
    if f64::from(single) == value { number(single) } else { Value::from(value) }
}

/// The shortest decimal that reads back as `value`.
fn number(value: f32) -> Value {
    let short = value.to_string().parse().unwrap_or(f64::from(value));
    Value::from(if short as f32 == value { short } else { f64::from(value) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> CameraTable {
        CameraTable {
            eye: Vec3::new(0.1, 1.6, 4.0).as_dvec3(),
            target: Vec3::new(-0.3, 1.2, 0.0).as_dvec3(),
            up: Vec3::new(0.01, 0.99, -0.1),
            fov_y_deg: 39.6,
            lens: Lens { principal_point: [0.01, -0.02], k1: -0.1, ..Lens::default() },
            near: 0.0,
        }
    }

    fn put(text: &str) -> String {
        table().put_into(text, Path::new("a.toml"), "from points.csv.").unwrap()
    }

    const TABLE: &str = "eye = [0.1, 1.6, 4.0]\ntarget = [-0.3, 1.2, 0.0]\n\
        up = [0.01, 0.99, -0.1]\nfov_y_deg = 39.6\n";

    #[test]
    fn everything_else_stays() {
        let head = "# my room\nscene = \"s.glb\" # here\nphoto = \"p.png\"\n";
        let tail = "\n[groups.wall] # white\nknown = { rho_d = 0.9 }\n";
        let expected = format!(
            "{head}{tail}\n# Calibrated from points.csv.\n[camera]\n{TABLE}\
             principal_point = [0.01, -0.02]\nk1 = -0.1\nk2 = 0.0\n"
        );
        let once = put(&format!("{head}camera = \"door\"\n{tail}"));
        assert_eq!(once, expected);
        assert_eq!(put(&once), once, "again changes nothing");
        let other = "\n[camera]\ncolmap = \"sparse/0\"\nimage = \"a.jpg\"\ncrop = [1, 2]\n\
                 pixels = \"stored\"\n";
        assert_eq!(put(&format!("{head}{other}")).replace("\n\n#", "\n#"), {
            let table = &expected[expected.find("# Calibrated").unwrap()..];
            format!("{head}{table}")
        });
        let inline = "camera = { eye = [0, 0, 1], target = [0, 0, 0], fov_y_deg = 40 }\n";
        assert_eq!(put(&format!("{head}{inline}{tail}")), expected);
    }

    #[test]
    fn a_table_stays_in_its_place_and_loses_what_no_longer_holds() {
        let plain = CameraTable { lens: Lens::default(), ..table() };
        let text =
            "scene = \"s\"\n\n# mine\n[camera]\neye = [0, 0, 1]\nk1 = 0.5\nk2 = 1\n\n[recover]\n";
        let text = plain.put_into(text, Path::new("a.toml"), "by hand.").unwrap();
        let expected = "scene = \"s\"\n\n# mine\n# Calibrated by hand.\n[camera]\neye = ";
        assert!(text.starts_with(expected) && text.ends_with("\n\n[recover]\n"), "{text}");
        assert!(!text.contains("k1") && !text.contains("k2"), "{text}");
    }

    #[test]
    fn a_camera_gives_its_table_and_back() {
        let camera = table().camera("a", DVec3::ZERO);
        let back = CameraTable::of(&camera, 3.0, DVec3::ZERO).camera("a", DVec3::ZERO);
        let (a, b) = (camera.world_from_camera, back.world_from_camera);
        assert!(a.abs_diff_eq(b, 1e-6) && camera.lens == back.lens);
        // And far away, where its file has more digits than single precision.
        let origin = DVec3::new(5e5, 0.0, 5.4e6);
        let far = CameraTable::of(&camera, 3.0, origin);
        let text = far.put_into("", Path::new("a.toml"), "by hand.").unwrap();
        assert!(text.contains("eye = [500000.1, 1.6, 5400004.0]"), "{text}");
        let again = far.camera("a", origin).world_from_camera;
        assert_eq!(again.translation, a.translation);
        assert!(again.abs_diff_eq(a, 1e-6));
    }
}
