"""Pages served while the program runs: the model before the run, the motion while it is computed."""

import http.client
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from urllib.parse import parse_qs, urlsplit

import h5py
import numpy as np
import pytest
from browser import asked, browser
from process import mecano_process
from time_runs import INPUTS

from mecano.analyses.preview import preview
from mecano.commands.viewing import live
from mecano.deck.read import read_deck
from mecano.errors import ConvergenceError
from mecano.post.serve import LOOPBACK, SHARE, Server, Source, serve
from mecano.process.interrupt import Interruption, Stopped
from mecano.results.reader import open_results

PATIENCE = 120.0  # s: elements may have to be compiled


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "model.h5"
    preview(read_deck(INPUTS / "slider_crank.yaml", ()), path)
    return path


@contextmanager
def serving(path):
    with Server(Source(path)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.shutdown()


def get(server, target, **headers):
    """Status and body of the answer to GET."""
    connection = http.client.HTTPConnection(LOOPBACK, server.server_port, timeout=60)
    connection.request("GET", target, headers=headers)
    answer = connection.getresponse()
    return answer.status, answer.read().decode()


def of_page(text):
    return json.loads(re.search(r"const data = (\{.*\});", text)[1])


@contextmanager
def program(*arguments, folder):
    """A process of mecano and the address that it prints; interrupted at the end, after which it must be gone."""
    command = [sys.executable, "-m", "mecano", *map(str, arguments)]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True, start_new_session=True)
    try:
        yield process, re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", process.stdout.readline())[0]
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        process.stdout.close()


def fetched(address, path="/", **query):
    """Status and text at an address, with its token."""
    parts = urlsplit(address)
    token = parse_qs(parts.query)["token"][0]
    target = f"{path}?token={token}" + "".join(f"&{name}={value}" for name, value in query.items())
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=60)
    connection.request("GET", target)
    answer = connection.getresponse()
    return answer.status, answer.read().decode()


def test_a_preview_has_the_assembled_positions(model, tmp_path):
    """They are those of the first saved time of a run, bit for bit; nothing tells of forces."""
    run = tmp_path / "run.h5"
    assert mecano_process("run", INPUTS / "slider_crank.yaml", "-q", "-o", run, "--set", "time.end=0.01")[0] == 0
    with open_results(model) as before, open_results(run) as after:
        names = before.names("*/position") + before.names("*/center_of_mass")
        assert len(names) > 3
        for name in names:
            np.testing.assert_array_equal(before[name].values[0], after[name].values[0])
        assert not before.names("*/force") and len(before.time) == 1


def test_only_the_token_opens_the_page(model):
    with serving(model) as server:
        token = f"token={server.token}"
        assert get(server, f"/?{token}")[0] == 200
        assert get(server, f"/?{token}", Host=f"localhost:{server.server_port}")[0] == 200
        for target in (
            "/",
            "/?token=",
            f"/?token={server.token[:-1]}",
            f"/?token={server.token}x",
            "/data",
            "/?token=%ff",
        ):
            status, text = get(server, target)
            assert status == 403 and server.token not in text
        for host in ("evil.example", f"evil.example:{server.server_port}", "127.0.0.1"):
            assert get(server, f"/?{token}", Host=host)[0] == 403
        assert get(server, f"/other?{token}")[0] == 404
        assert server.server_address[0] == LOOPBACK


def test_two_pages_have_ports_and_tokens_of_their_own(model):
    with serving(model) as one, serving(model) as other:
        assert one.server_port != other.server_port and one.token != other.token
        assert get(one, f"/?token={other.token}")[0] == 403


