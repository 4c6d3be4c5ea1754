"""What tests of networks say of weights that are refused."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from ovman.perception.weights import WeightsError


def line(call: Callable[[], object]) -> str:
    """The one line that a call refuses weights in; it begins with the setting."""
    with pytest.raises(WeightsError) as caught:
        call()
    text = str(caught.value)
    assert "\n" not in text and text.startswith("perception.") and len(text) < 450
    return text
