"""A SLURM of one node, in a folder of its own, started and stopped by this process and seen by no other.

munged, slurmctld and slurmd run as this user, on free ports of the loopback, with two fake GPUs (SLURM counts them; nothing is
behind them). Jobs of the partition `high` take the place of those of `low`, which are queued again. There is no accounting.
"""

from __future__ import annotations

import ctypes
import getpass
import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "srun")
REMEDY = "sudo apt install slurmctld slurmd slurm-client munge"
STARTS_S = 30.0
ENDS_S = 20.0
DEATH_SIGNAL = 1
"""PR_SET_PDEATHSIG of <linux/prctl.h>."""
PATH = f"{os.environ['PATH']}:/usr/sbin:/sbin"

CONF = """\
ClusterName=ovman
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ctld_port}
SlurmdPort={slurmd_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
MinJobAge=3600
KillWait=5
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
SchedulerParameters=sched_interval=1,sched_min_interval=0
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
GresTypes=gpu
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory_mb} Gres=gpu:2 State=UNKNOWN
PartitionName=low Nodes={host} Default=YES PriorityTier=1 MaxTime=INFINITE State=UP
PartitionName=high Nodes={host} PriorityTier=10 MaxTime=INFINITE State=UP
"""
GRES = "NodeName={host} Name=gpu Count=2 File=/dev/null,/dev/zero\n"
SRUN = "#!/bin/sh\nSLURM_CONF='{conf}' exec {srun} \"$@\"\n"


def missing() -> list[str]:
    """The programs of SLURM that this machine lacks."""
    return [name for name in PROGRAMS if shutil.which(name, path=PATH) is None]


@dataclass(frozen=True)
class Slurm:
    """A SLURM that runs. environment: in which its programs and Snakemake find it."""

    folder: Path
    environment: Mapping[str, str]

    def ask(self, *command: str) -> str:
        """What one of SLURM's programs says. CalledProcessError where it fails."""
        return subprocess.run(command, env=dict(self.environment), check=True, capture_output=True, text=True).stdout.strip()

    def queue(self) -> dict[str, str]:
        """The state of every job that SLURM remembers, by its id."""
        lines = self.ask("squeue", "--noheader", "--states=all", "--format=%i %T").splitlines()
        return dict(line.split(maxsplit=1) for line in lines)

    def described(self, job: str) -> dict[str, str]:
        """What SLURM knows of a job."""
        words = self.ask("scontrol", "--oneliner", "show", "job", job).split()
        return dict(word.split("=", 1) for word in words if "=" in word)


@contextmanager
def running(folder: Path) -> Iterator[Slurm]:
    """SLURM with its files in `folder`; all of it has ended, and its jobs with it, when the block ends."""
    host = socket.gethostname().split(".")[0]
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir(parents=True)
    folder.chmod(0o755)  # munged asks for it
    cpus = min(os.cpu_count() or 1, 2)
    memory_mb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 1_100_000  # slurmd refuses more than there is
    values = {"host": host, "folder": folder, "user": getpass.getuser(), "cpus": cpus, "memory_mb": memory_mb}
    ports = dict(zip(("ctld_port", "slurmd_port"), free_ports(2), strict=True))
    (folder / "slurm.conf").write_text(CONF.format(**values, **ports))
    (folder / "gres.conf").write_text(GRES.format(**values))
    (folder / "munge.key").write_bytes(os.urandom(128))
    (folder / "munge.key").chmod(0o400)
    environment = {name: text for name, text in os.environ.items() if not name.startswith(("SLURM", "OVMAN"))}
    environment |= {"SLURM_CONF": str(folder / "slurm.conf"), "PATH": f"{folder / 'bin'}:{PATH}"}
    # The plug-in takes SLURM's variables from what it starts within a job, this one among them; a cluster has its file in /etc.
    (folder / "bin" / "srun").write_text(SRUN.format(conf=folder / "slurm.conf", srun=shutil.which("srun", path=PATH)))
    (folder / "bin" / "srun").chmod(0o755)
    munge = [f"--{name}={folder}/munge.{end}" for name, end in (("key-file", "key"), ("socket", "socket"), ("pid-file", "pid"))]
    munge += [f"--log-file={folder}/munge.log", f"--seed-file={folder}/munge.seed", "--foreground", "--force"]
    daemons: list[subprocess.Popen[bytes]] = []
    slurm = Slurm(folder, environment)
    try:
        for command in (["munged", *munge], ["slurmctld", "-D"], ["slurmd", "-D", "-N", host]):
            with (folder / f"{command[0]}.said").open("wb") as said:
                daemons.append(
                    subprocess.Popen(command, env=environment, cwd=folder, stdout=said, stderr=said, preexec_fn=mortal)
                )
            if command[0] == "munged":
                until(lambda: (folder / "munge.socket").exists(), "munged has not started", folder)
        until(lambda: _idle(slurm), "SLURM has not started", folder)
        try:
            yield slurm
        finally:
            slurm.ask("scancel", "--user", getpass.getuser())
            until(lambda: not {"RUNNING", "COMPLETING"} & {*slurm.queue().values()}, "jobs go on", folder)
    finally:
        for daemon in reversed(daemons):
            daemon.send_signal(signal.SIGTERM)
            try:
                daemon.wait(timeout=ENDS_S)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()


def mortal() -> None:
    """End with the process that started this one, however that ends."""
    ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGTERM)


def free_ports(number: int) -> list[int]:
    """Ports of the loopback that nobody listens on."""
    sockets = [socket.socket() for _ in range(number)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def _idle(slurm: Slurm) -> bool:
    try:
        return slurm.ask("sinfo", "--noheader", "--partition=low", "--format=%T") == "idle"
    except subprocess.CalledProcessError:
        return False


def until(holds, complaint: str, folder: Path, within_s: float = STARTS_S) -> None:
    """Wait until something holds. AssertionError with the daemons' last words where it does not in time."""
    end = time.monotonic() + within_s
    while not holds():
        if time.monotonic() > end:
            said = {path.name: path.read_text(errors="replace")[-1000:] for path in sorted(folder.glob("*.said"))}
            logs = {path.name: path.read_text(errors="replace")[-1000:] for path in sorted(folder.glob("*.log"))}
            raise AssertionError(f"{complaint}: {said | logs}")
        time.sleep(0.1)
