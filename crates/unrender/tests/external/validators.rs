//! Exports, checked by the validators of their formats.

use crate::kit::export_scene::{exported, exported_as, scene};
use crate::kit::programs::{installed, need};
use glam::{Vec2, Vec3};
use std::process::Command;
use std::sync::Arc;
use unrender::formats::export::Target;
use unrender::formats::material_file;
use unrender::scene::{
    BrdfModel, Coverage, Detail, Glass, Image, Mapped, Material, NormalMap, Rgb, Scene, Ungrouped,
    Wrap,
};

const VALIDATE_GLTF: &str = "
const validator = require(process.argv[1] + '/node_modules/gltf-validator');
const bytes = new Uint8Array(require('fs').readFileSync(process.argv[2]));
validator.validateBytes(bytes).then(report => {
    console.log(JSON.stringify(report.issues));
    process.exitCode = report.issues.numErrors + report.issues.numWarnings > 0 ? 1 : 0;
});
";

#[test]
#[ignore = "slow: needs the glTF validator, which .ci/programs installs"]
fn khronos_validator_finds_nothing_wrong_with_gltf() {
    let Some(validator) = need(installed("gltf-validator")) else { return };
    let (_folder, path) = exported(&scene(), Target::Gltf);
    let mut node = Command::new("node");
    let report = node.args(["-e", VALIDATE_GLTF]).arg(validator).arg(path).output().unwrap();
    let said = String::from_utf8_lossy(&report.stdout).into_owned();
    assert!(report.status.success(), "{said} {}", String::from_utf8_lossy(&report.stderr));
}

const VALIDATE_MATERIALX: &str = "
import sys, MaterialX
document = MaterialX.createDocument()
libraries = MaterialX.createDocument()
MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), libraries)
MaterialX.readFromXmlFile(document, sys.argv[1])
document.setDataLibrary(libraries)
valid, message = document.validate()
names = [m.getAttribute('doc') for m in document.getNodes('standard_surface')]
print(message, names)
sys.exit(0 if valid and len(names) == int(sys.argv[2]) else 1)
";

#[test]
#[ignore = "slow: needs MaterialX, which .ci/programs installs"]
fn materialx_is_valid() {
    let Some(folder) = need(installed("materialx")) else { return };
    let (_folder, path) = exported(&scene(), Target::Materialx);
    let mut command = Command::new(folder.join("bin/python"));
    command.args(["-c", VALIDATE_MATERIALX]).arg(path.join("materials.mtlx"));
    let report = command.arg(scene().groups.len().to_string()).output().unwrap();
    let said = String::from_utf8_lossy(&report.stdout).into_owned();
    assert!(report.status.success(), "{said} {}", String::from_utf8_lossy(&report.stderr));
}

/// The scene with glass, holes and a normal map, too.
fn detailed() -> Scene {
    let mut scene = scene();
    let mut pane = scene.objects[0].mesh.clone();
    pane.positions.iter_mut().for_each(|position| *position += 0.5 * Vec3::Z);
    for (material, glass) in [("pane", Glass::pane(1.5)), ("body", Glass::solid(1.5))] {
        let (material, mesh) = (material.into(), pane.clone());
        let glass = Some(Glass { absorption: Rgb::new(0.5, 0.1, 0.0), ..glass });
        scene.ungrouped.push(Ungrouped { material, mesh, glass });
    }
    let wraps = (Wrap::ClampToEdge, Wrap::Repeat);
    let alpha = Image::from_fn(4, 4, |x, y| ((x + y) % 2) as f32);
    let alpha = Mapped { image: alpha, wrap_u: wraps.0, wrap_v: wraps.1 };
    let bumps = Image::from_fn(4, 4, |x, _| Vec3::new(0.2 * x as f32, 0.0, 1.0));
    let normals = Mapped { image: bumps, wrap_u: wraps.0, wrap_v: wraps.1 };
    let wall = &mut scene.objects[0].mesh;
    wall.uvs = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    wall.detail = Detail {
        coverage: Some(Arc::new(Coverage { alpha, cutoff: 0.5 })),
        normals: Some(Arc::new(NormalMap { normals, shades_itself: true })),
    };
    scene
}

