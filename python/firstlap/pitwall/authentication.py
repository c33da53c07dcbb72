"""Access control at the WebSocket handshake (docs/adr/0008-the-pit-wall.md); wraps the server that viser starts."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import hmac
import http
import io
import ipaddress
import secrets
import socket
import sys
import threading
import time
from collections.abc import Awaitable, Callable
from contextvars import ContextVar
from typing import Any
from urllib.parse import parse_qs, quote, urlsplit

import viser
import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from firstlap.common.errors import InputError
from firstlap.pitwall.guarded_connection import MESSAGE_SIZE, QUEUE, ConnectionClosed, GuardedConnection, Quiet, Role
from firstlap.pitwall.replay import skip_obsolete_messages

VIEWERS = 16
"""Maximum number of simultaneous viewers."""
WATCHERS = 12
"""Maximum number of read-only viewers. The rest is reserved for viewers who control; they displace read-only ones."""
KEY_LIFETIME = 60.0
"""[s] Lifetime of the one-time key in the address that opens the local browser."""
SHORTEST_TOKEN, LONGEST_TOKEN = 8, 200
NO_TOKEN = "a valid token is required: ask the person who started this page for its address"

Process = Callable[[ServerConnection, Request], "Response | None"]
Handler = Callable[[ServerConnection], Awaitable[None]]

_role: ContextVar[Role] = ContextVar("role")
_starting = threading.Lock()
"""Held while a function of websockets is replaced for viser's startup."""


