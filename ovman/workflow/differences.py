"""Compare the parameters that a release was made under with those of this checkout.

`python -m ovman.workflow.differences` declares that the code of this checkout gives the results of the release: it writes
workflow/equal_code.json. Run it only after a comparison of the results; docs/design.md says how.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

from ovman.settings import Settings
from ovman.settings.config import load_files
from ovman.shipped import EMBEDDED, HOME
from ovman.workflow import made
from ovman.workflow.parameter import canonical
from ovman.workflow.provenance import EQUAL_CODE

WORDS = {
    "code": "its code",
    "agent": "the code of its agent",
    "plugins": "its plug-ins",
    "of_agent": "which constants are its agent's",
}
"""Parts of a parameter beside the constants, in words."""


def differences(parameters: Iterable[str], settings: Settings) -> Iterator[str]:
    """Of each canonical text that is another in this checkout: which stage, and what differs, in words."""
    for text in parameters:
        made = json.loads(text)
        arm = made.get("arm", {}).get("name")
        who = f"stage {made['stage']}" + (f" of arm {arm}" if arm else "")
        try:
            now = json.loads(canonical(settings, made["stage"], arm))
        except KeyError:
            yield f"{who}: the settings have no such {'arm' if arm else 'stage'}"
            continue
        if what := list(_what(made, now)):
            yield f"{who}: {', '.join(what)}"


def _what(made: dict[str, Any], now: dict[str, Any]) -> Iterator[str]:
    """What differs in two parameters of one stage. Constants come first: they are the user's to put back."""
    then, here = made["constants"], now["constants"]
    for name in sorted({*then, *here}):
        if name not in then or name not in here:
            yield f"{name} is a constant of it {'here' if name in here else 'there'} alone"
        elif then[name] != here[name]:
            yield f"{name} {_changed(then[name], here[name])}"
    for key in sorted({*made, *now} - {"constants", "stage", "arm"}):
        if made.get(key) != now.get(key):
            yield f"{WORDS.get(key, key)} differs"
    for key in sorted({*made.get("arm", {}), *now.get("arm", {})}):
        before, after = made["arm"].get(key), now["arm"].get(key)
        if before != after:
            yield f"its {key} {_changed(before, after)}"


def _changed(then: Any, here: Any) -> str:
    """Two values that differ; long ones are not shown."""
    texts = json.dumps(then), json.dumps(here)
    return "differs" if max(map(len, texts)) > 40 else f"was {texts[0]} and is {texts[1]}"


def equal_code(parameters: Iterable[str], settings: Settings) -> dict[str, str]:
    """Pair each digest of code of this checkout with the one that the release has in its place, where the two differ."""
    pairs = {}
    for text in parameters:
        then = json.loads(text)
        now = json.loads(canonical(settings, then["stage"], then.get("arm", {}).get("name")))
        digests = zip([now["code"], *now.get("agent", [])], [then["code"], *then.get("agent", [])], strict=True)
        pairs.update({here: there for here, there in digests if here != there})
    return dict(sorted(pairs.items()))


if __name__ == "__main__":
    (HOME / EQUAL_CODE).unlink(missing_ok=True)
    pairs = equal_code(made.read(HOME / EMBEDDED).parameters.values(), load_files([HOME / "config.yaml"]))
    (HOME / EQUAL_CODE).write_text(json.dumps(pairs, indent=1) + "\n", encoding="utf-8")
