"""Confine this process and become an agent's server: limits, Landlock and seccomp, without privilege or dependency.

    python -I -S confine.py RULES PROGRAM ARGUMENT ...

RULES is a JSON object: `memory`, the bytes of private memory; `calls`, whether system calls are filtered; `files`, null or the
paths that the process may `read`, `list` and `write`, which Landlock enforces. PROGRAM cannot lift these rules.

An isolated agent is one process with threads. It cannot start others, so its limits hold for all that it does, and nothing is
left of it when it is killed. It gets no new socket, so its only line is the descriptor that it inherits.
"""

from __future__ import annotations

import ctypes
import errno
import json
import os
import platform
import resource
import signal
import struct
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress

LEAST_ABI = 3
"""Of Landlock, in Linux 6.2: earlier ones let a process truncate files that it may not write."""
READ, LIST, EVERYTHING = 0b101, 0b1000, (1 << 15) - 1  # execute and read files; list folders
FILES_ONLY = 0b111 | 1 << 14  # what Landlock can allow for a file: execute, write, read, truncate
DEVICES_AND_SOCKETS = 1 << 6 | 1 << 9 | 1 << 11
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446

FILE_BYTES = 1 << 30

ARCHITECTURES = {"x86_64": (0, 0xC000003E), "aarch64": (1, 0xC00000B7)}
"""Column of the tables below, and the value that seccomp has for the architecture."""
NEWEST = 462
"""The newest system call that the tables were checked against. The kernel is said not to have later ones."""
FORBIDDEN: Mapping[str, tuple[int | None, int | None]] = {
    # processes and namespaces
    "fork": (57, None), "vfork": (58, None), "unshare": (272, 97), "setns": (308, 268),
    # other processes; priorities of the same user's processes
    "ptrace": (101, 117), "process_vm_readv": (310, 270), "process_vm_writev": (311, 271), "kcmp": (312, 272),
    "tkill": (200, 130),
    "pidfd_send_signal": (424, 424), "pidfd_open": (434, 434), "pidfd_getfd": (438, 438), "process_madvise": (440, 440),
    "process_mrelease": (448, 448), "setpriority": (141, 140), "sched_setparam": (142, 118), "sched_setscheduler": (144, 119),
    "sched_setattr": (314, 274), "ioprio_set": (251, 30), "setrlimit": (160, 164), "perf_event_open": (298, 241),
    # sockets, and io_uring, whose requests no filter sees
    "socket": (41, 198), "connect": (42, 203), "bind": (49, 200), "io_uring_setup": (425, 425),
    # memory that RLIMIT_DATA does not count, or that others share
    "memfd_create": (319, 279), "memfd_secret": (447, 447), "userfaultfd": (323, 282), "shmget": (29, 194), "shmat": (30, 196),
    "semget": (64, 190), "msgget": (68, 186), "mq_open": (240, 180),
    # the kernel's keys and programs; files by handle; who touches which file
    "keyctl": (250, 219), "add_key": (248, 217), "request_key": (249, 218), "bpf": (321, 280), "open_by_handle_at": (304, 265),
    "inotify_init": (253, None), "inotify_init1": (294, 26), "fanotify_init": (300, 262),
    # attributes of files, which Landlock does not cover
    "setxattr": (188, 5), "lsetxattr": (189, 6), "fsetxattr": (190, 7), "removexattr": (197, 14), "lremovexattr": (198, 15),
    "fremovexattr": (199, 16),
}  # fmt: skip
PRETENDED: Mapping[str, tuple[int | None, int | None]] = {
    "chmod": (90, None), "fchmod": (91, 52), "fchmodat": (268, 53), "fchmodat2": (452, 452), "chown": (92, None),
    "fchown": (93, 55),
    "lchown": (94, None), "fchownat": (260, 54), "utime": (132, None), "utimes": (235, None), "futimesat": (261, None),
    "utimensat": (280, 88),
}  # fmt: skip
"""Attributes of files that copying sets: the call does nothing and says that it succeeded."""

Instruction = tuple[int, int, int, int]
LOAD, AND, IS, IS_AT_LEAST, HAS_BITS, RETURN = 0x20, 0x54, 0x15, 0x35, 0x45, 0x06
ALLOW, KILL, FAIL = 0x7FFF0000, 0x80000000, 0x00050000
REFUSE = (RETURN, 0, 0, FAIL | errno.EPERM)
PASS = (RETURN, 0, 0, ALLOW)

libc = ctypes.CDLL(None, use_errno=True)


def main() -> None:
    """Confine this process as the command line says, and run the program. OSError if the kernel refuses."""
    rules, program = json.loads(sys.argv[1]), sys.argv[2:]
    resource.setrlimit(resource.RLIMIT_DATA, (rules["memory"], rules["memory"]))
    if rules["calls"]:
        resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_BYTES, FILE_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        _check(libc.prctl(1, signal.SIGKILL))  # PR_SET_PDEATHSIG: it ends with the evaluator
        _check(libc.prctl(38, 1, 0, 0, 0))  # PR_SET_NO_NEW_PRIVS
        _check(libc.capset(struct.pack("=Ii", 0x20080522, 0), bytes(24)))  # root is refused what others are
        if rules["files"] is not None:
            restrict_files(**rules["files"])
        filter_calls()
    os.execv(program[0], program)


