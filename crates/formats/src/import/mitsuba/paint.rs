//! Colours and textures: what `<rgb>`, `<spectrum>`, `<float>` and `<texture>` say of a reflectance, of
//! light or of an index of refraction.

use super::motion::words;
use super::spectrum::{Spectrum, Use, blackbody};
use super::tree::{Node, Value};
use crate::input::Scope;
use crate::{picture, texels};
use glam::{Affine2, DAffine3, Mat2, Vec3};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;
use unrender_scene::{Image, Rgb, Texture, Warnings, Wrap};

/// A texture whose file is missing is this grey. Half of it would make a room of such textures three times as dark;
/// twice as much is white.
const UNKNOWN: f32 = 0.5;

/// The limits of reading, the warnings, and the textures that were read.
pub(super) struct Context<'a> {
    pub(super) scope: &'a Scope,
    pub(super) warnings: RefCell<Warnings>,
    /// By the place of the texture in the tree, and whether it is of light or of normals.
    textures: RefCell<BTreeMap<(usize, [bool; 2]), Paint>>,
}

impl<'a> Context<'a> {
    pub(super) fn new(scope: &'a Scope) -> Self {
        let (warnings, textures) = (RefCell::default(), RefCell::default());
        Self { scope, warnings, textures }
    }

    pub(super) fn warn(&self, warning: impl Into<String>) {
        self.warnings.borrow_mut().push(warning);
    }
}

/// A colour, the same everywhere or with a picture.
#[derive(Clone, Debug)]
pub(super) struct Paint {
    /// The colour, or its mean over the picture.
    pub(super) mean: Rgb,
    pub(super) picture: Option<Picture>,
}

/// A picture on a surface, and how its texture coordinates become those of the picture.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    pub(super) texture: Arc<Texture>,
    pub(super) to_uv: Affine2,
}

impl Paint {
    /// The same colour everywhere.
    pub(super) fn plain(mean: Rgb) -> Self {
        Self { mean, picture: None }
    }

    /// This times `by`.
    pub(super) fn scaled(&self, by: Rgb, scope: &Scope) -> Result<Self, String> {
        if by == Rgb::ONE {
            return Ok(Self { mean: self.mean, picture: self.picture.clone() });
        }
        self.mapped(|texel| texel * by, scope)
    }

    /// Every texel's `of`.
    pub(super) fn mapped(&self, of: impl Fn(Rgb) -> Rgb, scope: &Scope) -> Result<Self, String> {
        let mut mapped = Self { mean: of(self.mean), picture: self.picture.clone() };
        if let Some(picture) = &mut mapped.picture {
            let old = &picture.texture;
            scope.charge(size_of_val(old.image.pixels()) as u64)?;
            let image = old.image.map(|texel| of(*texel));
            mapped.mean = texels::mean(&image);
            picture.texture = Arc::new(Texture { image, ..**old });
        }
        Ok(mapped)
    }
}

/// The property `name` of `node`, or the grey `default`.
pub(super) fn paint(
    context: &Context,
    node: Node,
    name: &str,
    usage: Use,
    default: f32,
) -> Result<Paint, String> {
    let color = match node.value(name) {
        None => Rgb::splat(default),
        Some(Value::Number(number)) => Rgb::splat(*number as f32),
        Some(Value::Color(color)) => Vec3::from_array(color.map(|c| c as f32)),
        Some(Value::Spectrum(spectrum)) => spectrum.rgb(usage),
        Some(Value::Plugin(index)) if node.other(*index).tag() == "texture" => {
            return texture(context, node.other(*index), usage);
        }
        Some(_) => return Err(node.wrong(name, "a colour or a texture")),
    };
    let is_below = usage != Use::Refraction && color.min_element() < 0.0;
    if is_below || !color.is_finite() {
        return Err(node.wrong(name, "a colour: it is below zero or not finite"));
    }
    if usage == Use::Reflectance && color.max_element() > 1.0 {
        return Err(node.wrong(name, "a reflectance: it is above one"));
    }
    Ok(Paint::plain(color))
}

