//! From what is written to edits, each with what messages call its place.

use super::raw::{RawInsert, RawMaterial, RawRemove, RawRepaint};
use super::sheet::Sheet;
use super::start::Start;
use crate::Error;
use crate::lighting::{RawEnvironment, RawLight};
use crate::toml_values::NotNegative;
use glam::{EulerRot, Quat, Vec3};
use std::sync::Arc;
use unrender_formats::{Input, materials};
use unrender_restage::Edit;
use unrender_restage::environment::Surround;
use unrender_restage::insert::{Insert, Place};
use unrender_restage::remove::{Bearer, Remove};
use unrender_restage::repaint::{Paint, Repaint};
use unrender_scene::{Texture, Warnings, Wrap};

type Placed = (String, Edit);

/// The edits of all `sheets`: first all that is removed, then repainted, lit and inserted.
pub(super) fn edits(
    sheets: &[Sheet],
    start: &Start,
    warnings: &mut Warnings,
) -> Result<Vec<Placed>, Error> {
    let mut edits = Vec::new();
    let mut told = Warnings::default();
    for sheet in sheets {
        collect(sheet, &sheet.raw.remove, &mut edits, &mut |raw| remove(raw))?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.repaint, &mut edits, &mut |raw| repaint(raw, sheet, &mut told))?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.lights, &mut edits, &mut |raw| light(raw))?;
    }
    for sheet in sheets {
        collect(sheet, sheet.raw.environment.as_slice(), &mut edits, &mut |raw| {
            surround(raw, sheet, &mut told)
        })?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.insert, &mut edits, &mut |raw| {
            insert(raw, sheet, start, &mut told)
        })?;
    }
    warnings.extend(told);
    Ok(edits)
}

fn collect<T>(
    sheet: &Sheet,
    raw: &[toml::Spanned<T>],
    edits: &mut Vec<Placed>,
    understand: &mut dyn FnMut(&T) -> Result<Edit, String>,
) -> Result<(), Error> {
    for written in raw {
        let place = sheet.place(written.span());
        let edit = understand(written.get_ref())
            .map_err(|problem| Error::Request(format!("{place}: {problem}")))?;
        edits.push((place, edit));
    }
    Ok(())
}

fn remove(raw: &RawRemove) -> Result<Edit, String> {
    let (name, what) = match (&raw.name, &raw.object, &raw.group) {
        (Some(name), None, None) => (name, Bearer::Any),
        (None, Some(name), None) => (name, Bearer::Object),
        (None, None, Some(name)) => (name, Bearer::Group),
        _ => return Err("remove: give one of name, object and group".into()),
    };
    Ok(Edit::Remove(Remove { name: name.clone(), what }))
}

fn repaint(raw: &RawRepaint, sheet: &Sheet, told: &mut Warnings) -> Result<Edit, String> {
    let RawRepaint { group, rho_d, rho_s, alpha, alpha_x, alpha_y, theta_deg, texture } = raw;
    let (rho_d, rho_s, alpha, alpha_x, alpha_y) = (*rho_d, *rho_s, *alpha, *alpha_x, *alpha_y);
    let (theta_deg, texture) = (*theta_deg, texture.clone());
    let raw = RawMaterial { name: None, rho_d, rho_s, alpha, alpha_x, alpha_y, theta_deg, texture };
    Ok(Edit::Repaint(Repaint { group: group.clone(), paint: paint(&raw, sheet, told)? }))
}

