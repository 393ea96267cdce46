"""`--scene` and `--panel`: the scene that a command works in or asks about."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

import click

from hcsearch.basics.errors import SceneError

Command = Callable[..., Any]


def scene_options(command: Command) -> Command:
    """Add `--scene` and `--panel`; `--across WxT`, which help does not show, is `--panel 'across WxT'`."""

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
            "the width across flats (of triangles, the height) and the thickness.",
        ),
        click.option(
            "--scene",
            metavar="NAME|FILE.toml",
            help="The panels, springs and gravity: a scene such as default or earth, or a file.  [default: default]",
        ),
    ):
        run = option(run)
    return run
