"""Read the elements of a page. They are well-formed XML below the DOCTYPE, so an element that is left open is an error."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.etree.ElementTree import Element


def read(text: str) -> Element:
    """The root of a page."""
    return ElementTree.fromstring(text.partition("\n")[2])


def words(element: Element) -> str:
    """All text of an element."""
    return " ".join("".join(element.itertext()).split())


def classes(element: Element) -> set[str]:
    """The classes of an element."""
    return set(element.get("class", "").split())


def of_class(root: Element, *names: str) -> list[Element]:
    """The elements with all of these classes."""
    return [element for element in root.iter() if {*names} <= classes(element)]
