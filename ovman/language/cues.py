"""Cues: the phrases of a sentence that tell which change relation is meant.

Of all patterns the longest match that begins at a word counts, and its words are not read again: "not moved" is not "moved", "new
place" is not "new".

A pattern is words separated by spaces; X stands for the noun phrase. "p | q" is either pattern within the brackets around them,
"( p )"; "<name>" is the fragment of that name; "?" behind a word, a fragment or a closing bracket makes it optional, "*"
repeats it. The order of alternatives does not matter. A pattern becomes a regular expression over words that each end with a
space.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from functools import cache


class Tag(Enum):
    """Meaning of a phrase for the thing, or for the time and the place that are asked for."""

    MOVED = auto()  # it stands elsewhere in the home
    MOVING = auto()
    STAYED = auto()
    NEW = auto()  # it was not in the home before
    TAKEN = auto()  # it is no longer in the home
    WHERE = auto()  # "where ..."
    PLACE = auto()  # a noun for a place: "the spot"
    PAST = auto()
    NOW = auto()
    FROM = auto()
    TO = auto()
    WAS_HERE = auto()  # it was in the home, and nothing says that it is gone
    ASIDE = auto()  # about other things, or about what did not happen


_FRAGMENTS: Mapping[str, str] = {
    # Auxiliary verbs and adverbs.
    "is": "is | are | 's",
    "was": "was | were",
    "has": "has | have | had | 's",
    "be": "am | be | been | being | <is> | <was>",
    "aux": "<be> | has | have | had | having | do | does | did | will | would | can | could | get | gets | got | getting",
    "adv": """just | now | then | ever | even | yet | already | also | really | suddenly | somehow | meanwhile | since
        | all | once | again | currently | recently | apparently | only | simply | obviously | clearly | lately | quite
        | exactly | right | physically | actually | always | still | first | last | originally | initially | previously
        | formerly | probably | quietly | secretly | slowly | mysteriously | completely | entirely | perhaps | maybe | so
        | far | constantly | continually""",
    "mid": "( <aux> | <adv> )*",
    "not": "not | never",
    "nobody": "nobody | noone | none | no one | no person",
    # Persons and things.
    "the": "the | this | that | these | those | a | an | its | their | my | our | your | his | her",
    "person": "i | you | we | they | he | she | someone | somebody | people | anyone | anybody | everyone | everybody | who",
    "it": "<the>? ( X | one | ones | thing | things | object | item ) | it | they | them | he | she",
    # Places.
    "place": """place | places | spot | spots | location | locations | position | positions | site | point | area | corner
        | space""",
    "room": "room | rooms | wall | side | part | end | kitchen | bedroom | bathroom | house",
    "home": """<the>? whole? ( home | house | room | rooms | flat | apartment | place | kitchen | bedroom | bathroom |
            building | scene | living room )""",
    "here": """here | there | around | present | ( in | inside | at | within | anywhere in | part of | on ) <home>
        | anywhere | in here""",
    "formeradj": """old | former | previous | original | prior | earlier | past | initial | first | usual | normal
        | regular | vacated | empty | emptied | abandoned | onetime | familiar | deserted | customary""",
    "same": """( exactly | right | just )? <the>? ( very | exact )? ( same | old | original | usual | former | previous |
            initial | first | own | right | proper | normal )*""",
    "elsewhere": """( to | in | into | at | on | onto )? ( elsewhere | ( somewhere | someplace | anyplace | anywhere | some
            place ) ( else | different | new ) | ( <the> | some )? ( completely | totally )? ( different | new | another |
            other | changed | current | present ) ( <place> | <room> | home ) )""",
    # Times.
    "visit": "visit | tour | time | round | walk | trip | look | pass | day | inspection",
    "earlier": "last | first | previous | other | earlier | initial",
    "came": "was | were | came | looked | visited | checked | toured | saw | see | passed",
    "when": "( when | while )? <person> <mid> <came> ( here | there | by | it | this | around | last )*",
    "before": """before | earlier | previously | formerly | originally | beforehand | initially | at first | in the past
        | once | until recently | back then | yesterday | a while ago | last | ( on | during | at | in | from )? <the>?
            <earlier> <visit> around? <when>? | ( when | while ) <when> | before <when>""",
    "anymore": "any more | anymore | any longer | now | at all | these days | today | at the moment | at present",
    # Verbs of being somewhere.
    "stand": "be | stand | sit | lie | hang | live | rest | stay | belong | reside | go | lean | have",
    "stood": "stood | sat | lay | hung | lived | rested | belonged | resided | leaned | leant",
    "usedto": "( used | use ) to",
    "put": "standing | sitting | located | kept | situated | found | placed | put | seen | positioned | lying | stored",
    "waswhere": """<mid> <usedto> <adv>* <stand>? | <mid> <stood> | <adv>* <was> <adv>* <put>? | <mid> been <put>?
        | <person> <mid> ( left | put | saw | had | found | kept | placed | remember ) <it>?""",
    "wherewas": "where <it>? ( <waswhere> | <has> always <be>* ) <before>?",
    # Verbs of change.
    "moved": """moved | relocated | shifted | displaced | repositioned | rearranged | transferred | transported | pushed
        | dragged | slid | nudged | shoved | rolled | carried | wheeled | pulled | swapped | wandered | migrated
        | travelled | traveled""",
    "touched": "<moved> | touched | disturbed | changed | altered | affected | handled | budged | picked up | gone anywhere",
    "move": "move | change | shift | travel | budge | go anywhere",
    "moving": """moving | traveling | travelling | wandering | roaming | rolling | sliding | drifting | gliding | walking
        | running | driving | circulating | pacing | patrolling | circling | floating | shuttling | cruising | creeping
        | crawling | strolling | shifting | going ( around | about | back and forth | places | up and down | to and fro )
        | changing <the>? <place> | coming and going""",
    "moves": "moves | wanders | roams | travels | drifts | rolls | slides | glides | circulates | strolls",
    "about": """around | about | back and forth | to and fro | up and down | by itself | by themselves | on its own
        | on their own | along | ( through | around | across | about ) <home> | all the time | constantly | right now""",
    "still": "still | put | steady | fixed | unchanged | unmoved | untouched | constant | stationary | motionless",
    "stayed": """stayed | stays | remained | remains | remain | remaining | staying | kept | keeps | left | held | stuck
        | stay | standing | stood | sat""",
    "carried": """taken | took | take | carried | carry | thrown | threw | throw | cleared | clear | hauled | whisked
        | given | gave | tossed | spirited""",
    "removed": """( <carried> | moved | put ) <it>? ( out | off ) ( of <home> )? | <carried> <it>? away | removed | stolen
        | missing | disappeared | vanished | discarded | donated | sold | lost | eliminated | deleted | withdrawn | absent
        | took | taken | disappear | vanish | remove | go missing | departed | gone | tossed | trashed | confiscated
        | borrowed | disposed of | done away with | ( got | get )? rid of""",
    "added": "added | introduced | installed | delivered | bought | purchased | acquired | imported | brought",
    "appeared": """appeared | appears | arrived | arrives | emerged | materialised | materialized | came in | come in
        | joined | ( popped | showed | shown | shows | turned | cropped | sprung | sprang ) up""",
    "seen": """see | seen | saw | notice | noticed | meet | met | encountered | encounter | spotted | spot | existed
        | exist | know | known | find | found | remember | have | had | observe | observed""",
    # Other things, whose change says nothing.
    "others": """<the>? all? <the>? ( others | rest | everything else | all else | other ( X | ones | one | things | thing ) |
            another ( X | one )? | everything around it )""",
}

_PATTERNS: Mapping[tuple[Tag, ...], str] = {
    (Tag.ASIDE,): """( unlike | except | except for | besides | in contrast to ) <others>
        | ( while | whereas | when | as | although | though | but | and | after )? <others> <mid> ( <touched> | <moving> |
            <moves> | <removed> | <not> <mid> ( <touched> | <move> )? ) ( <elsewhere> | <about> | away )?
        | <mid> <not> <mid> ( <removed> | <added> | <appeared> | appear | new )""",
    (Tag.STAYED,): """<mid> <not> <mid> ( <touched> | <move> | <moving> ) ( <it> | <the>? <place> )? ( ( from | off ) (
            <wherewas> | <same> <place> ) | at all | an inch | a bit | <elsewhere> | around )*
        | <mid> <not> <mid> ( left | leave | changed | change | moved from ) <same> <place>
        | <nobody> <mid> ( <touched> ) <it>? ( at all )?
        | without <adv>* being? ( <touched> | moving )
        | <mid> <stayed> <adv>* ( <still> | in place | as it was | as they were | alone | the same | the way it was | as is |
            <wherewas> | ( in | at | on | to )? <same> <place> ( as <before> | <wherewas> | <it> <waswhere> | as it was | as
            they were )? )
        | <mid> ( stayed | remained ) ( there | here | behind )?
        | ( that | which )? ( remains | stays )
        | <is>? <adv>* still <adv>* ( <be> | stands | standing | sits | sitting | lies | rests | remains | stays )? <adv>* ( (
            in | at | on ) <same> <place> ( as <before> | <wherewas> | <it> <waswhere> )? | <wherewas> | there | here | put |
            in place | as before )
        | <mid> ( stands | standing | sits | sitting )? ( in | at | on | occupying | has | have | keeps | kept )? ( exactly |
            just | right | precisely )? ( the | that )? ( very | exact )? same <place> ( as <before> | <wherewas> | <it>
            <waswhere> )? <before>?
        | <is> <adv>* <wherewas>
        | <is> <adv>* ( in | at | on ) <the>? ( original | usual | old | former | previous | initial ) <place> still?
        | unmoved | untouched | undisturbed | unchanged | stationary | motionless | immobile | stable | static
        | <has> always <be>* ( <here> | <wherewas> | ( in | at | on ) <same> <place> | where it is | where they are )
        | ( standing | sitting | standing completely ) still | same as <before> | as <before> | ( and | but ) still ( is | are
            )""",
    (Tag.MOVING,): """<mid> <moving> <about>* <adv>*
        | <mid> ( being | getting ) <adv>* <moved> <about>*
        | ( keeps | keep | kept | continues | continue ) <adv>* on? to? ( <moving> | move | being moved ) <about>*
        | in constant? ( motion | movement | transit ) | on the ( move | go | run ) | restless | mobile
        | <moves> <about>*
        | ( that | which | who ) <adv>* ( move | wander | roam | travel | drift ) <about>*
        | ( move | wander | roam | travel ) <about> <about>*
        | ( goes | go ) ( around | about | back and forth | to and fro | up and down )
        | ( does | do | will | would | can | could | is | are | 's )? <not> <adv>* ( stay | stays | sit | sits | keep | keeps
            | stand | stands | hold | holds | remain | remains | rest | rests | staying | standing | sitting | keeping |
            resting | be ) <adv>* ( <still> | in place | in one <place> | <wherewas> | ( in | at ) <same> <place> | the same )
        | ( does | do | will | would | can | could | is | are )? <not> <adv>* ( stop | stops | stopping ) ( <moving> )?
            <about>*""",
    (Tag.MOVED,): """<mid> <moved> ( away | around | over | about | across | aside )? ( <elsewhere> | from ( <wherewas> |
            <the>? <formeradj>? own? <place> ( <wherewas> | <it> <waswhere> )? ) ( to? <elsewhere> )? )?
        | ( before | after | since | until ) <it>? moving
        | <mid> ( put | placed | set | taken | took | brought | carried | left | gone | went | came | landed | stands |
            standing | sits | sitting | found | turned up | ended up | wound up | finished up | appeared | <be> | <has> | got
            | given | occupies ) <it>? <adv>* <elsewhere> ( than | from <before> )? now?
        | <elsewhere> ( than ( <before> | <wherewas> ) )?
        | <mid> ( changed | changes | switched | swapped | traded | exchanged | left | abandoned | vacated ) <the>?
            <formeradj>? own? ( <place> | <room> ) <wherewas>?
        | <mid> ( <not> | no longer ) <mid> ( standing | sitting | found )? ( in | at | on )? ( <wherewas> | <same> <place> (
            <wherewas> | <it> <waswhere> )? ) <anymore>?
        | <mid> ( did | <has> ) <not> <adv>* ( stay | stayed | remain | remained | kept ) <adv>* ( <still> | in place |
            <wherewas> | ( in | at | on ) <same> <place> | the same )?
        | <mid> ( out of place | away from ( <same> <place> | <wherewas> ) | misplaced )
        | where <is> <it> <adv>* now
        | <place> <mid> ( changed | shifted )
        | where ( has | have | was | were | is | are | did ) <it> <mid> ( ( <moved> | put | placed | taken | brought | set |
            move ) to | <moved> | gone | go | went | move | end up | ended up )""",
    (Tag.TAKEN,): """<mid> <removed> <it>? ( ( from | out of | off ) ( here | there | us | <home> ) | away | out | off |
            altogether )? <anymore>?
        | <mid> ( went | gone ) ( missing | away )
        | <mid> ( left | leave | quit | exited ) ( us | <home> )
        | <mid> no longer <mid> ( <here> | exists | exist | with us | to be ( seen | found ) | available | seen )
        | <is> <not> <adv>* ( <here> | with us | anywhere? to be ( seen | found ) ) <anymore>?
        | <mid> <not> <mid> ( <here> | exist | exists | with us | see | find ) <it>? ( any more | anymore | any longer )
        | ( do | does ) <not> exist <anymore>? | ( can | could ) <not> ( see | find ) <it>? <anymore>?
        | can <not> be ( found | seen )
        | nowhere ( to be ( found | seen ) )? | ceased to exist""",
    (Tag.NEW,): """brand? new
        | ( newly | freshly | recently | just ) <be>* ( <added> | <appeared> | placed | put | set up | come ) ( in | here |
            there | home | up )?
        | <mid> <appeared> ( out of nowhere | <here> | <adv> )*
        | <mid> <added> <it>? ( in | here | home | along | over | ( to | into ) <home> )?
        | <mid> ( put | placed | set | left ) <it>? <adv>* ( in | here | there | ( into | in ) <home> )
        | newcomer | addition | additional | extra | unfamiliar | arrival | recent | newest
        | <mid> <was> <not> <mid> <here> <before>? | <mid> <has> <not> <mid> been <here>? <before>?
        | <mid> <not> <mid> <here> <before>
        | <mid> ( did | <has> ) <not> <adv>* <usedto>? ( exist | existed | <stand> | <stood> | been ) <here>? <before>?
        | used to not be <here> | used not to be <here>
        | <mid> <not> <mid> <seen> <it>? <here>? <before>?
        | there <was> ( no | not any | not a | not an ) such? ( X | one | ones | thing )? <here>? <before>?
        | no X <was> <here> <before>?
        | <was> <adv>* ( absent | missing ) <before> | for the first time""",
    (Tag.WHERE,): "where | wherever",
    (Tag.PLACE,): "<place>",
    (Tag.PLACE, Tag.PAST): """<formeradj> ( resting | standing )? ( <place> | home ) | ( what | which ) used to be <the>? ( X
            's )? <place>""",
    (Tag.WAS_HERE,): "<adv>* ( <was> | <usedto> be ) <adv>* <here> <before>?",
    (Tag.PAST,): """<was> | <usedto> <stand>? | had | <stood> | <before> | former | ago | kept | occupied | vacated | began
        | started | filled
        | came from | saw | seen | left behind? | remember""",
    (Tag.NOW,): "<is>? now | nowadays | currently | ended up | went | <mid> ( put | placed )",
    (Tag.MOVED, Tag.TO): "<mid> ( <moved> | put | placed | taken | brought ) to",
    (Tag.FROM,): "from",
    (Tag.TO,): "to which",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Cue:
    """A phrase with its tags: the words from start up to end."""

    tags: frozenset[Tag]
    start: int
    end: int


def find_cues(said: Sequence[str]) -> tuple[Cue, ...]:
    """Find the cues in the words of a sentence from left to right, none of which overlap. X among the words is the noun phrase.

    Of equally long matches the first pattern's counts.
    """
    found, start = [], 0
    starts = [sum(len(word) + 1 for word in said[:at]) for at in range(len(said) + 1)]
    text = "".join(f"{word} " for word in said)
    while start < len(said):
        longest, tags = start, frozenset[Tag]()
        for of, pattern in _compiled_patterns():
            # A match that `re` finds need not be the longest, so the ends are tried from the last one on.
            ends = range(len(said), longest, -1) if pattern.match(text, starts[start]) else ()
            longer = next((end for end in ends if pattern.fullmatch(text, starts[start], starts[end])), None)
            if longer is not None:
                longest, tags = longer, of
        if longest > start:
            found.append(Cue(tags, start, longest))
        start = max(longest, start + 1)
    return tuple(found)


@cache
def _compiled_patterns() -> tuple[tuple[frozenset[Tag], re.Pattern[str]], ...]:
    """Compile the patterns at the first use: it takes a second."""
    return tuple((frozenset(tags), re.compile(to_regex(pattern, _FRAGMENTS))) for tags, pattern in _PATTERNS.items())


def to_regex(pattern: str, fragments: Mapping[str, str]) -> str:
    """Translate a pattern into a regular expression over words that each end with a space.

    Raises:
        KeyError: The pattern has an unknown fragment.
    """
    parts = []
    for piece in pattern.replace("|", " | ").split():
        body, suffix = (piece[:-1], piece[-1]) if piece[-1] in "?*" else (piece, "")
        if body == "(":
            parts.append("(?:")
        elif body == ")" or piece == "|":
            parts.append(piece)
        elif body.startswith("<"):
            parts.append(to_regex(fragments[body[1:-1]], fragments) + suffix)
        else:
            parts.append(f"(?:{re.escape(body)} ){suffix}")
    return f"(?:{''.join(parts)})"
