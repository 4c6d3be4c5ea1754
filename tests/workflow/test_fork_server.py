"""A script in a fork is what it is in a fresh process, but for the time that its imports take."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from ovman.processes import alive
from ovman.workflow.fork_server import APART, ForkServer
from tests.workflow.conftest import ROOT


@pytest.fixture
def server():
    made = ForkServer()
    yield made
    made.end()


def script(directory: Path, text: str, name: str = "script.py") -> Path:
    path = directory / "scripts" / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(textwrap.dedent(text))
    return path


def run(server: ForkServer, path: Path) -> int:
    return server.run(path, os.environ).wait()


@pytest.mark.parametrize(
    ("end", "status"),
    [
        ("pass", 0),
        ("sys.exit(3)", 3),
        ("sys.exit('a line')", 1),
        ("raise ValueError", 1),
        ("os._exit(7)", 7),
        ("os.kill(os.getpid(), signal.SIGKILL)", -signal.SIGKILL),
        ("os.kill(os.getpid(), signal.SIGTERM)", -signal.SIGTERM),
        ("signal.raise_signal(signal.SIGINT)", -signal.SIGINT),
    ],
)
def test_a_script_ends_as_in_a_process_of_its_own(tmp_path, server, end, status):
    path = script(tmp_path, f"import os, signal, sys\n{end}\n")
    assert subprocess.run([sys.executable, path], capture_output=True).returncode == status
    assert run(server, path) == status


def test_a_script_is_main_where_it_lies_with_what_it_is_given(tmp_path, server, monkeypatch):
    monkeypatch.chdir(tmp_path)
    script(tmp_path, "VALUE = 5\n", "neighbour.py")
    (tmp_path / "colorsys.py").write_text("raise RuntimeError('of the working directory')\n")
    path = script(
        tmp_path,
        """
        import atexit, colorsys, os, sys
        from pathlib import Path
        from neighbour import VALUE
        name = Path("/proc/self/comm").read_text().strip()
        said = [__name__, sys.argv, os.getcwd(), os.environ.get("GIVEN"), os.environ.get("HOME"), VALUE, sys.path[0], name]
        atexit.register(Path("said").write_text, repr(said))
        """,
    )
    assert server.run(path, {"GIVEN": "yes"}).wait() == 0
    here = str(tmp_path)
    assert (tmp_path / "said").read_text() == repr(["__main__", [str(path)], here, "yes", None, 5, str(path.parent), "script"])


def test_what_one_script_imports_the_next_one_has_and_nothing_else_of_it(tmp_path, server, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first = script(tmp_path, "import os, sys, colorsys\ncolorsys.kept = os.environ['LEFT'] = 'here'\n", "first.py")
    second = script(
        tmp_path,
        """
        import os, sys
        from pathlib import Path
        there = sys.modules.get("colorsys")
        Path("said").write_text(repr((there is not None, hasattr(there, "kept"), "LEFT" in os.environ)))
        """,
    )
    assert run(server, first) == run(server, second) == 0
    assert (tmp_path / "said").read_text() == "(True, False, False)"


def test_what_is_no_module_of_ours_is_imported_in_the_fork(tmp_path, server, monkeypatch):
    monkeypatch.chdir(tmp_path)
    script(tmp_path, "import os\nfrom pathlib import Path\nPath('said').write_text(repr(os.getpid()))\n", "threads.py")
    path = script(
        tmp_path, "import os, threads\nfrom pathlib import Path\nassert Path('said').read_text() == repr(os.getpid())\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(path.parent), prepend=os.pathsep)
    assert run(server, path) == run(server, path) == 0


def test_what_cannot_be_imported_is_the_scripts_to_report(tmp_path, server, capfd):
    script(tmp_path, "raise OSError('no such thing')\n", "broken.py")
    assert run(server, script(tmp_path, "import nowhere_at_all\n")) == 1
    assert run(server, script(tmp_path, "import broken\n", "second.py")) == 1
    said = capfd.readouterr().err
    assert "ModuleNotFoundError: No module named 'nowhere_at_all'" in said and "OSError: no such thing" in said
    assert run(server, script(tmp_path, "pass", "third.py")) == 0


def test_what_a_script_and_its_children_took_is_known(tmp_path, server):
    burns = "import time\nwhile time.process_time() < {s}: pass\n"
    child = script(tmp_path, burns.format(s=0.2), "child.py")
    path = script(tmp_path, f"import subprocess, sys\nsubprocess.run([sys.executable, {str(child)!r}])\n" + burns.format(s=0.3))
    fork = server.run(path, os.environ)
    assert fork.wait() == 0
    assert 0.4 < fork.processor_s < 2.0


def test_scripts_run_side_by_side(tmp_path, server):
    meets = """
        import sys, time
        from pathlib import Path
        here, there = (Path(__file__).with_name(name) for name in {names})
        here.touch()
        ends = time.monotonic() + 20
        while not there.exists():
            if time.monotonic() > ends:
                sys.exit(1)
            time.sleep(.01)
    """
    paths = [script(tmp_path, meets.format(names=names), f"{names[0]}.py") for names in (("one", "two"), ("two", "one"))]
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(lambda path: run(server, path), paths)) == [0, 0]


def test_the_server_has_one_thread_whatever_its_scripts_import(tmp_path, server, monkeypatch):
    """A fork of a process with several threads may find locks held by threads that it does not have."""
    monkeypatch.chdir(tmp_path)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        monkeypatch.setenv(name, "1")  # as the workflow sets them
    imports = [
        line
        for path in sorted((ROOT / "workflow" / "scripts").glob("*.py"))
        for line in path.read_text().splitlines()
        if line.startswith("from ovman.") and not line.startswith(tuple(f"from {name}" for name in APART))
    ]
    assert len(imports) > 50
    path = script(tmp_path, "\n".join(imports))
    path.write_text(
        path.read_text()
        + textwrap.dedent("""
        import os, sys
        from pathlib import Path
        threads = len(os.listdir(f"/proc/{os.getppid()}/task"))
        names = "onnxruntime", "cv2", "ovman_engine.engine", "torch", "matplotlib"
        Path("said").write_text(repr((threads, [name in sys.modules for name in names])))
        """)
    )
    assert run(server, path) == 0
    assert (tmp_path / "said").read_text() == repr((1, [True, True, True, False, False]))


def test_the_server_ends_with_the_process_that_started_it(tmp_path):
    path = script(
        tmp_path, "import os\nfrom pathlib import Path\nPath(__file__).with_name('server').write_text(str(os.getppid()))"
    )
    starts = f"from ovman.workflow.fork_server import ForkServer\nimport os\nassert ForkServer().run({str(path)!r}, os.environ)"
    killed = f"{starts}.wait() == 0\nos.kill(os.getpid(), 9)"
    assert subprocess.run([sys.executable, "-c", killed], cwd=ROOT).returncode == -signal.SIGKILL
    server = int(path.with_name("server").read_text())
    with pytest.raises(ChildProcessError):  # not a child of this process: looked for until it is gone
        os.waitpid(server, 0)
    for _ in range(500):
        if not alive(server):
            return
        time.sleep(0.01)
    raise AssertionError("the server is still there")


def test_a_server_that_was_killed_is_said_to_be(tmp_path, server):
    path = script(tmp_path, "import os, signal\nos.kill(os.getppid(), signal.SIGKILL)\n")
    with pytest.raises(ChildProcessError, match="the process that jobs are forked from has ended"):
        run(server, path)
