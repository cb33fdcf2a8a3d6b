"""A resumed particle simulation has the bits of the one that was never stopped, wherever it was stopped."""

from __future__ import annotations

import pickle
from dataclasses import fields, is_dataclass

import h5py
import numpy as np
import pytest

from geodem._jit import set_threads
from geodem.assembly import Servo
from geodem.boundaries.walls import box, plane, segments
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.errors import InputError
from geodem.io.checkpoint import PARTICLES, read_checkpoint, write_checkpoint
from geodem.laws import CONTACT_LAWS
from geodem.particle_simulation import ParticleSimulation, Sleep
from geodem.particle_statics import find_equilibrium

CONTACT = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
SPRINGS = {
    "normal_stiffness": 1e6, "shear_stiffness": 5e5, "tensile_strength": 3e3, "cohesion": 3e3,
    "friction_coefficient": 0.5, "width_ratio": 0.8,
}  # fmt: skip
CEMENT = {
    "radius_factor": 1.0, "normal_stiffness": 1e7, "shear_stiffness": 5e6, "tensile_strength": 1e4,
    "shear_strength": 1e4,
}  # fmt: skip
STEPS = 320
SORTED_AT = 150


def block(dimension, cells, speed):
    """A bonded block whose particles fly apart, in a corner of planes."""
    law, kind, bond = (
        ("two_springs", "hexagonal", SPRINGS) if dimension == 2 else ("parallel_bond", "fcc", CEMENT)
    )
    gravity = (0.0,) * (dimension - 1) + (-9.81,)
    builder = AssemblyBuilder(dimension, bond_law=law, gravity=gravity)
    viscosity = {"normal_viscosity": 1e-4, "shear_viscosity": 1e-4}
    builder.add_material("rock", density=2000.0, contact={**CONTACT, **viscosity}, bond=bond)
    packing = lattice(kind, 0.1, cells=cells)
    places = packing.positions - packing.positions.min(axis=0) + 0.101
    velocity = np.random.default_rng(3).normal(size=places.shape) * speed
    ids = builder.add_particles(places, packing.radii, "rock", velocity=velocity)
    builder.bond_within(1.01)
    up = np.eye(dimension)[-1]
    builder.add_wall(plane("floor", np.zeros(dimension), up))
    return builder, ids, places


def servo_and_spin():
    """2D, serial: a servo above, a segment that turns, energy, both dampings."""
    builder, _, places = block(2, (12, 8), 0.5)
    top = float(places[:, 1].max()) + 0.101
    push = Servo(direction=(0.0, -1.0), force=2e3, limit=2.0)
    builder.add_wall(plane("lid", (0.0, top), (0.0, -1.0), servo=push))
    builder.add_wall(segments("blade", [(-0.3, 0.2), (-0.05, 0.2)], velocity=(1.0, 0.0), spin=5.0))
    return ParticleSimulation(builder.build(), local_damping=0.1, global_damping=2.0, energy=True)


def supports():
    """3D, serial: quaternions, energy, anchors, held and pushed particles."""
    builder, ids, places = block(3, (3, 3, 3), 0.3)
    builder.hold(ids[:4], x=0.5, y=0.0, z=0.0, rotation=0.0)
    builder.anchor(ids[10:14], places[10:14], stiffness=1e5)
    builder.apply(ids[-3:], force=(10.0, 0.0, -50.0))
    options = {"local_damping": 0.1, "energy": True, "orientation": True}
    return ParticleSimulation(builder.build(), **options)


def some_asleep():
    """2D, parallel: a bed of which parts sleep, hit by a disc."""
    builder = AssemblyBuilder(2, gravity=(0.0, -9.81))
    builder.add_material("grain", density=2000.0, contact={**CONTACT, "normal_viscosity": 3e-4})
    packing = lattice("hexagonal", 0.1, cells=(70, 4))
    places = packing.positions - packing.positions.min(axis=0) + 0.1
    builder.add_particles(places, packing.radii, "grain")
    high = places.max(axis=0) + 0.1
    builder.add_particles([(1.0, high[1] + 0.2)], 0.1, "grain", velocity=[(1.0, -2.0)])
    builder.add_wall(box("box", (0.0, 0.0), (high[0], 9.0)))
    return ParticleSimulation(
        builder.build(), local_damping=0.7, sleep=Sleep(speed=2e-2, steps=10), buffer=0.005
    )


def spheres():
    """3D, parallel, the vectorised loop: bonds break, a wall moves."""
    builder, _, places = block(3, (5, 5, 5), 0.3)
    side = float(places[:, 0].max()) + 0.15
    builder.add_wall(plane("side", (side, 0.0, 0.0), (-1.0, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0)))
    return ParticleSimulation(builder.build(), local_damping=0.1, buffer=0.01)


