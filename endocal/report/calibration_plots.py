"""The plots of a calibration's page."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import zoom

from ..calibration.fit.plumb_line import robust_sigma
from ..calibration.image.edges import sobel_gradients
from ..calibration.methods.vote_maps import ANGLES, vote_maps
from ..calibration.objective import cost_of, region_of
from ..calibration.outcome import Workings
from ..calibration.spec import CalibrationSpec
from ..calibration.straightness import Floats
from ..model import DivisionModel
from .figures import BLUE, GREEN, INK, ORANGE, SOFT, heat, plot
from .page import Html
from .sureness import parameters, placing_sigma

# Samples of the entropy along lambda, and along each side of the centre's region; fewer where the measure
# is slow.
_CURVE, _MAP, _SLOW_MAP = 121, 33, 13
_SLOW = ("heplp", "hewog", "cht")
# How much finer the map of the entropy is drawn.
_ENLARGED = 6
# Columns of the map of residuals over the frame; a cell with fewer points than this stays empty.
_COLUMNS, _FEWEST = 24, 3
# Its scale of colours ends where so large a share of the cells lies below.
_SCALE_SHARE = 0.97
# The plot of how surely points are placed ends at so many times what holds at the outermost lines.
_STEEPEST = 4.0
# Histograms reach so many robust standard deviations to both sides.
_HISTOGRAM_REACH = 5.0


def histogram(residuals: Floats, sigma: float) -> Html:
    """Return the histogram of residuals (n,) px with the normal curve of ``sigma`` px."""
    edge = _HISTOGRAM_REACH * max(sigma, 1e-4)
    inside = residuals[np.abs(residuals) <= edge]

    def draw(axes: Any) -> None:
        counts, edges, _ = axes.hist(inside, bins=61, range=(-edge, edge), color=BLUE, alpha=0.75)
        x = np.linspace(-edge, edge, 201)
        width = edges[1] - edges[0]
        y = len(residuals) * width * np.exp(-0.5 * (x / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
        axes.plot(x, y, color=ORANGE, label=f"normal, σ = {sigma:.3f} px")
        axes.set_xlabel("distance of an edge point from its line, px")
        axes.set_ylabel("edge points")
        axes.set_ylim(0, 1.18 * max(counts.max(), y.max()))
        axes.legend(loc="upper right")

    return plot(
        draw,
        f"Histogram of {len(residuals)} residuals: their standard deviation is {sigma:.3f} px.",
    )


def spread_over_frame(
    points: Floats, residuals: Floats, size: tuple[float, float]
) -> tuple[Floats, Floats, Floats]:
    """Return the robust standard deviation of residuals (n,) in the cells of a grid over the frame.

    As the edges of the cells in x and in y, px, and an array (rows, columns); NaN in cells with few points.
    """
    rows = max(1, round(_COLUMNS * size[1] / size[0]))
    x, y = np.linspace(0, size[0], _COLUMNS + 1), np.linspace(0, size[1], rows + 1)
    cell = np.clip((points // (x[1], y[1])).astype(np.intp), 0, (_COLUMNS - 1, rows - 1))
    number = cell[:, 1] * _COLUMNS + cell[:, 0]
    order = np.argsort(number, kind="stable")
    cells, starts = np.unique(number[order], return_index=True)
    spread = np.full(rows * _COLUMNS, np.nan)
    for i, values in zip(cells, np.split(residuals[order], starts[1:]), strict=True):
        if len(values) >= _FEWEST:
            spread[i] = robust_sigma(values)
    return x, y, spread.reshape(rows, _COLUMNS)


def residual_map(points: Floats, residuals: Floats, size: tuple[float, float]) -> Html:
    """Return the map of the residuals' robust size, px, over the frame of ``size`` px."""
    x, y, spread = spread_over_frame(points, residuals, size)
    known = spread[np.isfinite(spread)]
    worst = float(known.max()) if len(known) else 0.0
    # A few cells on what is no line must not make all others pale.
    top = float(np.quantile(known, _SCALE_SHARE)) if len(known) else 1.0

    def draw(axes: Any) -> None:
        mesh = axes.pcolormesh(x, y, spread, cmap=heat(), vmin=0, vmax=top)
        _as_frame(axes, size)
        more = "max" if worst > top else "neither"
        bar = axes.figure.colorbar(mesh, ax=axes, shrink=0.85, pad=0.02, extend=more)
        bar.outline.set_visible(False)
        bar.set_label("px", color=SOFT)

    return plot(
        draw, f"Map of the residuals over the frame: at most {worst:.3f} px in any part of it."
    )


