"""The settings of the physics: what is refused, and what the named ones stand for."""

import dataclasses

import pytest
from helpers import refused

import diffdrive_mj as dd

# Of the engine itself: what a model gets whose author leaves every choice to habit.
HABITS = {
    "timestep": 0.002, "integrator": "implicitfast", "cone": "pyramidal",
    "contact_stiffness": 0.01, "contact_damping": 0.2, "contact_impedance": (0.9, 0.95), "balanced_contacts": False,
    "friction_impedance": 1.0, "friction_damping": None, "truth": "engine", "servo_stiffness": 0.5, "tolerance": 1e-8,
    "settle_time": 0.3,
}  # fmt: skip


def changed(physics):
    """The settings that are not the default."""
    default = dd.Physics()
    return {
        field.name: getattr(physics, field.name)
        for field in dataclasses.fields(physics)
        if getattr(physics, field.name) != getattr(default, field.name)
    }


def test_the_habits_of_the_engine_are_all_of_them():
    assert dataclasses.asdict(dd.Physics.mujoco_defaults()) == HABITS


def test_fast_steps_change_the_step_alone_and_sliding_the_contacts_alone():
    assert changed(dd.Physics.fast()) == {"timestep": 0.005}
    # Contacts as stiff as one step in three holds, and damped below the critical.
    assert changed(dd.Physics.sliding()) == {
        "contact_stiffness": pytest.approx(1 / 9), "contact_damping": pytest.approx(2 / 3),
        "friction_impedance": 1.0, "friction_damping": 0.1, "truth": "engine",
    }  # fmt: skip


def test_what_coarse_steps_cost_rises_with_their_square():
    def floor(step):
        return float(dd.Physics(timestep=step).coarse.split("expect ")[1].split(" ppm")[0])

    assert dd.Physics(timestep=0.002).coarse == ""
    assert floor(0.04) == pytest.approx(4 * floor(0.02), rel=0.06)  # of two digits


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("cone", "round", "elliptic"),
        ("integrator", "rk4", "RK4"),
        ("truth", "true", "midpoint"),
        ("friction_impedance", 0.0, "must be positive"),
        ("friction_impedance", -1.0, "must be positive"),
        ("contact_stiffness", 1.01, "must be at most 1"),
        ("contact_damping", 0.0, "must be positive"),
        ("contact_impedance", (0.95, 0.9), "must be 0 < touching <= deep < 1"),
        ("contact_impedance", (0.9, 1.0), "must be 0 < touching <= deep < 1"),
        ("servo_stiffness", 1.6, "must be at most 1.5"),
        ("friction_damping", 2.0, "must be below 2"),
        ("tolerance", 0.0, "must be positive"),
        ("settle_time", -0.1, "must not be negative"),
    ],
)
def test_settings_without_meaning_are_named(field, value, said):
    with refused(ValueError, field, said):
        dd.Physics(**{field: value})
