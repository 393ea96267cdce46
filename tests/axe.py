"""Accessibility of pages in Chromium, by axe-core; the fixture `axe_script` of tests/conftest.py installs it."""

import json
import subprocess
from itertools import product

from tests.player.browser import TWO_FRAMES

PACKAGE = "axe-core@4.11.0"
HEIGHT = 900

RUN = """(async () => {
    const options = %s;
    await Promise.all(document.getAnimations().map(({ finished }) => finished));  // colours are those at the end
    const { violations } = await axe.run(document, { resultTypes: ["violations"], ...options });
    const found = violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html.slice(0, 200))]);
    const wide = document.documentElement.scrollWidth > innerWidth ? [["wider than the window"]] : [];
    return [...found, ...wide];
})()"""
OPEN_DETAILS = "document.querySelectorAll('details').forEach((part) => { part.open = true; })"


def install(folder):
    """Install axe-core in a folder where it is not there, and return its script. Needs npm: without it tests fail."""
    script = folder / "node_modules" / "axe-core" / "axe.min.js"
    if not script.exists():
        words = ["npm", "install", "--no-audit", "--no-fund", "--silent", "--prefix", str(folder), PACKAGE]
        subprocess.run(words, check=True, timeout=300)
    return script.read_text(encoding="utf-8")


def faults(tab, pages, script, themes=("light", "dark"), widths=(1400, 390)):
    """Violations of rules by pages, by address, theme and width; pages scroll sideways if they are too wide.

    tab : of `chromium`. pages : addresses, each with an expression that becomes true once its content is there.
    """

    def show(theme, width):
        media = {"prefers-color-scheme": theme, "prefers-reduced-motion": "reduce"}  # nothing plays, which is slow here
        tab.call("Emulation.setEmulatedMedia", features=[{"name": name, "value": to} for name, to in media.items()])
        size = {"width": width, "height": HEIGHT}
        tab.call("Emulation.setDeviceMetricsOverride", **size, deviceScaleFactor=1, mobile=False)

    found = {}
    for (address, ready), width in product(pages.items(), widths):
        show(themes[0], width)
        tab.open("about:blank")  # else only the part after # would change
        tab.open(address)
        tab.until(ready)
        tab.value(f"{OPEN_DETAILS}; {script}; 0")
        for theme in themes:
            show(theme, width)
            tab.value(TWO_FRAMES)
            rules = {} if theme == themes[0] else {"runOnly": ["color-contrast"]}  # themes differ in colours alone
            wrong = tab.value(RUN % json.dumps(rules))
            if wrong:
                found[address, theme, width] = wrong
    return found
