//! Scenes: from files, or from arrays with their description as JSON.

use crate::arrays::{image, picture, rows, rows2, rows3, triangles};
use crate::error::{exception, request};
use glam::{Affine3A, DVec3, Vec2, Vec3};
use numpy::{PyArray2, PyArray3, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use unrender::Error;
use unrender::scene as plain;
use unrender::scene::{
    Camera, Environment, Group, Lens, Light, LightKind, Material, Mesh, Object, Rgb, RgbImage,
    Texture, Wrap,
};
use unrender_formats::materials::{self, MaterialsFile, ReflectanceEntry};
use unrender_formats::{FileError, Input, LightUnits, Limits, atomic, gltf};

/// The meshes, groups, lights and cameras of a scene.
#[pyclass(module = "unrender._unrender", frozen)]
pub(crate) struct Scene {
    scene: Arc<plain::Scene>,
}

/// One mesh as arrays: positions, triangles, and optional normals and texture coordinates.
#[derive(FromPyObject)]
pub(crate) struct MeshArrays<'py> {
    positions: PyReadonlyArray2<'py, f32>,
    triangles: PyReadonlyArray2<'py, u32>,
    normals: Option<PyReadonlyArray2<'py, f32>>,
    uvs: Option<PyReadonlyArray2<'py, f32>>,
}

/// The arrays of a mesh for Python, in the order of [`MeshArrays`].
type MeshOut<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<u32>>,
    Bound<'py, PyArray2<f32>>,
    Option<Bound<'py, PyArray2<f32>>>,
);

impl Scene {
    pub(crate) fn new(scene: plain::Scene) -> Self {
        Self { scene: Arc::new(scene) }
    }

    pub(crate) fn plain(&self) -> &plain::Scene {
        &self.scene
    }

    pub(crate) fn shared(&self) -> Arc<plain::Scene> {
        Arc::clone(&self.scene)
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene file; returns the scene and its warnings.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        light_units: Option<&str>,
        allow_outside: bool,
        allow_missing: bool,
    ) -> PyResult<(Self, Vec<String>)> {
        let units = light_units.map(str::parse::<LightUnits>).transpose().map_err(request)?;
        let limits = Limits { outside: allow_outside, missing: allow_missing, ..Limits::default() };
        let input = || Input::new(&path, limits).in_light_units(units);
        let read = py.detach(|| unrender_formats::load_model(input()));
        let (scene, warnings) = read.map_err(|error| exception(py, &Error::File(error)))?;
        Ok((Self::new(scene), warnings.0))
    }

    /// A scene from arrays: `json` has the objects, groups, lights, cameras and the environment,
    /// `meshes` the arrays of the objects in their order. Returns its warnings too.
    #[staticmethod]
    fn build(
        py: Python<'_>,
        json: &str,
        meshes: Vec<MeshArrays<'_>>,
        textures: BTreeMap<String, PyReadonlyArray3<'_, f32>>,
    ) -> PyResult<(Self, Vec<String>)> {
        let value: Value = serde_json::from_str(json).map_err(|e| request(e.to_string()))?;
        let mut scene = built(&value, &meshes)?;
        for (name, texture) in &textures {
            put_texture(&mut scene, name, image(texture)?)?;
        }
        let warnings = scene
            .validate_meshes()
            .map_err(|error| exception(py, &Error::Request(format!("the scene: {error}"))))?;
        Ok((Self::new(scene), warnings.0))
    }

    /// Everything except the arrays, as JSON.
    fn describe(&self) -> String {
        let scene = self.plain();
        let group = |group: &Group| {
            let m = &group.material;
            let mut json = json!({
                "name": group.name, "rho_d": m.rho_d.to_array(), "rho_s": m.rho_s.to_array(),
                "alpha_x": m.alpha_x, "alpha_y": m.alpha_y, "theta_deg": m.theta_rad.to_degrees(),
                "textured": m.texture.is_some(), "emission": group.emission.to_array(),
            });
            // Absent for a free reflectance.
            if let (Some(all), Value::Object(of_lobe)) =
                (json.as_object_mut(), json!(ReflectanceEntry::of(m)))
            {
                all.extend(of_lobe);
            }
            json
        };
        let object = |o: &Object| {
            json!({
                "name": o.name, "group": scene.groups[o.group].name,
                "vertices": o.mesh.positions.len(), "triangles": o.mesh.triangles.len(),
            })
        };
        json!({
            "objects": scene.objects.iter().map(object).collect::<Vec<_>>(),
            "groups": scene.groups.iter().map(group).collect::<Vec<_>>(),
            "lights": scene.lights.iter().map(|light| light_out(light, scene)).collect::<Vec<_>>(),
            "cameras": scene.cameras.iter().map(|c| camera_out(c, scene)).collect::<Vec<_>>(),
            "origin": scene.origin.to_array(),
            "environment": scene.environment.is_some(),
            "brdf": scene.brdf.name(),
        })
        .to_string()
    }

