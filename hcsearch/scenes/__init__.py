"""Scenes: what acts on the panels of an array, as it is written (`Scene`), and in numbers of a linkage (`Setup`)."""

from hcsearch.scenes.scene import DEFAULT_SCENE_NAME, SCENES, Scene, check_verdicts, joined_name, panel_of, with_panel

__all__ = ["DEFAULT_SCENE_NAME", "SCENES", "Scene", "check_verdicts", "joined_name", "panel_of", "with_panel"]
