"""What each world costs each robot: every preset of both drives for a minute, or it is said what happened."""

import math

import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging.costs import Cost, cost, minute
from diffdrive_mj.robot import presets as robots
from diffdrive_mj.world import presets as worlds

# What a minute on each floor may cost [ppm], about twice what it costs the worst of the presets.
MOST = {"ideal": 0.4, "office": 1000.0, "workshop": 3000.0, "garden": 12000.0}


def went_through(found):
    """Whether the robot got to the end on its wheels."""
    return math.isfinite(found.position) and not any("fell" in event or "stuck" in event for event in found.events)


@pytest.mark.slow
@pytest.mark.parametrize("world", worlds())
@pytest.mark.parametrize("robot", robots())
def test_every_preset_drives_on_every_floor_for_a_minute(robot, world):
    assert minute(dd.Robot.load(robot)).duration > 60
    found = cost(dd.Robot.load(robot), dd.World.load(world))
    assert went_through(found)
    assert max(found.position, found.heading) < MOST[world]
    assert found.events if world in ("workshop", "garden") else world == "office" or not found.events


@pytest.mark.parametrize("world", worlds())
@pytest.mark.parametrize("robot", robots())
def test_every_preset_crosses_every_floor(robot, world):
    """In a straight line, over all that lies on the way."""
    true = dd.Robot.load(robot)
    found = cost(true, dd.World.load(world), dd.maneuvers.straight(true, speed=0.4, distance=1.6))
    assert went_through(found)
    assert found.position < (1.0 if world == "ideal" else 12000.0)


def test_what_cannot_be_driven_says_why():
    steep = dd.World(slope={"angle": 1.0})
    found = cost(dd.Robot.load("matched"), steep)
    assert math.isnan(found.position)
    assert str(found).startswith("not driven: World.slope.angle = 1 rad: robot matched would")


def test_what_happens_is_said_and_no_error():
    robot, ice = dd.Robot.load("matched"), dd.Patch(x=(-9, 9), y=(0.0, 9.0), friction=0.01)
    found = cost(robot, dd.World(patches=(ice,)), dd.maneuvers.straight(robot, speed=0.5, distance=1.0))
    assert found.position > 1000
    assert "the left wheel used 100 % of its friction" in str(found)


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (Cost(0.0123, 1e-5, ()), "0.012 ppm, heading 0.00001 ppm"),
        (Cost(123456.0, 7.0, ("a fell at 1 s",)), "120000 ppm, heading 7 ppm; a fell at 1 s"),
        (Cost(1.0, 2.0, ("a", "b", "c")), "1 ppm, heading 2 ppm; a, and 2 more"),
    ],
)
def test_it_prints_two_digits_and_the_first_event(found, words):
    assert str(found) == words


@pytest.mark.parametrize("bad", [(3, dd.World()), (dd.Robot.load("matched"), "office")])
def test_what_is_no_robot_or_no_world_is_refused(bad):
    with pytest.raises(TypeError):
        cost(*bad)


def test_odometry_of_skid_steer_knows_its_effective_track():
    """On the ideal floor what is left is how the wheels start and stop to slide, and no wrong track."""
    skids = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4, skid_steer=dd.SkidSteer(wheelbase=0.3))
    found = cost(skids, dd.World(), dd.maneuvers.square(skids, side=0.5, speed=0.2, yaw_rate=0.5))
    assert went_through(found)
    assert max(found.position, found.heading) < 1000
