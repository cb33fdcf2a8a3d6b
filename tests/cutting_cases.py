"""A small cut that all tests of cutting share: its kernel is compiled once."""

from dataclasses import replace
from pathlib import Path

from geodem.case.cutting_reading import parse_cutting

TEXT = (Path(__file__).parents[1] / "geodem" / "templates" / "cutting" / "case.toml").read_text(
    encoding="utf-8"
)


def small_text(**keys):
    """The template with other values of some keys of [tool], few particles and a short, fast cut."""
    values = {"distance": '"1.2 mm"', "entry": '"0.3 mm"', "ramp": '"0.2 mm"', "speed": '"8 m/s"', **keys}
    lines = []
    for line in TEXT.splitlines():
        key = line.split("=")[0].strip()
        if key == "radius":
            lines.append('radius = "0.8 mm"')
        elif key == "frames":
            lines.append("frames = 3")
        elif key == "box":
            lines.append('box = ["30 mm", "18 mm"]')
        elif key in values:
            lines.append(f"{key} = {values.pop(key)}")
        else:
            lines.append(line)
    at = lines.index("[tool]") + 1
    lines[at:at] = [f"{key} = {value}" for key, value in values.items()]
    return "\n".join(lines) + "\n"


def small_case(tmp_path, **keys):
    """The case of `small_text`."""
    return parse_cutting(small_text(**keys), tmp_path)


def with_tool(case, **changes):
    """The case with other properties of its tool, SI."""
    return replace(case, plan=replace(case.plan, tool=replace(case.plan.tool, **changes)))
