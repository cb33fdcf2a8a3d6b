"""``python -m reference bench NAME``: measure, print a table, store the rows."""

from __future__ import annotations

import argparse

from . import run_command
from .benchmarks import features, frontier, frontier_codes, large, limits, peers, slopes, statics

HELP = "measure run time, against error or against other programs, and store the rows under reference/results"

BENCHMARKS = {
    "slopes": slopes,
    "peers": peers,
    "limits": limits,
    "statics": statics,
    "large": large,
    "features": features,
    "frontier": frontier,
    "frontier-codes": frontier_codes,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One sub-command a benchmark; groups of `run` are taken too: nobody has to know which of both a name is."""
    names = parser.add_subparsers(dest="name", required=True, metavar="{" + ",".join(BENCHMARKS) + "}")
    for name in sorted(run_command.PROBLEMS.keys() - BENCHMARKS.keys()):
        names.add_parser(name)
    for name, module in BENCHMARKS.items():
        module.add_arguments(names.add_parser(name, help=(module.__doc__ or "").splitlines()[0]))


def main(arguments: argparse.Namespace) -> int:
    """Run the named benchmark, or group."""
    if arguments.name not in BENCHMARKS:
        return run_command.main(arguments)
    return BENCHMARKS[arguments.name].main(arguments)
