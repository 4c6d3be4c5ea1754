"""The joint agent."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.settings.values import Fraction, Metres, Probability, Section, Some


class Joint(Section):
    """The joint agent: evidence of every detection first, objects from it, one decision last."""

    every_px: Some = Field(description="rows and columns between the pixels of a frame that are looked up in other frames")
    tolerance_m: Metres = Field(description="a frame that shows something nearer to a place than this shows it at the place")
    tolerance_per_m: Annotated[float, Field(ge=0)] = Field(description="grows with the distance of the place by this share")
    part_cells: Some = Field(description="fewest cells of the grid that the other tour sees through without a detection")
    doubt: Fraction = Field(description="share of a segment's cells that may be wrong about its place")
    temperature: Fraction = Field(description="of the encoder: cosines are divided by it before the softmax over the vocabulary")
    astray: Probability = Field(description="probability that a segment's embedding says nothing about its name")
    radius_m: Metres = Field(description="distance at which two segments of equal features are two objects")
    feature_distance: Annotated[float, Field(gt=0)] = Field(
        description="1 - cosine at which two segments at one place are two objects"
    )
    views: Annotated[float, Field(ge=0)] = Field(description="number of views from which half of a name's evidence is believed")
    identity: Annotated[float, Field(ge=0)] = Field(description="weight of whether an object is to be found elsewhere")
    likeness: Annotated[float, Field(gt=0)] = Field(description="log odds of being one instance, for a difference of 1 in cosine")
    alike: Annotated[float, Field(ge=-1, le=1)] = Field(description="cosine at which these log odds are 0")
    unlike: Annotated[float, Field(lt=0)] = Field(description="log odds of being elsewhere where nothing is alike")
    motion: Annotated[float, Field(gt=0)] = Field(description="weight of motion beside the name, in a track")
    speed_m: Metres = Field(description="farthest that a mover comes between two views of a tour")
    least_confidence: Probability = Field(description="probability of its place below which it gives no answer")
    pursuit_m: Metres = Field(description="farthest from where a mover is thought to be that something is taken for it")
