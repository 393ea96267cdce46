"""Scenes: loads, springs and supports of an array, as written (`Scene`) and evaluated for a linkage (`Setup`)."""

from hcsearch.scenes.scene import DEFAULT_SCENE_NAME, SCENES, Scene, check_verdicts, joined_name, panel_of, with_panel

__all__ = ["DEFAULT_SCENE_NAME", "SCENES", "Scene", "check_verdicts", "joined_name", "panel_of", "with_panel"]
