//! Measured BRDFs by the command: what it prints is a project's known material, what it writes is read back.

use crate::kit::example::beside_crates;
use crate::kit::folder::{Folder, is_refused, succeeds};
use std::f32::consts::PI;
use std::path::Path;
use unrender::Project;
use unrender::formats::{materials, merl, picture};
use unrender::scene::{BrdfModel, Hypothesis, MeasuredBrdf, Rgb};

const BASE: Rgb = Rgb::new(0.3, 0.15, 0.06);

/// GGX of roughness 0.2 with the masking of Smith [Heitz 2014], of reflectance 0.1, over a base.
fn table(counts: [usize; 3]) -> MeasuredBrdf {
    MeasuredBrdf::from_fn(counts, |wo, wi| {
        let below = (wo + wi).normalize().z.powi(2) * (0.04 - 1.0) + 1.0;
        let lambda = |z: f32| 0.5 * ((1.0 + 0.04 * (1.0 / (z * z) - 1.0)).sqrt() - 1.0);
        let masked = 1.0 / (1.0 + lambda(wo.z) + lambda(wi.z)) / (4.0 * wo.z * wi.z).abs();
        BASE / PI + Rgb::splat(0.1 * 0.04 / (PI * below * below) * masked)
    })
    .unwrap()
}

fn folder() -> Folder {
    let folder = Folder::new();
    merl::write(&folder.path("car paint.binary"), &table([30, 10, 6])).unwrap();
    folder
}

/// The known material of `group` in the project file of these lines.
fn material(lines: &str, group: &str) -> unrender::scene::Material {
    let text = format!("scene = \"a.glb\"\nphoto = \"a.png\"\nexposure = 1\n{lines}");
    let (project, _) = Project::parse(Path::new("a.toml"), &text).unwrap();
    let model = project.brdf.unwrap();
    project.known[group].material(model).unwrap()
}

#[test]
fn the_lines_that_are_printed_are_a_known_material() {
    let folder = folder();
    let run = folder.run(&["fit-brdf", "car paint.binary", "--model", "ggx", "--out", "car"]);
    let printed = succeeds(&run);
    let (table, lines) = printed.split_once("\n\n").unwrap();
    assert!(table.contains("*  ggx   isotropic"), "{table}");
    let stated = material(lines, "car paint");
    assert!((stated.alpha_x - 0.2).abs() < 2e-3, "{stated:?}");
    assert!((stated.rho_d / BASE - 1.0).abs().max_element() < 0.01, "{stated:?}");
    assert_eq!(folder.text("car/known.toml"), lines);

    let found = materials::read(&folder.path("car/materials.json")).unwrap();
    let group = &found.groups["car paint"];
    assert_eq!(
        (found.brdf.as_deref(), group.hypothesis),
        (Some("ggx"), Some(Hypothesis::Isotropic))
    );
    let rounded = (group.alpha_x.unwrap() - stated.alpha_x).abs();
    assert!(rounded < 1e-4 * stated.alpha_x, "{rounded}");
    let spheres = picture::read(&folder.path("car/fits.png")).unwrap().0;
    assert_eq!((spheres.values.width(), spheres.values.height()), (3 * 128, 2 * 128));
}

#[test]
fn all_models_are_compared_and_every_one_can_be_stated() {
    let folder = folder();
    for model in ["principled", "ward-gmd", "ward-1992", "ward-duer"] {
        let group = ["--group", "a \"quoted\" one"];
        let run =
            folder.run(&[&["fit-brdf", "car paint.binary", "--model", model], &group[..]].concat());
        let printed = succeeds(&run);
        let stated = material(printed.split_once("\n\n").unwrap().1, "a \"quoted\" one");
        assert!(stated.rho_d.max_element() <= 1.0, "{stated:?}");
    }
    let run = folder.run(&["fit-brdf", "car paint.binary", "--json", "--out", "fits.json"]);
    assert_eq!(succeeds(&run), folder.text("fits.json"));
    let json: serde_json::Value = serde_json::from_str(&folder.text("fits.json")).unwrap();
    assert_eq!(json["cells"], serde_json::json!([30, 10, 6]));
    assert_eq!(json["measured"], 1800);
    let fits = json["fits"].as_array().unwrap();
    let models: std::collections::BTreeSet<_> =
        fits.iter().map(|fit| fit["brdf"].as_str().unwrap()).collect();
    assert_eq!(models, BrdfModel::ALL.map(BrdfModel::name).into_iter().collect());
    let error = |index: usize| fits[index]["error"].as_f64().unwrap();
    let least = (0..fits.len()).map(error).fold(f64::INFINITY, f64::min);
    assert!(error(json["chosen"].as_u64().unwrap() as usize) <= 1.02 * least);
}

