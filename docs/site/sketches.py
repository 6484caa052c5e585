"""Draw the sketches of the documentation: signs of tyres and pulleys, times of a controller, the way of a step.

``python docs/site/sketches.py`` writes them to docs/images.
"""

import math
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Arc, Circle, Rectangle

IMAGES = Path(__file__).parents[1] / "images"
DARK, FORCE, MOTION, LIGHT = "#3c4043", "#c5511a", "#1f6fb2", "#b8b8b8"
SETTINGS = {"font.size": 8, "svg.fonttype": "none", "svg.hashsalt": "mecano", "font.family": "sans-serif"}


def main():
    """Write all sketches."""
    matplotlib.use("svg")
    with plt.rc_context(SETTINGS):
        tyre_axes(IMAGES / "tyre_axes.svg")
        digital_controller(IMAGES / "digital_controller.svg")
        pulley_signs(IMAGES / "pulley_signs.svg")
        step(IMAGES / "step.svg")


def tyre_axes(target):
    """Draw a wheel from its right side, from above and from behind, with axes, motions and forces."""
    figure, panels = plt.subplots(1, 3, figsize=(8.4, 2.9))
    for axes, title, draw in zip(
        panels, ("from the right", "from above", "from behind"), (_side, _top, _rear), strict=True
    ):
        axes.set(aspect="equal", xlim=(-1.7, 1.9), ylim=(-1.45, 1.65))
        axes.set_axis_off()
        axes.set_title(title, fontsize=9, color=DARK)
        draw(axes)
    figure.tight_layout()
    _save(figure, target)


def _side(axes):
    axes.plot([-1.6, 1.8], [-1.0, -1.0], color=LIGHT)
    axes.add_patch(Circle((0, 0), 1.0, fill=False, color=DARK, lw=1.5))
    axes.add_patch(Circle((0, 0), 0.08, color=DARK))
    axes.text(-0.12, 0.1, "axis a\n(into the page)", ha="right", va="bottom", color=DARK)
    axes.add_patch(Arc((0, 0), 1.3, 1.3, theta1=30, theta2=120, color=MOTION, lw=1.2))
    _arrow(axes, (0.5628, 0.325), (0.60, 0.25), MOTION)
    axes.text(0.48, 0.62, "spin_rate", color=MOTION, ha="left", va="bottom")
    _arrow(axes, (0.12, 0), (1.35, 0), MOTION, "velocity", (1.4, 0.08), ha="right")
    _arrow(axes, (0, -1.0), (0, -0.35), FORCE, "normal_force", (0.06, -0.62))
    _arrow(axes, (0, -1.0), (1.0, -1.0), FORCE, "longitudinal_force", (0.1, -1.22))
    _triad(axes, "t", "n")


def _top(axes):
    axes.add_patch(Rectangle((-0.9, -0.22), 1.8, 0.44, fill=False, color=DARK, lw=1.5))
    axes.plot([0, 0], [-0.22, 0.75], color=DARK, lw=1)
    axes.text(-0.06, 0.72, "axis a", ha="right", va="top", color=DARK)
    angle = math.radians(20)
    _arrow(axes, (0, 0), (1.5 * math.cos(angle), 1.5 * math.sin(angle)), MOTION, "velocity", (0.95, 0.62))
    axes.plot([0, 1.7], [0, 0], color=LIGHT, ls="--", lw=0.8)
    axes.add_patch(Arc((0, 0), 2.3, 2.3, theta1=0, theta2=20, color=MOTION, lw=1))
    axes.text(1.2, 0.12, "slip_angle > 0", color=MOTION, ha="left", va="center", fontsize=7)
    _arrow(axes, (0, 0), (0, -0.95), FORCE, "lateral_force < 0", (0.08, -0.95))
    axes.add_patch(Arc((-0.45, 0), 0.7, 0.7, theta1=120, theta2=240, color=FORCE, lw=1.2))
    _arrow(axes, (-0.66, -0.28), (-0.59, -0.32), FORCE)
    axes.text(
        -1.0,
        -0.42,
        "slip_moment about n > 0\nturns it into the velocity",
        color=FORCE,
        ha="center",
        va="top",
        fontsize=7,
    )
    _triad(axes, "t", "l")


