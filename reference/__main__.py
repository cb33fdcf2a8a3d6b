"""``python -m reference COMMAND``: the checks and comparisons that geodem itself does not contain."""

from __future__ import annotations

import argparse
import importlib
import sys

# Command to module; a module has HELP, add_arguments(parser) and main(arguments) -> exit status. Modules are
# imported only when a command line names them, so that the quick ones stay quick.
COMMANDS = {
    "list": "reference.list_command",
    "run": "reference.run_command",
    "compare": "reference.compare_command",
    "bench": "reference.bench_command",
    "map": "reference.rock_map",
    "limit-equilibrium": "reference.limit_equilibrium_command",
    "pages": "reference.pages",
}


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit status."""
    given = sys.argv[1:] if arguments is None else arguments
    parser = argparse.ArgumentParser(prog="python -m reference", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="{" + ",".join(COMMANDS) + "}")
    named = [name for name in given[:1] if name in COMMANDS] or list(COMMANDS)
    for name in named:
        module = importlib.import_module(COMMANDS[name])
        command = commands.add_parser(name, help=module.HELP, description=module.HELP)
        module.add_arguments(command)
        command.set_defaults(run=module.main)
    parsed = parser.parse_args(given)
    return int(parsed.run(parsed))


if __name__ == "__main__":
    sys.exit(main())
