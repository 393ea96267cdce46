"""The share of work that omissions save is counted as if the scene had been compiled with everything put back."""

import math

import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import FORMULATIONS
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.compiled_scene import ALL_OMISSIONS, compile_scene
from hcsearch.springs.deployment.omission_savings import LOOK_WORK, can_restore, saved_share
from tests.linkages import linkage_named

FOLDINGS = ["hex:0234550132:4", "hex:0233335000:1", "square:012222230000:1", "square:012123230301:1"]


def terms(compiled):
    return compiled.system.n_joints + compiled.system.n_equations


@pytest.mark.parametrize("scene", ["default", "satellite"])
@pytest.mark.parametrize("name", [*FOLDINGS, *ASSEMBLIES])
def test_work_is_counted_as_with_everything_put_back(name, scene):
    linkage = linkage_named(name)
    for formulation in FORMULATIONS:
        try:
            compiled = compile_scene(linkage, SCENES[scene], formulation)
        except HcsearchError:  # a free base has no dampers, and open chains no springs that close loops
            continue
        keep = frozenset(name for name in ALL_OMISSIONS if can_restore(compiled, name))
        whole = compile_scene(linkage, SCENES[scene], formulation, keep=keep)
        pairs = math.comb(linkage.n_panels, 2)
        compared = pairs - len(compiled.separated_pairs)
        assert saved_share(compiled, 1, 0) == pytest.approx(1.0 - terms(compiled) / terms(whole)), formulation
        assert saved_share(compiled, 0, 5) == pytest.approx(1.0 - compared / pairs)
        made, everything = (100 * terms(one) + LOOK_WORK * n for one, n in ((compiled, compared), (whole, pairs)))
        assert saved_share(compiled, 100, compared) == pytest.approx(1.0 - made / everything)
        assert saved_share(whole, 100, pairs) == pytest.approx(0.0, abs=1e-12)
        assert saved_share(compiled, 0, 0) == 0.0
