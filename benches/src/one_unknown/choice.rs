//! The choice of the groups to recover, and a check that the truth has the others.

use std::path::Path;
use unrender::Project;
use unrender::formats::materials::MaterialsFile;
use unrender::scene::Group;

/// The status of a group in the project.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// The project recovers it.
    Asked,
    /// The project knows it: it is recovered only if it is named.
    Known,
    /// It cannot be recovered, and needs no truth; with the reason, the end of a sentence about it.
    Fixed(&'static str),
}

/// A group of the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Candidate {
    /// Its name.
    pub(super) name: String,
    /// Its status in the project.
    pub(super) standing: Standing,
}

/// All `groups` of a scene with their status in `project`, in the scene's order.
pub(super) fn candidates(project: &Project, groups: &[Group]) -> Vec<Candidate> {
    let anchor = project.used_anchor().map(|anchor| &anchor.group);
    let standing = |group: &Group| {
        if group.is_emitter() {
            Standing::Fixed("emits light")
        } else if project.ignored.contains(&group.name) {
            Standing::Fixed("is ignored by the project")
        } else if project.same_as.contains_key(&group.name) {
            Standing::Fixed("has one material with another (same_as); name that one")
        } else if anchor == Some(&group.name) {
            Standing::Fixed("is the anchor, which fixes the scale of light and exposure")
        } else if project.known.contains_key(&group.name) {
            Standing::Known
        } else {
            Standing::Asked
        }
    };
    let candidate =
        |group: &Group| Candidate { name: group.name.clone(), standing: standing(group) };
    groups.iter().map(candidate).collect()
}

/// The indices of the groups to recover: those that are `named`, or else those that the project
/// recovers.
///
/// # Errors
/// If there is no group of a name, if a named group cannot be recovered, or if there is no group to
/// recover.
pub(super) fn choose(candidates: &[Candidate], named: &[String]) -> Result<Vec<usize>, String> {
    if named.is_empty() {
        let is_asked = |index: &usize| candidates[*index].standing == Standing::Asked;
        let asked: Vec<usize> = (0..candidates.len()).filter(is_asked).collect();
        let none = "the project recovers no group; name the groups to recover with --groups";
        return if asked.is_empty() { Err(none.to_owned()) } else { Ok(asked) };
    }
    let mut chosen = Vec::new();
    for name in named {
        let index = candidates.iter().position(|candidate| candidate.name == *name);
        let Some(index) = index else {
            return Err(format!(
                "--groups: the scene has no group \"{name}\"; those that can be recovered are {}",
                names(candidates.iter().filter(|candidate| is_held(candidate)))
            ));
        };
        if let Standing::Fixed(why) = candidates[index].standing {
            return Err(format!("--groups: the group \"{name}\" {why}, and cannot be recovered"));
        }
        if !chosen.contains(&index) {
            chosen.push(index);
        }
    }
    Ok(chosen)
}

/// Refuses a `truth`, read from `file`, without the reflectance of each group of `project`.
///
/// # Errors
/// If a group that is recovered or held has no entry there, or an entry without diffuse reflectance.
pub(super) fn check_truth(
    candidates: &[Candidate],
    (truth, file): (&MaterialsFile, &Path),
    project: &Path,
) -> Result<(), String> {
    let says = |candidate: &&Candidate| {
        let entry = truth.groups.get(&candidate.name);
        entry.is_some_and(|entry| entry.rho_d.is_some() || entry.texture.is_some())
    };
    let missing = candidates.iter().filter(|c| is_held(c) && !says(c));
    let missing = names(missing);
    if missing.is_empty() {
        return Ok(());
    }
    Err(format!(
        "{}: no rho_d or texture is stated for {missing}, which {} has; add the true material of \
         every group, or set ignore = true for it in the project",
        file.display(),
        project.display()
    ))
}

/// Whether a group is recovered or held at the truth.
fn is_held(candidate: &Candidate) -> bool {
    !matches!(candidate.standing, Standing::Fixed(_))
}

