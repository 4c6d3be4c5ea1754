"""Make the film of a run, an animated WebP: what the agent sees next to the plan with its path, and the query below."""

from __future__ import annotations

import math
from collections.abc import Sequence
from io import BytesIO
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ovman.records.episode import Episode
from ovman.records.geometry import Point, Spawn
from ovman.records.scene import Scene
from ovman.report.show.answers import FOUND, Line
from ovman.report.show.plan import Frame, list_furniture

PANEL_PX, CAPTION_PX, GAP_PX = 300, 58, 8
SMOOTH = 3
"""Plans are drawn so many times larger, since Pillow draws no smooth edges."""
FRAMES, LENGTH_MS, LONGEST_MS, LAST_MS = 90, 12_000, 200, 2_500
"""Most pictures, their time in all, the longest time of one, and that of the last one."""
QUALITIES = (80, 60, 40, 20)
MOST_BYTES = 3_000_000
INK, SOFT, PAPER, FLOOR, WALL, THING, EDGE = "#22262b", "#5d656e", "#ffffff", "#f5f3ee", "#b9b3a6", "#e6e2d9", "#cfcabf"
TRUTH, ALIKE, PATH, RIGHT, WRONG = "#9c2f74", "#ead3e1", "#084582", "#00735c", "#c2500a"


class Background(NamedTuple):
    """The common parts of all pictures of a film. plan: of the second visit in its frame, SMOOTH times larger; query: words."""

    frame: Frame
    plan: Image.Image
    query: str


def make_film(
    episode: Episode, scene: Scene, title: str, line: Line, poses: Sequence[Spawn], images: Sequence[np.ndarray]
) -> bytes:
    """Return the film of a run, at most 15 s and 3 MB.

    Args:
        episode: With its query and answer, which the plan shows.
        scene: The home or floor plan.
        title: The agent, in words.
        line: The end of the run.
        poses: Of the agent, at its spawn and after each action.
        images: Its camera pictures there, (H, W, 3) uint8.
    """
    frame = plan_frame(scene, episode)
    behind, last = Background(frame, _draw_plan(frame, scene, episode), episode.sentence), len(poses) - 1
    chosen = sorted({round(k) for k in np.linspace(0, last, min(FRAMES, len(poses)))})
    pictures = [_draw_picture(behind, f"{title} · action {k} of {last}", poses[: k + 1], images[k]) for k in chosen]
    pictures.append(_draw_picture(behind, f"{title} · {line.verdict} · {line.words}", poses, images[-1], line))
    each = min(LONGEST_MS, LENGTH_MS // len(chosen))
    return _encode(pictures, [each] * len(chosen) + [LAST_MS])


def plan_frame(scene: Scene, episode: Episode) -> Frame:
    """Return the frame of the plan of a film, in pixels."""
    floor = [corner for corners in scene.rooms or () for corner in corners] or scene.reachable
    return Frame.around([*floor, episode.answer], (PANEL_PX, PANEL_PX), 0.3)


def _draw_plan(frame: Frame, scene: Scene, episode: Episode) -> Image.Image:
    """Draw the second visit, SMOOTH times larger: the rooms, the furniture, the changes of the queried category, the answer."""
    plan = Image.new("RGB", (PANEL_PX * SMOOTH, PANEL_PX * SMOOTH), PAPER)
    draw = ImageDraw.Draw(plan)
    for corners in scene.rooms or ():
        draw.polygon([_larger(frame.at(corner)) for corner in corners], FLOOR, WALL, SMOOTH)
    colours = {"floor": (FLOOR, WALL), "thing": (THING, EDGE), "thing of-category": (ALIKE, TRUTH)}
    for kind, (x, z), (wide, deep), _ in list_furniture(scene, [episode], 1):
        box = [_larger(frame.at(corner)) for corner in ((x - wide / 2, z + deep / 2), (x + wide / 2, z - deep / 2))]
        draw.rectangle([*box[0], *box[1]], *colours[kind], SMOOTH)
    radius = episode.protocol.success.radius_m * frame.scale * SMOOTH
    u, v = _larger(frame.at(episode.answer))
    draw.ellipse([u - radius, v - radius, u + radius, v + radius], outline=TRUTH, width=SMOOTH)
    star = [(k * math.pi / 5, 8.0 if k % 2 == 0 else 3.4) for k in range(10)]
    draw.polygon([(u + size * SMOOTH * math.sin(turn), v - size * SMOOTH * math.cos(turn)) for turn, size in star], TRUTH)
    return plan


def _draw_picture(
    behind: Background, says: str, poses: Sequence[Spawn], image: np.ndarray, end: Line | None = None
) -> Image.Image:
    """Draw one picture. poses: until now; end: of the run, in the last picture alone."""
    plan, here = behind.plan.copy(), poses[-1]
    draw = ImageDraw.Draw(plan)
    path = [_larger(behind.frame.at((pose.x, pose.z))) for pose in poses]
    draw.line(path, PATH, 3 * SMOOTH, "curve")
    colour = PATH if end is None else RIGHT if end.verdict == FOUND else WRONG
    size, (u, v) = (7.0 if end is None else 10.0) * SMOOTH, path[-1]
    turns = [math.radians(here.yaw_deg + turn) for turn in (0, 145, 215)]
    draw.polygon([(u + size * math.sin(turn), v - size * math.cos(turn)) for turn in turns], colour, PAPER, SMOOTH // 2)
    picture = Image.new("RGB", (2 * PANEL_PX + 3 * GAP_PX, PANEL_PX + GAP_PX + CAPTION_PX), PAPER)
    seen = Image.fromarray(image).resize((PANEL_PX, PANEL_PX), Image.Resampling.LANCZOS)
    picture.paste(seen, (GAP_PX, GAP_PX))
    small = plan.resize((PANEL_PX, PANEL_PX), Image.Resampling.LANCZOS)
    picture.paste(small, (PANEL_PX + 2 * GAP_PX, GAP_PX))
    write = ImageDraw.Draw(picture)
    if end is not None:
        write.rectangle([GAP_PX, GAP_PX, GAP_PX + PANEL_PX - 1, GAP_PX + PANEL_PX - 1], outline=colour, width=5)
    for text, size_pt, down, ink in ((behind.query, 18, 8, INK), (says, 13, 33, SOFT if end is None else colour)):
        write.text((GAP_PX, GAP_PX + PANEL_PX + down), text, ink, _font(text, size_pt))
    return picture


def _font(text: str, size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the font of a line, smaller if the line is too long for the picture."""
    font = ImageFont.load_default(size)
    length = font.getlength(text)
    return ImageFont.load_default(min(1.0, (2 * PANEL_PX + GAP_PX) / length) * size)


def _larger(at: Point) -> Point:
    return at[0] * SMOOTH, at[1] * SMOOTH


def _encode(pictures: Sequence[Image.Image], lasting_ms: Sequence[int]) -> bytes:
    """Return the pictures as an animated WebP, of the best quality that MOST_BYTES allows."""
    for quality in QUALITIES:
        file = BytesIO()
        options = {"append_images": pictures[1:], "duration": list(lasting_ms), "loop": 0, "quality": quality}
        pictures[0].save(file, "WEBP", save_all=True, method=4, **options)
        if file.tell() <= MOST_BYTES:
            break
    return file.getvalue()