fn paint(raw: &RawMaterial, sheet: &Sheet, told: &mut Warnings) -> Result<Paint, String> {
    if raw.alpha.is_some() && (raw.alpha_x.is_some() || raw.alpha_y.is_some()) {
        return Err("give alpha, or alpha_x and alpha_y".into());
    }
    if raw.texture.is_some() && raw.rho_d.is_some() {
        return Err("give rho_d or a texture, not both".into());
    }
    let texture = match &raw.texture {
        Some(path) => {
            let read = materials::read_texture(Input::new(&sheet.path(path), sheet.limits()));
            let (image, warnings) = read.map_err(|error| error.to_string())?;
            told.extend(warnings);
            let (wrap_u, wrap_v) = (Wrap::Repeat, Wrap::Repeat);
            Some(Arc::new(Texture { image, wrap_u, wrap_v }))
        }
        None => None,
    };
    let alpha = |own: Option<NotNegative>| own.or(raw.alpha).map(|alpha| alpha.0);
    Ok(Paint {
        rho_d: raw.rho_d.map(|rho| rho.0),
        rho_s: raw.rho_s.map(|rho| rho.0),
        alpha_x: alpha(raw.alpha_x),
        alpha_y: alpha(raw.alpha_y),
        theta_rad: raw.theta_deg.map(|theta| theta.0.to_radians()),
        texture,
    })
}

fn light(raw: &RawLight) -> Result<Edit, String> {
    if raw.unknown.is_some() {
        return Err("unknown is a key of project files, where brightness can be asked for".into());
    }
    Ok(Edit::Light(raw.edit()?))
}

fn surround(raw: &RawEnvironment, sheet: &Sheet, told: &mut Warnings) -> Result<Edit, String> {
    let read = raw.choice(&|file| sheet.path(file))?.read(sheet.limits());
    let (environment, warnings) = read.map_err(|error| error.to_string())?;
    told.extend(warnings);
    Ok(Edit::Surround(Surround { environment }))
}

fn insert(
    raw: &RawInsert,
    sheet: &Sheet,
    start: &Start,
    told: &mut Warnings,
) -> Result<Edit, String> {
    let path = sheet.path(&raw.file);
    let (model, warnings) = unrender_formats::load_model(Input::new(&path, sheet.limits()))
        .map_err(|error| error.to_string())?;
    told.extend(warnings);
    let stem = || raw.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = raw.name.clone().unwrap_or_else(stem);
    let turn = raw.rotation_deg.map_or(Vec3::ZERO, |turn| turn.0) * (std::f32::consts::PI / 180.0);
    let materials = raw.material.iter();
    let paint = materials.map(|m| Ok((m.name.clone(), paint(m, sheet, told)?)));
    Ok(Edit::Insert(Insert {
        paint: paint.collect::<Result<_, String>>()?,
        name,
        model,
        rotation: Quat::from_euler(EulerRot::ZYX, turn.z, turn.y, turn.x),
        scale: raw.scale.map_or(1.0, |scale| scale.0),
        place: place(raw, start)?,
    }))
}

fn place(raw: &RawInsert, start: &Start) -> Result<Place, String> {
    match (raw.position, raw.at, raw.pixel) {
        (Some(position), None, None) if raw.on.is_none() => Ok(Place::At(position.0)),
        (None, Some(at), None) => {
            let group = raw.on.clone().ok_or("at = [x, z] needs on = \"GROUP\" to stand on")?;
            Ok(Place::Onto { group, x: at.0.x, z: at.0.y })
        }
        (None, None, Some(pixel)) => {
            let photograph = start.photograph.as_ref();
            let photograph = photograph.ok_or("pixel needs the photograph; name the project")?;
            let (camera, (width, height)) = (&photograph.camera, photograph.size());
            let pixel = pixel.0;
            if !(0.0..width as f32).contains(&pixel.x) || !(0.0..height as f32).contains(&pixel.y) {
                return Err(format!(
                    "pixel is {pixel}, outside the photograph of {width} x {height}"
                ));
            }
            let direction = camera.direction(pixel.x, pixel.y, width, height);
            Ok(Place::Seen { origin: camera.origin(), direction, group: raw.on.clone() })
        }
        _ => Err("give one place: position = [x, y, z]; on = \"GROUP\" with at = [x, z]; or \
                  pixel = [x, y]"
            .into()),
    }
}
