"""The server of the page: its own files and drives, to this machine, with GET, and nothing else."""

import dataclasses
import http.client
import json
import re
import socket
import threading
import time
from posixpath import normpath
from urllib.parse import urlencode

import pytest
from helpers import ROOT, refused

import diffdrive_mj as dd
from diffdrive_mj.play.files import PACKAGES, node_modules, served
from diffdrive_mj.play.server import PlayServer, robots_by_name
from diffdrive_mj.play.setting import Setting

MATCHED = dd.Robot.load("matched")
SETTING = dataclasses.asdict(Setting.of(MATCHED))


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """Stand-ins for the packages of npm, which the server only reads."""
    folder = tmp_path_factory.mktemp("packages") / "node_modules"
    for name, version in PACKAGES.items():
        (folder / name).mkdir(parents=True)
        (folder / name / "package.json").write_text(json.dumps({"version": version}))
    for url, path in served(folder).items():
        if not url.startswith("/play") and folder in path.parents:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(url)
    (folder / "secret.js").write_text("secret")
    return folder


@pytest.fixture(scope="module")
def server(packages):
    with PlayServer(robots_by_name(MATCHED), packages) as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield running
        running.shutdown()
        thread.join()


def asked(server, path, method="GET", **headers):
    """Status, headers and body of an answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=10)
    connection.request(method, path, headers={key.replace("_", "-"): value for key, value in headers.items()})
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, answer.headers, body


def error(server, path, **options):
    status, _, body = asked(server, path, **options)
    said = json.loads(body)["error"]
    assert "\n" not in said
    return status, said


def drive(**changes):
    return f"/api/drive?{urlencode({**SETTING, **changes})}"


def test_it_listens_on_loopback_alone(server):
    assert server.socket.getsockname()[0] == "127.0.0.1"
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", server.address)


@pytest.mark.parametrize(
    ("path", "kind"),
    [("/", "text/html"), ("/play/web/app.mjs", "text/javascript"), ("/play/web/style.css", "text/css"),
     ("/report/web/odometry.mjs", "text/javascript"), ("/mujoco/mujoco.wasm", "application/wasm")],
)  # fmt: skip
def test_files_are_sent_with_their_type_and_a_policy(server, path, kind):
    status, headers, body = asked(server, path)
    assert status == 200
    assert headers["Content-Type"].startswith(kind)
    assert len(body) == int(headers["Content-Length"]) > 0
    assert headers["Content-Security-Policy"].startswith("default-src 'none'; script-src 'self';")
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert "Access-Control-Allow-Origin" not in headers


def test_only_the_worker_may_make_functions_of_text(server):
    loose = {url for url in server.files if "unsafe-eval" in asked(server, url)[1]["Content-Security-Policy"]}
    assert loose == {"/play/web/worker.mjs"}


def test_the_page_names_nothing_that_is_not_served(server):
    """Every address in the page's own files is one of the server's, and no other machine is named."""
    names = set()
    for url, path in server.files.items():
        if path.suffix in (".html", ".css", ".mjs"):
            text = path.read_text()
            assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)", text), path
            names |= set(re.findall(r"""["'(](/[\w./-]+\.(?:mjs|js|css|wasm))["')]""", text))
            folder = url.rpartition("/")[0]
            names |= {normpath(f"{folder}/{name}") for name in re.findall(r'from "(\.[\w./]+)"', text)}
    assert len(names) > 15
    # The browser asks for the page by itself, and packages import the rest of themselves.
    by_others = {"/", "/play/web/index.html", "/mujoco/mujoco.wasm", "/three/three.core.js"}
    assert names | by_others == set(server.files)


@pytest.mark.parametrize(
    "path",
    ["/play/web/", "/play/web", "/play/server.py", "/../pyproject.toml", "/play/web/../server.py", "/secret.js",
     "/play/web/%2e%2e/server.py", "/..%2f..%2fetc/passwd", "//etc/passwd", "/mujoco/../../secret.js", "/index.html",
     "/api", "/api/", "/api/start/", "/play/web/app.mjs%00", "/mujoco/package.json"],
)  # fmt: skip
def test_nothing_else_is_served(server, path):
    assert error(server, path) == (404, "there is no such file")


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "HEAD", "OPTIONS", "TRACE", "NONSENSE"])
def test_only_get_is_answered(server, method):
    status, headers, body = asked(server, "/", method=method)
    assert (status, headers["Allow"]) == (405, "GET")
    assert b"GET" in body or method == "HEAD"


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1", "0.0.0.0", ""])
def test_another_name_that_leads_here_is_refused(server, host):
    for path in ("/", "/api/start", drive()):
        assert error(server, path, Host=host)[0] == 403


def test_a_request_without_a_host_is_refused(server):
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=10) as connection:
        connection.sendall(b"GET / HTTP/1.0\r\n\r\n")
        assert connection.recv(100).startswith(b"HTTP/1.0 403 ")


def test_both_names_of_this_machine_are_known(server):
    for name in ("127.0.0.1", "localhost"):
        assert asked(server, "/", Host=f"{name}:{server.server_port}")[0] == 200


def test_another_page_may_not_ask_for_drives(server):
    for site in ("cross-site", "same-site"):  # the latter is another port of this machine
        assert error(server, drive(), Sec_Fetch_Site=site)[0] == 403
    assert asked(server, drive(), Sec_Fetch_Site="same-origin")[0] == 200
    assert asked(server, "/", Sec_Fetch_Site="cross-site")[0] == 200  # a link that was sent by mail


