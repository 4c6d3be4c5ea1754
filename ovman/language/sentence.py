"""The sentence that an agent is given: one canonical surface form for each change relation."""

from __future__ import annotations

from ovman.language.noun import is_plural_category

# (singular, plural). A thing that was moved is still in the home; one that was taken away left only its place. FORMER and REMOVED
# differ in their words, though both ask for where the thing was in the first visit.
_FORMS: dict[str, tuple[str, str]] = {
    "moved": ("go to the {noun} that was moved", "go to the {noun} that were moved"),
    "former": ("go to where the {noun} used to be", "go to where the {noun} used to be"),
    "moving": ("go to the {noun} that is moving", "go to the {noun} that are moving"),
    "stable": ("go to the {noun} that stayed in place", "go to the {noun} that stayed in place"),
    "appeared": ("go to the {noun} that was not here before", "go to the {noun} that were not here before"),
    "removed": ("go to where the {noun} was before it was taken away", "go to where the {noun} were before they were taken away"),
}

RELATIONS: tuple[str, ...] = tuple(_FORMS)


def sentence(relation: str, noun: str) -> str:
    """Return the canonical surface form of a query: ("former", "vase") -> "go to where the vase used to be".

    No two pairs share a sentence.

    Args:
        relation: The name of a change relation.
        noun: A noun phrase as `ovman.language.noun.noun` gives it.

    Raises:
        ValueError: An unknown relation or an empty noun.
    """
    if relation not in _FORMS:
        raise ValueError(f"{relation!r} is not a change relation; the relations are {', '.join(_FORMS)}")
    if not noun.strip():
        raise ValueError("the noun of a sentence is empty")
    return _FORMS[relation][is_plural_category(noun)].format(noun=noun)
