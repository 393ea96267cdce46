"""The folding player: a motion as plain data, and a page that shows it in three dimensions."""

from hcsearch.web.player.page import motion_json, notebook_html, player_html, player_script
from hcsearch.web.player.payload import Payload, payload_of, replay_in

__all__ = ["Payload", "motion_json", "notebook_html", "payload_of", "player_html", "player_script", "replay_in"]