@pytest.mark.parametrize("error", [ConnectionResetError, ValueError])
def test_a_browser_that_goes_away_is_no_error(model, monkeypatch, capsys, error):
    """It resets the connection before the answer is written; other errors are reported."""
    closed, done = threading.Event(), threading.Event()

    def data(source):
        assert closed.wait(60.0)
        if error is ValueError:
            raise ValueError("wrong")
        return {"text": 10_000_000 * "x"}

    monkeypatch.setattr(Source, "data", data)
    with serving(model) as server:
        close = server.shutdown_request
        monkeypatch.setattr(server, "shutdown_request", lambda request: (close(request), done.set()))
        with socket.create_connection((LOOPBACK, server.server_port)) as connection:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            request = f"GET /?token={server.token} HTTP/1.0\r\nHost: {LOOPBACK}:{server.server_port}\r\n\r\n"
            connection.sendall(request.encode())
        closed.set()
        assert done.wait(60.0)
    assert ("Traceback" in capsys.readouterr().err) == (error is ValueError)


def test_data_come_again_when_the_file_has_changed(model, tmp_path):
    path = tmp_path / "changing.h5"
    with serving(path) as server:
        token = f"token={server.token}"
        assert "Waiting" in get(server, f"/?{token}")[1]
        path.write_bytes(model.read_bytes())
        data = of_page(get(server, f"/?{token}")[1])
        assert data["live"].endswith(server.token) and not data["growing"]
        assert get(server, f"/data?{token}&key={data['key']}") == (204, "")
        os.utime(path, ns=(1, 1))
        server.source._next = 0.0  # the pause in which little time is spent on data
        status, text = get(server, f"/data?{token}&key={data['key']}")
        assert status == 200 and json.loads(text)["key"] != data["key"]


def test_only_the_own_work_delays_the_next_data(model, monkeypatch):
    """On a busy machine, reading takes longer, but no more of a processor."""
    source, read = Source(model), Source._read

    def interrupted(source):
        time.sleep(1.0)
        return read(source)

    source.data()  # imports
    source._data, source._next = None, 0.0
    monkeypatch.setattr(Source, "_read", interrupted)
    source.data()
    assert source._next < time.monotonic() + 0.5 / SHARE


def test_a_deck_is_shown_until_ctrl_c(tmp_path):
    with program("view", INPUTS / "slider_crank.yaml", folder=tmp_path) as (process, address):
        status, text = fetched(address)
        data = of_page(text)
        assert status == 200 and data["title"] and data["status"].startswith("before the run")
        joints = [shape for shape in data["shapes"] if shape["style"] == "joint"]
        assert joints and all("axis" in shape for shape in joints if shape["kind"] == "hinge")
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 0
    assert os.listdir(tmp_path) == []


def test_an_interrupt_is_not_lost(model):
    """One that is raised where Python ignores exceptions, as while a thread ends, ends the server a moment later."""
    interruption = Interruption()

    def lose():
        with suppress(Stopped):
            interruption._ask(signal.SIGINT, None)

    with pytest.raises(Stopped):
        serve(Source(model), lambda address: lose(), lambda: interruption.raise_if_asked("by Ctrl-C"))


def test_a_killed_run_is_shown_as_killed(model, tmp_path):
    """The file stays as it is when its writer is killed: only the process tells."""
    path = tmp_path / "run.h5"
    path.write_bytes(model.read_bytes())
    with h5py.File(path, "r+") as file:
        file["run/reason"][()], file["run/status"][()] = b"", b"running"
        started = datetime.now(UTC) + timedelta(hours=1)  # the process of the test counts as the writer
        file["run"].attrs["process"], file["run"].attrs["started"] = os.getpid(), started.isoformat()
    source = Source(path)
    before = source.data()
    assert before["growing"] and before["status"].startswith("running")
    began, source._next = os.stat(path).st_mtime_ns, 0.0
    with h5py.File(path, "r+") as file:
        file["run"].attrs["process"] = 4194305  # Linux gives no process this number
    os.utime(path, ns=(began, began))
    after = source.data()
    assert not after["growing"] and after["status"].startswith("killed") and after["key"] != before["key"]


