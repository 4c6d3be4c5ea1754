"""What tests of networks have in common."""

from __future__ import annotations

from collections.abc import Generator
from functools import cache

import pytest


@pytest.fixture(scope="module")
def one_tokenizer() -> Generator[None, None, None]:
    """open_clip's tokenizer is made once. Each text that is read makes one, which takes .4 s; it draws nothing."""
    from open_clip import tokenizer

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tokenizer, "SimpleTokenizer", cache(tokenizer.SimpleTokenizer))
        yield
