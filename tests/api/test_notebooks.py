"""What foldings and deployments show of themselves in a notebook."""

import subprocess
import sys

import pytest

from hcsearch import Folding, deploy
from hcsearch.web.player import notebook_html
from tests.player.motions import replay_of


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


def test_a_replay_plays():
    replay = replay_of("unit-ii")
    assert replay._repr_html_() == notebook_html(replay)


def test_what_a_notebook_shows_is_loaded_when_it_is_shown():
    code = (
        "import sys; from hcsearch import Folding; folding = Folding.from_notation('hex:02334051:0'); "
        "assert 'hcsearch.web.player' not in sys.modules; folding._repr_html_(); "
        "assert 'hcsearch.web.player' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
