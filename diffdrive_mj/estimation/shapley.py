"""A total split among its causes: each cause's part is the mean of what it adds, over all orders."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue


def added(outcomes: ArrayLike) -> Array:
    """Compute what each cause adds to each set of the others.

    Args:
        outcomes: (2, ..., 2, M), an axis for each of the n causes, off then on, and the outcome's own values.

    Returns:
        (n, 2^(n - 1), M): the first set is the empty one, the last that of all the others.

    Raises:
        InvalidType: not numbers.
        InvalidValue: no cause, or an axis that is not off and on.

    Example:
        Two causes, which together make more than each alone:

        >>> added([[[0.0], [1.0]], [[2.0], [5.0]]])[..., 0].tolist()
        [[2.0, 4.0], [1.0, 3.0]]
    """
    values = checks.array("outcomes", outcomes, "M")
    n = values.ndim - 1
    if n < 1 or values.shape[:n] != (2,) * n:
        raise InvalidValue(f"outcomes has shape {values.shape}: must be (2, ..., 2, M), off and on for each cause")
    steps = (np.diff(values, axis=cause).reshape(2 ** (n - 1), -1) for cause in range(n))
    return np.stack(list(steps))


def parts(outcomes: ArrayLike) -> Array:
    """Compute what part of the outcome each cause has.

    With v(S) the outcome when the causes in S are switched on, n of them in all, the part of cause i is

    ```
    phi_i = sum over S without i of |S|! (n - |S| - 1)! / n! (v(S + i) - v(S))
    ```

    The parts add up to v(all) - v(none), whatever v is; no part is left over as an interaction.

    Args:
        outcomes: as for `added`.

    Returns:
        (n, M); their sum is the outcome with all causes on, less that with none.

    Raises:
        InvalidType: not numbers.
        InvalidValue: no cause, or an axis that is not off and on.

    References:
        Shapley 1953.

    Example:
        >>> parts([[[0.0], [1.0]], [[2.0], [5.0]]])[:, 0].tolist()
        [3.0, 2.0]
    """
    steps = added(outcomes)
    n = len(steps)
    sizes = np.array([number.bit_count() for number in range(steps.shape[1])])
    weights = np.array([1 / (n * math.comb(n - 1, size)) for size in range(n)])
    return np.einsum("s,isM->iM", weights[sizes], steps)
