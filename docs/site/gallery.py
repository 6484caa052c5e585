"""Pictures of the gallery: ``python docs/site/gallery.py FOLDER [DECK ...]`` draws them from runs of the decks.

Every deck of inputs/ (or those named) is run into FOLDER, unless its results are there, and drawn to
docs/images/gallery: the mechanism at several times, and beside it, if there is room, the first standard plot. Those
of FILMS move.
"""

import io
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

from mecano.post.draw_sketch import draw_sketch
from mecano.post.film import film
from mecano.post.request import Request, requested_sheet
from mecano.post.runs import open_runs
from mecano.post.sheet import Panel
from mecano.post.sheets import default_sheets
from mecano.post.sketch import sketch
from mecano.post.style import COLOURS, SETTINGS, shown_unit, with_unit

ROOT = Path(__file__).parents[2]
PICTURES = ROOT / "docs" / "images" / "gallery"
PLOTS = {
    "anti_skid": "tyre.slip_ratio",
    "base_excitation": "table.velocity.z,weight.velocity.z",
    "bicycle": "frame.angular_velocity.x",
    "binding_strut": "rail_1.displacement,rail_2.displacement",
    "boom_in_sun": "tip.position.z",
    "cam_float": "profile.normal_force,profile.gap",
    "cleat": "tyre.contact_force.x,tyre.contact_force.z",
    "controlled_cart": "rail.displacement",
    "digital_control": "rail.displacement,shuttle_rail.displacement",
    "earthquake": "storey_1.displacement,storey_2.displacement",
    "elastic_drive": "drive.angle,copy.angle",
    "fiala_sweep": "*.lateral_force",
    "filters": "integral.value,washout.value,second_order.value",
    "flutter": "plunge.displacement,pitch.angle",
    "gear_stages": "loose.transmission_error,elastic.transmission_error",
    "gearbox": "joints.motor.rate,joints.load.rate",
    "landing_roll": "wheel.normal_force",
    "magic_formula_sweep": "*.lateral_force:*.slip_angle",
    "main_gear": "wheel.normal_force,wheel.longitudinal_force",
    "nose_gear_drop": "strut.compression_force:strut.stroke",
    "nose_wheel_steering": "command.value,steering.angle,piston.value",
    "oleo_drop": "strut.compression_force:strut.stroke",
    "position_servo": "rail.displacement",
    "separation": "stage.velocity.z,payload.velocity.z",
    "servo_valve": "pressure_a.value,pressure_b.value",
    "snakeboard": "nodes.board.velocity.x",
    "snap_through": "static.load_factor",
    "step_slip": "*.lateral_force",
    "step_steer": "*.lateral_force",
    "swept_sine": "mount.extension",
    "turn_slip": "*.slip_moment.z",
    "variator": "shaft_a.rate,shaft_b.rate",
    "yo_yo_despin": "axle.rate",
}
FILMS = (
    "andrews", "ball_in_pipe", "ball_on_turntable", "beam_spin_up", "belt_drive", "bicycle", "billiards",
    "block_and_tackle", "bricard", "cable_catch", "cam", "cam_float", "car", "caster_shimmy", "compass_walker",
    "controlled_double_pendulum", "crane", "crosswind_landing", "deployment_lock", "docking", "double_pendulum",
    "ellipsoids", "falling_cat", "flat_follower", "flexible_pendulum", "flexible_ring", "flexible_slider_crank",
    "flyball_governor", "four_bar", "free_body", "friction_pendulum", "gears", "gimbal", "heavy_top", "hoist",
    "landing_roll", "main_gear", "mecanum", "motorcycle", "moving_load", "n_four_bar", "nose_gear_rigid",
    "nose_landing_gear", "panel_lock", "panel_release", "paper_disc", "pendulum", "pendulum_stop", "rack", "reflector",
    "release", "rocking_block", "rods", "rolling_disc", "rope_brake", "satellite_slew", "ship_deck", "sleigh",
    "slider_crank", "snakeboard", "snap_pin", "solar_array", "spherical_pendulum", "stewart", "strut",
    "superelement_arm", "synchronised_panels", "thruster", "tippe_top", "trailing_wheel_bump", "trebuchet",
    "twin_wheel_gear", "tyre_drum", "wheel_drop", "winder", "woodpecker", "yo_yo_despin",
)  # fmt: skip
SIZE, DOTS = (3.6, 2.7), 160  # inches, per inch
FILM_SIZE, FILM_STEP, FILM_QUALITY = (280, 225), 4, 40  # pixels, at most; every fourth frame
QUALITY = 70
LOW = 0.35  # height over width, or its inverse, of a mechanism that leaves room for curves
MOST_CURVES = 4
SMALL = {"axes.labelsize": 7, "xtick.labelsize": 6.5, "ytick.labelsize": 6.5}