#[test]
fn what_is_no_table_is_refused_in_words() {
    let folder = folder();
    let bytes = folder.bytes("car paint.binary");
    folder.write("short.binary", &bytes[..1000]);
    folder.write("text.binary", "theta_h,theta_d,phi_d,red\n");
    folder.write(
        "none.binary",
        &merl::to_bytes(&MeasuredBrdf::from_fn([4, 4, 4], |_, _| Rgb::NEG_ONE).unwrap()),
    );
    for (words, problem) in [
        (
            "short.binary",
            "short.binary: is cut short: 30 x 10 x 6 cells need 43212 bytes, and it has 1000",
        ),
        ("text.binary", "MERL's binary format"),
        ("none.binary", "only 0 of 64 cells"),
        ("missing.binary", "does not exist"),
        (". --json", "is not a regular file"),
        ("short.binary --model blinn", "unknown brdf \"blinn\""),
    ] {
        let words: Vec<&str> = std::iter::once("fit-brdf").chain(words.split(' ')).collect();
        is_refused(&folder.run(&words), problem);
    }
    folder.write("kept.json", "{}");
    let own = ["fit-brdf", "kept.json", "--out", "kept.json"];
    is_refused(&folder.run(&own), "is an input of this run");
}

/// The groups of Figure 8 after a project in `folder` has stated `known` of the group `floor`.
fn with_known(folder: &Folder, known: &str) -> Result<unrender::Job, String> {
    let example = |name: &str| beside_crates("examples/fig8").join(name).display().to_string();
    let text = format!(
        "scene = {:?}\nphoto = {:?}\nresponse = \"srgb\"\nexposure = 1\n[groups.floor]\nknown = {known}\n",
        example("scene.glb"),
        example("photo.png")
    );
    let path = folder.write("project.toml", &text);
    let (project, warnings) = Project::read(&path).map_err(|error| error.to_string())?;
    unrender::Job::load(project, warnings).map_err(|error| error.to_string())
}

#[test]
fn a_project_may_name_the_table_or_a_materialx_file() {
    let folder = folder();
    let text = "<materialx version=\"1.39\"><open_pbr_surface name=\"s\" type=\"surfaceshader\">\
        <input name=\"base_color\" type=\"color3\" value=\"0.3, 0.2, 0.1\"/></open_pbr_surface>\
        <surfacematerial name=\"Oak\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" \
        nodename=\"s\"/></surfacematerial></materialx>";
    folder.write("wood.mtlx", text);
    let floor = |job: &unrender::Job| {
        let index = job.scene.group_index("floor").unwrap();
        job.scene.groups[index].material.clone()
    };
    let job = with_known(&folder, "{ measured = \"car paint.binary\" }").unwrap();
    let told = job.warnings.0.iter().any(|warning| warning.contains("fits it best"));
    assert!(told && floor(&job).alpha_x > 0.1, "{:?}", job.warnings);
    let job = with_known(&folder, "{ materialx = \"wood.mtlx\", material = \"Oak\" }").unwrap();
    assert_eq!(floor(&job).rho_d, Rgb::new(0.3, 0.2, 0.1));
    for (known, problem) in [
        ("{ materialx = \"wood.mtlx\" }", "has no material \"floor\"; its materials are \"Oak\""),
        ("{ materialx = \"missing.mtlx\" }", "known: there is no file"),
        ("{ measured = \"wood.mtlx\" }", "MERL's binary format"),
        ("{ measured = \"car paint.binary\", rho_d = 0.5 }", "leave out the numbers"),
        ("{ material = \"Oak\" }", "name the file by materialx"),
        ("{ materialx = \"wood.mtlx\", measured = \"car paint.binary\" }", "not both"),
        ("{ }", "give rho_d or rho_s or both, or a file"),
    ] {
        let said = with_known(&folder, known).err().unwrap();
        assert!(said.contains(problem), "{problem}: {said}");
    }
}
