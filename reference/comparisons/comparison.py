"""What a comparison is made of: scenes for a code, and rows of what differs."""

from __future__ import annotations

from dataclasses import dataclass

from ..posed import Posed, Trajectory
from ..posed_difference import differences


@dataclass(frozen=True)
class Row:
    """One quantity of one scene in geodem and in another code.

    Attributes
    ----------
    scene, code, version, law, quantity : str
    difference : float
        Largest |d| over largest |value| over all steps, unless the quantity says otherwise.
    bound : float
        Largest that is let pass; nan where the row is for information only.
    steps, particles : int
    seconds : float
        Of geodem's run.
    """

    scene: str
    code: str
    version: str
    law: str
    quantity: str
    difference: float
    bound: float
    steps: int
    particles: int
    seconds: float

    @property
    def good(self) -> bool:
        """Within its bound; a difference that is not a number never is."""
        return self.bound != self.bound or self.difference <= self.bound


def rows_of(posed: Posed, ours: Trajectory, theirs: Trajectory) -> list[Row]:
    """A row for every quantity that is posed to be compared."""
    return [
        Row(
            scene=posed.name,
            code=theirs.code,
            version=theirs.version,
            law=theirs.law,
            quantity=quantity,
            difference=difference,
            bound=posed.bound,
            steps=posed.steps,
            particles=posed.assembly.particles,
            seconds=ours.seconds,
        )
        for quantity, difference in differences(ours, theirs, posed).items()
    ]
