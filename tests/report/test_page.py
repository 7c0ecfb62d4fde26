"""A page is one file that loads nothing, whatever the text in it."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.report import figures
from endocal.report import page as p

# What a browser would fetch, and where that may stand.
_FETCHING = ("src", "href", "xlink:href", "srcset", "data", "poster", "action")
PLOTTED = ("blue", "orange", "green", "red", "yellow", "violet")
_VOID = {"meta", "link", "img", "br", "hr", "input"}


class Reading(HTMLParser):
    """The tags that are open, the text, and the addresses that a browser would fetch."""

    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.addresses: list[str] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag not in _VOID:
            self.open.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in _FETCHING]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in _FETCHING]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def a_plot() -> p.Html:
    pytest.importorskip("matplotlib")

    def draw(axes: object) -> None:
        axes.plot([1, 2, 3], [1, 4, 9], color=figures.BLUE)  # type: ignore[attr-defined]
        axes.set_xlabel("diameter, px")  # type: ignore[attr-defined]

    return figures.plot(draw, 'a curve that "rises"')


def a_page(text: str) -> p.Html:
    return p.page(
        text,
        p.verdict("doubtful", text, [text]),
        p.tiles([(text, text, text)]),
        p.section(text, p.paragraph(text), p.table([text, "n"], [[text, 3], [text, None]])),
        p.figures(p.figure(p.image(b"\x00", "png", text, (1, 1)), text), p.figure(a_plot(), text)),
        p.key([("var(--red)", text)]),
        subtitle=text,
    )


@given(st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1))
def test_any_text_comes_out_as_text(text: str) -> None:
    read = Reading(p.escape(text))
    assert "".join(read.texts) == text
    assert not read.tags


def test_a_hostile_file_name_stays_text() -> None:
    name = "<script>alert(1)</script>\"'&.png"
    read = Reading(a_page(name))
    assert not read.open
    assert "script" not in read.tags
    assert read.texts.count(name) >= 10


def test_a_page_loads_nothing() -> None:
    page = a_page("board.png")
    for address in Reading(page).addresses:
        assert address.startswith(("data:", "#")), address
    assert "@import" not in page
    assert re.findall(r"url\((?!#)", page) == []
    assert "default-src 'none'" in page


def test_numbers_stand_to_the_right() -> None:
    table = p.table(["setting", "departure"], [["wide.png", "+0.1 %"], ["tele.png", "−0.2 %"]])
    assert table.count('<td class="number">') == 2
    assert '<td class="number">+0.1 %</td>' in table


def test_a_plot_repeats_itself_and_takes_the_colours_of_the_page() -> None:
    first, again = a_plot(), a_plot()
    assert first == again
    assert "var(--blue)" in first
    assert not re.search(r"#0000[01][0-9a-f]", first)
    assert ">diameter, px</text>" in first
    assert 'aria-label="a curve that &quot;rises&quot;"' in first
    assert "<style" not in first


def _luminance(colour: str) -> float:
    """Relative luminance, WCAG 2.2."""
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
def test_text_and_lines_stand_out_enough(scheme: int) -> None:
    # WCAG 2.2 AA for text, which is more than what a plot needs.
    colours = {
        name: found[scheme]
        for name in ("surface", "raised", "ink", "soft", *PLOTTED)
        if (found := re.findall(rf"--{name}: (#[0-9a-f]{{6}})", p.page("colours")))
    }
    for ground in ("surface", "raised"):
        for name in ("ink", "soft", "green", "red", "yellow", "blue", "orange", "violet"):
            light, dark = sorted((_luminance(colours[ground]), _luminance(colours[name])))[::-1]
            assert (light + 0.05) / (dark + 0.05) >= 4.5, f"{name} on {ground}"


def test_every_colour_of_a_plot_is_one_of_the_page() -> None:
    page = p.page("colours")
    for name in figures._NAMES.values():
        assert page.count(f"--{name}:") == 2, f"{name}: once for light, once for dark"
