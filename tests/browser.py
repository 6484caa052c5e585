"""Pages rendered by a real browser."""

import html
import json
import os
import queue
import re
import shutil
import signal
import subprocess
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
OPTIONS = """--headless --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run
--disable-background-networking --disable-component-update --disable-sync --hide-scrollbars"""
browser = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")


def dom(page, width=1000):
    """The page, a file, as Chromium leaves it without a network after some seconds of the page's own time."""
    command = [*_command(page.parent, width), "--virtual-time-budget=4000", "--dump-dom", page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120).stdout


def asked(page, script, width=1000, served=False):
    """What ``script``, the body of an async function in the page, returns as plain data.

    ``served``: the page comes from a server of its own, and the script has the time that it needs, as films do.
    """
    report = "fetch('/', { method: 'POST', body: text })" if served else "document.title = text"
    probe = f"""
    <script>
    let errors = [];
    window.addEventListener("error", e => errors.push(e.message));
    const report = told => {{ const text = JSON.stringify(told); {report}; }};
    (async () => {{ {script} }})().then(
      found => report({{ found, errors }}), error => report({{ errors: [String(error)] }}),
    );
    </script>"""
    probed = page.with_name(f"probed_{page.name}")
    probed.write_text(page.read_text().replace("</body>", probe + "</body>"))
    text = _served(probed, width) if served else html.unescape(re.search("<title>(.*)</title>", dom(probed, width))[1])
    reported = json.loads(text)
    assert reported["errors"] == []
    return reported["found"]


def _command(folder, width):
    return [CHROMIUM, *OPTIONS.split(), f"--user-data-dir={folder / 'profile'}", f"--window-size={width},700"]


def _served(page, width):
    """The text that the page posts."""
    posted = queue.Queue()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            self.wfile.write(page.read_bytes())

        def do_POST(self):
            posted.put(self.rfile.read(int(self.headers["Content-Length"])).decode())
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{server.server_port}/"
    command = [*_command(page.parent, width), "--remote-debugging-port=0", address]  # keeps it from ending
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    chromium = subprocess.Popen(command, start_new_session=True, **quiet)
    try:
        return posted.get(timeout=90)
    finally:
        os.killpg(chromium.pid, signal.SIGKILL)
        chromium.wait()
        server.shutdown()
        server.server_close()
