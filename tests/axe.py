"""Accessibility of pages of a folder, by axe-core in Chromium: without it tests fail, they are not skipped."""

import json
import shutil
import subprocess
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from queue import Queue
from threading import Thread

from tests.report.browser import QUIET

# Each page is opened in a frame of each width, as the browser's own window is never narrower than 500 px.
DRIVER = """<!doctype html><html lang="en"><title>axe</title><body><script>
const left = (frame) => new Promise((resolve) => { frame.onload = resolve; });
const check = async (page, theme, width) => {
    const frame = document.createElement("iframe");
    frame.width = width;
    frame.height = 900;
    frame.src = page;
    document.body.append(frame);
    await left(frame);
    const { contentDocument: text, contentWindow: view } = frame;
    text.documentElement.dataset.theme = theme;
    const style = text.createElement("style");
    style.textContent = "* { transition: none !important; }";  // colours are those at the end
    text.head.append(style);
    view.eval(AXE);
    const { violations } = await view.axe.run(text);
    const found = violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html.slice(0, 200))]);
    const wide = text.documentElement.scrollWidth > width ? [["wider than the window"]] : [];
    frame.remove();
    return [`${page} ${theme} ${width}`, [...found, ...wide]];
};
(async () => {
    window.AXE = await (await fetch("/axe.js")).text();
    const results = [];
    try {
        for (const words of WORDS) results.push(await check(...words));
    } catch (error) {
        results.push([String(error), [["error"]]]);
    }
    fetch("/results", { method: "POST", body: JSON.stringify(results) });
})();
</script></body></html>"""


def faults(folder, pages, script, profile, themes=("light", "dark"), widths=(1400, 390)):
    """Violations of rules by pages of a folder, by page, theme and width; pages scroll sideways if they are too wide.

    script : of axe-core. profile : an empty folder for the browser.
    """
    words = [[page, theme, width] for page in pages for theme in themes for width in widths]
    results = Queue()

    class Handler(SimpleHTTPRequestHandler):
        def do_GET(self):
            own = {"/axe.js": script, "/axe.html": DRIVER.replace("WORDS", json.dumps(words))}.get(self.path)
            if own is None:
                return super().do_GET()
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            return self.wfile.write(own.encode())

        def do_POST(self):
            results.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_):
            pass

    program = shutil.which("chromium")
    assert program, "chromium is not installed: apt-get install chromium"
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=folder)) as server:
        Thread(target=server.serve_forever).start()
        own = ["--remote-debugging-port=0", f"--user-data-dir={profile}", "--window-size=1500,1000"]
        address = f"http://127.0.0.1:{server.server_port}/axe.html"
        browser = subprocess.Popen([program, *QUIET, *own, address], stderr=subprocess.DEVNULL)
        try:
            return {name: found for name, found in results.get(timeout=300) if found}
        finally:
            browser.kill()
            browser.wait()
            server.shutdown()
