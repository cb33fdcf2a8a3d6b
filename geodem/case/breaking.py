"""A case of breaking ground: bonded ground, measured points, walls, and the stages that it goes through; SI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from geodem.case.scene import Place, SceneCase


@dataclass(frozen=True)
class PointOptions:
    """A measured point: name and place [m]."""

    name: str
    at: Place


@dataclass(frozen=True)
class WallOptions:
    """A wall of segments, 2D.

    Attributes
    ----------
    name : str
    points : tuple of points [m]
    friction : float or None
        Coefficient against the ground [-]; that of the ground where it is left out.
    """

    name: str
    points: tuple[Place, ...]
    friction: float | None = None


@dataclass(frozen=True)
class StageOptions:
    """One stage.

    Attributes
    ----------
    kind : str
        A key of `geodem.case.breaking_stages.STAGES`.
    name : str
    values : mapping of str to anything
        Of the keys of that kind, SI, defaults written out.
    """

    kind: str
    name: str
    values: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class BreakingCase:
    """Ground that breaks, stage by stage.

    Attributes
    ----------
    title : str
    scene : SceneCase
    stages : tuple of StageOptions
    points : tuple of PointOptions
    walls : tuple of WallOptions
    damping : float
        Local damping [-].
    time_step_factor : float
        Time step over the critical one [-].
    seed : int
    allow_implausible, notices, questions : tuples of str
    text : str
        The file.
    """

    title: str
    scene: SceneCase
    stages: tuple[StageOptions, ...]
    points: tuple[PointOptions, ...] = ()
    walls: tuple[WallOptions, ...] = ()
    damping: float = 0.7
    time_step_factor: float = 0.5
    seed: int = 1
    allow_implausible: tuple[str, ...] = field(default=())
    notices: tuple[str, ...] = field(default=())
    questions: tuple[str, ...] = field(default=())
    text: str = ""
    workflow: str = "breaking"

    def beside(self) -> tuple[BreakingCase, dict[str, Path]]:
        """The case with its files in a folder ``source`` beside it, and where each of them comes from."""
        scene, copies = self.scene.beside()
        return replace(self, scene=scene), copies

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default written out."""
        # the writer needs the classes of this file
        from geodem.case.breaking_writing import breaking_text

        return breaking_text(self)
