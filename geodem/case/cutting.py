"""A case of cutting: bonded or loose ground, and the tool that cuts it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from geodem.case.scene import SceneCase
from geodem.cutting.plan import CuttingPlan


@dataclass(frozen=True, eq=False)
class CuttingCase:
    """Ground and cut.

    Attributes
    ----------
    title : str
    scene : SceneCase
        2D.
    plan : CuttingPlan
    allow_implausible : tuple of str
    notices, questions : tuple of str
    text : str
        The file.
    """

    title: str
    scene: SceneCase
    plan: CuttingPlan
    seed: int = 1
    allow_implausible: tuple[str, ...] = field(default=())
    notices: tuple[str, ...] = field(default=())
    questions: tuple[str, ...] = field(default=())
    text: str = ""
    workflow: str = "cutting"

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default written out."""
        # the writer needs the classes of this file
        from geodem.case.cutting_reading import cutting_text

        return cutting_text(self)

    def beside(self) -> tuple[CuttingCase, dict[str, Path]]:
        """The same with the files of its source beside it, and where each comes from."""
        scene, copies = self.scene.beside()
        return replace(self, scene=scene), copies
