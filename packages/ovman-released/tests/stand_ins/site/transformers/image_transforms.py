"""Boxes."""


def center_to_corners_format(boxes):
    return boxes
