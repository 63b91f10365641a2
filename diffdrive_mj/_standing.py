"""Robots that would tip over, refused when they are described."""

from __future__ import annotations

from diffdrive_mj.errors import InvalidValue

_PAYLOAD = "puts the centre of mass at x = {x:g} m, y = {y:g} m; it must stay"


def refuse_beside_triangle(own: float, x: float, y: float, payload: object, track: float, caster_x: float) -> None:
    """Refuse a robot on two wheels and a caster whose weight lies beside their triangle.

    Args:
        own: forward of the axle, where the body's centre of mass lies [m].
        x: the same with its payload [m].
        y: to the left, with its payload [m].
        payload: as messages show it.
        track: track width [m].
        caster_x: of the caster [m].
    """
    if not 0 < own / (caster_x or float("inf")) < 1:
        raise InvalidValue(
            f"Robot.center_of_mass_x = {own:g} m: must lie between the axle (0) and caster.x = {caster_x:g} m, or the "
            "robot tips over"
        )
    on_caster = x / caster_x
    if not (0 < on_caster < 1 and abs(y) < (1 - on_caster) * track / 2):
        raise InvalidValue(
            f"Robot.payload = {payload!r}: {_PAYLOAD.format(x=x, y=y)} within the triangle of the wheels and the "
            "caster, or the robot tips over"
        )


def refuse_on_three_wheels(own: float, x: float, y: float, payload: object, track: float, wheelbase: float) -> None:
    """Refuse a robot on four wheels one of which would carry nothing, since all sink alike.

    Args:
        own: forward of the middle, where the body's centre of mass lies [m].
        x: the same with its payload [m].
        y: to the left, with its payload [m].
        payload: as messages show it.
        track: track width [m].
        wheelbase: between front and rear wheels [m].
    """
    if not abs(own) < wheelbase / 2:
        raise InvalidValue(
            f"Robot.center_of_mass_x = {own:g} m: must lie within half of skid_steer.wheelbase = {wheelbase:g} m, or "
            "the robot tips over"
        )
    if not abs(x) / wheelbase + abs(y) / track < 0.5:
        raise InvalidValue(
            f"Robot.payload = {payload!r}: {_PAYLOAD.format(x=x, y=y)} within the diamond that halves the sides "
            "between the four wheels, or one of them carries nothing"
        )
