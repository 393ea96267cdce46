"""The sweep over processors of the bench `stability`: the same questions with OpenBLAS kernels for others.

NumPy and SciPy call OpenBLAS, which takes other kernels on another processor: other roundings, and other bases where
a decomposition is free to choose. OPENBLAS_CORETYPE makes it take those of an older processor.
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
from pathlib import Path
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch_bench.run.bench import Say
from hcsearch_bench.run.process import Finished, run_measured

Answer = list[dict[str, Any]]

CORES = ("Haswell", "Sandybridge", "Prescott", "SkylakeX")
"""Processors whose kernels are tried: with AVX2, with AVX, with neither, and with AVX-512."""
OLDEST = "Prescott"
LIMIT = 3600.0
"""Seconds for one process."""
ROUNDED = 6
"""Decimals of directions."""
SUBJECTS = ("element-8r", "element-6r", "unit-i", "unit-ii", "unit-iii", "fig-5.11b", "module-i")
VERDICTS = "SELECT d.circuit, f.* FROM foldings f JOIN designs d ON d.id = f.design_id ORDER BY f.design_id, f.crease"


@dataclass(frozen=True)
class ProcessorRow:
    """Answers with the kernels for one processor, beside those with this one's own.

    kernels : that OpenBLAS says it took. rows : compared; differ : those of which a word or a whole number differs.
    off : greatest difference of any other number, as a share of the greater one. seconds : with these kernels.
    note : why there is nothing to compare.
    """

    core: str
    kernels: str
    question: str
    rows: int | None
    differ: int | None
    off: float | None
    seconds: float | None
    note: str = ""


def measure_processors(*, quick: bool, say: Say) -> list[ProcessorRow]:
    """Compute all results with the kernels for this machine, then with those for others.

    quick : hexagons of 10 cells, and of other kernels those for the oldest processor.
    """
    own = kernels_for(None)
    if not own:
        note = "no OpenBLAS here whose kernels could be chosen: not tried"
        return [ProcessorRow("-", "-", "-", None, None, None, None, note)]
    n = 10 if quick else 12
    questions: dict[str, Callable[[str | None], Answer]] = {
        "branches of assemblies": _branches_for,
        f"verdicts of hexagons, n = {n}": partial(_verdicts_for, n=n),
    }
    first = {}
    for question, ask in questions.items():
        say(f"stability: {question}, own kernels")
        first[question] = ask(None)
    rows = []
    for core in (OLDEST,) if quick else CORES:
        taken = kernels_for(core)
        if taken in {own, ""}:
            note = "this machine's own" if core.lower() in own.lower() else "not taken on this machine"
            note = note if taken else "instructions that this machine lacks"
            rows.append(ProcessorRow(core, taken or "-", "-", None, None, None, None, note))
            continue
        for question, ask in questions.items():
            say(f"stability: {question}, kernels for {core}")
            begin = time.perf_counter()
            answer = ask(core)
            seconds = time.perf_counter() - begin
            differ, off = compared(first[question], answer)
            rows.append(ProcessorRow(core, taken, question, len(answer), differ, off, seconds))
    return rows


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


def kernels_for(core: str | None) -> str:
    """What OpenBLAS takes where the kernels for one processor are asked for.

    Empty without OpenBLAS, and for kernels that this machine cannot run: OpenBLAS takes those with AVX-512 where they
    are asked for, whether the processor has it or not.
    """
    done = _process(core, __name__, "kernels")
    if done.status == -signal.SIGILL:
        return ""
    return _output(done, core, __name__, "kernels").strip()


def _branches_for(core: str | None) -> Answer:
    answer: Answer = json.loads(_run(core, __name__, "branches"))
    return answer


def _verdicts_for(core: str | None, *, n: int) -> Answer:
    """The foldings of hexagons with all that the last stage leaves of them."""
    with tempfile.TemporaryDirectory() as folder:
        db = ("--db", str(Path(folder) / "hexagons.sqlite"))
        _run(core, "hcsearch", "enumerate", "--grid", "hex", "--n", str(n), *db)
        answer: Answer = json.loads(_run(core, "hcsearch", "query", "--sql", VERDICTS, "--format", "json", *db))
    return answer


def _run(core: str | None, module: str, *words: str) -> str:
    """What a process of its own prints with the kernels for one processor."""
    return _output(_process(core, module, *words), core, module, *words)


def _process(core: str | None, module: str, *words: str) -> Finished:
    environment = {} if core is None else {"OPENBLAS_CORETYPE": core}
    return run_measured([sys.executable, "-m", module, *words], LIMIT, environment)


def _output(done: Finished, core: str | None, module: str, *words: str) -> str:
    if done.status != 0:
        raise HcsearchError(f"{module} {' '.join(words)}, kernels for {core or 'this machine'}: {done.error.strip()}")
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
