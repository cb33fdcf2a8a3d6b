"""Whoever looks on while a site moves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from .site import Site


class Watcher(Protocol):
    """Whoever looks on while a site moves."""

    def told(self, detail: str) -> None:
        """Is told how far it is."""

    def stop_asked(self) -> bool:
        """Whether it is to stop."""

    def recorded(self, row: tuple[float, ...], steps: int) -> None:
        """Is given a line of the history, see `Site.columns`, and the steps since the one before."""

    def frame(self, site: Site) -> None:
        """A frame is due."""

    def may_keep(self, site: Site) -> None:
        """In a long stage: a place that can be gone on from."""


class Silent:
    """Nobody looks on."""

    def told(self, detail: str) -> None:
        """Nothing."""

    def stop_asked(self) -> bool:
        """Never."""
        return False

    def recorded(self, row: tuple[float, ...], steps: int) -> None:
        """Nothing."""

    def frame(self, site: Site) -> None:
        """Nothing."""

    def may_keep(self, site: Site) -> None:
        """Nothing."""
