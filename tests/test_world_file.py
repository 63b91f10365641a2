"""Worlds as TOML files: presets with the source of every number, and files of one's own read back as they were."""

import dataclasses
import tomllib

import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers, sizes
from test_presets import same, sourced

import diffdrive_mj as dd
from diffdrive_mj._resources import MODELS
from diffdrive_mj.world import presets

PRESETS = ("garden", "ideal", "office", "workshop")

spans = st.tuples(numbers(-1e3, 1e3), sizes(1e-3, 1e3)).map(lambda span: (span[0], span[0] + span[1]))
patches = st.fixed_dictionaries({"x": spans, "y": spans, "friction": sizes(0.01, 10.0)})
accelerations = st.tuples(*(numbers(-10.0, 10.0) for _ in range(3)))
pushes = st.fixed_dictionaries(
    {"start": numbers(0.0, 1e3), "duration": sizes(1e-3, 1e2), "acceleration": accelerations}
)
slopes = st.fixed_dictionaries({"angle": numbers(0.0, 1.5)}, optional={"direction": numbers(-7.0, 7.0)})
worlds = st.fixed_dictionaries(
    {},
    optional={
        "name": st.text(max_size=20),
        "friction": sizes(1e-3, 1e2),
        "gravity": sizes(0.1, 1e2),
        "slope": st.none() | slopes,
        "patches": st.lists(patches, max_size=3),
        "pushes": st.lists(pushes, max_size=3),
    },
).map(lambda fields: dd.World(**fields))


def toml(name):
    """The numbers in a preset's file under dotted names; several tables are counted."""
    found = {}

    def put(name, value):
        if isinstance(value, dict):
            for key, part in value.items():
                put(f"{name}.{key}" if name else key, part)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for k, part in enumerate(value):
                put(f"{name}[{k}]", part)
        else:
            found[name] = " to ".join(map(str, value)) if isinstance(value, list) else value

    put("", tomllib.loads((MODELS / "worlds" / f"{name}.toml").read_text(encoding="utf-8")))
    return found


def test_the_presets_are_these():
    assert presets() == PRESETS


def test_the_ideal_world_is_the_default():
    assert dd.World.load("ideal").replace(name="world") == dd.World()


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_loads_and_starts_with_a_comment(name):
    assert dd.World.load(name).name == name
    assert (MODELS / "worlds" / f"{name}.toml").read_text(encoding="utf-8").startswith("# ")


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_of_a_preset_has_a_source_and_no_row_is_stale(name):
    rows, values = sourced(f"The world {name}"), toml(name)
    assert rows.keys() == values.keys()
    wrong = {key: (rows[key], value) for key, value in values.items() if not same(rows[key], value)}
    assert not wrong


@given(worlds)
def test_a_world_is_read_back_as_it_was_written(tmp_path_factory, world):
    path = tmp_path_factory.mktemp("worlds") / "mine.toml"
    world.save(path)
    again = dd.World.load(path)
    assert again == world
    assert again.to_toml() == world.to_toml()
    assert hash(again) == hash(world)


def test_a_file_without_a_name_has_its_own_and_says_the_rest(tmp_path):
    path = tmp_path / "attic.toml"
    path.write_text(
        "friction = 0.5\n[slope]\nangle = 0.1\n[[patches]]\nx = [0, 1]\ny = [-1, 1]\nfriction = 0.2\n"
        "[[pushes]]\nstart = 1\nduration = 2\nacceleration = [0, 1, 0]\n"
    )
    assert dd.World.load(path) == dd.World(
        name="attic",
        friction=0.5,
        slope=dd.Slope(angle=0.1),
        patches=(dd.Patch(x=(0, 1), y=(-1, 1), friction=0.2),),
        pushes=(dd.Push(start=1, duration=2, acceleration=(0, 1, 0)),),
    )


@pytest.mark.parametrize(
    ("content", "builtin", "words"),
    [
        ("friction: 0.5", ValueError, ("attic.toml", "not a world's TOML file")),
        ("frction = 0.5", KeyError, ("key in attic.toml 'frction'", "did you mean 'friction'?")),
        ("[slope]\nangel = 0.1", KeyError, ("key in attic.toml [slope] 'angel'", "did you mean 'angle'?")),
        ("[slope]\ndirection = 0.1", TypeError, ("Slope(...): angle missing",)),
        ("[slope]\nangle = 10", ValueError, ("Slope.angle = 10 rad", "in degrees? then 0.1745 rad")),
        ("[[patches]]\nx = [0, 1]\ny = [0, 1]\nice = 1", KeyError, ("key in attic.toml [patches] 'ice'", "friction")),
        ("[patches]\nx = [0, 1]", TypeError, ("World.patches", "must be a tuple of Patch")),
        ("[[slope]]\nangle = 0.1", TypeError, ("World.slope", "Slope(...)")),
        ("slope = 0.1", TypeError, ("World.slope = 0.1", "Slope(...)")),
        ("gravity = 0", ValueError, ("World.gravity = 0", "positive")),
    ],
)
def test_bad_files_are_refused(tmp_path, content, builtin, words):
    path = tmp_path / "attic.toml"
    path.write_text(content)
    with refused(builtin, *words):
        dd.World.load(path)


def test_what_is_not_there_and_what_is_no_file_is_refused(tmp_path):
    with refused(FileNotFoundError, "no such world file"):
        dd.World.load(tmp_path / "nowhere.toml")
    with refused(KeyError, "unknown preset 'offce'", "did you mean 'office'?"):
        dd.World.load("offce")
    with refused(TypeError, "world = 3", "a preset's name or a path"):
        dd.World.load(3)
    with refused(ValueError, "a world's file is named .toml"):
        dd.World().save(tmp_path / "mine.yaml")


def test_what_was_left_out_is_written_when_it_is_given():
    """What `diffdrive worlds show` prints has all that has a value."""
    fields = dataclasses.asdict(dd.World(slope={"angle": 0.1}))
    read = tomllib.loads(dd.World(**fields).to_toml())
    assert read == {name: value for name, value in fields.items() if value is not None and value != ()}
    assert read["slope"] == {"angle": 0.1, "direction": 0.0}
