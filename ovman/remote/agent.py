"""An agent that does not run in the evaluator's process: its messages (docs/protocol.md), and the place where it runs.

It is told observations and the query, and nothing more.
"""

from __future__ import annotations

import os
import secrets
import select
import shutil
import signal
import site
import socket
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import Action, Instruction, Observation, Query, Visit
from ovman.evaluation.supervision import AgentError
from ovman.perception.weights import ASSETS_RELEASE
from ovman.remote.connection import Connection, ConnectionLost
from ovman.remote.isolation import Isolation, explain, link_modules, make_command, write_settings
from ovman.runner import AGENT_DRAWS, Run
from ovman.settings.benchmark import Remote
from ovman.shipped import user_cache
from ovman_client.messages import PICTURES, POSE, POSITIONS
from ovman_client.server import TOKEN

VISITS_KEPT = 2
"""Visits that are kept as messages, of some 15 MB each: all seeds of an episode have them in common."""


@dataclass(frozen=True, slots=True)
class AgentEndpoint:
    """The place where an agent runs: a server that listens already, or one to start on this machine.

    Attributes:
        limits: Time and memory that the agent may use.
        url: ws://host:port of a server that listens; None for one to start.
        arguments: Of Python, for a server to start (`AgentProcess`).
        log: File that takes the output of a server that is started.
        isolation: Isolation of a server that is started.
        module: The agent's module, for a server that is started in the working directory's modules.
        config: File of settings that the server gets, without seeds if it is isolated.
        readable: Files and folders that it may read besides Python, OVMAN and its own modules.
        hidden: Those that it may not read.
    """

    limits: Remote
    url: str | None = None
    arguments: tuple[str, ...] = ()
    log: Path = Path("agent.log")
    isolation: Isolation = Isolation.NONE
    module: str = ""
    config: Path | None = None
    readable: tuple[Path, ...] = ()
    hidden: tuple[Path, ...] = ()


class RemoteAgents:
    """Makes the agents of an evaluation, over one connection that is made at first use, and again if it was lost."""

    def __init__(self, endpoint: AgentEndpoint) -> None:
        self._endpoint, self._tours = endpoint, TourMessages()
        self._process: AgentProcess | None = None
        self._connection: Connection | None = None

    def __call__(self, run: Run) -> RemoteAgent:
        """Return an agent for a run. ConnectionLost and AgentError as for `Connection`."""
        return RemoteAgent(self.connect(), run, self._endpoint.limits, self._tours)

    def connect(self) -> Connection:
        """Return the connection; make it if there is none. AgentError as for `AgentProcess` and `Connection`."""
        if self._connection is None:
            url, address = self._endpoint.url, None
            if url is None:
                self._process = AgentProcess(self._endpoint)
                url, address = self._process.url, self._process.address
            self._connection = Connection(url, self._endpoint.limits.connect_s, address)
        return self._connection

    def drop(self) -> None:
        """Close the connection, and end the server if it was started here."""
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self._process.end()
        self._connection = self._process = None


