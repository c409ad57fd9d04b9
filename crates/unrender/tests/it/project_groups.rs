//! The statements of a project about the parameters of groups: bounds, initial values, and which
//! groups are alike.

use crate::kit::project_text::{are_refused, good};
use glam::Vec3;
use std::path::Path;
use unrender::formats::picture::{Depth, Picture};
use unrender::job::InMemory;
use unrender::recover::Expected;
use unrender::scene::{Group, Image, Material, Mesh, Object, Rgb, Scene, Ungrouped};
use unrender::{Job, Project};

#[test]
fn bounds_and_starts_are_understood() {
    let project = good(
        "[groups.sofa]\nrho_d = { start = [0.4, 0.3, 0.2], max = 0.6 }\nrho_s = { max = 0.1 }\n\
         alpha_x = { start = 0.1, min = 0.02 }\ntheta_deg = { start = 180 }\n",
    );
    let Expected { bounds, start, .. } = project.expected["sofa"];
    assert_eq!(start.rho_d, Some(Rgb::new(0.4, 0.3, 0.2)));
    assert_eq!((start.rho_s, start.alpha_x, start.alpha_y), (None, Some(0.1), None));
    assert_eq!(start.theta_rad, Some(std::f32::consts::PI));
    assert_eq!(bounds.rho_d, [Rgb::ZERO, Rgb::splat(0.6)]);
    assert_eq!(
        (bounds.rho_s[1], bounds.alpha_x, bounds.alpha_y[0]),
        (Rgb::splat(0.1), [0.02, 1.0], 0.005)
    );
    assert!(good("").expected.is_empty());
}

#[test]
fn faults_of_bounds_and_starts_name_their_key() {
    are_refused(&[
        ("[groups.a]\nrho_d = 0.4", "line 4: invalid type"),
        ("[groups.a]\nrho_d = { star = 0.4 }", "line 4: unknown field `star`"),
        ("[groups.a]\nrho_d = {}", "groups.a.rho_d: give start, min or max"),
        ("[groups.a]\nrho_d = { max = 1.2 }", "groups.a.rho_d.max is 1.2; a reflectance is from"),
        ("[groups.a]\nrho_d = { min = nan }", "groups.a.rho_d.min is nan"),
        (
            "[groups.a]\nrho_s = { min = [0, 0.3, 0], max = 0.2 }",
            "groups.a.rho_s: min is above max",
        ),
        ("[groups.a]\nrho_s = { start = 0.3, max = 0.2 }", "groups.a.rho_s: start lies beyond max"),
        ("[groups.a]\nalpha_x = { start = 0.01, min = 0.02 }", "alpha_x: start lies beyond min"),
        ("[groups.a]\nalpha_x = { min = 0 }", "groups.a.alpha_x.min is 0; an unknown roughness is"),
        ("[groups.a]\nalpha_y = { max = 2 }", "groups.a.alpha_y.max is 2; an unknown roughness is"),
        ("[groups.a]\ntheta_deg = { start = inf }", "groups.a.theta_deg.start is inf; give an"),
        ("[groups.a]\ntheta_deg = { start = 1, min = 0 }", "line 4: unknown field `min`"),
        (
            "[groups.a]\nalpha_x = { min = 0.3 }\nalpha_y = { max = 0.2 }",
            "groups.a: alpha_x.min is above alpha_y.max, but alpha_x is the lesser",
        ),
        (
            "[groups.a]\nalpha_x = { start = 0.3 }\nalpha_y = { start = 0.2 }",
            "exchange them, and turn theta_deg by 90",
        ),
        (
            "[groups.a]\nrho_d = { min = 0.7 }\nrho_s = { min = 0.4 }",
            "groups.a: rho_d.min and rho_s.min together are above 1, more than ward-gmd reflects",
        ),
        (
            "[groups.a]\nmax_rung = \"diffuse\"\nalpha_x = { min = 0.02 }",
            "groups.a.alpha_x: none of the hypotheses that the group may have (diffuse) has it; \
             it belongs to isotropic, anisotropic",
        ),
        (
            "[recover]\nmax_rung = \"diffuse\"\n[groups.a]\nrho_s = { max = 0.2 }",
            "groups.a.rho_s: none of the hypotheses",
        ),
        (
            "[groups.a]\nrungs = [\"diffuse\", \"isotropic\"]\nrho_s = { min = 0.1 }\n\
             alpha_x = { max = 0.1 }\n[groups.b]\nrungs = [\"isotropic\"]\nalpha_x = { max = 0.1 }\n\
             rho_s = { max = 0 }",
            "groups.b: none of the hypotheses that the group may have (isotropic) can keep its bounds",
        ),
        (
            "[groups.a]\nignore = true\nrho_d = { max = 0.5 }",
            "with ignore = true nothing is recovered",
        ),
        (
            "[groups.a]\nknown = { rho_d = 0.5 }\nrho_d = { max = 0.6 }",
            "groups.a: with known nothing is recovered; leave out rho_d",
        ),
        ("[groups.a]\nsame_as = \"b\"\nrho_d = { max = 0.5 }", "rho_d belongs to groups.b"),
        (
            "[groups.a]\nrho_d = { max = 0.5 }\n[anchor]\ngroup = \"a\"\nrho_d = 0.4",
            "groups.a: [anchor] states its reflectance; leave out rho_d",
        ),
    ]);
}

