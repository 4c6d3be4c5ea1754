"""Make ovman/language/phrases.yaml: noun phrases for the categories of queries that nobody of this project made up.

    git clone https://github.com/askforalfred/alfred FOLDER/alfred
    python -m training.phrases FOLDER [--measure]

`wordnet`: the words of the senses of SENSES. FOLDER/data.noun is WordNet's file of nouns; if it is missing, training/public.py
downloads it. `people`: what annotators of ALFRED call the object or the receptacle of a step whose plan names its class. Neither
list has a noun of the vocabulary or a caption of the encoder, whatever its spaces, hyphens and capitals.

--measure writes nothing. It prints how often the noun that is nearest to a phrase, and the category of the nearest caption, is
right by text alone.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from ovman.homes import catalogue
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS, all_nouns, nouns
from ovman.perception.networks import encoder_of
from ovman.records.episode import Episode
from ovman.settings.config import load
from ovman.shipped import EMBEDDED, HOME
from training.captions import ARTEFACT, COLOURS, PLANT, Captions, Senses, make_captions
from training.public import SOURCES, read_public

PHRASES = HOME / "ovman" / "language" / "phrases.yaml"
Phrases = dict[str, dict[str, list[str]]]
"""Phrases by category and source."""
MOST = 8
"""Phrases per category and source."""
ANNOTATORS, SHARE = 3, 2 / 3
"""Least number of annotators who use a phrase for a category, and least share of the category in all uses of the phrase."""

SENSES: Mapping[str, tuple[str, ...]] = {
    "ArmChair": ("armchair", "easy chair", "recliner", "fauteuil", "wing chair"),
    "BaseballBat": ("baseball bat", "club: stout stick"),  # not a playing card, not a house of members
    "Bed": ("bed: a piece of furniture", "platform bed", "single bed", "twin bed"),  # not of flowers, not of a road
    "Book": ("book: physical objects", "paperback", "hardcover", "pocket edition"),  # not of tickets
    "Box": (
        "box: a (usually rectangular) container",
        "carton",
        "crate: a rugged box",
        "package",
    ),  # not in a theatre, not a shrub
    "Chair": ("chair: a seat for one", "straight chair"),  # not in an orchestra, not for executions
    "CoffeeMachine": ("coffee maker", "espresso maker"),
    "CoffeeTable": ("coffee table",),
    "Desk": ("desk", "writing table"),
    "DeskLamp": ("table lamp", "reading lamp", "student lamp"),
    "DiningTable": ("dining table", "dining-room table", "refectory table", "kitchen table", "breakfast table"),
    "Dresser": ("chest of drawers", "chiffonier", "highboy", "lowboy"),  # "dresser" is a dressing table, too
    "FloorLamp": ("floor lamp",),
    "Footstool": ("footstool", "pouf"),
    "GarbageCan": ("trash can", "waste basket", "litterbin", "recycling bin"),
    "HousePlant": ("houseplant", "pot plant", "planter"),  # "plant" is a factory, too
    "Ladle": ("ladle", "dipper", "scoop: a large ladle"),  # not of an excavator
    "Laptop": ("laptop", "notebook computer", "portable computer"),
    "Microwave": ("microwave oven",),
    "Pan": ("cooking pan", "frying pan", "omelet pan"),  # "pan" is the container below a fridge, too
    "Pillow": ("pillow", "throw pillow", "bed pillow"),
    "Pot": ("pot: metal or earthenware", "saucepan", "Dutch oven: iron", "saucepot", "stockpot", "stewpan"),  # not of a plant
    "RoomDecor": ("decoration: something", "adornment"),  # "decoration" is a medal, too
    "ShelvingUnit": ("bookcase", "bookshelf", "etagere"),  # "rack" is for dishes or for torture
    "SideTable": ("stand: a small table", "console table", "gueridon"),  # not a stall, not seats, not a pedestal
    "Sofa": ("sofa", "loveseat", "settee: a small sofa", "divan: a long backless sofa"),  # not a bench, not a council chamber
    "Statue": ("statue", "sculpture", "figurine", "figure: a model of a bodily form", "carving"),  # not a pattern
    "Stool": ("stool: a simple seat", "milking stool", "piano stool", "tabouret"),  # not a toilet, not a stump
    "TVStand": ("entertainment center",),
    "Television": ("television set",),  # "television" is the system, too
    "TennisRacket": ("tennis racket",),
    "Toaster": ("toaster",),
    "ToiletPaper": ("toilet paper",),
    "Vase": ("vase", "urn: a large vase", "amphora", "crock: an earthen jar"),  # not a pot for coffee, not soot
}
"""Senses of WordNet whose words name a category: a word and, if several of its senses are things, the beginning of the gloss.

