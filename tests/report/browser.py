"""Pages in a real browser. Needs chromium: without it tests fail, they are not skipped."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

QUIET = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--enable-logging=stderr", "--v=0"),
)


def chromium(page: Path, *options: str, size: str = "1300,900", clock: str = "--virtual-time-budget=4000"):
    """Open a page; `clock` of its own makes pages quick, without it they take real time."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    assert program, "chromium is not installed: apt-get install chromium"
    profile = page.with_name(f"profile-{page.stem}")
    command = [program, *QUIET, clock, f"--window-size={size}", f"--user-data-dir={profile}", *options, page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True, cwd=page.parent)


def complaints(run: subprocess.CompletedProcess[str]) -> list[str]:
    """What a page wrote to its console; what Chromium says there of drawing without a graphics card is left out."""
    lines = [line for line in run.stderr.splitlines() if "CONSOLE" in line]
    return [line for line in lines if "GL Driver Message" not in line and "software WebGL" not in line]


def driven(page: Path, driver: str, name: str = "driven.html", **options: str) -> Any:
    """What a script that uses a page as a reader would left in its object `probe`.

    The page's policy bars the driver, so it runs on a copy without the policy; `await` works in it.
    """
    text, barred = re.subn(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", page.read_text(encoding="utf-8"))
    assert barred == 1
    listen = "<script>window.failures = []; window.onerror = (text) => { window.failures.push(text); };</script>"
    left = 'const place = document.createElement("pre"); place.id = "probe"; place.textContent = JSON.stringify(probe);'
    script = f"(async () => {{ const probe = {{}}; {driver}\nprobe.errors = window.failures; {left}"
    script += " document.body.append(place); })();"
    text = text.replace("<head>", f"<head>{listen}").replace("</body>", f"<script>{script}</script></body>")
    copy = page.with_name(name)
    copy.write_text(text, encoding="utf-8")
    run = chromium(copy, "--dump-dom", **options)
    assert complaints(run) == []
    match = re.search(r'<pre id="probe">(.*?)</pre>', run.stdout, re.DOTALL)
    assert match, run.stdout[-2000:]
    return json.loads(unescape(match[1]))