def main(folder, *names):
    """Run and draw decks."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in names or sorted(path.stem for path in (ROOT / "inputs").glob("*.yaml")):
        results = folder / f"{name}.h5"
        if not results.exists():
            subprocess.run(["mecano", "run", ROOT / "inputs" / f"{name}.yaml", "-o", results, "-q"], check=True)
        draw(results, PICTURES / f"{name}.webp")
        if name in FILMS:
            draw_film(results, PICTURES / f"{name}_film.webp")


def draw(results, target):
    """Draw the results file of a run to ``target``."""
    runs = open_runs([results])
    asked = PLOTS.get(results.stem)
    seen, curves = sketch(runs[0]), _asked(asked, runs) if asked else _curves(runs)
    with matplotlib.rc_context(SETTINGS | SMALL):
        figure = Figure(figsize=SIZE, dpi=DOTS)
        for ax, draw_it in _layout(figure, seen, curves, asked):
            draw_it(ax)
        picture = io.BytesIO()
        figure.savefig(picture, format="png")
    Image.open(picture).convert("RGB").save(target, quality=QUALITY, method=6)


def _asked(text, runs):
    return requested_sheet(Request.parse(text), runs).panels[0]


def _curves(runs):
    """Return the first panel of the standard plots with curves that vary, or None."""
    panels = (panel for sheet in default_sheets(runs) for panel in sheet.panels if isinstance(panel, Panel))
    return next((panel for panel in panels if panel.over_time and not panel.constant), None)


def _layout(figure, seen, curves, asked):
    """Return (axes, function that draws in them) of the mechanism ``seen``, and of curves if ``asked`` or if room."""
    parts = [(lambda ax: _draw_mechanism(ax, seen)) if seen else None, (lambda ax: _draw_curves(ax, curves))]
    if seen is None or curves is None:
        return [(figure.add_subplot(), next(part for part in parts if part))]
    aspect = _aspect(seen)
    if LOW < aspect < 1.0 / LOW and not asked:
        return [(figure.add_subplot(), parts[0])]
    across = aspect < 1.0
    grid = figure.add_gridspec(2, 1, height_ratios=(2, 3)) if across else figure.add_gridspec(1, 2, width_ratios=(1, 2))
    return [(figure.add_subplot(cell), part) for cell, part in zip(grid, parts, strict=True)]


def _aspect(seen):
    """Return height over width of a Sketch, 0 of several mechanisms side by side."""
    points = np.concatenate([shape.points @ seen.projection.T for shape in seen.shapes], axis=1).reshape(-1, 2)
    width, height = np.ptp(points, axis=0)
    return height / max(width, 1e-3 * height) if seen.in_place else 0.0


def _draw_mechanism(ax, seen):
    draw_sketch(ax, seen, named=False)
    ax.set_axis_off()
    if not seen.in_place and seen.aspect > LOW:  # no room for the times
        for text in list(ax.texts):
            text.remove()


def _draw_curves(ax, panel):
    curves = panel.curves[:MOST_CURVES]
    x, unit = curves[0].x, curves[0].y.unit
    factor, shown = shown_unit(unit, np.concatenate([curve.y.values for curve in curves]))
    for curve, colour in zip(curves, COLOURS, strict=False):
        ax.plot(curve.x.values, curve.y.values / factor, color=colour)
    ax.set_xlabel(with_unit(x.what, x.unit))
    ax.set_ylabel(with_unit(panel.label, shown))


def draw_film(results, target):
    """Write a small film, without a title, of the results file of a run to ``target``."""
    whole = film(results, results.with_suffix(".webp"), title=" ")
    with Image.open(whole) as opened:
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(opened)][::FILM_STEP]
        duration = FILM_STEP * opened.info.get("duration", 1000 // 15)
    size = np.array(frames[0].size)
    small = tuple((size / max(size / FILM_SIZE)).round().astype(int).tolist())
    first, *others = [frame.resize(small, Image.Resampling.LANCZOS) for frame in frames]
    first.save(target, save_all=True, append_images=others, duration=duration, loop=0, quality=FILM_QUALITY, method=6)


if __name__ == "__main__":
    main(*sys.argv[1:])