They are senses of the vocabulary's nouns, and direct hyponyms and hypernyms of these that people could call most assets of the
category. "breakfast table", "pot plant", "etagere", "stand", "console table" and "gueridon" are named because WordNet has no such
noun for their category. Left out are hyponyms of another shape ("rocking chair", "four-poster", "wok"), of another place or use
("wheelchair", "high table", "ballot box"), those that are named by their contents ("cookie jar") or are species ("gloxinia"), and
hypernyms of two categories ("seat", "furniture")."""
THINGS = (ARTEFACT, PLANT, "27")
"""WordNet's files of the senses that are meant; 27 are substances, paper among them."""
UNFIT: Mapping[str, str] = {
    "secretary": "a person",
    "pocketbook": "a purse",
    "pocket book": "a purse",
    "taboret": "another spelling of tabouret",
    "omelette pan": "another spelling of omelet pan",
    "trash": "what is in a garbage can",
    "garbage": "what is in a garbage can",
    "dress": "a misspelt dresser",
    "desk top": "a part",
    "table top": "a part",
    "lamp shade": "a part",
    "lid": "a part",
    "tube": "a roll without paper",
    "toilet paper tube": "a roll without paper",
    "pallet": "one odd coffee table",
    "piano": "one odd side table",
    "microwave stand": "a side table by what stands on it in one home",
    "microwave cart": "a side table by what stands on it in one home",
    "dog statue": "one of many statues",
    "geometry book": "one of many books",
    "measuring spoon": "another tool than a ladle",
}
"""Phrases that are left out by hand, with the reason."""

SIZES = frozenset(["big", "large", "larger", "little", "long", "low", "short", "small", "smaller", "tall"])
"""Words that stay if they tell two categories apart: a "small lamp" cannot be a floor lamp, a "large sofa" is a sofa."""
_TOLD = """
    beige copper corner floral flower gold golden grey plaid silver striped tan cardboard glass leather metal plastic
    steel wire wood circular rectangular round square clean dirty empty full open first second third middle other same
"""
ATTRIBUTES = frozenset([*COLOURS, *_TOLD.split()])
"""Words that tell which instance is meant: colours, patterns, materials, shapes, states, places, order. They would make a query
about another instance of the category wrong."""

_STOPS = """
    above across after against ahead along and are around as at atop back before behind below beneath beside between but
    by closest directly down face facing for from has have here i if in inside into is it its just leaning left located
    near nearest next of off on onto or out over right sitting so standing straight that that's then there to toward
    towards under underneath until up upon was when where which while who with you
"""
_WORD = rf"(?!(?:{'|'.join(_STOPS.split())})\b)[a-z]+(?:['-][a-z]+)*"
_NOUNS = rf"(?:(?:the|a|an|this|that|your|one) )*(?>({_WORD}(?: {_WORD})*))(?! of\b)"
_AT = r"(?: (?:up|out|down|back))* (?:on|in|into|inside|onto|from|off|at|to|upon|atop)(?: of| to)?(?: (?:the )?top of)?"
_TAKE = re.compile(rf"(?:pick|grab|take|get|lift|collect|retrieve|remove) (?:up |out |down |back )*{_NOUNS}(?:{_AT} {_NOUNS})?")
_PUT = re.compile(rf"(?:put|place|set|drop|leave|lay|throw|toss|insert) (?:up |out |down |back )*{_NOUNS}(?:{_AT} {_NOUNS})?")
_TOGGLE = re.compile(rf"(?:turn|switch|flip|click) (?:on |off )*{_NOUNS}")
_GO = re.compile(rf"\b(?:to|towards?|face|facing|reach|approach|front of) {_NOUNS}")


