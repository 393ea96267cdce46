"""Scenes by name: built-in, from a file or from a database, with panels of a given size."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from hcsearch.basics.errors import DatabaseError, SceneError
from hcsearch.designs.panel_sizes import PanelSize, is_panel, panel_text, read_panel
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES, Scene, joined_name, with_panel
from hcsearch.scenes.looks import variant_parts
from hcsearch.scenes.scene import check_scene_name, warn_of_panel_size
from hcsearch.scenes.scene_file import read_scene_file, read_scene_text, scene_in
from hcsearch.store import Database, check_scene, find_scene, grids_in, scene_names
from hcsearch.system.terminal import write_notice


def read_scene(text: str | None, database: Database | None, grid: str | None = None) -> Scene:
    """Read a built-in scene, a stored scene or a scene file.

    grid : of the panels, if known.
    """
    if text is None:
        return SCENES[DEFAULT_SCENE_NAME]
    if not text.strip():
        raise SceneError("a scene has a name: write --scene default, or name a file .toml")
    if text.endswith(".toml"):
        return _of_file(text, grid)
    if text not in SCENES and database is not None and text in scene_names(database):
        return stored_scene(database, text)
    parted = _parted(text, grid)
    if parted is not None and _parted(parted[0]) is None:
        name, size = parted
        base = read_scene(name, database) if name else SCENES[DEFAULT_SCENE_NAME]
        return replace(base, panel=size, name=joined_name(base.name, panel_text(size)))
    if text in SCENES:
        return SCENES[text]
    raise SceneError(f"there is no scene {text!r}: choose one of {', '.join(SCENES)}, or name a file .toml")


def scene_asked_for(
    database: Database,
    text: str | None,
    panel: str | None,
    *,
    query: str = "",
    grid: str | None = None,
) -> str:
    """Return the name of the stored scene denoted by options, with panels of a grid or of the grids of a query.

    Without options: `default`, or the only other scene with verdicts in the database, which a line on stderr reports.
    SceneError if the database has verdicts of several scenes, none of them `default`.
    """
    if text is None and panel is None:
        only = only_scene(database)
        write_notice(
            "" if only is None else f"in the scene {only}, the only one that {database.location} has verdicts of"
        )
        if only is None:
            check_scene(database, DEFAULT_SCENE_NAME)
        return only or DEFAULT_SCENE_NAME
    base = DEFAULT_SCENE_NAME if text is None else _of_file(text).name if text.endswith(".toml") else text
    if base not in scene_names(database):
        parted = _parted(base)
        if parted is not None:
            scene, given = parted
            base = joined_name(scene, panel_text(given))
            if base not in scene_names(database):
                warn_of_panel_size(given)
    if panel is None:
        return base
    meant: dict[str, tuple[PanelSize | None, str]] = {}
    refused = None
    for each in grids_in(database, query) if grid is None else [grid]:
        try:
            own = with_panel(SCENES[DEFAULT_SCENE_NAME], read_panel(panel, each), each).panel
        except SceneError as error:  # rectangles need another form of the size
            refused = error
        else:
            meant.setdefault(base if own is None else joined_name(base, panel_text(own)), (own, each))
    if not meant and refused is not None:
        raise refused
    if len(meant) > 1:
        each_of = " or ".join(f"{name!r} ({of})" for name, (_, of) in meant.items())
        raise SceneError(f"these panels are of the scene {each_of}: name the grid, as in grid=hex, or one with --scene")
    ((name, (own, of)),) = meant.items()
    if own is not None and name not in scene_names(database):
        warn_of_panel_size(own, panel, of)
    return name


def only_scene(database: Database) -> str | None:
    """Return the only scene with verdicts in a database; None for several, none, or `default`."""
    names = scene_names(database)
    return names[0] if len(names) == 1 and names[0] != DEFAULT_SCENE_NAME else None


def _parted(text: str, grid: str | None = None) -> tuple[str, PanelSize] | None:
    """Split a name into a scene, possibly empty, and the size of its panels (m); None without a size."""
    name, comma, size = (part.strip() for part in text.rpartition(","))
    return (name, read_panel(size, grid)) if is_panel(size) and bool(name) == bool(comma) else None


def _of_file(path: str, grid: str | None = None) -> Scene:
    content = read_scene_file(path)
    for key in ("design", "assembly"):
        if key in content:
            raise SceneError(
                f"{path} names what is deployed, {key}: give it to hcsearch deploy, or leave that line out"
            )
    scene = scene_in(content, grid=grid)
    scene = replace(scene, name=check_scene_name(content.get("name", Path(path).stem)))
    if variant_parts([scene.name]) != (None, ""):
        raise SceneError(f"{path} has the name {scene.name!r}, which means a way to try a scene: write name = 'solar'")
    if scene.name in SCENES and scene != SCENES[scene.name]:
        raise SceneError(f"{path} is another scene than {scene.name!r}: give it a name of its own, name = 'solar'")
    return scene


def stored_scene(database: Database, name: str) -> Scene:
    """Return a built-in or stored scene by name; SceneError for an unknown one, DatabaseError for a damaged one."""
    if name in SCENES:
        return SCENES[name]
    text = find_scene(database, name)
    if text is None:
        raise SceneError(f"there is no scene {name!r} in {database.location}: see the view `deployments`")
    try:
        return scene_in(read_scene_text(text, f"the scene {name!r}"))
    except SceneError as error:
        raise DatabaseError(
            f"database {database.location} is damaged, {error}; restore a copy, or enumerate anew"
        ) from error
