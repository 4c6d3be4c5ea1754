"""`ovman draw`: fresh homes from a seed, and the certified episodes of a split in them, by the stages of the workflow."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable
from importlib.metadata import version
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory

from ovman import __version__
from ovman.atomic import remove, replacing
from ovman.cache import Cache, digest
from ovman.draws import DrawError
from ovman.draws.folder import MANIFEST, read_draw
from ovman.draws.origin import check_beacon, check_commitment
from ovman.generation import candidates, certification, release, scenes, trials, verdict
from ovman.processes import WorkerDied
from ovman.provenance import ENGINE, digest_code
from ovman.records.draw import EPISODES, REJECTIONS, SCENES, SIGHTINGS, Beacon, Draw, SeedCommitment
from ovman.records.episode import Episode
from ovman.records.scene import Scene
from ovman.settings import Settings
from ovman.settings.splits import Homes

SECTIONS = frozenset(
    {"benchmark", "camera", "tour", "primitives", "mover", "candidates", "sensors", "measurement", "admissibility", "success"}
)
"""Sections of the settings that a draw reads, with the entry of its split."""
EVERY = 1_000_000
"""More episodes than a draw can certify: it releases all, of each relation that its split releases."""
ROOT_BITS, HOME_BITS = 62, 128
"""Of the root of random numbers, which tables keep in 64 bits, and of the number in the names of homes."""
Say = Callable[[str], None]


def settings_of_draw(settings: Settings, split: str, seed: str, homes: int) -> Settings:
    """Return the settings that a draw reads: those of its split with fresh homes, other random numbers, and no limit of episodes.

    seed: any text. DrawError for a split that does not exist or has no homes.
    """
    drawn = [name for name, entry in settings.splits.items() if entry.homes is not None]
    if split not in drawn:
        why = "has floor plans, which everybody knows" if split in settings.splits else "is not a split"
        remedy = f"write one with homes: {', '.join(drawn)}" if drawn else "give a split homes in place of scenes (docs/homes.md)"
        raise DrawError(f"--split: {split} {why}; {remedy}")
    if homes < 1:
        raise DrawError(f"--homes: {homes} homes; write at least 1")
    own = f"splits.{split}."
    constants = {
        name: EVERY if name.startswith(f"{own}episodes.") and value else value
        for name, value in settings.constants().items()
        if name.partition(".")[0] in SECTIONS or name.startswith(own)
    }
    number = int.from_bytes(hashlib.sha256(f"ovman draw {seed}".encode()).digest(), "big")
    return settings.partial(
        constants
        | {
            "benchmark.seed": number % 2**ROOT_BITS,
            "benchmark.allow_short_split": True,
            f"{own}homes.seed": number >> (256 - HOME_BITS),
            f"{own}homes.count": homes,
        },
        "a draw",
    )


def make(
    settings: Settings,
    split: str,
    seed: str,
    homes: int,
    out: Path,
    say: Say,
    workers: int = 1,
    commitment: SeedCommitment | None = None,
    beacon: Beacon | None = None,
) -> Draw:
    """Draw homes and episodes and write them to the new folder `out`.

    A draw that was interrupted goes on: finished work is kept in a hidden folder next to `out`, which the end removes.

    Args:
        settings: All settings.
        split: A split with homes.
        seed: Any text.
        homes: Number of homes.
        out: The folder; it does not exist or is empty.
        say: Told of each stage. The stages print their own progress.
        workers: Processes, one home each.
        commitment: The revealed commitment to the seed, if there is one.
        beacon: The beacon's round that gave the seed, if one did.

    Raises:
        DrawError: In one line: a wrong split, a folder that holds files, no certified episode, or a worker that was killed.
        SimulatorError: Finished work is kept.
    """
    own = settings_of_draw(settings, split, seed, homes)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise DrawError(f"--out: {out} holds something already; name a new folder")
    terms = own.splits[split].homes
    assert terms is not None
    code, work = digest_code(__name__, ENGINE), out.with_name(f".{out.name}.work")
    try:
        files = _make_files(own, split, terms, work, Cache(work / "items" / code), say, workers)
    except WorkerDied:
        raise DrawError("a worker process was killed; finished work is kept, and the same command goes on") from None
    episodes = Episode.load(files[EPISODES])
    if not episodes:
        raise DrawError(f"none of the {homes} homes has a certified episode; raise --homes")
    draw = Draw(
        split=split,
        seed=seed,
        homes=homes,
        commitment=commitment,
        beacon=beacon,
        scenes=tuple(scene.scene for scene in Scene.read(files[SCENES])),
        n=len(episodes),
        files={name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items()},
        settings=digest(own.constants()),
        code=code,
        ovman=__version__,
        engine=version("ovman-engine"),
    )
    with replacing(out) as partial:
        partial.mkdir()
        for name, path in files.items():
            (partial / name).write_bytes(path.read_bytes())
        (partial / MANIFEST).write_text(draw.to_line(), encoding="utf-8")
    remove(work)
    of = Counter(episode.relation.value for episode in episodes)
    counts = ", ".join(f"{relation} {n}" for relation, n in of.items())
    say(f"{out}: draw {draw.name}, {draw.n} episodes in {homes} homes ({counts})")
    return draw


def _make_files(
    settings: Settings, split: str, homes: Homes, work: Path, cache: Cache, say: Say, workers: int
) -> dict[str, Path]:
    """Run the stages of the workflow in a folder; return the files of the draw by name."""
    work.mkdir(parents=True, exist_ok=True)
    drawn, tried, admissible, certified = (work / f"{name}.jsonl" for name in ("candidates", "trials", "admissible", "certified"))
    made = {name: work / name for name in (EPISODES, SCENES, SIGHTINGS, REJECTIONS)}
    say(f"homes: {homes.count}")
    names = scenes.draw_homes(homes, workers)
    say("scenes: what is in the homes")
    scenes.run(names, settings, made[SCENES], cache, workers)
    say("candidates: what may change")
    candidates.run(split, made[SCENES], settings, drawn, workers)
    say("trials: every change is made and toured")
    trials.run(made[SCENES], drawn, settings, tried, cache, workers)
    verdict.run(tried, settings, admissible)
    say("certification: the oracle runs every query four times")
    certification.run(admissible, tried, settings, certified, cache, workers)
    release.run(tried, admissible, certified, settings, made[EPISODES], made[SIGHTINGS], made[REJECTIONS], split)
    return made


def check_seed(directory: Path, draw: Draw, settings: Settings) -> None:
    """Raise DrawError if the seed is not what the commitment or the beacon of a draw gives, or the homes are not the seed's.

    Quick: no home is drawn. Only `redraw` shows that the episodes are the seed's.
    """
    place = str(directory / MANIFEST)
    if draw.beacon is not None:
        check_beacon(draw.beacon, f"{place}: beacon")
        if draw.seed != draw.beacon.seed:
            raise DrawError(f"{place}: seed: is not that of the beacon; draw again with --beacon")
    if draw.commitment is not None:
        check_commitment(draw.commitment, f"{place}: commitment")
        if (draw.seed, draw.split, draw.homes) != (draw.commitment.seed, draw.commitment.split, draw.commitment.homes):
            raise DrawError(f"{place}: seed, split or homes are not those that were committed; draw again with --reveal")
    own = settings_of_draw(settings, draw.split, draw.seed, draw.homes)
    if draw.settings != digest(own.constants()):
        raise DrawError(f"{place}: settings: others than those here; name those of the draw with --config")
    terms = own.splits[draw.split].homes
    assert terms is not None
    pairs = zip_longest(draw.scenes, terms.stems, fillvalue="")
    if not all(scene.startswith((f"{stem}-", f"{stem}.")) for scene, stem in pairs):
        raise DrawError(f"{place}: scenes: are not homes of the seed; draw again")
    for episode in Episode.load(directory / EPISODES):
        if episode.scene not in draw.scenes or episode.provenance.seed != own.benchmark.seed:
            raise DrawError(f"{directory / EPISODES}: {episode.id} does not follow from the seed; draw again")


def redraw(directory: Path, settings: Settings, say: Say, workers: int = 1) -> list[str]:
    """Draw again what the manifest in a folder says, and return one line for each file that differs. Errors as for `make`."""
    draw = read_draw(directory)
    check_seed(directory, draw, settings)
    with TemporaryDirectory() as folder:
        made = make(settings, draw.split, draw.seed, draw.homes, Path(folder) / "again", say, workers)
    differing = sorted(name for name in {**draw.files, **made.files} if draw.files.get(name) != made.files.get(name))
    return [f"{directory / name}: differs from what the seed gives here" for name in differing]
