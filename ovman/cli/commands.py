"""The commands of `ovman`. A command imports what it needs, of which some may not be installed.

To add a command, write a function below with `@app.command`. Its parameters are the options and its docstring is the help. It
returns the exit status.
"""

from __future__ import annotations

import os
import sys
import time
import webbrowser
from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Group, Parameter
from cyclopts.validators import LimitedChoice
from cyclopts.validators import Path as Existing

from ovman import __version__
from ovman.cli import console
from ovman.entry import CONFIG, DATA
from ovman.faults import printable

app = App(
    name="ovman",
    help="Open-vocabulary motion-aware navigation.",
    version=f"ovman {__version__}",
    help_format="plaintext",
    default_parameter=Parameter(
        negative=(), allow_repeating=True, show_default=lambda value: str(value) if value or type(value) is int else None
    ),
)
app.register_install_completion_command(help="Complete commands and options in this shell from now on.")

INTERRUPTED = {
    "eval": "interrupted; the same command goes on in {out}",
    "draw": "interrupted; the same command goes on in {out}",
    "dataset": "interrupted; tours that are recorded are kept",
}
"""Messages after Ctrl-C by command, with options in braces. Other commands print "interrupted"."""

AGENT = Group("Agent (one of them)", validator=LimitedChoice())
EPISODES = Group("Episodes (one of them)", validator=LimitedChoice())
NEEDED_EPISODES = Group("Episodes (one of them)", validator=LimitedChoice(1, 1))
SEED = Group("Seed (one of them)", validator=LimitedChoice(1, 1))

ReleaseFolder = Annotated[
    Path,
    Parameter(name="--release", help="released files", show_default=False, validator=Existing(exists=True, file_okay=False)),
]
ConfigFile = Annotated[Path, Parameter(name="--config", help="settings", show_default=False)]
Workers = Annotated[int, Parameter(help="processes, one scene each")]
Json = Annotated[bool, Parameter(name="--json", help="print JSON, and progress on standard error")]
Quiet = Annotated[bool, Parameter(help="print no progress")]
Many = Parameter(consume_multiple=True)


@app.command
def demo(*, seed: int | None = None, out: Path | None = None, as_json: Json = False, quiet: Quiet = False) -> int:
    """Draw a home and changes in it, ask two agents about each change, and show both visits, answers and paths.

    Args:
        seed: other seeds give other homes; default: one of the clock
        out: a new folder for the page and the runs; default: ovman-demo-SEED
    """
    from ovman.demo import PAGE, run_demo

    own = time.time_ns() // 1_000_000 if seed is None else seed
    folder = out or Path(f"ovman-demo-{own}")
    with console.report_progress(quiet, as_json) as say:
        rows = run_demo(own, seed is None, folder, say)
    page = (folder / PAGE).absolute()
    if as_json:
        console.print_json({"seed": own, "page": str(page), "runs": rows})
    else:
        console.print_rows(rows, as_json)
        console.print_text(f"\n{page}\n")
    if sys.stdout.isatty() and any(name in os.environ for name in ("DISPLAY", "WAYLAND_DISPLAY")):
        webbrowser.open(page.as_uri())
    return 0


@app.command
def splits(*, release: ReleaseFolder = DATA, config: ConfigFile = CONFIG, as_json: Json = False) -> int:
    """List the splits: episodes, scenes, and what differs from the paper's protocol."""
    from ovman.entry import listing
    from ovman.entry.release import Release
    from ovman.settings.config import load

    console.print_rows(listing.list_splits(Release(release, load(config))), as_json)
    return 0


@app.command
def agents(*, config: ConfigFile = CONFIG, as_json: Json = False) -> int:
    """List the agents that `ovman eval --arm` runs."""
    from ovman.entry import listing
    from ovman.settings.config import load

    console.print_rows(listing.list_agents(load(config)), as_json)
    return 0


@app.command
def episodes(
    *,
    split: str = "main",
    scenes: Annotated[tuple[str, ...], Many] = (),
    release: ReleaseFolder = DATA,
    config: ConfigFile = CONFIG,
    as_json: Json = False,
) -> int:
    """List the episodes of a split with their sentences.

    Args:
        split: a split of config.yaml
        scenes: episodes of these scenes alone
    """
    from ovman.entry import listing
    from ovman.entry.release import Release
    from ovman.settings.config import load

    console.print_rows(listing.list_episodes(Release(release, load(config)), split, scenes), as_json)
    return 0


