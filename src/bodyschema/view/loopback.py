"""One page on this machine alone: a server that nobody else can reach, and that changes nothing."""

from __future__ import annotations

from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from bodyschema.errors import InputError

HOST = "127.0.0.1"


def serve(page: str, port: int = 0) -> ThreadingHTTPServer:
    """A server of one page, bound but not yet running.

    Only requests that name this machine are answered, and none that another site's page makes: a
    name that leads here (DNS rebinding) reads nothing.

    Args:
        page: the HTML.
        port: 0 for any that is free.

    Returns:
        The server; `address` says where it is, `serve_forever` runs it.

    Raises:
        InputError: the port is taken or not allowed.
    """
    content = page.encode()

    class OnePage(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            port = self.connection.getsockname()[1]
            known = {f"{name}:{port}" for name in (HOST, "localhost")}
            origin = self.headers.get("Origin")
            if self.headers.get("Host") not in known or (
                origin is not None and origin.removeprefix("http://") not in known
            ):
                self.send_error(403)
            elif self.path != "/":
                self.send_error(404)
            else:
                self.send_response(200)
                self.send_header("Content-Type", "text/html; charset=utf-8")
                self.send_header("Content-Length", str(len(content)))
                self.send_header("Cache-Control", "no-store")
                self.send_header("Cross-Origin-Resource-Policy", "same-origin")
                self.end_headers()
                self.wfile.write(content)

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing: the terminal shows the address alone."""

    try:
        return ThreadingHTTPServer((HOST, port), OnePage)
    except (OSError, OverflowError) as error:
        raise InputError(
            f"port {port} cannot be used ({error}); leave --port out to take any that is free."
        ) from None


def address(server: ThreadingHTTPServer) -> str:
    """The address of its page."""
    return f"http://{HOST}:{server.server_address[1]}/"
