"""The server of the page: who may ask, and for what.

It listens on the loopback alone. A request has to know a token, which is in the address; it has to call this machine
by its own name, so that no other name leads here; and what changes something has to come from our own page.
"""

from __future__ import annotations

import hmac
import json
import os
import secrets
import socket
import sys
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Callable, Mapping, cast
from urllib.parse import quote, unquote

from .. import programs
from . import settings
from .bodies import CHANGING, LARGEST, Body, all_bodies, version
from .runs import Refused

_PAGE = Path(__file__).parent / "page"
_TEXT = "text/plain; charset=utf-8"
_TYPES = {
    ".html": "text/html; charset=utf-8", ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8", ".png": "image/png", ".svg": "image/svg+xml", ".pdf": "application/pdf",
    **dict.fromkeys(".toml .geo .md .txt .json .jsonl .csv .log .ini .mk".split(), _TEXT), "": _TEXT,
}
_OURS = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
#: What a body's files may do: a page of theirs runs its scripts, but is not of our origin.
_THEIRS = "sandbox allow-scripts allow-downloads allow-popups; frame-ancestors 'self'"
#: A text that is edited has fewer bytes.
_LONGEST = 4_000_000


class Studio(ThreadingHTTPServer):
    """The server, on a port, or on one that is free for 0."""

    daemon_threads = True

    def __init__(self, port: int):
        super().__init__(("127.0.0.1", port), _Handler)
        self.token = secrets.token_urlsafe(24)
        # browsers leave the usual port out
        port_text = "" if self.server_port == 80 else f":{self.server_port}"
        self.hosts = [f"{name}{port_text}" for name in ("127.0.0.1", "localhost")]

    @property
    def address(self) -> str:
        """Of the page."""
        return f"http://{self.hosts[0]}/{self.token}/"

    def handle_error(self, request: object, client_address: object) -> None:
        """A browser that went away is no error."""
        error = sys.exc_info()[1]
        if not isinstance(error, (ConnectionError, TimeoutError)):
            print(f"puffer studio: {type(error).__name__}: {error}", file=sys.stderr)


