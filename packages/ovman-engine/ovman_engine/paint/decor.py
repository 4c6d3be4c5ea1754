"""Random finishes, colours and lights in place of a scene's own. This module imports little."""

from __future__ import annotations

from dataclasses import dataclass

Range = tuple[float, float]


@dataclass(frozen=True)
class Lighting:
    """Arguments of RandomizeLighting."""

    key: str
    """Key of the draw: equal keys give equal light."""
    synchronized: bool = False
    """Whether all lights share one draw"""
    brightness: Range = (0.5, 1.5)
    """Range of the factor on each light's intensity"""
    tinted: bool = True
    """Whether colours are drawn as well"""
    hue: Range = (0.0, 1.0)
    saturation: Range = (0.5, 1.0)
    """Ranges of the colours, HSV with value 1"""


@dataclass(frozen=True)
class Decor:
    """The appearance of a scene; the default is the scene's own."""

    finishes: str = ""
    """Key of the draw of all finishes; empty for the scene's own"""
    colours: str = ""
    """Key of the draw of all colours, with unchanged textures; empty for the finishes' own"""
    lighting: Lighting | None = None
    """None: the scene's own light"""
