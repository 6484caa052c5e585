"""Functions of other programs, and what stands for them in a deck; texts on calls that formulas refuse."""

from collections.abc import Collection

SMOOTH = "step(x, a, b) is 0 until x = a, 1 from x = b on, and smooth between"
IN_PLACE = {
    **dict.fromkeys(("step5", "havsin"), SMOOTH),
    **dict.fromkeys(
        ("akispl", "cubspl", "spline", "poly"),
        "write a law, such as {table: ...}, as the value, or in a signal of the type 'curve' whose name stands in the "
        "formula",
    ),
    **dict.fromkeys(("degrees", "radians"), "angles are in radians; multiply by 180/pi, or by pi/180"),
    **dict.fromkeys(("if", "where"), "a signal of the type 'switch' selects one of two formulas"),
    **dict.fromkeys(("dx", "dy", "dz", "dm"), "a position is written node.position.x, a distance is the length of a "
                    "'spring_damper'"),
    **dict.fromkeys(("vx", "vy", "vz", "vm", "vr"), "a velocity is written node.velocity.x"),
    **dict.fromkeys(("ax", "ay", "az"), "an angle is that of a joint, hinge.angle, or of an element 'attitude'"),
    **dict.fromkeys(("wx", "wy", "wz", "wm"), "an angular velocity is written node.angular_velocity.x"),
    **dict.fromkeys(("fx", "fy", "fz", "fm"), "a force is written joint.force.x, in the axes of the joint"),
    **dict.fromkeys(("impact", "bistop"), "write a 'contact', or a law with the term 'stop'"),
    "ln": "the natural logarithm is written log",
    "pow": "a power is written with **, as in x**2",
}  # fmt: skip


def refused_call(name: str, functions: Collection[str]) -> str:
    """Return a text on a call of ``name`` that is none of the ``functions`` with as many arguments as it takes."""
    if name in functions:
        return f"'{name}' has the wrong number of arguments{f': {SMOOTH}' if name == 'step' else ''}"
    known, hint = name.lower() in functions, IN_PLACE.get(name.lower(), f"known: {', '.join(functions)}")
    hint = f"did you mean '{name.lower()}'?" if known else hint
    return f"there is no function '{name}'; {hint}"
