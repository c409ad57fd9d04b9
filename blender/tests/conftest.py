# SPDX-License-Identifier: GPL-3.0-or-later
"""The built extension, installed into an empty profile of Blender (the package bpy), and a small scene."""

import os
import pathlib
import subprocess
import sys
import tempfile

import pytest

HERE = pathlib.Path(__file__).resolve().parent
# Blender reads it when it starts, at the import.
PROFILE = tempfile.TemporaryDirectory(prefix="unrender-profile-")
os.environ["BLENDER_USER_RESOURCES"] = PROFILE.name

import bpy  # noqa: E402

import addon_utils  # noqa: E402  isort: skip  (bpy adds it to the path)

sys.path[:0] = [str(HERE), str(HERE.parent)]

MODULE = "bl_ext.user_default.unrender"


def wheel():
    """The wheel of the Python package: named by UNRENDER_WHEEL, or built by pip wheel."""
    named = os.environ.get("UNRENDER_WHEEL")
    found = [pathlib.Path(named)] if named else sorted((HERE.parents[1] / "target/wheels").glob("unrender-*.whl"))
    if not found:
        pytest.exit("build the wheel first: pip wheel --no-deps --wheel-dir target/wheels ./python")
    return found[-1]


@pytest.fixture(scope="session")
def archive(tmp_path_factory):
    """The .zip of the extension."""
    out = tmp_path_factory.mktemp("zip")
    line = [sys.executable, str(HERE.parent / "build.py"), "--wheel", str(wheel()), "--out", str(out)]
    return pathlib.Path(subprocess.run(line, check=True, capture_output=True, text=True).stdout.strip())


@pytest.fixture(scope="session")
def extension(archive):
    """The extension, installed from its .zip and enabled."""
    bpy.ops.extensions.package_install_files(
        filepath=str(archive), repo="user_default", enable_on_install=True, overwrite=True
    )
    if MODULE not in bpy.context.preferences.addons:
        addon_utils.enable(MODULE, default_set=True)
    assert MODULE in bpy.context.preferences.addons
    return sys.modules[MODULE]


def pytest_sessionfinish(session, exitstatus):
    """The exit code of :func:`pytest_unconfigure`."""
    session.config.ended_with = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """Ends at once: Blender 4.2 as a module crashes when Python unloads it after the tests."""
    PROFILE.cleanup()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(getattr(config, "ended_with", 1))