def test_it_says_what_the_page_opens_with(server):
    start = json.loads(asked(server, "/api/start")[2])
    assert start["settings"][0] == SETTING
    assert {setting["robot"] for setting in start["settings"]} == set(dd.robot.presets())
    assert start["knobs"]["friction"] == {"least": 0.02, "most": 2.0, "unit": ""}


def test_a_drive_comes_with_its_setting(server):
    answer = json.loads(asked(server, drive(k=0.85))[2])
    assert answer["setting"] == {**SETTING, "k": 0.85}
    assert answer["believed"]["right_radius"] == 0.091
    assert max(answer["rates"]) == pytest.approx(15.0)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (drive(left_radius="-0.1"), "left_radius = -0.1 m: must lie between"),
        (drive(left_radius="nan"), "left_radius = nan: must be finite"),
        (drive(friction="1e999"), "friction = inf: must be finite"),
        (drive(k="<b>k</b>"), "k = '<b>k</b>': must be a number"),
        (drive(robot="../../etc/passwd"), "unknown robot"),
        (drive(robot="a\nb"), "unknown robot 'a\\nb'"),
        (drive(maneuver="nothing"), "unknown maneuver"),
        (drive(rate=333), "must be a whole multiple"),
        (drive(wheels=3), "unknown setting 'wheels'"),
        (drive() + "&k=1", "the setting names something twice"),
        ("/api/drive", "robot: is missing"),
        ("/api/drive?", "robot: is missing"),
        ("/api/drive?k", "not of the form"),
        ("/api/drive?k=%ff%fe", "not of the form"),
        ("/api/drive?" + "&".join(f"a{i}=1" for i in range(60)), "not of the form"),
        ("/api/drive?robot=matched", "maneuver: is missing"),
    ],
)
def test_rubbish_is_answered_in_one_line(server, path, words):
    status, said = error(server, path)
    assert status == 400
    assert words in said


def test_a_long_request_is_refused(server):
    assert error(server, "/api/drive?k=" + "1" * 5000)[0] == 414
    assert error(server, "/" + "x" * 100_000)[0] == 414


@pytest.mark.parametrize("sent", [b"\r\n\r\n", b"nonsense\r\n\r\n", b"\x00\xff\xfe\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n",
                                  b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 200 + b"\r\n", b"GET", b""])  # fmt: skip
def test_what_is_not_http_does_no_harm(server, sent, capfd):
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=10) as connection:
        connection.sendall(sent)
        connection.shutdown(socket.SHUT_WR)
        while connection.recv(65536):
            pass
    assert asked(server, "/")[0] == 200
    assert capfd.readouterr() == ("", "")


def until(condition):
    begin = time.monotonic()
    while not condition() and time.monotonic() < begin + 10:
        time.sleep(0.05)
    return condition()


def test_a_request_that_never_ends_is_closed(server, monkeypatch):
    monkeypatch.setattr("diffdrive_mj.play.server._SECONDS_OF_A_REQUEST", 0.3)
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=10) as connection:
        connection.sendall(b"GET / HTTP/1.1\r\n")

        def closed():
            try:
                connection.sendall(b"a: b\r\n")
            except OSError:
                return True
            return False

        assert until(closed)
    monkeypatch.undo()
    assert asked(server, "/")[0] == 200
    assert until(lambda: not server.open)


def test_two_run_at_once_and_a_port_is_had_once(server, packages):
    with PlayServer({"matched": MATCHED}, packages) as second:
        assert second.server_port != server.server_port
    with refused(ValueError, f"port {server.server_port}: cannot be had"):
        PlayServer({"matched": MATCHED}, packages, server.server_port)
    for port in (-1, 65536, 10**9):
        with refused(ValueError, f"port {port}: cannot be had"):
            PlayServer({"matched": MATCHED}, packages, port)


def test_a_robot_that_cannot_drive_is_refused_at_once(packages):
    for robot, words in [
        (MATCHED.replace(turning_gain=0.01), "Robot.turning_gain"),
        (MATCHED.replace(left_radius=0.7, right_radius=0.7, track_width=1.5), "left_radius = 0.7 m: must lie between"),
    ]:
        with refused(ValueError, words):
            PlayServer({robot.name: robot}, packages)


def test_packages_are_found_or_asked_for(packages, tmp_path, monkeypatch):
    assert node_modules(packages) == packages
    assert node_modules(packages.parent) == packages
    deeper = packages.parent / "robots" / "mine"  # from where npm install puts them beside the folders above
    deeper.mkdir(parents=True)
    for place in (packages.parent, deeper):
        monkeypatch.chdir(place)
        assert node_modules() == packages
    with refused(ValueError, "needs @mujoco/mujoco 3.14.0: make play gets it", "npm install @mujoco/mujoco@3.14.0 "):
        node_modules(tmp_path)
    older = tmp_path / "node_modules"
    for name in PACKAGES:
        (older / name).mkdir(parents=True)
        (older / name / "package.json").write_text('{"version": "0.1.0"}')
    with refused(ValueError, f"needs @mujoco/mujoco 3.14.0 ({older} has 0.1.0)"):
        node_modules(tmp_path)


@pytest.mark.parametrize("text", ["", "[]", "nothing", "null", '{"name": "three"}'])
def test_a_broken_package_is_one_that_is_missing(text, packages, tmp_path):
    for name in PACKAGES:
        (tmp_path / "node_modules" / name).mkdir(parents=True)
        (tmp_path / "node_modules" / name / "package.json").write_text(text)
    with refused(ValueError, "diffdrive play needs"):
        node_modules(tmp_path)


def test_the_versions_are_those_of_the_checkout():
    assert json.loads((ROOT / "package.json").read_text())["dependencies"] == PACKAGES
