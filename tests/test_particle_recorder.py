"""What a recorded run leaves in its folder, and that it is the same however the run was disturbed."""

from __future__ import annotations

import math
import shutil
import signal
import threading

import numpy as np
import pytest

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.errors import InputError, StoppedError
from geodem.io.history import read_history
from geodem.particle_recorder import Recorder
from geodem.particle_simulation import ParticleSimulation

CONTACT = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
SPRINGS = {
    "normal_stiffness": 1e6, "shear_stiffness": 5e5, "tensile_strength": 3e3, "cohesion": 3e3,
    "friction_coefficient": 0.5, "width_ratio": 0.8,
}  # fmt: skip
LAST = 430


def falling_block():
    """A bonded block that breaks on a floor."""
    builder = AssemblyBuilder(2, bond_law="two_springs", gravity=(0.0, -9.81))
    builder.add_material("rock", density=2000.0, contact=CONTACT, bond=SPRINGS)
    places = lattice("hexagonal", 0.1, cells=(6, 5)).positions
    places = places - places.min(axis=0) + 0.11
    builder.add_particles(places, 0.1, "rock", velocity=(0.0, -0.8))
    builder.bond_within(1.01)
    builder.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0)))
    return ParticleSimulation(builder.build(), local_damping=0.1, energy=True)


def record(folder, **options):
    """What a user's script does: go on where there is a checkpoint."""
    checkpoint = folder / "checkpoint.h5"
    simulation = ParticleSimulation.resume(checkpoint) if checkpoint.exists() else falling_block()
    recorder = Recorder(simulation, folder, history_every=20, frame_every=200, **options)
    recorder.run_to(LAST)
    return simulation


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    return record(folder), folder


