"""The sweep over processors of the bench `stability`: the same questions as other processors would answer them.

NumPy and SciPy call OpenBLAS, which takes other kernels on another processor: other roundings, and other bases where
a decomposition is free to choose. OPENBLAS_CORETYPE makes it take those of an older processor. NumPy itself takes other
loops where there is AVX-512, of which NPY_DISABLE_CPU_FEATURES makes no use.
"""

from __future__ import annotations

import ctypes
import json
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch_bench.run.bench import Say
from hcsearch_bench.run.process import Finished, run_measured

Answer = list[dict[str, Any]]


class Processor(NamedTuple):
    """A processor to compute as: its OpenBLAS kernels, None for this one's own, and whether NumPy uses AVX-512."""

    core: str | None
    avx512: bool = True

    @property
    def environment(self) -> dict[str, str]:
        """The environment variables by which a process computes as this processor does."""
        chosen = {} if self.core is None else {"OPENBLAS_CORETYPE": self.core}
        if not self.avx512 and (loops := avx512_loops()):
            chosen["NPY_DISABLE_CPU_FEATURES"] = " ".join(loops)
        return chosen


OWN = Processor(None)
CORES = ("Haswell", "Zen", "Sandybridge", "Prescott", "SkylakeX")
"""Processors whose kernels are tried: with AVX2 of two makers, with AVX, with neither, and with AVX-512."""
PLAIN = Processor("Haswell", avx512=False)
"""The kernels and loops of a processor with AVX2 and without AVX-512, as many machines have."""
LIMIT = 3600.0
"""Seconds for one process."""
ROUNDED = 6
"""Decimals of directions."""
SUBJECTS = ("element-8r", "element-6r", "unit-i", "unit-ii", "unit-iii", "fig-5.11b", "module-i")
ARRAYS = (("hex", 8), ("hex", 10), ("square", 10), ("square", 12))
"""Grids and numbers of cells whose verdicts are compared, the longest of each grid last."""
VERDICTS = tuple(
    f"SELECT d.circuit, t.* FROM {table} t JOIN designs d ON d.id = t.design_id ORDER BY t.design_id, t.crease{also}"
    for table, also in (("foldings", ""), ("motions", ", t.scene"), ("deployments", ", t.scene"))
)


@dataclass(frozen=True)
class ProcessorRow:
    """Answers as one processor gives them, beside those of this one.

    kernels : that OpenBLAS says it took. avx512 : whether NumPy uses it. rows : compared; differ : those in which a
    word, a sentence or a whole number differs. off : greatest difference of any other number, as a share of the greater
    one. seconds : with these kernels. note : why there is nothing to compare.
    """

    core: str
    kernels: str
    avx512: bool
    question: str
    rows: int | None
    differ: int | None
    off: float | None
    seconds: float | None
    note: str = ""


def measure_processors(*, quick: bool, say: Say) -> list[ProcessorRow]:
    """Compute all results as this machine does, then as others would.

    quick : hexagons of 8 cells, as the plain processor alone.
    """
    if not kernels_for(OWN):
        note = "no OpenBLAS here whose kernels could be chosen: not tried"
        return [ProcessorRow("-", "-", bool(avx512_loops()), "-", None, None, None, None, note)]
    questions: dict[str, Callable[[Processor], Answer]] = {"branches of assemblies": _branches_for}
    for grid, n in ARRAYS[:1] if quick else ARRAYS:
        questions[f"verdicts of {grid}, n = {n}"] = partial(_verdicts_for, grid=grid, n=n)
    first = {}
    for question, ask in questions.items():
        say(f"stability: {question}, own kernels")
        first[question] = ask(OWN)
    rows = []
    loops = (True, False) if avx512_loops() else (False,)
    for processor in (PLAIN,) if quick else map(Processor._make, product(CORES, loops)):
        taken, core = kernels_for(processor), str(processor.core)
        if core.lower() not in taken.lower():
            note = "not taken on this machine" if taken else "instructions that this machine lacks"
            rows.append(ProcessorRow(core, taken or "-", processor.avx512, "-", None, None, None, None, note))
            continue
        for question, ask in questions.items():
            say(f"stability: {question}, kernels for {core}, {'with' if processor.avx512 else 'without'} AVX-512")
            begin = time.perf_counter()
            answer = ask(processor)
            seconds = time.perf_counter() - begin
            differ, off = compared(first[question], answer)
            rows.append(ProcessorRow(core, taken, processor.avx512, question, len(answer), differ, off, seconds))
    return rows


def avx512_loops() -> list[str]:
    """The loops with AVX-512 that this NumPy takes on this machine, by the names by which it can be told not to."""
    found = np.show_config("dicts")["SIMD Extensions"].get("found", [])
    return [name for name in found if name.startswith("AVX512") or name == "X86_V4"]


