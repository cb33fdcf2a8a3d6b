"""The script of the page on long runs does what the page says: it records, is interrupted, goes on and draws."""

import os
import signal
import subprocess
import sys
import time

from geodem.io.history import read_history
from tests.docs.pages import DOCS, ROOT, snippet

PAGE = DOCS / "how-to" / "particle-runs.md"
LAST = 4000


def test_the_script_is_interrupted_and_goes_on(tmp_path):
    (tmp_path / "block.py").write_text(snippet(PAGE, "python"))
    command = [sys.executable, "block.py"]
    options = {"cwd": tmp_path, "env": {**os.environ, "PYTHONPATH": str(ROOT)}, "text": True}
    folder = tmp_path / "falling-block"
    with subprocess.Popen(command, stderr=subprocess.PIPE, **options) as running:
        deadline = time.monotonic() + 120.0
        while not (folder / "particles-000001000.vtkhdf").exists() and time.monotonic() < deadline:
            time.sleep(0.02)
        running.send_signal(signal.SIGINT)
        _, complaint = running.communicate(timeout=60)
    assert running.returncode == 1
    assert complaint.startswith("stopped at step")
    assert "Traceback" not in complaint
    begun = read_history(folder / "history.csv")["step [-]"]
    assert 1000 <= begun[-1] < LAST
    assert not (folder / "cracks.png").exists()

    subprocess.run(command, check=True, timeout=120, **options)
    history = read_history(folder / "history.csv")
    assert history["step [-]"].tolist() == list(range(0, LAST + 1, 50))
    # it fell, hit the edge and broke
    broken = history["bonds broken in tension [-]"] + history["bonds broken in shear [-]"]
    assert broken[0] == 0.0
    assert broken[-1] > 100.0
    assert history["force on edge, y [N/m]"].min() < 0.0
    for step in range(0, LAST + 1, 500):
        assert (folder / f"particles-{step:09d}.vtkhdf").exists()
    for name in ("cracks.png", "speed.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")


def test_files_and_arguments_that_the_page_names_exist(tmp_path):
    from geodem.io import particle_frames
    from geodem.plotting.particles import COLOURINGS

    text = PAGE.read_text()
    for kind in particle_frames.KINDS:
        assert f"`{kind}-*.vtkhdf`" in text
    for colouring in COLOURINGS:
        assert f'`"{colouring}"`' in text
    assert (particle_frames.CONTACT, particle_frames.BONDED, particle_frames.DEBONDED) == (0, 1, 2)
    assert "0 never bonded, 1 bonded, 2 touching after its bond broke" in text