def test_errors_of_view(tmp_path):
    (tmp_path / "bad.yaml").write_text("mecano: 1\nnodes: {a: {position: [0, 0]}}\n")
    assert mecano_process("view", tmp_path / "bad.yaml")[0] == 2
    assert mecano_process("view", tmp_path / "none.h5")[0] == 5
    assert mecano_process("view", tmp_path / "none.yaml")[0] in (2, 5)
    assert mecano_process("view", "--wait", tmp_path / "none.h5", "--set", "time.end=1")[0] == 2


def test_a_run_is_shown_while_it_goes_on(tmp_path):
    """The page grows with the run, is there when it has ended, and leaves the results as they are without it."""
    deck, options = INPUTS / "pendulum.yaml", ["--set", "time.end=60", "--set", "time.step=1e-4", "-q"]
    with program("run", deck, *options, "-o", "live.h5", "--live", folder=tmp_path) as (process, address):
        deadline, shown, data = time.monotonic() + PATIENCE, set(), {"growing": True}
        while data["growing"] and time.monotonic() < deadline:
            text = fetched(address)[1]
            data = of_page(text) if "const data" in text else data
            shown.add(data.get("times"))
            time.sleep(0.05)
        assert not data["growing"] and data["status"] == "complete" and len(shown) > 1
        assert process.poll() is None
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        assert process.wait(PATIENCE) == 0
    assert mecano_process("run", deck, *options, "-o", tmp_path / "plain.h5")[0] == 0
    with open_results(tmp_path / "live.h5") as live, open_results(tmp_path / "plain.h5") as plain:
        assert live.status == plain.status == "complete"
        for name in plain.names():
            np.testing.assert_array_equal(live[name].values, plain[name].values)


def test_the_page_ends_with_a_run_that_is_killed(tmp_path):
    deck = INPUTS / "pendulum.yaml"
    with program("run", deck, "--set", "time.end=1e4", "-q", "-o", "killed.h5", "--live", folder=tmp_path) as (
        process, address,
    ):  # fmt: skip
        process.kill()
        process.wait()
        deadline, refused = time.monotonic() + 20.0, False
        while not refused and time.monotonic() < deadline:
            try:
                fetched(address)
                time.sleep(0.1)
            except OSError:
                refused = True
        assert refused


def test_a_run_without_a_page_imports_none_of_it(tmp_path):
    code = """
import sys
from mecano.cli import main
sys.argv = ["mecano", "run", sys.argv[1], "-q", "-o", sys.argv[2]]
try:
    main()
finally:
    print([name for name in sys.modules if name.startswith(("mecano.post", "http", "socketserver"))])
"""
    command = [sys.executable, "-c", code, INPUTS / "pendulum.yaml", tmp_path / "run.h5"]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.stdout.splitlines()[-1] == "[]"


@browser
def test_the_model_is_seen_with_the_axes_of_its_joints(model, tmp_path):
    page = tmp_path / "page.html"
    with serving(model) as server:
        page.write_text(get(server, f"/?token={server.token}")[1])
    axes, hidden, names, share = asked(page, """
    stage.render();
    const share = byId("view").getBoundingClientRect().height / innerHeight;
    return [solids.axes.visible, byId("play").hidden, motion.shapes.map(shape => shape.name), share];
    """, width=600)  # fmt: skip
    assert axes and hidden and "crankshaft" in names
    assert share > 0.8  # no plots and no slider take room, also on a phone


@pytest.mark.parametrize("written", [True, False])
def test_a_run_that_fails_says_how_to_see_its_motion(written, tmp_path, capsys, monkeypatch):
    class Ended:
        def __init__(self, command, **options):
            pass

        def wait(self):
            """As a process that has ended."""

        terminate = wait

    path = tmp_path / "gear.h5"
    if written:
        path.touch()
    monkeypatch.setattr(subprocess, "Popen", Ended)
    with pytest.raises(ConvergenceError), live(str(path)):
        raise ConvergenceError("no step could be taken")
    assert (f"mecano view {path} shows the motion until the failure" in capsys.readouterr().err) == written
