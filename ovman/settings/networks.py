"""The networks: how they perceive, and how those of the default configuration are made."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ovman.section import Count, Section, Some, Whole

Sha256 = Annotated[str, Field(pattern=r"^([0-9a-f]{64})?$")]


class DetectorNetwork(Section):
    """The class-agnostic detector."""

    architecture: str = Field(min_length=1, description="segmentation network by ultralytics' name, of weights that are no graph")
    weights: str = Field(min_length=1, description="graph (.onnx) or file of weights, or ultralytics' name of released ones")
    sha256: Sha256 = Field(description="SHA-256 of the weights in hexadecimal, or empty")
    side_px: Annotated[Whole, Field(ge=32, le=4096, multiple_of=32)] = Field(description="pixels, side of scaled pictures")
    confidence: Annotated[float, Field(gt=0, lt=1)] = Field(description="detector confidence")
    min_mask_px: Some = Field(description="pixels, smallest mask that is kept")


class EncoderNetwork(Section):
    """The image and text towers."""

    model: str = Field(
        min_length=1,
        description="open_clip's name of a model or its configuration (.json); a name for the report if the weights are a graph",
    )
    weights: str = Field(min_length=1, description="graph (.onnx) or file of weights, or open_clip's tag of released ones")
    sha256: Sha256 = Field(description="SHA-256 of the weights in hexadecimal, or empty")
    crop_padding: Annotated[float, Field(ge=0)] = Field(description="share of a mask's longer side that is added around it")


class Perception(Section):
    """From pictures to detections."""

    device: Literal["cpu", "cuda"] = Field(description="where the networks run")
    trust_pickles: bool = Field(description="whether pickled weights (.pt), which can run code of their author, may be loaded")
    detector: DetectorNetwork
    encoder: EncoderNetwork


class DetectorTraining(Section):
    """Training of the default detector."""

    epochs: Some = Field(2, description="passes over all pictures")
    further_epochs: Some = Field(4, description="passes after that, without mosaics")
    batch: Some = Field(8, description="pictures a step")
    learning_rate: Annotated[float, Field(gt=0)] = Field(0.0015, description="peak learning rate")
    further_learning_rate: Annotated[float, Field(gt=0)] = Field(0.0012, description="peak learning rate of the further passes")
    weight_decay: Annotated[float, Field(ge=0)] = Field(0.0005, description="weight decay")
    look_every: Some = Field(500, description="steps between two looks at the held-out scenes")
    look_at_one_in: Some = Field(4, description="one in so many held-out pictures is looked at meanwhile")


class EncoderTraining(Section):
    """Training of the default encoder."""

    crop_px: Annotated[Whole, Field(ge=32, multiple_of=32)] = Field(96, description="pixels, side of a crop")
    views: Some = Field(48, description="pictures of a scene, of those that are recorded")
    steps: Some = Field(1200, description="steps of the image tower")
    batch: Some = Field(64, description="crops a step")
    learning_rate: Annotated[float, Field(gt=0)] = Field(0.0007, description="peak learning rate")
    weight_decay: Annotated[float, Field(ge=0)] = Field(0.05, description="weight decay")
    look_every: Some = Field(600, description="steps between two looks at the held-out scenes")


class Training(Section):
    """How `make models` trains the default networks. The defaults are the values that the shipped networks were trained with."""

    seed: Count = Field(0, description="root of every random number of the trainings")
    views: Some = Field(240, description="pictures of a floor plan that is learned from")
    held_out_views: Some = Field(60, description="pictures of a floor plan that is held out")
    homes: Some = Field(77, description="homes with assets of train that the encoder learns from")
    held_out_homes: Some = Field(40, description="homes with assets of val, for the encoder's learning curve")
    home_views: Some = Field(24, description="pictures of a home")
    left_out: tuple[str, ...] = Field((), description="categories that no picture or caption of the training shows")
    detector: DetectorTraining = DetectorTraining()
    encoder: EncoderTraining = EncoderTraining()
