"""Motions as films."""

import os
from dataclasses import replace

import every_kind
import numpy as np
import pytest
from matplotlib import animation, cm
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

from mecano.elements import KINDS
from mecano.errors import ResultsError, UsageError
from mecano.post import film
from mecano.post.animation import animate
from mecano.post.runs import opened_runs
from mecano.post.scene import scene_of
from mecano.post.shapes import BODY, ROD, Shape

SIDE = np.eye(3)[[0, 2]]
SHOWN = {name: KINDS[name] for name in ("beam", "wheel", "hinge")}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return every_kind.write(tmp_path_factory.mktemp("film") / "each.h5", kinds=SHOWN)


def test_the_view_of_a_line_has_room_for_it_and_the_title():
    """A strut that strokes upright, a row of balls, one point at rest."""
    for extent in ((0.0, 1.2), (1.2, 0.0), (0.0, 0.0), (3.0, 2.0)):
        width, height = 2.0 * film.half_widths(np.array(extent))
        assert width > max(extent[0], 0.5 * extent[1]) and height > max(extent[1], 0.15 * extent[0])


@pytest.mark.parametrize(("extent", "across"), [((0.4, 1.2), True), ((1.2, 0.2), False), ((1.0, 0.8), False)])
def test_a_film_has_the_shape_of_its_motion(path, extent, across):
    """An upright one is narrower than high, and the view takes most of the figure, which has even numbers of pixels."""
    with opened_runs([path]) as [run]:
        scene = scene_of(run, 2)
    line = np.array([(0.0, 0.0, 0.0), (extent[0], 0.0, extent[1])])
    scene = replace(scene, shapes=[Shape(ROD, "bar", line[None].repeat(2, axis=0))], colours=[{}], ranges=[])
    figure = Figure()
    film._Picture(replace(scene, grounds=[]), SIDE, figure).arrange(
        "A bar with a title longer than the picture, if upright"
    )
    width, height = figure.get_size_inches()
    place = figure.axes[0].get_position(original=True)
    assert (height > width) == across and place.width * place.height > 0.6
    assert np.all(np.round(film.DOTS * np.array([width, height]), 6) % 2 == 0)
    assert ("\n" in figure.texts[2].get_text()) == across


@pytest.mark.parametrize("ending", [".gif", ".webp", ".mp4"])
def test_frames_show_the_motion(path, tmp_path, monkeypatch, ending):
    """The frames of a film differ, and the colour of the stress is in them."""
    monkeypatch.setattr(film, "FRAMES", 4)
    if not animation.writers.is_available(film.WRITERS[ending]):
        pytest.skip("needs ffmpeg")
    written = animate(path, tmp_path / "films" / f"motion{ending}")
    if ending == ".mp4":
        assert b"ftyp" in written.read_bytes()[:12]
        return
    with Image.open(written) as file:
        frames = [np.asarray(one.convert("RGB"), float) for one in ImageSequence.Iterator(file)]
    assert len(frames) == 4
    for one, other in zip(frames[:-1], frames[1:], strict=True):
        assert 1e-3 < np.mean(np.abs(one - other).max(axis=2) > 60) < 0.3
    coloured = np.ptp(frames[0][:, : frames[0].shape[1] * 3 // 4], axis=2) > 60  # left of the scale
    assert coloured.sum() > 50


def test_all_pieces_of_an_element_have_its_colour(path):
    """A beam of two elements, each of which is drawn as four pieces: as on the page, half of the line has each."""
    with opened_runs([path]) as [run]:
        scene = scene_of(run, 2)
    bar = Shape(ROD, "bar", np.linspace((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 9)[None].repeat(2, axis=0))
    stress = np.array([[1.0, 3.0], [3.0, 1.0]])
    scene = replace(scene, shapes=[bar], colours=[{"stress": stress}], ranges=[("stress", "Pa", 1.0, 3.0)])
    picture = film._Picture(scene, SIDE, Figure())
    low, high = cm.ScalarMappable(Normalize(0.0, 1.0), film.COLOURS).to_rgba([0.0, 1.0])
    for frame, (first, second) in enumerate(((low, high), (high, low))):
        picture.show(frame)
        [line] = set(picture._ax.collections) - picture._still
        np.testing.assert_array_equal(line.get_colors(), [first] * 4 + [second] * 4)


def test_a_body_is_a_closed_outline_around_its_points(path):
    """A square whose corners are listed across, with a point inside."""
    with opened_runs([path]) as [run]:
        scene = scene_of(run, 2)
    corners = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.5, 0.0, 0.4), (0.0, 0.0, 1.0)])
    scene = replace(scene, shapes=[Shape(BODY, "plate", corners[None].repeat(2, axis=0))], colours=[{}], ranges=[])
    scene = replace(scene, grounds=[])
    picture = film._Picture(scene, SIDE, Figure())
    picture.show(0)
    [outline] = picture._ax.lines
    assert len(outline.get_xydata()) == 5 and np.array_equal(outline.get_xydata()[0], outline.get_xydata()[-1])
    assert {tuple(point) for point in outline.get_xydata()} == {tuple(SIDE @ corners[i]) for i in (0, 1, 2, 4)}


