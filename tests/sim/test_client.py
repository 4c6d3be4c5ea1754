"""AI2-THOR's client without its web server and its private store."""

from __future__ import annotations

import subprocess
import sys


def run(code: str) -> str:
    """What a new process prints."""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def test_no_web_server_and_no_store_is_loaded() -> None:
    code = (
        "import sys; from ovman.sim.client import controller; print(controller().__module__);"
        "print(sorted({'flask', 'werkzeug', 'botocore', 'urllib3'} & {*sys.modules}))"
    )
    assert run(code).split("\n") == ["ai2thor.controller", "[]"]


def test_what_was_postponed_is_itself_when_it_is_used() -> None:
    code = (
        "from ovman.sim.client import controller; controller(); import ai2thor.controller as c;"
        "later = c.ai2thor.wsgi_server.WsgiServer; server = later(host='127.0.0.1', width=3, height=3);"
        "import ai2thor.wsgi_server; print(type(server) is ai2thor.wsgi_server.WsgiServer);"
        "print(c.ai2thor.build.requests.exceptions.Timeout.__module__);"
        "from aws_requests_auth.boto_utils import BotoAWSRequestsAuth; print(BotoAWSRequestsAuth.__mro__[-1] is object);"
        "print(type(c.ai2thor.build.BotoAWSRequestsAuth('h', 'r', 's')) is BotoAWSRequestsAuth)"
    )
    assert run(code).split("\n") == ["True", "requests.exceptions", "True", "True"]


def test_a_client_that_is_loaded_stays_as_it_is() -> None:
    code = (
        "import ai2thor.controller as c, ai2thor.wsgi_server as w; from ovman.sim.client import controller;"
        "print(controller() is c.Controller, c.ai2thor.wsgi_server is w)"
    )
    assert run(code) == "True True"
