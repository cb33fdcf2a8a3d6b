"""A case of the virtual laboratory, and one of a calibration, once they have been read."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..calibration.targets import RockTargets
from ..laboratory.material import BondedMaterial


@dataclass(frozen=True)
class SpecimenOptions:
    """What every specimen of a case has in common; the seed is each one's own.

    Attributes
    ----------
    dimension : int
    packing, shape : str
        As of `geodem.laboratory.specimen.make_specimen`.
    width : float [m]
    height : float or None [m]
        None: what a test's specimen usually has.
    across : float
        Particles across the width.
    size_ratio : float
    """

    dimension: int = 2
    packing: str = "random"
    shape: str = "prism"
    width: float = 0.05
    height: float | None = None
    across: float = 40.0
    size_ratio: float = 1.66

    def arguments(self) -> dict[str, Any]:
        """For `make_specimen`, without the seed."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


@dataclass(frozen=True)
class TestOptions:
    """A kind of test, once or at several pressures.

    Attributes
    ----------
    kind : str
        uniaxial-compression, triaxial-compression, direct-tension, brazilian, direct-shear or three-point-bending.
    stresses : tuple of float
        Confinements of a triaxial test, normal stresses of a direct shear test [Pa]; empty for the others.
    """

    __test__ = False  # not one of pytest's

    kind: str
    stresses: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class LaboratoryCase:
    """Tests of one material on several specimens.

    Attributes
    ----------
    title : str
    seed : int
        Of the first specimen; the next ones have the numbers after it.
    seeds : int
        Specimens of each test.
    specimen : SpecimenOptions
    material : BondedMaterial
    tests : tuple of TestOptions
    material_file : pathlib.Path or None
        Where the material was read from.
    allow_implausible : tuple of str
        Keys whose value is meant although it looks mistaken.
    notices, questions : tuple of str
        Defaults that were taken; what looks odd and was let pass.
    text : str
        The file.
    """

    title: str
    seed: int
    seeds: int
    specimen: SpecimenOptions
    material: BondedMaterial
    tests: tuple[TestOptions, ...]
    material_file: Path | None = None
    allow_implausible: tuple[str, ...] = field(default=())
    notices: tuple[str, ...] = field(default=())
    questions: tuple[str, ...] = field(default=())
    text: str = ""
    workflow: str = "laboratory"

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default and the material written out."""
        # the writer needs the classes of this file
        from geodem.case.laboratory_writing import laboratory_text

        return laboratory_text(self)


@dataclass(frozen=True, eq=False)
class CalibrationCase:
    """Properties of a rock that a material is sought for.

    Attributes
    ----------
    title : str
    seed : int
    specimen : SpecimenOptions
    targets : RockTargets
    allow_implausible, notices, questions : tuple of str
    text : str
    """

    title: str
    seed: int
    specimen: SpecimenOptions
    targets: RockTargets
    allow_implausible: tuple[str, ...] = field(default=())
    notices: tuple[str, ...] = field(default=())
    questions: tuple[str, ...] = field(default=())
    text: str = ""
    workflow: str = "calibration"

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default written out."""
        # the writer needs the classes of this file
        from geodem.case.laboratory_writing import calibration_text

        return calibration_text(self)
