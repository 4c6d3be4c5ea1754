"""Record both tours of an episode and write them as an animation, with the query and the answer at the end.

python docs/animate.py EPISODE FILE.webp
"""

from __future__ import annotations

import sys
from io import BytesIO
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from ovman.agents.interface import VISITS
from ovman.entry import CONFIG, DATA
from ovman.evaluation.tours import record_tour
from ovman.perception import tour_files
from ovman.records.episode import Episode
from ovman.records.visit import tour_path
from ovman.report.figures.relations import Shown, draw_panel
from ovman.settings.config import load
from ovman.sim.session import Session

FRAME_MS, QUERY_MS, ANSWER_MS = 250, 2000, 4000
QUALITY = 65
TITLES, ANSWER_TITLES = ("first visit", "second visit"), ("first visit, the same place", "second visit, the answer")


def animate(episode: Episode, output: Path) -> None:
    """Write the animation: the tours next to each other, then the query, then the views that show the answer best."""
    with TemporaryDirectory() as folder, Session(episode.scene, episode.settings) as session:
        for which in VISITS:
            record_tour(session, episode, which, Path(folder))
        shown = Shown.choose(episode, Path(folder), load(CONFIG))
        tours = [tour_path(Path(folder), visit.visit) for visit in shown.visits]
        numbers = [range(len(visit.views)) for visit in shown.visits]
        pictures = [[tour_files.picture(tour, n, "rgb")[..., ::-1] for n in of] for tour, of in zip(tours, numbers, strict=True)]
        frames = [draw_frame(pair, TITLES, "") for pair in zip_longest(*pictures)]
        query, last = f"“{episode.sentence}”", (pictures[0][-1], pictures[1][-1])
        frames += [draw_frame(last, TITLES, query), draw_frame(shown, ANSWER_TITLES, query)]
    durations = [*[FRAME_MS] * (len(frames) - 2), QUERY_MS, ANSWER_MS]
    frames[0].save(output, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=QUALITY, method=6)


def draw_frame(views: Shown | tuple[np.ndarray | None, np.ndarray | None], titles: tuple[str, str], query: str) -> Image.Image:
    """Return one picture: a view of each visit, empty after the end of its tour, and the query below."""
    figure = plt.figure(figsize=(6.4, 3.7))
    for which, title in enumerate(titles):
        axis = figure.add_axes((0.005 + 0.5 * which, 0.1, 0.49, 0.82))
        axis.set_title(title, fontsize=11)
        axis.set_axis_off()
        if isinstance(views, Shown):
            draw_panel(axis, views, which, views.episode.protocol.camera)
        elif views[which] is not None:
            axis.imshow(views[which])
    figure.text(0.5, 0.03, query, fontsize=13, horizontalalignment="center")
    with BytesIO() as file:
        figure.savefig(file, format="png", dpi=100, facecolor="white")
        plt.close(figure)
        return Image.open(file).convert("RGB")


if __name__ == "__main__":
    matplotlib.use("Agg")
    wanted, file = sys.argv[1:]
    (chosen,) = [one for one in Episode.load(DATA / "episodes" / "everyday.jsonl") if one.id == wanted]
    animate(chosen, Path(file))
