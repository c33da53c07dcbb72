"""Who may come in, decided at the handshake (docs/adr/0008-the-pit-wall.md); wraps the server that viser starts."""

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
from firstlap.pitwall.replay import skip_what_is_gone

VIEWERS = 16
"""At the same time."""
WATCHERS = 12
"""Of them at most: the others are for those who control, of whom one that finds no place takes a watcher's."""
OPENING = 60.0
"""[s] for which the address that opens the browser of this machine lets one page in."""
SHORTEST_TOKEN, LONGEST_TOKEN = 8, 200
NO_TOKEN = "a right token is needed: ask whoever started this page for its address"

Process = Callable[[ServerConnection, Request], "Response | None"]
Handler = Callable[[ServerConnection], Awaitable[None]]

_role: ContextVar[Role] = ContextVar("role")
_starting = threading.Lock()
"""While viser starts, a function of websockets is replaced."""


class Authenticator:
    """Listens where it is told and nowhere else, and lets viser serve behind it.

    token: of those who may control; without one everybody on this machine may, and for another address one is made up.
    Raises InputError.
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
        """The server, once. host: a name or address of this machine. port: 0 for any free one. Raises InputError."""
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
        skip_what_is_gone(server)
        self._ready.set()
        return server

    def _start(self, listener: socket.socket) -> viser.ViserServer:
        before = websockets.asyncio.server.serve

        def serve(handler: Handler, _host: str, _port: int, *, process_request: Process, **options: Any) -> Any:
            asyncio.get_running_loop().set_exception_handler(_say_what_failed)
            options.update(max_size=MESSAGE_SIZE, max_queue=QUEUE, open_timeout=5.0, logger=Quiet())
            return before(
                self._guard(handler),
                sock=listener,
                process_request=self._ask(process_request),
                create_connection=GuardedConnection,
                **options,
            )

        with _starting, quietly():
            websockets.asyncio.server.serve = serve  # type: ignore[assignment, misc]
            try:
                return viser.ViserServer(host=self.host, port=self.port, verbose=False)
            finally:
                websockets.asyncio.server.serve = before  # type: ignore[misc]

    def _attach(self, server: viser.ViserServer) -> None:
        # Before the first viewer is let in, and so before all other callbacks.

        @server.on_client_connect
        async def _(client: viser.ClientHandle) -> None:
            self._roles[client.client_id] = _role.get(Role.WATCH)

        @server.on_client_disconnect
        async def _(client: viser.ClientHandle) -> None:
            self._roles.pop(client.client_id, None)

    def role(self, client_id: int) -> Role:
        """What this viewer may do; an unknown one may watch."""
        return self._roles.get(client_id, Role.WATCH)

    def may_control(self, client: viser.ClientHandle) -> bool:
        """Whether that viewer may do more than watch."""
        return self.role(client.client_id) is Role.CONTROL

    @property
    def url(self) -> str:
        """The address to control from."""
        return self._url(Role.CONTROL)

    def opening_url(self) -> str:
        """The address to hand to a browser of this machine, once: every user sees it in the list of processes.

        Its key lets one page in, which gets a cookie and an address without a token.
        """
        if not self._tokens:
            return self.url
        self._key, self._key_until = secrets.token_urlsafe(18), time.monotonic() + OPENING
        return f"http://{_shown(self.host)}:{self.port}/?key={self._key}"

    def _spend_key(self, request: Request) -> bool:
        """Whether the request has the key of `opening_url`, which is then spent."""
        given = parse_qs(urlsplit(request.path).query).get("key", [""])[-1]
        key, in_time = self._key, time.monotonic() < self._key_until
        if not (key and in_time and hmac.compare_digest(given.encode("utf-8", "replace"), key.encode())):
            return False
        self._key = ""
        return True

    @property
    def watch_url(self) -> str | None:
        """The address to watch from; None where everybody who gets in may control."""
        return self._url(Role.WATCH) if self._tokens else None

    @property
    def warning(self) -> str | None:
        """What to say before anyone from another machine gets in."""
        if self.loopback:
            return None
        return (
            f"listens on {self.host}: whoever has the first address can drive the car, whoever has the second can "
            "watch it; nothing is encrypted, so use it in a network that you trust"
        )

    def _url(self, role: Role) -> str:
        page = f"http://{_shown(self.host)}:{self.port}/"
        return f"{page}?token={quote(self._tokens[role], safe='')}" if self._tokens else page

    def _guard(self, handler: Handler) -> Handler:
        async def guarded(connection: ServerConnection) -> None:
            role = connection.role if isinstance(connection, GuardedConnection) else Role.WATCH
            if not self._has_place(role):
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
                _say(error)
                await connection.close(1003, "not understood")
            finally:
                self._live.pop(connection, None)

        return guarded

    def _has_place(self, role: Role) -> bool:
        watchers = sum(one is Role.WATCH for one in self._live.values())
        if role is Role.WATCH:
            return watchers < WATCHERS and len(self._live) < VIEWERS
        return watchers > 0 or len(self._live) < VIEWERS

    def _evict(self) -> None:
        """The watcher who came last makes place for one who controls."""
        last = next(one for one in reversed(self._live) if self._live[one] is Role.WATCH)
        del self._live[last]
        leaving = asyncio.ensure_future(last.close(1013, "its place was needed by one who controls"))
        self._leaving.add(leaving)
        leaving.add_done_callback(self._leaving.discard)

    def _ask(self, process: Process) -> Process:
        def asked(connection: ServerConnection, request: Request) -> Response | None:
            role, refusal = self._judge(request)
            response: Response | None
            if role is None and refusal == NO_TOKEN and self._spend_key(request):
                role = Role.CONTROL
                response = connection.respond(http.HTTPStatus.SEE_OTHER, "")
                response.headers["Location"] = "/"
            elif role is None:
                response = connection.respond(http.HTTPStatus.FORBIDDEN, refusal + "\n")
            elif "Upgrade" in request.headers and not self._has_place(role):
                response = connection.respond(http.HTTPStatus.SERVICE_UNAVAILABLE, "too many viewers\n")
            else:
                assert isinstance(connection, GuardedConnection)
                connection.role = role
                response = process(connection, request)
            if response is not None:
                self._dress(response, role)
            return response

        return asked

    def _dress(self, response: Response, role: Role | None) -> None:
        if role is not None and self._tokens:
            cookie = f"{self._cookie_name}={self._cookies[role]}"
            response.headers["Set-Cookie"] = f"{cookie}; Path=/; HttpOnly; SameSite=Strict"
        response.headers["Cache-Control"] = "no-store"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["X-Content-Type-Options"] = "nosniff"
        # A page of someone else's that shows ours in a frame could have its visitors press our buttons.
        response.headers["X-Frame-Options"] = "DENY"
        response.headers["Content-Security-Policy"] = "frame-ancestors 'none'"

    @property
    def _cookie_name(self) -> str:
        # Cookies are shared by all ports of a host.
        return f"firstlap_{self.port}"

    def _judge(self, request: Request) -> tuple[Role | None, str]:
        """The role, or None and why."""
        host = _only(request, "Host").lower()
        # A name that someone else's DNS points at this machine is not this server.
        if self.loopback and not self._is_ours(host):
            return None, f"this page is at {self._url(Role.CONTROL).partition('?')[0]}"
        if not host:
            return None, "a request without the name of its host"
        if "Upgrade" in request.headers and urlsplit(_only(request, "Origin").lower()).netloc != host:
            return None, "another page may not connect"
        if not self._tokens:
            return Role.CONTROL, ""
        role = self._known(request)
        return role, NO_TOKEN

    def _is_ours(self, host: str) -> bool:
        name, colon, port = host.rpartition(":")
        if not colon or host.endswith("]"):
            name, port = host, "80"
        # A name of this machine that was asked for, such as its hostname, is in nobody else's hands.
        known = name in ("localhost", self.host.lower())
        return port == str(self.port) and (known or is_loopback(name.strip("[]")))

    def _known(self, request: Request) -> Role | None:
        query = parse_qs(urlsplit(request.path).query, keep_blank_values=True)
        if "token" in query:
            return _which(query["token"][-1], self._tokens)
        found = None
        for part in ";".join(request.headers.get_all("Cookie")).split(";"):
            name, _, value = part.strip().partition("=")
            if name == self._cookie_name:
                found = _which(value, self._cookies) or found
        return found


def is_loopback(address: str) -> bool:
    """Whether an address reaches this machine only."""
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False


@contextlib.contextmanager
def quietly() -> Any:
    """viser greets and takes its leave on standard output; what is said there is the command's."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def _listen(host: str, port: int) -> tuple[socket.socket, bool]:
    """The socket, and whether only this machine reaches it. Raises InputError."""
    if not 0 <= port <= 65535:
        raise InputError(f"--port: {port} is outside of 0 to 65535")
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = sorted(found, key=lambda entry: entry[0])[0]
        listener = socket.create_server(address[:2], family=family)
    except (socket.gaierror, UnicodeError):
        raise InputError(f"--host: '{host[:60]}' is no name or address of this machine") from None
    except OverflowError as error:
        raise InputError(f"--port: {error}") from None
    except OSError as error:
        what = "is taken by another program; another one with --port, or --port 0 for any that is free"
        if error.errno != errno.EADDRINUSE:
            what = f"cannot be listened on at {host[:60]}: {error.strerror or error}"
        raise InputError(f"port {port} {what}") from None
    listener.setblocking(False)
    return listener, is_loopback(str(address[0]))


