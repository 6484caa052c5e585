"""The page that plays a motion, in a real browser if Chromium is installed."""

import base64
import json
import re

import numpy as np
import pytest
from browser import asked, browser
from process import mecano_process, settings
from time_runs import INPUTS, deck

from mecano.analyses.dynamic import run
from mecano.errors import ResultsError, UsageError
from mecano.post.animation import MOST_FRAMES, animate
from mecano.post.scene import BENT
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
    raw = floats(rod["exact"]).reshape(len(time), rod["count"], 3)  # it can be magnified: not rounded
    (joint,) = (shape for shape in data["shapes"] if shape["style"] == "joint")
    rounded = np.frombuffer(base64.b64decode(joint["points"]), "<u2").reshape(len(time), 1, 3)
    middle = floats(data["middle"]).reshape(-1, 3)
    places = middle[:, None] + data["size"] * raw
    assert rod["count"] == 4 * BENT + 1  # a smooth line through five nodes
    np.testing.assert_allclose(places[:, -1], tip, rtol=0, atol=1e-6 * data["size"])
    pin = middle[:, None] + data["size"] * (rounded / 32767.5 - 1.0)
    np.testing.assert_allclose(pin[:, 0], places[:, 0], rtol=0, atol=1.01 * data["size"] / 65535)
    np.testing.assert_allclose(floats(rod["colours"]["stress"]).reshape(-1, 4)[:, 3], stress, rtol=1e-6)
    assert [q[:2] for q in data["quantities"]] == [["stress", "Pa"], ["axial force", "N"]]
    assert not data["follow"] and data["up"] == [0, 0, 1] and 1 <= len(data["plots"]) <= 4


def test_a_wheel_has_its_ground_and_its_events(results):
    page = animate(results / "wheel_drop.h5", results / "wheel.html", ["tire.radial_force"])
    data = data_of(page)
    [(sides, bars)] = data["grounds"]
    left, right = floats(sides).reshape(2, -1, 3)
    ends = floats(bars).reshape(-1, 2, 3)
    np.testing.assert_allclose(ends[0], (left[0], right[0]))
    np.testing.assert_allclose(np.linalg.norm(np.diff(ends, axis=0), axis=2), 0.25 * data["size"], rtol=1e-5)
    assert len(data["plots"]) == 1 and data["plots"][0]["unit"] == "N"
    assert any("touch down" in event["name"] for event in data["events"])
    assert len(floats(data["times"])) <= MOST_FRAMES and page.stat().st_size < 1_500_000


def test_reference_curves_are_drawn_behind_others(results):
    """The rate at which the wheel would roll; it is unknown until the wheel touches down."""
    data = data_of(animate(results / "wheel_drop.h5", results / "sheets.html"))
    spin = next(plot for plot in data["plots"] if "spin rate" in plot["label"])
    assert [(name, reference) for name, _, reference in spin["curves"]] == [
        ("tire rolling rate", True), ("tire spin rate", False)
    ]  # fmt: skip
    (_, rolling, _), (_, spinning, _) = spin["curves"]
    assert np.isnan(floats(rolling)[0]) and np.isfinite(floats(rolling)).any() and np.isfinite(floats(spinning)).all()


def test_a_quantity_that_is_zero_throughout_is_not_offered_as_a_colour(results):
    """A cable without area has the stress zero: its page begins with its tension."""
    data = data_of(animate(results / "winder.h5", results / "winder.html"))
    assert [q[:2] for q in data["quantities"]] == [["axial force", "N"]]
    assert [list(shape["colours"]) for shape in data["shapes"]] == [["axial force"], [], []]


def test_what_cannot_be_played_is_reported(results, tmp_path):
    with pytest.raises(UsageError, match="end with .html"):
        animate(results / "wheel_drop.h5", tmp_path / "page.png")
    with pytest.raises(ResultsError, match="cannot write"):
        animate(results / "wheel_drop.h5", "/proc/page.html")


PICTURE = """
    const picture = () => { stage.render(); return stage.canvas.toDataURL(); };
"""


@browser
@pytest.mark.parametrize("name", ["flexible_pendulum", "wheel_drop"])
def test_the_slider_moves_the_mechanism_in_a_browser(results, tmp_path, name):
    """Pictures at three places of the slider differ; nothing asks for a network, and no error is met."""
    page = animate(results / f"{name}.h5", tmp_path / f"{name}.html")
    pictures, shown, requests = asked(page, PICTURE + """
    const pictures = [];
    for (const share of [0, 0.5, 1]) {
      byId("slider").value = Math.round(share * byId("slider").max);
      byId("slider").dispatchEvent(new Event("input"));
      pictures.push(picture());
    }
    return [pictures, byId("time").textContent, performance.getEntriesByType("resource").length];
    """)  # fmt: skip
    assert len(set(pictures)) == 3 and requests == 0
    with open_results(results / f"{name}.h5") as file:
        assert shown == f"time {file.time[-1]:.4f} s"


