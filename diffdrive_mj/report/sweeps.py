"""Pictures of sweeps: the fan of errors along the way, how many robots exceed a limit, the budget of tolerances."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import quantity
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.report import plots
from diffdrive_mj.report.figures import WIDTH, Picture, figure, legend_below, panel
from diffdrive_mj.sweeps._units import in_words, varied_in_words
from diffdrive_mj.sweeps.budgets import Budget
from diffdrive_mj.sweeps.percentiles import Estimate, share_of
from diffdrive_mj.sweeps.trials import Trials

# The shares of a fan, and how dark each band is: they can be told apart without colour.
BANDS = {0.5: "#0072B2", 0.9: "#66AAD1", 0.99: "#CCE3F0"}
_ALONG, _DRAWN, _POINTS = "position_along", 12, 80


def fan(ax: Axes, trials: Trials) -> Axes:
    """Draw under which position error half, 90 % and 99 % of the robots stay along their way.

    Args:
        ax: to draw into.
        trials: with the figure "position_along"; with "distance" too the way is in metres.

    Returns:
        The axes.

    Raises:
        UnknownName: the figure was not kept.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> spread = {"robot.radius_ratio": dd.sweeps.Normal(mean=1.0, sigma=0.005)}
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 1.0})
        >>> kept, truth = ("position_along", "distance"), "kinematics"
        >>> study = dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=50, truth=truth, figures=kept)
        >>> made, ax = dd.plots.figure("A finding")
        >>> fan(ax, dd.sweep(study)).get_xlabel()
        'distance driven [m]'
    """
    errors = 1e3 * trials.sizes(_ALONG)
    way, label = np.linspace(0, 100, errors.shape[1]), "share of the way [%]"
    if "distance" in trials.figures:
        way, label = way / 100 * float(np.median(trials.figures["distance"][trials.ok])), "distance driven [m]"
    below = np.zeros_like(way)
    for share, colour in BANDS.items():
        edge = 1e3 * trials.percentile(_ALONG, share).value
        ax.fill_between(way, below, edge, color=colour, linewidth=0, label=f"{100 * share:g} % of the robots")
        below = edge
    lost = np.isinf(errors[:, -1])
    ax.plot(way, errors[~lost][:_DRAWN].T, color="0.25", linewidth=0.6)
    ax.plot([], [], color="0.25", linewidth=0.6, label="some of them")
    found = trials.percentile(_ALONG, max(BANDS))
    for edge in (found.low, found.high):
        ax.plot(way, 1e3 * np.where(np.isfinite(edge), edge, np.nan), **plots.PREDICTION)
    ax.plot([], [], label="limits of the 99th percentile (95 %)", **plots.PREDICTION)
    ax.set(xlabel=label, ylabel="position error [mm]", ylim=(0, None))
    ax.margins(x=0)
    ax.legend(loc="upper left", frameon=False, fontsize=9.5)
    return plots.tidy(ax)


def exceedance_curve(ax: Axes, trials: Trials, name: str = "final_position", limit: float | None = None) -> Axes:
    """Draw which share of the robots is farther off than any limit.

    Args:
        ax: to draw into.
        trials: with the figure.
        name: of a position error.
        limit: to mark [m].

    Returns:
        The axes.

    Raises:
        UnknownName: the figure was not kept.
        InvalidValue: not a position error, or a limit that is not positive.

    Example:
        >>> off, ends = {"final_position": np.arange(1000) / 1e5}, np.full(1000, "ok")
        >>> made, ax = dd.plots.figure("A finding")
        >>> trials = dd.sweeps.Trials(np.arange(1000), {}, off, ends, ends)
        >>> exceedance_curve(ax, trials, limit=0.009).get_yscale()
        'log'
    """
    if "position" not in name or name.endswith("_per_metre"):
        raise InvalidValue(f"name = {name!r}: must be a position error in metres, such as 'final_position'")
    sizes = np.sort(trials.sizes(name))
    finite = sizes[np.isfinite(sizes)]
    tails = np.append(np.geomspace(1, 1 / len(finite), _POINTS), 0.0)
    places = np.unique(np.append(np.quantile(finite, 1 - tails), 0.0))
    beyond = len(sizes) - np.searchsorted(sizes, places, side="right")
    found = [share_of(int(count), len(sizes)) for count in beyond]
    share, low, high = (100 * np.array([getattr(each, part) for each in found]) for part in ("value", "low", "high"))
    look = plots.style(1)
    least = 100 / len(sizes) / 3  # where the axis ends
    ax.fill_between(
        1e3 * places,
        np.maximum(low, least),
        high,
        color=look["color"],
        alpha=0.18,
        linewidth=0,
        label="95 % limits of the share",
    )
    ax.step(1e3 * places, np.maximum(share, least), where="post", color=look["color"], label="robots of the sweep")
    if limit is not None:
        mark = checks.positive("limit", limit)
        said = trials.exceedance(name, mark).text("%", 100)
        ax.axvline(
            1e3 * mark, color="black", linewidth=0.9, linestyle=":", label=f"beyond {quantity(mark, 'm')}: {said}"
        )
    ax.set(
        yscale="log",
        ylim=(least, 130),
        xlabel=f"{in_words(name)} [mm]",
        ylabel="robots farther off [%]",
    )
    ax.yaxis.set_major_formatter("{x:g}")
    ax.margins(x=0.01)
    ax.legend(loc="lower left", frameon=False, fontsize=9.5)
    return plots.tidy(ax)


def swept(title: str, trials: Trials, limit: float | None = None) -> Picture:
    """Draw a sweep at one look: the fan of errors along the way, and which share ends beyond any limit.

    Args:
        title: the finding.
        trials: with the figures "position_along" and "final_position".
        limit: of the final position error, to mark [m].

    Returns:
        The figure.

    Raises:
        UnknownName: a figure that was not kept.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> spread = {"robot.radius_ratio": dd.sweeps.Normal(mean=1.0, sigma=0.005)}
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 1.0})
        >>> kept, truth = ("position_along", "final_position"), "kinematics"
        >>> study = dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=50, truth=truth, figures=kept)
        >>> len(swept("A finding", dd.sweep(study)).axes)
        2
    """
    made, (left, right) = figure(title, columns=2, size=(WIDTH, 4.8))
    exceedance_curve(right, trials, limit=limit)
    fan(left, trials)
    legend_below(made, left, right, columns=3)
    return made


def budgeted(found: Budget) -> Picture:
    """Draw a budget: what tightening each tolerance buys, and how much of the variance it makes.

    Args:
        found: of `sweeps.budget`.

    Returns:
        The figure; its title is the finding.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 0.5})
        >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
        >>> study = dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=1000, truth="kinematics")
        >>> [ax.get_title(loc="left") for ax in budgeted(dd.sweeps.budget(study, dd.sweep(study))).axes]
        ['What it buys']
    """
    names = [found.prices.names[k] for k in found.order]
    columns = 1 if found.indices is None else 2
    size = (WIDTH, 1.9 + 0.62 * len(names))
    made, axes = figure(found.finding.rstrip("."), columns=columns, size=size)
    bought = axes if columns == 1 else axes[0]
    places = np.arange(len(names), dtype=np.float64)
    fall = found.prices.fall
    _bars(bought, places, fall, found.order, 0, 0.55, "_fall")
    narrowed = "halved" if found.prices.factor == 0.5 else f"times {found.prices.factor:g}"
    bought.set(
        yticks=places,
        yticklabels=[f"{varied_in_words(name)}\nsigma {100 * found.spreads[name]:.3g} %" for name in names],
        xlabel=f"fall of the {100 * found.prices.share:g}th percentile, spread {narrowed} [%]",
    )
    panel(bought, "What it buys")
    shown = [bought]
    if found.indices is not None:
        order = [found.indices.names.index(name) for name in names]
        _bars(axes[1], places - 0.18, found.indices.first, order, 1, 0.32, "alone")
        _bars(axes[1], places + 0.18, found.indices.total, order, 2, 0.32, "with the others")
        axes[1].set(yticks=places, yticklabels=[""] * len(names), xlabel="share of the variance (Sobol' index) [%]")
        panel(axes[1], f"Whose variance, {in_words(found.figure)}")
        shown.append(axes[1])
    for ax in shown:
        ax.invert_yaxis()
        ax.axvline(0, color="0.4", linewidth=0.8)
        plots.tidy(ax).grid(visible=False, axis="y")
    if found.indices is not None:
        legend_below(made, *shown)
    return made


def _bars(ax: Axes, places: Array, found: Estimate, order: list[int], look: int, height: float, label: str) -> None:
    """Horizontal bars in per cent with their limits."""
    value, low, high = (100 * each[order] for each in (found.value, found.low, found.high))
    reach = np.maximum([value - low, high - value], 0)
    error = {"ecolor": "0.2", "capsize": 3, "elinewidth": 1.1}
    hatch = "//" if look == 2 else ""
    ax.barh(
        places, value, height, xerr=reach, color=plots.style(look)["color"], label=label, error_kw=error, hatch=hatch,
        edgecolor="white", linewidth=0,
    )  # fmt: skip
