"""Families of spoilt input: what is spoilt, and who reads it."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from geodem.case.any_kind import load_any, parse_any
from geodem.case.material_file import load_material
from geodem.errors import InputError
from geodem.io.checkpoint import PARTICLES, SEARCH, checksum, read_checkpoint, write_checkpoint
from geodem.io.files import read_json
from geodem.io.history import cut_history, read_history, write_history
from geodem.io.run_folder import RunFolder, resumable

from . import fuzzing_cases, fuzzing_files, fuzzing_pictures
from .fuzzing_judge import ROOT, Judge

TEMPLATES, WORKFLOWS = ROOT / "geodem" / "templates", ROOT / "workflows"
FEW, MANY = 400, 10**9
"""Particles between which a filling is only a matter of time."""
LEGEND = {"#8c6d31": "soil", "#d62728": "seam"}


def fuzz(judge: Judge, folder: Path, count: int, number: int) -> None:
    """Let a family's readers have `count` inputs that follow from the seed `number`."""
    fuzzing_files.write_sources(folder)
    inputs, read = FAMILIES[judge.family](folder)

    @seed(number)
    @settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(inputs)
    def one(given_input: Any) -> None:
        judge.judge(lambda: read(given_input), repr(given_input)[:3000])

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        one()


Family = tuple[st.SearchStrategy[Any], Callable[[Any], object]]


def _cases(folder: Path) -> Family:
    """Case files of every kind; where one can be read, its section or body is made too."""
    seeds = fuzzing_files.cases(TEMPLATES, WORKFLOWS)
    folders = [own or folder for _, own in seeds]
    for (text, _), own in zip(seeds, folders, strict=True):
        _use(parse_any(text, own))  # they are good, or there would be nothing to spoil

    def read(item: tuple[int, str]) -> None:
        number, text = item
        _use(parse_any(text, folders[number]))

    return fuzzing_cases.spoilt(fuzzing_cases.documents([text for text, _ in seeds])), read


def _use(case: Any) -> None:
    """What a case is made from, itself as text, and its particles where they are few, or too many to be made."""
    from geodem.building import make_particles, make_section
    from geodem.case import Case
    from geodem.case.ground import GroundCase
    from geodem.ground_building import fill, make_body

    case.as_run_text()
    if isinstance(case, Case):
        section = make_section(case)
        if not FEW < (case.particles or FEW + 1) < MANY:
            make_particles(case, section, particles=case.particles)
    elif isinstance(case, GroundCase):
        body = make_body(case).body
        if case.particles.particles is not None and not FEW < case.particles.particles < MANY:
            fill(case, body)


def _case_text(folder: Path) -> Family:
    """Bytes of case files."""
    seeds = [text.encode() for text, _ in fuzzing_files.cases(TEMPLATES, WORKFLOWS)]

    def read(content: bytes) -> None:
        (folder / "case.toml").write_bytes(content)
        load_any(folder)

    return fuzzing_cases.spoilt_text(seeds), read


def _materials(folder: Path) -> Family:
    path = folder / "spoilt.toml"
    documents = fuzzing_cases.documents([fuzzing_files.MATERIAL])
    texts = fuzzing_cases.spoilt(documents).map(lambda item: item[1].encode())

    def read(content: bytes) -> None:
        path.write_bytes(content)
        load_material(path)

    return st.one_of(texts, fuzzing_cases.spoilt_text([fuzzing_files.MATERIAL.encode()])), read


def _pictures(folder: Path) -> Family:
    """Pictures of any size, depth and format, whole and broken, as drawing and as photograph."""
    from geodem.builders.from_image import section_from_image
    from geodem.builders.grid_sources import grid_from_image, read_slices
    from geodem.builders.segmentation import segment

    def read(spec: fuzzing_pictures.Spec) -> None:
        path = fuzzing_pictures.write(folder, spec)
        readers: tuple[Callable[[], object], ...] = (
            lambda: section_from_image(path, scale=0.5, legend=LEGEND, picture=folder / "colours.png"),
            lambda: grid_from_image(path, scale=0.5, legend=LEGEND),
            lambda: segment(path, classes=2),
            lambda: read_slices(path),
        )
        readers[spec.reader % len(readers)]()

    return fuzzing_pictures.SPECS, read