@dataclass(frozen=True, slots=True)
class Uses:
    """Noun phrases that annotators of ALFRED use for things.

    by: annotators by phrase and class; times: how often they do so, by phrase. Classes are in lower case. sentences: of all
    steps, whether they were read or not; sha256: of the bytes of all files in the order of their paths.
    """

    by: Mapping[tuple[str, str], set[str]]
    times: Mapping[str, Counter[str]]
    sentences: int
    sha256: str

    @staticmethod
    def read(folder: Path) -> Uses:
        """Read all files traj_data.json below a folder. A sentence counts if the plan has as many steps as the annotation."""
        by: dict[tuple[str, str], set[str]] = defaultdict(set)
        times: dict[str, Counter[str]] = defaultdict(Counter)
        sentences, digest = 0, hashlib.sha256()
        for path in sorted(folder.rglob("traj_data.json")):
            held = path.read_bytes()
            digest.update(held)
            trajectory = json.loads(held)
            plan = [
                step for step in trajectory.get("plan", {}).get("high_pddl", ()) if step["discrete_action"]["action"] != "NoOp"
            ]
            for annotation in trajectory["turk_annotations"]["anns"]:
                said = annotation["high_descs"]
                sentences += len(said)
                for step, sentence in zip(plan, said, strict=True) if len(plan) == len(said) else ():
                    action, at = step["discrete_action"], step["planner_action"]
                    classes = [at.get(key, [None])[0] for key in ("coordinateObjectId", "coordinateReceptacleObjectId")]
                    if action["action"] == "GotoLocation":
                        classes = [*action["args"], None]
                    for of, phrase in zip(classes, find_phrases(action["action"], sentence), strict=False):
                        if of and phrase:
                            by[phrase, of.lower()].add(annotation["assignment_id"].split("_")[0])
                            times[phrase][of.lower()] += 1
        if not sentences:
            raise SystemExit(f"{folder}: no annotation; clone github.com/askforalfred/alfred there")
        return Uses(by, times, sentences, digest.hexdigest())


def find_phrases(action: str, sentence: str) -> tuple[str | None, str | None]:
    """Return what a sentence about an action calls its object and its receptacle.

    >>> find_phrases("PutObject", "Put the mug on the small stand, next to the bed.")
    ('mug', 'small stand')
    >>> find_phrases("GotoLocation", "Turn left and walk to the front of the couch.")
    ('couch', None)
    """
    # Whatever ends a phrase is a word of its own.
    text = " ".join(re.sub(r"[^a-z' -]", " . ", sentence.lower()).split()).lstrip(". ")
    if action == "GotoLocation":
        found = _GO.findall(text)
        return (found[-1], None) if found else (None, None)
    pattern = {"PickupObject": _TAKE, "PutObject": _PUT, "ToggleObject": _TOGGLE}.get(action)
    match = pattern.match(text) if pattern else None
    return (match[1], match[2] if pattern is not _TOGGLE else None) if match else (None, None)


