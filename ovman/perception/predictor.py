"""ultralytics' predictor, which prepares pictures and reads masks from what a network gives for them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import asdict, dataclass
from functools import cache
from types import SimpleNamespace
from typing import Any

from ovman.perception.graph import Graph, exported
from ovman.perception.network_cache import NetworkCache
from ovman.perception.non_max_suppression import non_max_suppression


@dataclass(frozen=True, slots=True)
class Facts:
    """What has to be known of a network to prepare pictures for its graph and to read what that gives.

    stride: sides of its pictures are multiples of it; end2end: it suppresses overlaps itself.
    """

    stride: int
    end2end: bool

    @staticmethod
    def of(network: Any) -> Facts:
        return Facts(max(int(network.stride.max()), 32), bool(getattr(network, "end2end", False)))


def with_network(options: Mapping[str, Any], network: Any) -> Any:
    """ultralytics' predictor, which looks for the instances of one picture after the other.

    Given several, its suppression of overlaps stops after two seconds of wall clock and leaves the rest of them without any.
    """
    from ultralytics.models.yolo.segment import SegmentationPredictor

    class Unhurried(SegmentationPredictor):
        def postprocess(self, preds: Any, img: Any, orig_imgs: Any) -> list[Any]:
            boxes, prototypes = preds[0] if isinstance(preds[0], tuple) else preds[:2]
            return [
                result
                for n in range(len(orig_imgs))
                for result in super(Unhurried, self).postprocess(
                    ((boxes[n : n + 1], prototypes[n : n + 1]),), img[n : n + 1], orig_imgs[n : n + 1]
                )
            ]

    network = network.to(options["device"]).float().eval()
    network.pt_path = None
    made = Unhurried(overrides=dict(options))
    made.setup_model(network, verbose=False)
    return made


def with_graphs(options: Mapping[str, Any], load: Callable[[], Any], kept: NetworkCache) -> Any:
    """ultralytics' predictor on a processor, where pictures go one by one through a graph for their shape.

    load: gives the network, if there is a graph to make of it that is not kept yet.
    """
    import torch
    from ultralytics.models.yolo.segment import SegmentationPredictor
    from ultralytics.utils.ops import xywh2xyxy

    facts = Facts(**json.loads(kept.content("facts.json", lambda: json.dumps(asdict(Facts.of(load()))).encode())))

    @cache
    def graph(*shape: int) -> Graph:
        name = "x".join(map(str, shape))
        return Graph(kept.content(f"{name}.onnx", lambda: exported(_boxes(load(), options["max_det"]), shape)))

    class Graphs(SegmentationPredictor):
        def inference(self, im: Any, *args: Any, **kwargs: Any) -> Any:
            return [graph(1, *im.shape[1:])(picture[None]) for picture in im]

        def postprocess(self, preds: Any, img: Any, orig_imgs: Any) -> list[Any]:
            return [
                result
                for n, (boxes, prototypes) in enumerate(preds)
                for result in self.construct_results(
                    [self._instances(boxes[0], prototypes.shape[1])], img[n : n + 1], orig_imgs[n : n + 1], prototypes
                )
            ]

        def _instances(self, boxes: Any, coefficients: int) -> Any:
            """Corners, confidence, class and coefficients of the mask (N, 6 + coefficients) of what is sure enough and stays."""
            sure, most = self.args.conf, self.args.max_det
            if facts.end2end:
                return boxes[boxes[:, 4] > sure][:most]
            end = len(boxes) - coefficients
            found = boxes[:, boxes[4:end].amax(0) > sure].T
            confidence, of = found[:, 4:end].max(1, keepdim=True)
            corners = xywh2xyxy(found[:, :4])
            stay = torch.from_numpy(non_max_suppression(corners.numpy(), confidence[:, 0].numpy(), self.args.iou, most))
            return torch.cat((corners, confidence, of.float(), found[:, end:]), 1)[stay]

    made = Graphs(overrides=dict(options))
    made.device = torch.device("cpu")
    made.model = SimpleNamespace(  # what it asks of a network that takes pictures of any shape
        format="onnx",
        dynamic=True,
        stride=facts.stride,
        end2end=facts.end2end,
        names={},
        channels=3,
        fp16=False,
        warmup=lambda *_, **__: None,
    )
    return made


def _boxes(network: Any, most: int) -> Any:
    """Of what a network gives, what counts where nothing is learned: boxes with their scores, and prototypes of masks."""
    import torch

    class Boxes(torch.nn.Module):
        def __init__(self, network: Any) -> None:
            super().__init__()
            self.network = network

        def forward(self, pictures: Any) -> Any:
            given = self.network(pictures)
            return given[0] if isinstance(given[0], tuple) else given[:2]

    fused = deepcopy(network).float().eval().fuse(verbose=False)
    if Facts.of(fused).end2end:
        fused.set_head_attr(max_det=max(most, 300), agnostic_nms=True)
    return Boxes(fused).eval()
