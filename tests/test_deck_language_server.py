"""yaml-language-server, the real one, with the schema of mecano: run where it is on the PATH, as after

npm install yaml-language-server && PATH=$PWD/node_modules/.bin:$PATH pytest -m slow tests/test_deck_language_server.py
"""

import json
import shutil
import subprocess

import pytest
from test_deck_schema import INPUTS, WRONG
from test_study_file import PAGE, WRONG_STUDIES

from mecano.deck.json_schema import deck_schema, schema_text
from mecano.deck.sample_decks import starters
from mecano.study.describe import EXAMPLE, study_schema

SERVER = shutil.which("yaml-language-server")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(SERVER is None, reason="yaml-language-server is not on the PATH")]


class Server:
    """A language server that is spoken to through its standard input and output."""

    def __init__(self, folder):
        self.process = subprocess.Popen([SERVER, "--stdio"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.count = 0
        self.folder = folder
        self.ask("initialize", {"processId": None, "rootUri": None, "capabilities": {}})
        self.tell("initialized", {})

    def send(self, message):
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
        self.process.stdin.flush()

    def receive(self):
        """The next message; questions of the server are answered with nothing."""
        length = 0
        while line := self.process.stdout.readline().strip():
            if line.lower().startswith(b"content-length:"):
                length = int(line.split(b":")[1])
        message = json.loads(self.process.stdout.read(length))
        if "id" in message and "method" in message:
            items = message.get("params", {}).get("items", [])
            self.send({"id": message["id"], "result": [None] * len(items) if items else None})
        return message

    def tell(self, method, params):
        self.send({"method": method, "params": params})

    def ask(self, method, params):
        self.count += 1
        self.send({"id": self.count, "method": method, "params": params})
        while (message := self.receive()).get("id") != self.count or "method" in message:
            pass
        return message["result"]

    def open(self, name, text, schema="mecano"):
        """The address of a deck that is opened with the modeline of docs/decks.md; its diagnostics."""
        address = f"file://{self.folder}/{name}.yaml"
        text = f"# yaml-language-server: $schema={schema}.schema.json\n" + text
        document = {"uri": address, "languageId": "yaml", "version": 1, "text": text}
        self.tell("textDocument/didOpen", {"textDocument": document})
        while True:
            message = self.receive()
            if message.get("method") == "textDocument/publishDiagnostics" and message["params"]["uri"] == address:
                return address, message["params"]["diagnostics"]


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("decks")
    for name, schema in (("mecano", deck_schema()), ("study", study_schema())):
        (folder / f"{name}.schema.json").write_text(schema_text(schema))
    server = Server(folder)
    yield server
    server.process.kill()
    server.process.communicate()


def test_no_diagnostics_for_inputs_and_starters(server):
    decks = {path.stem: path.read_text() for path in INPUTS} | {
        f"new_{name}": text for name, text in starters().items()
    }
    assert len(decks) > 60
    for name, text in decks.items():
        _, diagnostics = server.open(name, text)
        assert diagnostics == [], (name, diagnostics)


def test_diagnostics_for_wrong_decks(server):
    for i, (deck, old, new, _) in enumerate(WRONG):
        _, diagnostics = server.open(f"wrong{i}", deck.replace(old, new, 1))
        lines = deck.replace(old, new, 1).splitlines()
        at = {diagnostic["range"]["start"]["line"] - 1 for diagnostic in diagnostics}
        assert diagnostics, new
        assert any(new.split(":")[0].strip() in lines[line] or "{" in lines[line] for line in at), (new, diagnostics)


def test_study_files(server):
    for i, text in enumerate((EXAMPLE, PAGE)):
        assert server.open(f"study{i}", text, "study")[1] == []
    for i, (old, new, _) in enumerate(WRONG_STUDIES):
        text = EXAMPLE.replace(old, new, 1)
        diagnostics = server.open(f"wrong_study{i}", text, "study")[1]
        at = {diagnostic["range"]["start"]["line"] - 1 for diagnostic in diagnostics}
        assert at & {n for n, line in enumerate(text.splitlines()) if new.split(":")[0] in line} or at == {0}, new


def test_hover_and_completion(server):
    deck = WRONG[2][0]
    address, _ = server.open("hover", deck)
    lines = deck.splitlines()
    line = next(i for i, text in enumerate(lines) if "type: hinge" in text)
    place = {"line": line + 1, "character": lines[line].index("axis") + 1}
    hover = server.ask("textDocument/hover", {"textDocument": {"uri": address}, "position": place})
    assert "axis at the start, inertial" in json.dumps(hover)
    text = "mecano: 1\njoints:\n  pin:\n    type: hinge\n    "
    address, _ = server.open("completion", text)
    place = {"line": 5, "character": 4}
    found = server.ask("textDocument/completion", {"textDocument": {"uri": address}, "position": place})
    assert {"axis", "turning_law", "latch", "friction"} <= {item["label"] for item in found["items"]}