class _Handler(BaseHTTPRequestHandler):
    server_version, sys_version = "puffer", ""
    timeout = 20

    @property
    def studio(self) -> Studio:
        """Whose requests these are."""
        return cast(Studio, self.server)

    def do_GET(self) -> None:
        self._answer(self._get)

    def do_POST(self) -> None:
        self._answer(self._post)

    def _answer(self, make: Callable[[list[str]], Any]) -> None:
        try:
            found = make(self._asked())
            if isinstance(found, Path):
                self._send_file(found)
            else:
                self._send(200, json.dumps(found).encode())
        except Refused as refused:
            self._send_message(refused.status, str(refused))
            self._linger()
        except programs.ProgramError as error:
            self._send_message(422, str(error))
        except ConnectionError:
            raise
        except OSError as error:
            self._send_message(500, f"{error.filename}: {error.strerror}" if error.filename else str(error))

    def _asked(self) -> list[str]:
        """The parts of the path after the token, of a request that may be answered."""
        host = self.headers.get("Host", "")
        if host not in self.studio.hosts:
            raise Refused(403, f"{host!a}: the studio is called {self.studio.hosts[0]}")
        token, _, path = unquote(self.path.partition("?")[0]).removeprefix("/").partition("/")
        if not hmac.compare_digest(token.encode(), self.studio.token.encode()):
            raise Refused(403, "this is not the address that puffer studio printed when it was started last")
        ours = self.headers.get("Origin") == f"http://{host}" and self.headers.get("X-Puffer") == "studio"
        if self.command == "POST" and not ours:
            raise Refused(403, "a change has to come from the page of the studio")
        return path.split("/")

    def _get(self, parts: list[str]) -> Any:
        match parts:
            case [""]:
                return _PAGE / "studio.html"
            case [("studio.js" | "studio.css") as name]:
                return _PAGE / name
            case ["silicones"]:
                return settings.silicones()
            case ["bodies"]:
                names = [{"name": body.name, "running": body.run.is_running()} for body in all_bodies()]
                return {"folder": os.getcwd(), "bodies": names, "largest": LARGEST}
            case ["bodies", name]:
                return Body(name).existing().state()
            case ["bodies", name, "files", *path]:
                return Body(name).existing().file("/".join(path))
            case ["bodies", _, *_]:
                raise Refused(405, "nothing is changed by looking: a change is posted by the page")
        raise Refused(404, "there is nothing to be seen under this address")

    def _post(self, parts: list[str]) -> Any:
        """Makes a change; answers with what the body is then."""
        content, seen = self._content(), self.headers.get("If-Match", "")
        if len(parts) < 3 or parts[0] != "bodies":
            raise Refused(405, "there is nothing to be changed under this address")
        body, what = Body(parts[1]), parts[2:]
        with CHANGING:
            match what:
                case ["new"]:
                    body.create()
                case ["new", kind]:
                    body.create_for(kind, content)
                case ["model", kind]:
                    body.existing().replace_model(kind, content)
                case ["save", file]:
                    body.existing().save(file, _text(content), seen)
                case ["set", file]:
                    body.existing().save(file, _changed(body.text(file), _text(content)), seen)
                case ["pick"]:
                    body.existing().pick(_text(content))
                case ["make"]:
                    body.existing().make()
                case ["stop"]:
                    body.existing().run.stop()
                case _:
                    raise Refused(405, "there is nothing to be changed under this address")
            return body.state()

    def _content(self) -> bytes:
        size = self.headers.get("Content-Length", "")
        if not size.isdecimal():
            raise Refused(411, "the request does not say how long it is")
        if int(size) > LARGEST:
            raise Refused(413, f"the file has {int(size) / 1e6:.0f} MB, and at most {LARGEST / 1e6:.0f} MB are taken: "
                               "copy a larger one into the folder, as model.step")
        content = self.rfile.read(int(size))
        if len(content) < int(size):
            raise Refused(400, f"only {len(content)} bytes of {size} came: send it again")
        return content

    def _send_message(self, status: int, text: str) -> None:
        self._send(status, json.dumps({"message": text}).encode())

    def _send_file(self, path: Path) -> None:
        """Sends a file; one of a kind that browsers do not show is kept by them."""
        own = path.parent == _PAGE
        with open(os.open(path, os.O_RDONLY | (0 if own else os.O_NOFOLLOW)), "rb") as file:
            content = file.read()
        more = {"Content-Type": _TYPES.get(path.suffix, "application/octet-stream"), "ETag": version(content)}
        if path.suffix not in _TYPES:
            more["Content-Disposition"] = f"attachment; filename*=UTF-8''{quote(path.name)}"
        if not own:
            more["Content-Security-Policy"] = _THEIRS
        self._send(200, content, more)

    def _send(self, status: int, content: bytes, more: Mapping[str, str] = {}) -> None:
        self.send_response(status)
        headers = {
            "Content-Type": "application/json", "Content-Length": str(len(content)), "Cache-Control": "no-store",
            "Content-Security-Policy": _OURS, "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "same-origin", **more,
        }
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def _linger(self) -> None:
        """Takes what still comes of a request that is refused, so that the browser gets to read why."""
        self.connection.shutdown(socket.SHUT_WR)
        self.connection.settimeout(2)
        while self.rfile.read(1 << 16):
            pass

    def log_message(self, format: str, *arguments: object) -> None:
        """Nothing: addresses have the token."""


def _text(content: bytes) -> str:
    if len(content) > _LONGEST:
        raise Refused(413, f"a text has at most {_LONGEST / 1e6:.0f} MB here")
    try:
        return content.decode()
    except UnicodeDecodeError:
        raise Refused(400, "the text is not UTF-8") from None


def _changed(text: str, request: str) -> str:
    """A text with the change that the page asks for: a value, a table less, or a chamber more."""
    try:
        match json.loads(request):
            case {"number": int(number), "key": str(key), "value": (str() | float() | int()) as value}:
                return settings.changed(text, number, key, value)
            case {"leave": int(number)} if number > 0:
                return settings.left_out(text, number)
            case {"chamber": str(tag), "pressure": (float() | int()) as pressure}:
                return settings.with_chamber(text, tag, pressure)
    except (ValueError, LookupError):
        pass
    raise Refused(400, "no such change is known")
