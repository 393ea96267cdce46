"""Scenes by name: built-in, from a file or from a database, with panels of a given size."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, SceneError
from hcsearch.designs.panel_sizes import PanelSize, is_panel, panel_text, read_panel
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES, Scene, joined_name, with_panel
from hcsearch.scenes.looks import variant_parts
from hcsearch.scenes.scene import check_scene_name, warn_of_panel_size
from hcsearch.scenes.scene_file import SUBJECT_KEYS, read_scene_file, read_scene_text, scene_in
from hcsearch.subjects.names import Place, database_snapshot
from hcsearch.system.terminal import write_notice


def is_scene_file(text: str) -> bool:
    """Whether a text is the name of a scene file."""
    return text.endswith(".toml")


def scene_database(
    scene: Scene | str | None, db: Place | None
) -> AbstractContextManager[tuple[store.Database | None, DatabaseError | None]]:
    """Open the database in which a scene is looked up; none for values, built-in scenes and files."""
    if not isinstance(scene, str) or scene in SCENES or is_scene_file(scene):
        return nullcontext((None, None))
    return database_snapshot(db)


def read_scene(text: str | None, database: store.Database | None, grid: str | None = None) -> Scene:
    """Read a built-in scene, a stored scene or a scene file.

    grid : of the panels, if known.
    """
    if text is None:
        return SCENES[DEFAULT_SCENE_NAME]
    if not text.strip():
        raise SceneError("a scene has a name: write --scene default, or name a file .toml")
    if is_scene_file(text):
        return _of_file(text, grid)
    if text not in SCENES and database is not None and text in store.scene_names(database):
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
    database: store.Database, text: str | None, panel: str | None, *, query: str = "", grid: str | None = None
) -> str:
    """Return the name of the stored scene denoted by options, with panels of a grid or of the grids of a query.

    Without options: `default`, or the only other scene with verdicts in the database, which a line on stderr reports.
    SceneError if the database has verdicts of several scenes, none of them `default`.
    """
    if text is None and panel is None:
        only_name = only_scene(database)
        write_notice(
            ""
            if only_name is None
            else f"in the scene {only_name}, the only one that {database.location} has verdicts of"
        )
        if only_name is None:
            store.check_scene(database, DEFAULT_SCENE_NAME)
        return only_name or DEFAULT_SCENE_NAME
    base = DEFAULT_SCENE_NAME if text is None else _of_file(text).name if is_scene_file(text) else text
    if base not in store.scene_names(database):
        parted = _parted(base)
        if parted is not None:
            scene, size_in_name = parted
            base = joined_name(scene, panel_text(size_in_name))
            if base not in store.scene_names(database):
                warn_of_panel_size(size_in_name)
    if panel is None:
        return base
    candidates: dict[str, tuple[PanelSize | None, str]] = {}
    refused = None
    for grid_name in store.grids_in(database, query) if grid is None else [grid]:
        try:
            size = with_panel(SCENES[DEFAULT_SCENE_NAME], read_panel(panel, grid_name), grid_name).panel
        except SceneError as error:  # rectangles need another form of the size
            refused = error
        else:
            candidates.setdefault(base if size is None else joined_name(base, panel_text(size)), (size, grid_name))
    if not candidates and refused is not None:
        raise refused
    if len(candidates) > 1:
        alternatives = " or ".join(f"{name!r} ({its_grid})" for name, (_, its_grid) in candidates.items())
        raise SceneError(
            f"these panels are of the scene {alternatives}: name the grid, as in grid=hex, or one with --scene"
        )
    ((name, (size, its_grid)),) = candidates.items()
    if size is not None and name not in store.scene_names(database):
        warn_of_panel_size(size, panel, its_grid)
    return name


def only_scene(database: store.Database) -> str | None:
    """Return the only scene with verdicts in a database; None for several, none, or `default`."""
    names = store.scene_names(database)
    return names[0] if len(names) == 1 and names[0] != DEFAULT_SCENE_NAME else None


def _parted(text: str, grid: str | None = None) -> tuple[str, PanelSize] | None:
    """Split a name into a scene, possibly empty, and the size of its panels (m); None without a size."""
    name, comma, size = (part.strip() for part in text.rpartition(","))
    return (name, read_panel(size, grid)) if is_panel(size) and bool(name) == bool(comma) else None


def _of_file(path: str, grid: str | None = None) -> Scene:
    content = read_scene_file(path)
    for key in SUBJECT_KEYS:
        if key in content:
            raise SceneError(
                f"{path} names what is deployed, {key}: give it to hcsearch deploy, or leave that line out"
            )
    scene = scene_in(content, grid=grid)
    scene = replace(scene, name=check_scene_name(content.get("name", Path(path).stem)))
    if variant_parts([scene.name]) != (None, ""):
        raise SceneError(f"{path} has the name {scene.name!r}, which names a variant of a scene: write name = 'solar'")
    if scene.name in SCENES and scene != SCENES[scene.name]:
        raise SceneError(f"{path} differs from the scene {scene.name!r}: give it another name, name = 'solar'")
    return scene


def stored_scene(database: store.Database, name: str) -> Scene:
    """Return a built-in or stored scene by name; SceneError for an unknown one, DatabaseError for a damaged one."""
    if name in SCENES:
        return SCENES[name]
    text = store.find_scene(database, name)
    if text is None:
        raise SceneError(f"there is no scene {name!r} in {database.location}: see the view `deployments`")
    try:
        return scene_in(read_scene_text(text, f"the scene {name!r}"))
    except SceneError as error:
        raise DatabaseError(
            f"database {database.location} is damaged, {error}; restore a copy, or enumerate anew"
        ) from error
