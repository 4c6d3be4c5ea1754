"""What comes of an agent's process: limits of all its processes together, folders of its own, and nothing left at the end."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from ovman.remote.connection import ConnectionLost
from ovman.remote.process import AgentProcess
from ovman.settings.benchmark import Remote

LIMITS = {
    "connect_s": 20,
    "tour_s": 9,
    "act_s": 9,
    "run_s": 9,
    "memory_gb": 0.2,
    "processes": 9,
    "disk_gb": 0.05,
    "file_gb": 0.04,
}
SERVER = """
import mmap, os, sys, tempfile, time
from pathlib import Path

def child(work, own_session=False):
    if os.fork() == 0:
        if own_session and (os.setsid() and os.fork()):
            os._exit(0)
        work()
        time.sleep(100)

def hold(size):
    global held
    held = mmap.mmap(-1, size)
    for _ in range(size // 10**6): held.write(bytes(10**6))

def write(size):
    Path(tempfile.mkdtemp(), "large").write_bytes(bytes(size))

def write_unnamed(size):
    files.append(tempfile.TemporaryFile())
    files[-1].write(bytes(size))

files = []
ILL
Path(sys.argv[1], "env").write_text(os.environ["HOME"] + chr(10) + tempfile.gettempdir() + chr(10) + os.getcwd())
os.write(int(sys.argv[-1]), b"7\\n")
time.sleep(100)
"""
MB = 10**6


@pytest.fixture
def started(tmp_path):
    """Starts a server that does something before it listens."""
    running = []

    def start(ill="", **limits):
        (tmp_path / "server.py").write_text(SERVER.replace("ILL", ill))
        limits = Remote.model_validate({**LIMITS, **limits})
        running.append(AgentProcess([str(tmp_path / "server.py"), str(tmp_path)], limits, tmp_path / "log"))
        running[0].address()
        return running[0]

    yield start
    for one in running:
        one.end()


def mentioning(path):
    """The living processes whose command line names a file."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            if str(path) in (entry / "cmdline").read_text() and " Z " not in (entry / "stat").read_text():
                found.append(int(entry.name))
        except OSError:
            continue
    return found


ILLS = {
    "shared memory": (f"hold({300 * MB})", r"have 0\.[23]\d GB; use less, or raise remote.memory_gb \(0.2\)"),
    "children": (f"for _ in range(3): child(lambda: hold({90 * MB}))", "use less, or raise remote.memory_gb"),
    "daemons": ("for _ in range(20): child(lambda: None, True)", r"has 2\d processes; start fewer, or raise remote.processes"),
    "files": (f"for _ in range(3): write({30 * MB})", r"have 0\.0\d GB; write less, or raise remote.disk_gb \(0.05\)"),
    "unnamed files": (f"for _ in range(3): write_unnamed({30 * MB})", r"write less, or raise remote.disk_gb"),
}


@pytest.mark.parametrize(("ill", "said"), ILLS.values(), ids=ILLS)
def test_a_limit_is_that_of_all_processes_together(started, tmp_path, ill, said):
    with pytest.raises(ConnectionLost, match=said) as caught:
        started(f"{ill}\ntime.sleep(30)")
    assert "\n" not in str(caught.value) and not mentioning(tmp_path / "server.py")


def test_memory_that_children_share_counts_once(started):
    process = started(f"data = bytes({120 * MB})\nfor _ in range(3): child(lambda: data[::4096])")
    time.sleep(1.2)
    assert process.passed_limit() is None


def test_files_that_are_mapped_are_no_memory(started):
    mapped = f"for _ in range(9): write({30 * MB})\nfor one in Path(tempfile.gettempdir()).rglob('large'):\n"
    mapped += (
        "    with one.open() as file: files.append(mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)); sum(files[-1][::4096])"
    )
    process = started(mapped, disk_gb=1)
    time.sleep(1.2)
    assert process.passed_limit() is None


def test_nothing_is_left_of_an_agent(started, tmp_path):
    """Neither a daemon with a session of its own nor a file."""
    process = started("child(lambda: None, True)")
    home, temporary, work = (tmp_path / "env").read_text().splitlines()
    time.sleep(0.2)
    assert len(mentioning(tmp_path / "server.py")) == 3
    process.end()
    assert not mentioning(tmp_path / "server.py")
    assert not [place for place in (home, temporary, work) if Path(place).exists()] and not Path(home).parent.exists()


def test_no_run_finds_what_another_left_and_no_link_is_followed(started, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("dear")
    process = started()
    places = [Path(place) for place in (tmp_path / "env").read_text().splitlines()]
    for place in places:
        (place / "deep").mkdir()
        (place / "deep" / "notes").write_text("seen")
    places[0].joinpath("link").symlink_to(tmp_path / "mine")
    process.clean()
    assert [[*place.iterdir()] for place in places] == [[], [], []]
    places[1].rmdir()
    places[1].symlink_to(tmp_path / "mine")
    process.clean()
    assert not places[1].is_symlink() and places[1].is_dir()
    places[0].parent.rename(tmp_path / "moved")
    places[0].parent.symlink_to(tmp_path / "mine")
    process.end()
    assert (tmp_path / "mine" / "thesis.txt").read_text() == "dear" and not [*(tmp_path / "moved").iterdir()]
    places[0].parent.unlink(missing_ok=True)