    /// The arrays of an object's mesh: positions (N, 3) in metres from the scene's origin, triangles (M, 3), normals (N, 3),
    /// texture coordinates (N, 2) or none.
    fn mesh<'py>(&self, py: Python<'py>, object: usize) -> PyResult<MeshOut<'py>> {
        let objects = &self.plain().objects;
        let object = objects.get(object).ok_or_else(|| request("there is no such object"))?;
        let Mesh { positions, normals, uvs, triangles: corners, .. } = object.mesh.clone();
        let uvs = if uvs.is_empty() { None } else { Some(rows2(py, uvs)?) };
        Ok((rows3(py, positions)?, triangles(py, corners)?, rows3(py, normals)?, uvs))
    }

    /// The texture of a group's diffuse reflectance (H, W, 3), linear.
    fn texture<'py>(
        &self,
        py: Python<'py>,
        group: &str,
    ) -> PyResult<Option<Bound<'py, PyArray3<f32>>>> {
        let scene = self.plain();
        let index = scene.group_index(group).ok_or_else(|| no_group(group))?;
        let texture = scene.groups[index].material.texture.as_ref();
        texture.map(|texture| picture(py, texture.image.clone())).transpose()
    }

    /// The same scene with `materials`, and the warnings.
    fn with_materials(
        &self,
        py: Python<'_>,
        materials: Materials<'_>,
    ) -> PyResult<(Self, Vec<String>)> {
        let mut scene = self.plain().clone();
        let put = materials.read()?.put_onto(&mut scene);
        let warnings = put.map_err(|error| exception(py, &error))?;
        Ok((Self::new(scene), warnings.0))
    }

    /// The same scene with a further camera, which replaces one of its name.
    fn with_camera(&self, json: &str) -> PyResult<Self> {
        let value: Value = serde_json::from_str(json).map_err(|e| request(e.to_string()))?;
        let mut scene = self.plain().clone();
        let camera = camera_in(&value, &scene)?;
        scene.cameras.retain(|other| other.name != camera.name);
        scene.cameras.push(camera);
        Ok(Self::new(scene))
    }

    /// The scene's panorama, radiance (H, W, 3), and its rotation about +y, degrees.
    fn environment<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(Bound<'py, PyArray3<f32>>, f32)>> {
        let around = self.plain().environment.as_ref();
        let given = |around: &Environment| {
            let turned = around.rotation_rad().to_degrees();
            picture(py, around.panorama().clone()).map(|panorama| (panorama, turned))
        };
        around.map(given).transpose()
    }

    /// The bytes of the scene, for a process with the same build.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| postcard::to_stdvec(self.plain()));
        bytes.map(|b| PyBytes::new(py, &b)).map_err(|error| request(format!("the scene: {error}")))
    }

    /// The scene of [`Scene::to_bytes`].
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let read = || -> Result<plain::Scene, String> {
            let mut scene: plain::Scene =
                postcard::from_bytes(bytes).map_err(|error| error.to_string())?;
            scene.validate_meshes().map_err(|error| error.to_string())?;
            Ok(scene)
        };
        let scene = py.detach(read);
        scene.map(Self::new).map_err(|problem| {
            request(format!("these are not the bytes of a scene from the same build: {problem}"))
        })
    }

    /// Writes the scene as glTF to a .glb file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let written = py.detach(|| {
            let bytes = gltf::to_glb(self.plain()).map_err(|e| FileError::new(&path, e))?;
            atomic::write(&path, &bytes)
        });
        written.map_err(|error| exception(py, &Error::File(error)))
    }
}

