"""What foldings and deployments show of themselves in a notebook."""

import pytest

from hcsearch import Folding, deploy


def test_a_folding_shows_its_picture_and_plays():
    folding = Folding.from_notation("hex:0234435011:1")
    shown = folding._repr_html_()
    assert folding._repr_svg_() in shown
    assert shown.count("<iframe") == 1
    assert "planned path from packed to flat" in shown


@pytest.mark.parametrize("name", ["hex:02334051:0", "square:01223330301121:2"])
def test_twisted_and_large_foldings_show_their_picture_alone(name):
    assert Folding.from_notation(name)._repr_html_() is None


def test_a_deployment_plays():
    shown = deploy("hex:023350:1", seconds=0.02)._repr_html_()
    assert shown.count("<iframe") == 1
    assert "simulated in the scene" in shown
