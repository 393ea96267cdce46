"""Write certificates of motions and locks, and check them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.motion.certificates import certifying
from hcsearch.motion.certificates.certificate_grammar import SECONDS, Clock
from hcsearch.scenes import Scene
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.outputs import check_output, write_output
from hcsearch.system.work_steps import Progress

_ENDINGS = (".json",)


@dataclass(frozen=True)
class Certificate:
    """A certificate in a file, with a sentence for each claim that it proves."""

    path: Path
    sentences: tuple[str, ...]


def prove(
    what: str | Folding | Circuit | Case,
    path: str | Path,
    scene: Scene | str | None = None,
    *,
    budget: int = certifying.DEFAULT_PROOF_BUDGET,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    progress: Progress | None = None,
) -> Certificate:
    """Write a certificate that a folding or a pattern can be opened, or that no motion opens it, as `hcsearch prove`.

    Parameters
    ----------
    what, scene, panel, flat_pairs, db
        As in `deploy`, but not a Linkage or an assembly.
    path
        The file .json to write.
    budget
        Greatest number of efforts of the search for a path or a lock. From the third on each may
        take minutes, and longer than the one before.
    progress
        Called with the numbers of efforts on a pattern that are done and of all, and their name.

    Returns
    -------
    Certificate
        The certificate that was written.

    Raises
    ------
    HcsearchError
        If neither is proved, and for a pattern that lies on no lattice of a tiling, or whose path cannot be proved
        since the equations of its loops depend on each other.
    """
    check_kinds(prove, locals())
    check_output(str(path), _ENDINGS)
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs)
    data, sentences = case.certificate(budget, progress)
    write_output(str(path), json.dumps(data, separators=(",", ":")) + "\n", _ENDINGS)
    return Certificate(Path(path), tuple(sentences))


def verify(path: str | Path, *, seconds: float = SECONDS) -> Certificate:
    """Check a certificate, as `hcsearch verify` does.

    Parameters
    ----------
    path
        The file of the certificate.
    seconds
        Time after which it is not decided whether its claims are proved.

    Returns
    -------
    Certificate
        The certificate, whose claims are proved.

    Raises
    ------
    hcsearch.motion.certificates.certifying.UnprovedCertificateError
        If a claim is not proved, or not in the given time.
    hcsearch.motion.certificates.certifying.CertificateError
        If the file is no certificate.
    InputFileError
        For a file that cannot be read.
    """
    check_kinds(verify, locals())
    clock = Clock(seconds)  # reading 16 MiB takes some of it
    data = certifying.read_certificate(str(path))
    return Certificate(Path(path), tuple(certifying.verify_certificate(data, clock)))
