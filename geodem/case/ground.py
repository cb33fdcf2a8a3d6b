"""A case of ground: particles of a body, from whatever it is given by, before anything is run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..laboratory.material import BondedMaterial

if TYPE_CHECKING:
    from .scene import SceneCase


@dataclass(frozen=True)
class GroundSource:
    """What the body is made from.

    Attributes
    ----------
    kind : str
        A key of `geodem.case.ground_source.SOURCES`.
    files : mapping of str to pathlib.Path
        Absolute; of solids by material, else one by the name of the kind; none of what is drawn in the case.
    options : mapping
        Values of the keys, the kind's own too where it has no file, SI; those of `SOURCES` that the case leaves out and
        that have a default, too.
    """

    kind: str
    files: Mapping[str, Path]
    options: Mapping[str, Any]

    @property
    def file(self) -> Path:
        """The file, or the first of several; what is drawn has none."""
        return next(iter(self.files.values()))

    @property
    def dimension(self) -> int | None:
        """2 or 3; None where the file tells."""
        if self.kind in ("image", "photograph", "regions"):
            return 2
        if self.kind == "box":
            return len(self.options["box"])
        return 3 if self.kind in ("slices", "grid", "solids", "terrain") else None

    @property
    def materials(self) -> tuple[str, ...] | None:
        """Names that the case itself gives; None where the file names them."""
        if self.kind == "solids":
            return tuple(self.files)
        if "legend" in self.options:
            return tuple(dict.fromkeys(self.options["legend"].values()))
        if "regions" in self.options:
            return tuple(dict.fromkeys(name for name, _ in self.options["regions"]))
        if "materials" in self.options:
            return tuple(dict.fromkeys(name for name in self.options["materials"] if name is not None))
        if "layers" in self.options:
            return tuple(dict.fromkeys(name for name, _ in self.options["layers"]))
        return None

    def beside(self) -> tuple[GroundSource, dict[str, Path]]:
        """The same with its files in a folder ``source`` beside the case, and where each of them comes from."""
        names: dict[str, Path] = {}
        for key, path in self.files.items():
            taken = {place.name for place in names.values()}
            name = path.name
            while name in taken:  # another file's, of another folder, or called like that itself
                name = f"{len(taken)}-{name}"
            names[key] = Path("source") / name
        moved = {str(place): self.files[key] for key, place in names.items()}
        return replace(self, files=names), moved


@dataclass(frozen=True)
class ParticleOptions:
    """How a body is filled; as of `geodem.builders.fill_body.fill_body`.

    Attributes
    ----------
    arrangement : str
    radius : float or None [m]
    particles : int or None
    grading : tuple of (float, float) or None
        Radius [m] and share of smaller ones [-].
    size_ratio : float
    solid_fraction : float or None
    seed : int
    """

    arrangement: str = "random"
    radius: float | None = None
    particles: int | None = None
    grading: tuple[tuple[float, float], ...] | None = None
    size_ratio: float = 1.5
    solid_fraction: float | None = None
    seed: int = 1

    def arguments(self) -> dict[str, Any]:
        """For `fill_body`."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


@dataclass(frozen=True)
class GroundGrains:
    """One material of the ground.

    Attributes
    ----------
    name : str
    density : float [kg/m3]
        Of the ground, voids between the particles included.
    bonded : BondedMaterial or None
        What its particles are held together by, where that is known.
    """

    name: str
    density: float
    bonded: BondedMaterial | None = None


@dataclass(frozen=True, eq=False)
class GroundCase:
    """A body, its particles and its materials.

    Attributes
    ----------
    title : str
    source : GroundSource
    particles : ParticleOptions
    materials : mapping of str to GroundGrains
        In the order of the file.
    allow_implausible : tuple of str
        Keys whose value is meant although it looks mistaken.
    notices, questions : tuple of str
        Defaults that were taken; what looks odd and was let pass.
    text : str
        The file.
    scene : SceneCase or None
        Where the case says what holds, cuts and reinforces the ground; source, particles and materials are its own.
    """

    title: str
    source: GroundSource
    particles: ParticleOptions
    materials: Mapping[str, GroundGrains]
    allow_implausible: tuple[str, ...] = field(default=())
    notices: tuple[str, ...] = field(default=())
    questions: tuple[str, ...] = field(default=())
    text: str = ""
    workflow: str = "ground"
    scene: SceneCase | None = None

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default and all materials written out."""
        # the writer needs the classes of this file
        from geodem.case.ground_writing import ground_text

        return ground_text(self)