SCENES = {scene.__name__: scene for scene in (servo_and_spin, supports, some_asleep, spheres)}

SPLIT = {"moved", "carried", "force"}
"""Bounds that are summed batch by batch, so the last bit of the sum tells where batches ended; and resultants, which
are kept of the last step of a batch only, where a part that sleeps has none."""
# the guard looks from outside, and keeps what its own calls began with
NOT_STATE = {"_kernels", "_guard", "_pilot", "halo_force"}


def parts(value, name=""):
    """Every number of a value, by its name, as bytes or plain data."""
    if isinstance(value, np.ndarray):
        yield name, (value.dtype.str, value.shape, value.tobytes())
    elif is_dataclass(value):
        for field in fields(value):
            yield from parts(getattr(value, field.name), f"{name}.{field.name}")
    elif isinstance(value, tuple | list):
        for number, entry in enumerate(value):
            yield from parts(entry, f"{name}[{number}]")
    elif isinstance(value, dict):
        for key in value:
            yield from parts(value[key], f"{name}[{key!r}]")
    elif hasattr(value, "__dict__") and not isinstance(value, type):
        yield from parts(vars(value), name)
    else:
        yield name, value


def everything(simulation, without=()):
    """All that a simulation holds but what is compiled and how fast it was."""
    state = {name: value for name, value in vars(simulation).items() if name not in NOT_STATE | set(without)}
    return dict(parts(state))


def same(first, second, without=()):
    one, two = everything(first, without), everything(second, without)
    assert one.keys() == two.keys()
    assert [name for name in one if one[name] != two[name]] == []


def run(simulation, steps):
    """To a number of steps in all, with rows sorted anew on the way."""
    if simulation.steps < SORTED_AT <= steps:
        simulation.run(SORTED_AT - simulation.steps)
        simulation.search(sort=True)
    simulation.run(steps - simulation.steps)


@pytest.mark.parametrize("name", SCENES)
def test_stopped_at_random_steps(name, tmp_path):
    """Saved and resumed before the first step, after it and at random steps, on one thread; whole on all threads."""
    whole = SCENES[name]()
    run(whole, STEPS)
    # the scene has what could go wrong
    assert whole.searches > 3
    if whole.assembly.bond_law:
        assert 10 < len(whole.broken_bonds().bond) < len(whole.assembly.bonds)
    else:
        assert 0 < whole.asleep.sum() < len(whole.asleep)
    stops = np.random.default_rng(len(name)).integers(2, STEPS, size=7)
    simulation = SCENES[name]()
    try:
        set_threads(1)
        for stop in [0, 1, *sorted(stops.tolist())]:
            run(simulation, stop)
            simulation.save(tmp_path / "c.h5")
            before = simulation
            simulation = ParticleSimulation.resume(tmp_path / "c.h5")
            same(before, simulation)
        run(simulation, STEPS)
    finally:
        set_threads(None)
    same(whole, simulation, without=SPLIT)
    assert np.array_equal(simulation.forces, whole.forces)
    assert simulation.time == whole.time == STEPS * whole.time_step
    assert (simulation.moved, simulation.carried) == pytest.approx((whole.moved, whole.carried), rel=1e-12)
    if whole.features.energy:
        assert simulation.energy() == whole.energy()
    # the arrays are to the compiler what they were: it compiled nothing twice
    kernel = simulation.kernel(simulation.features)
    assert len(kernel.advance.signatures) == 1
    for one, two in (
        (whole.broken_bonds(), simulation.broken_bonds()),
        (whole.contacts(), simulation.contacts()),
    ):
        assert dict(parts(one)) == dict(parts(two))


def bending_beam():
    """A row of bonded discs, held at one end, too weak for its weight."""
    builder = AssemblyBuilder(2, bond_law="two_springs", gravity=(0.0, -9.81))
    builder.add_material("rock", density=2000.0, contact=CONTACT, bond=SPRINGS)
    places = lattice("hexagonal", 0.1, cells=(10, 2)).positions
    builder.add_particles(places, 0.1, "rock")
    builder.bond_within(1.01)
    builder.hold(places[:, 0] < places[:, 0].min() + 0.15, x=0.0, y=0.0, rotation=0.0)
    return ParticleSimulation(builder.build(), local_damping=0.2)