def _shown(host: str) -> str:
    """The host for an address that others can open."""
    if host in ("0.0.0.0", "", "*", "::"):
        return _own_address()
    return f"[{host}]" if ":" in host else host


def _own_address() -> str:
    """Of this machine in its network, as far as it has one. Sends nothing: a UDP socket is only pointed there."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, contextlib.suppress(OSError):
        probe.connect(("192.0.2.1", 9))
        return str(probe.getsockname()[0])
    return socket.gethostname()


def _only(request: Request, name: str) -> str:
    values = request.headers.get_all(name)
    return values[0] if len(values) == 1 else ""


def _which(text: str, secret: dict[Role, str]) -> Role | None:
    """In a time that does not tell how much of it was right."""
    found = None
    for role, expected in secret.items():
        if hmac.compare_digest(text.encode("utf-8", "replace"), expected.encode()):
            found = role
    return found


def _say_what_failed(_loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    error = context.get("exception")
    _say(error if error is not None else RuntimeError(context.get("message", "")))


class Complaints:
    """On stderr: a viewer who sends nonsense shall not fill it. The same again counts only after AGAIN [s]."""

    AGAIN = 10.0
    KEPT = 50

    def __init__(self) -> None:
        self._said: dict[str, float] = {}

    def say(self, error: BaseException) -> None:
        """In one line. Where many are said already, only that there are more."""
        now = time.monotonic()
        self._said = {line: at for line, at in self._said.items() if now - at < self.AGAIN}
        line = f"view: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        if len(self._said) >= self.KEPT:
            line = "view: and more of that"
        if line not in self._said:
            print(line, file=sys.stderr)
        self._said.setdefault(line, now)


_say = Complaints().say
