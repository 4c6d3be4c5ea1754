"""The gallery in a headless browser: filters, links, keyboard, a phone, no scripts. Skipped without Chromium."""

from __future__ import annotations

import shutil

import pytest
from playwright import sync_api as playwright

from ovman.report.show.gallery import render_gallery
from ovman.report.show.results import Results
from tests.arms import CONFIG
from tests.episodes import DATA
from tests.report.show.test_gallery import SPLIT, counts, queries, read_gallery

PHONE, DESKTOP = {"width": 360, "height": 740}, {"width": 1300, "height": 900}


@pytest.fixture(scope="module")
def browser():
    """Chromium: the system's, or the one of playwright."""
    with playwright.sync_playwright() as running:
        found = shutil.which("chromium") or shutil.which("google-chrome")
        try:
            started = running.chromium.launch(executable_path=found, args=["--no-sandbox"])
        except playwright.Error as error:
            pytest.skip(f"needs Chromium: apt install chromium, or playwright install chromium ({str(error).splitlines()[0]})")
        yield started
        started.close()


@pytest.fixture(scope="module")
def gallery(tmp_path_factory):
    """The address of the released gallery and its root."""
    folder = tmp_path_factory.mktemp("gallery")
    text = render_gallery(Results(DATA, CONFIG), SPLIT, folder)
    (folder / "index.html").write_text(text, encoding="utf-8")
    return (folder / "index.html").as_uri(), read_gallery(text)


@pytest.fixture
def visit(browser, gallery):
    """Return a function that opens the gallery with a fragment. No page may ask for a file or report an error."""
    contexts, wrong = [], []

    def visit(fragment="", **how):
        context = browser.new_context(**{"viewport": DESKTOP} | how)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("console", lambda line: wrong.append(line.text))
        page.on("request", lambda request: request.url.partition("#")[0] == gallery[0] or wrong.append(request.url))
        page.goto(gallery[0] + fragment)
        return page

    yield visit
    for context in contexts:
        context.close()
    assert wrong == []


def shown(page):
    """The number of visible cards and of visible queries, and what the page says of them."""
    cards, asked = (page.locator(f"{each}:visible").count() for each in ("article", "article > ol > li"))
    return (cards, asked), page.locator("[aria-live]").inner_text()


def expect(root, **wanted):
    """The numbers of cards and queries that fit, and the sentence about them."""
    agents = root.find(".//form").get("data-agents").split("|")
    verdict = {"failed": "0", "found": "1"}

    def fits(query):
        return all(
            query["data-found"][agents.index(value)] == verdict[name] if name in verdict else query[f"data-{name}"] == value
            for name, value in wanted.items()
        )

    all_cards, all_asked = counts(queries(root))
    cards, asked = counts(one for one in queries(root) if fits(one[1]))
    return (cards, asked), f"{cards} of {all_cards} world pairs, {asked} of {all_asked} queries"


def test_a_choice_filters_the_cards_and_can_be_linked(visit, gallery):
    page, root = visit(), gallery[1]
    assert shown(page) == expect(root)
    wanted = {"relation": "moved", "rooms": "2 rooms", "failed": "two_visits", "found": "joint"}
    for number, (name, value) in enumerate(wanted.items(), start=1):
        page.select_option(f"select[name={name}]", value)
        assert shown(page) == expect(root, **dict([*wanted.items()][:number]))
    linked = visit(page.evaluate("location.hash"))
    assert shown(linked) == shown(page) == expect(root, **wanted)
    assert linked.input_value("select[name=rooms]") == "2 rooms"
    page.get_by_role("button", name="Show all").click()
    page.wait_for_function("!location.hash.includes('=')")
    assert shown(page) == expect(root)


def test_a_changed_fragment_changes_the_view_and_nonsense_shows_all(visit, gallery):
    page, root = visit("#noun=unicorn&failed=nobody"), gallery[1]
    assert shown(page) == expect(root)
    page.evaluate("location.hash = 'noun=chair'")
    page.wait_for_function("document.querySelector('select[name=noun]').value === 'chair'")
    assert shown(page) == expect(root, noun="chair")


def test_the_keyboard_is_enough(visit, gallery):
    page, root = visit(), gallery[1]
    labels = []
    for _ in range(5):
        page.keyboard.press("Tab")
        labels.append(page.evaluate("document.activeElement.labels[0].firstChild.textContent.trim()"))
    assert labels == ["Relation", "Noun", "Rooms", "Failed by", "Found by"]
    page.focus("select[name=relation]")
    page.keyboard.press("ArrowDown")
    assert shown(page) == expect(root, relation=page.input_value("select[name=relation]")) != expect(root)
    for _ in range(6):
        page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.tagName") == "SUMMARY"
    page.keyboard.press("Enter")
    assert page.locator("details[open]").count() == 1


def test_a_phone_never_scrolls_sideways_and_reads_well(visit):
    page = visit("#relation=moved", viewport=PHONE)
    page.evaluate("document.querySelectorAll('article:not([hidden]) details').forEach(one => one.open = true)")
    assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
    heights = page.evaluate("[...document.querySelectorAll('select, button')].map(one => one.getBoundingClientRect().height)")
    assert min(heights) >= 40
    plan = page.locator("article:visible .plan").first
    assert plan.bounding_box()["width"] > 280


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_words_stand_out_from_what_is_behind_them(visit, scheme):
    page = visit(color_scheme=scheme)
    ratios = page.evaluate(
        """() => {
          const light = (text) => { const [r, g, b] = text.match(/[0-9.]+/g).map((v) => v / 255)
            .map((v) => v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4); return .2126 * r + .7152 * g + .0722 * b; };
          const back = light(getComputedStyle(document.querySelector('article')).backgroundColor);
          return ['p', '.facts', '.tag', '.found', '.failed', 'summary'].map((name) => {
            const ink = light(getComputedStyle(document.querySelector('article ' + name)).color);
            return (Math.max(ink, back) + .05) / (Math.min(ink, back) + .05); });
        }"""
    )
    assert min(ratios) >= 4.5


def test_without_scripts_every_card_is_there(visit, gallery):
    page = visit("#relation=moved", java_script_enabled=False)
    assert page.locator("article:visible").count() == expect(gallery[1])[0][0]
    assert not page.locator("form").is_visible() and page.locator("noscript p").is_visible()
