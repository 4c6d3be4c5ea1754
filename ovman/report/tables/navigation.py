"""The table of what executing answers costs."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import ALL, MARK, arms_frame, numbers, spread, spread_columns, three, words
from ovman.report.tables.table import DATA, PAGE, Column, Table
from ovman.settings import Settings

SCORES = {"sr": "SR", "spl": "SPL", "spl_given_success": "SPL given success"}


def navigation_table(navigations: pd.DataFrame, settings: Settings) -> Table:
    """One row an embodied arm, over all episodes: means and extremes over the seeds. navigations: rows of `Navigation`."""
    agents = arms_frame(settings)["system"]
    over_all = navigations[navigations["relation"] == ALL]
    rows = [_row(agents[str(arm)], of_arm) for arm, of_arm in over_all.groupby("arm", sort=False)]
    columns = (
        words("agent"),
        numbers("static", data=three, formats=DATA),
        Column("static_page", "static", numeric=True, formats=PAGE),
        *(column for key, title in SCORES.items() for column in spread_columns(key, title)),
        words("lost"),
        words("gained"),
        numbers("n"),
        words("seeds"),
    )
    caption = (
        "What executing an answer costs, means over seeds (least and greatest of a seed). Lost: static successes that fail when "
        "executed; gained: static failures that succeed, as the stop test also accepts a stop near the target's box or the "
        f"nearest navigable cell; one count per seed. Static: success of the executed answers ({MARK} of a stochastic pick)."
    )
    return Table(caption, columns, pd.DataFrame(rows), wide=True)


def _row(agent: str, seeds: pd.DataFrame) -> dict[str, object]:
    row: dict[str, object] = {
        "agent": agent,
        "n": seeds["n"].iloc[0],
        "seeds": ", ".join(map(str, seeds["seed"])),
        "lost": ", ".join(map(str, seeds["lost"].dropna())),
        "gained": ", ".join(map(str, seeds["gained"].dropna())),
    }
    successes = seeds["static_successes"].iloc[0]
    if pd.notna(successes):
        row["static"] = successes / seeds["n"].iloc[0]
        row["static_page"] = three(successes / seeds["n"].iloc[0]) + ("" if row["lost"] else MARK)
    for key in SCORES:
        row |= spread(seeds[key], key)
    return row
