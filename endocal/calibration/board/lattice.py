"""The numbers of a chessboard's rows and columns: which of the lines found are pieces of one.

A line that the model at hand cannot straighten is found in pieces. Between two corners next to each other on
a line lies one square, so that from one crossing to the next every line can be numbered, however it bends.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..straightness import Floats, Labels

# A line is numbered by at least this share of its crossings with lines numbered before it.
MOST_AGREE = 0.6
# Numbers are right that explain this share of all crossings. Till then they begin with one after the other of
# so many lines, those with most crossings.
ENOUGH_EXPLAINED, MOST_ROOTS = 0.8, 8
# Pieces of one line that both show a corner put it within this many px of each other.
SAME_CORNER = 8.0


@dataclass(frozen=True)
class Crossings:
    """Where lines cross: labels (m, 2) of the two, rank (m, 2) of the corner among those of each line.

    ``turn`` (m,) is +1 where the second line runs to the left of the first one, -1 to its right; ``places``
    (m, 2) px.
    """

    lines: Labels
    ranks: Labels
    turn: Labels
    places: Floats

    def of_each(self) -> dict[int, list[tuple[int, int, int, int]]]:
        """For each line: its own rank, the other line, that one's rank, and the turn, at each crossing."""
        out: dict[int, list[tuple[int, int, int, int]]] = {}
        for (a, b), (i, j), turn in zip(
            self.lines.tolist(), self.ranks.tolist(), self.turn.tolist(), strict=True
        ):
            out.setdefault(a, []).append((i, b, j, turn))
            out.setdefault(b, []).append((j, a, i, -turn))
        return out


@dataclass(frozen=True)
class _Number:
    """Line ``number`` of the rows (0) or columns (1); its corner of rank r is on line start + way r."""

    family: int
    number: int
    way: int
    start: int


def joined(crossings: Crossings, count: int) -> Labels:
    """Return for each of ``count`` lines the line that it is a piece of, itself where it is whole."""
    numbers = _numbers(crossings.of_each())
    corners = _corners(crossings, numbers)
    becomes = np.arange(count)
    pieces: dict[tuple[int, int], list[int]] = {}
    # The longest piece of each gathers the others.
    for line in sorted(corners, key=lambda i: -len(corners[i])):
        others = pieces.setdefault((numbers[line].family, numbers[line].number), [])
        if all(_agree(corners[line], corners[other]) for other in others):
            becomes[line] = others[0] if others else line
            others.append(line)
    return becomes


def places_of(crossings: Crossings) -> tuple[Labels, NDArray[np.bool_]]:
    """Return each crossing's place (m, 2) on the board, row and column, and which (m,) have one.

    Rows and columns are told apart by their directions alone, and numbered from an arbitrary first one.
    """
    numbers = _numbers(crossings.of_each())
    places = np.zeros((len(crossings.lines), 2), np.intp)
    known = np.zeros(len(crossings.lines), bool)
    for i, pair in enumerate(crossings.lines.tolist()):
        of = [numbers[line] for line in pair if line in numbers]
        if len(of) == 2 and of[0].family != of[1].family:
            known[i] = True
            for number in of:
                places[i, number.family] = number.number
    return places, known


def numbers_of(crossings: Crossings, count: int) -> tuple[Labels, Labels]:
    """Return of each of ``count`` lines its family (count,), row 0 or column 1, and its number (count,).

    The family of a line without a number is -1. Numbers are as ``places_of`` has them.
    """
    families, numbers = np.full(count, -1), np.zeros(count, np.intp)
    for line, number in _numbers(crossings.of_each()).items():
        families[line], numbers[line] = number.family, number.number
    return families, numbers


def _numbers(met: dict[int, list[tuple[int, int, int, int]]]) -> dict[int, _Number]:
    """Number the lines, each by the majority of its crossings, in the way that explains most crossings.

    A line that goes on into something else crosses what it should not. Numbers that begin with it explain
    little more than itself; those that begin elsewhere outvote it.
    """
    best: dict[int, _Number] = {}
    most, enough = -1, ENOUGH_EXPLAINED * sum(len(crossings) for crossings in met.values())
    for root in sorted(met, key=lambda i: -len(met[i]))[:MOST_ROOTS]:
        numbers = _numbered_from(root, met)
        explained = _explained(met, numbers)
        if explained > most:
            best, most = numbers, explained
        if most >= enough:
            break
    return best


def _explained(met: dict[int, list[tuple[int, int, int, int]]], numbers: dict[int, _Number]) -> int:
    """How many crossings, counted on both lines, are those of lines with these numbers."""
    count = 0
    for line, number in numbers.items():
        for rank, other, _, _ in met[line]:
            its = numbers.get(other)
            if its is not None and its.family != number.family:
                count += its.number == number.start + number.way * rank
    return count


def _numbered_from(
    root: int, met: dict[int, list[tuple[int, int, int, int]]]
) -> dict[int, _Number]:
    """Number the lines from one on."""
    votes: dict[int, Counter[_Number]] = {root: Counter([_Number(0, 0, 1, 0)])}
    numbers: dict[int, _Number] = {}
    while votes:
        line = max(votes, key=lambda i: votes[i].most_common(1)[0][1])
        cast = votes.pop(line)
        best, agree = cast.most_common(1)[0]
        if agree < MOST_AGREE * cast.total():
            continue
        numbers[line] = best
        for rank, other, its_rank, turn in met[line]:
            if other in numbers:
                continue
            # Seen along a row's numbering, columns run to one side, as in any picture of a board.
            way = best.way * turn * (1 if best.family == 0 else -1)
            number = best.start + best.way * rank
            vote = _Number(1 - best.family, number, way, best.number - way * its_rank)
            votes.setdefault(other, Counter())[vote] += 1
    return numbers


def _corners(
    crossings: Crossings, numbers: dict[int, _Number]
) -> dict[int, dict[int, tuple[float, float]]]:
    """For each numbered line its corners' places, by the number of the crossing line."""
    out: dict[int, dict[int, tuple[float, float]]] = {}
    for lines, ranks, (x, y) in zip(
        crossings.lines.tolist(), crossings.ranks.tolist(), crossings.places.tolist(), strict=True
    ):
        for line, rank in zip(lines, ranks, strict=True):
            if line in numbers:
                at = numbers[line].start + numbers[line].way * rank
                out.setdefault(line, {})[at] = (x, y)
    return out


def _agree(ones: dict[int, tuple[float, float]], others: dict[int, tuple[float, float]]) -> bool:
    """Whether two pieces put the corners that both show in the same places."""
    return all(math.dist(ones[i], others[i]) < SAME_CORNER for i in ones.keys() & others.keys())