@app.command
def score(
    predictions: Path,
    /,
    *,
    split: Annotated[str, Parameter(group=EPISODES)] = "main",
    episodes: Annotated[Path | None, Parameter(group=EPISODES)] = None,
    partial: bool = False,
    release: ReleaseFolder = DATA,
    config: ConfigFile = CONFIG,
    as_json: Json = False,
) -> int:
    """Score a file of predicted points, next to the released arms.

    Args:
        predictions: JSON lines with `episode`, and `x` and `z` in metres, or `abstain`
        split: a split of config.yaml
        episodes: a file of episodes, or the folder of a draw, instead
        partial: print rates although episodes are missing; they are not a score
    """
    from ovman.entry import score
    from ovman.entry.release import Release
    from ovman.settings.config import load

    found = score.score_file(predictions, Release(release, load(config)), split, episodes, partial)
    if found.is_whole or partial:
        console.print_text(score.as_json(found) if as_json else score.as_text(found))
    if not found.is_whole:
        console.print_error("score", score.complaint(found))
    return 0 if found.is_whole else 1


@app.command(name="eval")
def evaluate(
    *,
    agent: Annotated[str | None, Parameter(group=AGENT)] = None,
    arm: Annotated[str | None, Parameter(group=AGENT)] = None,
    server: str | None = None,
    in_process: bool = False,
    isolation: Literal["auto", "bubblewrap", "landlock", "none"] = "auto",
    readable: Annotated[tuple[Path, ...], Many] = (),
    failures: Literal["stop", "abstain"] = "stop",
    track: Literal["paper", "words"] | None = None,
    split: Annotated[str | None, Parameter(group=NEEDED_EPISODES)] = None,
    episodes: Annotated[Path | None, Parameter(group=NEEDED_EPISODES)] = None,
    out: Path,
    name: str | None = None,
    needs: Annotated[list[str] | None, Many] = None,
    scenes: Annotated[tuple[str, ...], Many] = (),
    seeds: Annotated[tuple[int, ...], Many] = (),
    cache: Path | None = None,
    nonce: str | None = None,
    workers: Workers = 1,
    release: ReleaseFolder = DATA,
    config: ConfigFile = CONFIG,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run an embodied agent on released episodes, outside the workflow.

    Args:
        agent: MODULE:FUNCTION, the factory of an agent (docs/agents.md), which runs in its own process
        arm: an embodied arm of config.yaml; `ovman agents` lists them
        server: the address that the agent's server printed: ws://host:port/?token=...
        in_process: trust the agent: run it in this process, which has the truth
        isolation: isolation of the agent's process; auto takes the strongest one here
        readable: files and folders that an isolated agent may read, such as weights
        failures: effect of a failing agent
        track: words: the agent gets a sentence and its noun phrase; default: also category and relation, as in the paper
        split: a split of config.yaml; `ovman splits` lists them
        episodes: a file of episodes, or the folder of a draw, instead
        out: folder of runs.jsonl, summary.md, summary.json and manifest.json
        name: name of the agent in its records; default: its module's last name
        needs: inputs of an agent: tours (the default), more, or none
        scenes: episodes of these scenes alone
        seeds: added to those of the folder; default: evaluation.seeds
        cache: folder of recorded tours; default: the user's cache
        nonce: nonce of an evaluation to repeat, or empty for none; default: a random one
    """
    options = Namespace(**locals())
    from ovman.entry import command, summary

    if agent is None and arm is None and server is None:
        console.print_error("eval", "name the agent: --agent MODULE:FUNCTION, --arm NAME or --server URL")
        return 2
    with console.report_progress(quiet, as_json) as say:
        found = command.run_eval(options, say)
    console.print_text(summary.as_json(found) if as_json else f"\n{summary.as_text(found, markdown=False)}")
    return 0


@app.command
def serve(
    *,
    agent: Annotated[str | None, Parameter(group=AGENT)] = None,
    arm: Annotated[str | None, Parameter(group=AGENT)] = None,
    needs: Annotated[list[str] | None, Many] = None,
    name: str | None = None,
    host: str = "127.0.0.1",
    port: int = 8765,
    config: ConfigFile = CONFIG,
    path: Path = Path(),
    listener: Annotated[int | None, Parameter(show=False)] = None,
    ready: Annotated[int | None, Parameter(show=False)] = None,
) -> int:
    """Serve an agent for `ovman eval --server`.

    Args:
        agent: MODULE:FUNCTION, the factory of an agent (docs/agents.md)
        arm: an embodied arm of config.yaml
        needs: inputs of an agent: tours (the default), more, or none
        name: name of the agent; default: its module's last name, or the arm's
        host: address to listen on; 0.0.0.0 for other machines
        port: 0 takes a free one
        path: folder of the agent's module
        listener: file descriptor of a socket to listen on
        ready: file descriptor that is written to when it listens
    """
    options = Namespace(**locals())
    from ovman.entry.serve import serve_agent

    serve_agent(options)
    return 0


@app.command
def verify(
    directory: Path,
    /,
    *,
    episodes: Path | None = None,
    workers: Workers = 1,
    release: ReleaseFolder = DATA,
    config: ConfigFile = CONFIG,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Replay the recorded actions of an evaluation and judge them again, or draw a draw again and compare the files.

    Args:
        directory: output of `ovman eval` or of `ovman draw`
        episodes: the file of episodes, or the folder of their draw, if they are not a released split
    """
    options = Namespace(**locals())
    from ovman.draws.folder import holds_draw
    from ovman.entry import command
    from ovman.entry.verification import as_lines

    if holds_draw(directory):
        return _verify_draw(options)
    with console.report_progress(quiet, as_json) as say:
        found = command.run_verify(options, say)
    if as_json:
        told = {"agrees": found.agrees, "runs": len(found.runs), "differing": found.differing}
        console.print_json({**told, "differences": list(found.differences), "deviations": found.deviations})
    else:
        console.print_text("\n".join(as_lines(found)) + "\n")
    return 0 if found.agrees else 1


def _verify_draw(options: Namespace) -> int:
    from ovman.draws import making
    from ovman.settings.config import load

    with console.report_progress(options.quiet, options.as_json, has_stages=True) as say:
        differing = making.redraw(options.directory, load(options.config), say, options.workers)
    if options.as_json:
        console.print_json({"agrees": not differing, "differences": differing})
    else:
        console.print_text("\n".join(differing or [f"{options.directory}: the seed gives the same files here"]) + "\n")
    return 1 if differing else 0


@app.command
def draw(
    *,
    seed: Annotated[str | None, Parameter(group=SEED)] = None,
    beacon: Annotated[Path | None, Parameter(group=SEED)] = None,
    reveal: Annotated[Path | None, Parameter(group=SEED)] = None,
    split: str | None = None,
    homes: int | None = None,
    out: Path,
    workers: Workers = 1,
    config: ConfigFile = CONFIG,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Draw fresh homes and certified episodes of a split from a seed.

    Args:
        seed: any text; other seeds give other homes
        beacon: the seed is a value of drand: a file with its answer for a round, as JSON
        reveal: the seed was committed: secret.json of `ovman commit`
        split: a split of config.yaml that has homes; a commitment names it already
        homes: number of homes; a commitment names it already
        out: a new folder for episodes, scenes and manifest
    """
    from ovman.draws import making, origin
    from ovman.settings.config import load

    if reveal is not None:
        if split is not None or homes is not None:
            console.print_error("draw", "--reveal names split and homes; leave out --split and --homes")
            return 2
        commitment = origin.read_secret(reveal)
        split, homes, seed = commitment.split, commitment.homes, commitment.seed
    elif split is None or homes is None:
        console.print_error("draw", "say what to draw, with --split NAME and --homes N")
        return 2
    else:
        commitment = None
    lit = None if beacon is None else origin.read_beacon(beacon)
    own = lit.seed if lit is not None else str(seed)
    with console.report_progress(quiet, as_json, has_stages=True) as say:
        made = making.make(load(config), split, own, homes, out, say, workers, commitment, lit)
    if as_json:
        console.print_json({"name": made.name, "directory": str(out), "manifest": made.to_json()})
    return 0


@app.command
def commit(
    entry: Path | None = None,
    /,
    *,
    files: Annotated[tuple[Path, ...], Many] = (),
    split: str | None = None,
    homes: int | None = None,
    closes: str | None = None,
    seed: str | None = None,
    out: Path | None = None,
    config: ConfigFile = CONFIG,
) -> int:
    """Commit to what is told later: the code of an entry, or the seed of a draw.

    Args:
        entry: folder of an entry of the leaderboard
        files: files of the entry's agent, such as weights
        split: of a draw: a split of config.yaml that has homes
        homes: of a draw: number of homes
        closes: of a draw: entries may be committed until this time, such as 2026-12-24T12:00:00Z
        seed: of a draw; default: a random one
        out: of a draw: a new folder for commitment.json and secret.json
    """
    terms = {"--split": split, "--homes": homes, "--closes": closes, "--out": out}
    if entry is not None:
        from ovman.leaderboard import commitment

        if given := [name for name, value in {**terms, "--seed": seed}.items() if value is not None]:
            console.print_error("commit", f"{given[0]} is of a draw; leave it out, or leave out ENTRY")
            return 2
        print(commitment.commit_entry(entry, files), flush=True)
        return 0
    if split is None or homes is None or closes is None or out is None:
        missing = ", ".join(name for name, value in terms.items() if value is None)
        console.print_error("commit", f"name the folder of an entry, or give {missing} of a draw")
        return 2
    from ovman.draws import making, origin
    from ovman.settings.config import load

    making.settings_of_draw(load(config), split, "", homes)  # refuses what cannot be drawn
    origin.commit(split, homes, closes, out, seed)
    print(f"{out / origin.PUBLIC}: publish it now", flush=True)
    print(f"{out / origin.SECRET}: keep it secret until {closes}", flush=True)
    return 0


@app.command
def enter(
    source: Path,
    name: str,
    /,
    *,
    split: str | None = None,
    system: str | None = None,
    authors: Annotated[tuple[str, ...], Parameter(name="--author")] = (),
    about: str | None = None,
    code: str | None = None,
    role: Literal["system", "control", "diagnostic"] = "system",
    leaderboard: Path = Path("leaderboard"),
    release: ReleaseFolder = DATA,
    config: ConfigFile = CONFIG,
) -> int:
    """Make an entry of the leaderboard from an evaluation or a file of points.

    Args:
        source: output of `ovman eval`, or a file of points
        name: name of the entry's folder: small letters, digits, - and _
        split: the split of a file of points
        system: title in the table; with --author and --about for a new entry
        authors: one of its authors; again for each
        about: a description in one line
        code: address of its code
        leaderboard: folder of the entries
    """
    options = Namespace(**locals())
    from ovman.leaderboard import command
    from ovman.settings.config import load

    directory = command.enter(options)
    print(directory, flush=True)
    splits = load(config).splits
    if directory.name in splits and not splits[directory.name].in_main_job:
        tested = [name for name, split in splits.items() if split.in_main_job]
        says = f"is a split for tuning. Its table on the leaderboard is separate from those of {', '.join(tested)}."
        console.print_note(f"{directory.name} {says}")
    console.print_note(
        f"Next: commit {directory.parent} and open a pull request on the repository of OVMAN (docs/leaderboard.md)."
        " The repository has no public address yet; CITATION.cff will name it."
    )
    return 0


@app.command
def leaderboard(
    directory: Path = Path("leaderboard"),
    /,
    *,
    draws: Annotated[tuple[Path, ...], Parameter(name="--draw")] = (),
    cache: Path | None = None,
    workers: Workers = 1,
    release: ReleaseFolder = DATA,
    config: ConfigFile = CONFIG,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Verify or judge all entries again, and write the tables of those that agree.

    Args:
        directory: folder of the entries
        draws: folder of a fresh draw, which ranks the entries; again for each
        cache: keep replays and do not repeat them; the pages then say so
    """
    options = Namespace(**locals())
    from ovman.leaderboard import command

    with console.report_progress(quiet, as_json) as say:
        page, standings, refusals = command.render_leaderboard(options, say)
    if as_json:
        console.print_json({"page": str(page), "standings": [*map(asdict, standings)], "refusals": [*map(asdict, refusals)]})
    else:
        refused = (f"refused: {one.place}: {reason}" for one in refusals for reason in one.reasons)
        console.print_text("".join(f"{line}\n" for line in map(printable, (str(page), *refused))))
    return 1 if refusals else 0


@app.command
def doctor(*, thor: bool = False, as_json: Json = False) -> int:
    """Check what works on this machine, and say what to do about what does not.

    Args:
        thor: look at Vulkan and AI2-THOR's Unity build, too
    """
    from ovman.doctor.checks import State, format_finding, run_checks

    found = []
    for one in run_checks(thor):
        found.append(one)
        if not as_json:
            console.print_text(f"{format_finding(one)}\n")
    if as_json:
        console.print_json([{**asdict(one), "state": one.state.name.lower()} for one in found])
    return 1 if any(one.state is State.ILL for one in found) else 0


@app.command
def show(
    *episodes: str,
    all_episodes: Annotated[bool, Parameter(name="--all")] = False,
    results: Path | None = None,
    output: Path | None = None,
    config: Annotated[Path | None, Parameter(help="default: config.yaml, or where there is none the release's")] = None,
    runs: Annotated[tuple[str, ...], Many] = (),
    video: Path | None = None,
    arm: str | None = None,
    seed: int | None = None,
    quiet: Quiet = False,
) -> int:
    """Write a page about an episode: both tours, the maps, every arm's answer and verdict, your own runs. Or film a run.

    Args:
        episodes: an id, or a pattern such as 'FloorPlan201/*'
        all_episodes: every released episode
        results: default: results, or where there are none the release
        output: a file for one episode, a directory for many; default: pages below the results
        runs: folders of `ovman eval`, whose runs are shown as well
        video: write no page but a film of one run, an animated WebP: what the agent sees next to the plan with its path
        arm: of the film, an agent that navigates; default: the first that has a run of the episode
        seed: of the film; default: the first
    """
    options = Namespace(all=all_episodes, **locals())
    from ovman.playback import show, write_film

    if video is not None:
        print(write_film(options), flush=True)
        return 0
    if arm is not None or seed is not None:
        raise ValueError("--arm and --seed choose the run of a film; add --video FILE.webp, or leave them out")
    for path in show(options, console.ignore if quiet else console.print_note):
        print(path, flush=True)
    return 0


@app.command
def gallery(
    *,
    split: str = "everyday",
    out: Path = Path("pages"),
    results: Path | None = None,
    config: Annotated[Path | None, Parameter(help="default: config.yaml, or where there is none the release's")] = None,
    runs: Annotated[tuple[str, ...], Many] = (),
) -> int:
    """Write one page with all world pairs of a split: plans, queries, who found the answers, and filters.

    Args:
        split: whose world pairs; those of a draw with --results DRAW
        out: folder of index.html; pages of episodes that `ovman show --output` wrote there are linked
        results: default: results, or where there are none the release
        runs: folders of `ovman eval`, whose verdicts are shown as well
    """
    from ovman.playback import write_gallery

    print(write_gallery(Namespace(**locals())), flush=True)
    return 0


@app.command
def dataset(
    *,
    out: Path,
    split: Annotated[list[str] | None, Many] = None,
    without_tours: bool = False,
    visits: Path | None = None,
    cache: Path | None = None,
    release: ReleaseFolder = DATA,
    config: ConfigFile = CONFIG,
    quiet: Quiet = False,
) -> int:
    """Write the release as a data set in Parquet, with its tours, card and Croissant.

    Args:
        out: the folder of the data set
        split: splits of config.yaml; default: all that the release has
        without_tours: records alone, and no simulator is started
        visits: recorded tours of the workflow, results/visits; others are recorded
        cache: where tours are recorded; default: the user's cache
    """
    options = Namespace(**locals())
    from ovman.dataset import making

    with console.report_progress(quiet) as say:
        making.run(options, say)
    return 0


@app.command
def homes(
    *,
    seed: int = 0,
    count: int = 1,
    rooms: str = "1",
    assets: Literal["train", "val", "test"] = "train",
    out: Path,
    without_pictures: bool = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Draw homes from a seed, with a table of what is in them and a sheet of pictures.

    Args:
        seed: other seeds give other homes
        count: number of homes
        rooms: numbers of rooms in turn, such as 1,2
        assets: whose furniture
        out: folder of the homes, index.csv and homes.png
        without_pictures: write no homes.png
    """
    from ovman.homes import command

    with console.report_progress(quiet, as_json) as say:
        drawn = command.run(seed, count, rooms, assets, out, not without_pictures, say)
    if as_json:
        console.print_json([command.describe(home, assets) for home in drawn])
    return 0
