"""ultralytics' predictor: preprocessing of pictures and decoding of masks."""

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
class DetectorFacts:
    """What preprocessing and decoding need of a network.

    stride: divides the sides of its pictures; end2end: it has non-maximum suppression of its own.
    """

    stride: int
    end2end: bool

    @staticmethod
    def of(network: Any) -> DetectorFacts:
        """The facts of a network of ultralytics."""
        return DetectorFacts(max(int(network.stride.max()), 32), bool(getattr(network, "end2end", False)))


def with_network(options: Mapping[str, Any], network: Any) -> Any:
    """ultralytics' predictor, one picture at a time.

    For a batch its non-maximum suppression stops after two seconds of wall time and drops the remaining pictures.
    """
    from ultralytics.models.yolo.segment import SegmentationPredictor

    class Unhurried(SegmentationPredictor):
        def postprocess(self, preds: Any, img: Any, orig_imgs: Any, **kwargs: Any) -> list[Any]:
            each: Any = super()
            boxes, prototypes = preds[0] if isinstance(preds[0], tuple) else preds[:2]
            return [
                result
                for n in range(len(orig_imgs))
                for result in each.postprocess(((boxes[n : n + 1], prototypes[n : n + 1]),), img[n : n + 1], orig_imgs[n : n + 1])
            ]

    network = network.to(options["device"]).float().eval()
    network.pt_path = None
    made = Unhurried(overrides=dict(options))
    made.setup_model(network, verbose=False)
    return made


def with_graphs(options: Mapping[str, Any], load: Callable[[], Any], kept: NetworkCache) -> Any:
    """ultralytics' predictor on a processor: pictures go one by one through a graph of their shape.

    load: returns the network; called only for a graph that the cache does not have.
    """
    import torch
    from ultralytics.models.yolo.segment import SegmentationPredictor
    from ultralytics.utils import ops

    untyped: Any = ops  # as all of ultralytics

    facts = DetectorFacts(**json.loads(kept.content("facts.json", lambda: json.dumps(asdict(DetectorFacts.of(load()))).encode())))

    @cache
    def graph(*shape: int) -> Graph:
        name = "x".join(map(str, shape))
        return Graph(kept.content(f"{name}.onnx", lambda: exported(_boxes(load(), options["max_det"]), shape)))

    class Graphs(SegmentationPredictor):
        def inference(self, im: Any, *args: Any, **kwargs: Any) -> Any:
            return [graph(1, *im.shape[1:])(picture[None]) for picture in im]

        def postprocess(self, preds: Any, img: Any, orig_imgs: Any, **kwargs: Any) -> list[Any]:
            whole: Any = self
            return [
                result
                for n, (boxes, prototypes) in enumerate(preds)
                for result in whole.construct_results(
                    [self._instances(boxes[0], prototypes.shape[1])], img[n : n + 1], orig_imgs[n : n + 1], prototypes
                )
            ]

        def _instances(self, boxes: Any, coefficients: int) -> Any:
            """Corners, confidence, class and mask coefficients (N, 6 + coefficients) of the kept boxes."""
            sure, most = self.args.conf, self.args.max_det
            if facts.end2end:
                return boxes[boxes[:, 4] > sure][:most]
            end = len(boxes) - coefficients
            found = boxes[:, boxes[4:end].amax(0) > sure].T
            confidence, of = found[:, 4:end].max(1, keepdim=True)
            corners = untyped.xywh2xyxy(found[:, :4])
            stay = torch.from_numpy(non_max_suppression(corners.numpy(), confidence[:, 0].numpy(), self.args.iou, most))
            return torch.cat((corners, confidence, of.float(), found[:, end:]), 1)[stay]

    made: Any = Graphs(overrides=dict(options))
    made.device = torch.device("cpu")
    made.model = SimpleNamespace(  # what the predictor asks of a network for pictures of any shape
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
    """The outputs that inference uses: boxes with scores, and mask prototypes."""
    import torch

    class Boxes(torch.nn.Module):
        def __init__(self, network: Any) -> None:
            super().__init__()
            self.network = network

        def forward(self, pictures: Any) -> Any:
            given = self.network(pictures)
            return given[0] if isinstance(given[0], tuple) else given[:2]

    fused = deepcopy(network).float().eval().fuse(verbose=False)
    if DetectorFacts.of(fused).end2end:
        fused.set_head_attr(max_det=max(most, 300), agnostic_nms=True)
    return Boxes(fused).eval()
