"""Networks that stand in for DualMap's own, by colour: run in the process of a real clone, where there are no weights.

A pixel of red 10 (k + 1) belongs to an instance of the k-th class of `chosen`. Images and texts have features of 512 numbers, one
of them 1.
"""

import sys
from importlib import import_module
from types import ModuleType, SimpleNamespace

BACKGROUND = {"wall", "floor", "ceiling", "unknown"}
FURNITURE = ("sofa", "bed", "table", "chair", "cabinet", "couch", "shelf", "stool", "bathtub", "armchair")


def chosen(names):
    """Names of a list of classes in the order of the colours: furniture that seldom moves first, then the others."""
    return sorted((name for name in names if name not in BACKGROUND), key=lambda name: name not in FURNITURE)


def before():
    """Replaces the networks that `utils.object_detector` and open_clip would load."""
    import numpy as np
    import open_clip
    import torch

    stub = ModuleType("mobileclip.modules.common.mobileone")
    stub.reparameterize_model = lambda model: model
    for name in ("mobileclip", "mobileclip.modules", "mobileclip.modules.common"):
        sys.modules[name] = ModuleType(name)
    sys.modules[stub.__name__] = stub

    class Yolo:
        def __init__(self, *args, **kwargs):
            pass

        def to(self, *args, **kwargs):
            return self

        def set_classes(self, names):
            self.names = list(names)

        def predict(self, rgb, **kwargs):
            colours = [value for value in np.unique(rgb[..., 0]).tolist() if value]
            boxes = []
            for value in colours:
                rows, columns = np.nonzero(rgb[..., 0] == value)
                boxes.append([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1])
            classes = [self.names.index(chosen(self.names)[value // 10 - 1]) for value in colours]
            found = SimpleNamespace(
                conf=torch.full((len(colours),), 0.9),
                cls=torch.tensor(classes, dtype=torch.float32),
                xyxy=torch.tensor(boxes, dtype=torch.float32).reshape(-1, 4),
            )
            return [SimpleNamespace(boxes=found)]

    class Sam:
        def __init__(self, *args, **kwargs):
            pass

        def to(self, *args, **kwargs):
            return self

        def predict(self, rgb, bboxes=None, **kwargs):
            colours = [value for value in np.unique(rgb[..., 0]).tolist() if value]
            masks = torch.from_numpy(np.stack([rgb[..., 0] == value for value in colours]))
            return [SimpleNamespace(masks=SimpleNamespace(data=masks))]

    class Towers(torch.nn.Module):
        def encode_image(self, pictures):
            return torch.nn.functional.one_hot(pictures.reshape(len(pictures)).long().cpu(), 512).float()

        def encode_text(self, tokens):
            return torch.nn.functional.one_hot(tokens.reshape(len(tokens)).long().cpu() + 256, 512).float()

    def colour(picture):
        red = np.asarray(picture)[..., 0]
        return torch.tensor([float(np.median(red[red > 0])) if (red > 0).any() else 0.0])

    def tokens(texts):
        texts = [texts] if isinstance(texts, str) else texts
        return torch.tensor([[sum(text.encode()) % 256] for text in texts])

    open_clip.create_model_and_transforms = lambda *args, **kwargs: (Towers(), colour, colour)
    open_clip.get_tokenizer = lambda *args, **kwargs: tokens

    detector = import_module("utils.object_detector")
    detector.YOLO, detector.SAM, detector.FastSAM = Yolo, Sam, Sam
