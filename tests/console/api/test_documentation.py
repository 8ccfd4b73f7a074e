"""The description of the interface: every answer by a name, who may ask, and calls that can be copied."""

from __future__ import annotations

import re
import shlex
from typing import Any, get_args

import jsonschema_rs
import msgspec
import pytest

from console import messages
from console.api.documentation import ADDRESS, DescribedApp, add_schemas, markdown
from console.app import ROUTERS
from console.messages.json_schema import UNIONS, socket_schema
from tests.console.live import Live, hear


@pytest.fixture(scope="module")
def description() -> Any:
    app = DescribedApp(docs_url=None, redoc_url=None, openapi_url=None)
    for router in ROUTERS:
        app.router.routes.extend(router.routes)
    return app.openapi()


def operations(description: Any) -> list[tuple[str, Any]]:
    return [
        (f"{method} {path}", each)
        for path, methods in description["paths"].items()
        for method, each in methods.items()
    ]


def test_every_answer_has_a_name_and_every_name_a_form(description: Any) -> None:
    schemas, seen = description["components"]["schemas"], 0
    for call, operation in operations(description):
        for status, answer in operation["responses"].items():
            for content in answer.get("content", {}).values():
                shape = content["schema"]
                for part in shape.get("anyOf", [shape]):
                    assert part.get("$ref", "").rpartition("/")[2] in schemas, (call, status, shape)
                    seen += 1
    assert seen > 1000


def test_every_call_says_who_may_make_it(description: Any) -> None:
    schemes = description["components"]["securitySchemes"]
    assert set(schemes) == {"key", "login"}
    open_to_all = {call for call, each in operations(description) if not each["security"]}
    assert open_to_all == {"post /api/login", "get /api/health"}
    for _, each in operations(description):
        assert {name for one in each["security"] for name in one} in (set(), set(schemes))
        assert each["x-role"] in ("public", "viewer", "operator", "admin")


def test_two_forms_of_one_name_are_refused() -> None:
    schemas = {"Ring": {"type": "object"}}
    add_schemas(schemas, {"Ring": {"type": "object"}})
    with pytest.raises(RuntimeError, match="Ring"):
        add_schemas(schemas, {"Ring": {"type": "string"}})


def test_every_call_can_be_copied_into_a_shell(description: Any) -> None:
    found = re.findall(r"```sh\n(curl .*)\n```", markdown(description))
    assert len(found) == len(operations(description)) + 1
    for line in found:
        words = shlex.split(line)
        assert words[0] == "curl" and any(word.startswith(ADDRESS + "/api/") for word in words)
        if "-d" in words:
            assert isinstance(msgspec.json.decode(words[words.index("-d") + 1]), dict)


def test_the_reader_finds_the_address_by_which_he_came(live: Live) -> None:
    for host in (f"127.0.0.1:{live.port}", f"localhost:{live.port}"):
        page = live.ask("GET", "/docs", token=live.viewer, host=host).body.decode()
        assert f"http://{host}/api/commands" in page and ADDRESS not in page
        described = live.ask("GET", "/openapi.json", token=live.viewer, host=host).json
        assert described["servers"] == [{"url": f"http://{host}"}]
        assert described["components"]["securitySchemes"]["login"]["name"] == live.cookie_name


def test_the_messages_of_the_socket_keep_to_their_schema(live: Live) -> None:
    served = live.ask("GET", "/api/socket.json", token=live.viewer)
    assert served.status == 200 and served.json == socket_schema()
    down = jsonschema_rs.validator_for({**served.json, "anyOf": [{"$ref": "#/$defs/Down"}]})
    up = jsonschema_rs.validator_for({**served.json, "anyOf": [{"$ref": "#/$defs/Up"}]})
    with live.open() as line:
        for kind in ("hello", "state"):
            down.validate(hear(line, kind))
    assert not down.is_valid({"kind": "hello"}) and not up.is_valid({"kind": "stop", "press": -1})
    up.validate({"kind": "stop", "press": 7})
    named = {kind.__name__ for union, _ in UNIONS.values() for kind in get_args(union)}
    assert {kind.__name__ for kind in get_args(messages.Up)} <= named <= set(served.json["$defs"])