def compared(first: Sequence[Mapping[str, Any]], second: Sequence[Mapping[str, Any]]) -> tuple[int, float]:
    """Rows of which more than numbers with a fraction differ, and the greatest difference of these, as a share."""
    differ, off = abs(len(first) - len(second)), 0.0
    for one, two in zip(first, second, strict=False):
        fractions = [k for k in one if isinstance(one[k], float) and isinstance(two.get(k), float)]
        differ += {k: v for k, v in one.items() if k not in fractions} != {
            k: v for k, v in two.items() if k not in fractions
        }
        shares = (abs(one[k] - two[k]) / max(abs(one[k]), abs(two[k])) for k in fractions if one[k] != two[k])
        off = max(off, *shares, 0.0)
    return differ, off


def kernels_for(processor: Processor) -> str:
    """What OpenBLAS takes where the kernels for one processor are asked for.

    Empty without OpenBLAS, and for kernels that this machine cannot run: OpenBLAS takes those with AVX-512 where they
    are asked for, whether the processor has it or not.
    """
    done = _process(processor, __name__, "kernels")
    if done.status == -signal.SIGILL:
        return ""
    return _output(done, processor, __name__, "kernels").strip()


def _branches_for(processor: Processor) -> Answer:
    answer: Answer = json.loads(_run(processor, __name__, "branches"))
    return answer


def _verdicts_for(processor: Processor, *, grid: str, n: int) -> Answer:
    """The foldings of all arrays with all that the last stage leaves of them, and the trials of their deployments."""
    with tempfile.TemporaryDirectory() as folder:
        db = ("--db", str(Path(folder) / "arrays.sqlite"))
        _run(processor, "hcsearch", "enumerate", "--grid", grid, "--n", str(n), *db)
        asked = [_run(processor, "hcsearch", "query", "--sql", sql, "--format", "json", *db) for sql in VERDICTS]
    return [row for rows in asked for row in json.loads(rows)]


def _run(processor: Processor, module: str, *words: str) -> str:
    """What a process of its own prints as one processor computes."""
    return _output(_process(processor, module, *words), processor, module, *words)


def _process(processor: Processor, module: str, *words: str) -> Finished:
    return run_measured([sys.executable, "-m", module, *words], LIMIT, processor.environment)


def _output(done: Finished, processor: Processor, module: str, *words: str) -> str:
    if done.status != 0:
        kernels_of = processor.core or "this machine"
        raise HcsearchError(f"{module} {' '.join(words)}, kernels for {kernels_of}: {done.error.strip()}")
    return done.output


def kernels() -> str:
    """What the OpenBLAS libraries that NumPy and SciPy bring say they run; empty where there are none."""
    import numpy
    import scipy.linalg

    for package in (numpy, scipy):
        package.linalg.svd(numpy.eye(64) + numpy.tri(64))  # it ends here where the processor lacks their instructions
    names = []
    for package in (numpy, scipy):
        folder = Path(package.__path__[0])
        beside = (folder.parent / f"{package.__name__}.libs", folder / ".dylibs")
        for path in (path for place in beside if place.is_dir() for path in sorted(place.glob("*openblas*"))):
            library = ctypes.CDLL(str(path))
            for name in ("scipy_openblas_get_corename64_", "scipy_openblas_get_corename"):
                if hasattr(library, name):
                    corename = getattr(library, name)
                    corename.restype = ctypes.c_char_p
                    names.append(corename().decode())
    return ", ".join(dict.fromkeys(names))


def branches_of_assemblies() -> Answer:
    """Branches of assemblies at both ends, with stops and without: of each search what is decided, and each direction.

    Of families, of which a search shows some members, their dimensions.
    """
    from hcsearch.motion.paths.branches import find_branches
    from hcsearch_bench.subjects.deployments import assembly

    answer: Answer = []
    for name in SUBJECTS:
        linkage = assembly(name)
        for state in ("folded", "flat"):
            for stops in (False, True):
                result = find_branches(linkage, getattr(linkage, state), stops=stops)
                families = sorted({branch.dimension for branch in result.branches} - {0})
                search = {"subject": name, "state": state, "stops": stops}
                answer.append(search | {"nullity": result.nullity, "families": families})
                for branch in (branch for branch in result.branches if not branch.dimension):
                    direction = [round(float(x), ROUNDED) + 0.0 for x in branch.direction]
                    answer.append(
                        search | {"direction": direction, "status": branch.status, "within": branch.within_stops}
                    )
    return answer


if __name__ == "__main__":
    print(kernels() if sys.argv[1] == "kernels" else json.dumps(branches_of_assemblies()))