class Authenticator:
    """Listens on one address and lets viser serve behind it.

    token: grants control. Without one, all users of this machine have control, and a token is generated for any other
    address. Raises InputError.
    """

    def __init__(self, token: str | None = None) -> None:
        if token is not None and not (SHORTEST_TOKEN <= len(token) <= LONGEST_TOKEN and token.isprintable()):
            raise InputError(f"the token: expected {SHORTEST_TOKEN} to {LONGEST_TOKEN} printable characters")
        self.host = ""
        self.port = 0
        self.loopback = False
        self._given = token
        self._tokens: dict[Role, str] = {}
        self._cookies = {role: secrets.token_urlsafe(24) for role in Role}
        self._roles: dict[int, Role] = {}
        self._ready = threading.Event()
        self._live: dict[ServerConnection, Role] = {}
        self._leaving: set[asyncio.Task[None]] = set()
        self._key, self._key_until = "", 0.0

    def open(self, host: str = "127.0.0.1", port: int = 8080) -> viser.ViserServer:
        """Starts the server; call it once. host: a name or address of this machine. port: 0 for any free one.

        Raises InputError."""
        listener, self.loopback = _listen(host, port)
        self.host, self.port = host, int(listener.getsockname()[1])
        if self._given is not None or not self.loopback:
            control = self._given if self._given is not None else secrets.token_urlsafe(12)
            self._tokens = {Role.CONTROL: control, Role.WATCH: secrets.token_urlsafe(12)}
        try:
            server = self._start(listener)
        except BaseException:
            listener.close()
            raise
        self._attach(server)
        skip_obsolete_messages(server)
        self._ready.set()
        return server

    def _start(self, listener: socket.socket) -> viser.ViserServer:
        before = websockets.asyncio.server.serve

        def serve(handler: Handler, _host: str, _port: int, *, process_request: Process, **options: Any) -> Any:
            asyncio.get_running_loop().set_exception_handler(_report_exception)
            options.update(max_size=MESSAGE_SIZE, max_queue=QUEUE, open_timeout=5.0, logger=Quiet())
            return before(
                self._guard(handler),
                sock=listener,
                process_request=self._admit(process_request),
                create_connection=GuardedConnection,
                **options,
            )

        with _starting, silenced():
            websockets.asyncio.server.serve = serve  # type: ignore[assignment, misc]
            try:
                return viser.ViserServer(host=self.host, port=self.port, verbose=False)
            finally:
                websockets.asyncio.server.serve = before  # type: ignore[misc]

    def _attach(self, server: viser.ViserServer) -> None:
        # Registered before the first viewer is admitted, and so before all other callbacks.

        @server.on_client_connect
        async def _(client: viser.ClientHandle) -> None:
            self._roles[client.client_id] = _role.get(Role.WATCH)

        @server.on_client_disconnect
        async def _(client: viser.ClientHandle) -> None:
            self._roles.pop(client.client_id, None)

    def role(self, client_id: int) -> Role:
        """The viewer's role; an unknown viewer may only watch."""
        return self._roles.get(client_id, Role.WATCH)

    def may_control(self, client: viser.ClientHandle) -> bool:
        """Whether the viewer has control."""
        return self.role(client.client_id) is Role.CONTROL

    @property
    def url(self) -> str:
        """The address that grants control."""
        return self._url(Role.CONTROL)

    def opening_url(self) -> str:
        """The address for the local browser, valid once: every user of the machine can see it in the process list.

        Its key admits one page, which then has a cookie and an address without a token.
        """
        if not self._tokens:
            return self.url
        self._key, self._key_until = secrets.token_urlsafe(18), time.monotonic() + KEY_LIFETIME
        return f"http://{_public_host(self.host)}:{self.port}/?key={self._key}"

    def _spend_key(self, request: Request) -> bool:
        """Whether the request has the key of `opening_url`; the key is then used up."""
        given = parse_qs(urlsplit(request.path).query).get("key", [""])[-1]
        key, in_time = self._key, time.monotonic() < self._key_until
        if not (key and in_time and hmac.compare_digest(given.encode("utf-8", "replace"), key.encode())):
            return False
        self._key = ""
        return True

    @property
    def watch_url(self) -> str | None:
        """The read-only address; None if everybody with access has control."""
        return self._url(Role.WATCH) if self._tokens else None

    @property
    def warning(self) -> str | None:
        """A warning to print if other machines can connect."""
        if self.loopback:
            return None
        return (
            f"listening on {self.host}: anyone with the first address can drive the car, anyone with the second can "
            "watch it; the connection is not encrypted, so use it only in a trusted network"
        )

    def _url(self, role: Role) -> str:
        page = f"http://{_public_host(self.host)}:{self.port}/"
        return f"{page}?token={quote(self._tokens[role], safe='')}" if self._tokens else page

    def _guard(self, handler: Handler) -> Handler:
        async def guarded(connection: ServerConnection) -> None:
            role = connection.role if isinstance(connection, GuardedConnection) else Role.WATCH
            if not self._has_slot(role):
                await connection.close(1013, "too many viewers")
                return
            if len(self._live) >= VIEWERS:
                self._evict()
            self._live[connection] = role
            _role.set(role)
            try:
                while not self._ready.is_set():
                    await asyncio.sleep(0.01)
                await handler(connection)
            except ConnectionClosed:
                pass
            except Exception as error:
                _report(error)
                await connection.close(1003, "invalid message")
            finally:
                self._live.pop(connection, None)

        return guarded

    def _has_slot(self, role: Role) -> bool:
        watchers = sum(one is Role.WATCH for one in self._live.values())
        if role is Role.WATCH:
            return watchers < WATCHERS and len(self._live) < VIEWERS
        return watchers > 0 or len(self._live) < VIEWERS

    def _evict(self) -> None:
        """Disconnects the newest read-only viewer for one with control."""
        last = next(one for one in reversed(self._live) if self._live[one] is Role.WATCH)
        del self._live[last]
        leaving = asyncio.ensure_future(last.close(1013, "displaced by a viewer with control"))
        self._leaving.add(leaving)
        leaving.add_done_callback(self._leaving.discard)

    def _admit(self, process: Process) -> Process:
        def admit(connection: ServerConnection, request: Request) -> Response | None:
            role, refusal = self._check_request(request)
            response: Response | None
            if role is None and refusal == NO_TOKEN and self._spend_key(request):
                role = Role.CONTROL
                response = connection.respond(http.HTTPStatus.SEE_OTHER, "")
                response.headers["Location"] = "/"
            elif role is None:
                response = connection.respond(http.HTTPStatus.FORBIDDEN, refusal + "\n")
            elif "Upgrade" in request.headers and not self._has_slot(role):
                response = connection.respond(http.HTTPStatus.SERVICE_UNAVAILABLE, "too many viewers\n")
            else:
                assert isinstance(connection, GuardedConnection)
                connection.role = role
                response = process(connection, request)
            if response is not None:
                self._set_headers(response, role)
            return response

        return admit

    def _set_headers(self, response: Response, role: Role | None) -> None:
        if role is not None and self._tokens:
            cookie = f"{self._cookie_name}={self._cookies[role]}"
            response.headers["Set-Cookie"] = f"{cookie}; Path=/; HttpOnly; SameSite=Strict"
        response.headers["Cache-Control"] = "no-store"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["X-Content-Type-Options"] = "nosniff"
        # Prevents clickjacking: another site must not show this page in a frame.
        response.headers["X-Frame-Options"] = "DENY"
        response.headers["Content-Security-Policy"] = "frame-ancestors 'none'"

    @property
    def _cookie_name(self) -> str:
        # The port is in the name because all ports of a host share cookies.
        return f"firstlap_{self.port}"

    def _check_request(self, request: Request) -> tuple[Role | None, str]:
        """The role; or None and the reason for the refusal."""
        host = _single_header(request, "Host").lower()
        # Prevents DNS rebinding: a foreign name that resolves to this machine is not accepted.
        if self.loopback and not self._is_ours(host):
            return None, f"this page is at {self._url(Role.CONTROL).partition('?')[0]}"
        if not host:
            return None, "the request has no Host header"
        if "Upgrade" in request.headers and urlsplit(_single_header(request, "Origin").lower()).netloc != host:
            return None, "cross-origin connections are not allowed"
        if not self._tokens:
            return Role.CONTROL, ""
        role = self._role_of(request)
        return role, NO_TOKEN

    def _is_ours(self, host: str) -> bool:
        name, colon, port = host.rpartition(":")
        if not colon or host.endswith("]"):
            name, port = host, "80"
        # The name given with --host, such as the hostname, is trusted.
        known = name in ("localhost", self.host.lower())
        return port == str(self.port) and (known or is_loopback(name.strip("[]")))

    def _role_of(self, request: Request) -> Role | None:
        query = parse_qs(urlsplit(request.path).query, keep_blank_values=True)
        if "token" in query:
            return _match_secret(query["token"][-1], self._tokens)
        found = None
        for part in ";".join(request.headers.get_all("Cookie")).split(";"):
            name, _, value = part.strip().partition("=")
            if name == self._cookie_name:
                found = _match_secret(value, self._cookies) or found
        return found