/// Materials for a scene: the text of a `materials.json`, the folder of its relative texture paths,
/// and textures by the names of their groups.
#[derive(FromPyObject)]
pub(crate) struct Materials<'py> {
    json: String,
    folder: PathBuf,
    textures: BTreeMap<String, PyReadonlyArray3<'py, f32>>,
}

/// The same without Python.
pub(crate) struct PlainMaterials {
    file: MaterialsFile,
    folder: PathBuf,
    textures: Vec<(String, RgbImage)>,
}

impl Materials<'_> {
    /// Reads the parameters and textures.
    pub(crate) fn read(&self) -> PyResult<PlainMaterials> {
        let file = serde_json::from_str(&self.json)
            .map_err(|error| request(format!("the materials: {error}")))?;
        let textures = self.textures.iter();
        let textures = textures.map(|(name, texture)| Ok((name.clone(), image(texture)?)));
        let textures = textures.collect::<PyResult<_>>()?;
        Ok(PlainMaterials { file, folder: self.folder.clone(), textures })
    }
}

impl PlainMaterials {
    pub(crate) fn put_onto(&self, scene: &mut plain::Scene) -> Result<plain::Warnings, Error> {
        let wraps: Vec<_> = scene.groups.iter().map(|group| wrap(&group.material)).collect();
        let warnings = materials::apply(&self.file, &self.folder, scene)?;
        for (name, texture) in &self.textures {
            let index = scene
                .group_index(name)
                .ok_or_else(|| Error::Request(format!("the scene has no group \"{name}\"")))?;
            let texture = wrapped(texture.clone(), wraps[index]);
            scene.groups[index].material.texture = Some(texture);
        }
        Ok(warnings)
    }
}

/// How the texture of a material continues beyond its edges.
fn wrap(material: &Material) -> [Wrap; 2] {
    material.texture.as_ref().map_or([Wrap::default(); 2], |old| [old.wrap_u, old.wrap_v])
}

fn wrapped(image: RgbImage, [wrap_u, wrap_v]: [Wrap; 2]) -> Arc<Texture> {
    let image = image.map(|rho| rho.clamp(Rgb::ZERO, Rgb::ONE));
    Arc::new(Texture { image, wrap_u, wrap_v })
}

fn no_group(name: &str) -> PyErr {
    request(format!("the scene has no group \"{name}\""))
}

fn put_texture(scene: &mut plain::Scene, group: &str, texture: RgbImage) -> PyResult<()> {
    let index = scene.group_index(group).ok_or_else(|| no_group(group))?;
    let material = &mut scene.groups[index].material;
    material.rho_d = materials::mean_of(&texture);
    material.texture = Some(wrapped(texture, [Wrap::default(); 2]));
    Ok(())
}