def test_after_an_equilibrium_and_in_motion_again(tmp_path):
    def go_on(simulation):
        simulation.run(200)
        simulation.save(tmp_path / "later.h5")
        return find_equilibrium(simulation, tolerance=1e-4, most_steps=3000)

    whole = bending_beam()
    whole.run(50)
    assert len(find_equilibrium(whole, tolerance=1e-4, most_steps=3000).broken)
    whole.save(tmp_path / "c.h5")
    resumed = ParticleSimulation.resume(tmp_path / "c.h5")
    same(whole, resumed)
    first, second = go_on(whole), go_on(resumed)
    assert (first.steps, first.unbalanced_ratio) == (second.steps, second.unbalanced_ratio)
    same(whole, resumed)
    breaks = resumed.broken_bonds()
    assert breaks.static.any()
    # time stood still in the search
    assert resumed.time == pytest.approx(250 * resumed.time_step, rel=1e-15)
    assert (breaks.time[breaks.static] == 50 * resumed.time_step).all()


def test_not_within_a_search_for_equilibrium(tmp_path):
    simulation = bending_beam()
    with pytest.raises(InputError, match="search for equilibrium"):
        find_equilibrium(simulation, progress=lambda *_: simulation.save(tmp_path / "c.h5"))
    assert not (tmp_path / "c.h5").exists()
    simulation.save(tmp_path / "c.h5")


# --- files that are no good


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    simulation = servo_and_spin()
    path = tmp_path_factory.mktemp("good") / "c.h5"
    simulation.save(path)
    return path


@pytest.fixture
def path(good, tmp_path):
    (tmp_path / "c.h5").write_bytes(good.read_bytes())
    return tmp_path / "c.h5"


def test_truncated(path):
    data = path.read_bytes()
    for length in (0, 100, len(data) // 2, len(data) - 1):
        path.write_bytes(data[:length])
        with pytest.raises(InputError, match=r"cut off|changed"):
            ParticleSimulation.resume(path)


def test_one_changed_number(path):
    with h5py.File(path, "r+") as file:
        file["state/arrays/rows"][0, 5, 1] += 1e-15
    with pytest.raises(InputError, match="checksum"):
        ParticleSimulation.resume(path)


def test_another_format_version(path):
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 999
    with pytest.raises(InputError, match=r"format 999.*earlier checkpoint"):
        ParticleSimulation.resume(path)


def test_other_sources_are_refused_unless_allowed(path, monkeypatch):
    monkeypatch.setattr("geodem.io.particle_checkpoint.sources_digest", lambda: "another")
    with pytest.raises(InputError, match=r"other sources or libraries \(geodem .*numba .*other_version=True"):
        ParticleSimulation.resume(path)
    assert ParticleSimulation.resume(path, other_version=True).steps == 0


def test_a_checkpoint_of_a_slope_and_the_other_way_round(path, tmp_path):
    write_checkpoint(tmp_path / "slope.h5", {"case": "..."})
    with pytest.raises(InputError, match="of a search for a factor, not of discs or spheres"):
        ParticleSimulation.resume(tmp_path / "slope.h5")
    with pytest.raises(InputError, match="of discs or spheres in motion, not of a search"):
        read_checkpoint(path)


def test_missing_or_something_else(tmp_path):
    with pytest.raises(InputError, match=r"no checkpoint here.*ParticleSimulation\.save"):
        ParticleSimulation.resume(tmp_path / "none.h5")

    class Evil:
        def __reduce__(self):
            return (tmp_path / "made").mkdir, ()

    (tmp_path / "pickle.h5").write_bytes(pickle.dumps(Evil()))
    with pytest.raises(InputError):
        ParticleSimulation.resume(tmp_path / "pickle.h5")
    assert not (tmp_path / "made").exists()


def test_a_law_that_is_not_known(path, monkeypatch):
    monkeypatch.delitem(CONTACT_LAWS, "linear_frictional")
    with pytest.raises(InputError, match="'linear_frictional' is not known here"):
        ParticleSimulation.resume(path)


@pytest.mark.parametrize(
    ("place", "spoil"),
    [
        ("pairs/a", lambda array: array + 1000),
        ("pairs/bond", lambda array: -1 - array),
        ("pairs/row", lambda array: array[:-1]),
        ("by_row/ids", lambda array: 0 * array),
        ("arrays/rows", lambda array: array[:, :-1]),
        ("arrays/record", lambda array: array.astype(np.float32)),
        ("arrays/sums", lambda _: None),
    ],
)
def test_parts_that_do_not_fit_never_reach_the_compiled_loops(path, place, spoil):
    """Written by somebody who knows the format, checksum and all."""
    tree = read_checkpoint(path, PARTICLES)
    group, name = place.split("/")
    tree["state"][group][name] = spoil(tree["state"][group][name])
    write_checkpoint(path, tree, PARTICLES)
    with pytest.raises(InputError, match="do not belong together"):
        ParticleSimulation.resume(path)


def test_a_failed_write_keeps_the_old_one(path, tmp_path, monkeypatch):
    simulation = ParticleSimulation.resume(path)
    simulation.run(10)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("geodem.io.files.os.replace", full)
    with pytest.raises(InputError, match="disk is full"):
        simulation.save(path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["c.h5"]
