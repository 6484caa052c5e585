"""Serve a page of results on the loopback address, to requests with the token, while the program runs.

The page polls for data that a running writer has added. Requests must have the token and a host name of this machine:
other pages in the same browser may send requests here, but know neither.
"""

import hmac
import json
import os
import secrets
import sys
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Lock
from typing import Any
from urllib.parse import parse_qs, urlsplit

from mecano.errors import ResultsError
from mecano.post.animation import page_data, page_text
from mecano.post.runs import opened_runs

LOOPBACK = "127.0.0.1"
SHARE = 0.1  # largest share of one processor for data that change during a run
WAITING = '<!DOCTYPE html><meta charset="utf-8"><meta http-equiv="refresh" content="1"><title>mecano</title>{}'


class Source:
    """Data of a page from the results file ``path``, updated when the file has changed, within SHARE of a processor."""

    def __init__(self, path: str | os.PathLike[str], title: str | None = None, status: str | None = None):
        self.path, self.title, self.status = Path(path), title, status
        self._lock, self._next = Lock(), 0.0
        self._key: list[int] = []  # the state of the file when the data were read
        self._data: dict[str, Any] | None = None

    def data(self) -> dict[str, Any]:
        """Return the current data of the page, with a key that changes with them. Raises ResultsError."""
        with self._lock:
            data = self._data
            if data is None or (time.monotonic() >= self._next and self._changed(data)):
                begun = time.thread_time()  # a busy machine does not count
                data = self._data = self._read()
                self._next = time.monotonic() + (time.thread_time() - begun) / SHARE
            return data

    def _changed(self, data):
        """Return whether the ``data`` may have changed; the file of a killed run no longer changes."""
        return data["growing"] or self._key != self._file_signature()

    def _file_signature(self):
        """Return data that change whenever the file changes."""
        found = self.path.stat()
        return [found.st_ino, found.st_size, found.st_mtime_ns]

    def _read(self):
        """Return the data of the page, read from the file."""
        key = self._file_signature()
        with opened_runs([self.path]) as [run]:
            data = page_data(run, title=self.title)
            status = run.results.status
        growing = status == "running"
        self._key = key
        data |= {"growing": growing, "key": "-".join(map(str, [*key, status]))}
        return data | {"status": self.status} if self.status else data


class Server(ThreadingHTTPServer):
    """Server of one page at ``address``, on a free port of the loopback address.

    ``pause`` is called twice a second and after requests; it may raise to end the server.
    """

    daemon_threads = True

    def __init__(self, source: Source, pause: Callable[[], object] = lambda: None):
        super().__init__((LOOPBACK, 0), _Handler)
        self.source, self.token = source, secrets.token_urlsafe(18)
        self._pause = pause
        self.hosts = {f"{name}:{self.server_port}" for name in (LOOPBACK, "localhost")}

    def service_actions(self) -> None:
        """Call ``pause``."""
        self._pause()

    @property
    def address(self) -> str:
        """Address of the page, with the token."""
        return f"http://{LOOPBACK}:{self.server_port}/?token={self.token}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a connection that the browser has closed; report other errors on the terminal."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    server: Server

    def do_GET(self) -> None:
        """Answer GET "/" with the page and "/data" with the data of a run; 403 for a wrong host or token, else 404."""
        url = urlsplit(self.path)
        query = {name: values[-1] for name, values in parse_qs(url.query).items()}
        answers = {"/": self._page, "/data": self._data}
        if self.headers.get("Host") not in self.server.hosts or not self._knows(query.get("token", "")):
            self._answer(403, "text/plain", "mecano: use the address that the program printed\n")
        elif url.path not in answers:
            self._answer(404, "text/plain", "mecano: there is no such page\n")
        else:
            answers[url.path](query)

    def _knows(self, token):
        return hmac.compare_digest(token.encode(), self.server.token.encode())

    def _page(self, query):
        try:
            data = self.server.source.data() | {"live": f"/data?token={self.server.token}"}
        except (ResultsError, OSError) as error:
            text = str(error).replace("&", "&amp;").replace("<", "&lt;")
            self._answer(200, "text/html", WAITING.format(f"<p>Waiting for the first saved times: {text}"))
            return
        self._answer(200, "text/html", page_text(data))

    def _data(self, query):
        try:
            data = self.server.source.data()
        except (ResultsError, OSError):
            data = {"key": query.get("key")}  # between two files: report no change
        if query.get("key") == data["key"]:
            self._answer(204, "application/json", "")
        else:
            self._answer(200, "application/json", json.dumps(data))

    def _answer(self, code, kind, text):
        body = text.encode()
        self.send_response(code)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: Any) -> None:
        """Suppress log messages, as the terminal shows those of the run."""


def serve(source: Source, announce: Callable[[str], object], pause: Callable[[], object] = lambda: None) -> None:
    """Serve the page of a Source until a signal ends the program or ``pause`` raises an exception.

    ``announce`` is called with the address.
    """
    with Server(source, pause) as server:
        announce(server.address)
        server.serve_forever()
