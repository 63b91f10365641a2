"""The server of the page: on this machine alone, a fixed list of files, and drives as JSON."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import socket
import sys
import threading
import time
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlsplit

from diffdrive_mj import _checks as checks
from diffdrive_mj.errors import DiffdriveError, InvalidValue
from diffdrive_mj.play.drives import MANEUVERS, plan
from diffdrive_mj.play.files import content_type, served
from diffdrive_mj.play.setting import KNOBS, Setting
from diffdrive_mj.robot import Robot, presets

HOST = "127.0.0.1"
_LONGEST_REQUEST = 4096
_WORKER = "/play/web/worker.mjs"  # alone may MuJoCo's bindings make functions of text, far from the page
_SECONDS_OF_SILENCE = 10
_SECONDS_OF_A_REQUEST = 60


class PlayServer(ThreadingHTTPServer):
    """Serve the page until it is closed.

    Args:
        robots: by name; the first is the one that the page opens with.
        packages: a folder `node_modules`.
        port: 0 for any that is free.

    Raises:
        InvalidValue: a port that cannot be had, or a first robot that cannot drive or is out of the sliders' range.

    Example:
        >>> with PlayServer({"matched": Robot.load("matched")}, Path("node_modules")) as server:
        ...     server.address.startswith("http://127.0.0.1:")
        True
    """

    daemon_threads = True
    block_on_close = False
    allow_reuse_address = True
    request_queue_size = 64  # a page asks for all of its files at once

    def __init__(self, robots: Mapping[str, Robot], packages: Path, port: int = 0) -> None:
        self.robots = robots
        opening = [Setting.of(robot) for robot in robots.values()]
        plan(opening[0], robots).as_json()  # refuses a robot that cannot drive before anybody opens the page
        self.start = {
            "settings": [dataclasses.asdict(setting) for setting in opening],
            "maneuvers": list(MANEUVERS),
            "knobs": {name: dataclasses.asdict(knob) for name, knob in KNOBS.items()},
        }
        self.files = served(packages)
        self.compiling = threading.Lock()
        self.open: dict[socket.socket, float] = {}  # connections, and until when
        try:
            super().__init__((HOST, port), _Handler)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InvalidValue(f"port {port}: cannot be had ({reason}); --port 0 takes any that is free") from None

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{HOST}:{self.server_port}/"

    def server_bind(self) -> None:
        """Bind without asking for the machine's name, which may take long."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = HOST, self.socket.getsockname()[1]

    def process_request(self, request: Any, client_address: Any) -> None:
        """Note until when the connection may stay open."""
        self.open[request] = time.monotonic() + _SECONDS_OF_A_REQUEST
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Forget a connection that is closed."""
        self.open.pop(request, None)
        super().shutdown_request(request)

    def service_actions(self) -> None:
        """Close connections whose request comes a byte now and then and never ends."""
        now = time.monotonic()
        for request, until in list(self.open.items()):
            if now > until:
                with contextlib.suppress(OSError):
                    request.shutdown(socket.SHUT_RDWR)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a browser that has gone."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    """Answers GET, and nothing else."""

    server: PlayServer
    timeout = _SECONDS_OF_SILENCE
    server_version, sys_version = "diffdrive", ""

    def do_GET(self) -> None:
        port = self.server.server_port
        if self.headers.get("Host") not in (f"{HOST}:{port}", f"localhost:{port}"):
            # Another site's name that was made to lead here.
            return self._refuse(HTTPStatus.FORBIDDEN, "this page is served to this machine alone, as 127.0.0.1")
        if len(self.path) > _LONGEST_REQUEST:
            return self._refuse(HTTPStatus.REQUEST_URI_TOO_LONG, f"a request has at most {_LONGEST_REQUEST} characters")
        path, _, query = self.path.partition("?")
        if path in ("/api/start", "/api/drive"):
            if self.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
                return self._refuse(HTTPStatus.FORBIDDEN, "only the page itself may ask for drives")
            return self._answer(self._start if path == "/api/start" else self._drive, query)
        file = self.server.files.get(path)
        if file is None or not file.is_file():
            return self._refuse(HTTPStatus.NOT_FOUND, "there is no such file")
        return self._send(HTTPStatus.OK, content_type(file), file.read_bytes())

    def _answer(self, made: Any, query: str) -> None:
        try:
            answer = json.dumps(made(query), allow_nan=False)
        except DiffdriveError as error:
            return self._refuse(HTTPStatus.BAD_REQUEST, str(error))
        return self._send(HTTPStatus.OK, "application/json", answer.encode())

    def _start(self, _: str) -> dict[str, Any]:
        return self.server.start

    def _drive(self, query: str) -> dict[str, Any]:
        try:
            pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=True, errors="strict", max_num_fields=50)
        except ValueError:
            raise InvalidValue("the setting is not of the form name=value&name=value") from None
        given = dict(pairs)
        if len(given) != len(pairs):
            raise InvalidValue("the setting names something twice")
        with self.server.compiling:
            return plan(Setting.parsed(given), self.server.robots).as_json()

    def _refuse(self, status: HTTPStatus, why: str) -> None:
        self._send(status, "application/json", json.dumps({"error": why}).encode())

    def _send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        loose = urlsplit(self.path).path == _WORKER
        headers = {
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            "Cache-Control": "no-store",
            "Content-Security-Policy": _LOOSE if loose else _STRICT,
            "Cross-Origin-Resource-Policy": "same-origin",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
        }
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Refuse in one line what is not GET, or not HTTP; a request is never repeated in the answer."""
        self.close_connection = True
        code = HTTPStatus.METHOD_NOT_ALLOWED if code == HTTPStatus.NOT_IMPLEMENTED else code
        body = json.dumps({"error": "the page is read with GET, in plain HTTP"}).encode()
        self.send_response(code)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        if code == HTTPStatus.METHOD_NOT_ALLOWED:
            self.send_header("Allow", "GET")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
        """Say nothing."""


_STRICT = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_LOOSE = "default-src 'none'; script-src 'self' 'unsafe-eval' 'wasm-unsafe-eval'; connect-src 'self'"


def robots_by_name(first: Robot) -> dict[str, Robot]:
    """Return the robots that the page offers: one, then the presets.

    Args:
        first: a preset or any other.

    Example:
        >>> list(robots_by_name(Robot.load("ct_bot")))[:2]
        ['ct_bot', 'matched']
    """
    if checks.instance("robot", first, Robot).skids:
        raise InvalidValue(f"robot {first.name}: has skid steer, which the page of `diffdrive play` does not drive")
    return {first.name: first, **{name: Robot.load(name) for name in presets() if name != first.name}}