def landlock_abi() -> int:
    """Return the version of Landlock that the kernel has, 0 or less for none."""
    return int(libc.syscall(CREATE_RULESET, None, 0, 1)) if sys.platform == "linux" else 0


def restrict_files(read: Sequence[str], list: Sequence[str], write: Sequence[str]) -> None:  # noqa: A002
    """Restrict this process to files. Paths that do not exist are left out.

    Args:
        read: Files, and folders with all that is in them.
        list: Folders whose names it may list, with those below them.
        write: Folders that it may change, but for devices and sockets, and devices that it may write.
    """
    ruleset = _check(libc.syscall(CREATE_RULESET, struct.pack("=Q", EVERYTHING), 8, 0))
    changed = EVERYTHING & ~DEVICES_AND_SOCKETS
    own = os.path.realpath("/proc/self")
    for paths, access in ((read, READ | LIST), ([own], READ | LIST), (list, LIST), (write, changed)):
        for path in paths:
            with suppress(FileNotFoundError):
                opened = os.open(path, os.O_PATH | os.O_CLOEXEC)
                allowed = access if os.path.isdir(path) else access & FILES_ONLY  # noqa: PTH112 (pathlib is slow to import)
                _check(libc.syscall(ADD_RULE, ruleset, 1, struct.pack("=Qi", allowed, opened), 0))
    _check(libc.syscall(RESTRICT_SELF, ruleset, 0))


def filter_calls() -> None:
    """Refuse system calls of this process from now on."""
    column, architecture = ARCHITECTURES[platform.machine()]
    filtered = list(_program(column, architecture))
    packed = ctypes.create_string_buffer(b"".join(struct.pack("=HBBI", *one) for one in filtered))
    program = ctypes.create_string_buffer(struct.pack("@HP", len(filtered), ctypes.addressof(packed)))
    _check(libc.prctl(22, 2, program, 0, 0))  # PR_SET_SECCOMP, SECCOMP_MODE_FILTER


def _program(column: int, architecture: int) -> Iterator[Instruction]:
    """Yield the filter for the kernel's machine: each test jumps over as many instructions as it says, if true and if false."""
    yield from ((LOAD, 0, 0, 4), (IS, 1, 0, architecture), (RETURN, 0, 0, KILL))
    yield from ((LOAD, 0, 0, 0), (IS_AT_LEAST, 0, 1, NEWEST + 1), (RETURN, 0, 0, FAIL | errno.ENOSYS))
    yield from ((IS, 0, 1, 435), (RETURN, 0, 0, FAIL | errno.ENOSYS))  # clone3, whose flags cannot be seen; libraries use clone
    for calls, answer in ((FORBIDDEN, REFUSE), (PRETENDED, (RETURN, 0, 0, FAIL))):
        for numbers in calls.values():
            if (number := numbers[column]) is not None:
                yield from ((IS, 0, 1, number), answer)
    own = [(IS, 2, 0, 0), (IS, 1, 0, os.getpid()), REFUSE, PASS]
    tests: Mapping[tuple[int, int], Sequence[Instruction]] = {
        (56, 220): [_argument(0), (HAS_BITS, 1, 0, 0x10000), REFUSE, PASS],  # clone: CLONE_THREAD
        (9, 222): [_argument(3), (AND, 0, 0, 0x21), (IS, 0, 1, 0x21), REFUSE, PASS],  # mmap: MAP_SHARED and MAP_ANONYMOUS
        (53, 199): [
            _argument(1),
            (AND, 0, 0, 0xF),
            (IS, 1, 0, 1),
            REFUSE,
            PASS,
        ],  # socketpair: SOCK_STREAM, which sends nowhere else
        (302, 261): [_argument(2), (IS, 0, 2, 0), _argument(2, 4), (IS, 1, 0, 0), REFUSE, PASS],  # prlimit64: no new limit
        (157, 167): [_argument(0), (IS, 0, 1, 1), REFUSE, PASS],  # prctl: PR_SET_PDEATHSIG
        **{pair: [_argument(0), *own] for pair in ((62, 129), (234, 131), (129, 138), (297, 240))},  # signals to itself
    }
    for pair, test in tests.items():
        yield from ((IS, 0, len(test), pair[column]), *test)
    yield PASS


def _argument(index: int, half: int = 0) -> Instruction:
    """Load the lower half of an argument of the call, or the upper one: half=4."""
    return LOAD, 0, 0, 16 + 8 * index + half


def _check(returned: int) -> int:
    if returned < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"the kernel refuses isolation: {os.strerror(number)}")
    return returned


if __name__ == "__main__":
    main()
