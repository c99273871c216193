"""The README's script renders as it stands, and its reference lists what there is."""

import re

import pytest

import blenders

BEGIN, END = "<!-- reference: ", "<!-- end of reference -->"


@pytest.fixture(scope="module")
def readme():
    return (blenders.ROOT / "README.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def blender():
    try:
        return blenders.blender(blenders.SYSTEM)
    except blenders.Missing as missing:
        pytest.skip(str(missing))


def test_the_reference_lists_what_a_script_can_set(readme, blender, tmp_path):
    out = tmp_path / "reference.md"
    blender.run(blenders.ROOT / "tests" / "addon" / "reference.py", out)
    start = readme.index("\n", readme.index(BEGIN)) + 1
    assert readme[start : readme.index(END)] == out.read_text(encoding="utf-8")


def test_the_script_renders_a_glowing_cube_from_two_tables(readme, blender, tmp_path):
    if not (blenders.ROOT / "build" / "stokes").exists():
        pytest.skip("build/stokes is not built")
    script = re.search(r"```python\n(.*?)```", readme, re.S).group(1)
    script = script.replace('sys.path.insert(0, ".")', "sys.path.insert(0, %r)" % str(blenders.ROOT))
    script = script.replace("scene.stokes.samples = 64", "scene.stokes.samples = 4; scene.render.resolution_percentage = 10")
    for name in ("absorption", "emission"):
        peak = 430 if name == "absorption" else 520
        rows = ["%d, %g" % (nm, max(0, 1 - abs(nm - peak) / 60)) for nm in range(350, 650, 5)]
        (tmp_path / (name + ".csv")).write_text("\n".join(rows))
        script = script.replace('"%s.csv"' % name, repr(str(tmp_path / (name + ".csv"))))
    script = script.replace('"glow.png"', repr(str(tmp_path / "glow.png")))
    (tmp_path / "glow.py").write_text(script)
    said = blender.run(tmp_path / "glow.py")
    assert (tmp_path / "glow.png").stat().st_size > 1000, said
    assert "warning" not in said.lower(), said
