"""A detector whose parent has outgrown an override; imports what present transformers no longer has."""

from importlib import import_module

center_to_corners_format = import_module("transformers.models.owlvit.feature_extraction_owlvit").center_to_corners_format
parent = import_module("transformers.models.owlvit").OwlViTForObjectDetection


class MyOwlViTForObjectDetection(parent):
    def normalize_grid_corner_coordinates(self, feature_map):
        return feature_map


class ClipOwl:
    def __init__(self, classes, classes_clip):
        assert MyOwlViTForObjectDetection().boxes() == (24, 24)
        self.prompts = {name: f"a photo of a {phrase}." for name, phrase in zip(classes, classes_clip, strict=True)}

    def forward(self, goal):
        return self.prompts[goal]
