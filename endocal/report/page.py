"""A self-contained HTML page and its parts: light, dark and on paper, with no script and no network.

Whatever is not ``Html`` already is escaped, so that a file name or a message can hold anything.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence
from importlib.resources import files

from .._version import __version__


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


Text = str | Html
Cell = Text | int | float | None

# The browser itself refuses whatever is not in the page: scripts, and anything from a network.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"


def escape(value: Text) -> Html:
    """Return text as HTML; what is HTML already stays."""
    return value if isinstance(value, Html) else Html(html.escape(value))


def joined(parts: Iterable[Html]) -> Html:
    """Return parts one below the other."""
    return Html("\n".join(parts))


def page(title: Text, *parts: Html, subtitle: Text = "") -> Html:
    """Return a whole page: ``title`` is its heading, ``subtitle`` the line below it."""
    style = files(__package__).joinpath("style.css").read_text(encoding="utf-8")
    below = f'<p class="soft">{escape(subtitle)}</p>' if subtitle else ""
    return Html(
        f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="endocal {__version__}">
<link rel="icon" href="data:,">
<title>{escape(title)}</title>
<style>
{style}</style>
</head>
<body>
<main>
<header>
<h1>{escape(title)}</h1>
{below}
</header>
{joined(parts)}
<footer>Made by endocal {__version__}. This page is one file: it loads nothing and runs no script.</footer>
</main>
</body>
</html>
"""
    )


def section(heading: Text, *parts: Html) -> Html:
    """Return a section under a heading."""
    return Html(f"<section>\n<h2>{escape(heading)}</h2>\n{joined(parts)}\n</section>")


def paragraph(text: Text, soft: bool = False) -> Html:
    """Return a paragraph; ``soft`` for what is said by the way."""
    kind = ' class="soft"' if soft else ""
    return Html(f"<p{kind}>{escape(text)}</p>")


def bullets(items: Iterable[Text]) -> Html:
    """Return a list."""
    return Html("<ul>" + "".join(f"<li>{escape(item)}</li>" for item in items) + "</ul>")


def verdict(level: str, headline: Text, reasons: Iterable[Text] = ()) -> Html:
    """Return the box that says how it went; ``level`` is good, doubtful or failed."""
    if level not in ("good", "doubtful", "failed"):
        raise ValueError(f"level {level!r}")
    mark = {"good": "✓", "doubtful": "!", "failed": "✗"}[level]
    said = f'<strong><span aria-hidden="true">{mark}</span> {escape(headline)}</strong>'
    reasons = list(reasons)
    return Html(f'<div class="verdict {level}">{said}{bullets(reasons) if reasons else ""}</div>')


def tiles(items: Iterable[tuple[Text, Text, Text]]) -> Html:
    """Return the main numbers as tiles: (label, value, a word about it or "")."""
    cells = [
        f"<div><dt>{escape(label)}</dt><dd>{escape(value)}</dd>"
        f"{f'<dd>{escape(more)}</dd>' if more else ''}</div>"
        for label, value, more in items
    ]
    return Html('<dl class="tiles">\n' + "\n".join(cells) + "\n</dl>")


def table(heads: Sequence[Text], rows: Iterable[Sequence[Cell]]) -> Html:
    """Return a table; a column of numbers, or of numbers in words that begin so, stands to the right."""
    rows = [list(row) for row in rows]
    numeric = [
        bool(rows) and all(_is_number(row[i]) for row in rows if row[i] not in (None, ""))
        for i in range(len(heads))
    ]
    kinds = [' class="number"' if n else "" for n in numeric]
    head = "".join(
        f'<th scope="col"{kind}>{escape(text)}</th>'
        for kind, text in zip(kinds, heads, strict=True)
    )
    body = "\n".join(
        "<tr>"
        + "".join(f"<td{kind}>{_cell(v)}</td>" for kind, v in zip(kinds, row, strict=True))
        + "</tr>"
        for row in rows
    )
    return Html(
        f'<div class="scroll"><table>\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def facts(rows: Iterable[tuple[Text, Text]]) -> Html:
    """Return a table of (name, what there is to say of it)."""
    body = "\n".join(
        f'<tr><th scope="row">{escape(name)}</th><td>{escape(value)}</td></tr>'
        for name, value in rows
    )
    return Html(f'<div class="scroll"><table><tbody>\n{body}\n</tbody></table></div>')


def figure(content: Html, caption: Text = "") -> Html:
    """Return a picture or plot with its caption."""
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return Html(f"<figure>{content}{below}</figure>")


def figures(*content: Html) -> Html:
    """Return figures side by side where the page is wide enough."""
    return Html('<div class="figures">\n' + "\n".join(content) + "\n</div>")


def image(data: bytes, kind: str, alt: str, size: tuple[int, int]) -> Html:
    """Return a picture held in the page: ``kind`` such as png or jpeg, ``size`` (width, height) in px."""
    encoded = base64.b64encode(data).decode("ascii")
    return Html(
        f'<img src="data:image/{kind};base64,{encoded}" alt="{html.escape(alt)}"'
        f' width="{size[0]}" height="{size[1]}">'
    )


def key(entries: Iterable[tuple[str, Text]]) -> Html:
    """Return the key to the colours of a figure: (CSS colour, meaning)."""
    items = "".join(
        f'<li><i style="background:{html.escape(colour)}"></i>{escape(text)}</li>'
        for colour, text in entries
    )
    return Html(f'<ul class="key">{items}</ul>')


def _is_number(value: Cell) -> bool:
    if isinstance(value, int | float):
        return True
    return isinstance(value, str) and value.lstrip("+-−±")[:1].isdigit()


def _cell(value: Cell) -> Html:
    if value is None:
        return Html("")
    return escape(value if isinstance(value, str) else f"{value:g}")