def is_loopback(address: str) -> bool:
    """Whether an address reaches this machine only."""
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False


@contextlib.contextmanager
def silenced() -> Any:
    """Suppresses viser's messages on standard output, which belongs to the command."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def _listen(host: str, port: int) -> tuple[socket.socket, bool]:
    """The socket, and whether it is reachable from this machine only. Raises InputError."""
    if not 0 <= port <= 65535:
        raise InputError(f"--port: {port} is outside of 0 to 65535")
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = sorted(found, key=lambda entry: entry[0])[0]
        listener = socket.create_server(address[:2], family=family)
    except (socket.gaierror, UnicodeError):
        raise InputError(f"--host: '{host[:60]}' is not a name or address of this machine") from None
    except OverflowError as error:
        raise InputError(f"--port: {error}") from None
    except OSError as error:
        what = "is in use by another program; choose another one with --port, or --port 0 for any free port"
        if error.errno != errno.EADDRINUSE:
            what = f"is not available at {host[:60]}: {error.strerror or error}"
        raise InputError(f"port {port} {what}") from None
    listener.setblocking(False)
    return listener, is_loopback(str(address[0]))


def _public_host(host: str) -> str:
    """The host in the form that others can open."""
    if host in ("0.0.0.0", "", "*", "::"):
        return _own_address()
    return f"[{host}]" if ":" in host else host


def _own_address() -> str:
    """The address of this machine in its network, or its hostname. Sends nothing: connecting a UDP socket only selects
    a route."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, contextlib.suppress(OSError):
        probe.connect(("192.0.2.1", 9))
        return str(probe.getsockname()[0])
    return socket.gethostname()


def _single_header(request: Request, name: str) -> str:
    values = request.headers.get_all(name)
    return values[0] if len(values) == 1 else ""


def _match_secret(text: str, secret: dict[Role, str]) -> Role | None:
    """The role with this secret. Compares in constant time."""
    found = None
    for role, expected in secret.items():
        if hmac.compare_digest(text.encode("utf-8", "replace"), expected.encode()):
            found = role
    return found


def _report_exception(_loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    error = context.get("exception")
    _report(error if error is not None else RuntimeError(context.get("message", "")))


class ErrorLog:
    """Prints errors on stderr, rate-limited: the same line at most every AGAIN [s], so that a faulty viewer cannot fill
    it."""

    AGAIN = 10.0
    KEPT = 50

    def __init__(self) -> None:
        self._reported: dict[str, float] = {}

    def report(self, error: BaseException) -> None:
        """Prints the error in one line; after many different ones, only that there are more."""
        now = time.monotonic()
        self._reported = {line: at for line, at in self._reported.items() if now - at < self.AGAIN}
        line = f"view: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        if len(self._reported) >= self.KEPT:
            line = "view: further errors are not shown"
        if line not in self._reported:
            print(line, file=sys.stderr)
        self._reported.setdefault(line, now)


_report = ErrorLog().report