fn built(value: &Value, meshes: &[MeshArrays<'_>]) -> PyResult<plain::Scene> {
    let origin = if value["origin"].is_null() { DVec3::ZERO } else { place(value, "origin")? };
    let mut scene = plain::Scene { origin, ..plain::Scene::default() };
    let list = |key: &str| value[key].as_array().cloned().unwrap_or_default();
    for group in list("groups") {
        let theta_rad = number(&group, "theta_deg")?.to_radians();
        let material = Material {
            rho_s: triple(&group, "rho_s")?.into(),
            alpha_x: number(&group, "alpha_x")?,
            alpha_y: number(&group, "alpha_y")?,
            theta_rad,
            ..Material::diffuse(triple(&group, "rho_d")?.into())
        };
        let emission = triple(&group, "emission")?.into();
        scene.groups.push(Group { name: name(&group)?, material, emission });
    }
    for (object, arrays) in list("objects").iter().zip(meshes) {
        let group = object["group"].as_str().unwrap_or_default();
        let group = scene.group_index(group).ok_or_else(|| no_group(group))?;
        scene.objects.push(Object { name: name(object)?, group, mesh: mesh(arrays)? });
    }
    for light in list("lights") {
        scene.lights.push(light_in(&light, &scene)?);
    }
    for camera in list("cameras") {
        scene.cameras.push(camera_in(&camera, &scene)?);
    }
    if !value["environment"].is_null() {
        let radiance: Rgb = triple(value, "environment")?.into();
        let environment = Environment::new(RgbImage::new(2, 1, vec![radiance; 2]), 0.0);
        scene.environment = Some(environment.map_err(|error| request(error.to_string()))?);
    }
    Ok(scene)
}

fn mesh(arrays: &MeshArrays<'_>) -> PyResult<Mesh> {
    let vec3 = |rows: Vec<[f32; 3]>| rows.into_iter().map(Vec3::from_array).collect::<Vec<_>>();
    let positions = vec3(rows(&arrays.positions, "vertices")?);
    let triangles: Vec<[u32; 3]> = rows(&arrays.triangles, "faces")?;
    let uvs = arrays.uvs.as_ref().map(|uvs| rows::<f32, 2>(uvs, "uvs")).transpose()?;
    let uvs: Vec<Vec2> = uvs.unwrap_or_default().into_iter().map(Vec2::from_array).collect();
    let count = positions.len();
    if let Some(corner) = triangles.as_flattened().iter().find(|c| **c as usize >= count) {
        return Err(request(format!("faces name vertex {corner}, but there are only {count}")));
    }
    if !uvs.is_empty() && uvs.len() != count {
        return Err(request(format!("there are {count} vertices, but {} uvs", uvs.len())));
    }
    let Some(normals) = &arrays.normals else {
        return Ok(Mesh::flat(&positions, &uvs, &triangles));
    };
    let normals = vec3(rows(normals, "normals")?);
    if normals.len() != count {
        return Err(request(format!("there are {count} vertices, but {} normals", normals.len())));
    }
    let normals = normals.iter().map(|n| n.normalize_or(Vec3::Y)).collect();
    Ok(Mesh { positions, normals, uvs, triangles, ..Mesh::default() })
}

fn name(of: &Value) -> PyResult<String> {
    of["name"].as_str().map(str::to_owned).ok_or_else(|| request("a name is missing"))
}

fn number(of: &Value, key: &str) -> PyResult<f32> {
    let number = of[key].as_f64().filter(|number| number.is_finite());
    number.map(|n| n as f32).ok_or_else(|| request(format!("{key} must be a finite number")))
}

fn triple(of: &Value, key: &str) -> PyResult<[f32; 3]> {
    place(of, key).map(|place| place.as_vec3().to_array())
}

/// A place in the world, or any three numbers, in double precision.
fn place(of: &Value, key: &str) -> PyResult<DVec3> {
    let problem = || request(format!("{key} must be three finite numbers"));
    let list = of[key].as_array().filter(|list| list.len() == 3).ok_or_else(problem)?;
    let one = |k: usize| list[k].as_f64().filter(|n| n.is_finite());
    one(0).zip(one(1)).zip(one(2)).map(|((a, b), c)| DVec3::new(a, b, c)).ok_or_else(problem)
}

fn light_in(light: &Value, scene: &plain::Scene) -> PyResult<Light> {
    let vec = |key: &str| triple(light, key).map(Vec3::from_array);
    let position = || place(light, "position").map(|place| scene.here(place));
    let strength: Rgb = triple(light, "strength")?.into();
    let kind = match light["kind"].as_str() {
        Some("point") => LightKind::Point { position: position()?, intensity: strength },
        Some("spot") => LightKind::Spot {
            position: position()?,
            direction: vec("direction")?.normalize_or(Vec3::NEG_Y),
            intensity: strength,
            inner_rad: number(light, "inner_deg")?.to_radians(),
            outer_rad: number(light, "outer_deg")?.to_radians(),
        },
        Some("directional") => LightKind::Directional {
            direction: vec("direction")?.normalize_or(Vec3::NEG_Y),
            irradiance: strength,
        },
        Some("profiled") => LightKind::Profiled {
            position: position()?,
            direction: vec("direction")?.normalize_or(Vec3::NEG_Y),
            upright: vec("upright")?.normalize_or(Vec3::X),
            intensity: strength,
            profile: serde_json::from_value(light["profile"].clone())
                .map_err(|error| request(format!("the profile of a light {error}")))?,
        },
        _ => return Err(request("a light is of the kind point, spot, directional or profiled")),
    };
    Ok(Light { name: name(light)?, kind })
}

fn light_out(light: &Light, scene: &plain::Scene) -> Value {
    let place = |here: Vec3| scene.in_world(here).to_array();
    let mut value = match &light.kind {
        LightKind::Point { position, intensity } => json!({
            "kind": "point", "position": place(*position), "strength": intensity.to_array(),
        }),
        LightKind::Spot { position, direction, intensity, inner_rad, outer_rad } => json!({
            "kind": "spot", "position": place(*position), "direction": direction.to_array(),
            "strength": intensity.to_array(), "inner_deg": inner_rad.to_degrees(),
            "outer_deg": outer_rad.to_degrees(),
        }),
        LightKind::Directional { direction, irradiance } => json!({
            "kind": "directional", "direction": direction.to_array(),
            "strength": irradiance.to_array(),
        }),
        LightKind::Profiled { position, direction, upright, intensity, profile } => json!({
            "kind": "profiled", "position": place(*position), "direction": direction.to_array(),
            "upright": upright.to_array(), "strength": intensity.to_array(), "profile": profile,
        }),
    };
    value["name"] = json!(light.name);
    value
}

/// A camera in `scene`, from its pose (12 numbers, column by column), or from its eye, target and
/// up.
fn camera_in(camera: &Value, scene: &plain::Scene) -> PyResult<Camera> {
    let fov_y_rad = number(camera, "fov_y_deg")?.to_radians();
    let here = |key: &str| place(camera, key).map(|place| scene.here(place));
    let (eye, target) = (here("eye")?, here("target")?);
    let up = Vec3::from_array(triple(camera, "up")?);
    let mut made = Camera::look_at(&name(camera)?, eye, target, up, fov_y_rad);
    if let Some(pose) = camera["world_from_camera"].as_array().filter(|pose| pose.len() == 12) {
        let mut columns = [0.0; 12];
        for (to, from) in columns.iter_mut().zip(pose) {
            *to = from.as_f64().unwrap_or_default();
        }
        let eye = scene.here(DVec3::from_slice(&columns[9..]));
        made.world_from_camera = Affine3A::from_cols_array(&columns.map(|number| number as f32));
        made.world_from_camera.translation = eye.into();
    }
    if !made.world_from_camera.is_finite() {
        return Err(request("the camera's eye, target and up do not determine its direction"));
    }
    made.aspect = camera["aspect"].as_f64().map(|aspect| aspect as f32);
    let point = camera["principal_point"].as_array().cloned().unwrap_or_default();
    let part = |k: usize| point.get(k).and_then(Value::as_f64).unwrap_or_default() as f32;
    let or = |key: &str, usual: f64| camera[key].as_f64().unwrap_or(usual) as f32;
    let [k1, k2, k3, p1, p2] = ["k1", "k2", "k3", "p1", "p2"].map(|key| or(key, 0.0));
    let fx_over_fy = or("fx_over_fy", 1.0);
    made.lens = Lens { principal_point: [part(0), part(1)], fx_over_fy, k1, k2, k3, p1, p2 };
    Ok(made)
}

/// A camera in `scene`, in the world of its file.
pub(crate) fn camera_out(camera: &Camera, scene: &plain::Scene) -> Value {
    let axes = camera.world_from_camera.matrix3;
    let eye = camera.origin();
    let place = |here: Vec3| scene.in_world(here).to_array();
    let mut pose = camera.world_from_camera.to_cols_array().map(f64::from);
    pose[9..].copy_from_slice(&place(eye));
    json!({
        "name": camera.name, "fov_y_deg": camera.fov_y_rad.to_degrees(), "aspect": camera.aspect,
        "eye": place(eye), "target": place(eye - Vec3::from(axes.z_axis)),
        "up": Vec3::from(axes.y_axis).to_array(),
        "world_from_camera": pose,
        "principal_point": camera.lens.principal_point, "fx_over_fy": camera.lens.fx_over_fy,
        "k1": camera.lens.k1, "k2": camera.lens.k2, "k3": camera.lens.k3,
        "p1": camera.lens.p1, "p2": camera.lens.p2,
    })
}
