"""The moments of a step against quadrature over its noise, and the rule that says how fine they are."""

from __future__ import annotations

import cmath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation._noisy_step import StepMoments, rule, step_moments

NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(60)
# Distance, turn, variance of the distance, covariance, variance of the turn: small and large, straight and on the spot.
STEPS = [
    (0.01, 0.005, 1e-8, 3e-8, 5e-7),
    (0.1, 0.5, 1e-4, 3e-5, 5e-3),
    (1.0, 0.0, 0.01, 0.003, 0.06),
    (0.0, 3.0, 1e-3, 0.0, 0.05),
    (2.0, 7.0, 0.1, -0.1, 0.9),
    (3.0, 0.0, 0.5, 0.2, 4.0),
]


def by_quadrature(distance, turn, var_distance, covariance, var_turn):
    weights = np.outer(WEIGHTS, WEIGHTS) / WEIGHTS.sum() ** 2
    first, second = np.meshgrid(NODES, NODES, indexing="ij")
    sigma = np.sqrt(var_turn)
    turned = turn + sigma * first
    way = distance + covariance / sigma * first + np.sqrt(var_distance - covariance**2 / var_turn) * second
    chord = way * np.sinc(turned / 2 / np.pi) * np.exp(0.5j * turned)

    def mean(values):
        return (weights * values).sum()

    off, spin = chord - mean(chord), np.exp(1j * turned) - mean(np.exp(1j * turned))
    return StepMoments(
        mean(np.exp(1j * turned)),
        mean(chord),
        mean(off * spin),
        mean(off.conj() * spin),
        mean(off * (turned - turn)),
        mean(off**2),
        mean(np.abs(off) ** 2),
    )


@pytest.mark.parametrize("step", STEPS)
def test_moments_are_those_of_quadrature_over_the_noise(step):
    found = step_moments(*step, rule(abs(step[1]), step[4]), cmath.exp)
    scale = abs(step[0]) + step[2] ** 0.5
    np.testing.assert_allclose(found, by_quadrature(*step), rtol=1e-11, atol=1e-13 * scale)


def test_arrays_give_the_same_as_numbers():
    fine = rule(7.0, 4.0)
    arrays = step_moments(*np.transpose(STEPS), fine, np.exp)
    for index, step in enumerate(STEPS):
        numbers = step_moments(*step, fine, cmath.exp)
        np.testing.assert_allclose([part[index] for part in arrays], numbers, rtol=1e-12, atol=1e-15)


@given(turn=st.floats(-50, 50), variance=st.floats(1e-9, 2.0))
def test_a_finer_rule_changes_nothing(turn, variance):
    step = (0.3, turn, 0.02, 0.1 * (0.02 * variance) ** 0.5, variance)
    found, finer = (step_moments(*step, rule(*size), cmath.exp) for size in ((abs(turn), variance), (70.0, 4.0)))
    np.testing.assert_allclose(found, finer, rtol=1e-10, atol=1e-13)


def test_few_nodes_do_for_small_steps_and_steps_of_many_turns_are_refused():
    assert len(rule(0.005, 1e-7).nodes) <= 4
    with pytest.raises(InvalidValue, match="sample the drive more often"):
        rule(3000.0, 0.1)
    with pytest.raises(InvalidValue, match="sample the drive more often"):
        rule(0.1, 20.0)
