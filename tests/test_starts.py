"""What a command loads: numba only where a kernel is called that computes much."""

import shlex
import subprocess
import sys

import pytest

LOADED = "import sys; print('numba' in sys.modules, file=sys.stderr)"
COMMAND = "import sys; sys.argv[0] = 'hcsearch'; from hcsearch.__main__ import main; main()"


def run(code, *words, folder=None):
    """A program in a process of its own: what it printed, and whether it loaded numba."""
    line = [sys.executable, "-c", f"{code}\n{LOADED}", *words]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr.splitlines()[-1] == "True"


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """A folder with a database of all arrays of eight hexagons, judged but for springs."""
    folder = tmp_path_factory.mktemp("searched")
    search = ("enumerate", "--grid", "hex", "--n", "8", "--until", "motion", "--db", "d.sqlite")
    _, loaded = run(COMMAND, *search, folder=folder)
    assert loaded
    return folder


@pytest.mark.parametrize(
    "words",
    [
        "query two_stack --db d.sqlite",
        "query --sql 'SELECT count(*) FROM designs' --db d.sqlite",
        "rank untwisted --db d.sqlite",
        "show 1 --db d.sqlite",
        "show untwisted --db d.sqlite",
        "show hex:012223444500",
        "report untwisted=0 --db d.sqlite --output r.html",
        "export untwisted --db d.sqlite --output sheet.svg",
        "assembly list",
        "init scene.toml",
    ],
)
def test_where_results_are_looked_up_numba_is_not_loaded(words, searched):
    untwisted, _ = run(
        COMMAND, "query", "untwisted", "--db", "d.sqlite", "-c", "id", "--format", "csv", folder=searched
    )
    if words.startswith(("show", "export")):
        words = words.replace("untwisted", untwisted.split()[1])
    _, loaded = run(COMMAND, *shlex.split(words), folder=searched)
    assert not loaded


SMALL_KERNELS = """
import sys
import numpy as np
from hcsearch import Folding, Linkage
from hcsearch.kernels.linkage.closing_steps import damped_step
from hcsearch.kernels.linkage.cones import cone_rays, nonnegative_least_squares
rng = np.random.default_rng(1)
for name, pairs in (("hex:0234550132:4", "rigid"), ("square:01222300:1", "hinged")):
    linkage = Linkage(Folding.from_notation(name).pattern((0.05, 0.05, 0.006), flat_pairs=pairs))
    for _ in range(20):
        residual, jacobian = linkage.closure(rng.uniform(0.0, np.pi, linkage.n_hinges))
        print(residual.tobytes().hex(), jacobian.tobytes().hex())
        print(linkage.bend(jacobian, rng.normal(size=linkage.n_hinges)).tobytes().hex())
        print(damped_step(jacobian, residual, 0.01).tobytes().hex())
        columns, rays = rng.normal(size=(8, 4)), np.zeros((100, 8))
        weights, left = np.empty(8), np.empty(4)
        nonnegative_least_squares(columns, rng.normal(size=4), weights, left)
        print(weights.tobytes().hex(), left.tobytes().hex(), cone_rays(columns, rays), rays.tobytes().hex())
"""


def test_small_kernels_give_the_same_bits_as_python():
    as_python, loaded = run(SMALL_KERNELS)
    assert not loaded
    compiled, loaded = run("import numba\n" + SMALL_KERNELS)
    assert loaded
    assert as_python == compiled
    assert len(as_python.splitlines()) == 160


@pytest.mark.parametrize(
    ("calls", "hinges", "loaded"), [(200, 10, False), (201, 10, True), (1, 16, False), (1, 17, True)], ids=str
)
def test_a_small_kernel_is_compiled_where_it_has_much_to_do(calls, hinges, loaded):
    code = f"""
import numpy as np
from hcsearch.kernels.linkage.closing_steps import damped_step
for _ in range({calls}):
    damped_step(np.ones(({hinges}, 2)), np.ones({hinges}), 0.1)
"""
    assert run(code) == ("", loaded)


def test_kernels_that_waited_are_those_that_modules_have():
    code = """
import hcsearch.kernels.linkage.loops as loops, hcsearch.shape.linkage as linkage
from hcsearch import count_array, parse_array
first = linkage.place_panels
assert count_array(parse_array("hex", "3-4-3")).circuits
from numba.core.dispatcher import Dispatcher
assert isinstance(loops.place_panels, Dispatcher) and linkage.place_panels is loops.place_panels
assert first is not loops.place_panels and first.signatures == loops.place_panels.signatures
"""
    assert run(code) == ("", True)
