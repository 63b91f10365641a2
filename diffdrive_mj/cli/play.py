"""`diffdrive play`: robot and belief on a page with sliders, in physics."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from diffdrive_mj.robot import Robot


def command(
    robot: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="[ROBOT]")] = "matched",
    /,
    port: int = 0,
    no_browser: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,
    packages: Annotated[Path | None, tyro.conf.arg(metavar="FOLDER")] = None,
) -> None:
    """Drive by hand: a page with sliders for the speed ratio k, the radii, the track width, the encoders and the floor.

      diffdrive play turtlebot3_burger

    The robot drives in MuJoCo, in the browser, beside the ghost of where it believes it is. The page is served on this
    machine alone, until Ctrl-C. It needs two packages of npm, which make play gets in a checkout; elsewhere
    npm install @mujoco/mujoco@3.14.0 three@0.187.0 does, in the current folder.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong; 130 after Ctrl-C.

    Args:
        robot: the name of a preset, or a TOML file; it has the masses and what else there is no slider for.
        port: of the page; 0 for any that is free.
        no_browser: print the address and open no browser.
        packages: the folder that holds node_modules; the current one or the checkout's if not given.

    Raises:
        DiffdriveError: bad input, a port that is taken, or packages that are missing.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["play", "matched", "--port", "-1"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    from diffdrive_mj.play.files import node_modules
    from diffdrive_mj.play.server import PlayServer, robots_by_name  # loads MuJoCo

    robots = robots_by_name(Robot.load(robot))
    with PlayServer(robots, node_modules(packages), port) as server:
        print(f"{server.address} (Ctrl-C ends it)", flush=True)
        if not no_browser:
            import webbrowser

            webbrowser.open(server.address)
        server.serve_forever(poll_interval=0.1)