@browser
def test_ticks_of_repeated_events_are_short(results, tmp_path):
    """13 limits beside a lock."""
    page = animate(results / "wheel_drop.h5", tmp_path / "ticks.html")
    found = asked(page, """
    data.events = [{ time: 0, element: "h", name: "locks" }];
    for (let i = 0; i < 13; i++) data.events.push({ time: 0.01 * i, element: "u", name: "limit" });
    showEvents();
    return [...byId("ticks").children].map(tick => tick.className);
    """)  # fmt: skip
    assert found == [""] + ["repeated"] * 13


@browser
def test_keys_play_step_and_choose(results, tmp_path):
    page = animate(results / "wheel_drop.h5", tmp_path / "keys.html")
    found = asked(page, """
    const press = (key, more) => document.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, ...more }));
    const frames = [];
    const shift = { shiftKey: true };
    for (const [key, more] of [["End"], ["ArrowLeft"], ["Home"], ["ArrowRight"], ["ArrowRight", shift], ["n"]]) {
      press(key, more);
      frames.push(player.frame);
    }
    press(" ");
    const playing = player.playing;
    press(" ");
    press("a"); press("?");
    const event = motion.frameAt(data.events[0].time);
    return [frames, playing, player.playing, solids.arrows.visible, byId("help").hidden, motion.count, event];
    """)  # fmt: skip
    frames, playing, stopped, arrows, hidden, count, event = found
    assert frames == [count - 1, count - 2, 0, 1, 11, event]
    assert (playing, stopped, arrows, hidden) == (True, False, True, False)


@browser
def test_the_keyboard_reaches_buttons_and_keeps_its_place(results, tmp_path):
    """Names of events are buttons; space presses the one in focus, which stays in focus after any key."""
    page = animate(results / "wheel_drop.h5", tmp_path / "focus.html")
    found = asked(page, """
    const down = key => new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true });
    const press = (target, key) => target.dispatchEvent(down(key));
    const entry = byId("legend").querySelector("button"), seen = [];
    entry.focus({ focusVisible: true });
    seen.push(press(entry, " "), player.playing);  // true: the browser presses the button
    entry.click();
    press(entry, "ArrowLeft");
    seen.push(player.frame, document.activeElement === entry, motion.frameAt(data.events[0].time));
    return seen;
    """)  # fmt: skip
    left, playing, frame, kept, event = found
    assert (left, playing, kept) == (True, False, True) and frame == event - 1


@browser
@pytest.mark.parametrize("time_step", [1e-5, 1e-3, 0.5])
def test_neighbouring_times_have_different_texts(results, tmp_path, time_step):
    page = animate(results / "wheel_drop.h5", tmp_path / "times.html")
    data = data_of(page)
    times = time_step * np.arange(len(floats(data["times"])))
    data["times"] = base64.b64encode(times.astype("<f4").tobytes()).decode()
    page.write_text(re.sub(r"const data = \{.*\};", lambda _: f"const data = {json.dumps(data)};", page.read_text()))
    texts = asked(page, "return [4, 5, 6].map(frame => { show(frame); return byId('time').textContent; });")
    assert len(set(texts)) == 3 and all(len(text) < 20 for text in texts)


WITHOUT_WEBGL = """<body><script>
const context = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith("webgl") ? null : context.call(this, kind, ...more);
};
</script>"""


@browser
def test_without_3d_graphics_the_curves_remain(results, tmp_path):
    page = animate(results / "wheel_drop.h5", tmp_path / "flat.html")
    page.write_text(page.read_text().replace("<body>", WITHOUT_WEBGL))
    message, view, plots, event, frame, asked_for = asked(page, """
    document.dispatchEvent(new KeyboardEvent("keydown", { key: "n", bubbles: true }));
    const width = id => byId(id).getBoundingClientRect().width, frame = player.frame;
    byId("film").click();
    return [byId("missing").textContent, width("view"), width("plots") / document.body.clientWidth,
      motion.frameAt(data.events[0].time), frame, byId("status").textContent];
    """)  # fmt: skip
    assert message == "no view in space: this browser has no 3D graphics (WebGL)"
    assert view == 0 and plots > 0.9 and frame == event > 0
    assert asked_for == "this browser cannot record films"


