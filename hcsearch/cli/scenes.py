"""`--scene`, `--panel` and `--across`: the scene that a command works in or asks about."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

Command = Callable[..., Any]


def scene_options(command: Command) -> Command:
    """`--scene` with `--panel` or `--across`."""
    for option in (
        click.option(
            "--across",
            metavar="WxT",
            help="Panels by their width across flats (of triangles, their height) and thickness, mm.",
        ),
        click.option(
            "--panel",
            metavar="LxWxT",
            help="Panels by length, width, thickness, mm; of hexagons and triangles the side: SxT.",
        ),
        click.option(
            "--scene",
            metavar="NAME|FILE.toml",
            help="default, earth, thesis, a scene of the database, or a file.  [default: default]",
        ),
    ):
        command = option(command)
    return command
