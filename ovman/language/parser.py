"""The parser: from a sentence to its noun phrase and change relation, or to the reason of a failure. It has no defaults.

The structure of a sentence says whether it asks for the thing or for its place: "the chair that is not where it was" is a thing,
"where the chair was" a place. The cues say which thing or which place (`ovman.language.cues`).
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache

from ovman.language import other_number
from ovman.language.cues import Cue, Tag, find_cues
from ovman.language.vocabulary import all_nouns


class ParseFailure(StrEnum):
    """Why a sentence names no query; records hold the value."""

    NO_WORDS = "no_words"
    NO_NOUN = "no_noun"  # nothing is named
    UNKNOWN_NOUN = "unknown_noun"  # something is named that is not in the vocabulary
    AMBIGUOUS_NOUN = "ambiguous_noun"  # several things are named and none is the one that is asked for
    NO_RELATION = "no_relation"  # nothing says how the thing changed
    AMBIGUOUS_RELATION = "ambiguous_relation"  # the sentence fits several relations, or contradicts itself


@dataclass(frozen=True, slots=True)
class Parsed:
    """noun_phrase: as the vocabulary has it ("TV stand" for "the tv-stand"); relation: a change relation by its name."""

    noun_phrase: str
    relation: str


def parse(sentence: str) -> Parsed | ParseFailure:
    """Parse a sentence. Articles, case, punctuation and politeness do not matter; any noun of the vocabulary will do."""
    said = split_words(sentence)
    if not said:
        return ParseFailure.NO_WORDS
    found = _find_referents(said, find_mentions(said))
    if not found:
        return ParseFailure.UNKNOWN_NOUN if _names_something(said) else ParseFailure.NO_NOUN
    if len({mention.noun for mention in found}) > 1:
        return ParseFailure.AMBIGUOUS_NOUN
    masked = _mask(said, found)
    read = find_cues(masked)
    if _is_part_of_another_noun(masked, read):
        return ParseFailure.UNKNOWN_NOUN
    relation = _relation(masked, read)
    return relation if isinstance(relation, ParseFailure) else Parsed(found[0].noun, relation)


def read_relation(sentence: str, noun_phrase: str) -> str | ParseFailure:
    """Return the change relation of a sentence about a noun phrase, which may be any words."""
    said, phrase = split_words(sentence), split_words(noun_phrase)
    starts = [k for k in range(len(said)) if phrase and said[k : k + len(phrase)] == phrase]
    masked = _mask(said, [Mention(noun_phrase, k, k + len(phrase)) for k in starts])
    return _relation(masked, find_cues(masked))


# Words and nouns --------------------------------------------------------------------------------------------------------------

_NOT = re.compile(r"\b(is|are|was|were|has|have|had|do|does|did|would|could|should)(?:n't|nt)\b")
_CONTRACTED = ((re.compile(r"\bwon'?t\b"), "will not"), (re.compile(r"\b(?:can't|cannot|cant)\b"), "can not")) + (
    (_NOT, r"\1 not"),
    (re.compile(r"\bain't\b"), "is not"),
    (
        re.compile(r"'(ve|re|ll|m|d)\b"),
        lambda found: {"ve": " have", "re": " are", "ll": " will", "m": " am", "d": " would"}[found[1]],
    ),
    (re.compile(r"\b(it|there|that|where|what|who|he|she|here|let)'s\b"), r"\1 is"),
    # After a noun "'s" is "is", "has" or a possessive; the words that follow tell which.
    (re.compile(r"'s\b"), " 's"),
    (re.compile(r"s'(?=\s|$)"), "s 's"),
)


def split_words(sentence: str) -> tuple[str, ...]:
    """Return the words of a sentence. "The T.V. isn't Tom's!" -> ("the", "tv", "is", "not", "tom", "'s")."""
    text = unicodedata.normalize("NFKC", sentence).casefold()
    text = re.sub("[\u2018\u2019\u02bc`\u00b4]", "'", text)
    text = re.sub(r"\b(?:[a-z]\.){2,}", lambda found: found[0].replace(".", ""), text)
    for pattern, plain in _CONTRACTED:
        text = pattern.sub(plain, text)
    return tuple(re.findall(r"'s(?!\w)|\w+", text))


@dataclass(frozen=True, slots=True)
class Mention:
    """A noun of the vocabulary in a sentence: its words are those from start up to end."""

    noun: str
    start: int
    end: int


def find_mentions(said: Sequence[str]) -> tuple[Mention, ...]:
    """Find the nouns in the words of a sentence from left to right, the longest one if one is part of another.

    Words may be joined or split ("houseplant", "arm chair") and the noun may be in the other number.
    """
    lexicon, longest = _lexicon()
    mentions, start = [], 0
    while start < len(said):
        ends = range(min(start + longest, len(said)), start, -1)
        spellings = ((joint.join(said[start:end]), end) for end in ends for joint in (" ", ""))
        found = next((Mention(lexicon[spelling], start, end) for spelling, end in spellings if spelling in lexicon), None)
        if found:
            mentions.append(found)
        start = found.end if found else start + 1
    return tuple(mentions)


@cache
def _lexicon() -> tuple[Mapping[str, str], int]:
    """Return the nouns by spelling, with and without spaces, and the greatest number of words that a noun is split into."""
    nouns = all_nouns()
    spelled: dict[str, str] = {}
    # The vocabulary's own spellings ("washbasin" and "wash basin" are two of its nouns) take precedence over derived ones.
    for joint in (" ", ""):
        for said in (lambda noun: noun, other_number):
            for noun in nouns:
                spelled.setdefault(joint.join(split_words(said(noun))), noun)
    # "footstool" may be said "foot stool", one word more than in the vocabulary.
    return spelled, 1 + max(len(split_words(noun)) for noun in nouns)


# Referents and relations ------------------------------------------------------------------------------------------------------


def _set(text: str) -> frozenset[str]:
    return frozenset(text.split())


_THING = "X"
_DETERMINERS = _set("the a an this that these those my our your his her its their which what some any one another other each 's")
_MODIFIERS = _set(
    """red green blue yellow orange purple pink brown black white grey gray beige golden silver dark light bright colourful
    colorful wooden metal plastic glass leather ceramic wicker fabric stone steel marble cardboard paper cloth velvet
    cotton big large small little tiny huge tall short long low round square rectangular wide narrow thin thick heavy
    nice lovely beautiful ugly dirty clean cute favourite favorite dear poor certain particular single only same very
    specific lone second third two three few of other one ones exact whole respective aforementioned said"""
)
_LANDMARK = _set("on in at by near beside behind under below above inside next against from off over onto opposite across along")
_RELATIVE = _set("that which who whose is are was were has have 's")
_KNOWN = _set(
    """i me you we us they them he she it who whom robot please hey hi hello ok okay could can would will shall should may
    might must do does did go going to and or but so then there here where what when how if now just for of with by at
    on in into from over back up down out off near be is are was were been being am has have had not no like want need
    help let lets try kindly thanks thank before after any more thing things ones object objects item items something
    somewhere anything upstairs downstairs nearby yesterday today tonight"""
)
_IMPERATIVES = _set(
    """go head drive navigate walk move roll travel come get return run take bring lead guide show point find locate look
    search seek reach approach visit follow catch track see check tell make direct carry fetch hunt stop wheel pursue
    chase"""
)
_OPENING = _set("please to you and then robot can could now kindly me i us lets let just")
_STRONG = frozenset({Tag.MOVED, Tag.MOVING, Tag.STAYED, Tag.NEW, Tag.TAKEN})
_OF_THE_THING = {Tag.MOVED: "moved", Tag.MOVING: "moving", Tag.STAYED: "stable", Tag.NEW: "appeared", Tag.TAKEN: "removed"}


def _find_referents(said: Sequence[str], found: Sequence[Mention]) -> tuple[Mention, ...]:
    """Return the mentions of the thing, without landmarks ("the vase on the table").

    Mentions without a determiner count only if none has one ("to be safe, go to the chair").
    """
    with_article = tuple(mention for mention in found if _determiner(said, mention.start) is not None) or tuple(found)
    landmarks = {mention for mention in with_article[1:] if _is_landmark(said, mention.start)}
    return tuple(mention for mention in with_article if mention not in landmarks)


def _determiner(said: Sequence[str], start: int) -> int | None:
    """Return the place of the determiner of the noun that begins at `start`, with at most four words between them."""
    return next((k for k in range(start - 1, max(start - 6, -1), -1) if said[k] in _DETERMINERS), None)


def _is_landmark(said: Sequence[str], start: int) -> bool:
    at = start - 1
    while at >= 0 and (said[at] in _DETERMINERS or said[at] in _MODIFIERS):
        at -= 1
    return at >= 0 and (said[at] in _LANDMARK or tuple(said[max(at - 1, 0) : at + 1]) in {("next", "to"), ("close", "to")})


def _names_something(said: Sequence[str]) -> bool:
    """Say whether a determiner is followed by a word that is neither of the grammar nor of a cue."""
    cue = _covered(find_cues(said))
    beginnings = (k for k in range(1, len(said)) if said[k - 1] in _DETERMINERS - {"that", "which"})
    return any(k not in cue and said[k] not in _KNOWN | _MODIFIERS for k in beginnings)


def _covered(read: Sequence[Cue]) -> set[int]:
    return {k for cue in read for k in range(cue.start, cue.end)}


def _mask(said: Sequence[str], found: Collection[Mention]) -> tuple[str, ...]:
    """Return the words with X for each of the mentions."""
    by_start = {mention.start: mention for mention in found}
    masked, at = [], 0
    while at < len(said):
        masked.append(_THING if at in by_start else said[at])
        at = by_start[at].end if at in by_start else at + 1
    return tuple(masked)


def _is_part_of_another_noun(masked: Sequence[str], read: Sequence[Cue]) -> bool:
    """Say whether X is one word of a compound that is not in the vocabulary: "the pool X", "the X leg that ..."."""
    cue = _covered(read)

    def strange(k: int) -> bool:
        word = masked[k]
        return k not in cue and word not in _KNOWN | _MODIFIERS | _DETERMINERS and word != _THING and not word.endswith("ly")

    for at in (k for k, word in enumerate(masked) if word == _THING):
        determiner = _determiner(masked, at)
        between = range(at if determiner is None else determiner + 1, at)
        if between and all(strange(k) or masked[k] in _MODIFIERS for k in between) and any(map(strange, between)):
            return True
        if at + 2 < len(masked) and strange(at + 1) and masked[at + 2] in _RELATIVE and masked[at + 1] not in _IMPERATIVES:
            return True
    return False


def _relation(masked: Sequence[str], read: Sequence[Cue]) -> str | ParseFailure:
    tags = frozenset[Tag]().union(*(cue.tags for cue in read))
    strong = tags & _STRONG
    goal = _goal(masked, read)
    if strong - {Tag.MOVED, Tag.TAKEN} and len(strong) > 1:
        return ParseFailure.AMBIGUOUS_RELATION
    if goal is not None:
        return _relation_of_place(tags, strong, goal)
    if len(strong) > 1:
        return ParseFailure.AMBIGUOUS_RELATION
    if strong:
        return _OF_THE_THING[next(iter(strong))]
    # "The chair that used to be here" is no longer in the home, or the sentence would not say so.
    return "removed" if Tag.WAS_HERE in tags else ParseFailure.NO_RELATION


def _relation_of_place(tags: frozenset[Tag], strong: frozenset[Tag], goal: Tag) -> str | ParseFailure:
    """Return the relation of a sentence that asks for a place: WHERE ("where the chair ...") or PLACE ("the spot of ...")."""
    past = not tags.isdisjoint({Tag.PAST, Tag.FROM, Tag.WAS_HERE})
    # A thing that was taken away is in no other place, so "moved" next to "taken" is the same event.
    if Tag.TAKEN in strong:
        return "removed"
    if strong - {Tag.MOVED}:
        # No relation asks for the former place of a thing that is new or has not moved.
        return ParseFailure.AMBIGUOUS_RELATION if past else _OF_THE_THING[next(iter(strong))]
    if past:
        return "former"
    if goal is Tag.WHERE:
        return "moved" if Tag.MOVED in strong or Tag.NOW in tags else ParseFailure.NO_RELATION
    if Tag.MOVED in strong and Tag.TO not in tags:
        # "The place of the chair that was moved" may be either end of its path.
        return ParseFailure.AMBIGUOUS_RELATION
    return "moved" if strong or Tag.NOW in tags else ParseFailure.NO_RELATION


def _goal(masked: Sequence[str], read: Sequence[Cue]) -> Tag | None:
    """Return WHERE or PLACE if the sentence asks for a place, None if for the thing.

    The goal is the first phrase after the last imperative that has an object of its own ("... was moved; go to where it was"),
    or the first phrase of the sentence.
    """
    inside = _covered(read)
    heads: list[tuple[int, Tag | None]] = [
        (cue.start, tag) for cue in read for tag in (Tag.WHERE, Tag.PLACE) if tag in cue.tags and _leads(masked, cue, tag)
    ]
    heads += [
        (k, None) for k, word in enumerate(masked) if word == _THING and k not in inside and not _owns_place(masked, k, read)
    ]
    heads.sort(key=lambda head: head[0])
    if not heads:
        return None
    goal = heads[0][1]
    # "Move" is an imperative only where a sentence may begin, not in "someone's move".
    orders = [
        k
        for k, word in enumerate(masked)
        if word in _IMPERATIVES and k not in inside and (word != "move" or k == 0 or masked[k - 1] in _OPENING)
    ]
    for order in orders:
        following = next((head for head in heads if head[0] > order), None)
        if following and following[0] - order <= 8 and not any(order < other < following[0] for other in orders):
            goal = following[1]
    return goal


def _leads(masked: Sequence[str], cue: Cue, tag: Tag) -> bool:
    """Say whether the sentence asks for the place of a phrase: "where is the chair" asks for the chair instead."""
    after = masked[cue.end : cue.end + 2]
    # A question about the past asks for the place: "where was the chair".
    return tag is Tag.PLACE or (after[:1] not in (("is",), ("are",), ("'s",)) and after != ("can", "i"))


def _owns_place(masked: Sequence[str], k: int, read: Sequence[Cue]) -> bool:
    """Say whether X at `k` only says whose place it is: "the chair's old spot"."""
    return masked[k + 1 : k + 2] == ("'s",) and any(k + 1 < cue.start <= k + 4 and Tag.PLACE in cue.tags for cue in read)