@browser
def test_a_body_that_travels_over_no_ground_passes_lines_at_rest(results, tmp_path):
    """The lines move against the body that the view follows as far as it travels; a pendulum has none."""
    page = animate(results / "wheel_drop.h5", tmp_path / "lines.html")
    data = data_of(page)
    middle = np.zeros((len(floats(data["times"])), 3), "<f4")
    middle[:, 0] = np.linspace(0.0, 40.0 * data["size"], len(middle))
    data |= {
        "grounds": [],
        "follow": True,
        "followed": [True, False, False],
        "middle": base64.b64encode(middle.tobytes()).decode(),
    }
    page.write_text(re.sub(r"const data = \{.*\};", lambda _: f"const data = {json.dumps(data)};", page.read_text()))
    lines = """
    const lines = solids.group.children.filter(part => part.isLineSegments);
    return lines.map(part => [0, motion.count - 1].map(frame => { show(frame); return part.position.toArray(); }));
    """
    [(start, end)] = asked(page, lines)
    np.testing.assert_allclose(np.subtract(end, start), (-40.0, 0.0, 0.0), atol=1e-4)
    assert asked(animate(results / "flexible_pendulum.h5", tmp_path / "still.html"), lines) == []


@browser
def test_the_view_holds_the_whole_motion(results, tmp_path):
    """All points of all frames are within the picture, and it is filled to more than half in one direction."""
    page = animate(results / "flexible_pendulum.h5", tmp_path / "fit.html")
    low, high = asked(page, """
    stage.render();
    const seen = stage.cloud().map(p => p.project(stage.camera)).map(p => Math.max(Math.abs(p.x), Math.abs(p.y)));
    return [seen.reduce((a, b) => Math.min(a, b)), seen.reduce((a, b) => Math.max(a, b))];
    """)  # fmt: skip
    assert 0.5 < high <= 1.0 and low >= 0.0


@browser
def test_a_single_point_does_not_fill_the_view(results, tmp_path):
    """It has room of half a metre on all sides; beside another shape a share of the size of both."""
    page = animate(results / "winder.h5", tmp_path / "point.html")
    alone, beside = asked(page, """
    const point = motion.shapes.find(shape => shape.count === 1);
    motion.count = 1;
    const width = shapes => {
      motion.shapes = shapes;
      const x = stage.cloud().map(place => place.x);
      return Math.max(...x) - Math.min(...x);
    };
    return [width([point]), width([point, point])];
    """)  # fmt: skip
    assert alone == pytest.approx(1.0, rel=1e-6) and beside == pytest.approx(0.12, rel=1e-5)


@browser
def test_magnified_deformation_leaves_what_is_held(results, tmp_path):
    """The hinge of the pendulum stays where it is; its tip goes ten times as far from the straight rod."""
    page = animate(results / "flexible_pendulum.h5", tmp_path / "bent.html")
    plain, magnified = asked(page, """
    const rod = motion.shapes.find(shape => shape.rest), frame = motion.count - 1, found = [];
    for (const m of [1, 10]) {
      motion.magnification = m;
      const place = i => motion.point(rod, i, frame, new THREE.Vector3()).toArray();
      found.push([0, rod.count >> 1, rod.count - 1].map(place));
    }
    return found;
    """)  # fmt: skip
    plain, magnified = np.array(plain), np.array(magnified)

    def sag(points):  # of the middle under the chord
        chord = points[2] - points[0]
        return np.linalg.norm(np.cross(points[1] - points[0], chord)) / np.linalg.norm(chord)

    assert np.abs(magnified[0] - plain[0]).max() < 1e-3 * np.abs(magnified[2] - plain[2]).max()
    assert sag(magnified) == pytest.approx(10 * sag(plain), rel=0.1)  # the chord of the magnified rod turns a little


@browser
def test_names_are_shown_where_the_pointer_is(results, tmp_path):
    page = animate(results / "wheel_drop.h5", tmp_path / "names.html")
    name = asked(page, """
    stage.render();
    const wheel = motion.shapes.find(shape => shape.style === "wheel"), box = stage.canvas.getBoundingClientRect();
    const centre = motion.point(wheel, wheel.count - 1, 0, new THREE.Vector3()).project(stage.camera);
    const [u, v] = [0.5 * (1 + centre.x), 0.5 * (1 - centre.y)];
    const at = { clientX: box.left + u * box.width, clientY: box.top + v * box.height, bubbles: true };
    byId("view").dispatchEvent(new PointerEvent("pointermove", at));
    return byId("name").textContent;
    """)  # fmt: skip
    assert name.endswith("tire")


