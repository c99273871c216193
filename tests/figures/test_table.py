"""Every name in the table of README.md exists: a function in its file, a picture in the script that draws it."""

import pathlib
import re

import pytest

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parents[1]
TABLE = (HERE / "README.md").read_text(encoding="utf-8")
NAMES = sorted(set(re.findall(r"`((?:csrc|tests|addon|test_scenes)/[\w/.]+):(\w+)`", TABLE)))
FILES = sorted(set(re.findall(r"`((?:csrc|tests|addon|test_scenes)/[\w/.]+\.\w+)`", TABLE)))
PICTURES = sorted(set(re.findall(r"`([\w-]+)\.(?:png|gif)`", TABLE)))


def test_the_table_holds_every_equation_and_figure():
    lines = [line.split("|")[1].strip() for line in TABLE.splitlines() if line.startswith("|")]
    equations, figures = set(), set()
    for first in lines:
        for kind, found in ((r"eqs?\. ", equations), (r"figs?\. ", figures)):
            match = re.match(kind + r"(\d+)(?:–(\d+))?$", first)
            if match:
                found.update(range(int(match[1]), int(match[2] or match[1]) + 1))
    assert equations == set(range(1, 29))
    assert figures == set(range(1, 14))


def defines(path, name):
    pattern = r"^(?:def |class |(?:[\w*]+ )*\**)%s\b(?:\(|:| =)" % name
    return path.is_file() and re.search(pattern, path.read_text(encoding="utf-8"), re.M)


@pytest.mark.parametrize("path, name", NAMES, ids=[":".join(pair) for pair in NAMES])
def test_a_named_function_is_in_its_file(path, name):
    if not defines(ROOT / path, name):
        room = (ROOT / path).parent.glob("*" + pathlib.Path(path).suffix)
        moved = [str(other.relative_to(ROOT)) for other in room if defines(other, name)]
        pytest.fail(
            "tests/figures/README.md names %s:%s; it is in %s" % (path, name, " and ".join(moved) or "no file there")
        )


@pytest.mark.parametrize("path", FILES)
def test_a_named_file_is_there(path):
    assert (ROOT / path).is_file()


def drawn_names():
    """Patterns of all names, with or without a place to fill, that scripts and notebook speak of."""
    scripts = [path for path in (*HERE.glob("*.py"), *HERE.glob("*.ipynb")) if path.name != pathlib.Path(__file__).name]
    words = {
        word for path in scripts for word in re.findall(r"[\w%/.-]+", path.read_text(encoding="utf-8")) if "-" in word
    }
    stems = {re.sub(r"\.(?:png|gif)$", "", word.rpartition("/")[2]) for word in words}
    return [
        re.escape(stem).replace("%s", r"[\w-]+").replace("%d", r"\d+") for stem in stems if re.match(r"\w{3}", stem)
    ]


@pytest.mark.parametrize("name", PICTURES)
def test_a_named_picture_is_drawn_by_some_script(name):
    assert any(re.fullmatch(pattern, name) for pattern in drawn_names()), "%s is drawn by nothing" % name
