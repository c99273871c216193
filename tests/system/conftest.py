"""Fixtures and helpers of the whole-render tests: running `stokes` and batches by seed."""

import concurrent.futures
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import exr  # noqa: E402  (found by the line above)

ROOT = pathlib.Path(__file__).parents[2]
TIMEOUT = 600  # seconds, for one render; `long` renders are many, not longer


class Core:
    """The `stokes` executable."""

    def __init__(self, path, directory):
        self.path, self.directory = path, directory
        self.count = 0

    def run(self, *arguments, check=True):
        result = subprocess.run(
            [self.path, *map(str, arguments)], capture_output=True, text=True, timeout=TIMEOUT, errors="replace"
        )
        if check:
            assert result.returncode == 0, "stokes %s: %s" % (" ".join(map(str, arguments)), result.stderr)
        return result

    def render(self, scene, name=None, keep=False, bins=None, **options):
        """The picture of a scene. `bins` is (count, min, max); other options are those of `stokes render`, with _ for -."""
        if name is None:
            self.count += 1
            name = "render-%d-%d.exr" % (os.getpid(), self.count)
        out = self.directory / name
        if bins:
            options.update(spectral_bins="%d:%g:%g" % bins)
        arguments = [text for key, value in options.items() for text in ("--" + key.replace("_", "-"), value)]
        self.run("render", scene, "-o", out, "--quiet", *arguments)
        picture = exr.read(out)
        if not keep:
            out.unlink()
        return picture

    def batches(self, scene, integrator, renders, samples, bins, measure, first_seed=1, **options):
        """The rows that `measure` makes of independent renders (by seed), as many at a time as there are processors."""

        def one(seed):
            name = "%s-%s-%d.exr" % (pathlib.Path(scene).stem, integrator, seed)
            return np.atleast_2d(
                measure(
                    self.render(
                        scene, name, integrator=integrator, samples=samples, seed=seed, threads=1, bins=bins, **options
                    )
                )
            )

        workers = len(os.sched_getaffinity(0))
        with concurrent.futures.ThreadPoolExecutor(workers) as pool:
            return np.concatenate(list(pool.map(one, range(first_seed, first_seed + renders))))


@pytest.fixture(scope="session")
def core(tmp_path_factory):
    path = pathlib.Path(os.environ.get("STOKES", ROOT / "build/stokes"))
    if not path.exists():
        pytest.fail("%s is not built; run `make core`" % path)
    return Core(path, tmp_path_factory.mktemp("renders"))
