//! An element's properties: `<float name="alpha" value="0.1"/>` and its like.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec3};
use roxmltree::Node;
use std::collections::BTreeMap;
use std::str::FromStr;
use unrender_scene::Rgb;

/// An element, `$name` in its values replaced by defaults.
#[derive(Clone)]
pub(super) struct Element<'a> {
    node: Node<'a, 'a>,
    defaults: &'a BTreeMap<String, String>,
}

impl<'a> Element<'a> {
    pub(super) fn new<'n: 'a>(node: Node<'n, 'n>, defaults: &'a BTreeMap<String, String>) -> Self {
        Self { node, defaults }
    }

    /// An attribute of the element itself; empty if it has none.
    pub(super) fn attribute(&self, name: &str) -> String {
        self.replaced(self.node.attribute(name).unwrap_or_default())
    }

    /// The first child element called `tag`.
    pub(super) fn child(&self, tag: &str) -> Option<Self> {
        let found = self.node.children().find(|n| n.has_tag_name(tag));
        found.map(|node| Self { node, defaults: self.defaults })
    }

    /// All child elements called `tag`.
    pub(super) fn children(&self, tag: &'static str) -> impl Iterator<Item = Self> {
        let defaults = self.defaults;
        let children = self.node.children().filter(move |n| n.has_tag_name(tag));
        children.map(move |node| Self { node, defaults })
    }

    /// The property called `name`, of any kind.
    pub(super) fn property(&self, name: &str) -> Option<Self> {
        let found = self.node.children().find(|n| n.attribute("name") == Some(name));
        found.map(|node| Self { node, defaults: self.defaults })
    }

    /// What it is called.
    pub(super) fn tag(&self) -> &str {
        self.node.tag_name().name()
    }

    /// Whether it is called `tag`.
    pub(super) fn is(&self, tag: &str) -> bool {
        self.node.has_tag_name(tag)
    }

    /// The `id` of the first `<ref>`.
    pub(super) fn reference(&self) -> Option<String> {
        self.child("ref").map(|r| r.attribute("id"))
    }

    /// The `value` of the property called `name`.
    pub(super) fn value(&self, name: &str) -> Option<String> {
        self.property(name).map(|p| p.attribute("value"))
    }

    /// A number.
    pub(super) fn float(&self, name: &str, default: f32) -> Result<f32, String> {
        let Some(text) = self.value(name) else { return Ok(default) };
        parse(&text).ok_or_else(|| format!("{name} is \"{text}\"; give a number"))
    }

    /// A colour: `<rgb>`, or one number for all channels.
    pub(super) fn rgb(&self, name: &str, default: Rgb) -> Result<Rgb, String> {
        let Some(property) = self.property(name) else { return Ok(default) };
        let inner = property.child("rgb");
        let text = inner.as_ref().unwrap_or(&property).attribute("value");
        color(&text).ok_or_else(|| format!("{name} is \"{text}\"; give a colour as <rgb>"))
    }

    /// A vector.
    pub(super) fn direction(&self, name: &str) -> Option<Vec3> {
        self.point(name).map(|p| p.as_vec3())
    }

    /// A point, in double precision: it may be far from zero.
    pub(super) fn point(&self, name: &str) -> Option<DVec3> {
        self.property(name).map(|p| p.vector(DVec3::ZERO))
    }

    fn vector(&self, default: DVec3) -> DVec3 {
        if let Some(all) = triple(&self.attribute("value")) {
            return all;
        }
        let axis = |name: &str, default| parse(&self.attribute(name)).unwrap_or(default);
        DVec3::new(axis("x", default.x), axis("y", default.y), axis("z", default.z))
    }

    /// The transform `to_world`; the last step stands last.
    pub(super) fn to_world(&self) -> Result<DAffine3, String> {
        let Some(transform) = self.property("to_world") else { return Ok(DAffine3::IDENTITY) };
        let mut world = DAffine3::IDENTITY;
        for node in transform.node.children().filter(Node::is_element) {
            let step = Self { node, defaults: self.defaults };
            world = step.motion()? * world;
        }
        if world.is_finite() { Ok(world) } else { Err("a transform is not finite".into()) }
    }

    fn motion(&self) -> Result<DAffine3, String> {
        let given = |name: &str| {
            let text = self.attribute(name);
            triple(&text).ok_or_else(|| format!("lookat has {name} = \"{text}\"; give 3 numbers"))
        };
        match self.node.tag_name().name() {
            "translate" => Ok(DAffine3::from_translation(self.vector(DVec3::ZERO))),
            "scale" => Ok(DAffine3::from_scale(self.vector(DVec3::ONE))),
            "rotate" => {
                let angle: Option<f64> = parse(&self.attribute("angle"));
                let angle = angle.ok_or("rotate has no angle")?;
                let axis = self.vector(DVec3::ZERO).try_normalize().ok_or("rotate has no axis")?;
                Ok(DAffine3::from_quat(DQuat::from_axis_angle(axis, angle.to_radians())))
            }
            "lookat" => {
                let (origin, target) = (given("origin")?, given("target")?);
                let ahead = (target - origin).normalize();
                let left = given("up")?.cross(ahead).normalize();
                let axes = DMat3::from_cols(left, ahead.cross(left), ahead);
                Ok(DAffine3::from_mat3_translation(axes, origin))
            }
            "matrix" => {
                let numbers: Vec<f64> = numbers(&self.attribute("value"));
                let rows: [f64; 16] = numbers.try_into().map_err(|_| "a matrix has 16 numbers")?;
                Ok(DAffine3::from_mat4(DMat4::from_cols_array(&rows).transpose()))
            }
            other => Err(format!("there is a transform <{other}>, which is not known")),
        }
    }

    fn replaced(&self, text: &str) -> String {
        let mut text = text.to_owned();
        for (name, value) in self.defaults.iter().rev() {
            text = text.replace(&format!("${name}"), value);
        }
        text
    }
}

/// A finite number, in single precision or in double.
fn parse<T: FromStr + Into<f64> + Copy>(text: &str) -> Option<T> {
    text.trim().parse().ok().filter(|v: &T| (*v).into().is_finite())
}

fn numbers<T: FromStr + Into<f64> + Copy>(text: &str) -> Vec<T> {
    let words = text.split([',', ' ', '\n', '\t']).filter(|word| !word.is_empty());
    words.map_while(parse).collect()
}

/// Three numbers, or one for all three.
fn color(text: &str) -> Option<Rgb> {
    match numbers(text)[..] {
        [all] => Some(Rgb::splat(all)),
        [r, g, b] => Some(Rgb::new(r, g, b)),
        _ => None,
    }
}

/// The same in double precision.
fn triple(text: &str) -> Option<DVec3> {
    match numbers(text)[..] {
        [all] => Some(DVec3::splat(all)),
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}