/// The property `name` as one colour: the mean of a picture, with a warning.
pub(super) fn color(
    context: &Context,
    node: Node,
    name: &str,
    usage: Use,
    default: f32,
) -> Result<Rgb, String> {
    let paint = paint(context, node, name, usage, default)?;
    if paint.picture.is_some() {
        let whose = format!("{} \"{}\"", node.tag(), node.kind());
        context.warn(node.fail(format!(
            "{name} of the {whose} is a picture; the mean of the picture was taken"
        )));
    }
    Ok(paint.mean)
}

/// The property `name` as one number: the mean of its channels.
pub(super) fn share(
    context: &Context,
    node: Node,
    name: &str,
    default: f32,
) -> Result<f32, String> {
    Ok(color(context, node, name, Use::Index, default)?.element_sum() / 3.0)
}

/// The texture `node`.
pub(super) fn texture(context: &Context, node: Node, usage: Use) -> Result<Paint, String> {
    let key = (node.index, [Use::Emission, Use::Normal].map(|other| usage == other));
    if let Some(known) = context.textures.borrow().get(&key) {
        return Ok(known.clone());
    }
    let read = plugin(context, node, usage)?;
    context.textures.borrow_mut().insert(key, read.clone());
    Ok(read)
}

fn plugin(context: &Context, node: Node, usage: Use) -> Result<Paint, String> {
    let placed = |problem: String| node.fail(problem);
    match node.kind() {
        "bitmap" => bitmap(context, node, usage),
        "checkerboard" => checkerboard(context, node, usage),
        "srgb" => {
            let unbounded = node.flag("unbounded", false)?;
            let usage = if unbounded { Use::Index } else { usage };
            paint(context, node, "color", usage, 1.0)
        }
        "uniform" => Ok(Paint::plain(Rgb::splat(node.number("value", 1.0)?.max(0.0)))),
        "rawconstant" => match node.value("value") {
            Some(Value::Vector(vector)) => Ok(Paint::plain(vector.as_vec3())),
            _ => paint(context, node, "value", Use::Index, 1.0),
        },
        "d65" => {
            let scale = node.number("scale", 1.0)?.max(0.0);
            let inside = match node.child("texture")? {
                Some(inside) if !node.has("color") => texture(context, inside, usage)?,
                _ => paint(context, node, "color", usage, 1.0)?,
            };
            inside.scaled(Rgb::splat(scale), context.scope).map_err(placed)
        }
        "blackbody" if usage == Use::Emission => {
            let temperature = f64::from(node.positive("temperature", 0.0)?);
            Ok(Paint::plain(blackbody(temperature, range(node)?)))
        }
        "regular" | "irregular" => {
            let spectrum = tabulated(node)?;
            Ok(Paint::plain(spectrum.map_err(|problem| node.fail(problem))?.rgb(usage)))
        }
        _ => Err(node.refused("put a colour or a bitmap in its place")),
    }
}

/// The first and the last wavelength of a spectrum.
fn range(node: Node) -> Result<[f64; 2], String> {
    let ends = [("wavelength_min", "lambda_min", 360.0), ("wavelength_max", "lambda_max", 830.0)];
    let end = |(name, old, default)| {
        Ok::<f64, String>(node.number(name, node.number(old, default)?)?.into())
    };
    Ok([end(ends[0])?, end(ends[1])?])
}

/// The plugins `regular` and `irregular`; the outer error states its place in the file, the inner
/// one does not.
fn tabulated(node: Node) -> Result<Result<Spectrum, String>, String> {
    if let Some(Value::Spectrum(spectrum)) = node.value("value") {
        return Ok(Ok(spectrum.clone()));
    }
    let list = |name: &str| -> Result<Vec<f64>, String> {
        let text = node.text(name)?;
        let text = text.ok_or_else(|| node.fail(format!("this spectrum has no {name}")))?;
        let numbers = words(text).map(super::motion::number).collect::<Result<_, _>>();
        numbers.map_err(|problem| node.wrong(name, &format!("a list of numbers: {problem}")))
    };
    let values = list("values")?;
    if node.kind() == "regular" {
        return Ok(Spectrum::regular(&values, range(node)?));
    }
    let wavelengths = list("wavelengths")?;
    if wavelengths.len() != values.len() {
        return Ok(Err("this spectrum has not as many wavelengths as values".into()));
    }
    let pairs = wavelengths.into_iter().zip(values).map(|(nm, value)| [nm, value]);
    Ok(Spectrum::sampled(pairs.collect()))
}

