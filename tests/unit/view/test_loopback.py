"""The page on this machine: nobody else gets it."""

from __future__ import annotations

import http.client
import threading
from collections.abc import Iterator
from http.server import ThreadingHTTPServer

import pytest

from bodyschema.errors import InputError
from bodyschema.view.loopback import HOST, address, serve


@pytest.fixture
def server() -> Iterator[ThreadingHTTPServer]:
    with serve("<p>ä</p>") as made:
        thread = threading.Thread(target=made.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield made
        made.shutdown()
        thread.join()


def asked(server: ThreadingHTTPServer, path: str = "/", **headers: str) -> tuple[int, str]:
    """Status and text of an answer."""
    connection = http.client.HTTPConnection(HOST, server.server_port, timeout=5)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, text


def test_the_address_is_real_and_of_this_machine(server: ThreadingHTTPServer) -> None:
    assert server.server_address[0] == "127.0.0.1"
    assert address(server) == f"http://127.0.0.1:{server.server_port}/"
    assert asked(server) == (200, "<p>ä</p>")
    assert asked(server, "/else")[0] == 404


def test_others_are_refused(server: ThreadingHTTPServer) -> None:
    """A name that leads here, and a page of another site."""
    port = server.server_port
    assert asked(server, Host=f"evil.example:{port}")[0] == 403
    assert asked(server, Origin="http://evil.example")[0] == 403
    assert asked(server, Origin="null")[0] == 403
    assert asked(server, Origin=f"http://localhost:{port}", Host=f"localhost:{port}")[0] == 200


def test_a_taken_port_is_said(server: ThreadingHTTPServer) -> None:
    with pytest.raises(InputError, match=r"port \d+ cannot be used"):
        serve("", server.server_port)
    with pytest.raises(InputError, match="port 99999 cannot be used"):
        serve("", 99999)