@browser
def test_a_film_is_recorded_by_a_busy_machine(results, tmp_path):
    """The browser stands still for longer than the film lasts."""
    page = animate(results / "wheel_drop.h5", tmp_path / "film.html")
    size = asked(page, """
    byId("speed").value = 0.2;
    const frame = () => new Promise(requestAnimationFrame), saved = () => film.saved !== undefined;
    film.start();
    await frame();
    await frame();
    for (const end = performance.now() + 1500; performance.now() < end; );
    for (let i = 0; i < 1600 && !saved(); i++) await new Promise(done => setTimeout(done, 50));
    return saved() ? film.saved : -1;
    """, width=500)  # fmt: skip
    assert size > 1000


@browser
@pytest.mark.parametrize("width", [500, 1280])
def test_the_page_fits_a_narrow_window(results, tmp_path, width):
    """500 px is the narrowest window of this browser; the page is put in a frame of 400."""
    page = animate(results / "wheel_drop.h5", tmp_path / "narrow.html")
    if width == 500:
        page.write_text(page.read_text().replace("</head>", "<style>html { width: 400px }</style></head>"))
    over, view, texts = asked(page, """
    const limit = document.documentElement.clientWidth;
    const over = [...document.querySelectorAll("header, main, footer, button, select, label, .plot")]
      .filter(e => e.getBoundingClientRect().right > limit + 1).map(e => e.id || e.className);
    return [over, byId("view").getBoundingClientRect().width, parseFloat(getComputedStyle(document.body).fontSize)];
    """, width=width)  # fmt: skip
    assert over == [] and view >= 300 and texts >= 13


@browser
def test_plots_have_room_for_legends_and_numbers_at_their_axes(results, tmp_path):
    """Each curve of the plots is drawn four times more; numbers at axes have up to six digits, small ones a power."""
    page = animate(results / "wheel_drop.h5", tmp_path / "many.html")
    data = data_of(page)
    for panel in data["plots"]:
        panel["curves"] = [[f"{name} number {i}", *rest] for i in range(5) for name, *rest in panel["curves"]]
    page.write_text(re.sub(r"const data = \{.*\};", lambda _: f"const data = {json.dumps(data)};", page.read_text()))
    beyond, numbers = asked(page, """
    return [[...document.querySelectorAll(".plot")].map(panel =>
      panel.querySelector(".u-legend").getBoundingClientRect().bottom - panel.getBoundingClientRect().bottom),
      [0, 2e-9, 0.1 + 0.2, 63.1765, -25000].map(atAxis)];
    """)  # fmt: skip
    assert beyond and max(beyond) <= 1.0
    assert numbers == ["0", "2e-9", "0.3", "63.1765", "-25000"]


@browser
def test_rounding_errors_beside_the_curves_are_zero(results, tmp_path):
    """The first curve of the first panel at the instant shown: 1e-12 of its largest value, and then 1e-3 of it."""
    page = animate(results / "wheel_drop.h5", tmp_path / "small.html")
    data = data_of(page)
    for share, expected in ((1e-12, "0"), (1e-3, "0.001")):
        for panel in data["plots"]:
            values = np.ones(len(floats(data["times"])), "<f4")
            values[0] = share
            panel["curves"] = [["one", base64.b64encode(values).decode(), *panel["curves"][0][2:]]]
        text = json.dumps(data)
        page.write_text(re.sub(r"const data = \{.*\};", lambda _, text=text: f"const data = {text};", page.read_text()))
        shown = asked(page, 'return document.querySelectorAll(".plot .u-legend .u-value")[1].textContent;')
        assert shown == expected


@browser
def test_a_released_joint_is_not_there(tmp_path):
    """The radii of the pin of a hold-down while it holds, and after its release."""
    text = """
        mecano: 1
        gravity: none
        nodes: {bus: {position: [0, 0, 0]}, panel: {position: [0, 0, 0]}, edge: {position: [1, 0, 0]}}
        elements:
          bus: {type: rigid_body, node: bus, mass: 9, inertia: [1, 1, 1]}
          panel: {type: rigid_body, node: panel, mass: 1, inertia: [0.1, 0.1, 0.1], attached: [edge]}
        joints: {pyro: {type: fixed, nodes: [bus, panel], release: {time: 0.5}}}
        initial: {velocities: [{nodes: [panel, bus], velocity: [1, 0, 0]}]}
        time: {end: 1, step: 0.1}
        """
    run(deck(text), tmp_path / "pyro.h5")
    found = asked(animate(tmp_path / "pyro.h5", tmp_path / "pyro.html"), """
    const radii = [];
    for (const share of [0, 1]) {
      byId("slider").value = Math.round(share * byId("slider").max);
      byId("slider").dispatchEvent(new Event("input"));
      stage.render();
      radii.push(Math.hypot(...solids.axes.instanceMatrix.array.slice(0, 3)));
    }
    return radii;
    """)  # fmt: skip
    assert found[0] > 0.0 and found[1] == 0.0
