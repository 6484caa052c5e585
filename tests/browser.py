"""Pages rendered by a real browser: one Chromium for each process of tests, which ends with it."""

import atexit
import itertools
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
from contextlib import contextmanager
from functools import cache

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
OPTIONS = """--headless --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run
--disable-background-networking --disable-component-update --disable-sync --hide-scrollbars --remote-debugging-pipe"""
PATIENCE = 120.0  # s: a busy machine
ERRORS = """
    var errors = [];
    window.addEventListener("error", e => e.message.startsWith("ResizeObserver loop") || errors.push(e.message));
"""  # what an observer is not told in one frame, it is told in the next
browser = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")


def asked(page, script, width=1000):
    """What ``script``, the body of an async function in the page (a file), returns as plain data."""
    with _chromium().page(page.as_uri(), width) as evaluated:
        found = evaluated(f"(async () => {{ {script} }})()")
        assert evaluated("errors") == []
    return found


@cache
def _chromium():
    return _Chromium()


class _Chromium:
    """A browser that speaks the Chrome DevTools Protocol, JSON with null bytes in between, through two pipes."""

    def __init__(self):
        self._profile, self._numbers, self._received = tempfile.mkdtemp(), itertools.count(1), b""
        command = [CHROMIUM, *OPTIONS.split(), f"--user-data-dir={self._profile}"]
        shell = ["sh", "-c", 'exec "$@" 3<&0 4>&1 </dev/null >/dev/null', "sh", *command]  # ends with its pipes
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(shell, start_new_session=True, bufsize=0, **pipes)
        atexit.register(self._end)

    def _end(self):
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        shutil.rmtree(self._profile, ignore_errors=True)

    @contextmanager
    def page(self, address, width):
        """Open a page of this width; give the function that evaluates an expression in it."""
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        size = {"width": width, "height": 700, "deviceScaleFactor": 1, "mobile": False}
        self._call("Emulation.setDeviceMetricsOverride", session, **size)
        self._call("Page.enable", session)
        self._call("Page.addScriptToEvaluateOnNewDocument", session, source=ERRORS)
        self._call("Page.navigate", session, url=address)
        while self._message().get("method") != "Page.loadEventFired":
            pass

        def evaluated(expression):
            wanted = {"expression": expression, "awaitPromise": True, "returnByValue": True}
            answer = self._call("Runtime.evaluate", session, **wanted)
            assert "exceptionDetails" not in answer, answer["exceptionDetails"]
            return answer["result"].get("value")

        try:
            yield evaluated
        finally:
            self._call("Target.closeTarget", targetId=target)

    def _call(self, method, session=None, **values):
        """Return the result of a method of the protocol."""
        number = next(self._numbers)
        request = {"id": number, "method": method, "params": values} | ({"sessionId": session} if session else {})
        self._process.stdin.write(json.dumps(request).encode() + b"\0")
        while (answer := self._message()).get("id") != number:
            pass
        assert "error" not in answer, answer
        return answer["result"]

    def _message(self):
        """Return the next message of the browser."""
        while b"\0" not in self._received:
            assert select.select([self._process.stdout], [], [], PATIENCE)[0], "the browser does not answer"
            self._received += self._process.stdout.read(1 << 20)
        message, _, self._received = self._received.partition(b"\0")
        return json.loads(message)
