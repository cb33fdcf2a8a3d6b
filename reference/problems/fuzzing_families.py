"""Families of spoilt input: what is spoilt, and who reads it."""

from __future__ import annotations

import contextlib
import io
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from geodem.case.any_kind import load_any, parse_any
from geodem.case.material_file import load_material
from geodem.checking import check_case
from geodem.errors import InputError
from geodem.io.checkpoint import PARTICLES, SEARCH, checksum, read_checkpoint, write_checkpoint
from geodem.io.files import read_json
from geodem.io.history import cut_history, read_history, write_history
from geodem.io.run_folder import RunFolder, resumable
from geodem.kinds import AnyCase

from . import fuzzing_cases, fuzzing_files, fuzzing_kinds, fuzzing_pictures
from .fuzzing_judge import ROOT, SECONDS, Judge

TEMPLATES, WORKFLOWS = ROOT / "geodem" / "templates", ROOT / "workflows"
FEW, MANY = 400, 10**9
"""Particles between which a filling is only a matter of time."""
LITTLE = 3 << 20
"""Memory that is free where cases are checked [B]: a few thousand particles."""
CHECKING = 60.0
"""Longest time that `geodem check` may take of a case [s of the processor], kernels compiled among it."""
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


def prepare(family: str, folder: Path) -> None:
    """Load what is loaded once and kept, which is no input's; libraries that draw end a process that lacks memory."""
    if family != "checks":
        fuzz(Judge(family), folder, 5, 1)
        return
    fuzzing_files.write_sources(folder)
    _, read = _checks(folder)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        for number, text in enumerate(fuzzing_kinds.SEEDS):
            read((number, text))


def longest(family: str) -> float:
    """Longest time that an input of a family may take [s of the processor]."""
    return CHECKING if family == "checks" else SECONDS


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


def _kinds(folder: Path) -> Family:
    """Cases that have every table there is, small; what can be read can be read again as it is written."""
    _write_beside(folder)

    def read(item: tuple[int, str]) -> None:
        case = parse_any(item[1], folder)
        again(case, folder)

    return fuzzing_cases.spoilt(fuzzing_cases.documents(list(fuzzing_kinds.SEEDS))), read


def again(case: AnyCase, folder: Path) -> None:
    """Raise AssertionError where a case cannot be read as it is written, or is another one then."""
    text = case.as_run_text()
    try:
        twice = parse_any(text, folder).as_run_text()
    except InputError as error:
        raise AssertionError(f"the case as it is run cannot be read: {error}") from error
    if twice != text:
        lines = zip(text.splitlines(), twice.splitlines(), strict=False)
        one, other = next((pair for pair in lines if pair[0] != pair[1]), ("", "more or fewer lines"))
        raise AssertionError(f"the case as it is run is another one when it is read: {one} | {other}")


def _checks(folder: Path) -> Family:
    """`geodem check` of cases of every kind, on a machine that has little memory left."""
    from rich.console import Console

    _write_beside(folder)
    path, picture = folder / "spoilt.toml", folder / "check.png"

    def read(item: tuple[int, str]) -> None:
        path.write_bytes(item[1].encode(errors="surrogatepass"))
        with _little_memory():
            check_case(path, picture, Console(file=io.StringIO()))

    documents = fuzzing_cases.documents(list(fuzzing_kinds.SEEDS))
    return fuzzing_cases.spoilt(documents, fuzzing_cases.MILD), read


def _write_beside(folder: Path) -> None:
    for name, text in fuzzing_kinds.BESIDE.items():
        (folder / name).write_text(text, encoding="utf-8")


@contextlib.contextmanager
def _little_memory() -> Iterator[None]:
    """So little that what is not refused is made within seconds: what would take hours must be refused then."""
    with contextlib.ExitStack() as stack:
        for place in ("geodem.builders.memory", "geodem.builders.filling"):
            stack.enter_context(patch(f"{place}.available_bytes", lambda: LITTLE))
        yield


def _case_text(folder: Path) -> Family:
    """Bytes of case files."""
    seeds = [text.encode() for text, _ in fuzzing_files.cases(TEMPLATES, WORKFLOWS)]

    def read(content: bytes) -> None:
        (folder / "case.toml").write_bytes(content)
        load_any(folder)

    return fuzzing_cases.spoilt_text(seeds), read


def _tables_of_runs(folder: Path) -> Family:
    """Tables of comma-separated values that a sweep names."""
    _write_beside(folder)
    path = folder / "runs.csv"
    sweep = fuzzing_kinds.SWEEP

    def read(content: bytes) -> None:
        path.write_bytes(content)
        parse_any(sweep, folder)

    return fuzzing_cases.spoilt_text([path.read_bytes()]), read


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
            lambda: read_slices(_stack(folder, path)),
        )
        readers[spec.reader % len(readers)]()

    return fuzzing_pictures.SPECS, read


def _stack(folder: Path, picture: Path) -> Path:
    """A folder with a picture twice; a TIFF file as it is."""
    if picture.suffix == ".tif":
        return picture
    stack = folder / "stack"
    shutil.rmtree(stack, ignore_errors=True)
    stack.mkdir()
    for number in range(2):
        shutil.copy(picture, stack / f"{number}{picture.suffix}")
    return stack


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
    run.finish(
        {"workflow": "slope", "title": "x" * 1500, "factors": [{"value": 1.2}], "notices": ["y" * 1500]}
    )
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
    "kinds": _kinds,
    "checks": _checks,
    "case text": _case_text,
    "tables of runs": _tables_of_runs,
    "materials": _materials,
    "pictures": _pictures,
    "meshes": _meshes,
    "terrains": _terrains,
    "checkpoints": _checkpoints,
    "histories": _histories,
    "results": _results,
    "fillings": _fillings,
}