def _rear(axes):
    lean = math.radians(18)
    c, s = math.cos(lean), math.sin(lean)
    axes.plot([-1.6, 1.8], [-1.0, -1.0], color=LIGHT)
    foot = np.array([-0.1, -1.0])
    up, side = np.array([s, c]), np.array([-c, s])
    corners = [foot + 0.16 * side, foot - 0.16 * side, foot - 0.16 * side + 1.9 * up, foot + 0.16 * side + 1.9 * up]
    axes.add_patch(plt.Polygon(corners, fill=False, color=DARK, lw=1.5))
    hub = foot + 0.95 * up
    _arrow(axes, hub, hub + 0.95 * side, DARK, "axis a", hub + 0.95 * side + [-0.02, 0.1], ha="right")
    axes.plot([foot[0]] * 2, [-1.0, 1.2], color=LIGHT, ls="--", lw=0.8)
    axes.add_patch(Arc(foot, 3.4, 3.4, theta1=72, theta2=90, color=MOTION, lw=1))
    axes.text(0.02, 0.86, "lean > 0", color=MOTION, ha="left", va="bottom")
    _arrow(axes, foot, foot + [0, 0.62], FORCE, "normal_force", foot + [-0.08, 0.4], ha="right")
    _arrow(axes, foot, foot + [0.85, 0.0], FORCE, "camber thrust:\nlateral_force < 0", foot + [0.2, -0.07], va="top")
    _triad(axes, "l", "n", mirrored=True)


def _triad(axes, first, second, mirrored=False):
    """Draw two axes; the first points to the left if ``mirrored``."""
    x, y, along = (1.75, 1.05, -0.4) if mirrored else (-1.6, 1.05, 0.4)
    _arrow(axes, (x, y), (x + along, y), DARK, first, (x + 1.15 * along, y), ha="center", va="center")
    _arrow(axes, (x, y), (x, y + 0.4), DARK, second, (x, y + 0.5), ha="center", va="center")


def _arrow(axes, begin, end, color, text="", at=None, ha="left", va="center"):
    axes.annotate(
        "", end, begin, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.3, "shrinkA": 0, "shrinkB": 0}
    )
    if text:
        axes.text(*at, text, color=color, ha=ha, va=va)


def digital_controller(target):
    """Draw the input of a controller, its samples, the held value, and the value that is applied late."""
    figure, axes = plt.subplots(figsize=(6.2, 2.3))
    t, late = np.linspace(0, 5, 400), 0.35

    def u(t):
        return 0.55 + 0.4 * np.sin(1.1 * t - 0.6)

    k = np.arange(6)
    axes.plot(t, u(t), color=LIGHT, lw=1.5, label="input")
    axes.step(k, u(k), where="post", color=MOTION, lw=1.5, label="sample_and_hold")
    axes.step([0, *(k + late)], [u(0), *u(k)], where="post", color=FORCE, lw=1.2, ls="--", label="delay of it")
    axes.plot(k[:-1], u(k[:-1]), "o", ms=4, color=MOTION)
    axes.annotate("", (2, 0.08), (1, 0.08), arrowprops={"arrowstyle": "<->", "color": DARK, "lw": 0.8})
    axes.text(1.5, 0.1, "period", ha="center", va="bottom", color=DARK)
    axes.annotate("", (3 + late, 0.3), (3, 0.3), arrowprops={"arrowstyle": "<->", "color": DARK, "lw": 0.8})
    axes.text(3 + late + 0.05, 0.3, "delay", ha="left", va="center", color=DARK)
    axes.set(xlim=(0, 5), ylim=(0, 1.15), yticks=[])
    axes.set_xticks(k, ["start", *(f"t$_{i}$" for i in k[1:])])
    for name in ("top", "right", "left"):
        axes.spines[name].set_visible(False)
    axes.legend(ncol=3, frameon=False, loc="upper left", fontsize=8)
    figure.tight_layout()
    _save(figure, target)


def pulley_signs(target):
    """Draw a rope over two pulleys, an open and a crossed belt, with the signs of their radii."""
    figure, panels = plt.subplots(1, 3, figsize=(8.4, 2.4), width_ratios=[1.25, 1, 1])
    rope = [((0.0, 0.0), 0.0, "a"), ((0.9, 1.6), -0.35, "p"), ((2.0, 0.6), 0.35, "q"), ((2.9, 2.0), 0.0, "b")]
    _belt(panels[0], "nodes: [a, p, q, b]\nradii: [0, -r, r, 0]", rope, closed=False)
    for axes, r, text in ((panels[1], 0.55, "[r, R]"), (panels[2], -0.55, "[r, -R]")):
        _belt(axes, f"closed: true\nradii: {text}", [((0.0, 1.0), 0.3, "p"), ((1.9, 1.0), r, "q")], closed=True)
    figure.tight_layout()
    _save(figure, target)


