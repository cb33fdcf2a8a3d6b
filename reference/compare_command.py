"""``python -m reference compare NAME``: geodem beside other codes, posed once, every difference beside its bound."""

from __future__ import annotations

import argparse
import math
import sys
from types import ModuleType

from .backends import BACKENDS
from .backends.program import BackendError
from .comparisons import beam, block, column, convergence, fewbody, handover, mutation, settling
from .comparisons.comparison import Row
from .results_file import load_rows, store_rows

HELP = "compare geodem with other codes, print and store every difference; exit status 0 only if all are within bounds"

COMPARISONS: dict[str, ModuleType] = {
    "beam": beam,
    "block": block,
    "fewbody": fewbody,
    "handover": handover,
    "convergence": convergence,
    "mutation": mutation,
    "settling": settling,
    "column": column,
}
"""Each has ``compare(codes) -> rows``, and ``CODES`` where it is made for some codes only."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The comparison and the codes."""
    parser.add_argument("name", choices=sorted(COMPARISONS))
    parser.add_argument(
        "--with",
        dest="codes",
        default=None,
        metavar="CODES",
        help=f"codes, with commas between them, of {', '.join(BACKENDS)}; all that the comparison knows if left out",
    )


def main(arguments: argparse.Namespace) -> int:
    """Compare; 0 only where every difference is within its bound and every code answered."""
    module = COMPARISONS[arguments.name]
    known = tuple(getattr(module, "CODES", ("yade", "liggghts")))
    codes = known if arguments.codes is None else tuple(arguments.codes.split(","))
    for code in codes:
        if code not in known:
            print(f"{arguments.name} is not made for {code!r}; it knows {', '.join(known)}", file=sys.stderr)
            return 2
    rows: list[Row] = []
    failed = False
    for code in codes:
        try:
            found = list(module.compare([code]))
            if not found:
                raise BackendError(f"{code} gave nothing to compare")
        except BackendError as error:
            failed = True
            print(f"{arguments.name} with {code} was NOT compared: {error}", file=sys.stderr)
            continue
        for row in found:
            print(line(row))
        rows += found
    if rows:
        stored = [_stored(row) for row in rows]
        # what was compared with other codes before stays
        compared = {row.code for row in rows}
        kept = [row for row in load_rows(f"compare-{arguments.name}") if row["code"] not in compared]
        all_rows = [*kept, *stored]
        every = ",".join(dict.fromkeys(str(row["code"]) for row in all_rows))
        command = f"python -m reference compare {arguments.name} --with {every}"
        path = store_rows(f"compare-{arguments.name}", all_rows, command)
        print(f"stored in {path}")
    bad = sum(not row.good for row in rows)
    print(f"{len(rows) - bad} of {len(rows)} within bounds" + ("; not all was compared" if failed else ""))
    return 0 if rows and not bad and not failed else 1


def line(row: Row) -> str:
    """One line of the table."""
    bound = "" if math.isnan(row.bound) else f"bound {row.bound:.0e}"
    return (
        f"{'good' if row.good else 'MISS':4s} {row.code:9s} {row.scene:58s} {row.quantity:14s} "
        f"{row.difference:9.2e} {bound}"
    )


def _stored(row: Row) -> dict[str, object]:
    return {
        **vars(row),
        "difference": row.difference if math.isfinite(row.difference) else None,
        "bound": None if math.isnan(row.bound) else row.bound,
        "good": row.good,
    }