/// How texture coordinates become those of a picture.
fn to_uv(node: Node) -> Result<Affine2, String> {
    let DAffine3 { matrix3, translation } = node.motion("to_uv")?;
    let column = |axis: glam::DVec3| axis.truncate().as_vec2();
    let axes = Mat2::from_cols(column(matrix3.x_axis), column(matrix3.y_axis));
    Ok(Affine2::from_mat2_translation(axes, column(translation)))
}

fn bitmap(context: &Context, node: Node, usage: Use) -> Result<Paint, String> {
    let scope = context.scope;
    let Some(path) = node.file(scope, "filename")? else {
        let file = node.text("filename")?.unwrap_or_default();
        context
            .warn(node.fail(format!("the texture \"{file}\" is missing; grey was taken for it")));
        node.pass_all();
        return Ok(Paint::plain(Rgb::splat(UNKNOWN)));
    };
    let (read, told) =
        picture::read_in(scope, &path).map_err(|error| node.fail(error.to_string()))?;
    context.warnings.borrow_mut().extend(told);
    let is_raw = node.flag("raw", false)? || usage == Use::Normal;
    let image = if is_raw { read.values.clone() } else { read.to_linear() };
    let image = match node.text("filter_type")?.unwrap_or("bilinear") {
        // Trilinear and anisotropic filters average what is far away, which many samples a pixel do, too.
        "bilinear" | "trilinear" | "ewa" => image,
        "nearest" => sharp(scope, image).map_err(|problem| node.fail(problem))?,
        _ => {
            return Err(
                node.wrong("filter_type", "\"bilinear\", \"trilinear\", \"ewa\" or \"nearest\"")
            );
        }
    };
    let wrap = match node.text("wrap_mode")?.unwrap_or("repeat") {
        "repeat" => Wrap::Repeat,
        "mirror" => Wrap::MirroredRepeat,
        "clamp" => Wrap::ClampToEdge,
        _ => return Err(node.wrong("wrap_mode", "\"repeat\", \"mirror\" or \"clamp\"")),
    };
    let mean = texels::mean(&image);
    let texture = Arc::new(Texture { image, wrap_u: wrap, wrap_v: wrap });
    Ok(Paint { mean, picture: Some(Picture { texture, to_uv: to_uv(node)? }) })
}

/// Enlarges small pictures, so that hardly anything is interpolated.
fn sharp(scope: &Scope, image: Image<Rgb>) -> Result<Image<Rgb>, String> {
    /// Texels of an enlarged picture along its longer side.
    const SIDE: usize = 1024;
    let times = (SIDE / image.width().max(image.height()).max(1)).clamp(1, 64);
    if times == 1 {
        return Ok(image);
    }
    let (width, height) = (times * image.width(), times * image.height());
    scope.charge((width * height * size_of::<Rgb>()) as u64)?;
    Ok(Image::from_fn(width, height, |x, y| *image.at(x / times, y / times)))
}

fn checkerboard(context: &Context, node: Node, usage: Use) -> Result<Paint, String> {
    /// Texels along one side of the board of two by two; an edge is one texel wide.
    const SIDE: usize = 512;
    let colors =
        [color(context, node, "color0", usage, 0.4)?, color(context, node, "color1", usage, 0.2)?];
    let size = (SIDE * SIDE * size_of::<Rgb>()) as u64;
    context.scope.charge(size).map_err(|problem| node.fail(problem))?;
    let image =
        Image::from_fn(SIDE, SIDE, |x, y| colors[usize::from((2 * x < SIDE) != (2 * y < SIDE))]);
    let texture = Arc::new(Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat });
    let mean = 0.5 * (colors[0] + colors[1]);
    Ok(Paint { mean, picture: Some(Picture { texture, to_uv: to_uv(node)? }) })
}

impl Picture {
    /// Whether u grows along another direction in the picture than on the surface.
    pub(super) fn turns(&self) -> bool {
        let axes = self.to_uv.matrix2;
        axes.x_axis.x <= 0.0 || axes.x_axis.y != 0.0 || axes.y_axis.x != 0.0 || axes.y_axis.y <= 0.0
    }
}
