"""The zip: installs as users install it, finds its own core, renders.
Skipped where the core is not built."""

import re
import subprocess
import sys
import zipfile

import pytest

from hosts import ROOT

CORE = ROOT / "build" / "stokes"
OCIO = ROOT / "build" / "deps" / "ocio"


@pytest.fixture(scope="session")
def archive(tmp_path_factory):
    if not CORE.exists():
        pytest.skip("build/stokes is not built")
    path = tmp_path_factory.mktemp("zip") / "stokes-addon.zip"
    subprocess.run(
        [sys.executable, str(ROOT / "addon" / "pack.py"), str(CORE), str(OCIO), str(path)],
        check=True,
        timeout=120,
    )
    return path


def test_the_zip_holds_one_folder_without_leftovers(archive):
    names = zipfile.ZipFile(archive).namelist()
    assert all(name.startswith("stokes/") for name in names) and len(names) == len(set(names))
    assert {
        "stokes/__init__.py",
        "stokes/blender_manifest.toml",
        "stokes/bin/stokes",
        "stokes/bin/deps/ocio/lib/libOpenColorIO.so",
    } <= set(names)
    assert not [
        name
        for name in names
        if "__pycache__" in name or "/." in name or name.endswith((".pyc", ".mk"))
    ]


INSTALL = """
import bpy, os, sys
archive, out = sys.argv[-2:]
if bpy.app.version >= (4, 2, 0):
    repos = bpy.context.preferences.extensions.repos
    if not repos:
        bpy.ops.preferences.extension_repo_add(name="Local", type='LOCAL')
    repo = next(repo for repo in repos if not repo.use_remote_url).module
    bpy.ops.extensions.package_install_files(filepath=archive, repo=repo, enable_on_install=True)
else:
    bpy.ops.preferences.addon_install(filepath=archive)
    bpy.ops.preferences.addon_enable(module="stokes")
names = [name for name in bpy.context.preferences.addons.keys() if name.split(".")[-1] == "stokes"]
print("TOLD add-ons", names)
exec(IMPORT_NEW if bpy.app.version >= (4, 2, 0) else IMPORT)  # as the README says
material = bpy.data.materials.new("Glow")
material.use_nodes = True
print("TOLD kind", addon.nodes.new(material.node_tree, "fluorescent").stokes.kind)
scene = bpy.context.scene
scene.render.engine = 'STOKES'
scene.stokes.samples = 4
scene.render.resolution_x = scene.render.resolution_y = 32
scene.render.filepath = out
scene.render.image_settings.file_format = 'PNG'
bpy.ops.render.render(write_still=True)
core = sys.modules[names[0] + ".core.find"].find_core()
print("TOLD core", core, os.access(core, os.X_OK))
"""


def test_the_zip_installs_and_renders_with_its_own_core(host, archive, tmp_path):
    script = tmp_path / "install.py"
    said = (ROOT / "README.md").read_text(encoding="utf-8")
    (plain,) = re.findall("`(import stokes as addon)`", said)
    (extension,) = re.findall("`(from bl_ext.* import stokes as addon)`", said)
    script.write_text(INSTALL.replace("IMPORT_NEW", repr(extension)).replace("IMPORT", repr(plain)))
    environment = {
        "PATH": "/usr/bin:/bin",
        "HOME": str(tmp_path),
        "BLENDER_USER_RESOURCES": str(tmp_path / "user"),
        "BLENDER_USER_SCRIPTS": str(tmp_path / "user" / "scripts"),
        "BLENDER_USER_CONFIG": str(tmp_path / "user" / "config"),
    }
    out = tmp_path / "out.png"
    done = subprocess.run(
        [*host.command, str(script), "--", str(archive), str(out)],
        env=environment,
        timeout=120,
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert done.returncode == 0 and out.exists(), done.stdout
    assert (
        "TOLD core " + str(tmp_path / "user") in done.stdout and "/bin/stokes True" in done.stdout
    ), done.stdout
    assert "TOLD kind fluorescent" in done.stdout, done.stdout
