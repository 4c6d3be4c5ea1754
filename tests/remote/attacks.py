"""Try to do harm as an agent: `attacks.py NAME FACTS --listener FD --ready FD`. Attacks return what they got, or raise."""

from __future__ import annotations

import ctypes
import json
import mmap
import os
import resource
import signal
import socket
import stat
import sys
import time
from pathlib import Path

libc = ctypes.CDLL(None, use_errno=True)


def called(returned):
    if returned < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return returned


def reads_the_released_episodes(facts):
    return Path(facts["data"], "episodes", "main.jsonl").read_bytes()[:20]


def reads_recorded_tours(facts):
    return Path(facts["cache"], "tours", "ids.png").read_bytes()


def reads_earlier_runs_in_the_working_directory(facts):
    return Path(facts["here"], "earlier", "runs.jsonl").read_bytes()


def reads_the_checkout(facts):
    return Path(facts["checkout"], "README.md").read_bytes()[:20]


def lists_the_checkout(facts):
    return any(path.name == "data" for path in Path(facts["checkout"]).iterdir()) or 1 / 0


def reads_through_a_link_in_its_folder(facts):
    Path("link").symlink_to(facts["secret"])
    return Path("link").read_text()


def reads_through_a_hard_link(facts):
    link = Path(os.environ["HOME"], "hard")
    os.link(facts["secret"], link)
    return link.read_text()


def looks_into_temporary_files_of_others(facts):
    return Path("/tmp", facts["temporary"]).read_text()


def plants_a_link_in_tmp(facts):
    Path("/tmp", facts["planted"]).symlink_to(facts["secret"])
    return Path("/tmp").stat().st_ino == facts["tmp"] or 1 / 0


def reads_variables_of_a_process(facts):
    return Path(f"/proc/{facts['victim']}/environ").read_bytes()


def reads_files_that_a_process_has_open(facts):
    return Path(f"/proc/{facts['victim']}/fd/0").read_text()


def reads_the_command_line_of_a_process(facts):
    return Path(f"/proc/{facts['victim']}/cmdline").read_bytes()


def traces_a_process(facts):
    return called(libc.ptrace(16, facts["victim"], 0, 0)) == 0


def takes_a_descriptor_of_a_process(facts):
    victim = called(libc.syscall(434, facts["victim"], 0))
    return Path(f"/proc/self/fd/{called(libc.syscall(438, victim, 0, 0))}").read_text()


def kills_a_process(facts):
    os.kill(facts["victim"], signal.SIGKILL)
    return True


def stops_a_process(facts):
    os.kill(facts["victim"], signal.SIGSTOP)
    return True


def slows_a_process(facts):
    os.setpriority(os.PRIO_PROCESS, facts["victim"], 19)
    return os.getpriority(os.PRIO_PROCESS, facts["victim"])


def connects_by_tcp(facts):
    return socket.create_connection(("127.0.0.1", facts["tcp"]), timeout=5).fileno()


def listens_by_tcp(facts):
    return socket.create_server(("127.0.0.1", 0)).getsockname()


def sends_by_udp(facts):
    return socket.socket(type=socket.SOCK_DGRAM).sendto(b"x", ("127.0.0.1", facts["udp"]))


def connects_by_a_unix_socket(facts):
    return socket.socket(socket.AF_UNIX).connect(facts["unix"]) is None


def connects_by_an_abstract_socket(facts):
    return socket.socket(socket.AF_UNIX).connect("\0" + facts["abstract"]) is None


def sends_by_half_of_a_pair(facts):
    return socket.socketpair(type=socket.SOCK_DGRAM)[0].sendto(b"x", facts["datagrams"])


def opens_a_ring(facts):
    return called(libc.syscall(425, 8, ctypes.create_string_buffer(120)))


def writes_into_the_checkout(facts):
    return Path(facts["place"], "written").write_text("x")


def changes_the_journal(facts):
    with Path(facts["journal"]).open("a") as journal:
        return journal.write("forged")


def cuts_a_file(facts):
    os.truncate(facts["secret"], 0)
    return True


def opens_a_folder_to_all(facts):
    Path(facts["place"]).chmod(0o777)
    return stat.S_IMODE(Path(facts["place"]).stat().st_mode) == 0o777 or 1 / 0


def puts_a_pth_into_the_environment(facts):
    return Path(facts["packages"], facts["pth"]).write_text("\n")


def replaces_a_module_of_ovman(facts):
    return Path(facts["checkout"], "ovman", facts["pth"]).write_text("\n")


def writes_shared_memory(facts):
    return Path("/dev/shm", facts["planted"]).write_text("x")


def takes_a_segment_of_shared_memory(facts):
    return called(libc.shmget(facts["key"], 4096, 0o1600))


def maps_more_memory_than_allowed(facts):
    shared = mmap.mmap(-1, 2 * facts["memory"])
    return len(shared)


def holds_memory_in_files(facts):
    return called(libc.memfd_create(b"x", 0))


def lowers_the_limits_of_a_process(facts):
    return resource.prlimit(facts["victim"], resource.RLIMIT_NOFILE, (4, 4))


def bombs_with_forks(facts):
    children = 0
    for _ in range(30):
        if os.fork() == 0:
            time.sleep(100)
        children += 1
    return children


def leaves_a_process(facts):
    if os.fork() == 0:
        os.setsid()
        os.execv(sys.executable, [sys.executable, "-c", "import time; time.sleep(100)", facts["planted"]])
    return True


def makes_a_user_namespace(facts):
    return called(libc.unshare(0x10000000)) == 0


def makes_a_device(facts):
    os.mknod(Path(os.environ["HOME"], "disk"), stat.S_IFBLK | 0o600, Path(facts["secret"]).stat().st_dev)
    return True


def watches_a_folder(facts):
    return called(libc.inotify_add_watch(called(libc.inotify_init1(0)), facts["place"].encode(), 0xFFF))


def main():
    attack, facts, ready = globals()[sys.argv[1]], json.loads(sys.argv[2]), int(sys.argv[-1])
    try:
        says = f"GOT {attack(facts)!r}"
    except Exception as error:
        says = f"REFUSED {type(error).__name__}: {error}"
    print(says, flush=True)
    os.write(ready, b"ready\n")
    sys.stdin.read()


if __name__ == "__main__":
    main()
