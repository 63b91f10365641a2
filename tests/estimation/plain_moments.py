"""The moments of the pose by another way: not centred, step by step, each step's own by quadrature over both wheels."""

from __future__ import annotations

import numpy as np

NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(15)


def plain_moments(angles, robot, k):
    """Mean (T, 3) and covariance (T, 3, 3) of a drive from the origin, whose wheels' ways have the variance k^2 |s|."""
    e, ee, p, pe, p_e, pp, p2, t, tt, tp, te = 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0
    weights = np.outer(WEIGHTS, WEIGHTS) / WEIGHTS.sum() ** 2
    drawn = np.meshgrid(NODES, NODES, indexing="ij")
    means, covariances = [np.zeros(3)], [np.zeros((3, 3))]
    for ways in np.diff(angles, axis=0) * (robot.left_radius, robot.right_radius):
        left, right = (way + k_wheel * abs(way) ** 0.5 * z for way, k_wheel, z in zip(ways, k, drawn, strict=True))
        turn = (right - left) / robot.track_width
        chord = (left + right) / 2 * np.sinc(turn / 2 / np.pi) * np.exp(0.5j * turn)
        turned = np.exp(1j * turn)
        a, aa, c, ca, c_a, cc, c2, w, ww, wc, wa = (
            (weights * part).sum()
            for part in (
                turned, turned**2, chord, chord * turned, chord / turned, chord**2, np.abs(chord) ** 2, turn, turn**2,
                turn * chord, turn * turned,
            )
        )  # fmt: skip
        e, ee, p, pe, p_e, pp, p2, t, tt, tp, te = (
            e * a,
            ee * aa,
            p + e * c,
            pe * a + ee * ca,
            p_e * a.conjugate() + c_a,
            pp + 2 * pe * c + ee * cc,
            p2 + 2 * (np.conj(p_e) * c).real + c2,
            t + w,
            tt + 2 * t * w + ww,
            tp + w * p + te * c + e * wc,
            te * a + e * wa,
        )
        spread, square, along = p2 - abs(p) ** 2, pp - p**2, tp - t * p
        xx, yy, xy = (spread + square.real) / 2, (spread - square.real) / 2, square.imag / 2
        means.append(np.array([p.real, p.imag, t]))
        covariances.append(np.array([[xx, xy, along.real], [xy, yy, along.imag], [along.real, along.imag, tt - t**2]]))
    return np.array(means), np.array(covariances)