def ellipse(workings: Workings, model: DivisionModel) -> Html:
    """Return the ellipses of one, two and three standard deviations of the centre."""
    assert workings.covariance is not None
    covariance = workings.covariance[1:3, 1:3]
    cx, cy = parameters(model)[1:3]
    values, vectors = np.linalg.eigh(covariance)
    turn = np.linspace(0, 2 * np.pi, 181)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    ring = vectors @ (np.sqrt(np.maximum(values, 0))[:, None] * circle)

    def draw(axes: Any) -> None:
        for times in (3, 2, 1):
            axes.fill(*(times * ring), color=BLUE, alpha=0.25, lw=0)
        axes.plot([0], [0], "+", color=INK, markersize=9)
        axes.set_aspect("equal", "datalim")
        axes.invert_yaxis()
        axes.set_xlabel(f"x from {cx:.2f} px")
        axes.set_ylabel(f"y from {cy:.2f} px")

    sx, sy = np.sqrt(np.diag(covariance))
    return plot(
        draw,
        f"Ellipses of 1, 2 and 3 standard deviations of the centre: {sx:.3f} px in x, {sy:.3f} px in y.",
    )


def placing(
    workings: Workings, model: DivisionModel, lines: float, content: float
) -> tuple[Html, float]:
    """Return how surely points out to the content's radius are placed, as a plot; and at the lines', px.

    ``lines`` and ``content`` px: how far the outermost lines and the farthest content lie from the centre.
    """
    params = parameters(model)
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rays = np.stack([np.cos(turn), np.sin(turn)], axis=1)

    def spread(radii: Floats) -> Floats:
        points = params[1:3] + radii[:, None, None] * rays
        sigma = placing_sigma(workings, model, points.reshape(-1, 2))
        return sigma.reshape(len(radii), -1)

    radii = np.linspace(0, max(content, lines), 60)
    sigma = spread(radii)
    low, high = sigma.min(axis=1), sigma.max(axis=1)
    there = float(spread(np.array([lines])).max())

    def draw(axes: Any) -> None:
        axes.fill_between(radii, low, high, color=BLUE, alpha=0.3, lw=0)
        axes.plot(radii, high, color=BLUE)
        axes.axvline(lines, color=ORANGE, lw=1.4, ls=(0, (4, 3)), label="outermost lines")
        axes.set_xlim(0, radii[-1])
        # Near a fold it grows without bound.
        axes.set_ylim(0, max(min(float(high[-1]), _STEEPEST * there), 1e-3))
        axes.set_xlabel("distance from the centre in the picture, px")
        axes.set_ylabel("± px in the corrected picture")
        axes.legend(loc="upper left")

    svg = plot(
        draw,
        "How surely a point is placed in the corrected picture, over its distance from the centre:"
        f" ± {there:.2g} px at the outermost lines.",
    )
    return svg, there


def entropy_over_lambda(workings: Workings, spec: CalibrationSpec, model: DivisionModel) -> Html:
    """Return the search's entropy over lambda, the centre being the model's."""
    region, cost = region_of(workings.scene), cost_of(workings.scene, spec)
    params = parameters(model)
    low = min(region.lam[0], 1.2 * params[0])
    lams = np.linspace(low, max(-0.1 * low, 1.2 * params[0]), _CURVE)
    values = cost(lams, params[1:2], params[2:3])[:, 0, 0]

    def draw(axes: Any) -> None:
        axes.plot(lams * 1e6, values, color=BLUE)
        axes.axvline(params[0] * 1e6, color=GREEN, lw=1.4, label="result")
        if workings.refined is not None:
            found = workings.found.params[0] * 1e6
            axes.axvline(found, color=ORANGE, lw=1.4, ls=(0, (4, 3)), label="search")
        axes.set_xlabel("λ, 10⁻⁶ px⁻²")
        axes.set_ylabel("entropy")
        axes.legend(loc="best")

    least = lams[int(np.argmin(values))]
    return plot(
        draw,
        f"The entropy over lambda: least at {least:.3g} px^-2; the result is {params[0]:.4g} px^-2.",
    )


