# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the extension for Blender: the add-on and the wheel of the Python package in one .zip.

    python blender/build.py [--wheel FILE.whl ...] [--out FOLDER]

Without --wheel, pip first builds the package for this machine (which needs Rust). With several wheels,
the .zip is for all of their platforms. Install it in Blender by Edit > Preferences > Get Extensions >
Install from Disk.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent

# Blender's names of platforms by the platform tags of wheels.
PLATFORMS = {
    r"linux.*_x86_64|manylinux.*_x86_64": "linux-x64",
    r"macosx.*_arm64": "macos-arm64",
    r"macosx.*_x86_64": "macos-x64",
    r"win_amd64": "windows-x64",
    r"win_arm64": "windows-arm64",
}


def platform(wheel):
    """Blender's name for the platform of a wheel."""
    tag = wheel.stem.split("-")[-1]
    for pattern, name in PLATFORMS.items():
        if re.fullmatch(pattern, tag):
            return name
    raise SystemExit(f"error: {wheel}: Blender does not run on {tag}")


def build_wheel(folder):
    """Builds the Python package."""
    words = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", str(folder), str(ROOT / "python")]
    subprocess.run(words, check=True)
    return sorted(folder.glob("unrender-*.whl"))


def manifest(wheels):
    """The manifest, with the wheels and their platforms."""
    text = (HERE / "extension" / "blender_manifest.toml").read_text(encoding="utf-8")
    text = "".join(line for line in text.splitlines(keepends=True) if not line.startswith("#"))
    head, table = text.split("\n[permissions]", 1)
    names = ", ".join(f'"./wheels/{wheel.name}"' for wheel in wheels)
    platforms = ", ".join(f'"{name}"' for name in sorted({platform(wheel) for wheel in wheels}))
    return f"{head.lstrip()}wheels = [{names}]\nplatforms = [{platforms}]\n\n[permissions]{table}"


def build(wheels, out):
    """Writes the .zip into the folder ``out``; returns its path."""
    version = re.search(r'^version = "(.*)"', manifest(wheels), re.MULTILINE)[1]
    names = "-".join(sorted({platform(wheel) for wheel in wheels}))
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"unrender-{version}-{names}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("blender_manifest.toml", manifest(wheels))
        file.write(HERE / "LICENSE", "LICENSE")
        for source in sorted((HERE / "extension").glob("*.py")):
            file.write(source, source.name)
        for wheel in wheels:
            file.write(wheel, f"wheels/{wheel.name}")
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheel", type=pathlib.Path, nargs="+", action="extend", default=[])
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "target" / "blender")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        wheels = options.wheel or build_wheel(pathlib.Path(folder))
        print(build(wheels, options.out))


if __name__ == "__main__":
    main()
