"""What stands in the script elements of a page: data that no text in it can end, and hashes that admit scripts."""

from __future__ import annotations

import base64
import hashlib
import json


def as_script(value: object) -> str:
    """JSON that may stand in a script element: no `<`, `>` or `&`, so that nothing in it ends the element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for mark in "<>&":
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return text


def digest_of(text: str) -> str:
    """The hash by which a policy of a page admits a script or a style."""
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
