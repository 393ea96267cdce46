"""Arguments and options for the subject of a command and its scene: `--scene`, `--panel` and others."""

from __future__ import annotations

from collections.abc import Mapping
from functools import wraps
from typing import TYPE_CHECKING, Any

import click

from hcsearch.basics.errors import HcsearchError, SceneError
from hcsearch.basics.vocabulary import WAYS, listed
from hcsearch.cli.options import Command, database_option, joined_words
from hcsearch.designs.grid import GRIDS
from hcsearch.scenes.scene import SCENE_VALUES

if TYPE_CHECKING:
    from hcsearch.subjects.case import Case


def _given_edges() -> str:
    """Return the edge whose length is given for each grid with several edges, such as `the leg of obtuse`."""
    edges = dict.fromkeys(grid.given_edge for grid in GRIDS.values() if grid.given_edge)
    of_grids = {edge: [grid.name for grid in GRIDS.values() if grid.given_edge == edge] for edge in edges}
    return ", ".join(f"the {edge} of {listed(names, 'and')}" for edge, names in of_grids.items())


def scene_options(command: Command) -> Command:
    """Add `--scene` and `--panel`; the hidden `--across WxT` means `--panel 'across WxT'`."""

    @wraps(command)
    def run(*args: Any, across: str | None, **options: Any) -> Any:
        if across is not None:
            if options["panel"] is not None:
                raise SceneError("give either --panel or --across: both say how large panels are")
            options["panel"] = f"across {across}"
        return command(*args, **options)

    for option in (
        click.option("--across", metavar="WxT", hidden=True),
        click.option(
            "--panel",
            metavar="LxWxT",
            help="Size of the panels in mm: length, width and thickness, or side and thickness (SxT), or 'across WxT', "
            "the width across flats (of equilateral triangles, the height) and the thickness. Of several sides, S is "
            f"{_given_edges()}.",
        ),
        click.option(
            "--scene",
            metavar="NAME|FILE.toml",
            help="The panels, springs and gravity: a scene such as default or earth, or a file.  [default: default]",
        ),
    ):
        run = option(run)
    return run


def value_options(of: str) -> tuple[Command, ...]:
    """Return the options for values of a scene that some commands have; of : as in `SceneValue.option`."""
    return tuple(
        click.option(
            f"--{name.replace('_', '-')}",
            type=float if value.is_number else str,
            metavar=value.option[1],
            help=value.help,
        )
        for name, value in SCENE_VALUES.items()
        if value.option[0] == of
    )


def subject_options(command: Command) -> Command:
    """Add the subject as argument, and options for panels and for the loads and constraints on them."""
    return _options(command, "DESIGN:CREASE|ASSEMBLY|FILE.toml|FILE.fold", "rigid", *value_options("time"))


def film_options(command: Command) -> Command:
    """Add the same for films, which decide how long the motion is simulated."""
    return _options(command, "DESIGN:CREASE|ASSEMBLY|FILE.toml|FILE.fold", "rigid")


def export_options(command: Command) -> Command:
    """Add the same, with a subject or a query, which may have several words."""
    return _options(
        command, "DESIGN:CREASE|ASSEMBLY|FILE.toml|FILE.fold|QUERY", "rigid", *value_options("time"), words=True
    )


def folding_options(command: Command) -> Command:
    """Add the same for a folding whose motion has no time limit, with any joining of flat pairs."""
    return _options(command, "DESIGN:CREASE|FILE.toml|FILE.fold", "either")


def circuit_options(command: Command) -> Command:
    """Add the same for a circuit whose foldings are all tried."""
    return _options(command, "FILE.fold|FILE.toml|CIRCUIT", "either", *value_options("time"))


def proof_options(command: Command) -> Command:
    """Add the same for a folding whose motion is proved, without loads on its panels."""
    return _panel_options(command, "DESIGN:CREASE|FILE.toml|FILE.fold", "either")


def linkage_options(command: Command) -> Command:
    """Add the same for the linkage of a folding or an assembly, without loads on its panels."""
    return _panel_options(command, "DESIGN:CREASE|ASSEMBLY|FILE.toml|FILE.fold", "rigid")


def _options(command: Command, names: str, flat_pairs: str, *own: Command, words: bool = False) -> Command:
    """Add the options of all subjects under loads, and the options of a command; the last one is first in the help."""
    return _panel_options(command, names, flat_pairs, *own, *value_options("loads"), words=words)


def _panel_options(command: Command, names: str, flat_pairs: str, *own: Command, words: bool = False) -> Command:
    """Add the subject as argument, options for panels and flat pairs, and others.

    words : whether the subject may be several words. The hidden `--merge` means `--flat-pairs merged`.
    """

    @wraps(command)
    def run(*args: Any, merge: bool, **options: Any) -> Any:
        if merge and options["flat_pairs"] == "hinged":
            raise HcsearchError("a merged flat pair has no hinge: leave out --merge, or --flat-pairs hinged")
        return command(*args, **options | ({"flat_pairs": "merged"} if merge else {}))

    several: dict[str, Any] = {"nargs": -1, "required": True, "callback": joined_words} if words else {}
    decorators: tuple[Command, ...] = (
        database_option,
        click.option("--merge", is_flag=True, hidden=True),
        click.option(
            "--flat-pairs",
            type=click.Choice(WAYS),
            help="How the two panels at each flat crease are joined; merged joins all mirror pairs of panels.  "
            f"[default: {flat_pairs}]",
        ),
        *own,
        scene_options,
        click.argument("name", metavar=names, **several),
    )
    for decorator in decorators:
        run = decorator(run)
    return run


def case_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return these options as arguments of the Python functions, with values of the scene by name."""
    arguments = named_options(options)
    values: dict[str, Any] = arguments.pop("values")
    return arguments | values


def named_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same arguments, with the values of the scene in a dict `values`."""
    others = ("db", "scene", "panel", "flat_pairs")
    values = {key: options[key] for key in SCENE_VALUES if key not in others and options.get(key) is not None}
    return {option: options[option] for option in others} | {"values": values}


def resolve_named(name: str, options: Mapping[str, Any], *, path: bool = False) -> Case:
    """Resolve the argument and options to a case by `resolve`."""
    from hcsearch.subjects.resolve import resolve

    return resolve(name, **named_options(options), path=path)
