"""`python -m dualmap_process request.json`, in the root of the clone. See `session.run` for what a request holds.

The process is left by os._exit: DualMap's threads would keep it alive after an error.
"""

import contextlib
import json
import os
import sys
import threading
import time
import traceback
from pathlib import Path

from . import session


def _end_with_parent(output: str) -> None:
    """End when the process that started this one has died: nobody waits for its maps, and the GPU is wanted.

    The directory `output` then says so: its log ends in the middle, and no status comes to anybody.
    """
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        with contextlib.suppress(OSError):
            _fail(output, "ended without a map, because the process that started it has ended")
        os._exit(1)

    threading.Thread(target=watch, name="end-with-parent", daemon=True).start()


def _forget_own_directory() -> None:
    """Modules beside this package must hide nothing of the clone and of its environment."""
    os.environ.pop("PYTHONPATH", None)
    beside = Path(__file__).resolve().parents[1]
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != beside]


def _fail(output: str, said: str) -> None:
    Path(output, "error.txt").write_text(" ".join(said.split()) + "\n")


def main(request_file: str) -> int:
    """Exit status of the run that a file asks for. What is wrong is said in `error.txt`, where the objects would be."""
    request = json.loads(Path(request_file).read_text())
    _end_with_parent(request["output"])
    try:
        session.run(request)
        return 0
    except session.RunError as error:
        said = str(error)
    except BaseException as error:
        traceback.print_exc()
        said = f"{type(error).__name__}: {error}"
    _fail(request["output"], said)
    return 1


if __name__ == "__main__":
    _forget_own_directory()
    status = main(sys.argv[1])
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