class RemoteAgent:
    """An `Agent` at the other end of a connection, for one run. Each method is one message and its reply."""

    looks = True
    _began: float | None = None

    def __init__(self, connection: Connection, run: Run, limits: Remote, tours: TourMessages) -> None:
        self._connection, self._limits, self._tours, self._run = connection, limits, tours, run
        self._tell(begin_message(run))

    def familiarise(self, visit: Visit) -> None:
        """Call `Agent.familiarise`. ConnectionLost and AgentError as for `Connection.ask`; so for the other methods."""
        self._tell({"type": "familiarise", "visit": self._encode(visit)})

    def revisit(self, visit: Visit) -> None:
        """Call `Agent.revisit`."""
        self._tell({"type": "revisit", "visit": self._encode(visit)})

    def ask(self, query: Instruction) -> None:
        """Call `Agent.ask`."""
        asked = {"sentence": query.sentence, "phrase": query.phrase}
        if isinstance(query, Query):
            asked |= {"category": query.category, "relation": str(query.relation)}
        reply = self._tell({"type": "ask", "query": asked})
        self.looks = reply.get("looks") is not False

    def act(self, observation: Observation) -> Action:
        """Call `Agent.act`. ConnectionLost for a reply that is not an action, and for a run that takes too long."""
        self._began = self._began or time.monotonic()
        if time.monotonic() - self._began > self._limits.run_s:
            raise self._connection.lose(f"act: a run of more than {self._limits.run_s:g} s; answer sooner, or raise remote.run_s")
        reply = self._connection.ask({"type": "act", "observation": observation_message(observation)}, self._limits.act_s)
        action = str(reply.get("action") if reply["type"] == "action" else reply["type"])
        if action not in [*Action]:
            raise self._connection.lose(f"act: the reply {action:.40} is not an action; answer one of {', '.join(Action)}")
        return Action(action)

    def _encode(self, visit: Visit) -> dict[str, Any]:
        return {**self._tours(visit), "content": self._run.conceal(visit.content)}

    def _tell(self, message: Mapping[str, Any]) -> dict[str, Any]:
        reply = self._connection.ask(message, self._limits.tour_s)
        if reply["type"] != "done":
            says = f"{message['type']}: the reply is {reply['type']:.40}, not done; answer as the protocol says"
            raise self._connection.lose(says)
        return reply


class TourMessages:
    """Visits as parts of messages; the last few are kept by their content."""

    def __init__(self) -> None:
        self._kept: dict[str | None, list[dict[str, Any]]] = {}

    def __call__(self, visit: Visit) -> dict[str, Any]:
        """Return the visit as a part of a message."""
        if visit.content is None or visit.content not in self._kept:
            while len(self._kept) >= VISITS_KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[visit.content] = [observation_message(seen) for seen in visit.observations]
        observations, reachable = self._kept[visit.content], _array(visit.reachable, POSITIONS)
        return {"observations": observations, "reachable": reachable, "content": visit.content}


def begin_message(run: Run) -> dict[str, Any]:
    """Return the message `begin`: constants of the protocol, the body's camera, and words that the agent's draws follow from."""
    body, primitives = run.embodiment, run.episode.protocol.primitives
    return {
        "type": "begin",
        **primitives.model_dump(mode="json"),
        "action_budget": primitives.action_budget if run.arm.budget is None else run.arm.budget,
        "grid": run.episode.rules.grid,
        "camera": {"width": body.width_px, "height": body.height_px, "field_of_view_deg": body.field_of_view_deg},
        "words": {name: run.words(name) for name in AGENT_DRAWS},
    }


def observation_message(seen: Observation) -> dict[str, Any]:
    """Return an observation as a part of a message. ValueError for one with oracle positions, which stay with the evaluator."""
    if seen.positions is not None:
        raise ValueError("an agent that is given positions runs in the evaluator's process")
    return {
        "rgb": None if seen.rgb is None else _array(seen.rgb, PICTURES["rgb"]),
        "depth": None if seen.depth is None else _array(seen.depth, PICTURES["depth"]),
        "pose": {name: float(getattr(seen.pose, name)) for name in POSE},
        "field_of_view_deg": float(seen.field_of_view_deg),
        "last_action_succeeded": bool(seen.last_action_succeeded),
        "reachable": None if seen.reachable is None else _array(seen.reachable, POSITIONS),
    }


def _array(values: np.ndarray, dtype: str) -> dict[str, Any]:
    ordered = np.ascontiguousarray(values, dtype)
    return {"dtype": dtype, "shape": list(ordered.shape), "data": ordered.tobytes()}


PASSED = ("PATH", "PYTHONPATH", "PYTHONNOUSERSITE", "LANG", "VIRTUAL_ENV", "LD_LIBRARY_PATH")
"""Variables of the evaluator's that the process has, and those that begin with `PASSED_BEGINNINGS`."""
PASSED_BEGINNINGS = ("LC_", "OMP_", "OPENBLAS_", "MKL_", "CUDA_", "NVIDIA_", "ORT_")
TAIL = 2000
"""Bytes of the log in which the last line is looked for."""


