"""What `geodem check` tells of a case of ground: its body, its particles, and what a run with them would cost."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .case import GroundCase
from .check_printing import escaped, print_notices

if TYPE_CHECKING:
    from rich.console import Console


def check_ground(case: GroundCase, picture: Path, console: Console) -> dict[str, Any]:
    """Body and particles of a case of ground."""
    from rich.table import Table

    from .errors import InputError
    from .ground_run import make_ground
    from .io.files import write_whole
    from .plotting import ground_wording as words
    from .plotting.ground_pictures import check_figure
    from .plotting.scene_wording import scene_rows

    begun = time.perf_counter()
    ground = make_ground(case)
    seconds = time.perf_counter() - begun
    result = ground.result
    console.print(f"[bold]{escaped(case.title)}[/]")
    console.print(f"{words.headline(result)}, {words.size_line(result)}")
    header, rows = words.material_rows(result)
    table = Table(show_header=True, box=None, pad_edge=False)
    table.add_column("")
    for row in rows:
        table.add_column(row[0], justify="right")
    for k, name in enumerate(header[1:], start=1):
        table.add_row(escaped(name), *(row[k] for row in rows))
    console.print(table)
    scenic = scene_rows(result["scene"]) if "scene" in result else []
    for name, value in (*scenic, *words.contact_rows(result), *words.cost_rows(result)):
        console.print(f"{name[0].upper()}{name[1:]}: {escaped(value)}")
    named = ", ".join(f"{entry['name']} ({entry['facets']:,})" for entry in result["surfaces"])
    if named:
        console.print(f"Boundaries: {escaped(named)}")
    print_notices(result["notices"], (), console)
    for text in result["warnings"]:
        console.print(f"[yellow]note[/] {escaped(text)}")
    try:
        drawn = check_figure(ground.filling, ground.surfaces, title=case.title, scene=ground.scene)
    except InputError as error:
        console.print(f"[yellow]note[/] no picture: {escaped(f'{error.problem}. {error.remedy}')}")
    else:
        write_whole(picture, drawn)
        console.print(f"Picture: {escaped(str(picture))}")
    return {**result, "expected_s": seconds}
