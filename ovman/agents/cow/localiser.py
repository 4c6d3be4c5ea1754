"""CoW's localiser: which pixels show the category of the query."""

from __future__ import annotations

import hashlib

import cv2
import numpy as np

from ovman.agents.cow import Cow
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS
from ovman.perception.detector import Detector
from ovman.perception.encoder import Encoder, crop
from ovman.settings import Settings

PROMPT = "a photo of a {}"
"""CoW's prompt without its full stop."""
REMEMBERED = 2000
"""Most images whose instances are kept. Runs of an episode under several seeds begin with the same images."""


def prompt(category: str) -> str:
    """Return the prompt of a category: "a photo of a house plant"."""
    return PROMPT.format(noun(category))


class OpenVocabularyLocaliser:
    """The reference agent's networks in place of OWL-ViT: class-agnostic instances whose crops are compared to the prompt.

    min_mask_share: smallest mask as a share of the image; crop_padding: as a share of the longer side of a mask's box.
    """

    def __init__(self, detector: Detector, encoder: Encoder, constants: Cow, min_mask_share: float, crop_padding: float) -> None:
        self._detector, self._encoder, self._constants = detector, encoder, constants
        self._min_mask_share, self._crop_padding = min_mask_share, crop_padding
        self._text = np.zeros(0, np.float32)
        self._known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def look_for(self, category: str) -> None:
        """Embed the prompt of a category."""
        self._text = self._encoder.texts([prompt(category)])[0]

    def relevance(self, rgb: np.ndarray) -> np.ndarray:
        """Return 1 at the centre of the box of every instance that is similar enough, or all over the box; else 0."""
        boxes, features = self.instances(rgb)
        side_px, found = self._constants.image_px, np.zeros((self._constants.image_px,) * 2, np.float32)
        scale = side_px / np.array(rgb.shape[:2] * 2)
        for top, left, bottom, right in boxes[features @ self._text >= self._constants.similarity] * scale:
            if self._constants.centre_only:
                found[int((top + bottom) / 2), int((left + right) / 2)] = 1.0
            else:
                found[int(top) : max(int(bottom), int(top) + 1), int(left) : max(int(right), int(left) + 1)] = 1.0
        return found

    def instances(self, rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the instances of an image (H, W, 3): boxes (N, 4), and unit embeddings (N, K) of their crops.

        A box is top, left, bottom, right in pixels, bottom and right exclusive.
        """
        key = hashlib.sha256(rgb.tobytes()).digest()
        if key not in self._known:
            if len(self._known) == REMEMBERED:
                self._known.clear()
            self._known[key] = self._look(rgb)
        return self._known[key]

    def _look(self, rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        (seen,) = self._detector.detect([rgb])
        masks = seen.masks[np.count_nonzero(seen.masks, axis=(1, 2)) >= self._min_mask_share * rgb.shape[0] * rgb.shape[1]]
        if not len(masks):
            return np.zeros((0, 4)), np.zeros((0, len(self._text)), np.float32)
        crops = [crop(rgb, mask, self._crop_padding, self._encoder.side_px, self._encoder.contrast) for mask in masks]
        sides = np.array([cv2.boundingRect(mask.view(np.uint8)) for mask in masks], float)[:, [1, 0, 3, 2]]
        return np.hstack([sides[:, :2], sides[:, :2] + sides[:, 2:]]), self._encoder.images(np.stack(crops))


def make_localiser(constants: Settings, detector: Detector, encoder: Encoder) -> OpenVocabularyLocaliser:
    """Make the localiser of the LoCoBot's frames. Reads cow.*, locobot.*, camera.* and perception.*.

    The smallest mask is the same share of the frame as for the reference agent.
    """
    for category in SYNONYMS:  # fills the encoder's cache for all jobs at once
        encoder.texts([prompt(category)])
    camera, perception = constants.camera, constants.perception
    min_mask_share = perception.detector.min_mask_px / (camera.width_px * camera.height_px)
    of_frames = detector.at(constants.locobot.side_px)
    return OpenVocabularyLocaliser(of_frames, encoder, constants.cow, min_mask_share, perception.encoder.crop_padding)
