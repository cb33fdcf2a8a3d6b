"""``python -m reference list``: what can be run and measured."""

from __future__ import annotations

import argparse

from .bench_command import BENCHMARKS
from .compare_command import COMPARISONS
from .run_command import PROBLEMS

HELP = "list the groups of problems, the comparisons and the benchmarks"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """None."""


def main(arguments: argparse.Namespace) -> int:
    """Print the names."""
    for word, names in (("run", PROBLEMS), ("compare", COMPARISONS), ("bench", BENCHMARKS)):
        for name, module in names.items():
            print(f"{word:7s} {name:18s} {(module.__doc__ or '').splitlines()[0]}")
    return 0