@dataclass(frozen=True, slots=True)
class Judge:
    """Decide which phrases fit a category. senses: WordNet's; seen: keys of the captions and of the nouns of the vocabulary."""

    senses: Senses
    seen: frozenset[str]

    @staticmethod
    def make(senses: Senses) -> Judge:
        """Return the judge for the captions that these senses give, of all categories that a picture can have shown."""
        captions = make_captions(sorted({*SYNONYMS, *catalogue.categories()}), senses)
        return Judge(senses, frozenset(key(text) for text in (*captions.texts, *all_nouns())))

    def accepts(self, phrase: str, category: str) -> bool:
        """Return whether the encoder has not seen a phrase and the phrase names no other category and no single instance."""
        words = phrase.split()
        own = {word for known in nouns(category) for word in (known, known.split()[-1])}
        ends = {" ".join(words[k:]) for k in range(len(words))} - own
        others = {known for other in SYNONYMS if other != category for known in nouns(other)}
        rest = " ".join(words[1:])
        return not (
            key(phrase) in self.seen
            or phrase in UNFIT
            or ends & others
            or phrase in {known.split()[-1] for known in others}
            or ATTRIBUTES.intersection(words)
            or (words[0] in SIZES and rest not in others)
        )


def key(phrase: str) -> str:
    """Return a phrase without what spellings differ in: "night-stand" and "night stand" are one word."""
    return re.sub(r"[^a-z0-9]", "", phrase.lower())


def askable() -> list[str]:
    """Return the categories that queries can ask for: those of released episodes, and those of which homes have loose things."""
    released = {episode.category for path in (HOME / EMBEDDED / "episodes").glob("*.jsonl") for episode in Episode.load(path)}
    loose = {c for c in catalogue.categories() for split in ("val", "test") if any(a.loose for a in catalogue.assets(c, split))}
    return sorted(released | loose)


def choose_from_wordnet(category: str, judge: Judge) -> list[str]:
    """Return the words of the senses of a category that the judge accepts, in WordNet's order."""
    found: dict[str, str] = {}
    for sense in SENSES[category]:
        word, _, gloss = sense.partition(": ")
        fitting = [s for s in judge.senses.senses.get(word.lower(), ()) if s[0] in THINGS and s[2].startswith(gloss)]
        if len(fitting) != 1:
            raise SystemExit(f"SENSES of {category}: WordNet has {len(fitting)} senses for {sense!r}; name one by its gloss")
        for phrase in fitting[0][1]:
            if judge.accepts(phrase, category):
                found.setdefault(key(phrase), phrase)
    return list(found.values())


def choose_from_people(category: str, uses: Uses, judge: Judge) -> list[str]:
    """Return what annotators call a category and the judge accepts, the most usual first."""
    of = category.lower()
    found = [
        phrase
        for phrase, times in uses.times.items()
        if len(uses.by.get((phrase, of), ())) >= ANNOTATORS
        and times[of] >= SHARE * times.total()
        and all(word in judge.senses.senses for word in phrase.split())
        and judge.accepts(phrase, category)
    ]
    return sorted(found, key=lambda phrase: (-len(uses.by[phrase, of]), phrase))


def make_phrases(uses: Uses, judge: Judge) -> Phrases:
    """Return the phrases of all categories, of each source the first MOST. A phrase of two categories belongs to neither."""
    chosen = {
        category: {"people": choose_from_people(category, uses, judge), "wordnet": choose_from_wordnet(category, judge)}
        for category in askable()
    }
    owners = Counter(k for lists in chosen.values() for k in {key(phrase) for of in lists.values() for phrase in of})
    kept = {
        c: {source: [p for p in of if owners[key(p)] == 1][:MOST] for source, of in lists.items()} for c, lists in chosen.items()
    }
    return {c: {source: sorted(of) for source, of in lists.items() if of} for c, lists in kept.items()}