def entropy_over_center(workings: Workings, spec: CalibrationSpec, model: DivisionModel) -> Html:
    """Return the search's entropy over the centre, lambda being the model's."""
    scene, found, params = workings.scene, workings.found.params, parameters(model)
    region, cost = region_of(scene), cost_of(scene, spec)
    n = _SLOW_MAP if spec.method in _SLOW else _MAP
    margin = 0.15 * np.array([np.ptp(region.x), np.ptp(region.y)])
    xs, ys = (
        np.linspace(min(low, params[1 + i]) - margin[i], max(high, params[1 + i]) + margin[i], n)
        for i, (low, high) in enumerate((region.x, region.y))
    )
    values = cost(params[:1], xs, ys)[0]

    def draw(axes: Any) -> None:
        axes.imshow(
            zoom(-values.T, _ENLARGED, order=1),
            cmap=heat(),
            extent=(xs[0], xs[-1], ys[-1], ys[0]),
            interpolation="none",
        )
        axes.plot(*scene.prior.center, "x", color=INK, ms=7, label="middle of the picture")
        if workings.refined is not None:
            axes.plot(*found[1:3], "s", mfc="none", mec=ORANGE, mew=1.6, ms=8, label="search")
        axes.plot(*params[1:3], "o", mfc="none", mec=GREEN, mew=1.8, ms=9, label="result")
        axes.grid(False)
        axes.set_xlabel("centre x, px")
        axes.set_ylabel("centre y, px")
        axes.legend(loc="upper center", bbox_to_anchor=(0.45, -0.16), ncols=3)

    i, j = np.unravel_index(int(np.argmin(values)), values.shape)
    return plot(
        draw,
        f"The entropy over the centre: least near {xs[i]:.0f}, {ys[j]:.0f} px;"
        f" the result is {params[1]:.1f}, {params[2]:.1f} px.",
    )


def vote_plots(workings: Workings, spec: CalibrationSpec, model: DivisionModel) -> list[Html]:
    """Return H1 before and after, then H2 before and after, of the first picture's edges."""
    scene, params = workings.scene, parameters(model)
    view = scene.views[0]
    gradients = sobel_gradients(view.grey, view.edges.points, spec.sobel)
    straight = np.array([0.0, *params[1:3]])
    maps = [
        vote_maps(view.edges.points, gradients, p, scene.square_size) for p in (straight, params)
    ]
    plots = []
    for name, moment in zip(maps, ("before", "after"), strict=True):
        extent = (0, 180, -name.reach, name.reach)
        alt = f"Votes of the edge points for lines, {moment} correction."
        plots.append(
            _votes(name.first, extent, "direction of the normal θ, °", "offset r, px", alt)
        )
    for name, moment in zip(maps, ("before", "after"), strict=True):
        alt = f"Votes of the lines for vanishing points, {moment} correction."
        plots.append(_votes(name.second, (0, 180, 0, 180), "ω, °", "ρ, °", alt))
    return plots


def _votes(
    votes: NDArray[Any], extent: tuple[float, float, float, float], x: str, y: str, alt: str
) -> Html:
    def draw(axes: Any) -> None:
        strength = np.sqrt(votes / max(float(np.quantile(votes[votes > 0], 0.999)), 1.0))
        axes.imshow(
            np.clip(strength, 0, 1),
            cmap=heat(),
            vmin=0,
            vmax=1,
            extent=extent,
            origin="lower",
            aspect="auto",
            interpolation="none",
        )
        axes.grid(False)
        axes.set_xlabel(x)
        axes.set_ylabel(y)
        axes.set_xticks(range(0, 181, 45))
        if extent[3] == ANGLES:
            axes.set_yticks(range(0, 181, 45))

    return plot(draw, alt)


def _as_frame(axes: Any, size: tuple[float, float]) -> None:
    """Show axes as the frame: y down, equal steps, a thin border."""
    axes.set_xlim(0, size[0])
    axes.set_ylim(size[1], 0)
    axes.set_aspect("equal")
    axes.grid(False)
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)
    axes.set_xlabel("x, px")
    axes.set_ylabel("y, px")