def _travelling(path, grounds):
    """Return a picture of a bar of 1 m that travels by 20 m, which the view follows."""
    with opened_runs([path]) as [run]:
        scene = scene_of(run, 2)
    bar = np.array([[(0.0, 0.0, 1.0), (1.0, 0.0, 1.0)], [(20.3, 0.0, 1.0), (21.3, 0.0, 1.0)]])
    scene = replace(scene, shapes=[Shape(ROD, "bar", bar)], colours=[{}], ranges=[], grounds=grounds, size=0.5)
    return film._Picture(replace(scene, middle=bar.mean(axis=1)), SIDE, Figure())


def test_behind_a_body_that_travels_lines_stand_still(path):
    """A grid of round numbers of metres, of which the label names the distance."""
    picture = _travelling(path, [])
    assert picture._scene.followed.tolist() == [True, False, False]
    places = []
    for frame in range(2):
        picture.show(frame)
        low, high = picture._ax.get_xlim()
        places.append([x for x in picture._ax.xaxis.get_majorticklocs() if low <= x <= high])
        np.testing.assert_allclose(np.remainder(places[-1], 0.2), 0.0, atol=1e-9)
    assert min(map(len, places)) > 3 and not set(places[0]) & set(places[1])
    assert all(line.get_visible() for line in picture._ax.get_xgridlines())
    assert picture._scale.get_text() == "lines every 0.2 m"


def test_marks_of_the_ground_stand_still(path):
    """From the side a ground is a line with a hatch; two artists stay when the bar has moved, and no grid is drawn."""
    ground = np.array([[(-2.0, y, 0.0), (23.0, y, 0.0)] for y in (1.0, -1.0)])
    picture = _travelling(path, [ground])
    [hatch] = picture._ax.collections
    before = [segment.copy() for segment in hatch.get_segments()]
    picture.show(0)
    picture.show(1)
    assert hatch in picture._ax.collections and len(picture._ax.collections) == 2
    np.testing.assert_array_equal(before, hatch.get_segments())
    starts = np.array([segment[0] for segment in before])
    np.testing.assert_allclose(np.diff(starts[:, 0]), 0.2)
    np.testing.assert_allclose(starts[:, 1], 0.0, atol=1e-12)
    assert not any(line.get_visible() for line in picture._ax.get_xgridlines())


def test_a_wheel_that_bounces_leaves_its_ground_in_the_view(path):
    """The view follows the 20.3 m along x, but not the 0.5 m upward."""
    scene, up = _travelling(path, [])._scene, np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 0.5)])
    shapes = [replace(shape, points=shape.points + up[:, None]) for shape in scene.shapes]
    picture = film._Picture(replace(scene, shapes=shapes, middle=scene.middle + up), SIDE, Figure())
    views = []
    for frame in range(2):
        picture.show(frame)
        views.append((*picture._ax.get_xlim(), *picture._ax.get_ylim()))
    np.testing.assert_allclose(np.subtract(*views[::-1]), (20.3, 20.3, 0.0, 0.0), atol=1e-12)
    assert views[0][2] < 1.0 and views[0][3] > 1.5


def test_lines_behind_a_film_have_round_distances():
    assert [film._round_length(x) for x in (0.99, 1.0, 4.9, 0.021, 700.0)] == [0.5, 1.0, 2.0, 0.02, 500.0]


def test_a_program_for_films_that_fails_is_an_error_with_its_words(path, tmp_path, monkeypatch):
    """As one built without the codec: the frames are not taken."""
    program = tmp_path / "bin" / "ffmpeg"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\necho 'first line' >&2\necho \"Unknown encoder 'h264'\" >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent), prepend=os.pathsep)
    with pytest.raises(ResultsError, match="ffmpeg fails to write the film: Unknown encoder 'h264'"):
        animate(path, tmp_path / "a.mp4")
    assert [file.name for file in tmp_path.iterdir()] == ["bin"]


def test_what_cannot_be_filmed_is_reported(path, tmp_path, monkeypatch):
    with pytest.raises(UsageError, match="a film has no plots"):
        animate(path, tmp_path / "a.gif", ["one_beam.stress"])
    with pytest.raises(UsageError, match="end with .html, .gif or .webp or .mp4"):
        animate(path, tmp_path / "a.avi")
    with pytest.raises(ResultsError, match="cannot make the folder /proc/films: "):
        animate(path, "/proc/films/a.gif")
    monkeypatch.setattr(animation.writers, "is_available", lambda name: False)
    with pytest.raises(UsageError, match="films need ffmpeg, which is not installed; .html does"):
        animate(path, tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []
