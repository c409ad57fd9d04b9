//! Exports, checked by the validators of their formats.

use crate::kit::export_scene::{exported, scene};
use crate::kit::programs::{installed, need};
use std::process::Command;
use unrender::formats::export::Target;

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
