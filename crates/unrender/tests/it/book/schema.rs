//! The schemas of `docs/reference/schema`: all files of the repository and those that the program
//! writes are valid by them, and they have the keys that its readers have.

use super::{files, root};
use crate::kit::synthetic;
use jsonschema::{Retrieve, Uri, ValidationError};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::path::Path;
use unrender::Project;
use unrender::edit::{EditSheet, Restaging};
use unrender::run::{EnvironmentEntry, PhotographRun, Run};

/// The schemas by their names.
pub(crate) const NAMES: [&str; 5] = ["project", "edit", "lighting", "materials", "run"];

pub(crate) fn schema(name: &str) -> Value {
    let path = root().join(format!("docs/reference/schema/{name}.schema.json"));
    serde_json::from_str(&fs::read_to_string(&path).unwrap())
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Reads the schemas that others refer to.
struct Schemas;

impl Retrieve for Schemas {
    fn retrieve(&self, uri: &Uri<String>) -> Result<Value, Box<dyn Error + Send + Sync>> {
        let file = uri.path().as_str().rsplit('/').next().unwrap_or_default();
        Ok(schema(file.strip_suffix(".schema.json").ok_or("no schema of ours")?))
    }
}

fn faults(name: &str, value: &Value) -> Vec<String> {
    let validator = jsonschema::options().with_retriever(Schemas).build(&schema(name)).unwrap();
    let fault = |error: ValidationError<'_>| format!("{}: {error}", error.instance_path());
    validator.iter_errors(value).map(fault).collect()
}

/// Asserts that `value` is valid by the schema `name`.
pub(crate) fn holds(name: &str, value: &Value, place: &str) {
    let faults = faults(name, value);
    assert!(faults.is_empty(), "{place} is not valid by the schema {name}: {faults:#?}");
}

pub(crate) fn from_toml(text: &str) -> Value {
    let table: toml::Table = text.parse().unwrap();
    serde_json::to_value(table).unwrap()
}

/// The words that the schemas use: a word that JSON Schema does not have would be ignored.
const WORDS: [&str; 28] = [
    "$schema",
    "$defs",
    "$ref",
    "title",
    "description",
    "default",
    "type",
    "enum",
    "const",
    "properties",
    "additionalProperties",
    "required",
    "dependentRequired",
    "items",
    "minItems",
    "maxItems",
    "minimum",
    "maximum",
    "exclusiveMinimum",
    "exclusiveMaximum",
    "pattern",
    "allOf",
    "anyOf",
    "oneOf",
    "not",
    "if",
    "then",
    "else",
];

/// The words of `schema` and of all parts of it.
fn words(schema: &Value, found: &mut BTreeSet<String>) {
    for (word, said) in schema.as_object().into_iter().flatten() {
        found.insert(word.clone());
        match word.as_str() {
            "properties" | "$defs" => {
                said.as_object().unwrap().values().for_each(|part| words(part, found));
            }
            "allOf" | "anyOf" | "oneOf" => {
                said.as_array().unwrap().iter().for_each(|part| words(part, found));
            }
            "additionalProperties" | "items" | "not" | "if" | "then" | "else" => words(said, found),
            _ => {}
        }
    }
}

#[test]
fn the_schemas_have_no_word_that_nobody_checks() {
    let mut found = BTreeSet::new();
    NAMES.iter().for_each(|name| words(&schema(name), &mut found));
    let others: Vec<&String> = found.iter().filter(|word| !WORDS.contains(&&***word)).collect();
    assert!(others.is_empty() && found.len() > 15, "{others:?}");
}

#[test]
fn all_examples_are_as_their_schemas_say() {
    let (mut projects, mut edits, mut materials) = (0, 0, 0);
    for path in files("examples", ".toml") {
        let text = fs::read_to_string(root().join(&path)).unwrap();
        let is_project = text.lines().any(|line| line.starts_with("photo"));
        holds(if is_project { "project" } else { "edit" }, &from_toml(&text), &path);
        *(if is_project { &mut projects } else { &mut edits }) += 1;
        if is_project {
            assert!(Project::parse(Path::new(&path), &text).is_ok(), "{path} is not understood");
        } else {
            assert!(EditSheet::read(&root().join(&path)).is_ok(), "{path} is not understood");
        }
    }
    for path in files("examples", "truth.json") {
        let value = serde_json::from_str(&fs::read_to_string(root().join(&path)).unwrap()).unwrap();
        holds("materials", &value, &path);
        materials += 1;
    }
    assert!(projects >= 6 && edits >= 8 && materials >= 2, "{projects} {edits} {materials}");
}

/// The readers refuse what the schemas refuse, and the reverse.
#[test]
fn faults_are_faults_for_reader_and_schema() {
    let files = "scene = \"a.glb\"\nphoto = \"a.png\"\n";
    for fault in [
        "black_level = 0.6",
        "response = \"agfa\"",
        "response = { gamma = 0 }",
        "exposure = -1",
        "vignetting = { radial = [] }",
        "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]",
        "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov_y_deg = 180",
        "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfx = 500\nfy = 500\ncx = 320",
        "[camera]\nopencv = \"a.yml\"\ncolmap = \"sparse\"",
        "[camera]\nopencv = \"a.yml\"\nimage = \"a.jpg\"",
        "[camera]\ncolmap = \"sparse\"\nscene_from_world = \"x-up\"",
        "[anchor]\ngroup = \"wall\"",
        "[groups.wall]\nknown = {}",
        "[groups.wall]\nknown = { rho_d = 1.2 }",
        "[groups.wall]\nmax_rung = \"velvet\"",
        "[groups.wall]\nrungs = []",
        "[groups.wall]\nlike = 3",
        "[groups.wall]\nlike = { within = 0.1 }",
        "[groups.wall]\nlike = { group = \"floor\", within = 0 }",
        "[groups.wall]\nrho_d = {}",
        "[groups.wall]\nrho_s = { min = 1.2 }",
        "[groups.wall]\nalpha_x = { start = 0 }",
        "[groups.wall]\ntheta_deg = {}",
        "[groups.wall]\nrungs = [\"velvet\"]",
        "[recover]\nrungs = [\"diffuse\"]\nmax_rung = \"diffuse\"",
        "[lights.lamp]",
        "[[lights]]\nname = \"a\"\nadd = \"sphere\"\nposition = [0, 0, 0]\nstrength = 1",
        "[[lights]]\nname = \"a\"\nadd = \"point\"\nposition = [0, 0, 0]",
        "[[lights]]\nname = \"a\"\nadd = \"area\"\nposition = [0, 0, 0]\ndirection = [0, 1, 0]\nstrength = 1",
        "[environment]",
        "[environment]\ncolor = -1",
        "[environment]\ncolor = 1\nremove = true",
        "[recover]\nbrdf = \"phong\"",
        "[recover]\nthresholds = { explained = 0 }",
        "light_units = \"candela\"",
    ] {
        let text = format!("{files}{fault}");
        assert!(!faults("project", &from_toml(&text)).is_empty(), "the schema accepts {fault}");
        assert!(Project::parse(Path::new("a.toml"), &text).is_err(), "the reader accepts {fault}");
    }
}

#[test]
fn brackets_are_read_as_the_schema_says() {
    let project = |photo: &str| format!("scene = \"a.glb\"\nexposure = 1\nphoto = {photo}\n");
    for good in [
        "{ bracket = [\"a.jpg\", \"b.jpg\"] }",
        "{ bracket = [\"a.jpg\", \"b.jpg\"], times = [\"1/60\", 0.25] }",
    ] {
        holds("project", &from_toml(&project(good)), good);
        assert!(Project::parse(Path::new("a.toml"), &project(good)).is_ok(), "{good}");
    }
    for fault in [
        "3",
        "{}",
        "{ bracket = [] }",
        "{ bracket = [\"a.jpg\"] }",
        "{ bracket = [\"a.jpg\", 3] }",
        "{ bracket = [\"a.jpg\", \"b.jpg\"], times = [0, 1] }",
        "{ bracket = [\"a.jpg\", \"b.jpg\"], times = [-1, 1] }",
        "{ bracket = [\"a.jpg\", \"b.jpg\"], times = [\"soon\", 1] }",
        "{ bracket = [\"a.jpg\", \"b.jpg\"], time = 1 }",
    ] {
        let text = project(fault);
        assert!(!faults("project", &from_toml(&text)).is_empty(), "the schema accepts {fault}");
        assert!(Project::parse(Path::new("a.toml"), &text).is_err(), "the reader accepts {fault}");
    }
    let text = project("{ bracket = [], no_such_key = 1 }");
    let error = Project::parse(Path::new("a.toml"), &text).unwrap_err().to_string();
    assert_eq!(expected(&error), keys("project", "/$defs/bracket"));
}

/// The keys that an error about an unknown key lists.
fn expected(error: &str) -> BTreeSet<String> {
    let (_, list) = error
        .split_once("expected ")
        .unwrap_or_else(|| panic!("the error does not say what is expected: {error}"));
    let list = list.lines().next().unwrap_or_default();
    list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The keys of the object at `pointer` in the schema `name`.
fn keys(name: &str, pointer: &str) -> BTreeSet<String> {
    let schema = schema(name);
    let object = schema.pointer(pointer).unwrap_or_else(|| panic!("{name} has no {pointer}"));
    object["properties"].as_object().unwrap().keys().cloned().collect()
}

#[test]
fn schemas_of_projects_have_the_readers_keys() {
    let files = "scene = \"a.glb\"\nphoto = \"a.png\"\n";
    let lamp = "[[lights]]\nname = \"a\"\n";
    for (head, name, pointer) in [
        ("", "project", ""),
        ("[camera]\n", "project", "/$defs/camera"),
        ("[anchor]\n", "project", "/$defs/anchor"),
        ("[groups.a]\n", "project", "/$defs/group"),
        ("[groups.a.known]\n", "project", "/$defs/known"),
        ("[groups.a.like]\n", "project", "/$defs/like"),
        ("[groups.a.rho_s]\n", "project", "/$defs/expected_reflectance"),
        ("[groups.a.alpha_x]\n", "project", "/$defs/expected_roughness"),
        ("[groups.a.theta_deg]\n", "project", "/$defs/expected_direction"),
        ("[lights.a]\n", "project", "/$defs/unknown_light"),
        ("[recover]\n", "project", "/$defs/recover"),
        ("[recover.thresholds]\n", "project", "/$defs/thresholds"),
        (lamp, "lighting", "/$defs/light"),
        ("[environment]\n", "lighting", "/$defs/environment"),
    ] {
        let text = format!("{files}{head}no_such_key = 1\n");
        let error = Project::parse(Path::new("a.toml"), &text).unwrap_err().to_string();
        let readers = if pointer == "/$defs/thresholds" {
            let (_, list) = error.split_once("there are ").unwrap();
            let words = list.replace("and for the paper's ladder ", "");
            words.split(", ").map(|word| word.trim().to_owned()).collect()
        } else {
            expected(&error)
        };
        assert_eq!(readers, keys(name, pointer), "{name}{pointer}");
    }
}

#[test]
fn schemas_of_edits_have_the_readers_keys() {
    let place = tempfile::tempdir().unwrap();
    let scene = root().join("examples/fig8/scene.glb");
    for (head, name, pointer) in [
        ("", "edit", ""),
        ("[[remove]]\n", "edit", "/$defs/remove"),
        ("[[repaint]]\n", "edit", "/$defs/repaint"),
        ("[[insert]]\n", "edit", "/$defs/insert"),
        ("[[insert]]\nfile = \"a.glb\"\n[[insert.material]]\n", "edit", "/$defs/material"),
        ("[[lights]]\nname = \"a\"\n", "lighting", "/$defs/light"),
        ("[environment]\n", "lighting", "/$defs/environment"),
        ("[camera]\n", "edit", "/$defs/camera"),
        ("[[camera.keys]]\n", "edit", "/$defs/key"),
    ] {
        let file = place.path().join("edit.toml");
        let scene = format!("scene = {scene:?}\n");
        let scene = if head.is_empty() { "" } else { &scene };
        fs::write(&file, format!("{scene}{head}no_such_key = 1\n")).unwrap();
        let error = match EditSheet::read(&file) {
            Err(error) => error.to_string(),
            Ok(sheet) => Restaging::load(vec![sheet]).unwrap_err().to_string(),
        };
        let mut readers = expected(&error);
        // One reader has both, and refuses the key of the other with its own message.
        match pointer {
            "/$defs/repaint" => _ = readers.remove("name"),
            "/$defs/material" => _ = readers.remove("group"),
            _ => {}
        }
        assert_eq!(readers, keys(name, pointer), "{name}{pointer}");
    }
}

/// Every key of `value` is in the schema: `additionalProperties` are maps by name, nothing else.
fn assert_known(name: &str, schema_at: &Value, value: &Value, place: &str) {
    let (name, schema_at) = follow(name, schema_at);
    match value {
        Value::Object(map) => {
            let all = properties(&name, &schema_at);
            for (key, value) in map {
                let place = format!("{place}/{key}");
                let (name, of_key) = match (all.get(key), schema_at.get("additionalProperties")) {
                    (Some((name, of_key)), _) => (name.clone(), of_key.clone()),
                    (None, Some(of_key)) if of_key.is_object() => (name.clone(), of_key.clone()),
                    _ => panic!("the schema {name} lacks {place}"),
                };
                assert_known(&name, &of_key, value, &place);
            }
        }
        Value::Array(list) => {
            let of_item = schema_at.get("items").cloned().unwrap_or(json!({}));
            list.iter().for_each(|item| assert_known(&name, &of_item, item, place));
        }
        _ => {}
    }
}

/// The target of the reference of `at`, with the name of its schema.
pub(crate) fn target(name: &str, at: &Value) -> Option<(String, Value)> {
    let (file, pointer) = at.get("$ref")?.as_str()?.split_once('#')?;
    let name = file.strip_suffix(".schema.json").unwrap_or(name);
    Some((name.to_owned(), schema(name).pointer(pointer).cloned()?))
}

/// The target of all references of `at`, ignoring the null of an `oneOf`.
fn follow(name: &str, at: &Value) -> (String, Value) {
    if let Some((name, at)) = target(name, at) {
        return follow(&name, &at);
    }
    let is_null = |choice: &&Value| choice["type"] == "null";
    match at.get("oneOf").and_then(Value::as_array).map(Vec::as_slice) {
        Some([first, second]) if is_null(&second) => follow(name, first),
        _ => (name.to_owned(), at.clone()),
    }
}

/// The properties of an object, those of `allOf` too, each with the schema that contains it.
fn properties(name: &str, at: &Value) -> std::collections::BTreeMap<String, (String, Value)> {
    let mut all = std::collections::BTreeMap::new();
    for part in at.get("allOf").and_then(Value::as_array).into_iter().flatten() {
        let (name, part) = follow(name, part);
        all.extend(properties(&name, &part));
    }
    let own = at.get("properties").and_then(Value::as_object).cloned().unwrap_or(Map::new());
    all.extend(own.into_iter().map(|(key, of_key)| (key, (name.to_owned(), of_key))));
    all
}

/// A run in which all fields are set.
fn filled_run() -> Run {
    let place = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..9).map(|index| format!("group {index}")).collect();
    let mut run = synthetic::write(place.path(), &names, (64, 48));
    run.input.environment = Some("sky.hdr".into());
    run.environment = Some(EnvironmentEntry {
        panorama: Some("environment.exr".into()),
        rotation_deg: 70.0,
        radiance: [0.3, 0.2, 0.1],
    });
    run.input.bracket = vec!["a.jpg".into(), "b.jpg".into()];
    run.input.up_axis = unrender::scene::UpAxis::Z;
    run.registration.camera = json!({
        "eye": [0.0, 1.6, 4.0], "target": [0.0, 1.2, 0.0], "up": [0.0, 1.0, 0.0],
        "fov_y_deg": 40.0, "principal_point": [0.0, 0.0], "k1": 0.0, "k2": 0.0,
    });
    run.photographs = vec![PhotographRun {
        photo: "a.jpg".into(),
        photograph: run.photograph.clone(),
        lights_off: vec!["lamp".into()],
        registration: run.registration.clone(),
        pixels: run.pixels,
        pictures: run.pictures.clone(),
        ..PhotographRun::default()
    }];
    run
}

#[test]
fn what_is_written_is_as_the_schemas_say() {
    let run = filled_run();
    let value: Value = serde_json::from_str(&run.to_text().unwrap()).unwrap();
    holds("run", &value, "a synthetic run.json");
    assert_known("run", &schema("run"), &value, "");
    let materials = unrender::formats::materials::MaterialsFile {
        version: Some(1),
        brdf: Some("ggx".into()),
        exposure: Some([1.0; 3]),
        groups: run
            .groups
            .iter()
            .map(|(name, group)| (name.clone(), group.entry.clone()))
            .collect(),
        lights: run.lights.clone(),
        photograph: run.photograph.clone(),
        photographs: vec![run.photograph.clone().unwrap()],
        seconds: Some(1.0),
        termination: Some("ended".into()),
    };
    let value = serde_json::to_value(materials).unwrap();
    holds("materials", &value, "a synthetic materials.json");
    assert_known("materials", &schema("materials"), &value, "");
}

#[test]
fn the_schemas_have_no_key_that_is_never_written() {
    let run = filled_run();
    let text = run.to_text().unwrap();
    // These are seldom written: they are left out if they have no content.
    for name in ["materials", "run"] {
        for key in all_keys(&schema(name)) {
            let seldom = ["termination", "seconds"].contains(&key.as_str());
            assert!(
                seldom || text.contains(&format!("\"{key}\":")),
                "{name}: {key} is never written"
            );
        }
    }
}

/// The names of all properties at any depth.
fn all_keys(at: &Value) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    match at {
        Value::Object(map) => {
            for (key, value) in map {
                if let ("properties", Value::Object(properties)) = (key.as_str(), value) {
                    all.extend(properties.keys().cloned());
                }
                all.extend(all_keys(value));
            }
        }
        Value::Array(list) => list.iter().for_each(|item| all.extend(all_keys(item))),
        _ => {}
    }
    all
}
