"""Write scene files to start from."""

from __future__ import annotations

import os
from pathlib import Path

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError, OutputError, SceneError
from hcsearch.designs.grid import grid_named
from hcsearch.designs.panel_sizes import ACROSS_FLATS_PREFIX, PanelSize, read_panel
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES, panel_of
from hcsearch.scenes.scene import check_scene_name, warn_of_panel_size, with_size
from hcsearch.scenes.scene_file import scene_template
from hcsearch.system.outputs import write_output


def init_scene(path: str | Path, *, panel: str | None = None, grid: str | None = None) -> Path:
    """Write a commented scene file to start from, as `hcsearch init` does, and return its path.

    Every value of the scene `default` is in it, with its unit. The scene has the name of the file.

    Parameters
    ----------
    path
        A file .toml that does not exist.
    panel
        The size of the panels in millimetres, such as `300x12`; by default it is left open.
    grid
        The grid of the panels, by which their size is checked.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    OutputError
        For a file that exists.
    SceneError
        For a name or a size that a scene cannot have.
    """
    check_kinds(init_scene, locals())
    file = Path(path)
    name = check_scene_name(file.stem)
    if name in SCENES:
        raise SceneError(f"{name} is a scene of the program: name the file otherwise, such as solar.toml")
    if os.path.lexists(file):
        raise OutputError(f"{file} exists: name another file, or delete it first")
    tiling = None if grid is None else grid_named(grid).name
    size = None if panel is None else _panel_size(panel, tiling)
    write_output(file, scene_template(size, grid), (".toml",))
    return file


def _panel_size(panel: str, grid: str | None) -> PanelSize:
    """Read a size of panels, m; HcsearchWarning for a doubtful one."""
    if grid is not None:
        return panel_of(with_size(SCENES[DEFAULT_SCENE_NAME], panel, grid), grid)
    if panel.startswith(ACROSS_FLATS_PREFIX):
        raise HcsearchError("the width across flats depends on the grid: name it with --grid")
    size = read_panel(panel)
    warn_of_panel_size(size, panel)
    return size
