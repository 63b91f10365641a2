"""Whether stated covariances are those of the errors: NEES against a true pose, NIS against measurements.

An error e of K numbers with the covariance C has the square e^T C^-1 e, which is K in the mean, and distributed as
chi-squared with K degrees of freedom where the errors are normal. Larger squares are those of an estimator that is
overconfident, smaller ones of one that is timid.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import _covariances as covariances
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, table
from diffdrive_mj.errors import InvalidValue

Frame = Literal["world", "mean"]
LEVELS = (0.5, 0.95, 0.99)
# An error that rounding alone may leave where none is stated [m, rad].
_NONE = 1e-9


@dataclass(frozen=True, eq=False)
class Consistency:
    """Holds how errors compare with the covariances that were stated for them, and prints as a table.

    Attributes:
        name: of the test, "NEES" or "NIS".
        squares: of R runs at T samples (R, T); NaN where the covariance is singular, as at a start that is known.
        freedom: K, the degrees of freedom of a square.
        independent: whether the samples of a run are independent of each other, as innovations are.
        confidence: with which an honest covariance is found to be one.

    Example:
        >>> from diffdrive_mj.judging.consistency import Consistency
        >>> found = Consistency("NEES", np.array([[4.0, 2.6], [2.3, 3.2]]), freedom=3, independent=False)
        >>> round(found.mean, 4), found.holds
        (1.0083, True)
    """

    name: str
    squares: Array
    freedom: int
    independent: bool
    confidence: float = 0.95

    @property
    def mean(self) -> float:
        """The mean square over its degrees of freedom: 1 if the covariances are honest."""
        return float(np.nanmean(self.squares)) / self.freedom

    @property
    def along(self) -> Array:
        """The same of each sample, over the runs (T,); NaN where the covariance is singular."""
        return np.asarray(np.mean(self.squares, axis=0) / self.freedom)

    @property
    def interval(self) -> tuple[float, float]:
        """Where the mean of honest covariances lies; the samples of a run count as one unless they are independent."""
        used = int(np.isfinite(self.squares[0]).sum()) if self.independent else 1
        return self._limits(len(self.squares) * used, (1 - self.confidence) / 2)

    @property
    def band(self) -> tuple[float, float]:
        """Where all values of `along` lie if the covariances are honest, however the samples hang together."""
        used = max(1, int(np.isfinite(self.along).sum()))
        return self._limits(len(self.squares), (1 - self.confidence) / 2 / used)

    @property
    def holds(self) -> bool:
        """Whether the covariances may be honest, in the mean and at every sample."""
        return self._within(self.mean, self.interval) and not self._outside().any()

    def inside(self, level: float) -> float:
        """Return the share of the errors in the stated region of a level, which should be the level.

        Args:
            level: such as 0.95.

        Example:
            >>> Consistency("NEES", np.array([[1.0, 9.0]]), freedom=3, independent=False).inside(0.95)
            0.5
        """
        from scipy.special import chdtri

        known = self.squares[np.isfinite(self.squares)]
        return float(np.mean(known <= chdtri(self.freedom, 1 - _level(level))))

    @property
    def verdict(self) -> str:
        """One line: honest, or by which factor not."""
        factor, (low, high) = self.mean, self.interval
        what = f"{self.name} / {self.freedom} is {factor:.3g}"
        if self._within(factor, self.interval):
            if not self._outside().any():
                return f"honest: {what}, within {low:.3g} to {high:.3g}"
            least, most = int(np.nanargmin(self.along)), int(np.nanargmax(self.along))
            return (
                f"honest on average only: {self.name} / {self.freedom} goes from {self.along[least]:.3g} at sample "
                f"{least} to {self.along[most]:.3g} at sample {most}"
            )
        if factor > high:
            return (
                f"overconfident by a factor {factor:.3g}: {what}, more than {high:.3g}; errors are {factor**0.5:.3g} "
                "times the stated deviations"
            )
        return (
            f"timid by a factor {1 / factor:.3g}: {what}, less than {low:.3g}; errors are {factor**0.5:.3g} times the "
            "stated deviations"
        )

    def __str__(self) -> str:
        return "\n".join([table(self._header(), self._rows()), *self._remarks(), self.verdict])

    def _repr_html_(self) -> str:
        return html_table(self._rows(), self._header(), self.verdict)

    def _header(self) -> list[str]:
        return [self.name, "found", "if honest"]

    def _rows(self) -> list[list[str]]:
        low, high = self.interval
        lowest, highest = self.band
        ends = (float(np.nanmin(self.along)), float(np.nanmax(self.along)))
        return [
            ["mean, over its degrees of freedom", f"{self.mean:.3g}", f"{low:.3g} to {high:.3g}"],
            ["the same along the drive", f"{ends[0]:.3g} to {ends[1]:.3g}", f"{lowest:.3g} to {highest:.3g}"],
            *(
                [f"inside of the {100 * level:g} % region", f"{100 * self.inside(level):.3g} %", f"{100 * level:g} %"]
                for level in LEVELS
            ),
        ]

    def _remarks(self) -> list[str]:
        runs, samples = self.squares.shape
        lost = samples - np.count_nonzero(np.isfinite(self.along))
        without = f", {lost} of them left out: their covariance is singular" if lost else ""
        return [f"runs: {runs}, samples of each: {samples}{without}"]

    def _outside(self) -> Array:
        low, high = self.band
        return np.asarray((self.along < low) | (self.along > high))

    def _limits(self, count: int, tail: float) -> tuple[float, float]:
        """The mean of so many squares over their degrees of freedom, but for two tails of half of this together."""
        from scipy.special import chdtri

        total = count * self.freedom
        return float(chdtri(total, 1 - tail / 2)) / total, float(chdtri(total, tail / 2)) / total

    @staticmethod
    def _within(value: float, limits: tuple[float, float]) -> bool:
        return limits[0] <= value <= limits[1]


def nees(
    truth: ArrayLike,
    estimate: ArrayLike,
    covariance: ArrayLike,
    *,
    frame: Frame = "world",
    confidence: float = 0.95,
) -> Consistency:
    """Compare the errors of estimated poses with their stated covariances: the normalised estimation error squared.

    ```
    NEES = e^T C^-1 e,    e = truth - estimate in the world, log(estimate^-1 truth) in that of the mean
    ```

    The errors of odometry add up along a drive, so that the samples of a run count as one: only more runs make the test
    sharper. The bounds along the drive hold for all samples together.

    Args:
        truth: (..., T, 3) [m, m, rad], R runs in the leading dimensions.
        estimate: means of the estimated poses, likewise; headings may be off by whole turns.
        covariance: (..., T, 3, 3), as stated for them.
        frame: of the covariances: "world" for those of x, y and theta, "mean" for those of exponential coordinates.
        confidence: with which honest covariances of normal errors are found to be honest, at least.

    Returns:
        The squares, and what they say.

    Raises:
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, a matrix that is no covariance, or an error where none is stated.
        UnknownName: the frame.

    References:
        Bar-Shalom, Li, Kirubarajan 2001, section 5.4.

    Example:
        Deviations of 1 cm are stated for errors of 2 cm:

        >>> rng = np.random.default_rng(0)
        >>> truth = 0.02 * rng.normal(size=(200, 1, 3))
        >>> print(dd.judging.consistency.nees(truth, np.zeros(3)[None], 1e-4 * np.eye(3)).verdict)
        overconfident by a factor 3.98: NEES / 3 is 3.98, more than 1.13; errors are 1.99 times the stated deviations
    """
    checks.member("frame", frame, get_args(Frame))
    true, poses = checks.array("truth", truth, "T", 3), checks.array("estimate", estimate, "T", 3)
    checks.broadcast(truth=true[..., 0], estimate=poses[..., 0])
    if frame == "mean":
        errors = se2.log(se2.between(poses, true))
    else:
        errors = true - poses
        errors[..., 2] = se2.wrap_angle(errors[..., 2])
    return _tested("NEES", errors, covariance, False, confidence, ("x", "y", "theta"))


def nis(innovations: ArrayLike, covariance: ArrayLike, *, confidence: float = 0.95) -> Consistency:
    """Compare an estimator's innovations with their stated covariances: the normalised innovation squared.

    ```
    NIS = v^T S^-1 v,    v = z - h(x),    S = H P H^T + R
    ```

    Innovations of an honest estimator are independent of each other, so that one log has as many trials as fixes. It
    takes no truth.

    Args:
        innovations: v (..., T, K), measurements less what the estimator expected of them.
        covariance: S (..., T, K, K), as the estimator states them.
        confidence: with which honest covariances of normal errors are found to be honest, at least.

    Returns:
        The squares, and what they say.

    Raises:
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, a matrix that is no covariance, or an innovation where none is stated.

    References:
        Bar-Shalom, Li, Kirubarajan 2001, section 5.4.

    Example:
        >>> rng = np.random.default_rng(0)
        >>> fixes = 0.1 * rng.normal(size=(300, 2))
        >>> print(dd.judging.consistency.nis(fixes, 0.01 * np.eye(2)).verdict)
        honest: NIS / 2 is 0.994, within 0.875 to 1.13
    """
    errors = checks.array("innovations", innovations, "T", "K")
    return _tested("NIS", errors, covariance, True, confidence, tuple(map(str, range(errors.shape[-1]))))


def _tested(
    name: str, errors: Array, covariance: ArrayLike, independent: bool, confidence: float, parts: tuple[str, ...]
) -> Consistency:
    stated = covariances.covariance("covariance", covariance, errors.shape[-1])
    leading = checks.broadcast(errors=errors[..., 0], covariance=stated[..., 0, 0])
    none = np.diagonal(stated, axis1=-2, axis2=-1) == 0
    wrong = np.argwhere(np.broadcast_to(none & (np.abs(errors) > _NONE), (*leading, errors.shape[-1])))
    if len(wrong):
        *at, part = (int(k) for k in wrong[0])
        off = np.broadcast_to(errors, (*leading, errors.shape[-1]))[tuple(wrong[0])]
        raise InvalidValue(
            f"covariance: the variance of {parts[part]} is zero at sample {at[-1]}, where the error is {off:.3g}: must "
            "say how far it may be off"
        )
    squares = np.broadcast_to(covariances.squared(errors, stated), leading).reshape(-1, leading[-1])
    # A sample counts in all runs or in none.
    squares = np.where(np.isnan(squares).any(axis=0), np.nan, squares)
    if np.isnan(squares).all():
        raise InvalidValue("covariance: singular at every sample: must say how far each of the numbers may be off")
    return Consistency(name, squares, errors.shape[-1], independent, _level(confidence, "confidence"))


def _level(value: float, name: str = "level") -> float:
    share = checks.positive(name, value)
    if share >= 1:
        raise InvalidValue(f"{name} = {share:g}: must be below 1")
    return share
