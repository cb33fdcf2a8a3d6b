"""python -m geodem."""

from .cli import main

main()
