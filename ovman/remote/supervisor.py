"""Run an agent's server, hold all processes that come of it to limits, and end every one of them.

A script for `AgentProcess`, with the standard library alone: `supervisor.py LIMITS COMMAND...`. LIMITS is JSON with the keys of
section `remote`, `places` (the agent's folder, with its subfolder `work`) and `ready` (the number of a file for the command).

All processes of the agent, daemons included, stay below this process: Linux gives orphans to the nearest subreaper. When standard
input closes, however the evaluator ended, this process ends all of them. Standard output gets one line if a limit was passed.
Standard error is the agent's log.
"""

from __future__ import annotations

import ctypes
import json
import os
import resource
import select
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

GB = 10**9
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36
"""Linux's numbers for: end this process when its parent ends; be the parent of the orphans among the descendants."""
PAUSE_S = 0.5
"""Between two measurements; ten times as long as a measurement takes, where that is more."""
STUBBORN_S = 30.0
"""After this long, a process that SIGKILL does not end waits for a device or a network's disk."""
SHARED = Path("/dev/shm")
"""Where shared memory has names."""
BLOCK = 512


def main() -> None:
    """Run the command until it ends, passes a limit, or the evaluator has had enough."""
    limits, command = json.loads(sys.argv[1]), sys.argv[2:]
    libc = ctypes.CDLL(None)
    libc.prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    places = os.open(limits["places"], os.O_RDONLY)

    def hold_to_limits() -> None:
        memory, file = (int(limits[key] * GB) for key in ("memory_gb", "file_gb"))
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
        resource.setrlimit(resource.RLIMIT_FSIZE, (file, file))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)

    agent = subprocess.Popen(
        command,
        cwd=Path(limits["places"], "work"),
        stdin=subprocess.DEVNULL,
        stdout=sys.stderr,
        pass_fds=[limits["ready"]],
        start_new_session=True,
        preexec_fn=hold_to_limits,
    )
    os.close(limits["ready"])
    pause = PAUSE_S
    while not select.select([sys.stdin], [], [], pause)[0] and agent.pid not in set(reaped()):
        began = time.monotonic()
        if passed := passed_limit(limits, places):
            print(passed, flush=True)
            break
        pause = max(PAUSE_S, 10 * (time.monotonic() - began))
    end_all()


def passed_limit(limits: Mapping[str, Any], places: int) -> str | None:
    """Say which limit the agent's processes pass together, None for none. places: descriptor of the agent's folder."""
    there = descendants()
    if len(there) > limits["processes"]:
        return f"the agent has {len(there)} processes; start fewer, or raise remote.processes ({limits['processes']})"
    files = opened(there)
    shared = SHARED.stat().st_dev if SHARED.is_dir() else -1
    memory = resident(there, BLOCK * sum(of.st_blocks for of, name in files if of.st_dev == shared or "memfd:" in name), limits)
    if memory > limits["memory_gb"] * GB:
        return f"the agent's processes have {memory / GB:.2f} GB; use less, or raise remote.memory_gb ({limits['memory_gb']:g})"
    device = os.fstat(places).st_dev
    unnamed = sum(of.st_blocks for of, _ in files if of.st_nlink == 0 and of.st_dev == device)
    disk = BLOCK * (unnamed + sum(of.st_blocks for of in written(places)))
    if disk > limits["disk_gb"] * GB:
        return f"the agent's files have {disk / GB:.2f} GB; write less, or raise remote.disk_gb ({limits['disk_gb']:g})"
    return None


def descendants() -> list[int]:
    """Return the processes below this one, parents first."""
    children: dict[int, list[int]] = {}
    for entry in os.scandir("/proc"):
        if entry.name.isdigit() and (said := of_proc(int(entry.name), "stat")):
            children.setdefault(int(said.rpartition(")")[2].split()[1]), []).append(int(entry.name))
    found = children.get(os.getpid(), [])
    for pid in found:  # grows on the way
        found += children.get(pid, [])
    return found


def resident(pids: list[int], shared: int, limits: Mapping[str, Any]) -> float:
    """Return the bytes of memory of processes. shared: of shared memory that they hold open, mapped or not.

    Memory that processes share counts once, and files that they map do not count. The kernel takes long to tell this (Linux 5.4
    and later), so it is asked only if the sum of what is resident passes the limit.
    """
    page = resource.getpagesize()
    whole = sum(int(fields[1]) * page for pid in pids if (fields := of_proc(pid, "statm").split()))
    if whole + shared <= limits["memory_gb"] * GB:
        return whole + shared
    parts = {"Pss_Anon:": 0, "Pss_Shmem:": 0}
    for pid in pids:
        for line in of_proc(pid, "smaps_rollup").splitlines():
            name, *rest = line.split()
            if name in parts:
                parts[name] += int(rest[0]) * 1024
    return parts["Pss_Anon:"] + max(parts["Pss_Shmem:"], shared)


def opened(pids: list[int]) -> list[tuple[os.stat_result, str]]:
    """Return the regular files that processes hold open, each once, with its name."""
    found: dict[tuple[int, int], tuple[os.stat_result, str]] = {}
    for pid in pids:
        with suppress(OSError):
            for entry in os.scandir(f"/proc/{pid}/fd"):
                with suppress(OSError):
                    of = entry.stat()
                    if stat.S_ISREG(of.st_mode):
                        found[of.st_dev, of.st_ino] = of, str(Path(entry.path).readlink())
    return [*found.values()]


def written(places: int) -> Iterator[os.stat_result]:
    """Yield what is in the agent's folder, whatever has become of its name."""
    for _, _, files, folder in os.fwalk(".", dir_fd=places):
        for name in files:
            with suppress(OSError):
                yield os.stat(name, dir_fd=folder, follow_symlinks=False)


def of_proc(pid: int, name: str) -> str:
    """Return what the kernel says of a process, nothing for one that has ended."""
    try:
        return Path("/proc", str(pid), name).read_text(errors="replace")
    except OSError:
        return ""


def reaped() -> Iterator[int]:
    """Yield the processes below this one that have ended since."""
    with suppress(ChildProcessError):
        while pid := os.waitpid(-1, os.WNOHANG)[0]:
            yield pid


def end_all() -> None:
    """End all processes below this one. Each is stopped first, so that none starts another meanwhile."""
    until = time.monotonic() + STUBBORN_S
    while (there := descendants()) and time.monotonic() < until:
        for signum in (signal.SIGSTOP, signal.SIGKILL):
            for pid in there:
                with suppress(ProcessLookupError, PermissionError):
                    os.kill(pid, signum)
        for _ in reaped():
            pass
        time.sleep(0.01)
    if there:
        print(f"processes {', '.join(map(str, there))} of the agent cannot be ended", flush=True)


if __name__ == "__main__":
    main()
