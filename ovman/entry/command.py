"""The commands `ovman eval`, `ovman verify` and `ovman merge`: from their options to what is made of them."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from pydantic import ValidationError

from ovman.entry.evaluation import asked, evaluate
from ovman.entry.merging import merge
from ovman.entry.release import CONFIG, DATA, EntryError, Release
from ovman.entry.summary import as_text
from ovman.entry.verification import Verification, as_lines, verify
from ovman.evaluation.supervision import function
from ovman.models.settings import Arm, Kind, Need, Settings
from ovman.perception.libraries import cache as user_cache
from ovman.workflow.config import load
from ovman.workflow.parameter import stage_settings


def run(options: argparse.Namespace, say: Callable[[str], None]) -> str:
    """Evaluate as the options say, and return the summary as text. say: told of progress, a line a time.

    EntryError, ConfigError, RecordError, AgentError or SimulatorError, in one line.
    """
    settings = load(Path(options.config or CONFIG))
    shard = shard_of(options.shard)
    if options.agent is not None:
        settings, name = with_agent(settings, options.agent, options.name, options.needs)
    else:
        name = checked(settings, options.arm, options.name, options.needs)
    release = Release(Path(options.release or DATA), settings)
    episodes_file = None if options.episodes is None else Path(options.episodes)
    what = asked(release, options.split, episodes_file, options.scenes, shard, options.seeds or settings.evaluation.seeds)
    cache = user_cache() if options.cache is None else Path(options.cache)
    of_arm = stage_settings(settings, "rollouts", name)
    function(name, of_arm.arm.agent)
    manifest, summary = evaluate(
        of_arm, what, release, Path(options.out), cache.absolute(), say, checked_workers(options.workers)
    )
    return f"\n{as_text(summary, markdown=False)}"


def verified(options: argparse.Namespace, say: Callable[[str], None]) -> Verification:
    """Verify as the options say, and say what comes of it. EntryError, ConfigError, RecordError, SimulatorError, in one line."""
    release = Release(Path(options.release or DATA), load(Path(options.config or CONFIG)))
    episodes_file = None if options.episodes is None else Path(options.episodes)
    found = verify(Path(options.directory), release, episodes_file, say, checked_workers(options.workers))
    for line in as_lines(found):
        say(line)
    return found


def merged(options: argparse.Namespace) -> str:
    """Merge as the options say, and return the summary as text. EntryError, ConfigError or RecordError, in one line."""
    release = Release(Path(options.release or DATA), load(Path(options.config or CONFIG)))
    episodes_file = None if options.episodes is None else Path(options.episodes)
    _, summary = merge(Path(options.out), [Path(one) for one in options.directories], release, episodes_file)
    return as_text(summary, markdown=False)


def with_agent(settings: Settings, agent: str, name: str | None, needs: Sequence[str] | None) -> tuple[Settings, str]:
    """The settings with an arm for an agent of the user's, and the arm's name.

    The working directory is on Python's path from now on. EntryError for a name that is taken or is none, and for what cannot be
    needed here.
    """
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    wanted = [str(Need.TOURS)] if needs is None else list(needs)
    if others := [need for need in wanted if need != Need.TOURS]:
        raise EntryError(f"--needs: {others[0]} cannot be made outside the workflow; write tours, or an arm in an overlay")
    name = re.sub(r"\W", "_", agent.partition(":")[0].rpartition(".")[2].lower()) if name is None else name
    if name in settings.arms:
        raise EntryError(f"--name: {name} is an arm of config.yaml; write another name")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise EntryError(f"--name: {name!r} cannot name an arm; write small letters, digits and _")
    try:
        entry = {"name": name, "kind": "embodied", "agent": agent, "system": name, "memory": "its own", "needs": wanted}
        arm = Arm.model_validate(entry)
    except ValidationError as error:
        said = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise EntryError(f"--agent: {said}") from None
    return settings.model_copy(update={"arms": {**settings.arms, name: arm}}), name


def checked(settings: Settings, name: str, called: str | None, needs: Sequence[str] | None) -> str:
    """The name of an arm of config.yaml that can be run from episodes and tours alone. EntryError for another."""
    if called is not None or needs is not None:
        raise EntryError("--name and --needs are of an --agent; an arm of config.yaml has its own")
    able = [arm.name for arm in settings.arms.values() if _able(arm)]
    if name not in able:
        why = "does not drive from episodes and tours alone" if name in settings.arms else "is no arm of config.yaml"
        raise EntryError(f"--arm: {name} {why}; write one of {', '.join(able)}")
    return name


def checked_workers(number: int) -> int:
    """The number of workers. EntryError for fewer than one."""
    if number < 1:
        raise EntryError(f"--workers: {number} make nothing; write 1 or more")
    return number


def shard_of(text: str) -> tuple[int, int]:
    """(k, m) of "k/m", 1 <= k <= m. EntryError for another text."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise EntryError(f"--shard: {text!r} is no part; write k/m, k from 1 to m, such as 2/8")
    return int(found[1]), int(found[2])


def _able(arm: Arm) -> bool:
    """Whether an arm drives by itself and is given nothing that is neither in the episode nor in its tours."""
    alone = arm.made_by is None and arm.cut_from is None and not arm.reads_sightings
    return arm.kind is Kind.EMBODIED and alone and set(arm.needs) <= {Need.TOURS}