def _belt(axes, title, nodes, closed):
    """Draw nodes (place, radius > 0 counter-clockwise, name) and the line around them."""
    axes.set(aspect="equal")
    axes.set_axis_off()
    axes.set_title(title, fontsize=8, color=DARK, family="monospace")
    pairs = list(zip(nodes, nodes[1:] + nodes[:1], strict=True))[: len(nodes) if closed else -1]
    spans = [_tangent(np.array(c0), r0, np.array(c1), r1) for (c0, r0, _), (c1, r1, _) in pairs]
    for begin, end in spans:
        axes.plot(*np.transpose([begin, end]), color=MOTION, lw=1.5)
    middle = 0.5 * (spans[0][0] + spans[0][1])
    _arrow(axes, middle - 0.02 * (spans[0][1] - spans[0][0]), middle, MOTION)
    arrivals = [spans[-1][1] if closed else None, *(end for _, end in spans)]
    for i, (centre, r, name) in enumerate(nodes):
        axes.plot(*centre, "o", ms=3, color=DARK)
        axes.text(centre[0] + 0.06, centre[1] + 0.06, name, color=DARK)
        if r:
            axes.add_patch(Circle(centre, abs(r), fill=False, color=LIGHT))
            angles = [math.atan2(*(point - centre)[::-1]) for point in (arrivals[i], spans[i][0])]
            turn = (angles[1] - angles[0]) % (2.0 * math.pi) if r > 0 else -((angles[0] - angles[1]) % (2.0 * math.pi))
            arc = angles[0] + turn * np.linspace(0.0, 1.0, 60)
            axes.plot(centre[0] + abs(r) * np.cos(arc), centre[1] + abs(r) * np.sin(arc), color=MOTION, lw=1.5)
    x, y = axes.get_xlim()[0], axes.get_ylim()[1]
    axes.plot(x, y, "o", ms=7, mfc="none", color=DARK)
    axes.plot(x, y, "o", ms=2, color=DARK)
    axes.text(x + 0.15, y, "axis", color=DARK, va="center")


def _tangent(c0, r0, c1, r1):
    """Return both ends of the line that leaves one circle and reaches another; radii > 0: counter-clockwise."""
    x, y = c1 - c0
    angle = math.atan2(y, x) + math.asin((r0 - r1) / math.hypot(x, y))
    right = np.array([math.sin(angle), -math.cos(angle)])
    return c0 + r0 * right, c1 + r1 * right


def step(target):
    """Draw how a step is tried, rejected, ended at an event, and accepted."""
    figure, axes = plt.subplots(figsize=(8.4, 2.7))
    axes.set(xlim=(0, 16.8), ylim=(0.2, 5.4), aspect="equal")
    axes.set_axis_off()
    row, low = 4.2, 1.1
    boxes = [
        (1.5, row, "state, history,\nstep size h", DARK),
        (5.0, row, "trial: predict,\nNewton's iterations", DARK),
        (8.8, row, "error within\nits share?", DARK),
        (12.1, row, "an event\nin the step?", DARK),
        (15.3, row, "accept it,\nplan the next h", DARK),
        (6.9, low, "smaller h", MOTION),
        (12.1, low, "locate: trials\nof other h", FORCE),
        (1.5, low, "consistent restart:\nphases, impulses", FORCE),
    ]
    for x, y, text, color in boxes:
        axes.text(x, y, text, ha="center", va="center", color=color, bbox={"fc": "white", "ec": color, "pad": 4.0})
    for begin, end in (
        ((2.75, row), (3.35, row)),
        ((6.7, row), (7.65, row)),
        ((9.95, row), (11.0, row)),
        ((13.2, row), (13.9, row)),
    ):
        _arrow(axes, begin, end, DARK)
    for x, text in ((10.45, "yes"), (13.55, "no")):
        axes.text(x, row + 0.1, text, ha="center", va="bottom", color=DARK)
    _arrow(axes, (8.4, row - 0.55), (7.3, low + 0.35), MOTION, "no", (8.05, 2.4))
    _arrow(axes, (5.8, row - 0.55), (6.6, low + 0.35), MOTION, "not\nconverged", (4.75, 2.45))
    axes.plot([6.1, 4.6], [low, low], color=MOTION, lw=1.3)
    _arrow(axes, (4.6, low), (4.6, row - 0.55), MOTION)
    _arrow(axes, (12.1, row - 0.55), (12.1, low + 0.55), FORCE, "yes", (12.2, 2.6))
    axes.plot([10.9, 10.3, 10.3], [low, low, 0.4], color=FORCE, lw=1.3)
    axes.plot([10.3, 1.5], [0.4, 0.4], color=FORCE, lw=1.3)
    _arrow(axes, (1.5, 0.4), (1.5, low - 0.5), FORCE)
    _arrow(axes, (1.5, low + 0.55), (1.5, row - 0.55), FORCE)
    axes.plot([15.3, 15.3, 1.5], [row + 0.55, 5.2, 5.2], color=DARK, lw=1.3)
    _arrow(axes, (1.5, 5.2), (1.5, row + 0.55), DARK)
    figure.tight_layout()
    _save(figure, target)


def _save(figure, target):
    figure.savefig(target, metadata={"Date": None}, bbox_inches="tight")
    plt.close(figure)


if __name__ == "__main__":
    main()
