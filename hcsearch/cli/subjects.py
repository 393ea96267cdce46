"""The argument and the options that say what `hcsearch deploy`, `tune` and `drive` work on, and in which scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import database_option
from hcsearch.cli.scenes import scene_options

if TYPE_CHECKING:
    from hcsearch.subjects.requests import Request

Command = Callable[..., Any]
_VALUES = ("held", "seconds", "gravity", "spring", "springs", "damping", "start", "restitution", "spring_range")
"""Values of a scene that one command or another has options for."""

_SECONDS = click.option(
    "--seconds",
    type=float,
    metavar="S",
    help="How long the motion is simulated, s.  [default: 1; longer for large panels and soft springs]",
)


def subject_options(command: Command) -> Command:
    """The argument, and the options that say what the panels are and what acts on them."""
    return _options(command, "DESIGN:CREASE|ASSEMBLY|FILE.toml", "rigid", _SECONDS)


def folding_options(command: Command) -> Command:
    """The same where the subject is a folding, which moves as long as it takes, in any way of joining flat pairs."""
    return _options(command, "DESIGN:CREASE|FILE.toml", "either")


def circuit_options(command: Command) -> Command:
    """The same where it is a circuit, all of whose foldings are looked at."""
    return _options(command, "FILE.fold|CIRCUIT", "either", _SECONDS)


def proof_options(command: Command) -> Command:
    """The same where it is a folding whose motion is proved: nothing acts on its panels."""
    return _panel_options(command, "DESIGN:CREASE", "either")


def _options(command: Command, names: str, flat_pairs: str, *own: Command) -> Command:
    """The options that all have on which something acts, and a command's own; the last one comes first in its help."""
    options: tuple[Command, ...] = (
        *own,
        click.option(
            "--held",
            metavar="PANEL|free",
            help="The panel that is held fixed.  [default: the lowest pair; of assemblies panel 0]",
        ),
        click.option("--gravity", metavar="X,Y,Z", help="Gravity in m/s^2; z points up from the flat sheet."),
    )
    return _panel_options(command, names, flat_pairs, *options)


def _panel_options(command: Command, names: str, flat_pairs: str, *own: Command) -> Command:
    """The argument, options that say what the panels are and how they are joined, and others."""
    options: tuple[Command, ...] = (
        database_option,
        click.option("--merge", is_flag=True, help="Join the two panels of each mirror pair of a design to one panel."),
        click.option(
            "--flat-pairs",
            type=click.Choice(("rigid", "hinged")),
            help=f"How the two panels at each flat crease are joined.  [default: {flat_pairs}]",
        ),
        *own,
        scene_options,
        click.argument("name", metavar=names),
    )
    for option in options:
        command = option(command)
    return command


def request_of(name: str, options: Mapping[str, Any]) -> Request:
    """What these options ask for; more values of the scene, where a command has any, go by their names in it."""
    from hcsearch.subjects.requests import Request

    named = {option: options[option] for option in ("db", "scene", "panel", "across", "flat_pairs", "merge")}
    values = {key: options[key] for key in _VALUES if options.get(key) is not None}
    return Request(name, values=values, **named)


def known_request(name: str, options: Mapping[str, Any]) -> Request:
    """The same with what it comes to, of which stderr says what users should know."""
    from hcsearch.subjects.requests import announced

    return announced(request_of(name, options))
