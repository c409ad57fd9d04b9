//! The cameras of the new pictures.

use super::edit_sheet::EditSheet;
use super::raw_camera::{RawCamera, RawKey};
use super::start::Start;
use crate::{Error, job};
use toml::Value;
use unrender_restage::camera::{Key, Path, goes_through};
use unrender_scene::{Camera, Lens, Scene, Warnings};

/// The cameras of the new pictures.
#[derive(Clone, Debug, PartialEq)]
pub enum View {
    /// The photograph's.
    Photograph(Camera),
    /// Another one, with the name of its place in messages.
    Other(Camera, String),
    /// One per picture, with the name of their place in messages.
    Sequence(Vec<Camera>, String),
}

impl View {
    /// The cameras, one per picture.
    pub fn cameras(&self) -> &[Camera] {
        match self {
            Self::Photograph(camera) | Self::Other(camera, _) => std::slice::from_ref(camera),
            Self::Sequence(cameras, _) => cameras,
        }
    }

    /// A warning if the camera of a sequence goes through a surface of `scene`.
    pub(super) fn doubts(&self, scene: &Scene) -> Warnings {
        let mut warnings = Warnings::default();
        let Self::Sequence(cameras, place) = self else { return warnings };
        if let Some((picture, object)) = goes_through(scene, cameras) {
            warnings.push(format!(
                "{place}: camera: between the pictures {picture} and {} it goes through \"{}\"; a key between them keeps it \
                 on its side",
                picture + 1,
                scene.objects[object].name
            ));
        }
        warnings
    }
}

/// The last camera that `sheets` state, else the photograph's, else the scene's first.
pub(super) fn choose(sheets: &[EditSheet], start: &Start) -> Result<View, Error> {
    let stated = sheets.iter().rev().find_map(|s| s.raw.camera.as_ref().map(|c| (s, c)));
    let Some((sheet, value)) = stated else {
        return Ok(match &start.photograph {
            Some(photograph) => View::Photograph(photograph.camera.clone()),
            None => {
                let (camera, _) = job::named_camera(&start.scene, None, &start.path)?;
                View::Other(camera, "the scene".into())
            }
        });
    };
    let place = sheet.written.place(value.span());
    let fault = |problem: String| Error::Request(format!("{place}: {problem}"));
    match value.get_ref() {
        Value::String(name) => {
            let (camera, _) = job::named_camera(&start.scene, Some(name), &start.path)
                .map_err(|error| fault(error.to_string()))?;
            Ok(View::Other(camera, place))
        }
        Value::Table(table) => {
            let raw = table.clone().try_into();
            let raw: RawCamera = raw
                .map_err(|error: toml::de::Error| fault(format!("camera: {}", error.message())))?;
            placed(raw, start).map_err(fault).map(|cameras| {
                match <[Camera; 1]>::try_from(cameras) {
                    Ok([camera]) => View::Other(camera, place),
                    Err(cameras) => View::Sequence(cameras, place),
                }
            })
        }
        _ => Err(fault("camera: give a name or a table with eye and target".into())),
    }
}

/// The cameras of a table `[camera]`: one, or a sequence through its keys.
fn placed(raw: RawCamera, start: &Start) -> Result<Vec<Camera>, String> {
    let of_photograph = start.photograph.as_ref().map(|p| &p.camera);
    let usual = of_photograph.or(start.scene.cameras.first());
    let fov = raw.fov_y_deg.map(|fov| fov.0);
    let fov = fov.or(usual.map(|c| c.fov_y_rad.to_degrees()));
    let up = raw.up.map_or(start.scene.up.unit(), |up| up.0);
    let single = match (raw.eye, raw.target) {
        (Some(eye), Some(target)) => {
            Some(RawKey { time: None, eye, target, up: None, fov_y_deg: None })
        }
        (None, None) => None,
        _ => return Err("camera: eye and target go together".into()),
    };
    let keys = match (single, raw.keys.is_empty()) {
        (Some(key), true) => vec![key],
        (None, false) => raw.keys,
        _ => return Err("camera: give eye and target, or [[camera.keys]]".into()),
    };
    let key = |(index, key): (usize, &RawKey)| {
        let fov = key.fov_y_deg.map(|fov| fov.0).or(fov);
        let fov = fov.filter(|fov| *fov < 180.0);
        let fov = fov.ok_or("camera: fov_y_deg is missing, or not below 180")?;
        let time = key.time.map_or(index as f32, |time| time.0);
        let up = key.up.map_or(up, |up| up.0);
        let [eye, target] = [key.eye, key.target].map(|place| start.scene.here(place.0));
        Ok(Key { time, eye, target, up, fov_y_rad: fov.to_radians() })
    };
    let keys: Vec<Key> = keys.iter().enumerate().map(key).collect::<Result<_, String>>()?;
    if keys.windows(2).any(|pair| pair[0].time >= pair[1].time) {
        return Err("camera.keys: the times must grow from key to key".into());
    }
    let frames = match (keys.len(), raw.frames) {
        (1, None) => 1,
        (_, Some(frames @ 1..=100_000)) => frames,
        _ => return Err("camera: state the number of pictures, as in frames = 48".into()),
    };
    let lens = usual.map_or_else(Lens::default, |camera| camera.lens);
    let aspect = usual.and_then(|camera| camera.aspect);
    let cameras = Path { keys, lens }.cameras(frames);
    if let Some(frame) = cameras.iter().position(|c| !c.world_from_camera.is_finite()) {
        return Err(format!(
            "camera: in picture {} eye and target are the same point, or up is along the line of sight",
            frame + 1
        ));
    }
    Ok(cameras.into_iter().map(|camera| Camera { aspect, ..camera }).collect())
}
