"""The folding player: motions as plain data, and pages that show them in three dimensions."""

from hcsearch.web.player.player_data import Payload, payload_of, replay_in
from hcsearch.web.player.player_page import motion_json, notebook_html, player_html, player_script

__all__ = ["Payload", "motion_json", "notebook_html", "payload_of", "player_html", "player_script", "replay_in"]