/// By all validators of the library; it lacks MaterialX's nodes, which the test below looks at. A package's paths are
/// other ones.
const VALIDATE_USD: &str = "
import sys
from pxr import Sdf, Usd, UsdValidation
text, binary, package = sys.argv[1:]
context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
errors = []
for path in sys.argv[1:]:
    stage = Usd.Stage.Open(path)
    assert len(list(stage.Traverse())) > 40, path
    found = [*context.Validate(stage), *context.Validate(stage.GetRootLayer())]
    errors += [e for e in map(lambda e: e.GetErrorAsString(), found)
               if 'MissingShaderIdInRegistry' not in e or \"shaderId 'ND_\" not in e]
print(errors)
layers = [Sdf.Layer.FindOrOpen(path).ExportToString() for path in (text, binary)]
packed = Usd.Stage.Open(package).GetRootLayer().ExportToString()
plain = lambda layer: layer.replace('./scene_textures/', './textures/')
print([layers[0] == layers[1], plain(layers[0]) == packed])
sys.exit(1 if errors or layers[0] != layers[1] or plain(layers[0]) != packed else 0)
";

#[test]
#[ignore = "slow: needs OpenUSD, which .ci/programs installs"]
fn openusd_finds_nothing_wrong_and_the_same_in_text_binary_and_package() {
    let Some(folder) = need(installed("usd-core")) else { return };
    let names = ["scene.usda", "scene.usdc", "scene.usdz"];
    let exports = names.map(|name| exported_as(&detailed(), Target::Usd, name));
    let mut command = Command::new(folder.join("bin/python"));
    command.args(["-c", VALIDATE_USD]).args(exports.iter().map(|(_, path)| path));
    let report = command.output().unwrap();
    let said = String::from_utf8_lossy(&report.stdout).into_owned();
    assert!(report.status.success(), "{said} {}", String::from_utf8_lossy(&report.stderr));
}

/// Nodes of MaterialX in a stage are known to its library, with all their inputs and of these types.
const VALIDATE_NODES: &str = "
import re, sys, MaterialX
library = MaterialX.createDocument()
MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), library)
types = {'color3': 'color3f', 'vector2': 'float2', 'vector3': 'float3', 'filename': 'asset', 'boolean': 'bool'}
nodes = re.findall(r'info:id = \"(ND_\\w+)\"(.*?)\\}', open(sys.argv[1]).read(), re.S)
for name, body in nodes:
    node = library.getNodeDef(name)
    assert node is not None, name
    for kind, name in re.findall(r'(\\w+) inputs:(\\w+)', body):
        known = node.getActiveInput(name)
        assert known is not None and types.get(known.getType(), known.getType()) == kind, (kind, name)
assert len({name for name, _ in nodes}) == 7, nodes
";

#[test]
#[ignore = "slow: needs MaterialX, which .ci/programs installs"]
fn nodes_of_materialx_in_usd_are_known_with_their_inputs() {
    let Some(folder) = need(installed("materialx")) else { return };
    let (_folder, path) = exported(&detailed(), Target::Usd);
    let mut command = Command::new(folder.join("bin/python"));
    let report = command.args(["-c", VALIDATE_NODES]).arg(path).output().unwrap();
    assert!(report.status.success(), "{}", String::from_utf8_lossy(&report.stderr));
}

const REWRITE_MATERIALX: &str = "
import sys, MaterialX
document = MaterialX.createDocument()
MaterialX.readFromXmlFile(document, sys.argv[1])
options = MaterialX.XmlWriteOptions()
options.elementPredicate = lambda element: element.getCategory() != 'comment'
MaterialX.writeToXmlFile(document, sys.argv[2], options)
";

#[test]
#[ignore = "slow: needs MaterialX, which .ci/programs installs"]
fn what_materialx_writes_itself_is_read_back() {
    let Some(folder) = need(installed("materialx")) else { return };
    // The lobe of MaterialX's shaders, so that none is converted.
    let mut original = Scene { brdf: BrdfModel::Ggx, ..scene() };
    // MaterialX does not escape these in its attributes, which is no XML then.
    original.groups.iter_mut().for_each(|group| group.name = group.name.replace(['<', '>'], ""));
    let (_folder, path) = exported(&original, Target::Materialx);
    let again = path.join("again.mtlx");
    let mut command = Command::new(folder.join("bin/python"));
    command.args(["-c", REWRITE_MATERIALX]).arg(path.join("materials.mtlx")).arg(&again);
    let report = command.output().unwrap();
    assert!(report.status.success(), "{}", String::from_utf8_lossy(&report.stderr));
    assert!(
        !std::fs::read_to_string(&again).unwrap().contains("<!--"),
        "without our exact numbers"
    );
    let mut back = original.clone();
    for group in &mut back.groups {
        group.material = Material::diffuse(Rgb::splat(0.123));
    }
    material_file::apply(&again, &mut back).unwrap();
    // The reflectance at normal incidence is all that a free lobe has of the shader.
    let at_normal = |material: &Material| material.clone().freed();
    let base = |material: &Material| match &material.texture {
        None => material.rho_d,
        Some(texture) => {
            let texels = texture.image.pixels();
            texels.iter().sum::<Rgb>() / texels.len() as f32
        }
    };
    for (a, b) in original.groups.iter().zip(&back.groups) {
        let (a, b, name) = (at_normal(&a.material), at_normal(&b.material), &a.name);
        assert_eq!(a.texture.is_some(), b.texture.is_some(), "{name}");
        let off = (base(&a) - base(&b)).abs().max((a.rho_s - b.rho_s).abs()).max_element();
        assert!(off < 0.02, "{name}: {a:?} {b:?}");
    }
}
