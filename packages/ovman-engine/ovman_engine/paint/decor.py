"""How the look of a scene differs from the one that it comes with: finishes, colours and light drawn anew. Light to import."""

from __future__ import annotations

from dataclasses import dataclass

Range = tuple[float, float]


@dataclass(frozen=True)
class Lighting:
    """What RandomizeLighting draws the lights of a scene from."""

    key: str
    """Names the draw: the same key gives the same light."""
    synchronized: bool = False
    """Whether all lights share one draw"""
    brightness: Range = (0.5, 1.5)
    """Range of the factor on each light's intensity"""
    tinted: bool = True
    """Whether colours are drawn too"""
    hue: Range = (0.0, 1.0)
    saturation: Range = (0.5, 1.0)
    """Ranges of the colours, HSV with value 1"""


@dataclass(frozen=True)
class Decor:
    """A scene's look. The default is how the scene comes."""

    finishes: str = ""
    """Names the draw of all finishes; empty: the scene's own"""
    colours: str = ""
    """Names the draw of all colours, textures staying as they are; empty: as the finishes have them"""
    lighting: Lighting | None = None
    """None: the scene's own light"""
