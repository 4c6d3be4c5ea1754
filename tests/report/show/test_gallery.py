"""The gallery of a split: every world pair with its queries, filters that agree with the records, sound HTML."""

from __future__ import annotations

import csv
import json
import re
import shutil
from collections import defaultdict

import pytest

from ovman import cli
from ovman.report.show.gallery import render_gallery
from ovman.report.show.results import Results
from tests.arms import CONFIG
from tests.episodes import DATA, ROOT
from tests.report.show.pages import classes, of_class, read, words

SPLIT = "everyday"


@pytest.fixture(scope="module")
def gallery(tmp_path_factory):
    """Text and root of the released gallery."""
    text = render_gallery(Results(DATA, CONFIG), SPLIT, tmp_path_factory.mktemp("pages"))
    return text, read_gallery(text)


@pytest.fixture(scope="module")
def records():
    """Raw episodes, the number of rooms by home, and by agent and episode whether all its runs succeed."""
    episodes = [json.loads(line) for line in (DATA / "episodes" / f"{SPLIT}.jsonl").read_text().splitlines()]
    scenes = [json.loads(line) for line in (DATA / "scenes" / f"{SPLIT}.jsonl").read_text().splitlines()]
    found = defaultdict(lambda: defaultdict(lambda: True))
    for kind in ("static", "embodied"):
        with (DATA / "metrics" / SPLIT / f"{kind}_outcomes.csv").open(newline="") as file:
            for row in csv.DictReader(file):
                found[row["arm"]][row["episode"]] &= float(row["success"]) == 1
    return episodes, {scene["scene"]: len(scene["rooms"]) for scene in scenes}, found


@pytest.fixture
def few(tmp_path):
    """The records of the first world pair alone, to be changed, and the folder of them."""
    root = tmp_path / "results"
    for stage in ("episodes", "scenes"):
        (root / stage).mkdir(parents=True)
    shutil.copy(DATA / "scenes" / f"{SPLIT}.jsonl", root / "scenes")
    every = [json.loads(line) for line in (DATA / "episodes" / f"{SPLIT}.jsonl").read_text().splitlines()[:20]]
    return root, [record for record in every if record["pair"] == every[0]["pair"]]


def write(root, episodes):
    """Write the episodes of the split."""
    (root / "episodes" / f"{SPLIT}.jsonl").write_text("".join(json.dumps(one) + "\n" for one in episodes))


def read_gallery(text):
    """The root of a gallery. The text of its script is not XML, so it is left out."""
    return read(re.sub(r"(?s)(<script>).*(</script>)", r"\1\2", text))


def queries(root):
    """Card, and relation, noun, rooms and verdicts of each of its queries, as the filters read them."""
    for card in root.iter("article"):
        for row in card.iterfind("ol/li"):
            yield card, {**row.attrib, "data-rooms": card.get("data-rooms")}


def counts(pairs):
    """The number of different cards and that of queries among (card, query)."""
    pairs = list(pairs)
    return len({card for card, _ in pairs}), len(pairs)


def test_every_world_pair_has_a_card_with_its_queries(gallery, records):
    cards = {card.find("h2").get("id"): card for card in gallery[1].iter("article")}
    asked = defaultdict(list)
    for episode in records[0]:
        asked[episode["pair"]].append((episode["relation"], episode["noun"], episode["sentence"]))
    assert {*cards} == {*asked}
    for pair, card in cards.items():
        rows = card.findall("ol/li")
        assert [(row.get("data-relation"), row.get("data-noun")) for row in rows] == [(one, noun) for one, noun, _ in asked[pair]]
        assert all(sentence in words(row) for row, (_, _, sentence) in zip(rows, asked[pair], strict=True))


def test_every_filter_counts_what_the_records_have(gallery, records):
    root, (episodes, rooms, found) = gallery[1], records
    agents = root.find(".//form").get("data-agents").split("|")
    assert {*agents} == {*found}
    shown, options = list(queries(root)), 0
    for select in root.iter("select"):
        name = select.get("name")
        for option in (option for option in select.iter("option") if option.get("value")):
            value, options = option.get("value"), options + 1
            if name in ("found", "failed"):
                sign = {"found": "1", "failed": "0"}[name]
                here = counts(one for one in shown if one[1]["data-found"][agents.index(value)] == sign)
                wanted = [one for one in episodes if one["id"] in found[value] and found[value][one["id"]] == (name == "found")]
            else:
                here = counts(one for one in shown if one[1][f"data-{name}"] == value)
                wanted = [one for one in episodes if value in (one.get(name), f"{rooms[one['scene']]} room")]
                if value == "2 rooms":
                    wanted = [one for one in episodes if rooms[one["scene"]] == 2]
            assert here == counts((one["pair"], one) for one in wanted), (name, value)
            assert words(option).endswith(f"({len(wanted)})")
    kinds = sum(len({one[name] for one in episodes}) for name in ("relation", "noun")) + len(
        {rooms[one["scene"]] for one in episodes}
    )
    assert options == kinds + 2 * len(found)