def _meshes(folder: Path) -> Family:
    """Meshes and surfaces, as text and as bytes."""
    from geodem.builders.from_mesh import body_from_mesh, particles_from_mesh, section_from_mesh
    from geodem.builders.grid_sources import grid_from_vtk
    from geodem.builders.mesh_reading import read_mesh

    names = sorted(
        p.name for p in folder.iterdir() if p.stem.rstrip("4") in ("section", "box", "box-binary", "scan")
    )
    names = [name for name in names if not name.endswith(".png")]
    seeds = {name: (folder / name).read_bytes() for name in names}

    def read(item: tuple[str, bytes]) -> None:
        name, content = item
        path = folder / f"spoilt{Path(name).suffix}"
        path.write_bytes(content)
        if path.suffix == ".vti":
            grid_from_vtk(path, thresholds=[0.5], materials=[None, "ore"])
        elif path.suffix == ".stl" or name.startswith("box"):
            body = body_from_mesh(path)
            body.material_at(np.zeros((3, 3)))
        else:
            mesh = read_mesh(path, names={1: "clay"})
            if mesh.dimension == 2 and not mesh.unjoined:
                particles_from_mesh(mesh)
                section_from_mesh(mesh)

    pairs = [
        st.tuples(st.just(name), fuzzing_cases.spoilt_text([content])) for name, content in seeds.items()
    ]
    return st.one_of(pairs), read


def _terrains(folder: Path) -> Family:
    from geodem.builders.terrain import Layer
    from geodem.builders.terrain_files import read_terrain

    seeds = {name: (folder / name).read_bytes() for name in ("heights.asc", "heights.npz", "heights.tif")}

    def read(item: tuple[str, bytes]) -> None:
        name, content = item
        path = folder / f"spoilt{Path(name).suffix}"
        path.write_bytes(content)
        terrain = read_terrain(path, holes="fill")
        terrain.section_along([(2.0, 10.0), (38.0, 12.0)], base=0.0, layers=[Layer("soil", np.inf)])

    pairs = [
        st.tuples(st.just(name), fuzzing_cases.spoilt_text([content])) for name, content in seeds.items()
    ]
    return st.one_of(
        [*pairs, fuzzing_pictures.ARCHIVES.map(lambda held: ("x.npz", fuzzing_pictures.archive(held)))]
    ), read


def _checkpoints(folder: Path) -> Family:
    """Bytes of checkpoints: read as they were written, or refused."""
    tree = {
        "state": {"positions": np.arange(60.0).reshape(-1, 2), "numbers": {"steps": 7}},
        "names": ["a", "b"],
    }
    written = checksum(tree)
    path = folder / "checkpoint.h5"
    seeds = []
    for form in (SEARCH, PARTICLES):
        write_checkpoint(path, tree, form)
        seeds.append(path.read_bytes())

    def read(content: bytes) -> None:
        path.write_bytes(content)
        for form in (SEARCH, PARTICLES):
            try:
                if checksum(read_checkpoint(path, form)) != written:
                    raise AssertionError("a checkpoint was misread")
            except InputError:
                if form is PARTICLES:
                    raise

    return fuzzing_cases.spoilt_text(seeds), read


def _histories(folder: Path) -> Family:
    path = folder / "history.csv"
    write_history(path, ("step [-]", "force [N]"), [(k, 0.5 * k) for k in range(20)])
    seeds = [path.read_bytes()]

    def read(content: bytes) -> None:
        path.write_bytes(content)
        read_history(path)
        cut_history(path, 7)

    return fuzzing_cases.spoilt_text(seeds), read


def _results(folder: Path) -> Family:
    """result.json as another program, a full disk or an editor leaves it."""
    run = RunFolder(folder, 'workflow = "slope"\n', "identity")
    run.claim()
    run.finish({"workflow": "slope", "title": "x", "factors": [{"value": 1.2}]})
    seeds = [
        (folder / "result.json").read_bytes(),
        b"[" * 100_000,
        b"[]",
        b"7",
        b'"a"',
        b'[["a", 1]]',
        b"null",
    ]

    def read(content: bytes) -> None:
        (folder / "result.json").write_bytes(content)
        read_json(folder / "result.json")
        resumable(folder)
        again = RunFolder(folder, 'workflow = "slope"\n', "identity")
        again.finished()
        again.claim()
        again.begin({"workflow": "slope"})

    return fuzzing_cases.spoilt_text(seeds), read


def _fillings(folder: Path) -> Family:
    from geodem.builders.body_filling_file import load_filling, save_filling
    from geodem.builders.fill_body import fill_body
    from geodem.builders.from_mesh import body_from_mesh

    path = folder / "filling.npz"
    save_filling(fill_body(body_from_mesh(folder / "section.msh", names={1: "clay"}), particles=60), path)
    seeds = [path.read_bytes()]

    def read(content: bytes) -> None:
        path.write_bytes(content)
        load_filling(path)

    return fuzzing_cases.spoilt_text(seeds), read


FAMILIES: dict[str, Callable[[Path], Family]] = {
    "cases": _cases,
    "case text": _case_text,
    "materials": _materials,
    "pictures": _pictures,
    "meshes": _meshes,
    "terrains": _terrains,
    "checkpoints": _checkpoints,
    "histories": _histories,
    "results": _results,
    "fillings": _fillings,
}