def write_phrases(phrases: Phrases, uses: Uses, judge: Judge) -> None:
    """Write the file with its sources, and print how many uses of ALFRED's annotators the encoder has seen."""
    counts = Counter(source for lists in phrases.values() for source, of in lists.items() for _ in of)
    wordnet = SOURCES["senses"]
    header = f"""\
# Noun phrases for the categories of queries, written by `python -m training.phrases`: do not edit. The training of the encoder
# saw none of them: none is a noun of the vocabulary or a caption, whatever its spaces, hyphens and capitals.
# wordnet: {counts["wordnet"]} words of WordNet 3.1 (copyright 2011 Princeton University, WordNet's licence). Source: package
#   {wordnet.package} {wordnet.version}, {wordnet.file}
#   SHA-256 {wordnet.sha256}
# people: {counts["people"]} phrases of annotators of ALFRED, from {uses.sentences:,} sentences (MIT, copyright 2019 ALFRED).
#   Source: github.com/askforalfred/alfred at f91f4c0c, all traj_data.json in data/json_2.1.0, joined in the order of their paths
#   SHA-256 {uses.sha256}
"""
    PHRASES.write_text(header + yaml.safe_dump(phrases, width=128, default_flow_style=None), encoding="utf-8")
    of = [category.lower() for category in phrases]
    total, seen, told = (
        sum(times[c] for phrase, times in uses.times.items() for c in of if counted(phrase))
        for counted in (bool, lambda p: key(p) in judge.seen, lambda p: not (ATTRIBUTES | SIZES).isdisjoint(p.split()))
    )
    print(f"{dict(counts)} phrases; {sum(map(bool, phrases.values()))} of {len(phrases)} categories have some")
    print(f"of {total:,} uses by annotators {seen / total:.3f} are nouns or captions, {told / total:.3f} have an attribute")


def measure(phrases: Phrases, captions: Captions) -> None:
    """Print how often text alone finds the category of a phrase: by the nearest noun, and by the nearest caption."""
    embed = encoder_of(load(HOME / "config.yaml").perception).texts
    categories = sorted(phrases)
    said = [(source, category, phrase) for category, lists in phrases.items() for source, of in lists.items() for phrase in of]
    asked = embed([phrase for *_, phrase in said])
    to_nouns = asked @ embed([noun(category) for category in categories]).T
    known = list(zip(captions.texts, captions.share, strict=True))
    to_captions = asked @ embed([text for text, _ in known]).T
    right = np.array([category for _, category, _ in said])
    by_noun = np.array(categories)[to_nouns.argmax(axis=1)] == right
    nearest = to_captions.argmax(axis=1)
    by_caption = np.array([known[k][1][categories.index(c)] > 0 for k, c in zip(nearest, right.tolist(), strict=True)])
    for source in ("wordnet", "people"):
        here = np.array([s == source for s, *_ in said])
        rates = by_noun[here].mean(), by_caption[here].mean()
        print(f"{source}: {here.sum()} phrases, nearest noun {rates[0]:.3f}, nearest caption {rates[1]:.3f}")
    margins = to_nouns[np.arange(len(said)), [categories.index(c) for c in right]] - to_nouns.max(axis=1)
    for k in margins.argsort()[:10]:
        wrong = categories[to_nouns[k].argmax()]
        print(f"  {said[k][2]} ({right[k]}, {said[k][0]}): nearest noun {noun(wrong)}, nearest caption {known[nearest[k]][0]!r}")


def read_senses(folder: Path) -> Senses:
    """Read data.noun of a folder, downloaded at the first time. Raises SystemExit for another file than the pinned one."""
    path = folder / "data.noun"
    if not path.is_file():
        path.write_bytes(read_public("senses"))
    held = path.read_bytes()
    if hashlib.sha256(held).hexdigest() != SOURCES["senses"].sha256:
        raise SystemExit(f"{path}: not WordNet's file of training/public.py; delete it, and it is downloaded again")
    return Senses.read(held.decode())


def main() -> None:
    """Write the phrases, or measure them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="has the clone alfred, and data.noun")
    parser.add_argument("--measure", action="store_true", help="measure the phrases that there are")
    options = parser.parse_args()
    senses = read_senses(options.folder)
    if options.measure:
        phrases = yaml.safe_load(PHRASES.read_text(encoding="utf-8"))
        measure(phrases, make_captions(sorted(phrases), senses))
        return
    uses = Uses.read(options.folder / "alfred")
    judge = Judge.make(senses)
    write_phrases(make_phrases(uses, judge), uses, judge)


if __name__ == "__main__":
    main()
