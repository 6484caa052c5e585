"""The page that plays a motion, in a real browser where Chromium is installed."""

import base64
import json
import re

import numpy as np
import pytest
from browser import browser, dom
from process import mecano_process, settings
from time_runs import INPUTS

from mecano.errors import ResultsError, UsageError
from mecano.post.animation import MOST_FRAMES, animate
from mecano.results.reader import open_results


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A flexible pendulum in four beams, a wheel that drops, a cable without area."""
    folder = tmp_path_factory.mktemp("played")
    for name, *overrides in (
        ("flexible_pendulum", "time.end=0.3", "elements.rod.mesh=4"),
        ("wheel_drop", "time.end=0.2"),
        ("winder", "time.end=0.2"),
    ):
        command = ("run", INPUTS / f"{name}.yaml", "-q", "-o", folder / f"{name}.h5", *settings(*overrides))
        assert mecano_process(*command)[0] == 0
    return folder


def data_of(page):
    return json.loads(re.search(r"const data = (\{.*\});", page.read_text())[1])


def floats(text):
    return np.frombuffer(base64.b64decode(text), "<f4")


def test_points_are_those_of_the_file(results):
    data = data_of(animate(results / "flexible_pendulum.h5", results / "pages" / "rod.html"))
    with open_results(results / "flexible_pendulum.h5") as file:
        time, tip = file.time, file["tip.position"].values
        stress = file["rod.4.stress"].values
    np.testing.assert_allclose(floats(data["times"]), time, rtol=1e-6)
    (rod,) = (shape for shape in data["shapes"] if shape["name"] == "rod")
    raw = np.frombuffer(base64.b64decode(rod["points"]), "<u2").reshape(len(time), rod["count"], 3)
    middle = floats(data["middle"]).reshape(-1, 3)
    places = middle[:, None] + data["size"] * (raw / 32767.5 - 1.0)
    assert rod["count"] == 5
    np.testing.assert_allclose(places[:, -1], tip, rtol=0, atol=data["size"] / 65535)
    np.testing.assert_allclose(floats(rod["colours"]["stress"]).reshape(-1, 4)[:, 3], stress, rtol=1e-6)
    assert [q[:2] for q in data["quantities"]] == [["stress", "Pa"], ["axial force", "N"]]
    assert not data["follow"] and data["up"] == 2 and 1 <= len(data["plots"]) <= 4


def test_a_wheel_has_its_ground_and_its_events(results):
    page = animate(results / "wheel_drop.h5", results / "wheel.html", ["tire.radial_force"])
    data = data_of(page)
    assert len(data["grounds"]) == 3 and len(data["plots"]) == 1 and data["plots"][0]["unit"] == "N"
    assert any("touch down" in text for _, text in data["events"])
    assert len(floats(data["times"])) <= MOST_FRAMES and page.stat().st_size < 500_000


def test_what_others_are_compared_with_lies_behind_them(results):
    """The rate at which the wheel would roll; it is unknown until the wheel touches down."""
    data = data_of(animate(results / "wheel_drop.h5", results / "sheets.html"))
    spin = next(plot for plot in data["plots"] if "spin rate" in plot["label"])
    assert [(name, reference) for name, _, reference in spin["curves"]] == [
        ("tire rolling rate", True), ("tire spin rate", False)
    ]  # fmt: skip
    (_, rolling, _), (_, spinning, _) = spin["curves"]
    assert np.isnan(floats(rolling)[0]) and np.isfinite(floats(rolling)).any() and np.isfinite(floats(spinning)).all()


def test_what_is_zero_throughout_colours_nothing(results):
    """A cable without area has the stress zero: its page begins with its tension."""
    data = data_of(animate(results / "winder.h5", results / "winder.html"))
    assert [q[:2] for q in data["quantities"]] == [["axial force", "N"]]
    assert [list(shape["colours"]) for shape in data["shapes"]] == [["axial force"], [], []]


def test_what_cannot_be_played_is_reported(results, tmp_path):
    with pytest.raises(UsageError, match="ends with .html"):
        animate(results / "wheel_drop.h5", tmp_path / "page.png")
    with pytest.raises(ResultsError, match="cannot write"):
        animate(results / "wheel_drop.h5", "/proc/page.html")


@browser
@pytest.mark.parametrize("name", ["flexible_pendulum", "wheel_drop"])
def test_the_slider_moves_the_mechanism_in_a_browser(results, tmp_path, name):
    """Pictures at three places of the slider differ; nothing asks for a network, and no error is met."""
    page = animate(results / f"{name}.h5", tmp_path / f"{name}.html")
    probe = """
    <script>
    let sums = [], errors = 0;
    window.onerror = () => { errors += 1; };
    for (const share of [0, 0.5, 1]) {
      byId("slider").value = Math.round(share * byId("slider").max);
      byId("slider").dispatchEvent(new Event("input"));
      const canvas = byId("scene");
      const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
      sums.push(pixels.reduce((a, b, i) => (a + b * (i % 65521)) % 1e9, 0));
    }
    const asked = performance.getEntriesByType("resource").length;
    document.title = JSON.stringify([sums, byId("time").textContent, errors, asked]);
    </script>"""
    page.write_text(page.read_text().replace("</body>", probe + "</body>"))
    sums, shown, errors, asked = json.loads(re.search("<title>(.*)</title>", dom(page))[1])
    assert len(set(sums)) == 3 and (errors, asked) == (0, 0)
    with open_results(results / f"{name}.h5") as file:
        assert shown == f"time {file.time[-1]:.4f} s"