#[test]
fn groups_are_like_others() {
    let project =
        good("[groups.a]\nlike = \"b\"\n[groups.b]\nlike = { group = \"c\", within = 0.25 }\n");
    assert_eq!((project.like["a"].group.as_str(), project.like["a"].within), ("b", 0.1));
    assert_eq!((project.like["b"].group.as_str(), project.like["b"].within), ("c", 0.25));
}

#[test]
fn faults_of_likeness_name_their_key() {
    are_refused(&[
        ("[groups.a]\nlike = 3", "line 4: invalid type: integer `3`, expected the name of a group"),
        ("[groups.a]\nlike = { group = \"b\", width = 1 }", "line 4: unknown field `width`"),
        ("[groups.a]\nlike = { within = 0.1 }", "line 4: missing field `group`"),
        ("[groups.a]\nlike = { group = \"b\", within = 0 }", "groups.a.like: within is 0; give a"),
        ("[groups.a]\nlike = { group = \"b\", within = nan }", "groups.a.like: within is NaN"),
        ("[groups.a]\nlike = \"a\"", "groups.a.like: it names the group itself"),
        (
            "[groups.a]\nlike = \"b\"\n[groups.b]\nlike = \"a\"",
            "groups.a.like: groups.b is like \"a\" already; state it for one of the two",
        ),
        (
            "[groups.a]\nlike = \"b\"\n[groups.b]\nsame_as = \"c\"",
            "groups.a.like: groups.b has same_as = \"c\"; name that one",
        ),
        (
            "[groups.a]\nlike = \"b\"\n[groups.b]\nignore = true",
            "groups.a.like: groups.b has ignore = true; name another group",
        ),
        ("[groups.a]\nlike = \"b\"\nknown = { rho_d = 1 }", "the group itself is not recovered"),
        ("[groups.a]\nlike = \"b\"\nsame_as = \"c\"", "like belongs to groups.c"),
        (
            "[groups.a]\nlike = \"b\"\n[anchor]\ngroup = \"a\"\nrho_d = 0.4",
            "groups.a.like: the group itself is not recovered",
        ),
    ]);
}

#[test]
fn names_are_checked_against_the_scene() {
    let group = |name: &str, emission| Group {
        name: name.into(),
        material: Material::diffuse(Rgb::ONE),
        emission,
    };
    let groups = vec![group("wall", Rgb::ZERO), group("lamp", Rgb::ONE)];
    let scene = Scene { groups, ..Scene::default() };
    let pane = Ungrouped { material: "pane".into(), mesh: Mesh::default(), glass: None };
    let scene = Scene { ungrouped: vec![pane], ..scene };
    let error = |text: &str| good(text).check_against(&scene).unwrap_err().to_string();
    for (text, problem) in [
        ("[groups.pane]\nrho_d = { max = 0.5 }", "groups.pane: \"pane\" is glass"),
        ("[groups.lamp]\nrho_d = { max = 0.5 }", "groups.lamp: the group emits light"),
        (
            "[groups.floor]\nrho_d = { max = 0.5 }",
            "groups.floor: the scene has no group \"floor\"; it has wall, lamp",
        ),
        (
            "[groups.wall]\nlike = \"floor\"",
            "groups.wall.like: the scene has no group \"floor\"; it has wall, lamp",
        ),
        ("[groups.wall]\nlike = \"lamp\"", "groups.wall.like: one of the two emits light"),
    ] {
        let told = error(text);
        assert!(told.contains(problem), "{text}: {told}");
    }
}

/// A lamp that is ignored shines, and what is known beside it is there; other ignored things take no part in the light.
#[test]
fn ignored_groups_take_no_part_in_the_light() {
    let group = |name: &str, emission| Group {
        name: name.into(),
        material: Material::diffuse(Rgb::splat(0.5)),
        emission,
    };
    let names = ["wall", "passer-by", "stand", "lamp"];
    let square = |index: usize| {
        let z = index as f32;
        let corners = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)].map(|p| p + z * Vec3::Z);
        let mesh = Mesh::flat(&corners, &[], &[[0, 1, 2]]);
        Object { name: names[index].into(), group: index, mesh }
    };
    let emissions = [Rgb::ZERO, Rgb::ZERO, Rgb::ZERO, Rgb::ONE];
    let scene = Scene {
        objects: (0..4).map(square).collect(),
        groups: names.iter().zip(emissions).map(|(name, emission)| group(name, emission)).collect(),
        ..Scene::default()
    };
    let text = "scene = \"s.glb\"\nphoto = \"p.png\"\nexposure = 1\n\
                camera = { eye = [0,0,9], target = [0,0,0], fov_y_deg = 40 }\n\
                [groups.passer-by]\nignore = true\n[groups.lamp]\nignore = true\n\
                [groups.stand]\nignore = true\nknown = { rho_d = 0.2 }\n";
    let (project, warnings) = Project::parse(Path::new("a.toml"), text).unwrap();
    let photo = Picture::new(Image::new(4, 4, vec![Rgb::splat(0.5); 16]), Depth::Float);
    let given = InMemory { scene: Some(scene), photo: Some(photo), mask: None };
    let job = Job::assemble(project, warnings, given).unwrap();
    let there: Vec<&str> = job.scene.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(there, ["wall", "stand", "lamp"]);
    assert_eq!(job.scene.ungrouped_materials(), ["passer-by"]);
    assert_eq!(job.scene.ungrouped[0].glass, None);
    assert_eq!(job.scene.groups.len(), 4);
}