class AgentProcess:
    """A server of an agent that the evaluator starts, `ovman serve`.

    url, address: Place to connect to. The address is of a Unix socket, which the process inherits as a descriptor.
    """

    def __init__(self, endpoint: AgentEndpoint) -> None:
        """Start the process and wait until it listens.

        Args:
            endpoint: Its arguments are of Python, for a server that takes the numbers of two files: of the socket, and of one to
                write to when it listens. It ends with its session when its standard input closes, however the evaluator ended.

        Raises:
            ConnectionLost: The process ends before it listens.
            AgentError: The process does not listen in time.
        """
        self._folder = Path(tempfile.mkdtemp(prefix="ovman-agent-"))
        places = {name: self._folder / name for name in ("work", "home", "tmp")}
        for place in places.values():
            place.mkdir()
        token, connect_s = secrets.token_urlsafe(16), endpoint.limits.connect_s
        reading, writing = os.pipe()
        with endpoint.log.open("ab") as output, socket.socket(socket.AF_UNIX) as listener:
            listener.bind("")  # the kernel draws a name, which is not that of a file
            listener.listen()
            self.address, self.url = listener.getsockname(), f"ws://localhost/?token={token}"
            numbers = ["--listener", str(listener.fileno()), "--ready", str(writing)]
            user = {"PYTHONUSERBASE": site.getuserbase(), "HOME": str(places["home"]), "TMPDIR": str(places["tmp"])}
            self._process = subprocess.Popen(
                self._command(endpoint, numbers),
                cwd=places["work"],
                env={**passed_variables(os.environ), **user, "XDG_CACHE_HOME": str(self._cache(endpoint)), TOKEN: token},
                stdin=subprocess.PIPE,
                stdout=output,
                stderr=output,
                pass_fds=[listener.fileno(), writing],
                start_new_session=True,
            )
        os.close(writing)
        listens, _, _ = select.select([reading], [], [], connect_s)
        is_ready = bool(listens and os.read(reading, 64))
        os.close(reading)
        if not is_ready:
            self.end()
            if not listens:
                raise AgentError(f"the agent did not listen within {connect_s:g} s; raise remote.connect_s")
            with endpoint.log.open("rb") as output:
                output.seek(max(0, output.seek(0, os.SEEK_END) - TAIL))
                said = output.read(TAIL).decode("utf-8", "replace").strip().splitlines() or ["it said nothing"]
            raise ConnectionLost(
                f"the agent's process ended before it listened: {said[-1]}{explain(endpoint.isolation, said[-1])}"
            )

    def _command(self, endpoint: AgentEndpoint, numbers: Sequence[str]) -> list[str]:
        """Return the command of the process. Its modules, settings and weights lie in its own folder if it is isolated."""
        path, config, readable = Path.cwd(), endpoint.config, list(endpoint.readable)
        if endpoint.isolation is not Isolation.NONE:
            path = self._folder / "code"
            readable += link_modules(endpoint.module, path, endpoint.readable)
            if endpoint.config is not None:
                config = self._folder / "config.yaml"
                write_settings(endpoint.config, config)
        told = [] if config is None else ["--path", str(path), "--config", str(config)]
        program, memory = [*endpoint.arguments, *told, *numbers], int(endpoint.limits.memory_gb * 1e9)
        return make_command(endpoint.isolation, program, self._folder, memory, readable, endpoint.hidden)

    def _cache(self, endpoint: AgentEndpoint) -> Path:
        """Return the cache of the process: the user's, or one that has weights of the user's alone."""
        if endpoint.isolation is Isolation.NONE:
            return user_cache().parent
        own = self._folder / "home" / ".cache" / "ovman"
        own.mkdir(parents=True)
        (own / ASSETS_RELEASE).symlink_to(user_cache() / ASSETS_RELEASE)
        return own.parent

    def end(self) -> None:
        """End the process with those that it started in its session, and remove its folders."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.communicate()
        shutil.rmtree(self._folder, ignore_errors=True)


def passed_variables(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the variables of the evaluator that an agent's process has."""
    return {name: value for name, value in environment.items() if name in PASSED or name.startswith(PASSED_BEGINNINGS)}