def test_names_next_to_a_query_are_those_of_its_verdicts(gallery):
    root = gallery[1]
    titles = {option.get("value"): re.sub(r" \(\d+\)$", "", words(option)) for option in root.iter("option")}
    agents = root.find(".//form").get("data-agents").split("|")
    assert len({titles[agent] for agent in agents}) == len(agents)
    for row in (row for card in [*root.iter("article")][:5] for row in card.iterfind("ol/li")):
        found, failed = (
            {re.sub(r" \([^)]*\)$", "", name) for name in words(part).partition(": ")[2].split("; ")}
            for part in row.findall("details/p")
        )
        for sign, names in (("1", found), ("0", failed)):
            wanted = {titles[agent] for agent, verdict in zip(agents, row.get("data-found"), strict=True) if verdict == sign}
            assert wanted == names - {"no agent"}


def test_the_page_is_one_small_file_that_needs_no_network(gallery):
    text, root = gallery
    assert len(text.encode()) < 5_000_000 and "://" not in text and "url(" not in text
    assert not [element for element in root.iter() if element.get("src") or element.tag == "link"]
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert len({*ids}) == len(ids) and {card.get("aria-labelledby") for card in root.iter("article")} <= {*ids}
    assert root.find(".//form").get("hidden") and root.find(".//*[@aria-live]") is not None
    assert len(root.findall(".//label/select")) == len([*root.iter("select")]) > 0
    assert all(svg.get("role") == "img" and svg.get("aria-label") for svg in root.iter("svg"))
    style = words(root.find("head/style"))
    drawn = {name for svg in root.iter("svg") for element in svg.iter() for name in classes(element)}
    assert {name for name in drawn if f".{name}" not in style} == set()


def test_every_query_has_its_number_on_the_plan_that_it_asks_about(gallery, records):
    past = {episode["relation"] for episode in records[0]} & {"former", "removed"}
    for card in gallery[1].iter("article"):
        first, second = ({pin.get("data-query") for pin in of_class(svg, "pin")} for svg in card.iter("svg"))
        rows = card.findall("ol/li")
        assert first == {row.get("value") for row in rows if row.get("data-relation") in past}
        assert second == {row.get("value") for row in rows} - first


def test_records_without_metrics_give_a_gallery_without_agents(few, tmp_path):
    root, episodes = few
    write(root, episodes)
    page = read_gallery(render_gallery(Results(root, CONFIG), SPLIT, tmp_path))
    assert counts(queries(page)) == (1, len(episodes))
    assert {select.get("name") for select in page.iter("select")} == {"relation", "noun", "rooms"}


def test_text_of_records_is_escaped(few, tmp_path):
    root, episodes = few
    evil = "<script>alert('x')</script> & \"y\" </svg></style>"
    write(root, [one | {"sentence": evil} for one in episodes])
    text = render_gallery(Results(root, CONFIG), SPLIT, tmp_path)
    assert text.count("<script") == 1 and evil in words(read_gallery(text).find(".//article"))


def test_pages_that_are_there_are_linked_and_others_have_a_command(few, tmp_path, capsys):
    root, episodes = few
    write(root, episodes)
    command = ["gallery", "--results", str(root), "--config", str(ROOT / "config.yaml"), "--out", str(tmp_path / "a b")]
    page = tmp_path / "a b" / f"{episodes[1]['id']}.html"
    assert cli.main(command) == 0
    before = read_gallery((tmp_path / "a b" / "index.html").read_text())
    assert before.find(".//article//a") is None and f"--output '{tmp_path}/a b'" in words(before.find(".//pre"))
    page.parent.mkdir(parents=True)
    page.write_text("")
    assert cli.main(command) == 0
    after = read_gallery((tmp_path / "a b" / "index.html").read_text())
    (link,) = after.findall(".//article//a")
    assert (tmp_path / "a b" / link.get("href")).samefile(page) and words(link) == episodes[1]["sentence"]
    capsys.readouterr()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--split", "nowhere"], "no episodes of split nowhere; there are those of everyday"),
        (["--results", "nowhere"], "make tables"),
        (["--runs", "nowhere"], "nowhere"),
    ],
)
def test_the_command_says_in_one_line_why_there_is_no_gallery(few, tmp_path, capsys, arguments, says):
    root, episodes = few
    write(root, episodes)
    given = [] if "--results" in arguments else ["--results", str(root)]
    assert cli.main(["gallery", "--out", str(tmp_path), *given, *arguments]) == 1
    printed = capsys.readouterr()
    assert says in printed.err and printed.err.count("\n") == 1 and printed.out == ""