def content(folder):
    """Of everything but the checkpoint, which also tells where batches of steps ended."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "checkpoint.h5"}


def is_whole(folder, whole):
    assert content(folder) == content(whole[1])
    resumed = ParticleSimulation.resume(folder / "checkpoint.h5")
    assert resumed.steps == LAST
    assert np.array_equal(resumed.positions, whole[0].positions)
    assert np.array_equal(resumed.velocities, whole[0].velocities)


def after(looks, then):
    """A stop_asked that does something after so many looks."""
    left = looks

    def asked():
        nonlocal left
        left -= 1
        return bool(then()) if left <= 0 else False

    return asked


def test_what_is_there(whole):
    simulation, folder = whole
    assert 5 < len(simulation.broken_bonds().bond) < len(simulation.assembly.bonds)
    frames = {
        f"{kind}-{step:09d}.vtkhdf" for kind in ("particles", "contacts", "cracks") for step in (0, 200, 400)
    }
    series = {f"{kind}.vtkhdf.series" for kind in ("particles", "contacts", "cracks")}
    assert set(content(folder)) == {"history.csv"} | frames | series
    history = read_history(folder / "history.csv")
    assert history["step [-]"].tolist() == list(range(0, LAST, 20))
    assert history["time [s]"] == pytest.approx(history["step [-]"] * simulation.time_step, rel=1e-15)
    assert (np.diff(history["bonds broken in tension [-]"] + history["bonds broken in shear [-]"]) >= 0).all()
    terms = {
        name.split(", ")[1]: values for name, values in history.items() if name.startswith("energy account")
    }
    assert "imbalance [J/m]" not in terms
    assert terms["gravity [J/m]"][-1] > 0.0


def test_the_history_of_a_fall(tmp_path):
    """v = g t and m v^2/2, until something is hit; velocities are those half a step before."""
    builder = AssemblyBuilder(3, gravity=(0.0, 0.0, -10.0))
    builder.add_material("grain", density=2000.0, contact=CONTACT)
    builder.add_particles([(0.0, 0.0, 5.0)], 0.1, "grain")
    builder.add_wall(plane("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), velocity=(0.0, 0.0, 0.5)))
    simulation = ParticleSimulation(builder.build(), time_step=1e-3)
    Recorder(simulation, tmp_path, history_every=50).run_to(200)
    history = read_history(tmp_path / "history.csv")
    speed = 10.0 * (history["time [s]"] - 0.5e-3)
    mass = 2000.0 * 4.0 / 3.0 * math.pi * 1e-3
    assert history["largest speed [m/s]"][1:] == pytest.approx(speed[1:], rel=1e-12)
    assert history["kinetic energy [J]"][1:] == pytest.approx(0.5 * mass * speed[1:] ** 2, rel=1e-12)
    assert history["displacement of floor, z [m]"] == pytest.approx(0.5 * history["time [s]"])
    assert (history["force on floor, z [N]"] == 0.0).all()
    assert not list(tmp_path.glob("*.vtkhdf"))


def test_stopped_again_and_again(whole, tmp_path):
    for _ in range(4):
        with pytest.raises(StoppedError, match=r"resume from .*checkpoint\.h5"):
            record(tmp_path, stop_asked=after(5, lambda: True))
    record(tmp_path)
    is_whole(tmp_path, whole)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_by_the_user(number, whole, tmp_path):
    before = signal.getsignal(number)
    with pytest.raises(StoppedError, match="stopped at step"):
        record(tmp_path, stop_asked=after(9, lambda: signal.raise_signal(number)))
    assert signal.getsignal(number) is before
    record(tmp_path)
    is_whole(tmp_path, whole)


def test_a_second_interrupt_ends_at_once(tmp_path):
    def twice():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        record(tmp_path, stop_asked=after(9, twice))


def test_killed_long_after_its_checkpoint(whole, tmp_path):
    """What was recorded after the checkpoint is dropped and recorded again, half a line included."""
    with pytest.raises(StoppedError):
        record(tmp_path, stop_asked=after(9, lambda: True))

    def killed():
        raise MemoryError

    with pytest.raises(MemoryError):
        record(tmp_path, stop_asked=after(14, killed), checkpoint_seconds=math.inf)
    resumed = ParticleSimulation.resume(tmp_path / "checkpoint.h5")
    assert read_history(tmp_path / "history.csv")["step [-]"].max() > resumed.steps
    with (tmp_path / "history.csv").open("a") as file:
        file.write("400,0.3")
    record(tmp_path)
    is_whole(tmp_path, whole)


def test_killed_before_its_first_checkpoint(whole, tmp_path):
    shutil.copytree(whole[1], tmp_path, dirs_exist_ok=True)
    (tmp_path / "checkpoint.h5").unlink()
    record(tmp_path)
    is_whole(tmp_path, whole)


def test_killed_while_its_first_frame_was_written(whole, tmp_path):
    first = "000000000.vtkhdf"
    shutil.copy(whole[1] / f"particles-{first}", tmp_path)
    record(tmp_path)
    is_whole(tmp_path, whole)


def test_checkpoints_on_the_way(tmp_path):
    seen = []

    def look():
        seen.append((tmp_path / "checkpoint.h5").exists())

    record(tmp_path, stop_asked=look, checkpoint_seconds=0.0)
    assert seen[0] is False
    assert all(seen[1:])


def test_done_is_done_and_can_go_further(whole, tmp_path):
    shutil.copytree(whole[1], tmp_path, dirs_exist_ok=True)
    before = content(tmp_path)
    simulation = record(tmp_path)
    assert content(tmp_path) == before
    Recorder(simulation, tmp_path, history_every=20, frame_every=200).run_to(LAST + 30)
    steps = read_history(tmp_path / "history.csv")["step [-]"]
    assert steps.tolist() == list(range(0, LAST + 31, 20))


def test_a_new_run_never_writes_over_one_that_is_further(whole):
    before = content(whole[1])
    with pytest.raises(InputError, match=f"at step {LAST}, beyond the simulation's step 0.*another folder"):
        Recorder(falling_block(), whole[1])
    assert content(whole[1]) == before


def test_a_history_of_other_columns_is_kept(tmp_path):
    (tmp_path / "history.csv").write_text("step [-],something [m]\n0,1.0\n")
    with pytest.raises(InputError, match="has the columns"):
        Recorder(falling_block(), tmp_path)
    assert (tmp_path / "history.csv").read_text().endswith("0,1.0\n")


@pytest.mark.parametrize(
    "wrong", [{"history_every": 0}, {"frame_every": 0}, {"checkpoint_seconds": math.nan}]
)
def test_arguments_that_make_no_sense(wrong, tmp_path):
    with pytest.raises(InputError, match=next(iter(wrong))):
        Recorder(falling_block(), tmp_path, **wrong)


def test_progress_is_shown_on_request(tmp_path, capsys):
    record(tmp_path / "a", show=True)
    shown = capsys.readouterr().err
    assert f"{LAST}/{LAST}" in shown
    assert "bonds broken" in shown
    record(tmp_path / "a")
    assert capsys.readouterr().err == ""


def test_outside_the_main_thread(whole, tmp_path):
    thread = threading.Thread(target=record, args=(tmp_path,))
    thread.start()
    thread.join()
    is_whole(tmp_path, whole)


def test_what_a_killed_run_left_unfinished_is_taken_away(whole, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(whole[1], folder)
    # no process has this number: the system gives none above 2^22
    (folder / ".particles.vtkhdf.series.99999999.part").write_text("half")
    record(folder)
    is_whole(folder, whole)
