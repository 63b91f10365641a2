"""`diffdrive play`: what it says, how it ends, and that it leaves nothing behind."""

import http.client
import json
import re
import signal
import socket
import subprocess
import sys

import pytest

from diffdrive_mj import cli
from diffdrive_mj.play.files import PACKAGES


@pytest.fixture
def packages(tmp_path):
    """Stand-ins for the packages of npm, of which the command reads the versions alone."""
    for name, version in PACKAGES.items():
        (tmp_path / "node_modules" / name).mkdir(parents=True)
        (tmp_path / "node_modules" / name / "package.json").write_text(json.dumps({"version": version}))
    return tmp_path


def started(packages, *options):
    """The running command, and the port that it has said."""
    command = [sys.executable, "-m", "diffdrive_mj", "play", "--no-browser", "--packages", str(packages), *options]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    line = running.stdout.readline()
    said = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/ \(Ctrl-C ends it\)\n", line)
    assert said, line + running.stderr.read()
    return running, int(said[1])


@pytest.mark.parametrize(("number", "status", "line"), [(signal.SIGINT, 130, "diffdrive: interrupted\n"),
                                                        (signal.SIGTERM, 143, "")])  # fmt: skip
def test_a_signal_ends_it_and_frees_the_port(packages, number, status, line):
    first, port = started(packages)
    second, other = started(packages, "ct_bot")
    assert port != other
    # A browser that keeps its connection open does not keep the command from ending.
    with socket.create_connection(("127.0.0.1", port)):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
        connection.request("GET", "/api/start")
        assert json.loads(connection.getresponse().read())["settings"][0]["robot"] == "matched"
        for running in (first, second):
            running.send_signal(number)
            out, err = running.communicate(timeout=10)
            assert (running.returncode, out, err) == (status, "", line)
    again, taken = started(packages, "--port", str(port))
    assert taken == port
    again.send_signal(signal.SIGINT)
    again.communicate(timeout=10)


def refusal(capsys, *arguments):
    with pytest.raises(SystemExit) as raised:
        cli.main(["play", "--no-browser", *arguments])
    assert raised.value.code == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.count("\n") == 1
    return streams.err


def test_bad_input_is_one_line(packages, tmp_path_factory, capsys):
    found = ("--packages", str(packages))
    assert "unknown preset 'mached'" in refusal(capsys, "mached", *found)
    assert "port 99999: cannot be had" in refusal(capsys, "--port", "99999", *found)
    assert "port -1: cannot be had" in refusal(capsys, "--port", "-1", *found)
    assert "diffdrive play" in refusal(capsys, "--port", "many", *found)
    assert "nothing.toml: no such robot file" in refusal(capsys, "nothing.toml", *found)
    missing = refusal(capsys, "--packages", str(tmp_path_factory.mktemp("empty")))
    assert "npm install @mujoco/mujoco@3.14.0 three@0.187.0" in missing
    assert "diffdrive report" in missing


def test_the_browser_is_opened_unless_it_is_not_wanted(packages, monkeypatch, capsys):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("diffdrive_mj.play.server.PlayServer.serve_forever", lambda self, poll_interval: None)
    cli.main(["play", "--packages", str(packages)])
    cli.main(["play", "--packages", str(packages), "--no-browser"])
    addresses = re.findall(r"http://\S+", capsys.readouterr().out)
    assert opened == addresses[:1]
