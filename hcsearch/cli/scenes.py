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
            help="Size of the panels in mm: width across flats (of triangles, the height) and thickness.",
        ),
        click.option(
            "--panel",
            metavar="LxWxT",
            help="Size of the panels in mm: length, width and thickness, or side and thickness (SxT).",
        ),
        click.option(
            "--scene",
            metavar="NAME|FILE.toml",
            help="The panels, springs and gravity: a scene such as default or earth, or a file.  [default: default]",
        ),
    ):
        command = option(command)
    return command