/// The names of `candidates`, in quotation marks.
fn names<'a>(candidates: impl Iterator<Item = &'a Candidate>) -> String {
    let names: Vec<String> = candidates.map(|c| format!("\"{}\"", c.name)).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender::formats::materials::GroupEntry;
    use unrender::scene::{Material, Rgb};

    /// The groups floor, wall and ceiling and a lamp, in a project with the lines `text`.
    fn of_project(text: &str) -> Vec<Candidate> {
        let text = format!("scene = \"s.glb\"\nphoto = \"p.exr\"\nexposure = 1\n{text}");
        let (project, _) = Project::parse(Path::new("p.toml"), &text).unwrap();
        let groups = ["floor", "wall", "ceiling", "lamp"].map(|name| Group {
            name: name.to_owned(),
            material: Material::diffuse(Rgb::splat(0.5)),
            emission: if name == "lamp" { Rgb::ONE } else { Rgb::ZERO },
        });
        candidates(&project, &groups)
    }

    fn truth(names: &[&str]) -> MaterialsFile {
        let mut file = MaterialsFile::default();
        for name in names {
            let entry = GroupEntry { rho_d: Some([0.5; 3]), ..GroupEntry::default() };
            file.groups.insert((*name).to_owned(), entry);
        }
        file
    }

    fn chosen(candidates: &[Candidate], named: &[&str]) -> Result<Vec<usize>, String> {
        choose(candidates, &named.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn what_the_project_knows_is_asked_only_by_name() {
        let all = of_project("[groups.wall]\nknown = { rho_d = 0.5 }\n");
        assert_eq!(chosen(&all, &[]), Ok(vec![0, 2]));
        assert_eq!(chosen(&all, &["wall", "floor", "wall"]), Ok(vec![1, 0]));
        let ignored = of_project("[groups.ceiling]\nignore = true\n");
        assert_eq!(chosen(&ignored, &[]), Ok(vec![0, 1]));
    }

    #[test]
    fn groups_that_are_not_there_or_cannot_be_asked_are_refused() {
        let all = of_project("[groups.ceiling]\nignore = true\n");
        let fault = chosen(&all, &["flor"]).unwrap_err();
        assert!(fault.contains("no group \"flor\""), "{fault}");
        assert!(fault.ends_with("are \"floor\", \"wall\""), "{fault}");
        let fault = chosen(&all, &["lamp"]).unwrap_err();
        assert!(fault.contains("\"lamp\" emits light"), "{fault}");
        let fault = chosen(&all, &["ceiling"]).unwrap_err();
        assert!(fault.contains("is ignored"), "{fault}");
        let known = ["floor", "wall", "ceiling"]
            .map(|name| format!("[groups.{name}]\nknown = {{ rho_d = 0.5 }}\n"));
        let fault = chosen(&of_project(&known.concat()), &[]).unwrap_err();
        assert!(fault.contains("--groups"), "{fault}");
    }

    #[test]
    fn a_truth_that_misses_a_group_is_refused() {
        let all = of_project("[groups.ceiling]\nignore = true\n");
        let check = |truth: &MaterialsFile| {
            check_truth(&all, (truth, Path::new("truth.json")), Path::new("p.toml"))
        };
        assert_eq!(check(&truth(&["floor", "wall"])), Ok(()));
        let fault = check(&truth(&["floor", "door"])).unwrap_err();
        assert!(fault.starts_with("truth.json: no rho_d"), "{fault}");
        assert!(fault.contains("\"wall\", which p.toml has"), "{fault}");
        let mut empty = truth(&["floor", "wall"]);
        empty.groups.insert("floor".to_owned(), GroupEntry::default());
        assert!(check(&empty).unwrap_err().contains("\"floor\""));
    }

    #[test]
    fn the_anchor_and_what_shares_a_material_are_not_asked() {
        let text = "[groups.floor]\nsame_as = \"wall\"\n";
        assert_eq!(chosen(&of_project(text), &[]), Ok(vec![1, 2]));
        let text = "scene = \"s.glb\"\nphoto = \"p.exr\"\nexposure = \"auto\"\n\
            [anchor]\ngroup = \"wall\"\nrho_d = 0.5\n";
        let (project, _) = Project::parse(Path::new("p.toml"), text).unwrap();
        let material = Material::diffuse(Rgb::splat(0.5));
        let wall = Group { name: "wall".to_owned(), material, emission: Rgb::ZERO };
        let fault = chosen(&candidates(&project, &[wall]), &["wall"]).unwrap_err();
        assert!(fault.contains("is the anchor"), "{fault}");
    }
}
